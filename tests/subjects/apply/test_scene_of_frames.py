"""The scene at one instant: films of a moving scene by each kind of camera against the scene itself, and hand-computed cases."""

import numpy as np
import pytest
from moving_scene import EDGE_COLUMNS, HIGH, LOW, ROWS, FilmedBy, film

from irtiming.apply.frames import Readout, SceneStream, scenes
from irtiming.apply.inverse_lag import Response, of_two_constants, responses, step
from irtiming.apply.noise import noise_of
from irtiming.errors import EstimationError
from irtiming.physics.response.two_constants import TwoConstants

ROLLING_PHOTON = FilmedBy(row_delay_s=7e-4, window_s=2e-3)
ROLLING_BOLOMETER = FilmedBy(row_delay_s=-7e-4, tau_s=5e-3)
SNAPSHOT_LAG = FilmedBy(tau_s=7e-3)
FILTERED = FilmedBy(tau_s=5e-3, share=0.3)


def _readout(camera):
    return Readout(
        response=Response(time_constant_s=camera.tau_s, recursive_filter=camera.share), row_delay_s=camera.row_delay_s
    )


def _instants_s(filmed):
    """When the middle row of each frame was read, or the middle of its integration."""
    camera = filmed.camera
    return filmed.trigger_s + camera.delay_s + camera.window_s / 2 + camera.row_delay_s * (ROWS - 1) / 2


def _errors(filmed, frames, times_s):
    """Rms error of the edge's position in px and of the even field, against the scene at those times."""
    edge = ((frames[:, :, :EDGE_COLUMNS] - LOW) / (HIGH - LOW)).sum(axis=2)
    field = frames[:, :, EDGE_COLUMNS:]
    return (
        np.sqrt(np.mean((edge - filmed.edge_px(times_s)[:, None]) ** 2)),
        np.sqrt(np.mean((field - filmed.warmth(times_s)[:, None, None]) ** 2)),
    )


def _before_and_after(filmed, noise):
    found = [
        (one.index, one.time_s, one.pixels.copy())
        for one in scenes(filmed.frames, _instants_s(filmed), readout=_readout(filmed.camera), noise=noise)
    ]
    index, times = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    late = slice(5, None)  # what was before the first frame nobody knows
    after = _errors(filmed, np.array([one[2] for one in found])[late], times[late])
    return _errors(filmed, filmed.frames[index][late], times[late]), after


@pytest.mark.parametrize(
    ("camera", "times"),
    [(ROLLING_PHOTON, 10), (ROLLING_BOLOMETER, 10), (SNAPSHOT_LAG, 5), (FILTERED, 5)],
    ids=["rolling-photon", "rolling-bolometer", "snapshot-lag", "filter"],
)
def test_errors_of_edge_and_temperature_fall(camera, times):
    """Oracle: the scene that was filmed, in steps of 0.1 ms; SNR 1000 of the edge."""
    filmed = film(camera, noise=0.9)
    before, after = _before_and_after(filmed, 0.9)
    assert after[0] < before[0] / times
    assert after[1] < before[1] / times


def test_a_snapshot_photon_camera_is_left_as_it_is():
    """Oracle: the frames; nothing is to be undone."""
    filmed = film(FilmedBy(window_s=2e-3), n_frames=6)
    found = [one.pixels.copy() for one in scenes(filmed.frames, _instants_s(filmed), readout=_readout(filmed.camera))]
    assert np.allclose(found, filmed.frames[1:], rtol=1e-6)


def test_a_ramp_is_found_exactly():
    """Oracle: a pixel that lags a ramp stands behind it by slope times tau; after the inversion it is the ramp."""
    tau_s, interval_s, slope = 8e-3, 0.02, 1000.0
    times = interval_s * np.arange(30)
    late = 2e-4 * np.arange(16)
    ramp = slope * (times[:, None] + late - tau_s)
    frames = np.repeat(ramp[:, :, None], 24, axis=2)
    readout = Readout(response=Response(time_constant_s=tau_s), row_delay_s=2e-4, instant_row=0.0)
    found = {one.index: one.pixels.copy() for one in scenes(frames, times, readout=readout, noise=0.0)}
    assert list(found) == list(range(1, 29))
    for index in range(20, 29):
        assert np.allclose(found[index], slope * times[index], atol=1e-3)


def test_noise_of_a_scene_at_rest_never_rises_and_is_what_is_stated():
    """Oracle: the scatter of the pixels themselves, frames of pure noise."""
    frames = 5000 + 10 * np.random.default_rng(3).normal(size=(60, 48, 64))
    readout = Readout(response=Response(time_constant_s=12e-3), row_delay_s=4e-4)
    found = [(one.pixels.std(), np.sqrt(np.mean(one.noise_gain**2)), one.gain.max()) for one in
             scenes(frames, 0.03 * np.arange(60), readout=readout, noise=10.0)]  # fmt: skip
    scatter, stated, gain = np.array(found).T
    assert np.sqrt(np.mean(scatter**2)) <= 10.05
    assert np.sqrt(np.mean(scatter**2)) / 10 == pytest.approx(np.sqrt(np.mean(stated**2)), rel=0.02)
    assert gain.mean() < 0.15


def test_the_noise_of_what_is_inverted_wholly_is_what_is_stated():
    """Oracle: the scatter of noise frames that are told to be without noise, so that the gain is 1."""
    frames = np.random.default_rng(4).normal(size=(200, 40, 40))
    readout = Readout(response=Response(time_constant_s=12e-3), row_delay_s=4e-4)
    found = [
        (one.pixels[8:16].std(), one.noise_gain[1, 0], one.gain.min())
        for one in scenes(frames, 0.03 * np.arange(200), readout=readout, noise=0.0)
    ]
    scatter, stated, gain = np.array(found)[10:].T
    assert gain.min() == 1
    assert np.sqrt(np.mean(scatter**2)) == pytest.approx(stated[0], rel=0.03)
    assert stated[0] > 1.1


@pytest.mark.parametrize("tau_s", [0.0, 1e-3, 5e-3, 2e-2, 0.1])
@pytest.mark.parametrize("share", [0.0, 0.4])
def test_responses_are_those_of_single_noise_values(tau_s, share):
    """Oracle: one noise value sent through the recursions by hand."""
    one = step(Response(time_constant_s=tau_s, recursive_filter=share), 0.02)
    x = np.zeros(40)
    x[0] = 1.0
    y, s = np.zeros(40), np.zeros(40)
    for n in range(40):
        y[n] = (1 - share) * x[n] + share * (y[n - 1] if n else 0)
        s[n] = (x[n] - (one.decay * x[n - 1] + one.before * s[n - 1] if n else 0)) / one.now
    found = responses(one)
    assert np.allclose(found.as_it_came[:40], y)
    assert np.allclose(found.added[:40], s - y)
    assert one.decay + one.before + one.now == pytest.approx(1)  # a scene at rest is its own frame


def test_what_a_gap_hides_is_not_made_up():
    """Oracle: a list by hand; runs of frames 0..5 and 9..14 give what lies between their ends."""
    times = 0.03 * np.array([*range(6), *range(9, 15)])
    frames = np.ones((12, 16, 16))
    readout = Readout(response=Response(time_constant_s=3e-3), row_delay_s=1e-3)
    assert [one.index for one in scenes(frames, times, readout=readout, noise=1.0)] == [1, 2, 3, 4, 7, 8, 9, 10]


def test_noise_is_found_beside_an_edge_that_moves():
    """Oracle: the noise that was added."""
    assert noise_of(film(FilmedBy(window_s=1e-3), n_frames=16, noise=4.0).frames) == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"times": [0.0, 0.1, 0.1]}, "each later than the one before"),
        ({"row_delay_s": 0.05}, "rows are read over"),
        ({"tau_s": 9.0}, "more than 20 times the frame interval"),
        ({"noise": -1.0}, "noise of a pixel is -1.0"),
    ],
)
def test_what_cannot_be_is_refused(change, said):
    """Oracle: the words of each refusal."""
    given = {"times": [0.0, 0.1, 0.2], "row_delay_s": 0.0, "tau_s": 0.01, "noise": 1.0} | change
    readout = Readout(response=Response(time_constant_s=given["tau_s"]), row_delay_s=given["row_delay_s"])
    with pytest.raises(EstimationError, match=said):
        list(scenes(np.ones((3, 8, 8)), np.array(given["times"]), readout=readout, noise=given["noise"]))


def test_a_frame_of_another_size_is_refused():
    """Oracle: the words of the refusal."""
    stream = SceneStream(Readout(response=Response()), size=(8, 8), interval_s=0.1, noise=0.0)
    with pytest.raises(EstimationError, match="frame 3 has 8 x 9 pixels"):
        list(stream.push(np.ones((8, 9)), index=3, time_s=0.0))


def _radiance(kelvin):
    """In-band radiance from 7.5 to 14 um by Planck's law, summed over 200 wavelengths; W m^-2 sr^-1."""
    wave_m = np.linspace(7.5e-6, 14e-6, 200)
    c1, c2 = 2 * 6.62607015e-34 * 299792458.0**2, 6.62607015e-34 * 299792458.0 / 1.380649e-23
    spectrum = c1 / wave_m**5 / np.expm1(c2 / (wave_m * np.asarray(kelvin)[..., None]))
    return np.trapezoid(spectrum, wave_m, axis=-1)


def test_a_lag_that_depends_on_the_temperature_is_undone():
    """Oracle: a pixel with two constants, its heat stepped in 50 us with Planck's law; scenes from 290 K to 390 K and back."""
    substrate_s, scene_s, around_k, reference_k, interval_s = 12e-3, 14e-3, 300.0, 300.0, 0.02
    slope = float(_radiance(reference_k + 0.01) - _radiance(reference_k - 0.01)) / 0.02
    ends = _radiance(np.array([290.0, 390.0]))
    fine = np.arange(0, 1.0, 5e-5)
    seen = np.interp(fine, interval_s * np.arange(51), ends[0] + np.ptp(ends) * np.sin(np.pi * np.arange(51) / 20) ** 2)
    table_k = np.linspace(280.0, 400.0, 4000)
    table = _radiance(table_k)
    shown, pixel_k = [], 295.0
    for n, light in enumerate(seen):
        radiance = np.interp(pixel_k, table_k, table)
        if n % 400 == 0:  # what a camera shows: the light that would hold the pixel there
            shown.append(radiance + slope * scene_s * (pixel_k - around_k) / substrate_s)
        pixel_k += 5e-5 * ((around_k - pixel_k) / substrate_s + (light - radiance) / (slope * scene_s))
    frames = np.array(shown)[:, None, None] * np.ones((1, 8, 8)) * 100
    times = interval_s * np.arange(len(frames))
    constants = TwoConstants(
        substrate_time_constant_s=substrate_s, scene_time_constant_s=scene_s, reference_temperature_k=reference_k
    )
    lowest, highest = 100 * table[0], 100 * table[-1]
    kelvin = np.interp(np.linspace(lowest, highest, 256), 100 * table, table_k)
    of_value = of_two_constants(
        constants, substrate_temperature_k=around_k, lowest=lowest, highest=highest, scene_temperature_k=kelvin
    )
    true = 100 * seen[::400]
    errors = []
    for response in (Response(time_constant_s=6.4e-3, of_value=of_value), Response(time_constant_s=6.4e-3)):
        found = {
            one.index: one.pixels[0, 0] for one in scenes(frames, times, readout=Readout(response=response), noise=0.0)
        }
        errors.append(np.sqrt(np.mean([(found[n] - true[n]) ** 2 for n in range(5, len(frames))])))
    before = np.sqrt(np.mean((frames[5:, 0, 0] - true[5:]) ** 2))
    assert errors[0] < before / 50
    assert errors[0] < errors[1] / 3  # one constant for all temperatures does worse

"""Pixels with unequal gains before a wheel that is asked point by point: the sums' delays move as the light's mean angle says."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate import pixel_sums, reference_noise
from irtiming.physics.wheel import wheel_model
from irtiming.records.reduced import AxleView, ContrastImage

TURN, OMEGA, CLOCK_HZ, START = 2 * np.pi, 2 * np.pi * 3, 49_152_000, 7_000_000
EDGES, GATE, BISECTOR = (0.0, 1.5718, 3.1421, 4.7125), 0.2682, -np.pi / 2
GAMMA = float(np.radians(75))
ROWS, COLUMNS, AXLE = 40, 64, (45.2, 31.3)
ROI = (0, ROWS, 0, COLUMNS)
TRIGGERS = START + 20_000_000 + 1_622_016 * np.arange(1000, dtype=np.int64)
SPREAD = 0.01


def _places():
    down, across = np.arange(ROWS)[:, None] - AXLE[0], np.arange(COLUMNS)[None, :] - AXLE[1]
    beside = np.angle(np.exp(1j * (np.arctan2(down, across) - BISECTOR)))
    radius = np.hypot(down, across)
    return beside, (np.abs(beside) < GAMMA / 2) & (radius > 10) & (radius < 40)


def _angle(triggers):
    return OMEGA * (triggers - START) / CLOCK_HZ + 0.4


def _opened(clockwise, triggers):
    """Open share of each pixel of the mask in each frame: nine points across its own angle."""
    beside, mask = _places()
    polar = BISECTOR + beside[mask] if clockwise else np.pi - BISECTOR - beside[mask]
    spread = 1 / np.hypot(np.nonzero(mask)[0] - AXLE[0], np.nonzero(mask)[1] - AXLE[1])
    theta, total = _angle(triggers), np.zeros((triggers.size, polar.size))
    for part in (np.arange(9) + 0.5) / 9 - 0.5:
        wheel = np.mod(np.pi / 2 + GATE + theta[:, None] - polar - part * spread, TURN)
        total += ((wheel >= EDGES[1]) & (wheel < EDGES[2])) | (wheel >= EDGES[3])
    return total / 9, mask


@pytest.fixture
def recordings(track_of, reduced_recording):
    """Recordings of the same wheel, each with gains of its own: ``recordings(gains (k, n_pixel), clockwise, references)``."""
    track = track_of(lambda t: OMEGA * t + 0.4, start=START, duration_s=35.5)

    def make(gains, clockwise, fingerprints, triggers=TRIGGERS):
        opened, mask = _opened(clockwise, triggers)
        weight = 2 / triggers.size * np.exp(-2j * _angle(triggers))
        weight -= weight.mean()
        made = []
        for gain, name in zip(gains, fingerprints, strict=True):
            image = np.zeros(mask.shape, complex)
            image[mask] = 1000 * gain * (weight @ opened)
            one = reduced_recording(track, triggers, 1000 * opened @ gain)
            opening = replace(
                one.opening, roi=ROI, mask=mask, summed=mask, weight=mask.astype(float), bad=np.zeros(mask.shape, bool)
            )
            axle = AxleView(
                row_px=AXLE[0], column_px=AXLE[1], u_centre_px=0.0, bisector_rad=BISECTOR, u_bisector_rad=0.0,
                mean_angle_rad=BISECTOR, u_off_axle_rad=0.0,
            )  # fmt: skip
            contrast = ContrastImage(
                projection_dn=image, frame_weight=weight, u_dn=1e-3, good=np.ones(mask.shape, bool), roi=ROI
            )
            made.append(
                replace(
                    one,
                    opening=opening,
                    axle=axle,
                    contrast=contrast,
                    references=name,
                    pixel_maps={"u_gain": np.where(mask, SPREAD, 0.0), "mean_dn": np.zeros(mask.shape)},
                )
            )
        return made

    return make


def _gains(n, seed=1):
    n_pixel = int(_places()[1].sum())
    return 1 + SPREAD * np.random.default_rng(seed).standard_normal((n, n_pixel))


def _wheel(rotation="clockwise"):
    return wheel_model(EDGES, GATE, opening_angle_rad=GAMMA, centre_angle_rad=BISECTOR, rotation=rotation)


def _turns(made, rotation="clockwise"):
    return reference_noise.light_turns(made, wheel=_wheel(rotation), rotation=rotation)


def _delay_without_memory(fit):
    """Mean of the edges' delays where the pixels are known to remember nothing: each fit alone is free to find that they do."""
    at = fit.estimate.names.index(pixel_sums.MEMORY)
    with_memory = fit.estimate.covariance[:4, at].mean() / fit.estimate.covariance[at, at]
    return fit.edge_delay_s.mean() - with_memory * fit.estimate.value(pixel_sums.MEMORY)


@pytest.mark.parametrize("clockwise", [True, False])
def test_delays_move_as_the_image_says(recordings, clockwise):
    """Oracle: the sums of the pixels themselves, fitted one recording at a time: differences of their delays.

    The number per set of references is what the image says, since it has hardly any noise here.
    """
    made = recordings(_gains(3), clockwise, ["a", "b", "c"])
    rotation = "clockwise" if clockwise else "counterclockwise"
    model = _wheel(rotation)
    fits = [pixel_sums.fit(one, model) for one in made]
    delay = np.array([_delay_without_memory(fit) for fit in fits])
    shared = reference_noise.shared(made, fits, wheel=model, rotation=rotation)
    told = np.array([one.known * one.effects[k]["edge_delay_0"] for k, one in enumerate(shared)])
    assert np.ptp(delay) > 5e-6
    # an edge that comes early by an angle makes the local delay larger by that over omega
    np.testing.assert_allclose(told - told.mean(), delay - delay.mean(), atol=0.12 * np.ptp(delay))


def test_levels_that_sway_turn_no_light(recordings):
    """Oracle: the recordings without it; all pixels sway by a tenth of the contrast, some turns at a time."""
    model = _wheel()
    made, swaying = recordings(_gains(2), True, ["a", "b"]), []
    for one, turns in zip(made, (5.3, 8.1), strict=True):
        sway_dn = 100 * np.sin(TURN * turns * np.arange(TRIGGERS.size) / TRIGGERS.size)
        image, sums = one.contrast_image, one.pixels.pixel_sum + sway_dn * one.opening.summed.sum()
        beside = replace(image, projection_dn=image.projection_dn + image.frame_weight @ sway_dn)
        swaying.append(replace(one, contrast=beside, pixels=replace(one.pixels, pixel_sum=sums)))
    known = []
    for recordings_of in (made, swaying):
        fits = [pixel_sums.fit(one, model) for one in recordings_of]
        known.append(
            [one.known for one in reference_noise.shared(recordings_of, fits, wheel=model, rotation="clockwise")]
        )
    assert np.abs(known[0]).min() > 0.1
    np.testing.assert_allclose(known[1], known[0], rtol=0.03)


@pytest.mark.parametrize("clockwise", [True, False])
def test_triggers_that_visit_the_wheel_in_slow_turns_turn_no_light(recordings, clockwise):
    """Oracle: the gains themselves: their mean angle in each recording, less that over both.

    From frame to frame the wheel turns a little more than a quarter, so that its fourth order stands still in the image.
    """
    gains, made = _gains(2), []
    for gain, name, lead in zip(gains, "ab", (0.0, 0.31), strict=True):
        turns = lead + 0.2554 * np.arange(242)
        triggers = START + 20_000_000 + np.rint(TURN * turns * CLOCK_HZ / OMEGA).astype(np.int64)
        made += recordings([gain], clockwise, [name], triggers=triggers)
    beside, mask = _places()
    mean_angle = gains @ beside[mask] / gains.sum(axis=1)
    found = [one.image_rad for one in _turns(made, "clockwise" if clockwise else "counterclockwise")]
    assert abs(np.diff(mean_angle)[0]) > 5e-5
    np.testing.assert_allclose(found, mean_angle - mean_angle.mean(), atol=1e-5)


def test_references_alone_turn_the_light_by_what_draws_of_them_do(recordings):
    """Oracle: 60 draws of gains: the spread of the light's mean angle."""
    turns = _turns(recordings(_gains(60), True, [str(k) for k in range(60)]))
    spread = np.std([turn.image_rad for turn in turns], ddof=1)
    assert turns[0].u_references_rad == pytest.approx(spread, rel=0.25)
    n_pixel = _gains(1).size
    assert turns[0].u_references_rad == pytest.approx(SPREAD * GAMMA / np.sqrt(12 * n_pixel), rel=0.1)


def test_what_turns_the_whole_image_turns_no_light(recordings):
    """Oracle: a law; a delay turns all phases of an image alike, and the light's mean angle is about the opening's own."""
    one = recordings(_gains(1), True, ["a"])[0]
    later = replace(
        one, contrast=replace(one.contrast_image, projection_dn=one.contrast_image.projection_dn * np.exp(0.7j))
    )
    (here,), (there,) = _turns([one]), _turns([later])
    assert there.image_rad == pytest.approx(here.image_rad, abs=1e-9)
    assert there.u_references_rad == pytest.approx(here.u_references_rad, rel=1e-9)


def test_the_same_references_are_one_number_and_none_are_none(recordings):
    """Oracle: by hand; recordings a, a, b have two sets, recordings without references no noise of any."""
    made = recordings(_gains(3), True, ["a", "a", "b"])
    model = _wheel()
    fits = [pixel_sums.fit(one, model) for one in made]
    shared = reference_noise.shared(made, fits, wheel=model, rotation="clockwise")
    assert [[bool(effect) for effect in one.effects] for one in shared] == [[True, True, False], [False, False, True]]
    bare = [
        replace(one, references="", pixel_maps=one.pixel_maps | {"u_gain": np.zeros((ROWS, COLUMNS))}) for one in made
    ]
    assert reference_noise.shared(bare, fits, wheel=model, rotation="clockwise") == []
    assert (
        reference_noise.shared([replace(one, axle=None) for one in made], fits, wheel=model, rotation="clockwise") == []
    )


def test_an_image_of_three_times_the_noise_counts_a_ninth(recordings):
    """Oracle: a law; beside one with noise of a third, a recording weighs as it does beside nine like it."""
    one, other = recordings(_gains(2), True, ["a", "b"])
    noisy = replace(other, contrast=replace(other.contrast_image, u_dn=3 * other.contrast_image.u_dn))
    found, alike = _turns([one, noisy])[0], _turns([*[one] * 9, other])[0]
    assert found.image_rad == pytest.approx(alike.image_rad, rel=1e-9)
    assert found.u_references_rad == pytest.approx(alike.u_references_rad, rel=1e-9)
    assert found.u_references_rad > 0

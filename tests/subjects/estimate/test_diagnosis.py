"""The likeliest cause of structured residuals: defects put into the sums of small simulated recordings, one at a time."""

from dataclasses import fields, replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming import measurement
from irtiming.archive import reader
from irtiming.archive.rig_file import read_rig
from irtiming.estimate import causes, diagnosis, timing
from irtiming.estimate.frame_residuals import FrameResiduals
from irtiming.records.diagnosis import Cause
from irtiming.records.estimate import Estimate
from irtiming.records.row_timing import RowTimingFit
from irtiming.reduce.wheel import pooled_slots
from irtiming.session.simulation import CameraOrder, SimulationOrder, simulate


def _reduced(folder, camera):
    order = SimulationOrder(folder=folder, camera=CameraOrder(camera=camera, rows=64, columns=80), frames=400)
    made = simulate(order)
    rig = read_rig(made.rig)
    one = measurement.reduce(reader.read(made.recordings[0]), rig)
    tracks, _ = pooled_slots.pool([one], before=None)
    return replace(one, track=tracks[0]), rig


@pytest.fixture(scope="module")
def photon(tmp_path_factory):
    """One reduced recording of a cooled camera, 64 x 80 pixels, 400 frames, and its rig."""
    return _reduced(tmp_path_factory.mktemp("photon"), "photon")


@pytest.fixture(scope="module")
def microbolometer(tmp_path_factory):
    """The same of a microbolometer camera."""
    return _reduced(tmp_path_factory.mktemp("microbolometer"), "microbolometer")


@pytest.fixture(scope="module")
def sound(request):
    """Timing of the recording of a camera as it was made, once for each camera."""

    def estimate(camera):
        recording, rig = request.getfixturevalue(camera)
        return timing.estimate([recording], rig)

    return cache(estimate)


def _span(values):
    return np.ptp(np.quantile(values, [0.03, 0.97], axis=0), axis=0)


def _spoilt(recording, added):
    """The recording with so much of the contrast added to each frame, shape (n,)."""
    if recording.pixels is not None:
        sums = recording.pixels.pixel_sum
        return replace(recording, pixels=replace(recording.pixels, pixel_sum=sums + added * _span(sums)))
    rows = recording.rows.row_sum_dn
    return replace(recording, rows=replace(recording.rows, row_sum_dn=rows + added[:, None] * _span(rows)))


def _jumped(recording, share=8e-3):
    """The recording whose level rises in the middle by so much of the contrast, alike in all its pixels."""
    added = np.where(np.arange(recording.trigger_ticks.size) > recording.trigger_ticks.size // 2, share, 0.0)
    if recording.pixels is not None:
        return _spoilt(recording, added)
    rows, opening = recording.rows, recording.opening
    pixels = opening.summed.sum(axis=1)[rows.row_px]
    contrast_dn = np.median(_span(rows.row_sum_dn) / np.maximum(1, opening.mask.sum(axis=1)[rows.row_px]))
    return replace(recording, rows=replace(rows, row_sum_dn=rows.row_sum_dn + added[:, None] * contrast_dn * pixels))


def _every_second(n):
    return np.where(np.arange(n) % 2 == 0, 2e-3, -2e-3)


@pytest.mark.parametrize("camera", ["photon", "microbolometer"])
def test_what_was_put_in_is_named_first(request, camera):
    """Oracle: the defect that was added to the sums, known in closed form; its size is found too."""
    recording, rig = request.getfixturevalue(camera)
    found = diagnosis.diagnose(timing.estimate([_spoilt(recording, _every_second(recording.trigger_ticks.size))], rig))
    first = found.causes[0]
    assert first.name.startswith("every second frame differs")
    assert first.chance < 1e-6
    assert first.size == pytest.approx(2e-3, rel=0.25)


@pytest.mark.parametrize("camera", ["photon", "microbolometer"])
def test_levels_that_jump_are_followed(request, sound, camera):
    """Oracle: the result without the jump; nothing is left of it to be named."""
    recording, rig = request.getfixturevalue(camera)
    spoilt = timing.estimate([_jumped(recording)], rig)
    even = sound(camera).found.result.estimate
    assert diagnosis.diagnose(spoilt).findings == ()
    moved = np.abs(spoilt.found.result.estimate.values - even.values) / even.standard_uncertainties
    assert np.max(moved) < 0.5


@pytest.mark.parametrize("camera", ["photon", "microbolometer"])
def test_a_sound_rig_gives_no_finding(sound, camera):
    """Oracle: nothing was put in; no cause moves the result by a standard uncertainty, and none is named."""
    found = diagnosis.diagnose(sound(camera))
    assert found.findings == ()
    assert len({one.name for one in found.causes}) == len(found.causes)
    assert found.fitted


def _seen(rng, *, n=1000, added=0.0, noise=1e-4):
    """Residuals of noise over a trapezoid that opens twice a turn, with so much of the frame before."""
    number = np.arange(n)
    angle = np.mod(2 * np.pi * number * 0.0990990, 2 * np.pi)
    fraction = np.clip(0.5 + 1.6 * np.cos(2 * angle), 0, 1)[:, None]
    plain = FrameResiduals(
        name="x", omega_rad_per_s=6 * np.pi, angle_rad=angle, time=np.linspace(-1, 1, n), number=number, fraction=fraction,
        residual=rng.normal(0, noise, (n, 1)), row=np.zeros(1), noise=np.array([noise]),
    )  # fmt: skip
    (before,) = next(one for one in causes.CANDIDATES if "one before" in one.name).columns(plain)
    return plain, before, replace(plain, residual=plain.residual + added * before)


def test_the_frame_before_is_the_frame_before():
    """Oracle: by hand; the model of the trigger before less that of this one, nothing after a gap."""
    plain, before, _ = _seen(np.random.default_rng(1))
    assert before[0, 0] == 0
    assert before[7, 0] == plain.fraction[6, 0] - plain.fraction[7, 0]
    lost = replace(plain, number=plain.number + (plain.number > 6))
    (after_gap,) = next(one for one in causes.CANDIDATES if "one before" in one.name).columns(lost)
    assert after_gap[7, 0] == 0


def test_a_harmonic_filter_of_nothing_is_the_model():
    """Oracle: a factor of 1; a turn by i m is the derivative of cos 2 theta, -2 sin 2 theta."""
    angle = np.mod(2.399963 * np.arange(2000), 2 * np.pi)
    wave = replace(_seen(np.random.default_rng(2))[0], angle_rad=angle, fraction=np.cos(2 * angle)[:, None])
    ones = np.ones(513, complex)
    assert np.abs(wave.filtered(ones) - wave.fraction).max() < 1e-4
    assert np.abs(wave.slope / wave.omega_rad_per_s + 2 * np.sin(2 * angle)[:, None]).max() < 1e-2


@pytest.mark.parametrize(("moves", "severity"), [(3.0, "doubt"), (0.2, "warning")])
def test_a_cause_is_a_doubt_only_where_it_moves_the_result(moves, severity):
    """Oracle: by hand; a deviance 900 beyond 1000 degrees of freedom, of which one number explains 800."""
    first = Cause(name="a", gained=800.0, n_numbers=1, chance=0.0, size=1e-3, moves={"trigger_delay": moves}, cure="b")
    (found,) = diagnosis._findings([first], deviance=1900.0, freedom=1000)
    assert (found.severity, found.cure) == (severity, "b")
    assert "explains most of them is that a (deviance 800 of 900 too much)" in found.what


def test_two_causes_that_explain_alike_are_both_named():
    """Oracle: by hand; deviances that differ by 4 are e^2 apart, and the larger move counts."""
    first = Cause(name="a", gained=104.0, n_numbers=1, chance=0.0, size=1e-3, moves={"trigger_delay": 0.1})
    second = replace(first, name="c", gained=100.0, moves={"trigger_delay": -5.0})
    (found,) = diagnosis._findings([first, second], deviance=1100.0, freedom=1000)
    assert "or nearly as well that c: that would move trigger_delay by -5.0 u" in found.what
    assert diagnosis._findings([replace(first, chance=0.5)], deviance=1100.0, freedom=1000) == ()


def test_a_cause_moves_the_result_as_a_fit_with_it_would():
    """Oracle: least squares with the cause's column beside those of the fit, against least squares without it."""
    rng = np.random.default_rng(3)
    frames, before, _ = _seen(rng)
    flat = [diagnosis._flat(frames, one)[:, None] for one in (frames.slope, np.abs(frames.slope), before)]
    fitted, data = np.hstack(flat[:2]), 4.0 * flat[2][:, 0] + rng.normal(size=len(before))
    without = np.linalg.lstsq(fitted, data, rcond=None)[0]
    together = np.linalg.lstsq(np.hstack(flat), data, rcond=None)[0]
    beside = diagnosis._Beside(
        runs=(frames,), residual=data - fitted @ without, fitted=fitted, known=np.zeros((0, 2)),
        parameters={"trigger_delay": np.array([1.0, 0.5])},
    )  # fmt: skip
    estimate = Estimate(names=("trigger_delay",), units=("s",), values=np.zeros(1), covariance=np.array([[9e-12]]))
    candidate = next(one for one in causes.CANDIDATES if "one before" in one.name)
    found = diagnosis._cause(candidate, beside, estimate, n_tried=1)
    move = (together[:2] - without) @ [1.0, 0.5]
    assert found.moves["trigger_delay"] == pytest.approx(move / 3e-6, rel=1e-6)
    assert found.n_numbers == 1


def test_a_cause_that_is_like_what_was_fitted_explains_nothing():
    """Oracle: by hand; but for 1e-4 of it the cause's column is the one that was fitted, and of the residuals it has no share."""
    rng = np.random.default_rng(4)
    frames, before, _ = _seen(rng)
    column = diagnosis._flat(frames, before)
    fitted = (column + 1e-4 * np.linalg.norm(column) / len(column) ** 0.5 * rng.normal(size=len(column)))[:, None]
    beside = diagnosis._Beside(
        runs=(frames,), residual=rng.normal(size=len(column)), fitted=fitted, known=np.zeros((0, 1)), parameters={}
    )
    estimate = Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0)))
    candidate = next(one for one in causes.CANDIDATES if "one before" in one.name)
    found = diagnosis._cause(candidate, beside, estimate, n_tried=1)
    assert (found.n_numbers, found.gained, found.chance) == (0, 0.0, 1.0)


def test_later_rows_are_a_delay_and_a_row_delay(sound):
    """Oracle: by hand; all edges 1 s later are the delay 1 s later, and 1 s for each row leaves row 0 where it was."""
    beside = diagnosis._of_rows(sound("microbolometer"))
    names = list(causes.fitted(beside.runs[0], lag_s=8e-3))
    edges = np.array([name.startswith("edge") for name in names], float)
    for_each_row = beside.runs[0].middle_px * edges + beside.runs[0].half_px * np.array(
        [name == "row delay" for name in names]
    )
    moved = {name: (float(of @ edges), float(of @ for_each_row)) for name, of in beside.parameters.items()}
    assert moved["trigger_delay"] == pytest.approx((1.0, 0.0), abs=1e-9)
    assert moved["row_delay"] == pytest.approx((0.0, 1.0), abs=1e-9)
    assert moved["time_constant"] == (0.0, 0.0)


def test_an_error_that_is_known_beforehand_stands_beside_what_is_known_of_it():
    """Oracle: by hand; 0.8 mrad where 0.2 +- 0.3 is known are 2 u from it, and found to 0.1 they are 36 of deviance.

    A number of which nothing is known stands for no defect; the one farther from what is known comes first.
    """
    shared = [
        SimpleNamespace(name="gate_angle", unit="rad", known=2e-4, u=3e-4),
        SimpleNamespace(name="trigger_delay", unit="s", known=0.0, u=None),
        SimpleNamespace(name="latency", unit="s", known=0.0, u=1e-6),
    ]
    joint = SimpleNamespace(
        shared=shared,
        values=np.array([8e-4, 1e-3, -3e-6]),
        combined=lambda: SimpleNamespace(covariance=np.diag([1e-8, 1e-12, 2.5e-13])),
    )
    latency, angle = diagnosis._fitted(joint, ())
    assert (latency.name, latency.from_none, latency.gained) == ("latency", pytest.approx(-3.0), pytest.approx(36.0))
    assert (angle.name, angle.from_none, angle.gained) == ("gate_angle", pytest.approx(2.0), pytest.approx(36.0))
    assert (angle.value.value, angle.value.standard_uncertainty) == (pytest.approx(6e-4), pytest.approx(1e-4))


def test_what_a_recording_has_of_its_own_stands_beside_its_u():
    """Oracle: by hand; a memory of 0.06 known to 0.02 is 3 u from none, and without it the deviance is larger by 9.

    A number that was held has no u, and is none of the recording's own.
    """
    estimate = Estimate(
        names=("time_constant", "recursive_filter", "held"), units=("s", "1", "1"), values=np.array([8e-3, 0.06, 0.1]),
        covariance=np.diag([1e-10, 4e-4, 0.0]),
    )  # fmt: skip
    nothing = dict.fromkeys(one.name for one in fields(RowTimingFit))
    (found,) = diagnosis._own(RowTimingFit(**nothing | {"name": "a", "estimate": estimate}))
    assert (found.name, found.unit) == ("a: recursive_filter", "1")
    assert (found.from_none, found.gained) == (pytest.approx(3.0), pytest.approx(9.0))
    assert (found.value.value, found.value.standard_uncertainty) == (pytest.approx(0.06), pytest.approx(0.02))

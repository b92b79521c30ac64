"""The whole analysis on example recordings of a cooled camera whose truth is stored beside them."""

import json

import numpy as np
import pytest

from irtiming import measurement
from irtiming.archive import reader, rig_file
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.choices import Choices

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def cooled(shared_recordings):
    """Folder with two recordings of one cooled camera, 0 and 25 ms set."""
    folder = shared_recordings / "cooled"
    if not (folder / "truth.json").is_file():
        pytest.skip(f"no truth.json in {folder}")
    return folder


@pytest.fixture(scope="module")
def truth(cooled):
    """What made the recordings."""
    return json.loads((cooled / "truth.json").read_text())


@pytest.fixture(scope="module")
def analysis(cooled):
    """Both recordings analysed by both methods."""
    rig = rig_file.read_rig(cooled / "rig.toml")
    paths = sorted(cooled.glob("*.nxs"))
    return measurement.analyse((reader.read(path) for path in paths), rig, extras=("published",))


@pytest.mark.parametrize("method", ["best", "published"])
def test_relative_delay_is_what_was_set(analysis, method):
    """Oracle: the trigger generator; 25 ms, within three stated uncertainties and within 2 us."""
    result = analysis.best if method == "best" else analysis.published.result
    first, second = result.relative_delays
    assert (first.value_s, first.nominal_s, second.nominal_s) == (0, 0, pytest.approx(0.025))
    deviation = abs(second.value_s - 0.025)
    assert deviation < 3 * second.standard_uncertainty_s
    assert deviation < 2e-6
    assert 0 < second.standard_uncertainty_s < 5e-6


def test_absolute_delay_is_the_true_one(analysis, truth):
    """Oracle: truth.json; start, middle, falling and rising within three stated uncertainties, which are not huge.

    The camera of truth.json has no memory of the frame before: that share is 0, and known to a thousandth.
    """
    estimate = analysis.best.estimate
    true = dict.fromkeys(("trigger_delay", "trigger_delay_falling", "trigger_delay_rising"), truth["trigger_delay_s"])
    true["exposure_midpoint_delay"] = truth["trigger_delay_s"] + truth["integration_time_s"] / 2
    limits = {**dict.fromkeys(true, 50e-6), "pixel_memory": 1e-3}
    true["pixel_memory"] = 0.0
    assert estimate.names[:2] == ("trigger_delay", "exposure_midpoint_delay")
    assert set(estimate.names) == set(true)
    deviations = np.abs(estimate.values - [true[name] for name in estimate.names])
    assert np.all(deviations < 3 * estimate.standard_uncertainties)
    assert np.all(estimate.standard_uncertainties < [limits[name] for name in estimate.names])
    budget = np.sqrt(sum(c.standard_uncertainty["trigger_delay"] ** 2 for c in analysis.best.budget))
    assert budget == pytest.approx(estimate.standard_uncertainties[0])


def test_falling_and_rising_edges_agree_without_a_threshold(analysis):
    """Oracle: the truth has one delay; pixel sums have no threshold that could split it."""
    values = dict(zip(analysis.best.estimate.names, analysis.best.estimate.values, strict=True))
    assert abs(values["trigger_delay_falling"] - values["trigger_delay_rising"]) < 5e-6


def test_learned_slots_are_nearer_the_truth_than_equal_ones(analysis, truth):
    """Oracle: truth.json; deviations of 100 slots from regularity, means taken off: better by five times.

    What is left is a speed ripple that repeats every turn, which nobody can tell from the slots at one speed.
    """
    true = np.array(truth["control_slot_angles_rad"]) - TURN * np.arange(100) / 100
    true -= true.mean()
    for recording in analysis.recordings:
        learned = recording.track.slot_deviation_rad - true
        assert np.std(learned) < 0.2 * np.std(true)
        assert np.all(recording.equal_track.slot_deviation_rad == 0)


def test_gates_are_where_they_are(analysis, truth):
    """Oracle: truth.json; beta_1 and beta_2 within three of the uncertainties that caliper and slots give."""
    gates = analysis.geometry.gates
    u = np.sqrt(sum(u**2 for source, _, u in analysis.geometry.angle_budget if source.startswith(("gate", "register"))))
    assert abs(gates.application_rad - truth["beta_1_rad"]) < 3 * u
    assert abs(gates.control_rad - truth["beta_2_rad"]) < 3 * u


def test_wheel_centre_is_where_it_is(analysis, truth):
    """Oracle: truth.json; within a fiftieth of a pixel, ten times better than asked for."""
    row, column = truth["wheel_centre_row_column_px"]
    for recording in analysis.recordings:
        assert recording.axle.row_px == pytest.approx(row, abs=0.02)
        assert recording.axle.column_px == pytest.approx(column, abs=0.02)


def test_angles_of_learned_and_equal_slots_differ_by_the_slots(analysis):
    """Oracle: the two tracks of one recording; they differ by the slot deviations, interpolated, and by nothing else."""
    recording = analysis.recordings[0]
    angles = [
        wheel_angle_rad(0.0, track, at_ticks=recording.trigger_ticks)
        for track in (recording.track, recording.equal_track)
    ]
    difference = np.angle(np.exp(1j * (angles[0] - angles[1])))
    deviation = recording.track.slot_deviation_rad
    assert np.std(difference) == pytest.approx(np.std(deviation), rel=0.3)
    assert np.abs(difference - difference.mean()).max() < 1.5 * np.abs(deviation).max()


def test_residuals_are_small_and_no_frame_is_lost(analysis):
    """Oracle: the size of the recordings; every frame is used, and the model holds to a thousandth of the step."""
    for recording, fit in zip(analysis.recordings, analysis.fits, strict=True):
        assert recording.pixels.pixel_sum.size == recording.n_frames
        assert fit.n_dropped <= 0.02 * recording.n_frames
        assert fit.noise < 2e-3


def test_choice_of_the_method_is_obeyed(analysis):
    """Oracle: by hand; both results are always there, the choice names the one that counts."""
    assert analysis.result is analysis.best
    choices = Choices(method="published")
    published = measurement.estimate(analysis.recordings[:1], analysis.rig, choices=choices)
    assert published.result is published.published.result
    assert published.result.method == "published"

"""Contrast image and row sums in turns, on frames that were summed point by point in the time domain."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import profiles, rolling_camera, timing
from irtiming.physics.light_gates import gate_angles
from irtiming.records.reduced import ContrastPairs
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel

TURN = 2 * np.pi
ROLL = float(np.radians(-1.2))
UNSTATED = {"latency-not-stated", "clock-not-stated", "lateral-offset-not-stated", "taken-on-trust"}
FILTER = "share of the frame before in each frame"
NAMES = ("trigger_delay", "time_constant", "row_delay", "recursive_filter")


@pytest.fixture(scope="module")
def rig():
    """Rig of the camera; the gates as far apart as the tracks have it, beta_1 = 0.2682 rad."""

    def make(*, rotation="clockwise", centre_deg=-90.0, edges=(0.0, 1.5718, 3.1421, 4.7125)):
        stated = None if edges is None else tuple(Measured(edge, 1e-4) for edge in edges)
        return Rig(
            wheel=Wheel(rotation=rotation, cutout_edges_rad=stated),
            light_gates=LightGates(
                half_separation_m=Measured(13e-3, 5e-5),
                height_difference_m=Measured(5.5e-3, 5e-5),
                whole_slots_between=9,
            ),
            mask_opening=MaskOpening(
                opening_angle_rad=Measured(float(np.radians(75))),
                centre_angle_rad=Measured(float(np.radians(centre_deg)), 5e-4),
            ),
        )

    return make


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    """Rolled by -1.2 deg, its gate where rig and tracks put it."""
    gates = LightGates(
        half_separation_m=Measured(13e-3, 5e-5), height_difference_m=Measured(5.5e-3, 5e-5), whole_slots_between=9
    )
    return brute_bolometer(gate_rad=float(np.pi / 2 + gate_angles(0.5697, gates).application_rad))


@pytest.fixture(scope="module")
def rows(camera, brute_rows):
    return brute_rows(camera, noise_dn=6.0, seed=1)


@pytest.fixture(scope="module")
def found(rows, rig):
    """One recording before a cold blackbody."""
    return timing.estimate([rows], rig())


def _deviations(fit, camera):
    truth = np.array([camera.edge_delay_s[0], camera.time_constant_s, camera.row_delay_s, 0.0])
    assert fit.found.result.estimate.names == NAMES
    return (fit.found.result.estimate.values - truth) / fit.found.result.estimate.standard_uncertainties


def test_the_camera_comes_back(found, camera):
    """Oracle: the numbers that made the frames; delay by noise alone, for the rig is stated exactly as it is."""
    noise = np.sqrt(np.mean(np.diag(found.fits[0].estimate.covariance)[:4]))
    shape = found.found.result.budget[1].standard_uncertainty["trigger_delay"]
    assert abs(found.found.result.estimate.values[0] - 2.3e-3) < 4 * np.hypot(noise, shape)
    assert np.all(np.abs(_deviations(found, camera)) < 4)
    u = found.found.result.estimate.standard_uncertainties
    (filtered,) = (line for line in found.found.result.budget if line.source == FILTER)
    by_filter = [filtered.standard_uncertainty[name] for name in NAMES[:3]]
    assert np.all(np.sqrt(u[:3] ** 2 - np.square(by_filter)) < [60e-6, 25e-6, 1.3e-6])
    assert np.all(u < [60e-6, 30e-6, 1.4e-6, 1e-3])
    assert {finding.code for finding in found.found.result.findings} == UNSTATED
    assert 4 <= found.sectors[0].n_rounds <= 5


def test_the_axle_is_told_to_the_report(found, camera):
    """Oracle: the camera's axle, bisector and roll; before, the recordings knew none."""
    (seen,) = found.recordings
    assert seen.axle.row_px == pytest.approx(camera.axle[0], abs=0.05)
    assert seen.axle.column_px == pytest.approx(camera.axle[1], abs=0.05)
    assert seen.axle.bisector_rad == pytest.approx(camera.bisector_rad, abs=2e-3)
    assert seen.axle.mean_angle_rad == pytest.approx(camera.bisector_rad, abs=3e-3)
    assert found.geometry.camera_roll_rad == pytest.approx(ROLL, abs=2e-3)
    assert 0 < seen.axle.u_bisector_rad < 2e-3


def test_the_profile_of_the_time_constant_is_least_at_the_fit(found):
    """Oracle: the fit itself; the exact likelihood has its minimum within a third of the uncertainty, and rises by 1 at one."""
    profile = next(one for one in profiles.profiles(found) if one.name == "time_constant")
    estimate = found.found.result.estimate
    assert profile.value == pytest.approx(estimate.value("time_constant"), abs=0.3 * estimate.u("time_constant"))
    assert profile.deviation[np.argmin(np.abs(profile.values - profile.value))] == 0
    np.testing.assert_allclose(profile.deviation, [4, 1, 0, 1, 4], atol=0.6)


def test_a_counterclockwise_wheel_is_the_mirror_image(found, camera, brute_rows, rig):
    """Oracle: the same frames read backwards, mask on the other side; numbers stay within a fraction of their noise."""
    mirrored = brute_rows(camera, noise_dn=6.0, seed=1, mirror=True)
    other = timing.estimate([mirrored], rig(rotation="counterclockwise"))
    moved = other.found.result.estimate.values - found.found.result.estimate.values
    alone = found.fits[0].estimate
    noise = np.array([alone.u(name) for name in ("edge_delay_0", *NAMES[1:])])
    assert np.all(np.abs(moved) < noise)
    axle = other.recordings[0].axle
    assert axle.column_px == pytest.approx(63 - camera.axle[1], abs=0.05)
    assert axle.bisector_rad == pytest.approx(-np.pi - camera.bisector_rad, abs=2e-3)
    assert other.geometry.camera_roll_rad == pytest.approx(-ROLL, abs=2e-3)


@pytest.mark.parametrize("contrast_dn", [-600.0, 600.0])
def test_edges_that_nobody_stated_do_not_turn_the_wheel(camera, brute_rows, rig, contrast_dn):
    """Oracle: the camera's delay; an ideal wheel looks the same a quarter turn, 83 ms, later with the contrast reversed."""
    rows = brute_rows(camera, contrast_dn=contrast_dn, noise_dn=6.0, seed=2)
    fit = timing.estimate([rows], rig(edges=None))
    assert np.all(np.abs(_deviations(fit, camera)) < 4)
    assert fit.geometry.edges_from == "ideal"
    assert any("cutout edges taken as ideal" in text for text in (one.sentence() for one in fit.found.result.findings))


@pytest.mark.parametrize(
    ("gains", "move", "stays"),
    [((0.9, 1.0), 0.9, True), ((0.9, 1.1), 0.9, False), ((0.9,), 1.1, False)],
)
def test_images_stay_that_gain_little_while_rows_are_near(monkeypatch, gains, move, stays):
    """Oracle: by hand; a square for each image, one standard uncertainty of the rows."""
    views = [SimpleNamespace(sector=SimpleNamespace(gained=gained)) for gained in gains]
    monkeypatch.setattr(rolling_camera, "_move", lambda *_: move)
    assert rolling_camera._stay(views, (), ()) is stays


def test_rounds_that_never_agree_are_told(rows, rig, monkeypatch):
    """Oracle: an agreement that cannot be reached, as no two rounds are nearer than nothing."""
    monkeypatch.setattr(rolling_camera, "_MOST_ROUNDS", 2)
    monkeypatch.setattr(rolling_camera, "_NEAR", -1.0)
    with pytest.raises(EstimationError, match="did not agree within 2 rounds"):
        timing.estimate([rows], rig())


def test_rounds_that_go_to_and_fro_by_less_than_the_noise_give_a_result(rows, found, rig, monkeypatch):
    """Oracle: the result of rounds that agree; an image's search ends somewhere within its own noise."""
    usual = found.found.result.estimate
    monkeypatch.setattr(rolling_camera, "_AGREED", -1.0)
    monkeypatch.setattr(rolling_camera, "_MOST_ROUNDS", 10)
    other = timing.estimate([rows], rig()).found.result.estimate
    assert np.max(np.abs(other.values - usual.values) / usual.standard_uncertainties) < 0.5


class _SeenError(Exception):
    """The images that a fit was to be made of."""


def test_images_are_rid_of_the_filter_that_rows_tell_from_the_first_on(rows, found, monkeypatch):
    """Oracle: by hand; frames less a quarter of those before, over three quarters, and half of them, over a half.

    In frames of few turns all orders of the wheel show in an image, and a filter turns them apart.
    """
    now, before = np.full((4, 5), 3.0 + 1j), np.full((4, 5), 2.0 - 1j)
    weight = np.ones(rows.trigger_ticks.size, complex)
    pairs = ContrastPairs(projection_dn=now, before_dn=before, frame_weight=weight)
    one = replace(rows, contrast=replace(rows.contrast_image, projection_dn=now, pairs=pairs))

    def seen(recordings, *_, **__):
        raise _SeenError(recordings[0].contrast_image.projection_dn)

    monkeypatch.setattr(rolling_camera.sector_fit, "fit", seen)
    monkeypatch.setattr(rolling_camera.steady_image, "by_rows", lambda recording, _: recording)
    turns = rolling_camera._Turns(recordings=[one], model=None, rig=None, groups=[[0]], filtered={0: 0.25})
    with pytest.raises(_SeenError) as first:
        turns.next([{}])
    np.testing.assert_allclose(first.value.args[0], (now - 0.25 * before) / 0.75)
    (fit,) = found.fits
    filtered = replace(
        fit.estimate, values=np.where(np.array(fit.estimate.names) == NAMES[3], 0.5, fit.estimate.values)
    )
    with pytest.raises(_SeenError) as second:
        turns.next([{}], before=(replace(fit, estimate=filtered, undone=0.0),))
    np.testing.assert_allclose(second.value.args[0], (now - 0.5 * before) / 0.5)


def _rows_at(place):
    estimate = SimpleNamespace(names=("row_delay",), u=lambda _: 1.0)
    return (SimpleNamespace(timing={"row_delay": place}, estimate=estimate),)


class _TurnsBetween:
    """Images that stay, and rows that are found at one place after the other; a search ends at ``searched``."""

    def __init__(self, places, searched):
        self.places, self.at = iter(places), searched

    def next(self, *_, **__):
        return [SimpleNamespace(sector=SimpleNamespace(gained=0.0))], _rows_at(next(self.places))

    def searched(self, *_, **__):
        return _rows_at(self.at)

    def timings(self, _):
        return []


@pytest.mark.parametrize(
    ("places", "searched", "last"),
    [
        ((5.0, 0.9, 0.0, 7.0), -0.7, 7.0),  # a search that ends near, on the far side of where the round before was
        ((5.0, 0.9, 0.0, -3.1, 7.0), -3.0, 7.0),  # one that ends far, from where the next round does not move
    ],
)
def test_what_a_search_finds_is_held_against_where_it_began(monkeypatch, places, searched, last):
    """Oracle: places in standard uncertainties, by hand; when rounds have agreed, one more takes the slopes anew."""
    turns = _TurnsBetween(places, searched)
    monkeypatch.setattr(rolling_camera, "_Turns", lambda **_: turns)
    monkeypatch.setattr(rolling_camera, "_begin", lambda *_, **__: SimpleNamespace(timing={}, filtered=(0.0,)))
    monkeypatch.setattr(rolling_camera.by_blackbody, "of_recordings", lambda _: [[0]])
    one = SimpleNamespace(camera_type="microbolometer", readout_mode="rolling")
    _, fits = rolling_camera._in_turns([one], None, rig=None)
    assert fits[0].timing["row_delay"] == last


@pytest.mark.parametrize(
    ("places", "is_settled"),
    [
        ((3.0, 0.0, 0.04), False),  # it had come far: that it stays this time may be chance
        ((0.04, 0.0, 0.04), True),
        ((0.3, 0.0, 0.31), True),  # to and fro
        ((0.3, 0.0, 0.2), False),
        ((2.0, 0.0, 2.0), False),  # between two places that are not near
    ],
)
def test_rounds_end_when_numbers_stay_or_go_to_and_fro(places, is_settled):
    """Oracle: places in standard uncertainties, by hand: 0.05 is to stay, 1 is near."""
    assert rolling_camera._are_settled(*(_rows_at(place) for place in places)) == is_settled


QUADRATIC, CUBIC = "quadratic_nonlinearity", "cubic_nonlinearity"


@pytest.mark.parametrize(("bent", "wanted"), [((-0.1, 0.0), "warning"), ((0.0, 0.06), "doubt")])
def test_a_response_that_is_not_linear_moves_no_timing(camera, brute_rows, rig, bent, wanted):
    """Oracle: the numbers that made the frames, put through the curve pixel by pixel; a cubic part may have others beyond it."""
    b, c = bent
    rows = brute_rows(camera, noise_dn=6.0, seed=1, curve=lambda v: v + b * v * (1 - v) + c * v * (1 - v) * (1 - 2 * v))
    found = timing.estimate([rows], rig())
    assert np.all(np.abs(_deviations(found, camera)) < 3)
    for name, value in zip((QUADRATIC, CUBIC), bent, strict=True):
        assert found.found.joint_fit.parameters.value(name) == pytest.approx(value, abs=0.012)
    (said,) = (one for one in found.found.result.findings if one.code == "response-not-linear")
    assert said.severity == wanted
    profile = next(one for one in profiles.profiles(found) if one.name == "time_constant")
    np.testing.assert_allclose(profile.deviation, [4, 1, 0, 1, 4], atol=0.6)


def test_a_response_that_is_linear_has_no_curve(found, rows, rig):
    """Oracle: nothing bends the response; its two numbers are looked at, within their u of none, and not fitted."""
    (fit,) = found.fits
    assert not fit.is_bent
    assert all(abs(fit.bends.value(name)) < 3 * fit.bends.u(name) < 0.02 for name in (QUADRATIC, CUBIC))
    assert QUADRATIC not in found.found.joint.names


def test_numbers_that_one_of_two_fits_holds_have_a_mean():
    """Oracle: by hand; the blade beside is that of the opening where it is no number of its own, and a response is straight."""
    one = {"edge_delay_0": 2e-3, "blade_share": 0.01}
    other = {"edge_delay_0": 3e-3, "blade_share": 0.02, "blade_share_beside": 0.05, QUADRATIC: 0.4}
    for both in ([one, other], [other, one]):
        mean = rolling_camera._mean(both)
        assert mean == pytest.approx({
            "edge_delay_0": 2.5e-3, "blade_share": 0.015, "blade_share_beside": 0.03, QUADRATIC: 0.2
        })  # fmt: skip

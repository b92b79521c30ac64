"""What is reported of a joint fit: starts, middles, windows, bounds and budgets by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import joint, measurands, shared_numbers
from irtiming.estimate.measurands import Window
from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.records.rig import Measured, WindowTail
from irtiming.records.sources import TAIL, WINDOW

TURN = 2 * np.pi


def _joint(names, values, covariance, *, n=2, stated=None, tail=None):
    """Recordings that tell four edges and more, all numbers shared; no errors of a rig."""
    estimate = Estimate(
        names=(*EDGE_DELAYS, *names), units=("s",) * (4 + len(names)), values=values, covariance=covariance
    )
    fits = [SimpleNamespace(estimate=estimate, angular_frequency_rad_per_s=TURN * 3)] * n
    shared = [shared_numbers.delay(fits, start=values[0])]
    shared += [shared_numbers.same(name, fits, start=value) for name, value in zip(names, values[4:], strict=True)]
    if stated is not None:
        shared = shared_numbers.with_stated_window(shared, stated_s=stated[0], u_s=stated[1])
    if tail is not None:
        shared += shared_numbers.window_tails(fits, tail, integration_time_s=stated[0])
    return joint.fit([joint.parabola(estimate)] * n, shared)


def _window(length_s=240e-6, *, u_s=10e-6, coupling=0.0, **more):
    """Middle at 600 us; edges to 4 us each, so that two recordings know their mean to sqrt(2) us."""
    covariance = np.diag([16e-12] * 4 + [2 * u_s**2])
    covariance[:4, 4] = covariance[4, :4] = coupling * 4e-6 * np.sqrt(2) * u_s
    return _joint(("integration_time",), np.array([600e-6] * 4 + [length_s]), covariance, **more)


def _of_window(found, *, is_determined=True, **stated):
    given = {"stated_s": None} | stated
    window = Window(is_determined=is_determined, **given)
    return measurands.of_window(found, window, degrees_of_freedom=50.0)


def test_a_stated_window_moves_the_middle_to_the_start():
    """Oracle: by hand; half of 250 us earlier, as uncertain as the middle, for a stated length is taken as exact."""
    found = _of_window(_window(), stated_s=250e-6).estimate
    assert found.value("exposure_midpoint_delay") == pytest.approx(600e-6)
    for name in ("trigger_delay", "trigger_delay_falling", "trigger_delay_rising"):
        assert found.value(name) == pytest.approx(475e-6)
    assert found.u("trigger_delay") == pytest.approx(np.sqrt(2) * 1e-6, rel=1e-6)
    assert found.u("trigger_delay_falling") == pytest.approx(2e-6, rel=1e-6)  # two edges of four
    assert found.value("integration_time") == pytest.approx(240e-6)
    assert found.u("integration_time") == pytest.approx(10e-6)


def test_what_was_known_of_a_window_is_its_stated_length():
    """Oracle: by hand; 250 us with u 20 us were stated, of the delay nothing; a sum of twice the window is 500 us, u 40 us."""
    found = _window(stated=(250e-6, 20e-6))
    asked = [joint.Measurand(name=name, weights={name: 1.0}) for name in ("delay", "integration_time")]
    twice = joint.Measurand(name="twice", weights={"integration_time": 2.0})
    known = measurands.known_before(found, [*asked, twice])
    assert known.names == ("integration_time", "twice")
    assert known.values == pytest.approx([250e-6, 500e-6])
    assert known.standard_uncertainties == pytest.approx([20e-6, 40e-6])
    assert measurands.known_before(found, asked[:1]).names == ()


@pytest.mark.parametrize("coupling", [0.0, 0.3, -0.3])
def test_a_window_that_sums_tell_stands_in(coupling):
    """Oracle: by hand; middle less half the length: variance a + b / 4 - c."""
    found = _of_window(_window(coupling=coupling)).estimate
    assert found.value("trigger_delay") == pytest.approx(480e-6)
    assert found.u("integration_time") == pytest.approx(10e-6)
    u_middle, u_length = found.u("exposure_midpoint_delay"), found.u("integration_time")
    k, m = found.names.index("exposure_midpoint_delay"), found.names.index("integration_time")
    expected = np.sqrt(u_middle**2 + u_length**2 / 4 - found.covariance[k, m])
    assert found.u("trigger_delay") == pytest.approx(expected)
    assert np.sign(found.covariance[k, m]) == np.sign(coupling)


def _squares_add_up(reported):
    for name in reported.estimate.names:
        total = sum(part.standard_uncertainty[name] ** 2 for part in reported.budget)
        assert np.sqrt(total) == pytest.approx(reported.estimate.u(name), rel=1e-6), name


def test_a_length_of_the_other_sign_is_the_same_window():
    """Oracle: the model is even in the length; its coupling to the middle turns with it, variances stay."""
    plus = _of_window(_window(240e-6, coupling=0.3)).estimate
    minus = _of_window(_window(-240e-6, coupling=-0.3)).estimate
    assert minus.values == pytest.approx(plus.values)
    np.testing.assert_allclose(minus.covariance, plus.covariance, rtol=1e-6, atol=1e-20)


@pytest.mark.parametrize(
    ("length_s", "is_determined", "is_significant"), [(21e-6, True, True), (19e-6, True, False), (240e-6, False, False)]
)
def test_a_window_shorter_than_two_u_or_at_one_speed_is_not_reported(length_s, is_determined, is_significant):
    """Oracle: the limit of two standard uncertainties; without a stated length there is no start then."""
    found = _of_window(_window(length_s), is_determined=is_determined).estimate
    assert ("integration_time" in found) is is_significant
    assert ("trigger_delay" in found) is is_significant
    assert "exposure_midpoint_delay" in found


@pytest.mark.parametrize(("stated_s", "n"), [(201e-6, 0), (199e-6, 1), (281e-6, 1), (279e-6, 0)])
def test_a_stated_length_four_u_beside_is_contradicted(stated_s, n):
    """Oracle: by hand; the sums say 240 us with u = 10 us."""
    (found,) = _of_window(_window(), stated_s=stated_s).findings
    assert found.code == ("integration-time-contradicted" if n else "integration-time-on-trust")
    assert found.severity == "doubt"


def test_a_stated_length_and_the_corners_share_by_their_uncertainties():
    """Oracle: weighted mean by hand; 240 us with u = 10 us and 260 us with 20 us: 244 us with 8.94 us, half in the start."""
    one = _of_window(_window(stated=(260e-6, 20e-6)), stated_s=260e-6, u_stated_s=20e-6)
    found, middle = one.estimate, one.estimate.value("exposure_midpoint_delay")
    assert found.value("integration_time") == pytest.approx(244e-6)
    u_length = np.sqrt(1 / (1 / 10**2 + 1 / 20**2)) * 1e-6
    assert found.u("integration_time") == pytest.approx(u_length, rel=1e-3)
    assert found.value("trigger_delay") == pytest.approx(middle - 122e-6)
    assert found.u("trigger_delay") == pytest.approx(np.hypot(np.sqrt(2) * 1e-6, u_length / 2), rel=1e-3)
    _squares_add_up(one)
    (line,) = [part for part in one.budget if part.source == WINDOW]
    assert line.standard_uncertainty["integration_time"] == pytest.approx(20e-6 * (10**2 / (10**2 + 20**2)), rel=1e-3)
    assert (line.kind, line.measured) == ("B", (20e-6, "s"))
    assert (one.findings, one.not_held, one.midpoint_leads) == ((), (), False)


def test_a_stated_length_that_frames_contradict_is_said():
    """Oracle: by hand; 240 us with u = 10 us and 340 us with 20 us are 4.5 standard uncertainties apart, 320 us 3.6."""
    for stated_s, codes in ((340e-6, ["integration-time-contradicted"]), (320e-6, [])):
        found = _of_window(_window(stated=(stated_s, 20e-6)), stated_s=stated_s, u_stated_s=20e-6)
        assert [one.code for one in found.findings] == codes


@pytest.mark.parametrize(("u_s", "is_checked"), [(39e-6, True), (41e-6, False)])
def test_frames_check_a_length_that_they_tell_half_as_well_as_it_is_stated(u_s, is_checked):
    """Oracle: the rule by hand; the stated u is 20 us."""
    found = _of_window(_window(stated=(250e-6, 20e-6), u_s=u_s), stated_s=250e-6, u_stated_s=20e-6)
    assert (found.findings, found.is_length_checked) == ((), is_checked)


def test_a_stated_length_that_no_frame_tells_is_half_in_the_start():
    """Oracle: by hand; u = 15 us of the count_time is 7.5 us of the start, nothing of the middle."""
    bare = _joint((), np.array([600e-6] * 4), np.diag([16e-12] * 4))
    exact, known = (_of_window(bare, stated_s=250e-6, u_stated_s=u, is_determined=False) for u in (0.0, 15e-6))
    assert known.estimate.value("trigger_delay") == exact.estimate.value("trigger_delay") == pytest.approx(475e-6)
    assert known.estimate.u("trigger_delay") == pytest.approx(np.hypot(exact.estimate.u("trigger_delay"), 7.5e-6))
    assert known.estimate.u("exposure_midpoint_delay") == exact.estimate.u("exposure_midpoint_delay")
    _squares_add_up(known)


_FADES_S = {"window_tail_fast": 0.1e-3 / 3, "window_tail_slow": 0.5e-3 / 3}


def test_a_tail_makes_the_start_earlier_and_less_certain():
    """Oracle: by hand; 3 % with u = 2 % over 0.1 ms, of 0.4 ms: parts 1/3 and 5/3 of 0.1 ms beyond the half window."""
    tail, stated = WindowTail(share=Measured(0.03, 0.02), time_constant_s=0.1e-3), (400e-6, 1e-9)
    late_s = {name: 200e-6 + fades_s for name, fades_s in _FADES_S.items()}
    found = _of_window(_window(400e-6, stated=stated, tail=tail), stated_s=400e-6, u_stated_s=1e-9, tails_s=_FADES_S)
    estimate = found.estimate
    assert estimate.value("exposure_midpoint_delay") == pytest.approx(600e-6)
    assert estimate.value("trigger_delay") == pytest.approx(600e-6 - 200e-6 - 0.03 * 300e-6, abs=1e-10)
    u_tail = 0.02 / np.sqrt(2) * np.hypot(*late_s.values())
    assert estimate.u("trigger_delay") == pytest.approx(np.hypot(np.sqrt(2) * 1e-6, u_tail), rel=1e-3)
    assert estimate.u("exposure_midpoint_delay") == pytest.approx(np.sqrt(2) * 1e-6)
    (line,) = [part for part in found.budget if part.source == TAIL]
    assert line.standard_uncertainty["trigger_delay"] == pytest.approx(u_tail, rel=1e-3)
    _squares_add_up(found)


@pytest.mark.parametrize(("is_determined", "leads"), [(False, True), (True, False)])
def test_a_length_on_trust_is_said_beside_the_result(is_determined, leads):
    """Oracle: the rule: the midpoint leads where no speeds verify the window; its u here (10 us) is too coarse to be silent."""
    found = _of_window(_window(), stated_s=250e-6, is_determined=is_determined)
    assert [one.code for one in found.findings] == ["integration-time-on-trust"]
    assert found.not_held == ("integration time (count_time)",)
    assert found.midpoint_leads is leads


def _lag(tau_s, u_s, *, u_delay_s=20e-6):
    covariance = np.diag([4 * u_delay_s**2] * 4 + [u_s**2, 0.04e-12])
    found = _joint(("time_constant", "row_delay"), np.array([4e-3] * 4 + [tau_s, 40e-6]), covariance, n=1)
    return measurands.of_lag(found, ["time_constant"], degrees_of_freedom=50.0)


def test_a_lag_that_is_known_is_a_number():
    """Oracle: by hand; four edges to 40 us make 20 us; the rest as it stands."""
    reported = _lag(5e-3, 1.2e-3)
    assert reported.estimate.names == ("trigger_delay", "time_constant", "row_delay")
    assert reported.estimate.values == pytest.approx([4e-3, 5e-3, 40e-6])
    assert reported.estimate.standard_uncertainties == pytest.approx([20e-6, 1.2e-3, 0.2e-6])
    assert (reported.bounds, reported.findings) == ((), ())


def test_a_lag_that_is_not_known_is_a_bound():
    """Oracle: by hand; u above a quarter of 5 ms: two u to either side, of the delay too; the row delay stays."""
    reported = _lag(5e-3, 1.3e-3)
    assert reported.estimate.names == ("row_delay",)
    bounds = {one.name: (one.lower, one.upper) for one in reported.bounds}
    assert bounds["time_constant"] == pytest.approx((2.4e-3, 7.6e-3))
    assert bounds["trigger_delay"] == pytest.approx((3.96e-3, 4.04e-3))
    assert [one.code for one in reported.findings] == ["lag-not-determined"]


@pytest.mark.parametrize(
    ("tau_s", "u_s", "code"), [(0.1e-3, 0.49e-3, "no-lag-seen"), (0.1e-3, 0.51e-3, "lag-not-determined")]
)
def test_no_lag_at_all(tau_s, u_s, code):
    """Oracle: by hand; an uncertainty below half a millisecond would have shown any microbolometer's."""
    reported = _lag(tau_s, u_s)
    assert [one.code for one in reported.findings] == [code]
    bounds = {one.name: (one.lower, one.upper) for one in reported.bounds}
    assert bounds["time_constant"] == pytest.approx((0.0, tau_s + 2 * u_s))
    assert ("trigger_delay" in reported.estimate) is (code == "no-lag-seen")


def test_several_constants_are_reported_by_their_weighted_mean():
    """Oracle: by hand; u of 10 and 20 us weigh 4 to 1."""
    covariance = np.diag([16e-12] * 4 + [1e-10, 4e-10])
    found = _joint(("a", "b"), np.array([4e-3] * 4 + [5e-3, 5.1e-3]), covariance, n=1)
    estimate = measurands.of_lag(found, ["a", "b"], degrees_of_freedom=50.0).estimate
    assert estimate.value("time_constant") == pytest.approx(5.02e-3)
    assert estimate.u("time_constant") == pytest.approx(20e-6 / np.sqrt(5))


def test_sums_have_the_covariance_of_what_they_are_made_of():
    """Oracle: by hand; a - b and a + 2 b of correlated numbers."""
    given = Estimate(
        names=("a", "b"), units=("s", "s"), values=np.array([1.0, 2.0]), covariance=np.array([[4.0, 1], [1, 9]])
    )
    found = measurands.mixed(given, {"less": {"a": 1, "b": -1}, "more": {"a": 1, "b": 2}})
    assert found.values.tolist() == [-1, 5]
    np.testing.assert_allclose(found.covariance, [[11, -13], [-13, 44]])


@pytest.mark.parametrize(("u_s", "severity"), [(2.7e-6, "info"), (2.9e-6, "doubt")])
def test_frames_that_confirm_a_length_to_two_u_of_the_middle_leave_no_doubt(u_s, severity):
    """Oracle: the rule by hand; the middle is known to sqrt(2) us: half a length to as much or better adds little."""
    found = _of_window(_window(u_s=u_s), stated_s=240e-6)
    assert [(one.code, one.severity) for one in found.findings] == [("integration-time-on-trust", severity)]
    assert found.not_held == (() if severity == "info" else ("integration time (count_time)",))
    assert not found.midpoint_leads

"""Wheel angle of every trigger from tick streams of a wheel whose angle is known at all times."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.rig import Wheel
from irtiming.reduce.wheel import wheel_angles
from irtiming.reduce.wheel.edge_train import EdgeTrain
from irtiming.reduce.wheel.wheel_angles import frame_trigger_ticks, track

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000
WANDER = ((0.02, 11.0, 0.3), (0.004, 3.1, 2.0))


def _wrong_slots(seed=3):
    regular = TURN * np.arange(100) / 100
    slots = regular + 4e-4 * np.sin(regular + 0.7) + np.random.default_rng(seed).normal(0, 1e-4, 100)
    return slots - np.mean(slots - regular)


def _beside(wheel, found, ticks, delay_s=0.0):
    """Angle found minus true angle, within half a turn."""
    t = (np.asarray(ticks) - wheel.start) / CLOCK_HZ + delay_s
    return np.angle(np.exp(1j * (wheel_angle_rad(delay_s, found, at_ticks=ticks) - wheel.theta(t))))


def _between(recording):
    slots = recording.control_slot_ticks
    return np.sort(np.random.default_rng(0).integers(slots[0], slots[-1], 5000))


@pytest.mark.parametrize("start", [0, 7_000_000, -(2**47), 2**47])
@pytest.mark.parametrize("theta_0", [0.0, 1.0, 3.0, 6.2])
def test_angle_is_right_at_any_tick(paper_wheel, recorded, rig, start, theta_0):
    """Oracle: theta(t) that made the ticks; regular slots, a wheel that wanders by 20 mrad, a counter from anywhere."""
    wheel = paper_wheel(start=start, theta_0=theta_0, wander=WANDER)
    recording = recorded(wheel)
    found = track(recording, rig)
    assert np.abs(_beside(wheel, found, _between(recording))).max() < 3e-6
    assert np.abs(_beside(wheel, found, _between(recording)[:-200], delay_s=0.1)).max() < 3e-6
    assert found.gate_separation_rad == pytest.approx(wheel.gate_separation, abs=2e-6)
    assert found.angular_frequency_rad_per_s == pytest.approx(TURN * 3, rel=1e-3)
    assert found.findings == ()


@pytest.mark.parametrize("theta_0", np.linspace(0, TURN, 7))
def test_learned_slots_remove_what_equal_slots_leave(paper_wheel, recorded, rig, theta_0):
    """Oracle: theta(t) that made the ticks; slots that are wrong by 0.3 mrad rms, starting at any slot."""
    wheel = paper_wheel(theta_0=theta_0, slots=_wrong_slots(), wander=((0.002, 11.0, 0.3),))
    recording = recorded(wheel)
    ticks = _between(recording)
    learned = np.std(_beside(wheel, track(recording, rig), ticks))
    equal = np.std(_beside(wheel, track(recording, rig, slots="equal"), ticks))
    assert learned < 3e-6
    assert 2e-4 < equal < 4e-4
    deviation = track(recording, rig).slot_deviation_rad
    np.testing.assert_allclose(deviation, _wrong_slots() - TURN * np.arange(100) / 100, atol=1e-5)
    assert np.all(track(recording, rig, slots="equal").slot_deviation_rad == 0)


def test_delay_counts_from_the_trigger(paper_wheel, recorded, rig):
    """Oracle: the angle at the same moment, reached once by ticks and once by seconds."""
    wheel = paper_wheel(wander=WANDER)
    recording = recorded(wheel)
    found = track(recording, rig)
    ticks = recording.camera_trigger_ticks
    by_ticks = wheel_angle_rad(0.0, found, at_ticks=ticks + 4_915_200)
    np.testing.assert_allclose(wheel_angle_rad(0.1, found, at_ticks=ticks), by_ticks, atol=1e-9)


@pytest.mark.parametrize("alpha_2", [3.1450, 3.1380])
@pytest.mark.parametrize("theta_0", [0.5, 3.5])
def test_reference_edge_precedes_the_longer_interval(paper_wheel, recorded, rig, alpha_2, theta_0):
    """Oracle: section 2.4; with alpha_2 below pi the longer half turn follows edge 2, which so becomes the zero."""
    wheel = paper_wheel(theta_0=theta_0, edges=(0.0, 1.57, alpha_2, 4.71), gate_separation=0.60)
    zero = 0.0 if alpha_2 > np.pi else alpha_2
    found = track(recorded(wheel), rig)
    ticks = _between(recorded(wheel))
    assert np.abs(np.angle(np.exp(1j * (_beside(wheel, found, ticks) + zero)))).max() < 3e-6
    # the same slot ring as seen from the other edge: 50 slots further, and beside them by what alpha_2 misses pi
    separation = 0.60 if alpha_2 > np.pi else 0.60 + alpha_2 - np.pi
    assert found.gate_separation_rad == pytest.approx(separation, abs=3e-6)


def test_reference_edge_can_be_named(paper_wheel, recorded, rig):
    """Oracle: theta(t); first and second name the two alternating edges, in the order of their first appearance."""
    wheel = paper_wheel(theta_0=1.0)  # edge 2, at theta = 3.14, comes first
    recording = recorded(wheel)
    ticks = _between(recording)
    second = _beside(wheel, track(recording, rig, reference_edge="second"), ticks)
    first = _beside(wheel, track(recording, rig, reference_edge="first"), ticks)
    assert np.abs(second).max() < 3e-6
    assert np.abs(np.angle(np.exp(1j * (first + 3.1421)))).max() < 3e-6


@pytest.mark.parametrize("theta_0", [1.0, 4.0])
def test_a_wander_does_not_hide_the_longer_half_turn(paper_wheel, recorded, rig, theta_0):
    """Oracle: theta(t); half turns differ by 1e-4, and a wander makes either kind scatter by 4e-4."""
    wheel = paper_wheel(edges=(0.0, 1.57, np.pi + 1.5e-4, 4.71), theta_0=theta_0, wander=WANDER, jitter_s=2e-6)
    recording = recorded(wheel)
    ticks = _between(recording)
    assert np.abs(_beside(wheel, track(recording, rig), ticks)).max() < 1e-3  # the other edge is half a turn off


@pytest.mark.parametrize("jitter_s", [0.0, 2e-6])
def test_symmetric_wheel_is_refused_until_the_edge_is_named(paper_wheel, recorded, rig, jitter_s):
    """Oracle: two equal half turns cannot be told apart by anybody, with or without jitter."""
    wheel = paper_wheel(edges=(0.0, 1.57, np.pi, 4.71), jitter_s=jitter_s, rate_hz=3.0)
    recording = recorded(wheel)
    with pytest.raises(ReductionError, match=r"the reference edge cannot be determined; record longer or name it with"):
        track(recording, rig)
    assert track(recording, rig, reference_edge="first").gate_separation_rad == pytest.approx(0.5697, abs=1e-5)


def test_exactly_equal_half_turns_are_refused(paper_wheel, recorded, rig):
    """Oracle: by hand; edges on whole ticks, every half turn 8 192 000 ticks, no scatter at all."""
    recording = replace(
        recorded(paper_wheel()),
        control_slot_ticks=163_840 * np.arange(5000),
        application_slot_ticks=9_000 + 8_192_000 * np.arange(90),
    )
    with pytest.raises(ReductionError, match=r"the reference edge cannot be determined"):
        track(recording, rig)


@pytest.mark.parametrize("separation", [0.10, 0.5697, 0.9, 2.0])
@pytest.mark.parametrize("theta_0", [0.0, 2.0, 5.0])
def test_gate_separation_of_any_rig(paper_wheel, recorded, rig, separation, theta_0):
    """Oracle: the separation that made the ticks, told to the rig only by its whole slots."""
    wheel = paper_wheel(gate_separation=separation, theta_0=theta_0)
    whole = int(separation / (TURN / 100))
    gates = replace(rig.light_gates, whole_slots_between=whole)
    found = track(recorded(wheel), replace(rig, light_gates=gates))
    assert found.gate_separation_rad == pytest.approx(separation, abs=2e-6)
    assert np.abs(_beside(wheel, found, _between(recorded(wheel)))).max() < 3e-6


@pytest.mark.parametrize("beside", [-0.003, 0.003])
@pytest.mark.parametrize("seed", range(4))
def test_a_slot_that_is_made_late_counts_as_the_slot_that_it_is(paper_wheel, recorded, rig, beside, seed):
    """Oracle: the separation that made the ticks, 0.003 slots beside nine of them; slots err by 0.016 of one.

    By the slots' own edges the ninth would count or not as it was made: 63 mrad, a slot's angle.
    """
    pitch = TURN / 100
    slots = pitch * np.arange(100) + np.random.default_rng(seed).normal(0, 1e-3, 100)
    slots -= np.mean(slots - pitch * np.arange(100))
    wheel = paper_wheel(gate_separation=(9 + beside) * pitch, slots=slots, duration_s=4.0)
    gates = replace(rig.light_gates, whole_slots_between=int(9 + beside))
    found = track(recorded(wheel, n_triggers=10), replace(rig, light_gates=gates))
    assert found.gate_separation_rad == pytest.approx(wheel.gate_separation, abs=2e-5)


def test_uncertainty_of_the_separation_is_that_of_a_mean(paper_wheel, recorded, rig):
    """Oracle: by hand; reference edges 300 ticks early and late in turn: their mean has 300 / sqrt(n - 1) ticks, equal slots."""
    n = 6
    edges = 9_000 + 8_192_000 * np.arange(2 * n)
    edges[::2] += np.where(np.arange(n) % 2, 300, -300) - 20_000
    recording = replace(
        recorded(paper_wheel()), control_slot_ticks=163_840 * np.arange(-50, 700), application_slot_ticks=edges
    )
    found = track(recording, rig, slots="equal")
    per_tick = TURN / 16_384_000
    assert found.u_gate_separation_rad == pytest.approx(300 / np.sqrt(n - 1) * per_tick, rel=1e-6)


def test_pulls_of_the_separation_are_standard(paper_wheel, recorded, rig):
    """Oracle: 200 recordings whose 12 edges jitter by 5 us; Student's t with 11 degrees of freedom."""
    pulls = []
    for seed in range(200):
        wheel = paper_wheel(duration_s=4.0, theta_0=0.03 * seed)
        recording = recorded(wheel, n_triggers=10)
        jitter = np.random.default_rng(seed).normal(0, 5e-6 * CLOCK_HZ, recording.application_slot_ticks.size)
        moved = recording.application_slot_ticks + np.rint(jitter).astype(np.int64)
        found = track(replace(recording, application_slot_ticks=moved), rig, slots="equal")
        pulls.append((found.gate_separation_rad - wheel.gate_separation) / found.u_gate_separation_rad)
    assert np.std(pulls) == pytest.approx(np.sqrt(11 / 9), abs=0.15)
    assert abs(np.mean(pulls)) < 0.2


def test_uncertainty_of_the_separation_holds_the_slots(paper_wheel, recorded, rig):
    """Oracle: 120 wheels whose 100 random slot errors have a mean, against edge 0: pulls of the separation spread by 1."""
    pulls = []
    for seed in range(120):
        rng = np.random.default_rng(seed)
        slots = TURN * np.arange(100) / 100 + rng.normal(0, 1e-3, 100)
        found = track(recorded(paper_wheel(slots=slots, duration_s=4.0), n_triggers=10), rig)
        pulls.append((found.gate_separation_rad - 0.5697) / found.u_gate_separation_rad)
    assert np.std(pulls) == pytest.approx(1, abs=0.15)
    assert abs(np.mean(pulls)) < 0.3


def test_missing_doubled_and_spurious_edges_change_no_angle(paper_wheel, recorded, rig):
    """Oracle: theta(t); edges are taken out and put in on both gates, and told."""
    wheel = paper_wheel(wander=WANDER, theta_0=4.0)
    whole = recorded(wheel)
    slots = np.delete(whole.control_slot_ticks, [0, 1, 500, 501, 3000, 10_100])
    slots = np.sort(np.append(slots, [slots[77] + 3000, slots[5000] + 80_000, slots[-1] + 50_000]))
    gate = np.delete(whole.application_slot_ticks, [0, 50])
    gate = np.sort(np.append(gate, [gate[20] + 500]))
    found = track(replace(whole, control_slot_ticks=slots, application_slot_ticks=gate), rig)
    ticks = _between(whole)
    ticks = ticks[(ticks > slots[3]) & (ticks < slots[-3])]
    assert np.abs(_beside(wheel, found, ticks)).max() < 2e-5
    assert found.findings[0].what.startswith("control_slot: 4 edges missing (bridged by interpolation), 3 doubled")
    assert found.findings[1].what.startswith("application_slot: 1 edge missing (bridged by interpolation), 1 doubled")


def test_long_gap_gives_no_angle(paper_wheel, recorded, rig):
    """Oracle: docstring; 3 missing slots are bridged (steps of 4 are not), a gap of 40 slots is nan, the rest is right."""
    wheel = paper_wheel(wander=WANDER)
    whole = recorded(wheel)
    all_slots = whole.control_slot_ticks
    gone = [2000, 2001, *range(3000, 3040)]
    found = track(replace(whole, control_slot_ticks=np.delete(all_slots, gone)), rig)
    angle = wheel_angle_rad(0.0, found, at_ticks=_between(whole))
    ticks = _between(whole)
    in_gap = (ticks > all_slots[2999]) & (ticks < all_slots[3040])
    assert in_gap.sum() > 5
    assert np.all(np.isnan(angle[in_gap]))
    assert np.all(np.isfinite(angle[~in_gap]))
    assert np.abs(_beside(wheel, found, ticks[~in_gap])).max() < 2e-5


def test_triggers_outside_the_edges_have_no_angle(paper_wheel, recorded, rig):
    """Oracle: nobody saw the wheel there."""
    recording = recorded(paper_wheel())
    found = track(recording, rig)
    slots = recording.control_slot_ticks
    angle = wheel_angle_rad(0.0, found, at_ticks=np.array([slots[0] - 1, slots[0], slots[-1], slots[-1] + 1]))
    assert np.isfinite(angle).tolist() == [False, True, True, False]


def test_frames_skip_the_triggers_of_lost_frames(paper_wheel, recorded):
    """Oracle: by hand; frame_number indexes the triggers."""
    recording = replace(recorded(paper_wheel()), frame_number=np.array([0, 1, 4, 999]))
    ticks = frame_trigger_ticks(recording)
    assert ((ticks - ticks[0]) // 1_622_016).tolist() == [0, 1, 4, 999]


@pytest.mark.parametrize("numbers", [[0, 1000], [-1, 5]])
def test_frame_without_trigger_is_refused(paper_wheel, recorded, numbers):
    """Oracle: by hand; 1000 triggers are numbered 0 .. 999."""
    recording = replace(recorded(paper_wheel()), frame_number=np.array(numbers))
    with pytest.raises(ReductionError, match=r"but there are 1000 camera triggers; a frame must belong to a recorded"):
        frame_trigger_ticks(recording)


def test_four_application_edges_are_measured(paper_wheel, recorded, rig):
    """Oracle: the edge angles that made the ticks, with a wheel that wanders and learned slots."""
    wheel = paper_wheel(wander=WANDER, slots=_wrong_slots(), jitter_s=1e-6)
    recording = recorded(wheel)
    found = track(replace(recording, application_edge_ticks=wheel.application_edge_ticks()), rig)
    assert found.application_edges_rad[0] == 0
    np.testing.assert_allclose(found.application_edges_rad, wheel.edges, atol=1.5e-5)
    assert np.all(np.asarray(found.u_application_edges_rad) < 1e-5)
    assert np.all(np.asarray(found.u_application_edges_rad) > 5e-7)
    assert track(recording, rig).application_edges_rad is None


def test_pulls_of_the_application_edges_are_standard(paper_wheel, recorded, rig):
    """Oracle: 150 recordings of 35 turns whose application edges jitter by 5 us; angles of edges 1 to 3 counted from edge 0."""
    wheel = paper_wheel(duration_s=12.0)
    recording, edges = recorded(wheel, n_triggers=10), wheel.application_edge_ticks()
    pulls = []
    for seed in range(150):
        jitter = np.random.default_rng(seed).normal(0, 5e-6 * CLOCK_HZ, edges.size)
        found = track(
            replace(recording, application_edge_ticks=edges + np.rint(jitter).astype(np.int64)), rig, slots="equal"
        )
        off = np.array(found.application_edges_rad[1:]) - wheel.edges[1:]
        pulls.append(off / np.array(found.u_application_edges_rad[1:]))
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.15)
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 0.3)


def test_counterclockwise_rotation_has_the_same_angles(paper_wheel, recorded, rig):
    """Oracle: conventions.md; the drawing is mirrored, the wheel angle still grows with rotation."""
    recording = recorded(paper_wheel(wander=WANDER))
    mirrored = track(recording, replace(rig, wheel=Wheel(rotation="counterclockwise")))
    np.testing.assert_array_equal(mirrored.edge_angle_rad, track(recording, rig).edge_angle_rad)


def test_gates_recorded_at_different_times_are_refused(paper_wheel, recorded, rig):
    """Oracle: by hand; the application gate was recorded a minute later."""
    recording = recorded(paper_wheel())
    late = recording.application_slot_ticks + 60 * CLOCK_HZ
    with pytest.raises(
        ReductionError, match=r"no reference edge lies between the first and the last control-slot edge"
    ):
        track(replace(recording, application_slot_ticks=late), rig)


def test_wrong_number_of_slots_is_refused(paper_wheel, recorded, rig):
    """Oracle: by hand; the ring has 98 slots, so the reference edge moves by two slots a turn."""
    wheel = paper_wheel(slots=TURN * np.arange(98) / 98)
    with pytest.raises(ReductionError, match=r"control slots beside the others.*control_slots is wrong"):
        track(recorded(wheel), rig)


def test_slip_of_one_whole_slot_is_refused(paper_wheel, recorded, rig):
    """Oracle: by hand; from the middle on, all control edges come one slot late: a lost edge that nobody can see."""
    recording = recorded(paper_wheel())
    slots = recording.control_slot_ticks.copy()
    slots[5000:] += np.linspace(0, 163_840, 30).astype(np.int64)[np.minimum(np.arange(slots.size - 5000), 29)]
    with pytest.raises(ReductionError, match=r"an edge was lost or added where it cannot be traced"):
        track(replace(recording, control_slot_ticks=slots), rig)


def test_too_few_half_turns_are_refused(paper_wheel, recorded, rig):
    """Oracle: by hand; of 8 edges, four missing in between leave no second interval of each kind."""
    recording = recorded(paper_wheel())
    few = recording.application_slot_ticks[:5]
    with pytest.raises(ReductionError, match=r"application_slot holds 5 edges, at least 8 are needed"):
        track(replace(recording, application_slot_ticks=few), rig)


def test_the_scatter_of_half_turns_is_that_of_neighbours():
    """Oracle: the double sum over pairs of half turns at most four apart, of weight 1 - distance / 5, written out."""
    half_turns = 8_192_000 + np.random.default_rng(3).integers(-3000, 3001, 39)
    sign = np.where(np.arange(1, 38) % 2 == 0, 1.0, -1.0)
    longer = sign * (half_turns[1:-1] - (half_turns[:-2] + half_turns[2:]) / 2)
    off, total = longer - longer.mean(), 0.0
    for a in range(37):
        for b in range(37):
            total += max(0.0, 1 - abs(a - b) / 5) * off[a] * off[b]
    train = EdgeTrain(ticks=np.append(0, np.cumsum(half_turns)), number=np.arange(40), n_missing=0, n_spurious=0)
    with pytest.raises(ReductionError, match=rf"uncertainties \({np.sqrt(total) / 36:.0f} ticks\)"):
        wheel_angles._reference_edges(train, "automatic")


def test_long_gaps_are_broken_in_their_middle():
    """Oracle: by hand; gaps of ten slots right after the first edge and before the last, one of three that is bridged."""
    control = SimpleNamespace(ticks=np.array([0, 1000, 1100, 1400, 2400]), number=np.array([0, 10, 11, 14, 24]))
    ticks, angle = wheel_angles._break_long_gaps(control, np.arange(5.0))
    assert ticks.tolist() == [0, 500, 1000, 1100, 1400, 1900, 2400]
    np.testing.assert_array_equal(angle, [0, np.nan, 1, 2, 3, np.nan, 4])


@pytest.mark.parametrize(("n_edges", "known"), [(8, True), (7, False)])
def test_each_of_the_four_edges_must_pass_twice(n_edges, known):
    """Oracle: by hand; the wheel turns by a quarter a thousand ticks; two turns of edges, or one edge less."""
    recording = SimpleNamespace(application_edge_ticks=1000 * np.arange(1, n_edges + 1))
    ticks = np.array([0, 10_000])
    found = wheel_angles._application_edges(recording, ticks, ticks / 1000 * TURN / 4)
    assert [one is not None for one in found] == [known, known]

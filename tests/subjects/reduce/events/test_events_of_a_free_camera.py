"""Events of a camera that runs free against the times at which the twin made them, and against hand-made recordings."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.inference import stamp_line
from irtiming.reduce.events import clocks, placing
from irtiming.twin import free_camera
from irtiming.twin import rig as twin
from irtiming.twin.clockwork import first_trigger_ticks
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.scene import Faults, paper_scene, with_wheel_speed

BASE = with_wheel_speed(paper_scene(32, 40), 3.0, samples=200)


def _recorded(free, *, seed=1, lost=7):
    """Recording whose frames nobody makes, and the true moments at which its frames began, s from the twin's zero."""
    scene = replace(BASE, free=free, faults=Faults(lost_frames=lost))
    run = twin.simulate(scene, seed=seed)
    return run, free_camera.begun_s(scene.trigger, free, number=run.frame_number)


def _event_s(placed):
    """Time of each frame's event, s from the twin's zero."""
    ticks = placed.camera_trigger_ticks[placed.frame_number] - first_trigger_ticks(BASE.trigger)
    return ticks / BASE.trigger.clock_frequency_hz


def _codes(placed):
    return [one.code for one in placed.events.findings]


def test_each_frame_gets_its_own_strobe_edge_though_frames_are_lost():
    """Oracle: when the twin's camera began each frame; the strobe comes 600 us later with 0.1 us of jitter."""
    run, begun_s = _recorded(FreeRunning(event="strobe"))
    placed = placing.placed(run)
    assert np.abs(_event_s(placed) - begun_s - 600e-6).max() < 0.6e-6
    assert _codes(placed) == ["strobe-pairing"]
    assert placed.events.period_s == pytest.approx(float(np.median(np.diff(begun_s))), rel=1e-8)
    assert 0.08e-6 < np.std(placed.events.deviation_s) < 0.12e-6
    assert placing.placed(placed) is placed


def test_edges_before_and_after_the_recording_leave_whole_periods_open():
    """Oracle: the same; frames arrive within a period after their strobe, which chooses the right edge but proves nothing."""
    run, begun_s = _recorded(FreeRunning(event="strobe", frames_before=3, frames_after=2))
    placed = placing.placed(run)
    assert np.abs(_event_s(placed) - begun_s - 600e-6).max() < 0.6e-6
    assert _codes(placed) == ["strobe-pairing-ambiguous"]
    blind = placing.placed(replace(run, frame_host_time_s=None))
    periods = (_event_s(blind) - begun_s - 600e-6) / blind.events.period_s
    assert np.allclose(periods, -3, atol=1e-4)  # the first edge, three frames early
    assert _codes(blind) == ["strobe-pairing-ambiguous"]


def test_an_irregular_camera_proves_its_pairing_by_its_stamps():
    """Oracle: frames whose period wanders by 40 us, as strobe and stamps both saw; edge 4 is the first frame's."""
    run, _ = _recorded(FreeRunning(event="strobe"), lost=0)
    random = np.random.default_rng(5)
    began_s = np.cumsum(33e-3 + 40e-6 * random.standard_normal(209))
    edges = np.rint(began_s * run.clock_frequency_hz).astype(np.int64)
    seen = began_s[4:204] + 10e-6 * random.standard_normal(200)
    irregular = replace(
        run,
        camera_input_ticks=edges,
        frame_timestamp_ticks=np.rint(seen * 125e6 * (1 + 30e-6)).astype(np.int64),
        frame_id=None,
        frame_host_time_s=None,
    )
    placed = placing.placed(irregular)
    assert _codes(placed) == ["strobe-pairing"]
    assert placed.camera_trigger_ticks[0] == edges[4]


def test_a_strobe_that_cannot_be_paired_is_refused():
    """Oracle: hand-made cases: fewer edges than frames; more, with nothing that counts frames; no edges."""
    run, _ = _recorded(FreeRunning(event="strobe"), lost=0)
    unknown = {"frame_id": None, "frame_timestamp_ticks": None, "frame_host_time_s": None}
    edges = run.camera_input_ticks
    for change, words in (
        ({"camera_input_ticks": edges[5:]}, "edges of 195 frames, but the camera made 200"),
        ({"camera_input_ticks": np.append(edges, edges[-1] + 1_600_000), **unknown}, "nothing shows which frames were"),
        ({"camera_input_ticks": edges[:3]}, "holds 3 edges"),
    ):
        with pytest.raises(ReductionError, match=words):
            placing.placed(replace(run, **change))


def test_events_that_are_no_train_are_refused_in_words_of_a_camera():
    """Oracle: hand-made cases: strobes at random, a stamp and an arrival that are missing, an exchange that never ended."""
    strobe, stamp, arrival = (
        _recorded(FreeRunning(event=event), lost=0)[0] for event in ("strobe", "stamp", "arrival")
    )
    random = np.random.default_rng(1)
    edges = np.sort(random.integers(0, 2**32, 200))
    gone = np.where(np.arange(200) == 17, 0, stamp.frame_timestamp_ticks)
    never = np.where(np.arange(200) == 5, np.nan, arrival.frame_host_time_s)
    endless = arrival.counter_exchange_after_s.copy()
    endless[3] = np.inf
    for run, change, words in (
        (strobe, {"camera_input_ticks": edges}, "camera_input have no steady rhythm"),
        (stamp, {"frame_timestamp_ticks": gone}, "frame 17 is 0, unknown"),
        (arrival, {"frame_host_time_s": never}, "frame 5 is no number"),
        (arrival, {"counter_exchange_after_s": endless}, "the counter has a time that is no number"),
        (arrival, {"frame_host_time_s": np.sort(random.uniform(1e4, 1e4 + 9, 200))}, "further than .* from a grid"),
    ):
        with pytest.raises(ReductionError, match=words):
            placing.placed(replace(run, **change))


@pytest.mark.parametrize("event", ["stamp", "arrival"])
def test_the_grid_lies_at_the_median_of_stamps_and_arrivals(event):
    """Oracle: the twin's times, and the median of the latency's distribution by root finding: within 3.5 u, 1 chance in 2000."""
    free = FreeRunning(event=event)
    run, begun_s = _recorded(free)
    placed = placing.placed(run)
    usual_s = free.stamp_after_s if event == "stamp" else free_camera.usual_latency_s(free)
    off_s = float(np.mean(_event_s(placed) - begun_s - usual_s))
    u_s = np.hypot(placed.events.u_grid_s, placed.events.u_clock_s)
    assert abs(off_s) < 3.5 * u_s
    assert u_s < 100e-6
    rate = (1 + (free.rate_error if event == "stamp" else free.computer_rate_error)) - 1
    assert placed.events.relative_rate == pytest.approx(rate, abs=20e-6)
    assert _codes(placed) == ["event-grid"]


def test_stamps_without_a_way_to_the_counter_are_refused():
    """Oracle: hand-made: without exchanges of the camera, or of the counter, no time can be told."""
    run, _ = _recorded(FreeRunning(event="stamp"))
    with pytest.raises(ReductionError, match="camera's own clock"):
        placing.placed(replace(run, camera_exchange_ticks=None))
    with pytest.raises(ReductionError, match="nothing relates the computer's clock to the counter"):
        placing.placed(replace(run, counter_exchange_ticks=None))
    names = ("counter_exchange_before_s", "counter_exchange_ticks", "counter_exchange_after_s")
    one = {name: getattr(run, name)[:1] for name in names}
    with pytest.raises(ReductionError, match="at least 2"):
        placing.placed(replace(run, **one))


def test_stamps_of_the_computers_clock_need_no_exchange_with_the_camera():
    """Oracle: the same stamps rewritten in the computer's nanoseconds since 1970, where doubles have lost their last digits."""
    free = FreeRunning(event="stamp", computer_zero_s=1.7e9)
    run, begun_s = _recorded(free, lost=0)
    exact = begun_s + free.stamp_after_s
    ns = (exact * (1 + free.computer_rate_error) * 1e9).astype(np.int64) + 1_700_000_000 * 10**9
    placed = placing.placed(
        replace(
            run,
            timestamp_clock="computer",
            frame_timestamp_ticks=ns,
            timestamp_frequency_hz=1e9,
            camera_exchange_ticks=None,
        )
    )
    assert abs(float(np.mean(_event_s(placed) - exact))) < 3.5 * placed.events.u_clock_s


def test_no_exchange_ever_contradicts_its_bounds():
    """Oracle: brute force over lines on a grid: those that pass between all bounds, and the truth among them."""
    random = np.random.default_rng(3)
    for _ in range(20):
        reading = np.sort(random.uniform(0, 10, 12))
        rate, offset = random.normal(0, 20e-6), random.normal(0, 1e-3)
        true = reading + offset + rate * (reading - 5.0)
        before, after = true - random.exponential(80e-6, 12), true + random.exponential(80e-6, 12)
        found = clocks.relation(reading, before_s=before, after_s=after, name="a clock", middle_s=5.0)
        slopes = rate + np.linspace(-60e-6, 60e-6, 2001)[:, None]
        low = np.max(before - reading - slopes * (reading - 5.0), axis=1)
        high = np.min(after - reading - slopes * (reading - 5.0), axis=1)
        passes = high >= low
        least, most = low[passes].min(), high[passes].max()
        assert found.offset_s == pytest.approx((least + most) / 2, abs=0.5e-6)
        assert found.u_offset_s * np.sqrt(3) == pytest.approx((most - least) / 2, abs=0.5e-6)
        evenly = np.linspace(slopes[passes].min(), slopes[passes].max(), 1001)
        assert found.u_rate == pytest.approx(np.sqrt(np.mean((evenly - found.rate) ** 2)), abs=0.1e-6)
        assert least <= offset <= most
        assert found.slack_s == 0
        assert found.reading_s(found.computer_s(reading)) == pytest.approx(reading, abs=1e-12)


def test_exchanges_that_disagree_are_said_aloud():
    """Oracle: hand-made: three exchanges of 10 us with a clock that jumps by 1 ms; a line misses one of them by 0.5 ms."""
    reading = np.array([0.0, 5.0, 10.0])
    middle = reading + np.array([0.0, 1e-3, 0.0])
    found = clocks.relation(reading, before_s=middle - 5e-6, after_s=middle + 5e-6, name="a clock")
    assert found.slack_s == pytest.approx(0.495e-3, abs=2e-6)
    assert found.u_offset_s >= found.slack_s


def test_the_u_of_a_grid_is_that_of_its_scatter():
    """Oracle: 100 grids of arrivals with a long tail, whose median is known: their pulls scatter by 1."""
    random = np.random.default_rng(11)
    number, pulls = np.arange(250), []
    for _ in range(100):
        late = random.gamma(2.0, 0.4e-3, 250) + np.where(random.random(250) < 0.02, random.uniform(0, 20e-3, 250), 0)
        found = stamp_line.grid(number, 0.1 + 33e-3 * number + late)
        late_s = found.at_middle_s - 0.1 - 33e-3 * found.middle
        pulls.append((late_s - free_camera.usual_latency_s(FreeRunning(arrival_shortest_s=0.0))) / found.u_at_middle_s)
    assert 0.7 < np.std(pulls) < 1.15
    assert abs(np.mean(pulls)) < 0.3


def test_of_many_exchanges_the_slowest_have_no_say():
    """Oracle: by hand; 2000 exchanges of 20 us about a clock 3 ms ahead, and one of 1 ms that contradicts them by 4 ms."""
    reading = np.linspace(0.0, 10.0, 2001)
    before, after = reading + 3e-3 - 10e-6, reading + 3e-3 + 10e-6
    before[700], after[700] = reading[700] + 7e-3, reading[700] + 8e-3
    found = clocks.relation(reading, before_s=before, after_s=after, name="a clock")
    assert found.slack_s == 0
    assert found.offset_s == pytest.approx(3e-3, abs=1e-8)


def test_the_clock_s_part_is_that_of_the_middle_of_the_frames():
    """Oracle: the relation of both clocks, asked for there: the longer away from the exchanges, the less is known of it."""
    run, _ = _recorded(FreeRunning(event="arrival"), lost=0)
    placed = placing.placed(run)
    middle = (placed.camera_trigger_ticks[0] + placed.camera_trigger_ticks[-1]) / 2 - clocks.zeros(run).counter_ticks
    there, away = (clocks.of_counter(run, middle_s=k * middle / run.clock_frequency_hz).u_offset_s for k in (1, 2))
    assert placed.events.u_clock_s == pytest.approx(there, rel=1e-3)
    assert away > 1.1 * there

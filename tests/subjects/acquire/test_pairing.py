"""Which trigger made which frame: every way in which the two can fall apart."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.acquire.pairing import Pairing
from irtiming.records.camera_frame import CameraFrame
from irtiming.records.timestamps import Timestamps

CLOCK_HZ = 1_000_000
PERIOD_TICKS = 10_000
PERIOD_S = PERIOD_TICKS / CLOCK_HZ
LATENCY_S = 0.004
NONE = np.empty(0, np.int64)


def _timestamps(n_triggers, lost=NONE):
    ticks = 500_000 + PERIOD_TICKS * np.arange(n_triggers)
    return Timestamps(
        clock_frequency_hz=CLOCK_HZ,
        camera_trigger_ticks=ticks,
        camera_trigger_delayed_ticks=ticks,
        control_slot_ticks=NONE,
        application_slot_ticks=NONE,
        application_edge_ticks=NONE,
        camera_input_ticks=NONE,
        spare_ticks=NONE,
        lost_after_ticks=lost,
    )


def _frame(frame_id, made_at, *, device_hz=1e6, latency_s=LATENCY_S, clock_error=0.0):
    """Frame that trigger number ``made_at`` made; a half number is between two triggers."""
    time_s = made_at * PERIOD_S
    return CameraFrame(
        pixels=np.zeros((1, 1), np.uint16),
        frame_id=frame_id,
        device_timestamp_ticks=round(time_s * (1 + clock_error) * device_hz) + 99 if device_hz else 0,
        host_time_s=0.5 + time_s + latency_s,
    )


def _judged(made_at, *, n_triggers, ids=None, usual=None, **about):
    """Numbers that frames of these triggers got, and the verdict."""
    pairing = Pairing(period_s=PERIOD_S, n_triggers=n_triggers, device_frequency_hz=about.get("device_hz", 1e6))
    places = [pairing.take(_frame(i, at, **about)) for i, at in zip(ids or range(len(made_at)), made_at, strict=True)]
    verdict = pairing.judge(
        _timestamps(n_triggers), earliest_s=lambda ticks: ticks / CLOCK_HZ, speed=1.0, usual_latency_s=usual
    )
    return [place and place.number for place in places], verdict


@pytest.mark.parametrize("device_hz", [1e6, 1e9, 0])
def test_as_many_frames_as_triggers_are_trusted(device_hz):
    """Oracle: frame k of trigger k, and the latency that they were made with."""
    numbers, verdict = _judged(list(range(40)), n_triggers=40, device_hz=device_hz)
    assert numbers == list(range(40))
    assert verdict.is_trusted
    assert (verdict.frames, verdict.lost, verdict.missed, verdict.findings) == (40, 0, 0, ())
    assert verdict.latency_s == pytest.approx(LATENCY_S)


@pytest.mark.parametrize("device_hz", [1e6, 0])
def test_a_gap_in_the_identifiers_is_a_lost_frame(device_hz):
    """Oracle: by hand, triggers 3 and 4 made frames 3 and 4 that did not come."""
    made = [k for k in range(20) if k not in (3, 4)]
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=device_hz)
    places = [pairing.take(_frame(k, k, device_hz=device_hz)) for k in made]
    assert [place.number for place in places] == made
    assert places[3].lost_numbers == places[3].lost_ids == (3, 4)
    verdict = pairing.judge(_timestamps(20), earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert verdict.is_trusted
    assert (verdict.frames, verdict.lost, verdict.missed) == (18, 2, 0)


def test_the_first_frames_may_be_lost():
    """Oracle: by hand, the first frame that comes says that it is the third."""
    numbers, verdict = _judged(list(range(2, 20)), ids=list(range(2, 20)), n_triggers=20)
    assert numbers == list(range(2, 20))
    assert verdict.is_trusted
    assert verdict.lost == 2


def test_a_missed_trigger_moves_the_numbers_after_it():
    """Oracle: by hand, trigger 7 made no frame; the camera's identifiers know nothing of it."""
    made = [k for k in range(20) if k != 7]
    numbers, verdict = _judged(made, n_triggers=20)
    assert numbers == made
    assert verdict.is_trusted
    assert (verdict.lost, verdict.missed) == (0, 1)
    assert ("triggers-without-frame", "1 trigger made no frame") in [(f.code, f.what) for f in verdict.findings]


def test_a_missed_trigger_beside_a_lost_frame():
    """Oracle: by hand, of triggers 7 and 8 one made no frame and the other's was lost."""
    made = [k for k in range(20) if k not in (7, 8)]
    ids = [k if k < 7 else k - 1 for k in made]
    numbers, verdict = _judged(made, ids=ids, n_triggers=20)
    assert numbers == made
    assert verdict.is_trusted
    assert (verdict.lost, verdict.missed) == (1, 1)


def test_a_missed_trigger_of_a_camera_without_clock_is_not_trusted():
    """Oracle: 19 frames for 20 triggers; those after the seventh come a period late by their count."""
    made = [k for k in range(64) if k != 7]
    _, verdict = _judged(made, n_triggers=64, device_hz=0)
    assert not verdict.is_trusted
    assert "the camera has no clock to tell" in verdict.reasons[0]


def test_a_missed_and_an_extra_frame_do_not_cancel():
    """Oracle: as many frames as triggers, but 30 of them a period late."""
    made = [k if k < 20 else k + 1 if k < 49 else 49.5 if k == 49 else k for k in range(64)]
    for device_hz in (1e6, 0):
        _, verdict = _judged(made, n_triggers=64, device_hz=device_hz)
        assert not verdict.is_trusted


@pytest.mark.parametrize("at", [0.5, 7.5, 7.1])
def test_a_frame_that_no_trigger_made_is_not_trusted(at):
    """Oracle: a frame within a period of another."""
    made = sorted([*range(20), at])
    _, verdict = _judged(made, n_triggers=20)
    assert not verdict.is_trusted
    assert "the camera makes frames without triggers" in verdict.reasons[0]


def test_one_frame_too_many_is_not_trusted():
    """Oracle: 21 frames a period apart for 20 triggers."""
    _, verdict = _judged(list(range(21)), n_triggers=20)
    assert "a frame more than the 20 triggers came" in verdict.reasons[0]


def test_a_free_running_camera_of_another_rate_is_not_trusted():
    """Oracle: a frame every 0.7 periods."""
    _, verdict = _judged([0.7 * k for k in range(20)], n_triggers=20)
    assert not verdict.is_trusted


def test_a_last_trigger_without_frame_is_known_by_the_arrivals():
    """Oracle: the frames came 4 ms after their triggers, before the next: no later trigger can have made them."""
    numbers, verdict = _judged(list(range(19)), n_triggers=20)
    assert numbers == list(range(19))
    assert verdict.is_trusted
    assert ("last-triggers-without-frame", "no frame came for the last 1 trigger") in [
        (f.code, f.what) for f in verdict.findings
    ]


def test_a_first_trigger_without_frame_is_not_trusted():
    """Oracle: 19 frames of triggers 1 to 19 look a period late if the first is taken for that of trigger 0."""
    _, verdict = _judged(list(range(1, 20)), n_triggers=20)
    assert not verdict.is_trusted
    assert "which were missed cannot be determined" in verdict.reasons[0]


def test_a_slow_camera_is_known_by_its_usual_latency():
    """Oracle: 23 ms are more than two periods; only who knows them can tell that the last trigger has no frame."""
    made = list(range(19))
    assert not _judged(made, n_triggers=20, latency_s=0.023)[1].is_trusted
    assert _judged(made, n_triggers=20, latency_s=0.023, usual=0.0228)[1].is_trusted
    assert not _judged([k + 1 for k in made], n_triggers=20, latency_s=0.023, usual=0.0228)[1].is_trusted


def test_a_clock_that_stands_counts_as_none():
    """Oracle: a camera whose timestamps are all alike."""
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=1e6)
    for k in range(20):
        pairing.take(_frame(k, k, device_hz=1))
    verdict = pairing.judge(_timestamps(20), earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert verdict.is_trusted


@pytest.mark.parametrize(("error", "n"), [(0.01, 20), (-0.01, 20), (0.01, 3)])
def test_a_clock_of_another_rate_is_told(error, n):
    """Oracle: 1 % fast or slow, by construction; three frames are the fewest that can lie on a line."""
    _, verdict = _judged(list(range(n)), n_triggers=n, clock_error=error)
    assert verdict.is_trusted
    assert f"the camera's clock runs {error:+.2%} against" in verdict.findings[-1].sentence()


@pytest.mark.parametrize("device_hz", [1e6, 0])
def test_a_camera_that_goes_on_by_itself_after_its_first_trigger_is_not_trusted(device_hz):
    """Oracle: a rate 0.2 % off: after 500 frames a period less, and every count is as it should be."""
    _, verdict = _judged([0.998 * k + 0.5 for k in range(500)], n_triggers=500, device_hz=device_hz)
    assert not verdict.is_trusted
    assert "does not wait for its triggers" in verdict.reasons[-1]


def test_identifiers_that_go_back_are_not_trusted():
    """Oracle: 0, 1, 1."""
    numbers, verdict = _judged([0, 1, 2], ids=[0, 1, 1], n_triggers=3)
    assert numbers == [0, 1, None]
    assert "frame 1 came after frame 1" in verdict.reasons[0]


def test_of_many_reasons_the_first_three_are_kept():
    """Oracle: by hand; nine frames after the last trigger's, each of which would be a reason."""
    _, verdict = _judged(list(range(10)), n_triggers=10, ids=[9, *range(9)])
    assert len(verdict.reasons) == 3
    assert "frame 0 came after frame 9" in verdict.reasons[0]


def test_an_identifier_out_of_all_proportion_makes_no_blanks():
    """Oracle: a counter that wrapped wrongly would ask for 65 000 blank frames."""
    numbers, verdict = _judged([0, 1], ids=[0, 65_000], n_triggers=20)
    assert numbers == [0, None]
    assert not verdict.is_trusted


@pytest.mark.parametrize(("last", "number"), [(39, 39), (40, None)])
def test_an_identifier_may_run_to_twice_the_triggers(last, number):
    """Oracle: the limit; of 20 triggers as many again may have been lost, and no more are told by name."""
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=0)
    pairing.take(_frame(0, 0, device_hz=0))
    place = pairing.take(_frame(last, last, device_hz=0))
    assert (place and place.number) == number
    assert place is None or len(place.lost_ids) == 38


@pytest.mark.parametrize(("beside", "trusted"), [(0.45, True), (-0.45, True), (0.6, False), (-0.6, False)])
def test_a_usual_latency_holds_within_half_a_period(beside, trusted):
    """Oracle: by hand; further off, the frames could be those of the next triggers, or of the ones before."""
    usual = 0.023 + beside * PERIOD_S
    assert _judged(list(range(19)), n_triggers=20, latency_s=0.023, usual=usual)[1].is_trusted is trusted


@pytest.mark.parametrize(("speed", "drift_s", "trusted"), [(10.0, 3e-3, True), (10.0, 9e-3, False), (1.0, 3e-3, True)])
def test_what_a_computer_may_come_late_is_its_own_time(speed, drift_s, trusted):
    """Oracle: by hand; 5 ms of the computer are 50 ms of a rig that runs ten times as fast. The camera's clock is 2 % off."""
    n = 1000
    pairing = Pairing(period_s=PERIOD_S, n_triggers=n, device_frequency_hz=1e6)
    for k in range(n):
        frame = _frame(k, k, clock_error=0.02)
        late = drift_s * (k >= n // 2)
        pairing.take(replace(frame, host_time_s=(0.5 + k * PERIOD_S + LATENCY_S) / speed + late))
    verdict = pairing.judge(
        _timestamps(n), earliest_s=lambda ticks: ticks / CLOCK_HZ / speed, speed=speed, usual_latency_s=None
    )
    assert verdict.is_trusted is trusted


def test_no_frame_at_all():
    """Oracle: the words."""
    _, verdict = _judged([], n_triggers=20)
    assert "no frame came for 20 triggers" in verdict.reasons[0]


def test_of_thousand_random_faults_none_passes_silently():
    """Oracle: the trigger that truly made each frame, or is nearest to it where none did.

    What is trusted has it, whatever was lost, missed or made too much: within a fiftieth of a period by the camera's clock, a
    half by arrivals.
    """
    random = np.random.default_rng(7)
    trusted = 0
    for _ in range(1000):
        n = 48
        missed = set(random.choice(n, random.integers(0, 4), replace=False).tolist())
        extra = set((random.choice(n, random.integers(0, 2), replace=False) + random.uniform(0.05, 0.95)).tolist())
        events = sorted([*(set(range(n)) - missed), *extra])
        lost = set(random.choice(len(events), random.integers(0, 3), replace=False).tolist())
        come = [(i, at) for i, at in enumerate(events) if i not in lost]
        about = {"latency_s": random.choice([0.004, 0.013, 0.03]), "device_hz": random.choice([0, 1e6])}
        numbers, verdict = _judged([at for _, at in come], ids=[i for i, _ in come], n_triggers=n, **about)
        if verdict.is_trusted:
            trusted += 1
            off = np.abs(np.array(numbers) - [at for _, at in come])
            assert off.max() <= (0.03 if about["device_hz"] else 0.5)
    assert trusted > 200


@pytest.mark.parametrize("untimed", [0, 7, 19])
def test_a_frame_that_came_without_its_first_packet_has_its_place_by_its_identifier(untimed):
    """Oracle: by hand; the packet that says when the frame was made is lost, trigger 12 made no frame."""
    made = [k for k in range(20) if k != 12]
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=1e6)
    frames = [_frame(i, at) for i, at in enumerate(made)]
    frames = [
        replace(frame, device_timestamp_ticks=0, packets_missing=1) if at == untimed else frame
        for at, frame in zip(made, frames, strict=True)
    ]
    assert [pairing.take(frame).number for frame in frames] == made
    verdict = pairing.judge(_timestamps(20), earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert verdict.is_trusted
    assert verdict.missed == 1


def test_a_clock_that_stops_in_the_middle_proves_nothing():
    """Oracle: from frame 30 on its time is 0 though all of it came; trigger 40 made none, so later ones are a period late."""
    pairing = Pairing(period_s=PERIOD_S, n_triggers=64, device_frequency_hz=1e6)
    for i, at in enumerate(k for k in range(64) if k != 40):
        frame = _frame(i, at)
        pairing.take(frame if i < 30 else replace(frame, device_timestamp_ticks=0))
    verdict = pairing.judge(_timestamps(64), earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert "the camera has no clock to tell" in verdict.reasons[0]


def test_frames_are_not_trusted_where_timestamps_were_lost():
    """Oracle: which trigger is the fifth cannot be said where one may be missing before it."""
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=1e6)
    for k in range(20):
        pairing.take(_frame(k, k))
    lost = _timestamps(20, lost=np.array([520_000]))
    verdict = pairing.judge(lost, earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert verdict.reasons == ("timestamps were lost at 1 place; check the trigger generator's line",)
    assert verdict.latency_s is None


def test_frames_that_a_busy_computer_takes_have_no_usual_latency():
    """Oracle: every third comes 8 ms late where the period is 10 ms: their median is near the usual, and proves nothing."""
    made = list(range(19))
    pairing = Pairing(period_s=PERIOD_S, n_triggers=20, device_frequency_hz=1e6)
    for k in made:
        pairing.take(_frame(k, k, latency_s=0.023 + 0.008 * (k % 3 == 0)))
    verdict = pairing.judge(_timestamps(20), earliest_s=lambda t: t / CLOCK_HZ, speed=1.0, usual_latency_s=0.0228)
    assert "which were missed cannot be determined" in verdict.reasons[0]
    assert verdict.latency_s is None


@pytest.mark.parametrize(("share", "trusted"), [(0.11, True), (0.14, False)])
def test_latencies_of_the_first_and_the_last_quarter_are_compared(share, trusted):
    """Oracle: by hand; the median of a quarter counts what lasts for an eighth of the run, and nothing shorter."""
    n = 1000
    pairing = Pairing(period_s=PERIOD_S, n_triggers=n, device_frequency_hz=1e6)
    for k in range(n):
        frame = _frame(k, k, clock_error=0.02)
        pairing.take(replace(frame, host_time_s=frame.host_time_s + 9e-3 * (k >= (1 - share) * n)))
    verdict = pairing.judge(_timestamps(n), earliest_s=lambda ticks: ticks / CLOCK_HZ, speed=1.0, usual_latency_s=None)
    assert verdict.is_trusted is trusted

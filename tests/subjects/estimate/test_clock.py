"""The clock against pulses: ticks by hand, and draws with known error and noise."""

import math

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import clock
from irtiming.physics.clock_rate import allan_deviation, camera_clock, line, pulse_train

CLOCK_HZ = 49_152_000


def _checked(ticks, **options):
    return clock.estimate(np.asarray(ticks, np.int64), name="x", clock_frequency_hz=CLOCK_HZ, **options)


def _stamped(error, rng, *, n=34, jitter_s=50e-9):
    true_s = np.arange(n) + rng.uniform() + rng.normal(0, jitter_s, n)
    return np.floor(true_s * CLOCK_HZ * (1 + error)).astype(np.int64) + 10**12


def test_a_clock_of_a_hundred_ticks_more_per_second():
    """Oracle: by hand; 49 152 100 ticks per true second are (49 152 100 - 49 152 000) / 49 152 000 = 2.0345e-6."""
    found = _checked(7 + 49_152_100 * np.arange(20))
    assert found.relative_error.value == pytest.approx(100 / 49_152_000, abs=1e-12)
    assert found.drift_per_s.value == pytest.approx(0, abs=1e-12)
    assert found.missing_s == found.extra_s == () == found.findings


def test_pulses_of_another_period():
    """Oracle: by hand; ten pulses a second of a clock that is right."""
    assert _checked(4_915_200 * np.arange(40), pulse_period_s=0.1).relative_error.value == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("drift_per_s", [1e-8, -1e-8])
def test_a_steady_drift_is_found_and_the_error_is_that_of_the_middle(drift_per_s):
    """Oracle: by hand; ticks of f (t + e t + d t^2 / 2) have the error e + d t_middle in the middle, and drift d."""
    t = np.arange(101.0)
    ticks = np.rint(CLOCK_HZ * (t + 5e-6 * t + drift_per_s * t**2 / 2))
    found = _checked(ticks)
    assert found.relative_error.value == pytest.approx(5e-6 + drift_per_s * 50, abs=2e-9)
    assert found.drift_per_s.value == pytest.approx(drift_per_s, rel=1e-3)
    assert [one.code for one in found.findings] == ["clock-drifts"]


def test_missing_and_extra_pulses_are_named():
    """Oracle: pulses 5 and 17 were taken out; an echo of pulse 9 and a stray at 3.2 s were put in, both since the first pulse."""
    first = 10**12
    ticks = first + np.rint(CLOCK_HZ * (1 + 2e-5) * np.arange(30)).astype(np.int64)
    stray = first + int(3.2 * CLOCK_HZ)
    found = _checked(np.sort([*np.delete(ticks, [5, 17]), ticks[9] + 400, stray]))
    assert found.missing_s == (5.0, 17.0)
    assert found.extra_s == pytest.approx((3.2, 9.0), abs=1e-3)
    assert found.relative_error.value == pytest.approx(2e-5, abs=1e-9)
    assert [one.code for one in found.findings] == ["pulses-missing", "pulses-extra"]


def test_a_clock_that_cannot_be_a_crystal_is_doubted():
    """Oracle: 300 ppm; crystals are within 100 ppm."""
    assert [one.code for one in _checked(np.rint(CLOCK_HZ * (1 + 3e-4) * np.arange(30))).findings] == ["clock-far-off"]


@pytest.mark.parametrize("ticks", [[], [5, 10], np.arange(30) * 30_000_000])
def test_what_is_no_pulse_per_second_is_refused(ticks):
    """Oracle: no pulses, two of them, or a period that is 0.61 s by the clock."""
    with pytest.raises(EstimationError, match="spare input|ticks apart"):
        _checked(ticks)


def test_uncertainty_of_error_and_drift_covers():
    """Oracle: 200 draws of known error and noise; (found - true) / u has rms 1 +- 0.15, of the error and of the drift."""
    rng = np.random.default_rng(5)
    pulls, drifts = [], []
    for _ in range(200):
        error = rng.uniform(-60e-6, 60e-6)
        found = _checked(_stamped(error, rng))
        pulls.append((found.relative_error.value - error) / found.relative_error.standard_uncertainty)
        drifts.append(found.drift_per_s.value / found.drift_per_s.standard_uncertainty)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.15)
    assert np.sqrt(np.mean(np.square(drifts))) == pytest.approx(1, abs=0.15)


def test_recordings_that_agree_share_their_mean_and_others_are_as_uncertain_as_they_scatter():
    """Oracle: by hand; u / sqrt(3) for three that agree, the standard deviation of 1, 2 and 3 ppm, 1 ppm, for others."""
    rng = np.random.default_rng(6)
    same = [_checked(_stamped(1e-6, rng)) for _ in range(3)]
    assert clock.combined(same).relative_error.standard_uncertainty == pytest.approx(
        np.mean([one.relative_error.standard_uncertainty for one in same]) / math.sqrt(3), rel=0.1
    )
    moved = [_checked(_stamped(ppm * 1e-6, rng)) for ppm in (1, 2, 3)]
    assert clock.combined(moved).relative_error.standard_uncertainty == pytest.approx(1e-6, rel=0.01)
    assert clock.combined(same, pulse_u=1e-7).relative_error.standard_uncertainty == pytest.approx(1e-7, rel=0.01)


def test_allan_deviation_of_white_phase_noise():
    """Oracle: sqrt(3) sigma / tau for phases with independent errors; a missing pulse leaves a gap."""
    rng = np.random.default_rng(7)
    number = np.delete(np.arange(20_000), [77, 5000])
    found = dict(allan_deviation(number, rng.normal(0, 1e-7, number.size), period_s=1.0))
    for interval in (1.0, 2.0, 8.0):
        assert found[interval] == pytest.approx(math.sqrt(3) * 1e-7 / interval, rel=0.05)


def test_rate_of_the_cameras_clock():
    """Oracle: 12 ppm more seconds of the camera, offset and delay of any size, 200 draws of noise: pulls with rms 1 +- 0.15."""
    rng = np.random.default_rng(8)
    triggers = 10**9 + 1_622_016 * np.arange(300)
    pulls = []
    for _ in range(200):
        said_s = (triggers / CLOCK_HZ) * (1 + 12e-6) + 1.7 + rng.normal(0, 2e-6, 300)
        stamps = np.rint(said_s * 1e9).astype(np.int64)
        stamps[rng.integers(300)] = 0
        found = camera_clock(
            "x", stamp_ticks=stamps, stamp_frequency_hz=1e9, trigger_ticks=triggers, clock_frequency_hz=CLOCK_HZ
        )
        assert found.n_frames == 299
        pulls.append((found.relative_rate.value - 12e-6) / found.relative_rate.standard_uncertainty)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize(("stamp_hz", "trigger_hz"), [(1e3, 49_152_000.0), (1e9, 1e3)])
def test_a_rate_is_known_no_better_than_the_coarser_clock_rounds(stamp_hz, trigger_hz):
    """Oracle: by hand; both ends of a run of 29.9 s round to a tick of a millisecond, sqrt(1/6) of it together."""
    run_s = 0.1 * np.arange(300)
    stamps, triggers = (np.rint(run_s * hz).astype(np.int64) + 1000 for hz in (stamp_hz, trigger_hz))
    found = camera_clock(
        "x", stamp_ticks=stamps, stamp_frequency_hz=stamp_hz, trigger_ticks=triggers, clock_frequency_hz=trigger_hz
    )
    assert found.relative_rate.value == pytest.approx(0, abs=1e-9)
    assert found.relative_rate.standard_uncertainty == pytest.approx(1e-3 / 29.9 / np.sqrt(6), rel=1e-6)


def test_the_drift_of_four_events_by_hand():
    """Oracle: by hand; a cubic at -1.5 to 1.5 s leaves 20 e^2 for one degree of freedom, x^2 less its mean 1, -1, -1, 1."""
    e = 1e-3
    found = line(np.arange(4.0), np.arange(4.0) + e * np.array([-1.0, 3.0, -3.0, 1.0]), tick_s=1e-9)
    assert found.slope.value == pytest.approx(1.0)
    assert found.slope.standard_uncertainty == pytest.approx(e * math.sqrt(20 / 2) / math.sqrt(5))
    assert found.bend_per_s.value == pytest.approx(0.0, abs=1e-12)
    assert found.bend_per_s.standard_uncertainty == pytest.approx(2 * e * math.sqrt(20) / math.sqrt(4))


def test_events_that_wander_together_tell_less():
    """Oracle: by hand; 8 early, 16 late, 8 early: neighbours correlate by r = 27/32: variances grow by (1 + r) / (1 - r)."""
    beside = 1e-3 * np.repeat([1.0, -1.0, 1.0], [8, 16, 8])
    found = line(np.arange(32.0), np.arange(32.0) + beside, tick_s=1e-9)
    inflation = math.sqrt((32 + 27) / (32 - 27))
    assert found.slope.value == pytest.approx(1.0)
    assert found.scatter_s == pytest.approx(1e-3 * math.sqrt(32 / 30))
    squares = 32 * (32**2 - 1) / 12
    assert found.slope.standard_uncertainty == pytest.approx(found.scatter_s * inflation / math.sqrt(squares))


def test_two_ends_are_rounded_to_a_tick():
    """Oracle: by hand; a rounding has the variance 1/12, two of them 1/6, over the time between the ends."""
    found = line(np.arange(4.0), np.arange(4.0), tick_s=1e-3)
    assert found.slope.standard_uncertainty == pytest.approx(1e-3 / math.sqrt(6) / 3)


def test_a_pulse_that_one_other_doubts_is_of_the_train_if_all_the_rest_know_it():
    """Oracle: by hand; pulse 1 is 4 thousandths of a period too near to pulse 0, 3 to the others; those jitter by 0.5."""
    ticks = 1_000_000 * np.arange(10) + np.array([500, -3500, 500, -500, 500, -500, 500, -500, 500, -500])
    found = pulse_train(ticks, period_ticks=1e6)
    assert found.number.tolist() == list(range(10))
    assert (found.missing, found.extra) == ((), ())


@pytest.mark.parametrize(("beside", "extra"), [(1_000, ()), (1_500, (20,))])
def test_a_pulse_eight_standard_deviations_beside_is_a_stray(beside, extra):
    """Oracle: by hand; pulses alternately 100 ticks early and late have the robust deviation 148: eight are 1186 ticks."""
    ticks = 1_000_000 * np.arange(40) + np.where(np.arange(40) % 2, 100, -100)
    ticks[20] = 20_000_000 + beside
    assert pulse_train(ticks, period_ticks=1e6).extra == extra


def test_pulses_that_many_strays_follow_are_told_by_their_line():
    """Oracle: by hand; five of 12 have two strays behind: the mean of all is nearest to the first of those."""
    true = 1_000_000 * np.arange(12)
    ticks = np.sort(np.concatenate([true, true[3:8] + 1_000, true[3:8] + 2_000]))
    found = pulse_train(ticks, period_ticks=1e6)
    assert found.ticks.tolist() == true.tolist()
    assert found.missing == ()

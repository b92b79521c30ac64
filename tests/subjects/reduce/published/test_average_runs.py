"""Averages over runs per nominal angle, against a plain loop and against known scatter."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.reduce.published.average_runs import average

TURN = 2 * np.pi
CORNERS = np.radians([37.5, 112.5, 127.5, 202.5, 217.5, 292.5, 307.5, 382.5])
OMEGA = TURN * 3


def _trapezoid(angle):
    at = np.concatenate([CORNERS - TURN, CORNERS, CORNERS + TURN])
    return np.interp(np.mod(angle - CORNERS[0], TURN) + CORNERS[0], at, [0, 1, 1, 0, 0, 1, 1, 0] * 3)


@pytest.fixture
def make_runs(track_of, reduced_recording):
    """Runs of the paper's scheme whose angles and counts scatter by known amounts."""

    def make(n_runs, *, noise=4e-3, jitter_rad=2e-4, lost=(), n=1000):
        rng = np.random.default_rng(11)
        runs = []
        for k in range(n_runs):
            # each run's wheel lags by a little, as irregular slots and wander make it do
            track = track_of(lambda t, lag=rng.normal(0, jitter_rad): OMEGA * t + 0.4 + lag, start=1000 * k)
            triggers = 1000 * k + 500_000 + 1_622_016 * np.arange(n, dtype=np.int64)
            t = (triggers - 1000 * k) / 49_152_000
            angle = np.interp(t, (track.edge_ticks - 1000 * k) / 49_152_000, track.edge_angle_rad)
            count = 500 + 8000 * (_trapezoid(angle) + rng.normal(0, noise, n))
            keep = ~np.isin(np.arange(n), lost[k] if k < len(lost) else [])
            runs.append(reduced_recording(track, triggers[keep], count[keep], name=f"run {k}"))
        return runs

    return make


def test_one_run_is_returned_as_it_is(make_runs):
    """Oracle: the run itself; without repeats there is no scatter to tell."""
    run = make_runs(1, noise=0)[0]
    data = average([run])
    angle = np.interp(run.trigger_ticks, run.track.edge_ticks, run.track.edge_angle_rad)
    np.testing.assert_allclose(data.wheel_angle_rad, np.sort(np.mod(angle, TURN)), atol=1e-9)
    np.testing.assert_allclose(data.fraction, _trapezoid(data.wheel_angle_rad), atol=1e-9)
    assert data.u_fraction is None
    assert data.u_wheel_angle_rad is None
    assert data.names == ("run 0",)
    assert [p[2] for p in sorted(data.plateaus)] in ([0, 1, 0, 1], [1, 0, 1, 0])


def test_means_and_uncertainties_of_six_runs_are_those_of_a_plain_loop(make_runs):
    """Oracle: for each trigger number, NumPy's mean and standard deviation over the runs."""
    runs = make_runs(6)
    data = average(runs)
    angles = np.stack([np.interp(r.trigger_ticks, r.track.edge_ticks, r.track.edge_angle_rad) for r in runs])
    angles = np.angle(np.exp(1j * (angles - angles[0]))) + np.mod(angles[0], TURN)
    fractions = []
    for run, angle in zip(runs, angles, strict=True):
        inside = [np.mod(angle - p[0], TURN) <= p[1] - p[0] for p in data.plateaus]
        top = run.pixels.pixel_count[
            np.any([m for m, p in zip(inside, data.plateaus, strict=True) if p[2]], axis=0)
        ].mean()
        low = run.pixels.pixel_count[
            np.any([m for m, p in zip(inside, data.plateaus, strict=True) if not p[2]], axis=0)
        ].mean()
        fractions.append((run.pixels.pixel_count - low) / (top - low))
    order = np.argsort(np.mod(angles.mean(axis=0), TURN))
    np.testing.assert_allclose(data.wheel_angle_rad, np.mod(angles.mean(axis=0), TURN)[order], atol=1e-9)
    np.testing.assert_allclose(data.fraction, np.mean(fractions, axis=0)[order], atol=3e-4)
    u_angle, u_fraction = (np.std(v, axis=0, ddof=1)[order] / np.sqrt(6) for v in (angles, fractions))
    np.testing.assert_allclose(data.u_wheel_angle_rad, u_angle, rtol=1e-6)
    np.testing.assert_allclose(data.u_fraction, u_fraction, rtol=0.2)
    assert np.median(np.abs(data.u_fraction / u_fraction - 1)) < 0.02


def test_few_runs_share_one_scatter(make_runs):
    """Oracle: the noise that was put in, over the square root of the runs; the same for all points."""
    data = average(make_runs(3, noise=4e-3))
    np.testing.assert_allclose(data.u_fraction, data.u_fraction[0])
    assert data.u_fraction[0] == pytest.approx(4e-3 / np.sqrt(3), rel=0.05)


def test_lost_frames_are_averaged_over_the_runs_that_have_them(make_runs):
    """Oracle: by hand; a trigger lost in one of four runs stays, one lost in three of four goes."""
    data = average(make_runs(4, lost=([17, 50], [50], [50])))
    assert data.wheel_angle_rad.size == 999
    ratio = np.sort(data.u_fraction / data.u_fraction.min())
    np.testing.assert_allclose(ratio[:998], 1)
    assert ratio[998] == pytest.approx(np.sqrt(4 / 3))


def test_angles_are_sorted_within_a_turn(make_runs):
    """Oracle: the docstring."""
    data = average(make_runs(2))
    assert np.all(np.diff(data.wheel_angle_rad) > 0)
    assert 0 <= data.wheel_angle_rad[0] < data.wheel_angle_rad[-1] < TURN


def test_triggers_before_the_first_slot_are_left_out(make_runs):
    """Oracle: by hand; 3 of 1000 triggers lie before the first slot edge, their delayed exposures after it."""
    run = make_runs(1, noise=0)[0]
    late = run.track.edge_ticks > run.trigger_ticks[2]
    track = replace(run.track, edge_ticks=run.track.edge_ticks[late], edge_angle_rad=run.track.edge_angle_rad[late])
    data = average([replace(run, track=track, equal_track=track)])
    assert data.wheel_angle_rad.size == 997
    np.testing.assert_allclose(data.fraction, _trapezoid(data.wheel_angle_rad), atol=1e-9)


def test_short_runs_are_refused(make_runs):
    """Oracle: by hand; 400 of 1000 nominal angles are less than half."""
    with pytest.raises(
        ReductionError, match=r"only 400 of 1000 nominal angles were met in at least half of the 2 passes"
    ):
        average(make_runs(2, n=400))

"""Trigger delay, row delay and time constant of a microbolometer camera as published, step by step (Schatz 2023, 3.2.4).

Where the paper is silent, the notes of `fit` say what was chosen.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.published.lag_simulation import MaskCrossings, SimulatedRows, crossings, simulate
from irtiming.estimate.published.plausible_lag import plausible_time_constant_s
from irtiming.estimate.published.slope_distance import LIMITS, slope_distances
from irtiming.inference import in_threads
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.exposed import ExposedRows
from irtiming.records.finding import Finding
from irtiming.records.lag_estimate import LagTiming, PublishedLagFit, WheelInImage
from irtiming.records.wheel_geometry import WheelModel

ROUNDS = 3
"""Simulation and determination of the delays are done so many times for each time constant."""

_WIDE, _NARROW = 0.3, 0.05  # half ranges of time constants, relative
_TRIED, _MOST_RANGES = 11, 6


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """The data of one nominal delay beside what is needed to simulate them.

    ``used`` are the rows of ``mask`` that are compared, ``row_fraction`` their data; ``place`` is where each data angle lies
    among the ``samples`` of a simulation.
    """

    data: ExposedRows
    mask: MaskCrossings
    samples: int
    used: Ticks
    row_fraction: Array
    place: Array

    @property
    def row_px(self) -> Ticks:
        return self.mask.row_px[self.used]

    def simulate(self, timing: LagTiming) -> SimulatedRows:
        total = LagTiming(
            trigger_delay_s=timing.trigger_delay_s + self.data.trigger_delay_time_set_s,
            row_delay_s=timing.row_delay_s,
            time_constant_s=timing.time_constant_s,
        )
        omega = self.data.angular_frequency_rad_per_s
        return simulate(self.mask, total, samples=self.samples, angular_frequency_rad_per_s=omega)

    def at_data(self, simulated: Array) -> Array:
        """Simulated curves, shape (..., samples), at the angles of the data, linear between the samples."""
        before = self.place.astype(np.int64) % self.samples
        share = self.place % 1.0
        return simulated[..., before] * (1 - share) + simulated[..., (before + 1) % self.samples] * share


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Delays:
    """Delays found for one time constant, the delay of each row that they are the line of, and the simulation with them."""

    timing: LagTiming
    u_trigger_delay_s: float
    u_row_delay_s: float
    delay_of_row_s: Array
    fraction: Array
    row_fraction: Array
    rms: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """RMS deviations over a range of time constants, and the minimum of the parabola through them."""

    time_constants_s: Array
    rms: Array
    parabola: Array
    lowest_s: float
    u_lowest_s: float

    @property
    def settled(self) -> bool:
        """Whether the minimum lies in the middle of the range: a parabola is no good guide further out."""
        inner = (self.time_constants_s.size - 1) // 3
        return bool(self.time_constants_s[inner] <= self.lowest_s <= self.time_constants_s[-1 - inner])

    @property
    def holds_minimum(self) -> bool:
        """Whether the minimum lies inside the range at all."""
        return bool(self.time_constants_s[0] < self.lowest_s < self.time_constants_s[-1])

    @property
    def best_guess_s(self) -> float:
        """Minimum of the parabola, or the best of the range where that lies outside."""
        return self.lowest_s if self.holds_minimum else float(self.time_constants_s[np.argmin(self.rms)])

    @property
    def text(self) -> str:
        return f"time constants of {1e3 * self.time_constants_s[0]:.3f} to {1e3 * self.time_constants_s[-1]:.3f} ms"


def fit(data: ExposedRows, model: WheelModel, *, wheel: WheelInImage, initial_row_delay_s: float) -> PublishedLagFit:
    """The three timing parameters from the opening fractions of the whole mask and of its rows.

    For each of eleven equidistant time constants both delays are determined from the horizontal distance of the slopes,
    three times; a parabola through the RMS deviations gives the time constant, and there both delays are determined again.

    Parameters
    ----------
    data
        Averaged opening fractions over the wheel angle at the nominal trigger.
    model
        The wheel.
    wheel
        Where the image shows it.
    initial_row_delay_s
        In the paper 1 / maximum frame rate / image rows; the trigger delay starts at 0.

    Raises
    ------
    EstimationError
        If rows and mask do not fit each other, fewer than three rows have slopes, or no time constant fits best.

    Notes
    -----
    What the paper leaves open. *Range*: +-30 % about what the start of the slopes tells, moved until the minimum is in its
    middle third, then +-5 % about that: far from its minimum the RMS deviation is a hyperbola, and a parabola through +-30 %
    was 0.4 ms off. *RMS*: of one more simulation, with the delays that were found third. *Straight line*: a row weighs by
    the scatter of its distances, see `_line`.
    """
    task = _task(data, crossings(data.mask, model, wheel=wheel))
    initial = LagTiming(
        trigger_delay_s=0.0,
        row_delay_s=initial_row_delay_s,
        time_constant_s=plausible_time_constant_s(data),
    )
    search, n_simulations, findings = _search(task, initial)
    best = _determine(task, initial, search.lowest_s)
    return PublishedLagFit(
        data=data,
        timing=best.timing,
        u_timing=LagTiming(
            trigger_delay_s=best.u_trigger_delay_s,
            row_delay_s=best.u_row_delay_s,
            time_constant_s=search.u_lowest_s,
        ),
        initial_timing=initial,
        time_constants_s=search.time_constants_s,
        rms=search.rms,
        parabola=search.parabola,
        row_px=task.row_px,
        delay_of_row_s=best.delay_of_row_s,
        simulated_fraction=best.fraction,
        simulated_row_fraction=best.row_fraction,
        deviation_rms=best.rms,
        n_simulations=n_simulations + ROUNDS + 1,
        findings=findings,
    )


def _task(data: ExposedRows, mask: MaskCrossings) -> _Task:
    _, at_mask, at_data = np.intersect1d(mask.row_px, data.row_px, return_indices=True)
    known = np.isfinite(data.row_fraction[at_data]).all(axis=1)
    used, row_fraction = at_mask[known], data.row_fraction[at_data[known]]
    if used.size < 3:
        raise EstimationError(
            f"{', '.join(data.names)}: {used.size} image rows have both mask pixels and opening fractions, a row delay needs "
            "at least 3; name the opening with --roi"
        )
    gaps = np.diff(data.wheel_angle_rad, append=data.wheel_angle_rad[0] + TURN)
    samples = round(TURN / float(np.median(gaps)))  # of the turn, had no angle been lost
    return _Task(
        data=data,
        mask=mask,
        samples=samples,
        used=used,
        row_fraction=row_fraction,
        place=np.mod(data.wheel_angle_rad, TURN) / TURN * samples,
    )


def _search(task: _Task, initial: LagTiming) -> tuple[_Search, int, tuple[Finding, ...]]:
    """Range that has its minimum in the middle, the simulations that all ranges took, and what there is to say."""
    names = ", ".join(task.data.names)
    wide = _moved_ranges(task, initial, half_range=_WIDE)
    if not wide[-1].settled:
        raise EstimationError(
            f"{names}: the RMS deviation has no minimum well inside {wide[-1].text}, nor in the {len(wide) - 1} ranges before; "
            "look at the opening fractions, or use the default method"
        )
    narrow = _moved_ranges(task, replace(initial, time_constant_s=wide[-1].lowest_s), half_range=_NARROW)
    findings = [
        Finding(
            code="published-range-moved",
            severity="warning",
            recording=names,
            what=f"{tried.text} have no minimum of the RMS deviation inside",
            cure=f"continued about {1e3 * tried.best_guess_s:.3f} ms",
        )
        for tried in wide
        if not tried.holds_minimum
    ]
    if not narrow[-1].settled:
        findings.append(
            Finding(
                code="published-range-not-settled",
                severity="warning",
                recording=names,
                what=f"the RMS deviation does not settle in {narrow[-1].text}",
                cure=f"{wide[-1].text} were taken",
            )
        )
    n_simulations = (ROUNDS + 1) * _TRIED * (len(wide) + len(narrow))
    return narrow[-1] if narrow[-1].settled else wide[-1], n_simulations, tuple(findings)


def _moved_ranges(task: _Task, initial: LagTiming, *, half_range: float) -> list[_Search]:
    """Ranges of time constants about the initial one, each about the minimum of the one before, until it is settled."""
    searches: list[_Search] = []
    centre = initial.time_constant_s
    while len(searches) < _MOST_RANGES and not (searches and searches[-1].settled):
        tried = centre * np.linspace(1 - half_range, 1 + half_range, _TRIED)
        rms = in_threads.mapped(lambda tau: _determine(task, initial, float(tau)).rms, tried)
        searches.append(_minimum(tried, np.array(rms)))
        centre = searches[-1].best_guess_s
    return searches


def _determine(task: _Task, initial: LagTiming, time_constant_s: float) -> _Delays:
    """Both delays at one time constant: three corrections from the distance of the slopes, then one simulation more."""
    omega, angle, y = task.data.angular_frequency_rad_per_s, task.data.wheel_angle_rad, task.row_px.astype(float)
    delay_s, row_delay_s = initial.trigger_delay_s, initial.row_delay_s
    for _ in range(ROUNDS):
        trial = LagTiming(trigger_delay_s=delay_s, row_delay_s=row_delay_s, time_constant_s=time_constant_s)
        simulated = task.simulate(trial).row_fraction[task.used]
        distance, u_distance = slope_distances(simulated, task.row_fraction, wheel_angle_rad=angle)
        correction = distance / omega
        has_slopes = np.isfinite(correction)
        if has_slopes.sum() < 3:
            raise EstimationError(
                f"{', '.join(task.data.names)}: only {has_slopes.sum()} rows have points between opening fractions "
                f"{LIMITS[0]} and {LIMITS[1]} on all four slopes, at least 3 are needed; sample the turn more finely"
            )
        line, u_line = _line(y[has_slopes], correction[has_slopes], u=u_distance[has_slopes])
        delay_of_row_s = delay_s + row_delay_s * y + correction
        delay_s, row_delay_s = delay_s + float(line[0]), row_delay_s + float(line[1])
    timing = LagTiming(trigger_delay_s=delay_s, row_delay_s=row_delay_s, time_constant_s=time_constant_s)
    final_run = task.simulate(timing)
    fraction, rows = task.at_data(final_run.fraction), task.at_data(final_run.row_fraction[task.used])
    squares = np.sum((fraction - task.data.fraction) ** 2) + np.sum((rows - task.row_fraction) ** 2)
    return _Delays(
        timing=timing,
        u_trigger_delay_s=float(u_line[0]),
        u_row_delay_s=float(u_line[1]),
        delay_of_row_s=delay_of_row_s,
        fraction=fraction,
        row_fraction=rows,
        rms=float(np.sqrt(squares / (fraction.size + rows.size))),
    )


def _line(y: Array, value: Array, *, u: Array) -> tuple[Array, Array]:
    """Intercept and slope of a straight line over y, and their standard uncertainties from the scatter about it.

    A row weighs 1 / u^2, but none more than the middle one. The paper says nothing of weights. Without any, the few rows
    that the mask's inner arc parts in two decide: half way down their slopes are flat, and their horizontal distance from
    a simulation is milliseconds off.
    """
    middle = float(np.median(u))
    weight = (middle / np.maximum(u, middle)) ** 2 if middle > 0 else np.ones_like(u)
    design = np.stack([np.ones_like(y), y], axis=1)
    inverse = np.linalg.inv(design.T @ (weight[:, None] * design))
    line = inverse @ design.T @ (weight * value)
    rest = value - design @ line
    return line, np.sqrt(np.diag(inverse) * (weight @ rest**2) / max(y.size - 2, 1))


def _minimum(time_constants_s: Array, rms: Array) -> _Search:
    """Parabola through the RMS deviations; its minimum is infinitely far where it has none."""
    middle, half = float(time_constants_s.mean()), float(np.ptp(time_constants_s)) / 2
    x = (time_constants_s - middle) / half
    design = np.stack([np.ones_like(x), x, x**2], axis=1)
    inverse = np.linalg.inv(design.T @ design)
    a, b, c = (float(p) for p in inverse @ design.T @ rms)
    rest = rms - design @ np.array([a, b, c])
    lowest, u = np.inf, np.inf
    if c > 0:
        along = np.array([0.0, -1 / (2 * c), b / (2 * c**2)])
        lowest = middle - half * b / (2 * c)
        u = half * np.sqrt(along @ inverse @ along * (rest @ rest) / (x.size - 3))
    p1, p2 = b / half, c / half**2
    return _Search(
        time_constants_s=time_constants_s,
        rms=rms,
        parabola=np.array([a - p1 * middle + p2 * middle**2, p1 - 2 * p2 * middle, p2]),
        lowest_s=lowest,
        u_lowest_s=float(u),
    )

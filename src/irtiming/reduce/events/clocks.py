"""How two clocks are related that were read one between two readings of the other.

A counter that was read between the times b and a of the computer's clock stood there at some moment between the two. So each
exchange puts two limits on the straight line of the one clock over the other, and all together leave a small polygon of lines:
its extent is what asymmetric ways can hide, whatever the delays were (the method of convex hulls for clock skew; a rigorous
bound, not a fit).
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.optimize import linprog

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Ticks
from irtiming.records.recording import Recording

_FEWEST = 2
_MOST = 2000
"""Exchanges that are taken, the quickest: each is a bound, and slow ones bound nothing."""

_US = 1e6
_LARGEST_RATE = 1e-3
"""Relative; no two crystals are so far apart."""

_OF_RECTANGLE = 1 / np.sqrt(3)


@final
@dataclass(frozen=True, kw_only=True)
class Relation:
    """Computer's clock of another one: computer = reading + offset_s + rate (reading - middle_s).

    ``u_offset_s`` is of the offset, at ``middle_s``, and ``u_rate`` of the rate: both of a rectangle between bounds.
    ``slack_s`` is by how much the bounds had to be widened for any straight line to lie within them.
    """

    middle_s: float
    offset_s: float
    rate: float
    u_offset_s: float
    u_rate: float
    slack_s: float

    def computer_s(self, reading_s: Array) -> Array:
        """Time of the computer at these readings, any shape."""
        return np.asarray(reading_s + self.offset_s + self.rate * (reading_s - self.middle_s))

    def reading_s(self, computer_s: Array) -> Array:
        """Reading of the other clock at these times of the computer, any shape."""
        return np.asarray((computer_s - self.offset_s + self.rate * self.middle_s) / (1 + self.rate))


def relation(
    reading_s: Array, *, before_s: Array, after_s: Array, name: str, middle_s: float | None = None
) -> Relation:
    """The computer's clock over another one.

    Parameters
    ----------
    reading_s, before_s, after_s
        Shape (n,): the other clock, and the computer's before and after it was read, s; small, so that no digits are lost.
    name
        Of the other clock, for messages.
    middle_s
        Of the other clock: where the offset is wanted; the middle of the readings where it is not given.

    Raises
    ------
    ReductionError
        If there are fewer than two exchanges, or no two clocks run so.
    """
    if reading_s.size < _FEWEST or float(np.ptp(reading_s)) <= 0:
        raise ReductionError(
            f"{reading_s.size} exchanges relate the clock of {name} to the computer's, at least {_FEWEST} at two times are "
            "needed; read it at the beginning and at the end of the recording, and often between"
        )
    if not all(np.all(np.isfinite(column)) for column in (before_s, reading_s, after_s)):
        raise ReductionError(f"an exchange with the clock of {name} has a time that is no number; leave it out")
    if reading_s.size > _MOST:
        tight = np.sort(np.argsort(after_s - before_s, kind="stable")[:_MOST])
        before_s, reading_s, after_s = before_s[tight], reading_s[tight], after_s[tight]
    middle = float(reading_s.min() + reading_s.max()) / 2 if middle_s is None else middle_s
    span = float(np.abs(reading_s - middle).max())
    place = (reading_s - middle) / span
    low, high = _US * (before_s - reading_s), _US * (after_s - reading_s)
    shift, steepest = float(low[0]), _LARGEST_RATE * span * _US
    low, high = low - shift, high - shift  # numbers stay small
    limits = [(None, None), (-steepest, steepest)]
    rows, bounds = np.vstack([_columns(place), -_columns(place)]), np.concatenate([high, -low])
    with_slack = np.column_stack([rows, -np.ones(len(rows))])
    widened = linprog([0, 0, 1], A_ub=with_slack, b_ub=bounds, bounds=[*limits, (0, None)], method="highs")
    if widened.x is None:
        raise ReductionError(
            f"the exchanges with the clock of {name} lie on no straight line; check their columns and units"
        )
    slack = float(widened.x[2])
    bounds = bounds + slack + 1e-6 * max(1.0, slack)
    earliest, latest, slowest, fastest = (
        np.asarray(linprog(goal, A_ub=rows, b_ub=bounds, bounds=limits, method="highs").x, np.float64)
        for goal in ((1, 0), (-1, 0), (0, 1), (0, -1))
    )
    offset, rate = (earliest + latest) / 2
    half_offset, half_rate = (latest[0] - earliest[0]) / 2, (fastest[1] - slowest[1]) / 2
    beside = rate - (slowest[1] + fastest[1]) / 2  # the line is a possible one: its rate need not be the middle of all
    return Relation(
        middle_s=middle,
        offset_s=(float(offset) + shift) / _US,
        rate=float(rate) / span / _US,
        u_offset_s=float(half_offset * _OF_RECTANGLE + slack) / _US,
        u_rate=float(np.hypot(half_rate * _OF_RECTANGLE, beside) + slack) / span / _US,
        slack_s=slack / _US,
    )


def _columns(place: Array) -> Array:
    return np.column_stack([np.ones_like(place), place])


@final
@dataclass(frozen=True, kw_only=True)
class Zeros:
    """From where times are counted, so that they are small numbers: counter in ticks, computer in s, camera's clock in ticks."""

    counter_ticks: int
    computer_s: float
    camera_ticks: int


def zeros(recording: Recording) -> Zeros:
    """Some moment of the recording by each clock, 0 where it has no such clock."""
    computer = recording.counter_exchange_before_s
    camera = recording.frame_timestamp_ticks
    return Zeros(
        counter_ticks=int(recording.control_slot_ticks[0]),
        computer_s=0.0 if computer is None or not computer.size else float(computer[0]),
        camera_ticks=0 if camera is None or not camera.size else int(camera[0]),
    )


def of_counter(recording: Recording, *, middle_s: float | None = None) -> Relation | None:
    """Computer's clock over the counter, both from `zeros`; None where the counter was never read.

    Parameters
    ----------
    recording
        With its exchanges.
    middle_s
        As for `relation`.

    Raises
    ------
    ReductionError
        As for `relation`.
    """
    before, ticks, after = (
        recording.counter_exchange_before_s, recording.counter_exchange_ticks, recording.counter_exchange_after_s,
    )  # fmt: skip
    if before is None or ticks is None or after is None or not ticks.size:
        return None
    zero = zeros(recording)
    reading_s = (ticks - zero.counter_ticks) / recording.clock_frequency_hz
    return relation(
        reading_s,
        before_s=before - zero.computer_s,
        after_s=after - zero.computer_s,
        name="the counter",
        middle_s=middle_s,
    )


def of_camera(recording: Recording, *, middle_s: float | None = None) -> Relation | None:
    """Computer's clock over the camera's, both from `zeros`; None where the camera's was never read.

    Parameters and errors as for `of_counter`.
    """
    before, ticks, after = (
        recording.camera_exchange_before_s, recording.camera_exchange_ticks, recording.camera_exchange_after_s,
    )  # fmt: skip
    frequency_hz = recording.timestamp_frequency_hz
    if before is None or ticks is None or after is None or frequency_hz is None or not ticks.size:
        return None
    zero = zeros(recording)
    reading_s = (ticks - zero.camera_ticks) / frequency_hz
    return relation(
        reading_s,
        before_s=before - zero.computer_s,
        after_s=after - zero.computer_s,
        name="the camera",
        middle_s=middle_s,
    )


def arrival_after_s(recording: Recording, edge_s: Array) -> float | None:
    """Usual time from these moments to the arrival of the frames, s; None where it is not known.

    Parameters
    ----------
    recording
        With arrivals of its frames by the computer's clock, and exchanges of that with the counter.
    edge_s
        Shape (n_frame,), s of the counter after the first edge of ``camera_input``.
    """
    related, arrival_s = of_counter(recording), recording.frame_host_time_s
    if related is None or arrival_s is None or recording.camera_input_ticks is None:
        return None
    zero = zeros(recording)
    first_s = float(recording.camera_input_ticks[0] - zero.counter_ticks) / recording.clock_frequency_hz
    return float(np.median(related.reading_s(arrival_s - zero.computer_s) - (edge_s + first_s)))


def counter_ticks(recording: Recording, counter_s: Array) -> Ticks:
    """Ticks of the counter at these times after its zero, any shape."""
    whole = np.rint(counter_s * recording.clock_frequency_hz).astype(np.int64)
    return np.asarray(whole + zeros(recording).counter_ticks)

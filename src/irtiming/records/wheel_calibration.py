"""What the timestamps tell of the wheel itself: where its slots and edges are, and by how much the speed ripples."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Array
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlotsAtSpeed:
    """Slots as they appear at one wheel speed: their own deviations and the ripple of that speed together.

    Parameters
    ----------
    rotation_speed_hz
        Turns per second, as measured.
    n_turns
        Turns that were averaged.
    deviation_rad
        Shape (slots,); apparent angle of slot j minus 2 pi j / slots, mean zero.
    order_variance_rad2
        Shape (slots // 2 + 1,); variance per order, see `irtiming.physics.slot_orders`.
    """

    rotation_speed_hz: float
    n_turns: int
    deviation_rad: Array
    order_variance_rad2: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedRipple:
    """Speed variation that repeats every turn, distinguished from the slots by its fall with the square of the speed.

    Parameters
    ----------
    reference_speed_hz
        Speed that the deviation belongs to, the slowest one; at another speed f it is (reference / f)^2 times as large.
    deviation_rad
        Shape (slots,); what the ripple adds to the apparent angle of each slot, mean zero.
    order_variance_rad2
        Shape (slots // 2 + 1,); its variance per order.
    order_chance
        Shape (slots // 2 + 1,); probability that chance alone gives an order so large a ripple.
    chance
        The same of all orders together.
    """

    reference_speed_hz: float
    deviation_rad: Array
    order_variance_rad2: Array
    order_chance: Array
    chance: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WheelCalibration:
    """The wheel as its timestamps show it, pooled over recordings.

    Parameters
    ----------
    slot_deviation_rad
        Shape (slots,); angle of slot j minus 2 pi j / slots, mean zero. Without ``ripple`` it holds the ripple too.
    order_variance_rad2
        Shape (slots // 2 + 1,); its variance per order.
    ripple
        None where all recordings have one speed: then no order can be distinguished from a ripple that repeats every turn.
    speeds
        Apparent slots at each speed, slowest first: all that a later calibration needs of this one.
    gate_separation_rad, u_gate_separation_rad
        dbeta with the register of slots and edges.
    application_edges_rad, u_application_edges_rad
        alpha_0 .. alpha_3 of the ring at the application gate; None where no recording has all four edges.
    names, sha256
        Of the recordings that went in.
    warnings
        What does not fit together.
    """

    __repr__ = short_repr

    slot_deviation_rad: Array
    order_variance_rad2: Array
    ripple: SpeedRipple | None
    speeds: tuple[SlotsAtSpeed, ...]
    gate_separation_rad: float
    u_gate_separation_rad: float
    application_edges_rad: tuple[float, float, float, float] | None = None
    u_application_edges_rad: tuple[float, float, float, float] | None = None
    names: tuple[str, ...] = ()
    sha256: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

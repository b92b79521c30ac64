"""Where the wheel was at every moment of one recording."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Ticks
from irtiming.records.finding import Finding
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WheelTrack:
    """Wheel angle at each control-slot edge of one recording; between edges it is linear in time.

    Parameters
    ----------
    edge_ticks, edge_angle_rad
        Shape (n_edge,); times of the control-slot edges and the unwrapped wheel angle there. Zero (mod 2 pi) when the
        reference edge passes the application gate.
    clock_frequency_hz
        Ticks per SI second, with the relative error of the clock that rig.toml states; ``clock_relative_error`` is that.
    angular_frequency_rad_per_s
        Mean over the recording; always positive.
    gate_separation_rad, u_gate_separation_rad
        Angle dbeta between the two gates (Schatz 2023, 2.5). Its standard uncertainty holds the register of slots and
        edges: the table has mean zero, while the slots' own errors have a mean of about their rms over the root of their
        number; a wave around the wheel, such as eccentricity, has none.
    slot_deviation_rad, u_slot_deviation_rad
        Shape (control_slots,); angle of slot j minus 2 pi j / control_slots, mean zero, as used for
        ``edge_angle_rad``; all zero where the slots are taken as equal.
    order_variance_rad2
        Shape (control_slots // 2 + 1,); variance of the slots' deviations per order, see `irtiming.physics.slot_orders`.
        None counts as slots that are uncertain each for itself.
    application_edges_rad, u_application_edges_rad
        Angles of edges 0..3 at the application gate, from the timestamps of all four; None where not recorded.
    findings
        What was missing, doubled or spurious and what was done about it.
    ahead_rad
        Angle by which ``edge_angle_rad`` stands ahead of what the slots' timestamps show, for the latencies that rig.toml states:
        it is the wheel's angle at the moment when a trigger with that timestamp is at the camera's connector.
    register_rad_per_s
        Mean angular frequency of the wheel in the recordings that determined ``gate_separation_rad``; None where it is this one.
    """

    __repr__ = short_repr

    edge_ticks: Ticks
    edge_angle_rad: Array
    clock_frequency_hz: float
    angular_frequency_rad_per_s: float
    gate_separation_rad: float
    u_gate_separation_rad: float
    slot_deviation_rad: Array
    u_slot_deviation_rad: Array
    order_variance_rad2: Array | None = None
    application_edges_rad: tuple[float, float, float, float] | None = None
    u_application_edges_rad: tuple[float, float, float, float] | None = None
    findings: tuple[Finding, ...] = ()
    ahead_rad: float = 0.0
    clock_relative_error: float = 0.0
    register_rad_per_s: float | None = None

    @property
    def has_learned_slots(self) -> bool:
        """Whether its slots were learned from timestamps; else they are taken as regular."""
        return bool(np.any(self.u_slot_deviation_rad > 0) or np.any(self.slot_deviation_rad != 0))

"""Put another slot table under a wheel track."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel.slot_table import SlotTable

_MOVED = 5.0  # standard uncertainties between the gates' angles of two recordings
_LEAST_JITTER_RAD = 1e-9


def with_slots(track: WheelTrack, slots: SlotTable) -> WheelTrack:
    """The track with another table; angle zero stays where the reference edge passed the gate.

    Parameters
    ----------
    track
        With a table of as many slots, which is taken off.
    slots
        The table to put in its place.
    """
    n_slots = slots.deviation_rad.size
    change = slots.deviation_rad - track.slot_deviation_rad
    alpha = track.edge_angle_rad + track.gate_separation_rad - track.ahead_rad
    known = np.isfinite(alpha)
    slot = np.mod(np.rint(np.where(known, alpha, 0.0) * n_slots / TURN).astype(int), n_slots)
    moved = alpha + change[slot]
    zeros = TURN * np.arange(np.ceil(np.nanmin(track.edge_angle_rad) / TURN), np.nanmax(track.edge_angle_rad) / TURN)
    ticks = (track.edge_ticks - track.edge_ticks[0]).astype(float)
    at_reference = np.interp(zeros, track.edge_angle_rad[known], ticks[known])
    separation = float(np.mean(np.interp(at_reference, ticks[known], moved[known]) - zeros)) + track.ahead_rad
    u_scatter_2 = track.u_gate_separation_rad**2 - table_of(track).u_register_rad ** 2
    return replace(
        track,
        edge_angle_rad=moved - separation + track.ahead_rad,
        gate_separation_rad=separation,
        u_gate_separation_rad=float(np.sqrt(max(u_scatter_2, 0.0) + slots.u_register_rad**2)),
        slot_deviation_rad=slots.deviation_rad,
        u_slot_deviation_rad=slots.u_deviation_rad,
        order_variance_rad2=slots.order_variance_rad2,
        application_edges_rad=_moved_edges(track, change),
    )


def with_common_zero(tracks: Sequence[WheelTrack]) -> list[WheelTrack]:
    """The tracks with one angle between the gates, which is the rig's and the same in every recording.

    Where each recording keeps its own, the jitter of its some hundred reference edges goes into its delay; what the ten thousand
    edges of its control slots say of the wheel's phase is far better.

    Parameters
    ----------
    tracks
        On one slot table.

    Returns
    -------
    The tracks as they were where their angles differ by more than jitter: the gates were moved, or their detectors lag.
    """
    if len(tracks) < 2:
        return list(tracks)
    variance = [max(t.u_gate_separation_rad**2 - table_of(t).u_register_rad ** 2, 0.0) for t in tracks]
    own = np.array([t.gate_separation_rad for t in tracks])
    u_own = np.maximum(np.sqrt(variance), _LEAST_JITTER_RAD)
    common = float(np.average(own, weights=u_own**-2))
    if np.any(np.abs(own - common) > _MOVED * u_own):
        return list(tracks)
    u_common = float(np.sum(u_own**-2.0) ** -0.5)
    speed = float(np.average([t.angular_frequency_rad_per_s for t in tracks], weights=u_own**-2))
    return [
        replace(
            t,
            edge_angle_rad=t.edge_angle_rad + (t.gate_separation_rad - common),
            gate_separation_rad=common,
            u_gate_separation_rad=float(np.hypot(u_common, table_of(t).u_register_rad)),
            register_rad_per_s=speed,
        )
        for t in tracks
    ]


def table_of(track: WheelTrack) -> SlotTable:
    """The table that the track stands on."""
    variance = track.order_variance_rad2
    if variance is None:  # each slot uncertain for itself
        n_orders = track.u_slot_deviation_rad.size // 2 + 1
        variance = np.full(n_orders, float(np.mean(track.u_slot_deviation_rad**2)))
    return SlotTable(deviation_rad=track.slot_deviation_rad, order_variance_rad2=variance)


def _moved_edges(track: WheelTrack, change: Array) -> tuple[float, float, float, float] | None:
    """Application edges on the changed slots."""
    if track.application_edges_rad is None:
        return None
    edges = np.array(track.application_edges_rad)
    places = TURN * np.arange(change.size) / change.size
    shift = np.interp(edges + track.gate_separation_rad, places, change, period=TURN)
    a, b, c, d = (float(angle) for angle in edges + shift - shift[0])
    return (a, b, c, d)

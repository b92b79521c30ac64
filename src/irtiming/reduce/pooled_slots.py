"""One slot table for all recordings of a rig: their wheel is the same, only its wander differs."""

from dataclasses import replace

import numpy as np

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.wheel_track import WheelTrack


def pool(tracks: list[WheelTrack]) -> list[WheelTrack]:
    """The same tracks with the slot deviations averaged over all of them.

    A table learned from one recording carries that recording's wander into its delays; the average carries less, and the
    same for all, so that it cancels in relative delays.

    Parameters
    ----------
    tracks
        Of one wheel, each with its own learned table or with equal slots.
    """
    own = np.array([track.slot_deviation_rad for track in tracks])
    u_own = np.array([track.u_slot_deviation_rad for track in tracks])
    learned = np.any(u_own > 0, axis=1)
    if learned.sum() < 2:
        return tracks
    weight = 1 / np.mean(u_own[learned] ** 2, axis=1)
    weight /= weight.sum()
    deviation = weight @ own[learned]
    u_deviation = np.sqrt(weight**2 @ u_own[learned] ** 2)
    return [_with_slots(track, deviation, u_deviation) for track in tracks]


def _with_slots(track: WheelTrack, deviation: Array, u_deviation: Array) -> WheelTrack:
    """The track with another table; angle zero stays where the reference edge passed the gate."""
    pitch = TURN / deviation.size
    alpha = track.edge_angle_rad + track.gate_separation_rad
    known = np.isfinite(alpha)
    slot = np.mod(np.rint(np.where(known, alpha, 0.0) / pitch).astype(int), deviation.size)
    moved = alpha + (deviation - track.slot_deviation_rad)[slot]
    zeros = TURN * np.arange(np.ceil(np.nanmin(track.edge_angle_rad) / TURN), np.nanmax(track.edge_angle_rad) / TURN)
    ticks = (track.edge_ticks - track.edge_ticks[0]).astype(float)
    at_reference = np.interp(zeros, track.edge_angle_rad[known], ticks[known])
    separation = np.interp(at_reference, ticks[known], moved[known]) - zeros
    return replace(
        track,
        edge_angle_rad=moved - float(separation.mean()),
        gate_separation_rad=float(separation.mean()),
        slot_deviation_rad=deviation,
        u_slot_deviation_rad=u_deviation,
    )

"""The wheel as its timestamps show it: speed over time, and the irregularity of its control slots."""

import numpy as np
from matplotlib.figure import Figure

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.wheel_track import WheelTrack
from irtiming.report import sheet
from irtiming.report.evidence import WheelEvidence

_PER_MILLION = 1e6


def speed(evidence: WheelEvidence) -> Figure:
    """Mean speed of each turn of each recording, relative to the nominal one."""
    recordings = evidence.recordings
    names = sheet.run_names(
        [recording.trigger_delay_time_set_s for recording in recordings],
        [recording.rotation_speed_hz for recording in recordings],
    )
    with sheet.style():
        drawn = sheet.figure(height_in=2.6)
        axes = drawn.add_subplot()
        told: set[str] = set()
        for recording, name, hue in zip(recordings, names, sheet.colours(names), strict=True):
            middle_s, rate_hz = turn_rates(recording.track)
            deviation = _PER_MILLION * (rate_hz / recording.rotation_speed_hz - 1)
            label = None if name in told else name
            told.add(name)
            axes.plot(middle_s, deviation, color=hue, linewidth=0.9, marker=".", markersize=3, label=label)
        sheet.zero_line(axes)
        axes.set_xlabel("time after the first control slot of the recording (s)")
        axes.set_ylabel("turn rate − nominal\n(10⁻⁶ of nominal)")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def turn_rates(track: WheelTrack) -> tuple[Array, Array]:
    """Time of the middle of each whole turn, s after the first control slot, and its mean rate, Hz; shapes (n_turn,)."""
    known = np.isfinite(track.edge_angle_rad)
    angle = track.edge_angle_rad[known]
    time_s = (track.edge_ticks[known] - track.edge_ticks[0]) / track.clock_frequency_hz
    marks = np.arange(angle[0], angle[-1], TURN)
    passed = np.interp(marks, angle, time_s)
    return (passed[1:] + passed[:-1]) / 2, 1 / np.diff(passed)


def slots(evidence: WheelEvidence) -> Figure:
    """Deviation of each control slot from its regular place, as learned, with its standard uncertainty."""
    tracks = [recording.track for recording in evidence.recordings]
    tables = np.array([track.slot_deviation_rad for track in tracks])
    u = np.sqrt(np.mean([track.u_slot_deviation_rad**2 for track in tracks], axis=0) / len(tracks))
    mean, slot = tables.mean(axis=0), np.arange(tables.shape[1])
    omega = float(np.mean([track.angular_frequency_rad_per_s for track in tracks]))
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        axes = drawn.add_subplot()
        sheet.zero_line(axes)
        axes.vlines(slot, 0, 1e3 * mean, color=sheet.BLUE, linewidth=2.2, alpha=0.35)
        if len(tracks) > 1:
            all_slots = np.tile(slot, len(tracks)).astype(float)
            axes.plot(
                all_slots, 1e3 * tables.ravel(), "_", color=sheet.FAINT, markersize=5, label="single recordings",
                rasterized=all_slots.size > 2500,
            )  # fmt: skip
        axes.errorbar(
            slot, 1e3 * mean, yerr=1e3 * u, fmt=".", color=sheet.BLUE, ecolor=sheet.RED, elinewidth=1.2, markersize=4,
            label="mean with standard uncertainty",
        )  # fmt: skip
        axes.set_xlim(-1.5, slot.size + 0.5)
        axes.set_xlabel("control slot, slot 0 in register with edge 0 (1)")
        axes.set_ylabel("deviation (mrad)")
        times = axes.twinx()
        times.set_ylim(*(1e3 * limit / omega for limit in axes.get_ylim()))
        times.grid(visible=False)
        times.spines["right"].set_visible(True)
        times.set_ylabel(f"at {omega / TURN:.3g} Hz (µs)")
        axes.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.14))
    return drawn

r"""Whether frames belong to the triggers that their numbers say: short blocks of a run against all of it.

A frame is lost, or delivered twice, uncounted: from then on each frame is given the trigger before or after its own.
The light of some ten frames follows the wheel in a wave :math:`\exp(2 i \theta)`, since two cutouts pass in a turn. Where frames
are given triggers k before their own, and the wheel turns by :math:`\Delta` from one trigger to the next, its phase is off by
:math:`2 k \Delta`: much more than the noise of a block, so that a block tells k to a whole number. What counts is the phase
beside that of the usual light at the same angles: a block that visits three of them has another phase than a wave all around.
"""

from collections import Counter
from dataclasses import dataclass
from itertools import groupby
from typing import final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.finding import Finding
from irtiming.reduce.passing_wave import PASSING
from irtiming.reduce.wheel.frame_angles import FrameAngles

_BLOCK = 15  # frames, of which half overlap
_MOST = 3  # frames that are looked for: half a turn has five, and more would be as good as fewer the other way
_FAR = 6.0  # standard uncertainties: by chance never
_SLIGHT_RAD = 0.1  # by as much a level that sways by a twentieth turns a block that visits three places of the wave
_CERTAIN = 0.2  # of a frame: the standard uncertainty from which a block tells a whole number by three of them
_ORDERS = np.array([1, 2, 4, 6, 8])  # of the light over the wheel's angle
_ALIKE = 1e-6  # relative: waves that the visited angles hardly distinguish
_IN_A_ROW = 3  # blocks, which a shutter that closes hardly is


@final
@dataclass(frozen=True, kw_only=True)
class Shift:
    """Frames ``first_frame`` to ``end_frame`` (excluded), roughly, are of triggers ``by`` after those that they are given."""

    first_frame: int
    end_frame: int
    by: int


def shifts(light_dn: Array, wheel_angle_rad: Array) -> tuple[Shift, ...]:
    """Stretches of a run that are counted otherwise than most of it.

    Parameters
    ----------
    light_dn
        Shape (n_frame,); light of the opening in each frame.
    wheel_angle_rad
        Shape (n_frame,), at the trigger; nan where unknown.
    """
    known = np.flatnonzero(np.isfinite(wheel_angle_rad) & np.isfinite(light_dn))
    if known.size < 4 * _BLOCK:
        return ()
    step_rad = float(np.median(np.mod(np.diff(wheel_angle_rad[known]), TURN)))
    blocks = sliding_window_view(known, _BLOCK)[:: _BLOCK // 2]
    usual_dn, angle = np.full(light_dn.size, np.nan), wheel_angle_rad[blocks]
    usual_dn[known] = _usual(light_dn[known], wheel_angle_rad[known])
    (phases, u_rad), (expected, _) = _phases(light_dn[blocks], angle), _phases(usual_dn[blocks], angle)
    phases = np.angle(np.exp(1j * (phases - expected)))
    usual = Counter(np.digitize(phases, np.linspace(-np.pi, np.pi, 13)).tolist())
    fullest = usual.most_common(1)[0][0]
    about = np.linspace(-np.pi, np.pi, 13)[fullest - 1] + np.pi / 12
    near = [off for phase in phases.tolist() if abs(off := _folded(phase - about)) < np.pi / 6]
    middle = about + float(np.median(near))
    every = zip(phases.tolist(), u_rad.tolist(), strict=True)
    by = [_by(_folded(phase - middle), u, step_rad=step_rad) for phase, u in every]
    return _joined(by, blocks)


def _folded(phase: float) -> float:
    """Between -pi and pi."""
    return float(np.angle(np.exp(1j * phase)))


def _usual(light: Array, angle: Array) -> Array:
    """Light of all frames as their angles alone tell it, shape (n,): few orders, which follow no jump of the numbers."""
    waves = np.multiply.outer(angle, _ORDERS)
    columns = np.concatenate([np.ones((angle.size, 1)), np.cos(waves), np.sin(waves)], axis=1)
    return np.asarray(columns @ np.linalg.lstsq(columns, light, rcond=_ALIKE)[0])


def _phases(light: Array, angle: Array) -> tuple[Array, Array]:
    """Of the wave with which cutouts pass, beside a straight line, and its standard uncertainty, rad; in each block, a row."""
    line = np.broadcast_to(np.linspace(-1.0, 1.0, _BLOCK), angle.shape)
    columns = np.stack([np.ones(angle.shape), line, np.cos(PASSING * angle), np.sin(PASSING * angle)], axis=-1)
    inverse = np.linalg.pinv(columns)
    found = np.einsum("bij,bj->bi", inverse, light)
    left = light - np.einsum("bji,bi->bj", columns, found)
    variance = np.sum(left**2, axis=1) / (_BLOCK - columns.shape[-1])
    size = np.maximum(np.hypot(found[:, 2], found[:, 3]), np.finfo(float).tiny)
    u = np.sqrt(np.sum(inverse[:, 2:] ** 2, axis=(1, 2)) * variance / 2)
    return np.arctan2(found[:, 3], found[:, 2]), u / size


def _by(off_rad: float, u_rad: float, *, step_rad: float) -> int | None:
    """Whole frames by which a block is off; None where its noise does not tell, or where it is off by no whole number."""
    if not u_rad < _CERTAIN * abs(_folded(PASSING * step_rad)):
        return None
    fits = [k for k in range(-_MOST, _MOST + 1) if abs(_folded(off_rad + PASSING * k * step_rad)) < 3 * u_rad]
    if 0 in fits or not fits or abs(off_rad) < max(_FAR * u_rad, _SLIGHT_RAD):
        return 0
    return min(fits, key=abs)


def _joined(by: list[int | None], blocks: Ticks) -> tuple[Shift, ...]:
    """Blocks of frames, shape (n, frames), in a row that are off by as many; one alone may be a shutter that closes."""
    found = []
    for k, group in groupby(range(len(by)), key=by.__getitem__):
        members = list(group)
        if k and len(members) >= _IN_A_ROW:
            first, last = blocks[members[0]], blocks[members[-1]]
            found.append(Shift(first_frame=int(first[0]), end_frame=int(last[-1]) + 1, by=k))
    return tuple(found)


def findings(angles: FrameAngles, *, light_dn: Array) -> tuple[Finding, ...]:
    """A doubt where frames belong to other triggers than their numbers say.

    Parameters
    ----------
    angles
        Of the recording's frames.
    light_dn
        Shape (n_frame,); light of the opening in each frame of the recording.
    """
    found = shifts(light_dn, angles.angle_rad)
    if not found:
        return ()
    stretches = ", ".join(f"about {one.first_frame} to {one.end_frame - 1}: {one.by:+d}" for one in found[:4])
    return (
        Finding(
            code="frames-renumbered",
            severity="doubt",
            recording=angles.recording.name,
            what=f"frames follow the wheel as if they were of other triggers than the rest of the run ({stretches} triggers"
            f"{', and more' if len(found) > 4 else ''}): frames were lost or came twice, and the others were counted on",
            cure="write frame_number from the camera's own counter, and record again",
        ),
    )

"""Whether the whole run tells one story: the light follows the wheel equally late, and from one place, in all its parts.

A frame that was lost and not numbered, timestamps that jump, a disk that slips on its axle: from then on the light comes earlier
or later by the same amount. Each quarter of the run has its own fit of the light's waves over the wheel's angle, and the phase of
the wave with which the two cutouts pass tells when. A phase needs no model of wheel, mask or lag, and levels that drift leave it
where it is.
"""

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics import robust
from irtiming.physics.covariance import hac_covariance
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.finding import Finding
from irtiming.records.rig import Rig
from irtiming.reduce import passing_wave, renumbered
from irtiming.reduce.passing_wave import PASSING
from irtiming.reduce.wheel.frame_angles import FrameAngles

_PARTS = 4
_FEWEST_TURNS = 3.0  # of a part: in fewer, a gain that sways as slowly as that looks like light that comes later
_ORDERS = (1, 2, 3, *range(4, 17, 2))  # waves a turn: of two cutouts, and what tells them apart
_CORNERS = tuple(range(18, 49, 2))  # what the corners of the slopes add
_ODD = tuple(range(5, 50, 2))  # what cutouts that differ add beside the first and third wave
_SMALL = _CORNERS + _ODD  # of the whole run, since a part has too few frames for them
_FRAMES_PER_NUMBER = 3
_FAR = 6.0  # standard uncertainties, which take for noise what waves of higher order leave; by chance never
_OUTLIER, _LOOKS = 6.0, 3
_SWAYS = 8  # of a part: what sways not faster moves a wave as a whole, in so many pieces that their scatter is known
_OF_SLOPE = 0.75 * 12**0.5
"""Of a straight line through evenly spread points: u of its rise from the first part to the last, over u of its middle."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Lateness:
    """By how much the light comes later in each part of a run than on average, and its standard uncertainty, rad of the wheel.

    Shapes (n_part,); ``first_frame`` is where each part begins.
    """

    first_frame: tuple[int, ...]
    angle_rad: Array
    u_rad: Array


def lateness(light_dn: Array, wheel_angle_rad: Array) -> Lateness | None:
    """Of the parts of a run; None where it is too short to have any, or where a part does not tell, as it sees no whole turn.

    Parameters
    ----------
    light_dn
        Shape (n_frame,); light of the opening in each frame.
    wheel_angle_rad
        Shape (n_frame,), at the trigger; nan where unknown.
    """
    known = np.flatnonzero(np.isfinite(wheel_angle_rad) & np.isfinite(light_dn))
    n_turns = float(np.ptp(wheel_angle_rad[known])) / TURN if known.size else 0.0
    n_parts = min(_PARTS, int(n_turns / _FEWEST_TURNS))
    if n_parts < 2:
        return None
    parts = np.array_split(known, n_parts)
    if parts[-1].size < _FRAMES_PER_NUMBER * (2 * len(_ORDERS) + 2):
        return None
    if _is_slow(wheel_angle_rad[known], len(parts[-1])):
        return None
    if not passing_wave.is_told(wheel_angle_rad, parts, orders=_ORDERS):
        return None
    light_dn, small_left = _without_small(light_dn, wheel_angle_rad, parts=parts)
    found = [_phase(light_dn[part], wheel_angle_rad[part], small_left=small_left) for part in parts]
    waves, u_rad = np.array([wave for wave, _ in found]), np.array([u for _, u in found])
    middle = np.sum(waves / np.abs(waves))
    angle_rad = -np.angle(waves / middle) / PASSING
    return Lateness(first_frame=tuple(int(part[0]) for part in parts), angle_rad=angle_rad, u_rad=u_rad)


def _is_slow(angle: Array, n_frames: int) -> bool:
    """Whether the passing wave, or the doubled one, beats with the frames in fewer than three periods in so many frames.

    Then an offset or a gain that sways as slowly looks like light that comes later.
    """
    step = float(np.median(np.diff(angle))) / TURN
    beats = [abs(order * step - round(order * step)) * n_frames for order in (PASSING, 2 * PASSING)]
    return min(beats) < _FEWEST_TURNS


def _without_small(light: Array, angle: Array, *, parts: list[Ticks]) -> tuple[Array, Array]:
    """The light less its corners and odd waves, as the whole run tells them, and covariance of what is left of those, DN^2.

    They are told by what the large waves of each part do not explain, or a lateness would be taken for them. They are known
    beforehand to be small: an odd wave of order m no more than 3/m of the first and third, one of a corner no more than 8/m^2 of
    the passing one, as of a trapezoid. Where frames see one of them as slowly as the passing wave, no more is known of it.
    """
    known = np.concatenate(parts)
    whole = passing_wave.waves(angle[known], _ORDERS + _CORNERS)
    kept = _usual(light[known], whole)
    amounts = np.asarray(np.linalg.lstsq(whole[kept], light[known][kept], rcond=None)[0], float)
    noise = max(robust.spread((light[known] - whole @ amounts)[kept]), float(np.finfo(float).tiny) ** 0.5)
    prior = _small_at_most(amounts)
    small = passing_wave.waves(angle[known], _SMALL)[:, 2:] * prior
    both, ends = np.column_stack([light[known], small]), np.cumsum([part.size for part in parts[:-1]])
    left = np.concatenate([
        _beside(passing_wave.waves(angle[part], _ORDERS)[good], own[good])
        for part, own, good in zip(parts, np.split(both, ends), np.split(kept, ends), strict=True)
    ])  # fmt: skip
    covariance = np.linalg.inv(np.eye(small.shape[1]) + left[:, 1:].T @ left[:, 1:] / noise**2)
    seen = covariance @ (left[:, 1:].T @ left[:, 0]) / noise**2
    less = np.full(light.size, np.nan)
    less[known] = light[known] - small @ seen
    return less, covariance * np.outer(prior, prior)


def _beside(columns: Array, values: Array) -> Array:
    """What the columns do not explain of the values, shape (n, k)."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])


def _small_at_most(found: Array) -> Array:
    """Standard deviations of the small waves' amounts, DN, shape (2 n_small,), from those of the large ones."""
    odd = math.hypot(*(float(np.linalg.norm(found[passing_wave.place(_ORDERS, order=order)])) for order in (1, 3)))
    passing = float(np.linalg.norm(found[passing_wave.place(_ORDERS)]))
    corner = [8 / order**2 * passing for order in _CORNERS]
    return np.repeat([*corner, *(3 / order * odd for order in _ODD)], 2) / math.sqrt(2)


def _usual(light: Array, columns: Array) -> Mask:
    """Frames that these waves explain as they do the others, shape (n,): a shutter's or a single bad one has no part."""
    kept = np.ones(light.size, bool)
    for _ in range(_LOOKS):
        left = light - columns @ np.linalg.lstsq(columns[kept], light[kept], rcond=None)[0]
        kept = np.abs(left) <= _OUTLIER * robust.spread(left[kept])
    return kept


def _phase(light: Array, angle: Array, *, small_left: Array) -> tuple[complex, float]:
    """The wave with which cutouts pass, and the standard uncertainty of its place on the wheel, rad; outliers have no part.

    A gain that sways mixes waves: where frames visit the wheel's angles in a slow pattern, all that it leaves is alike for long.
    And where they do so by nearly whole parts of a turn, small waves look like the passing one: ``small_left`` is the covariance
    of what the whole run leaves of them.
    """
    columns = passing_wave.waves(angle, _ORDERS)
    kept, at = _usual(light, columns), passing_wave.place(_ORDERS)
    found = np.linalg.lstsq(columns[kept], light[kept], rcond=None)[0]
    left = light - columns @ found
    normal = np.linalg.pinv(columns[kept].T @ columns[kept])
    n_kept = int(kept.sum())
    n_left = max(1, n_kept - columns.shape[1])
    white = float(np.sum(left[kept] ** 2)) / n_left * np.trace(normal[at, at])
    moved = (columns[kept] @ normal[:, at]) * left[kept, None]
    swayed = np.trace(hac_covariance(moved, n_neighbours=n_kept // _SWAYS, is_circular=False)) * n_kept / n_left
    taken = normal[at] @ columns[kept].T @ passing_wave.waves(angle[kept], _SMALL)[:, 2:]
    passed_on = float(np.trace(taken @ small_left @ taken.T))
    wave = complex(*(found[at] * (1, -1)))
    size = max(abs(wave), float(np.finfo(float).tiny))
    return wave or 1.0, float(np.sqrt((max(white, swayed) + passed_on) / 2)) / size / PASSING


def findings(angles: FrameAngles, rig: Rig, *, light_dn: Array) -> tuple[Finding, ...]:
    """A doubt where parts of the run are late by more than their noise, and by more than the stated angle of the mask may be off.

    Where they are late by whole frames, the doubt says that.

    Parameters
    ----------
    angles, rig
        Of the recording's frames, and what the owner of the rig says of the mask's.
    light_dn
        Shape (n_frame,); light of the opening in each frame of the recording.
    """
    recording = angles.recording
    if counted := renumbered.findings(angles, light_dn=light_dn):
        return counted
    late = lateness(light_dn, angles.angle_rad)
    if late is None:
        return ()
    first, last = int(np.argmin(late.angle_rad)), int(np.argmax(late.angle_rad))
    grid_rad = 0.0 if recording.events is None else TURN * recording.rotation_speed_hz * recording.events.u_grid_s
    apart = float(np.ptp(late.angle_rad))
    u = float(np.hypot.reduce([late.u_rad[first], late.u_rad[last], _OF_SLOPE * grid_rad]))
    if apart <= max(_FAR * u, 2 * rig.mask_opening.centre_angle_rad.standard_uncertainty):
        return ()
    apart_ms, u_ms = (1e3 * angle / (TURN * recording.rotation_speed_hz) for angle in (apart, u))
    return (
        Finding(
            code="run-not-steady",
            severity="doubt",
            recording=recording.name,
            what=f"the light follows the wheel {apart_ms:.3g} ms later in the part of the run from frame "
            f"{late.first_frame[last]} on than in that from frame {late.first_frame[first]} on (u = {u_ms:.2g} ms): "
            "frames were lost and renumbered, timestamps jump, or disk, mask or camera moved",
            cure="check frame_number and the trigger generator, see that nothing is loose, and record again",
        ),
    )

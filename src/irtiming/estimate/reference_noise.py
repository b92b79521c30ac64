r"""What pixels that answer unequally do to a sum over the opening: they turn the mean angle of its light.

Non-uniformity references are means of finitely many frames, so each pixel's gain is known to u_g only: the mean of both levels'
noise over the step between them and the root of the frames. The mean polar angle of the light in a sum errs by

.. math:: u^2 = \sum_p (c_p (\varphi_p - \bar\varphi) u_{g,p})^2 / (\sum_p c_p)^2

with the contrast c_p of each pixel: about u_g over the root of the pixels times the opening angle over the root of 12. It is an
angle, the same for all edges, in all recordings that were corrected with the same references. The images tell it as well: the
contrast of each pixel in a recording, less its mean over all, is what its gain errs by, and noise. The two are weighed by their
variances. Without references the gains are those of the camera, the same in all recordings, and the image alone tells them.

A pixel's contrast is what it shows over what a point of light in its place would show in the frames of that recording
(`estimate.contrast_look`). Where triggers visit the wheel's angles in slow turns, all orders of the wheel show in an image, and
what is taken for contrast would turn the light by a milliradian.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.estimate import contrast_look, steady_image
from irtiming.estimate.point_table import PointTable
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.physics import blurred_sector
from irtiming.records import sources
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rotation
from irtiming.records.wheel_geometry import WheelModel

_LEAST_RADIUS_PX = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class LightTurn:
    """By how much the mean angle of one recording's light lies beyond that of all, and what is known of it, rad.

    ``image_rad`` by the image with ``u_image_rad``, ``u_references_rad`` by the references alone.
    """

    image_rad: float
    u_image_rad: float
    u_references_rad: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Light:
    """Contrast of each summed pixel, about 1 in the opening, and its noise; shapes (roi rows, roi columns)."""

    contrast: Array
    u: Array


def shared(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], *, wheel: WheelModel, rotation: Rotation
) -> list[SharedNumber]:
    """One number per set of references, in units of its standard uncertainty; none where axle or references are not known.

    Levels that sway by chance as the wheel turns would be light on all pixels, with a mean angle of its own: they are taken off.

    Parameters
    ----------
    recordings, fits
        In the same order, of a snapshot photon camera.
    wheel
        That the fits used.
    rotation
        Of the wheel as the camera sees it.
    """
    if any(one.axle is None or one.contrast is None or "u_gain" not in one.pixel_maps for one in recordings):
        return []
    steady = [steady_image.by_sums(one, fit) for one, fit in zip(recordings, fits, strict=True)]
    turns = light_turns(steady, wheel=wheel, rotation=rotation)
    sense = -1.0 if rotation == "clockwise" else 1.0
    found = []
    for number, name in enumerate(dict.fromkeys(one.references for one in recordings)):
        members = [k for k, one in enumerate(recordings) if one.references == name]
        turn_rad = float(np.mean([turns[k].image_rad for k in members]))
        u_image = float(np.mean([turns[k].u_image_rad for k in members])) / np.sqrt(len(members))
        u_references = float(np.mean([turns[k].u_references_rad for k in members]))
        if not u_references > 0:
            continue
        share = u_references**2 / (u_references**2 + u_image**2)
        u = float(np.sqrt(share)) * u_image
        effects = [
            dict.fromkeys(EDGE_DELAYS, sense * u / fit.angular_frequency_rad_per_s) if k in members else {}
            for k, fit in enumerate(fits)
        ]
        found.append(
            SharedNumber(
                name=f"{sources.REFERENCES} {number}",
                unit="1",
                effects=effects,
                u=1.0,
                known=share * turn_rad / u,
                start=share * turn_rad / u,
                source=sources.REFERENCES,
                kind="A",
            )
        )
    return found


def light_turns(recordings: Sequence[ReducedRecording], *, wheel: WheelModel, rotation: Rotation) -> list[LightTurn]:
    """What image and references tell of each recording's light.

    Parameters
    ----------
    recordings
        With axle, contrast image and the pixel map ``u_gain``.
    wheel, rotation
        As for `shared`.
    """
    lights = [_light(one, wheel, rotation=rotation) for one in recordings]
    contrast, u = (np.array([getattr(one, name) for one in lights]) for name in ("contrast", "u"))
    known = np.where(u > 0, u, np.inf) ** -2.0
    mean = np.sum(known * contrast, axis=0) / np.maximum(known.sum(axis=0), np.finfo(float).tiny)
    angle = _places(recordings[0]).angle_rad
    whole = float(mean.sum())
    beside = angle - float(np.sum(mean * angle)) / whole
    return [
        LightTurn(
            image_rad=float(np.sum(light.contrast * beside)) / float(light.contrast.sum()),
            u_image_rad=float(np.sqrt(np.sum((light.u * beside) ** 2))) / whole,
            u_references_rad=float(np.sqrt(np.sum((mean * beside * one.pixel_maps["u_gain"]) ** 2))) / whole,
        )
        for one, light in zip(recordings, lights, strict=True)
    ]


def _light(one: ReducedRecording, wheel: WheelModel, *, rotation: Rotation) -> _Light:
    """What each pixel shows over what a point of light in its place would show, as much of it as is in phase with that."""
    (look,) = contrast_look.looks([one], wheel, timing=contrast_look.as_stated(one))
    box = np.s_[slice(*one.opening.roi[:2]), slice(*one.opening.roi[2:])]
    mask, weight, places = one.opening.mask[box], one.opening.weight[box], _places(one)
    on_wheel_rad = places.angle_rad if rotation == "clockwise" else -places.angle_rad
    table = PointTable(table=look.point.table + look.odd.table)
    point = table.smeared(on_wheel_rad, width_rad=places.reach_rad)
    point = point * np.exp(1j * np.angle(np.vdot(point[mask], look.projection[mask])))
    along = (look.projection * point.conj()).real / np.abs(point) ** 2
    scale = float(np.median(along[mask]))
    return _Light(contrast=weight * along / scale, u=weight * look.u_dn / (scale * np.abs(point)))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Places:
    """Polar angle of each pixel about the axle from the opening's mean direction, and that over which it gathers its light.

    Shapes (roi rows, roi columns).
    """

    angle_rad: Array
    reach_rad: Array


def _places(one: ReducedRecording) -> _Places:
    axle, roi = one.axle, one.opening.roi
    assert axle is not None
    down = np.arange(roi[0], roi[1])[:, None] - axle.row_px
    across = np.arange(roi[2], roi[3])[None, :] - axle.column_px
    return _Places(
        angle_rad=np.angle(np.exp(1j * (np.arctan2(down, across) - axle.bisector_rad))),
        reach_rad=blurred_sector.reach_px(axle.blur_px) / np.maximum(np.hypot(down, across), _LEAST_RADIUS_PX),
    )

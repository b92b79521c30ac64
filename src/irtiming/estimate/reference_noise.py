r"""What pixels that answer unequally do to a sum over the opening: they turn the mean angle of its light.

Non-uniformity references are means of finitely many frames, so each pixel's gain is known to u_g only: the mean of both levels'
noise over the step between them and the root of the frames. The mean polar angle of the light in a sum errs by

.. math:: u^2 = \sum_p (c_p (\varphi_p - \bar\varphi) u_{g,p})^2 / (\sum_p c_p)^2

with the contrast c_p of each pixel: about u_g over the root of the pixels times the opening angle over the root of 12. It is an
angle, the same for all edges, in all recordings that were corrected with the same references. The images tell it as well: the
contrast of each pixel in a recording, less its mean over all, is what its gain errs by, and noise. The two are weighed by their
variances. Without references the gains are those of the camera, the same in all recordings, and the image alone tells them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.estimate import steady_image
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.records import sources
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rotation


@final
@dataclass(frozen=True, kw_only=True)
class LightTurn:
    """By how much the mean angle of one recording's light lies beyond that of all, and what is known of it, rad.

    ``image_rad`` by the image with ``u_image_rad``, ``u_references_rad`` by the references alone.
    """

    image_rad: float
    u_image_rad: float
    u_references_rad: float


def shared(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], *, rotation: Rotation
) -> list[SharedNumber]:
    """One number per set of references, in units of its standard uncertainty; none where axle or references are not known.

    Levels that sway by chance as the wheel turns would be light on all pixels, with a mean angle of its own: they are taken off.

    Parameters
    ----------
    recordings, fits
        In the same order, of a snapshot photon camera.
    rotation
        Of the wheel as the camera sees it.
    """
    if any(one.axle is None or one.contrast is None or "u_gain" not in one.pixel_maps for one in recordings):
        return []
    turns = light_turns([steady_image.by_sums(one, fit) for one, fit in zip(recordings, fits, strict=True)])
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


def light_turns(recordings: Sequence[ReducedRecording]) -> list[LightTurn]:
    """What image and references tell of each recording's light.

    Parameters
    ----------
    recordings
        With axle, contrast image and the pixel map ``u_gain``.
    """
    lights = [_light(one) for one in recordings]
    u_pixel = [one.contrast_image.u_dn / scale for one, (_, scale) in zip(recordings, lights, strict=True)]
    weight = np.array([1 / u**2 for u in u_pixel])
    mean = np.average([light for light, _ in lights], axis=0, weights=weight)
    angle = _angle_rad(recordings[0])
    whole = float(mean.sum())
    beside = angle - float(np.sum(mean * angle)) / whole
    return [
        LightTurn(
            image_rad=float(np.sum(light * beside)) / float(light.sum()),
            u_image_rad=u * float(np.sqrt(np.sum(beside[mean > 0] ** 2))) / whole,
            u_references_rad=float(np.sqrt(np.sum((mean * beside * one.pixel_maps["u_gain"]) ** 2))) / whole,
        )
        for one, (light, _), u in zip(recordings, lights, u_pixel, strict=True)
    ]


def _light(one: ReducedRecording) -> tuple[Array, float]:
    """Contrast of each summed pixel, about 1 in the opening, shape (roi rows, roi columns); and what it is over, DN.

    The size of its second harmonic in the direction of the phase that its place on the wheel asks for.
    """
    image, box = one.contrast_image, np.s_[slice(*one.opening.roi[:2]), slice(*one.opening.roi[2:])]
    mask, weight = one.opening.mask[box], one.opening.weight[box]
    turned = image.projection_dn * np.exp(2j * _angle_rad(one))
    other = image.projection_dn * np.exp(-2j * _angle_rad(one))
    turned = max((turned, other), key=lambda picture: abs(np.sum(picture[mask])))
    along = (turned * np.exp(-1j * np.angle(np.sum(turned[mask])))).real
    scale = float(np.median(along[mask]))
    return weight * along / scale, scale


def _angle_rad(one: ReducedRecording) -> Array:
    """Polar angle of each pixel about the axle, from the opening's mean direction, shape (roi rows, roi columns)."""
    axle, roi = one.axle, one.opening.roi
    if axle is None:
        return np.zeros((roi[1] - roi[0], roi[3] - roi[2]))
    down = np.arange(roi[0], roi[1])[:, None] - axle.row_px
    across = np.arange(roi[2], roi[3])[None, :] - axle.column_px
    return np.asarray(np.angle(np.exp(1j * (np.arctan2(down, across) - axle.bisector_rad))))

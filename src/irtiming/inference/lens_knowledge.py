r"""What is known of camera and lens before the image is looked at: from rig.toml, or what no camera on such a rig exceeds.

Cameras that are set up by eye are half a degree to two off the wheel's normal, a lens centre is off the image's
middle by 1 to 3 per cent of its width, and thermal lenses see fields of 9 to 53 degrees across the diagonal. The image says more:
these are for where it does not.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import GeometryError
from irtiming.physics import lens
from irtiming.records.arrays import Array
from irtiming.records.rig import CameraOptics, LensCalibration, Measured
from irtiming.records.row_timing import LensTerms

LENS_NUMBERS = ("distortion", "log_focal_length", "lens_row_px", "lens_column_px")
"""Numbers of the sector's shape of which something is known beforehand."""

CAMERA_NUMBERS = (*LENS_NUMBERS, "tilt_row", "tilt_column", "axis_row_px", "axis_column_px", "quartic")
"""The same, both tilts, as sines, where the pinhole's axis lies beside the centre of the distortion, and OpenCV's k_2."""

U_GLARE = 0.03
"""Of the share of light that goes astray: makers of lenses state 1 to 3 %."""

U_BLUR_GROWTH = 1.5
"""Of the blur's variance, over half a diagonal: in the corners few lenses are more than twice as blurred as in the middle."""

_USUAL_DISTORTION = Measured(0.0, 0.05)  # few lenses exceed twice that, over half a diagonal
_TILT_U_RAD = math.radians(1.2)
_QUARTIC_U = 0.02  # over half a diagonal: k_2 of a wide lens whose k is at the limit of what is usual
_CENTRE_U = 0.02  # of the image's width
_FOCAL_LENGTH, _FOCAL_LENGTH_U = math.log(5.0), math.log(2.5)  # half diagonals


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LensKnowledge:
    """What is known of LENS_NUMBERS, and the further terms of a calibrated lens.

    ``u_axis_px`` and ``u_quartic`` say how far an uncalibrated lens may have them beside zero.
    """

    known: Mapping[str, Measured]
    terms: LensTerms
    u_axis_px: float = 0.0
    u_quartic: float = 0.0

    @property
    def start(self) -> dict[str, float]:
        """Values to begin with."""
        return {name: one.value for name, one in self.known.items()}

    @property
    def held(self) -> tuple[str, ...]:
        """Numbers that count as exact."""
        return tuple(name for name, one in self.known.items() if one.standard_uncertainty == 0)

    def prior(self, name: str) -> Measured:
        """What is known of one of CAMERA_NUMBERS."""
        if name in self.known:
            return self.known[name]
        u = {"axis_row_px": self.u_axis_px, "axis_column_px": self.u_axis_px, "quartic": self.u_quartic}
        return Measured(0.0, u.get(name, _TILT_U_RAD))

    def off(self, numbers: Mapping[str, float]) -> Array:
        """Deviations from what is known over its uncertainties: of LENS_NUMBERS, then of both tilts, shape (N_KNOWN,)."""
        focal_length = math.exp(numbers["log_focal_length"])
        tilts = [focal_length * numbers[name] / _TILT_U_RAD for name in ("keystone_row", "keystone_column")]
        stated = [
            (numbers[name] - one.value) / one.standard_uncertainty if one.standard_uncertainty else 0.0
            for name, one in ((name, self.known[name]) for name in LENS_NUMBERS)
        ]
        return np.array([*stated, *tilts])


N_KNOWN = len(LENS_NUMBERS) + 2
"""Length of what `LensKnowledge.off` gives."""


def knowledge(camera: CameraOptics, *, image: tuple[int, ...]) -> LensKnowledge:
    """What rig.toml says of the lens, for an image of so many rows and columns; the wide priors where it says nothing.

    Parameters
    ----------
    camera
        Of rig.toml.
    image
        Rows and columns of the whole image.

    Raises
    ------
    GeometryError
        If no lens that shows the whole image has the distortion that is stated.
    """
    unit, calibration = math.hypot(*image) / 2, camera.calibration
    if calibration is not None:
        known = _placed(calibration.focal_length_px[0], calibration.centre_px, image=image)
        return LensKnowledge(
            known=known | {"distortion": _as_calibrated(calibration, unit)}, terms=_terms(calibration, unit)
        )
    known = {
        "distortion": _as_stated(camera, image=image),
        "log_focal_length": Measured(_FOCAL_LENGTH, _FOCAL_LENGTH_U),
        "lens_row_px": Measured(0.0, _CENTRE_U * image[1]),
        "lens_column_px": Measured(0.0, _CENTRE_U * image[1]),
    }
    return LensKnowledge(
        known=known | _placed(camera.focal_length_px, camera.lens_centre_px, image=image),
        terms=LensTerms(),
        u_axis_px=_CENTRE_U * image[1],
        u_quartic=_QUARTIC_U,
    )


def _placed(
    focal_length_px: Measured | None, centre_px: tuple[Measured, Measured] | None, *, image: tuple[int, ...]
) -> dict[str, Measured]:
    """Focal length and lens centre as the sector's shape has them, as far as stated."""
    found = {}
    if focal_length_px is not None:
        unit, value = math.hypot(*image) / 2, focal_length_px.value
        found["log_focal_length"] = Measured(math.log(value / unit), focal_length_px.standard_uncertainty / value)
    if centre_px is not None:
        for name, size, one in zip(("lens_column_px", "lens_row_px"), (image[1], image[0]), centre_px, strict=True):
            found[name] = Measured(one.value - (size - 1) / 2, one.standard_uncertainty)
    return found


def _as_stated(camera: CameraOptics, *, image: tuple[int, ...]) -> Measured:
    """Distortion over half a diagonal, of that over half the image's width as rig.toml has it; or what lenses have."""
    if camera.distortion is None:
        return _USUAL_DISTORTION
    return _in_half_diagonals(
        camera.distortion,
        (math.hypot(*image) / image[1]) ** 2,
        must=f"[camera] distortion = {camera.distortion.value:g} is not that of a lens that shows all of an image of "
        f"{image[0]} x {image[1]} pixels; it must be",
        cure=": k1 over half the image's width",
    )


def _as_calibrated(calibration: LensCalibration, unit: float) -> Measured:
    """The same, of k_1 of lengths over the focal length."""
    first, focal_length_px = calibration.coefficients[0], calibration.focal_length_px[0].value
    return _in_half_diagonals(
        first,
        (unit / focal_length_px) ** 2,
        must=f"[camera] distortion_coefficients begin with {first.value:g}, at a focal length of {focal_length_px:g} px k1 "
        "must be",
        cure=", or corners of the image have no place in the scene; check that camera_matrix and coefficients are of this "
        "lens, in the order of OpenCV, and region_origin_px of this image",
    )


def _in_half_diagonals(k1: Measured, scale: float, *, must: str, cure: str) -> Measured:
    """Distortion over half a diagonal, of one over a length that is shorter by the root of the scale."""
    k = Measured(k1.value * scale, k1.standard_uncertainty * scale)
    if not lens.LOWEST <= k.value <= lens.HIGHEST:
        raise GeometryError(f"{must} from {lens.LOWEST / scale:.3f} to {lens.HIGHEST / scale:.3f}{cure}")
    return k


def _terms(calibration: LensCalibration, unit: float) -> LensTerms:
    across, down = (one.value for one in calibration.focal_length_px)
    (_, quartic, first, second, sextic), scale = calibration.coefficients, unit / across
    return LensTerms(
        quartic=quartic * scale**4,
        sextic=sextic * scale**6,
        tangential_row=first * scale,
        tangential_column=second * scale,
        row_stretch=down / across,
    )

"""What the image says of the opening whose sum is fitted: extent, ends, what shows beside it and what of it goes astray."""

import numpy as np

from irtiming.physics.light.summed_region import SummedRegion, radii_px, together
from irtiming.records.arrays import Array
from irtiming.records.reduced import ReducedRecording

_U_UNKNOWN_RAD = 0.01
_EXTENT = (0.02, 0.98)  # of the pixels' radii


def edge_misalignments(reduced: ReducedRecording, *, turns_clockwise: bool) -> tuple[Array, float]:
    """Edge misalignments: angles by which the ends of the opening lean in the image, low and high wheel coordinate; and u, rad.

    Zero, with a wide uncertainty, where the image does not tell.

    Parameters
    ----------
    reduced
        Its axle view.
    turns_clockwise
        As the camera sees the wheel: wheel coordinates grow against polar angles then.

    Returns
    -------
    Shape (2,), and the standard uncertainty of either.
    """
    radii, axle = radii_px(reduced.opening, reduced.axle), reduced.axle
    if radii is None or axle is None or axle.edge_miss_px is None:
        return np.zeros(2), _U_UNKNOWN_RAD
    inner, outer = extent_px(reduced, radii)
    miss = np.array(axle.edge_miss_px)
    misalignment_px = -miss[::-1] if turns_clockwise else miss
    return 2 * misalignment_px / (inner + outer), 2 * axle.u_edge_miss_px / (inner + outer)


def plate(reduced: ReducedRecording) -> SummedRegion | None:
    """Where the summed pixels see the mask plate, as the image shows it; None where the image was not looked at."""
    axle = reduced.axle
    return None if axle is None else _region(axle.beside_ends_rad, axle.plate_share)


def uneven(reduced: ReducedRecording) -> SummedRegion | None:
    """What uneven wheel, dead and uneven pixels add to the sum, as a share of it; None where the image shows none of them."""
    axle = reduced.axle
    if axle is None:
        return None
    return together(_region(axle.beside_ends_rad, axle.uneven_share), _region(axle.pixels_ends_rad, axle.pixels_share))


def extent_px(reduced: ReducedRecording, distance: Array) -> tuple[float, float]:
    """Inner and outer radius of the opening: of the sector in the image, else nearly those of its pixels, ``distance`` (n,)."""
    if reduced.axle is not None and reduced.axle.radii_px is not None:
        return reduced.axle.radii_px
    inner, outer = np.quantile(distance, _EXTENT)
    return float(inner), float(outer)


def lost(reduced: ReducedRecording) -> SummedRegion | None:
    """What part of the opening's light leaves the summed pixels, were all of it glare; None where the image was not looked at."""
    axle = reduced.axle
    return None if axle is None else _region(axle.lost_ends_rad, axle.lost_share)


def _region(ends_rad: tuple[float, ...], share: tuple[float, ...]) -> SummedRegion | None:
    """Of an axle view; None where it has no shares."""
    return SummedRegion(ends_rad=np.array(ends_rad), share=np.array(share)) if share else None


def glare(reduced: ReducedRecording) -> tuple[float, float]:
    """Share of the light that goes astray, and its standard uncertainty; 0, exactly, where the image was not looked at."""
    axle = reduced.axle
    return (0.0, 0.0) if axle is None else (axle.glare, axle.u_glare)

"""What openings in an image usually are, and what none is: where a search ends so, it has found something else."""

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.sector_image import GLARE_PX
from irtiming.inference.lens_knowledge import U_BLUR_GROWTH, U_GLARE
from irtiming.physics import lens
from irtiming.physics.edge_motion import Contradiction
from irtiming.records.arrays import Array

_U_GLARE_WIDTH = 0.7  # prior: of the width's logarithm
_RING_MARGIN_PX = 2.0  # how far, roughly, a cutout reaches beyond the opening
_AT_LIMIT = 1e-3  # of the distortion
_LEAST_RADIAL_PX, _NARROWEST_RAD = 3.0, 0.1
_FARTHEST_OFF = 0.3  # of the outer radius: how far the middle of the opening's arcs may lie beside the axle

FARTHEST_CENTRE = 0.2
"""Of the image's width: lens centres are off its middle by a tenth of that."""


Sense: TypeAlias = Callable[[], Contradiction | None]


def _nothing() -> None:
    """No contradiction that is known of."""


def check(numbers: Mapping[str, float], name: str, *, sense: Sense = _nothing) -> None:
    """Refuse what is no annular sector about the axle.

    Parameters
    ----------
    numbers
        Of the sector, where its search ended.
    name
        Of the recording.
    sense
        Asked, where there is none, what the edges' way says against the stated rotation: then that is why.

    Raises
    ------
    EstimationError
        If it is none.
    """
    inner, outer, angle = (numbers[one] for one in ("inner_radius_px", "outer_radius_px", "opening_angle_rad"))
    off, most_off = float(np.hypot(numbers["offset_row_px"], numbers["offset_column_px"])), _FARTHEST_OFF * outer
    if not (outer > inner and angle > 0):
        what = "no radii and no angle fit the contrast image"
    elif not outer - inner > _LEAST_RADIAL_PX:
        what = f"from its inner to its outer radius it would be {outer - inner:.1f} px, more than {_LEAST_RADIAL_PX:g} must be"
    elif not _NARROWEST_RAD < angle < np.pi:
        least = np.degrees(_NARROWEST_RAD)
        what = f"it would be {np.degrees(angle):.1f} deg wide, from {least:.1f} to 180 deg must be"
    elif not off < most_off:
        what = f"its centre would lie {off:.1f} px beside the axle, at most {most_off:.1f} px can be"
    else:
        return
    _refuse_sense(name, sense)
    raise EstimationError(
        f"{name}: the opening does not look like an annular sector about the axle: {what}; the whole opening must be in view, "
        "sharp, and covered by the wheel alone, the image not mirrored, and [wheel] rotation as the camera sees it"
    )


def _refuse_sense(name: str, sense: Sense) -> None:
    if (found := sense()) is not None:
        raise EstimationError(
            f"{name}: the image shows edges that move {found.way}; {found.stated} means the other way: correct one of them, or "
            "the image is mirrored"
        )


def check_lens(
    numbers: Mapping[str, float],
    known: Mapping[str, float],
    *,
    name: str,
    columns: int,
    sense: Sense = _nothing,
) -> None:
    """Refuse what only a lens that there is not would show: such a search has found no sector, and would go on for long.

    Parameters
    ----------
    numbers
        Of the sector, where its search ended.
    known
        Where the lens centre was thought to be, by the same names.
    name
        Of the recording.
    columns
        Of the image.
    sense
        As for `check`.

    Raises
    ------
    EstimationError
        If the distortion is at its limit or the lens centre far from where it was thought to be.
    """
    distortion, least = numbers["distortion"], lens.LOWEST + _AT_LIMIT
    down, right = (numbers[one] - known[one] for one in ("lens_row_px", "lens_column_px"))
    beside, most = float(np.hypot(down, right)), FARTHEST_CENTRE * columns
    if distortion >= least and beside <= most:
        return
    _refuse_sense(name, sense)
    what = (
        f"its distortion would be {distortion:.4f} over half a diagonal, at least {least:.4f} can be"
        if distortion < least
        else f"its centre would lie {beside:.0f} px from the middle of the image or from where rig.toml has it, at most "
        f"{most:.0f} px can be"
    )
    raise EstimationError(
        f"{name}: no lens shows an opening as the contrast image has it: {what}; look for a cable, a finger or an edge "
        "before the mask, shade it from stray light and mirrors, give the frames as the camera made them, neither stretched "
        "one by one nor turned nor cut, or state the lens in [camera]"
    )


def off_usual(numbers: Mapping[str, float]) -> Array:
    """A loose word on cutouts, plate's reflection, glare and the blur's growth, for where they do not show, shape (N_USUAL,).

    Parameters
    ----------
    numbers
        All of a sector's, by name.
    """
    inner = numbers["inner_radius_px"] - numbers["ring_inner_px"]
    outer = numbers["ring_outer_px"] - numbers["outer_radius_px"]
    margins = [(margin - _RING_MARGIN_PX) / _RING_MARGIN_PX for margin in (inner, outer)]
    glare = numbers["glare"] / U_GLARE, math.log(numbers["glare_px"] / GLARE_PX) / _U_GLARE_WIDTH
    return np.array([*margins, numbers["plate_reflection"], *glare, numbers["blur_growth"] / U_BLUR_GROWTH])


N_USUAL = 6
"""Length of what `off_usual` gives."""

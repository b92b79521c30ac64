"""What all recordings of a camera on a rig share, one name each: what is sought, and every error that is known to a size.

A nuisance parameter is one `SharedNumber`: its name, what is known of it, and by how much one unit of it changes the local
numbers of each recording. It then takes part in the fit, the budget, the profiles and the report by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.inference.information import NOISE, EvaluationType
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics.camera import EXACT_SHARE
from irtiming.physics.covariance import generalised_inverse, root
from irtiming.physics.latency import EXACT_S
from irtiming.physics.response import in_camera_filter, integration_window, pixel_memory
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records import sources
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, RecordingFit
from irtiming.records.rig import Measured, WindowTail
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry

_OF_CAMERA = (*SLIGHT, *WARP_NUMBERS)

DELAY = "delay"
"""Delay of the camera, common to all wheel edges: to the reading of row 0, or to the middle of its integration window."""

MEMORIES = (in_camera_filter.PARAMETER, pixel_memory.PARAMETER)
"""Shares of the frame before, by a filter of the camera or in its pixels."""

STRAIGHT_RAD = 2e-3
"""To which angle about the axle mask edges are straight: burrs of 0.05 mm, 27 mm from it."""


_LONGER = 6.0  # over its length: by how much longer a window looks per variance, which is T^2 / 12


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SharedNumber:
    """One number that all recordings share.

    Parameters
    ----------
    name, unit
        Of it; errors are counted in units of their standard uncertainty, "1".
    start, other_starts
        Where the search begins, and where it begins again; the lowest minimum counts.
    effects
        One per recording; by how much each local number changes per unit, those that do not change left out.
    u, known
        What is known of it beforehand, standard uncertainty and value; None: nothing.
    source, kind
        Who knows it, as a budget names it.
    may_be_mirrored
        Whether its other sign looks nearly alike.
    turns_edges
        Whether it is an error of the wheel's angles.
    measured
        Standard uncertainty and unit of a measured quantity, where this follows from one such number.
    """

    name: str
    effects: Sequence[Mapping[str, float]]
    unit: str = "s"
    start: float = 0.0
    other_starts: tuple[float, ...] = ()
    u: float | None = None
    known: float = 0.0
    source: str = NOISE
    kind: EvaluationType = "A"
    may_be_mirrored: bool = False
    turns_edges: bool = False
    measured: tuple[float, str] | None = None


def design(shared: Sequence[SharedNumber], recording: int, *, names: tuple[str, ...]) -> Array:
    """What makes the local numbers of one recording of the shared ones, shape (k, n)."""
    return np.array([[one.effects[recording].get(name, 0.0) for one in shared] for name in names])


def delay(fits: Sequence[RecordingFit], *, start: float) -> SharedNumber:
    """The camera's own, with the delay set taken off."""
    return SharedNumber(name=DELAY, start=start, effects=[dict.fromkeys(EDGE_DELAYS, 1.0)] * len(fits))


def same(
    name: str, fits: Sequence[RecordingFit], *, start: float, unit: str = "s", u: float | None = None
) -> SharedNumber:
    """A local number that is the same in all recordings.

    Parameters
    ----------
    name, unit
        Of it.
    fits
        One per recording.
    start
        Where the search begins.
    u
        Standard uncertainty with which it is known to be there beforehand; None: nothing is known.
    """
    return SharedNumber(
        name=name, unit=unit, start=start, effects=[{name: 1.0}] * len(fits), known=start, u=u,
        may_be_mirrored=name.startswith("lean"),
    )  # fmt: skip


def memory(name: str, fits: Sequence[RecordingFit], *, start: float) -> SharedNumber:
    """The share of the frame before, with what is known of it where nothing is stated.

    Parameters
    ----------
    name
        Of `MEMORIES`.
    fits
        One per recording.
    start
        Where the search begins.
    """
    u_share = {one.PARAMETER: one.U_SHARE for one in (in_camera_filter, pixel_memory)}[name]
    return replace(same(name, fits, unit="1", start=start, u=u_share), known=0.0)


def with_stated_memory(own: Sequence[SharedNumber], stated: Measured | None) -> list[SharedNumber]:
    """The camera's numbers with what its owner knows of the share of the frame before.

    Parameters
    ----------
    own
        Of the camera, a share of the frame before perhaps among them.
    stated
        That share; None leaves it to the frames.
    """
    if stated is None:
        return list(own)
    return _stated_numbers(own, MEMORIES, stated=stated, least_u=EXACT_SHARE, source=sources.MEMORY)


def with_stated_window(own: Sequence[SharedNumber], *, stated_s: float, u_s: float | None) -> list[SharedNumber]:
    """The camera's numbers with what its owner knows of the length of the window.

    Parameters
    ----------
    own
        Of the camera, the integration time among them or not.
    stated_s, u_s
        What the recordings state, and its standard uncertainty; None leaves it to the frames.
    """
    if u_s is None:
        return list(own)
    name, stated = integration_window.PARAMETER, Measured(stated_s, u_s)
    return _stated_numbers(own, (name,), stated=stated, least_u=EXACT_S, source=sources.WINDOW)


def _stated_numbers(
    own: Sequence[SharedNumber], names: Sequence[str], *, stated: Measured, least_u: float, source: str
) -> list[SharedNumber]:
    """The same, with what is stated of those of these names; one that counts as exact has the least uncertainty."""
    u = stated.standard_uncertainty
    return [
        replace(one, known=stated.value, u=max(u, least_u), source=source, kind="B", measured=(u, one.unit))
        if one.name in names
        else one
        for one in own
    ]


def window_tails(
    fits: Sequence[RecordingFit], tail: WindowTail, *, integration_time_s: float | None
) -> list[SharedNumber]:
    """Shares that come after the window's end; delays count to the centre, so that only their width shows in the frames.

    Parameters
    ----------
    fits
        One per recording; sums of pixels show it as it is, sums of rows as a longer window.
    tail
        What is known of them together.
    integration_time_s
        Length of the window as stated; None where it is not, so that sums of rows say it.
    """
    found = []
    for name, part in integration_window.tails(tail).items():
        effects = [
            _longer(fit, part, integration_time_s) if isinstance(fit, RowTimingFit) else {name: 1.0} for fit in fits
        ]
        found.append(
            SharedNumber(
                name=name, unit="1", effects=effects, start=part.share.value, known=part.share.value,
                u=max(part.share.standard_uncertainty, EXACT_SHARE), source=sources.TAIL, kind="B",
                measured=(tail.share.standard_uncertainty, "1"),
            )
        )  # fmt: skip
    return found


def _longer(fit: RowTimingFit, tail: WindowTail, stated_s: float | None) -> dict[str, float]:
    """By how much longer the window of these rows looks per share that comes after it."""
    window = integration_window.PARAMETER
    if window not in fit.estimate:
        return {}
    length_s = abs(fit.timing[window]) if stated_s is None else stated_s
    wider_s2 = integration_window.tail_variance_s2(length_s, tail.time_constant_s)
    return {window: _LONGER * wider_s2 / max(length_s, tail.time_constant_s)}


def rig_errors(fits: Sequence[RecordingFit], geometry: WheelGeometry, *, u_edge_rad: float) -> list[SharedNumber]:
    """Errors of the wheel's angles: of every edge alike by source, and of each cutout edge.

    Parameters
    ----------
    fits
        One per recording; of each the wheel's speed counts.
    geometry
        Sizes of the common errors.
    u_edge_rad
        Standard uncertainty of one cutout edge.
    """
    kind: EvaluationType = "A" if geometry.u_edge_rad is None else "B"
    errors = [
        _turned(f"cutout edge {k}", fits, column, source=sources.EDGES, kind=kind)
        for k, column in enumerate(u_edge_rad * np.eye(4))
    ]
    errors += [
        replace(
            _turned(source, fits, np.full(4, u), source=source, kind="A" if kind == "A" else "B"),
            measured=geometry.measured.get(source, (u, "rad")),
        )
        for source, kind, u in geometry.angle_budget
    ]
    return errors


def uneven_edges(fits: Sequence[RecordingFit]) -> SharedNumber:
    """What rounds the corners of pixel sums beside the window and the leans: radial mask edges that are not straight.

    It is an angle, the same at any wheel speed, which is what tells it from the window. Taken on trust is its size, with one
    standard uncertainty a scatter of `STRAIGHT_RAD` along an edge; its square may come out negative as well as positive.

    Parameters
    ----------
    fits
        One per recording.
    """
    return SharedNumber(
        name=sources.STRAIGHTNESS, unit="1", effects=[{"corner_variance": STRAIGHT_RAD**2}] * len(fits), u=1.0,
        source=sources.STRAIGHTNESS, kind="B",
    )  # fmt: skip


def residual_errors(fits: Sequence[RecordingFit], covariance_rad2: Array) -> list[SharedNumber]:
    """What the residuals of all recordings share, as errors of the edges' angles.

    Parameters
    ----------
    fits
        One per recording; of each the wheel's speed counts.
    covariance_rad2
        Shape (4, 4); of the edges' angles.
    """
    return [
        _turned(f"{sources.RESIDUALS} {k}", fits, column, source=sources.RESIDUALS, kind="A")
        for k, column in enumerate(root(covariance_rad2).T)
    ]


def _turned(
    name: str, fits: Sequence[RecordingFit], per_unit_rad: Array, *, source: str, kind: EvaluationType
) -> SharedNumber:
    """An error, counted in its standard uncertainty, by which the four edges come early by ``per_unit_rad``."""
    effects = [
        dict(zip(EDGE_DELAYS, (per_unit_rad / fit.angular_frequency_rad_per_s).tolist(), strict=True)) for fit in fits
    ]
    return SharedNumber(name=name, unit="1", effects=effects, u=1.0, source=source, kind=kind, turns_edges=True)


def image_errors(fits: Sequence[RecordingFit], sectors: Sequence[SectorFit]) -> list[SharedNumber]:
    """Errors of the opening's shape in the image, by what each fit owes to them.

    What camera and lens add, tilt, focal length, distortion and lens centre, has a line of its own: it is what would go if
    they were known.

    Parameters
    ----------
    fits, sectors
        In the same order; the errors of one sector are common to all fits that used it.
    """
    errors = []
    each = list({id(sector): sector for sector in sectors}.values())
    for g, sector in enumerate(each):
        for name, source, error in _image_parts(sector):
            effects = [
                dict(zip(fit.estimate.names, (fit.shape_effect @ error).tolist(), strict=True))
                if own is sector and fit.shape_effect is not None
                else {}
                for fit, own in zip(fits, sectors, strict=True)
            ]
            errors.append(
                SharedNumber(
                    name=name if len(each) == 1 else f"{name} of image {g + 1}",
                    unit="1", effects=effects, u=1.0, source=source, kind="A",
                )
            )  # fmt: skip
    return errors


def _image_parts(sector: SectorFit) -> list[tuple[str, str, Array]]:
    """Independent errors of the sector's numbers: a name, who owes them, and the error (n_shape,) in standard uncertainties."""
    whole, at = sector.covariance, [k for k, name in enumerate(sector.names) if name in _OF_CAMERA]
    own = whole[np.ix_(at, at)]
    by_camera = whole[:, at] @ generalised_inverse(own, flat=1e-10) @ whole[at]
    rest = whole - by_camera
    rest[at, :] = rest[:, at] = 0.0
    parts = ((sources.IMAGE, root(rest)), (sources.LENS, root(by_camera)))
    return [
        (f"{source}, combination {m}", source, error)
        for source, errors in parts
        for m, error in enumerate((error for error in errors.T if error.any()), start=1)
    ]

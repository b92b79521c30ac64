r"""What one run of a camera whose rows are summed can tell (`physics.light.row_sum`; Schatz 2023, eq. 1 to 3).

Samples that stand evenly over the turn see the harmonics of a row apart, so the information on the delays d_i of the four edges,
the response's parameter and t_row is a sum over rows and harmonics; gain and offset of each row are its own. The delays are
d_i = t_delay + (e + e_i) / omega; of a photon camera they are those of the window's middle, half the window later.

The place and shape of the opening come from the image of the second harmonic, where each pixel's phase is twice its polar angle:
noise, the pixels' gains and what is known of lens and tilt set how well. Its errors are common to all runs of a set, and move
those numbers by one linear step. Lens and tilt displace the image by a warp (`physics.warp`); all of them that image and prior
knowledge allow (`inference.weighed_lens`) count as if their warps were normal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, final

import numpy as np
from scipy import ndimage

from irtiming.inference import in_threads, weighed_lens
from irtiming.inference.information import NOISE, Information, without_own
from irtiming.inference.lens_knowledge import U_BLUR_GROWTH, U_GLARE, LensKnowledge
from irtiming.physics import blurred_sector, sector_points, wheel_harmonics
from irtiming.physics import camera as physics_camera
from irtiming.physics.blur_shape import EXCHANGES, U_EXCHANGED, exchanged
from irtiming.physics.covariance import generalised_inverse
from irtiming.physics.light import pixel_waves, row_sum, sector_rows
from irtiming.physics.light.row_sum import RowSum, Timing
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.physics.wheel import TURN
from irtiming.plan.information import RunInformation, run_information
from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.records.prediction import AngleErrors
from irtiming.records.row_timing import SectorShape
from irtiming.records.sources import EDGES, IMAGE
from irtiming.records.wheel_geometry import WheelModel

_LEAST_LIGHT_PX2 = 3.0
_IN_LIGHT = 0.05  # px^2: what a pixel has that counts to the row for sure
_ROWS = 50  # at least, that are looked at
_BORDER_PX = 5.0  # that the reduction adds to both ends of a row, roughly
_OPENING = (
    "axle_row_px", "axle_column_px", "offset_row_px", "offset_column_px", "inner_radius_px", "outer_radius_px",
    "bisector_rad", "opening_angle_rad", "blur_px", "blur_ellipticity", "blur_correlation", "blur_growth",
    "glare",
)  # fmt: skip
_SHAPE = (*_OPENING, *WARP_NUMBERS)
_STEPS = (
    dict.fromkeys(_OPENING, 3e-3)
    | {"bisector_rad": 1e-4, "opening_angle_rad": 1e-4, "glare": 1e-3, "blur_growth": 1e-2}
    | dict.fromkeys(WARP_NUMBERS, 0.02)
)
_LEAST = 1e-6  # of a variance: what counts as none
_PAPER = SectorShape(
    axle_row_px=249.1, axle_column_px=319.5, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=46.3,
    outer_radius_px=229.7, bisector_rad=-TURN / 4, opening_angle_rad=TURN * 75 / 360, blur_px=0.7, image_rows=480,
    image_columns=640,
)  # fmt: skip
_PAPER_PIXELS = 33_100.0
_Roi: TypeAlias = tuple[int, int, int, int]


def sector_of(camera: Camera, opening_angle_rad: float) -> SectorShape:
    """The paper's opening, larger or smaller, until it has this camera's number of pixels; blur stays."""
    scale = (camera.opening_pixels / _PAPER_PIXELS) ** 0.5
    grown: dict[str, Any] = {
        name: getattr(_PAPER, name) * scale for name in _OPENING if name.endswith("_px") and name != "blur_px"
    }
    return replace(
        _PAPER, **grown, image_rows=round(_PAPER.image_rows * scale), image_columns=round(_PAPER.image_columns * scale),
        opening_angle_rad=opening_angle_rad,
    )  # fmt: skip


def through(sector: SectorShape, known: LensKnowledge) -> SectorShape:
    """The same behind the lens that is expected, its centre in the middle of the image: of a plan's image the size is unknown."""
    start: dict[str, Any] = known.start | {"lens_row_px": 0.0, "lens_column_px": 0.0}
    return replace(sector, **start, lens_terms=known.terms)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """Rows in the light: image rows (n,), harmonics (n, M + 1) of their light, px^2, and changes (20, n, M + 1).

    Of a high opening not every row is looked at; each then stands for ``weight`` rows.
    """

    row_px: Array
    harmonics: ComplexArray
    changes: ComplexArray
    weight: int


def rows_of(sector: SectorShape, *, n_harmonics: int) -> Rows:
    """Rows with the light of three pixels or more, and how they change with each number of the sector's shape.

    Each pixel keeps its amount of light, which the contrast image shows: only where it lies changes.
    """
    roi = _around(sector)
    light = _pixels(sector, roi)
    summed = np.asarray(ndimage.maximum_filter1d(light > _IN_LIGHT, 2 * round(_BORDER_PX) + 1, axis=1))
    rows = roi[0] + np.flatnonzero(light.sum(axis=1) > _LEAST_LIGHT_PX2)
    weight = max(1, rows.size // _ROWS)
    rows = rows[weight // 2 :: weight]
    here = rows - roi[0]
    angle, smear = blurred_sector.pixel_places(sector, roi=roi)[0][here], _smear(sector, roi, 1)[here]

    def harmonics(shape: SectorShape) -> ComplexArray:
        return sector_rows.harmonics(shape, rows, summed=summed, roi=roi, n_harmonics=n_harmonics)

    at = harmonics(sector)

    def change(name: str) -> ComplexArray:
        moved = replace(sector, **{name: getattr(sector, name) + _STEPS[name]})
        gained = (summed * (_pixels(moved, roi) - light))[here]  # each pixel's light about its own angle
        kept = pixel_waves.by_row(gained, angle, smear=smear, n_harmonics=n_harmonics)
        return np.asarray((harmonics(moved) - at - kept) / _STEPS[name], complex)

    changes = np.array(in_threads.mapped(change, _SHAPE))
    return Rows(row_px=rows.astype(float), harmonics=at, changes=changes, weight=weight)


def _pixels(sector: SectorShape, roi: _Roi) -> Array:
    """Light of each pixel of a region, px^2."""
    points = sector_points.light_points(sector)
    ones = np.ones(points.row_px.size, complex)
    sharp = blurred_sector.image(points, ones, blur=sector.blur, roi=roi)
    return np.asarray(blurred_sector.with_glare(sharp, sector).real, float)


def _smear(sector: SectorShape, roi: _Roi, order: int) -> Array:
    _, radius = blurred_sector.pixel_places(sector, roi=roi)
    return blurred_sector.pixel_smear(radius, blur_px=blurred_sector.blur_across_px(sector, roi=roi), order=order)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingRun:
    """One run: the camera, its rows in the light, the wheel's speed, the number of frames, and the wheel's step between them.

    With ``knows_response`` the camera's integration time or time constant counts as exact.
    """

    camera: Camera
    rows: Rows
    angular_frequency_rad_per_s: float
    n_frames: int
    step_rad: float
    knows_response: bool = False


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ImageErrors:
    """Covariances (20, 20) of the sector's numbers: from the noise of one run, and from gains and lens, which stays."""

    noise: Array
    stays: Array


def one_run(run: RollingRun, *, model: WheelModel, angles: AngleErrors, image: ImageErrors) -> RunInformation:
    """Information of one run on the camera's timing, the sector's numbers, and the errors.

    Parameters
    ----------
    run
        What is sampled, and how.
    model
        Wheel and gates.
    angles
        Sizes of the angle errors.
    image
        How well a run's image shows the sector. Its noise averages over the runs, so the sector's numbers are parameters; what
        gains and lens do to them is an error that stays.
    """
    normal, effect = normal_and_effect(run, model)
    local = _local_names(run)
    normal = (
        Information(source=NOISE, names=local, matrix=normal, gradient=np.zeros(len(local)))
        .without(row_sum.BLADE)
        .matrix
    )
    timing = _timing_design(run)
    n_own, n_shape, n_common = timing.shape[1], len(_SHAPE), len(angles.common)
    first_edge = n_own + n_shape + n_common
    per_rad = 1 / run.angular_frequency_rad_per_s
    design = np.zeros((normal.shape[0], first_edge + 4 + n_shape))
    design[:, :n_own] = timing
    design[:, n_own : n_own + n_shape] = effect
    for k, (_, u) in enumerate(angles.common):
        design[:4, n_own + n_shape + k] = u * per_rad
    design[:4, first_edge : first_edge + 4] = angles.edge_rad * per_rad * np.eye(4)
    design[:, first_edge + 4 :] = effect @ _root(image.stays)
    matrix = design.T @ normal @ design
    shape = slice(n_own, n_own + n_shape)
    matrix[shape, shape] += generalised_inverse(image.noise + _LEAST * np.diag(np.diag(image.noise + image.stays)))
    sources = (*(source for source, _ in angles.common), *[EDGES] * 4, *[IMAGE] * n_shape)
    return run_information((*timing_names(run), *_SHAPE), sources, matrix=matrix)


def timing_names(run: RollingRun) -> tuple[str, ...]:
    """What a run tells of its camera: the trigger delay, what response, memory and readout have."""
    response, memory, _, *readout = _local_names(run)[len(row_sum.EDGE_DELAYS) :]
    return ("trigger_delay", *([] if run.knows_response else [response]), memory, *readout)


def _local_names(run: RollingRun) -> tuple[str, ...]:
    """What the sum over a row has; the plan knows the opening alone, and no blade beside it."""
    return tuple(name for name in row_sum.timing_names(_kind(run.camera)) if name != row_sum.BESIDE)


def _timing_design(run: RollingRun) -> Array:
    """Change of edge delays, response and row delay per unit of each of `timing_names`, shape (k, n)."""
    local, own = _local_names(run), timing_names(run)
    design = np.zeros((len(local), len(own)))
    design[:4, 0] = 1.0
    for column, name in enumerate(own[1:], 1):
        design[local.index(name), column] = 1.0
    if isinstance(run.camera, PhotonCamera) and not run.knows_response:
        design[:4, own.index("integration_time")] = 0.5
    return design


def normal_and_effect(run: RollingRun, model: WheelModel) -> tuple[Array, Array]:
    """Information (k, k) on the numbers of a row sum, per unit squared; their change (k, n_shape) per unit of the sector's."""
    rows, timing = _row_sums(run, model)
    whole, slopes = row_sum.linearised(rows, timing)
    light, n = run.rows.harmonics, len(rows.names)
    moved = run.rows.changes * (whole / np.where(light == 0, 1, light))
    summed = summed_pixels(light)
    per_noise = np.sqrt(run.rows.weight * run.n_frames / 2 / summed) / run.camera.noise_to_contrast
    normal, mixed = np.zeros((n, n)), np.zeros((n, len(_SHAPE)))
    for y, scale in enumerate(per_noise):
        columns = scale * _real(np.concatenate([slopes[:, y], moved[:, y]])).T
        free = without_own(columns, _real(whole[None, y]).T)
        normal += free[:, :n].T @ free[:, :n]
        mixed -= free[:, :n].T @ free[:, n:]
    return normal, np.asarray(np.linalg.solve(normal, mixed), float)


def summed_pixels(light: ComplexArray) -> Array:
    """Pixels that are summed in each row, (n_row,), of light with the harmonics (n_row, M + 1)."""
    return np.asarray(light[:, 0].real + 2 * _BORDER_PX)


def _kind(described: Camera) -> physics_camera.Camera:
    return physics_camera.camera(described.camera_type, described.readout_mode)


def _response_s(described: Camera) -> float:
    return described.time_constant_s if isinstance(described, Microbolometer) else described.integration_time_s


def _row_sums(run: RollingRun, model: WheelModel) -> tuple[RowSum, Timing]:
    """The run's rows, and timing without any delay of the edges: it does not matter here."""
    rows = RowSum(
        camera=_kind(run.camera),
        open_harmonics=wheel_harmonics.open_harmonics(model, run.rows.harmonics.shape[1] - 1),
        row_harmonics=run.rows.harmonics,
        row_px=run.rows.row_px,
        angular_frequency_rad_per_s=run.angular_frequency_rad_per_s,
        step_rad=run.step_rad,
    )
    own = {
        rows.camera.memory.PARAMETER: 0.0,
        row_sum.BLADE: 0.0,
        rows.camera.response.PARAMETER: _response_s(run.camera),
        "row_delay": run.camera.row_delay_s or 0.0,
    }
    return rows, dict.fromkeys(row_sum.EDGE_DELAYS, 0.0) | own


def _real(harmonics: ComplexArray) -> Array:
    """Orders 1 .. M as real numbers whose products are the mean products of the waves, times two; (k, 2 M)."""
    return np.concatenate([harmonics[:, 1:].real, harmonics[:, 1:].imag], axis=1)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SectorImage:
    """Image of the second harmonic about each pixel's own phase, at contrast 1, and its derivatives.

    Shapes: ``light`` (n,), share of each pixel in the light; ``columns`` (35, n), complex: to 13 numbers of the opening, to
    what else is unknown (row delay, phase, contrast, that of the mask plate beside the opening, a slope and a bow of it, the
    blur's own shape), and to the nine of a warp; ``known`` (35,), the information on them without an image.
    """

    sector: SectorShape
    light: Array
    columns: ComplexArray
    known: Array


def sector_image(sector: SectorShape) -> SectorImage:
    """The image of an opening, with the same derivatives whatever the wheel's speed."""
    roi = _around(sector)
    angle, _ = blurred_sector.pixel_places(sector, roi=roi)
    image, phase = _second_harmonic(sector, roi), np.asarray(np.exp(-2j * (angle + sector.bisector_rad)), complex)

    def slope(name: str) -> ComplexArray:
        moved = replace(sector, **{name: getattr(sector, name) + _STEPS[name]})
        return np.asarray((_second_harmonic(moved, roi) - image) / _STEPS[name], complex)

    slopes = in_threads.mapped(slope, _SHAPE)
    down, across = np.linspace(-1, 1, roi[1] - roi[0])[:, None], np.linspace(-1, 1, roi[3] - roi[2])[None, :]
    fields = [down + 0 * across, across + 0 * down, down**2 + 0 * across, across**2 + 0 * down, down * across]
    columns = [*slopes[: len(_OPENING)], down * image * 1j, image * 1j, image, phase - image]
    columns += [field * phase for field in fields]
    columns += [exchanged(image, U_EXCHANGED, axis=axis, away=away) - image for axis, away in EXCHANGES]
    known = np.zeros(len(columns) + len(WARP_NUMBERS))
    known[_OPENING.index("glare")] = U_GLARE**-2
    known[_OPENING.index("blur_growth")] = U_BLUR_GROWTH**-2
    known[len(columns) - len(EXCHANGES) : len(columns)] = 1.0
    columns += slopes[len(_OPENING) :]
    return SectorImage(
        sector=sector,
        light=np.clip(np.abs(image), 0, 1).ravel(),
        columns=(np.array(columns) * phase.conj()).reshape(len(columns), -1),
        known=known,
    )


def lens_information(
    runs: Sequence[RollingRun], image: SectorImage, *, model: WheelModel, known: LensKnowledge
) -> Array:
    """What lens and tilt, as they are known, say of the warp's numbers beside the image, px^-2, shape (9, 9).

    Parameters
    ----------
    runs
        All of one camera: how much their images say together tells which lenses are left.
    image
        Of the opening.
    model
        Wheel and gates.
    known
        Of the lens beforehand.
    """
    normal, _ = _normal_and_noise(image, runs[0].camera, noise=_noise_of(runs, model).pooled)
    n_warp = len(WARP_NUMBERS)
    beside = weighed_lens.with_own_following(normal, n_own=len(normal) - n_warp).beside
    lens = weighed_lens.weighed(np.zeros(n_warp), beside, shape=image.sector, known=known)
    scale = np.sqrt(np.diag(beside))
    values, vectors = np.linalg.eigh((np.linalg.inv(lens.covariance) - beside) / np.outer(scale, scale))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T * np.outer(scale, scale))


def image_errors(
    runs: Sequence[RollingRun], image: SectorImage, *, model: WheelModel, lens: Array
) -> list[ImageErrors]:
    """How well the images of runs tell the sector, from least squares over all pixels of all of them; for each run.

    Along a pixel's phase noise and the scatter of gains count, across it noise alone.

    Parameters
    ----------
    runs
        All of one camera.
    image
        Of the opening.
    model
        Wheel and gates.
    lens
        What is known of the warp's numbers, px^-2, shape (9, 9).
    """
    noise, n_warp = _noise_of(runs, model), len(WARP_NUMBERS)
    normal, of_noise = _normal_and_noise(image, runs[0].camera, noise=noise.pooled)
    prior = np.zeros_like(normal)
    prior[-n_warp:, -n_warp:] = lens
    inverse = generalised_inverse(normal + prior)
    own = np.r_[: len(_OPENING), len(normal) - n_warp : len(normal)]
    by_noise, stays = ((inverse @ part @ inverse)[np.ix_(own, own)] for part in (of_noise, normal - of_noise + prior))
    return [ImageErrors(noise=by_noise * (one / noise.pooled) ** 2, stays=stays) for one in noise.of_runs]


@dataclass(frozen=True, kw_only=True)
class _Noise:
    """Standard deviation of a pixel in the images of runs at contrast 1, and in their best mean."""

    of_runs: list[float]

    @property
    def pooled(self) -> float:
        return float(np.sum(np.power(self.of_runs, -2.0)) ** -0.5)


def _noise_of(runs: Sequence[RollingRun], model: WheelModel) -> _Noise:
    point = wheel_harmonics.open_harmonics(model, 2).sum(axis=0)[2]
    found = []
    for run in runs:
        response = _kind(run.camera).response.transfer(
            run.angular_frequency_rad_per_s, _response_s(run.camera), n_harmonics=2
        )
        found.append(float(run.camera.noise_to_contrast * np.sqrt(2 / run.n_frames) / abs(point * response[2])))
    return _Noise(of_runs=found)


def _normal_and_noise(image: SectorImage, camera: Camera, *, noise: float) -> tuple[Array, Array]:
    """Normal matrix of all numbers of the image, (n, n), and the part of it that the noise has."""
    scatter = np.hypot(camera.gain_scatter * image.light, camera.border_scatter * 4 * image.light * (1 - image.light))
    own = np.arange(len(image.columns))
    if camera.readout_mode == "snapshot":  # without a row delay
        own = np.delete(own, len(_OPENING))
    columns = image.columns[own]
    along = columns.real / np.hypot(noise, scatter)
    share = noise / np.hypot(noise, scatter)
    across = columns.imag @ columns.imag.T / noise**2
    return along @ along.T + across + np.diag(image.known[own]), (along * share) @ (along * share).T + across


def _around(sector: SectorShape) -> _Roi:
    """Region of the image that holds the opening and some of the plate around it."""
    points, edge = sector_points.light_points(sector), 2 * (5 * sector.blur_px + 2)
    rows, columns = points.row_px, points.column_px
    return (
        max(0, int(rows.min() - edge)), int(rows.max() + edge) + 1,
        max(0, int(columns.min() - edge)), int(columns.max() + edge) + 1,
    )  # fmt: skip


def _second_harmonic(sector: SectorShape, roi: _Roi) -> ComplexArray:
    """Image of exp(-2 i phi) over the sector; only its border is worked out point by point."""
    points = sector_points.border_points(sector)
    value = np.exp(-2j * (points.angle_rad + sector.bisector_rad))
    border = blurred_sector.image(points, value, blur=sector.blur, roi=roi)
    angle, _ = blurred_sector.pixel_places(sector, roi=roi)
    even = angle + blurred_sector.even_angle_rad(sector, roi=roi)
    inside = _smear(sector, roi, 2) * np.exp(-2j * (even + sector.bisector_rad))
    sharp = np.where(blurred_sector.well_inside(sector, roi=roi), inside, border)
    return blurred_sector.with_glare(sharp, sector)


def _root(matrix: Array) -> Array:
    """Columns whose products with themselves add up to the matrix, shape (n, n): near ones for a matrix that is near."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)

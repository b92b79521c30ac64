r"""What one run of a camera whose rows are summed can tell (`physics.light.row_sum`; Schatz 2023, eq. 1 to 3).

Samples that stand evenly over the turn see the harmonics of a row apart, so the information on the delays d_i of the four edges,
the response's parameter and t_row is a sum over rows and harmonics; gain and offset of each row are its own. The delays are
d_i = t_delay + (e + e_i) / omega; of a photon camera they are those of the window's middle, half the window later.

The place and shape of the opening come from the image of the second harmonic, where each pixel's phase is twice its polar angle:
noise and the pixels' gains set how well. Its errors are common to all runs of a set, and move those numbers by one linear step.
"""

from dataclasses import dataclass, replace
from typing import TypeAlias, final

import numpy as np

from irtiming.inference.information import NOISE, Information, without_own
from irtiming.physics import blurred_sector, wheel_harmonics
from irtiming.physics import camera as physics_camera
from irtiming.physics.light import row_sum
from irtiming.physics.light.row_sum import RowSum, Timing
from irtiming.physics.wheel import TURN
from irtiming.plan.information import EDGES, RunInformation, run_information
from irtiming.records.arrays import Array, ComplexArray, Ticks
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.records.prediction import AngleErrors
from irtiming.records.row_timing import SectorShape
from irtiming.records.wheel_geometry import WheelModel

IMAGE = "axle, mask and blur in the image"

_HARMONICS = 64
_LEAST_LIGHT_PX2 = 3.0
_ROWS = 50  # at least, that are looked at
_BORDER_PX = 5.0  # that the reduction adds to both ends of a row, roughly
_SHAPE = (
    "axle_row_px", "axle_column_px", "offset_row_px", "offset_column_px", "inner_radius_px", "outer_radius_px",
    "bisector_rad", "opening_angle_rad", "blur_px",
)  # fmt: skip
_ANGLES = ("bisector_rad", "opening_angle_rad")
_STEP_RAD, _STEP_PX = 1e-4, 3e-3
_PAPER = SectorShape(
    axle_row_px=249.1, axle_column_px=319.5, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=46.3,
    outer_radius_px=229.7, bisector_rad=-TURN / 4, opening_angle_rad=TURN * 75 / 360, blur_px=0.7,
)  # fmt: skip
_PAPER_PIXELS = 33_100.0
_Roi: TypeAlias = tuple[int, int, int, int]


def sector_of(camera: Camera, opening_angle_rad: float) -> SectorShape:
    """The paper's opening, larger or smaller, until it has this camera's number of pixels; blur stays."""
    scale = (camera.opening_pixels / _PAPER_PIXELS) ** 0.5
    grown = {name: getattr(_PAPER, name) * scale for name in _SHAPE if name.endswith("_px") and name != "blur_px"}
    return replace(_PAPER, **grown, opening_angle_rad=opening_angle_rad)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """Rows in the light: image rows (n,), harmonics (n, M + 1) of their light, px^2, and changes (9, n, M + 1).

    Of a high opening not every row is looked at; each then stands for ``weight`` rows.
    """

    row_px: Array
    harmonics: ComplexArray
    changes: ComplexArray
    weight: int


def rows_of(sector: SectorShape, *, n_harmonics: int = _HARMONICS) -> Rows:
    """Rows with the light of three pixels or more, and how they change with each number of the sector's shape.

    Each pixel keeps its amount of light, which the contrast image shows: only where it lies changes.
    """
    reach = sector.outer_radius_px + abs(sector.offset_row_px) + 5 * sector.blur_px
    first = max(0, int(sector.axle_row_px - reach))
    rows = np.arange(first, int(sector.axle_row_px + reach) + 1)
    rows = rows[_light(sector, rows, n_harmonics=0)[:, 0].real > _LEAST_LIGHT_PX2]
    weight = max(1, rows.size // _ROWS)
    rows = rows[weight // 2 :: weight]
    roi = _around(sector)
    rows = rows[(rows >= roi[0]) & (rows < roi[1])]
    changes = []
    for name in _SHAPE:
        step = _STEP_RAD if name in _ANGLES else _STEP_PX
        ahead, behind = (replace(sector, **{name: getattr(sector, name) + sign * step}) for sign in (1, -1))
        gained = (_pixels(ahead, roi) - _pixels(behind, roi))[rows - roi[0]]
        moved = _light(ahead, rows, n_harmonics=n_harmonics) - _light(behind, rows, n_harmonics=n_harmonics)
        change = moved - _of_pixels(sector, gained, rows=rows, roi=roi, n_harmonics=n_harmonics)
        changes.append(change / (2 * step))
    light = _light(sector, rows, n_harmonics=n_harmonics)
    return Rows(row_px=rows.astype(float), harmonics=light, changes=np.array(changes), weight=weight)


def _pixels(sector: SectorShape, roi: _Roi) -> Array:
    """Light of each pixel of a region, px^2."""
    points = blurred_sector.light_points(sector)
    ones = np.ones(points.row_px.size, complex)
    return np.asarray(blurred_sector.image(points, ones, blur_px=sector.blur_px, roi=roi).real, float)


def _of_pixels(sector: SectorShape, light: Array, *, rows: Ticks, roi: _Roi, n_harmonics: int) -> ComplexArray:
    """Harmonics of rows whose pixels have so much light, (n_row, columns of the region), each about its own angle."""
    angle, radius = (place[rows - roi[0]] for place in blurred_sector.pixel_places(sector, roi=roi))
    return np.stack(
        [np.sum(light * np.exp(-1j * m * angle) * _smear(radius, sector, m), axis=1) for m in range(n_harmonics + 1)],
        axis=1,
    )


def _smear(radius_px: Array, sector: SectorShape, order: int) -> Array:
    return blurred_sector.pixel_smear(radius_px, blur_px=sector.blur_px, order=order)


def _light(sector: SectorShape, rows: Ticks, *, n_harmonics: int) -> ComplexArray:
    points = blurred_sector.light_points(sector, n_harmonics=n_harmonics)
    return blurred_sector.row_harmonics(points, rows, blur_px=sector.blur_px, n_harmonics=n_harmonics)


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
    """Covariances (9, 9) of the sector's numbers: what the noise of one run and what the pixels' gains make of them."""

    noise: Array
    gains: Array


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
        the pixels' gains do to them is an error that stays.
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
    design[:, first_edge + 4 :] = effect @ _root(image.gains)
    matrix = design.T @ normal @ design
    shape = slice(n_own, n_own + n_shape)
    matrix[shape, shape] += np.linalg.pinv(image.noise, rcond=1e-13, hermitian=True)
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
    """Information (k, k) on the numbers of a row sum, s^-2, and their change (k, 9) per unit of the sector's numbers."""
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

    Shapes: ``light`` (n,), share of each pixel in the light; ``columns`` (18, n), complex: to the sector's nine numbers and to
    what else is unknown: row delay, phase, contrast, that of the mask plate beside the opening, a slope and a bow of it.
    """

    light: Array
    columns: ComplexArray


def sector_image(sector: SectorShape) -> SectorImage:
    """The image of an opening, with the same derivatives whatever the wheel's speed."""
    roi = _around(sector)
    columns: list[ComplexArray] = []
    for name in _SHAPE:
        step = _STEP_RAD if name in _ANGLES else _STEP_PX
        ahead, behind = (replace(sector, **{name: getattr(sector, name) + sign * step}) for sign in (1, -1))
        columns.append((_second_harmonic(ahead, roi) - _second_harmonic(behind, roi)) / (2 * step))
    angle, _ = blurred_sector.pixel_places(sector, roi=roi)
    wave, phase = _second_harmonic(sector, roi), np.asarray(np.exp(-2j * (angle + sector.bisector_rad)), complex)
    down, across = np.linspace(-1, 1, roi[1] - roi[0])[:, None], np.linspace(-1, 1, roi[3] - roi[2])[None, :]
    fields = [down + 0 * across, across + 0 * down, down**2 + 0 * across, across**2 + 0 * down, down * across]
    columns += [down * wave * 1j, wave * 1j, wave, phase - wave, *(field * phase for field in fields)]
    return SectorImage(
        light=np.clip(np.abs(wave), 0, 1).ravel(), columns=(np.array(columns) * phase.conj()).reshape(18, -1)
    )


def image_errors(run: RollingRun, image: SectorImage, *, model: WheelModel) -> ImageErrors:
    """How well the image tells the sector, from least squares over all pixels.

    Along a pixel's phase noise and the scatter of gains count, across it noise alone.
    """
    point = wheel_harmonics.open_harmonics(model, 2).sum(axis=0)[2]
    response = _kind(run.camera).response
    point *= response.transfer(run.angular_frequency_rad_per_s, _response_s(run.camera), n_harmonics=2)[2]
    noise = run.camera.noise_to_contrast * np.sqrt(2 / run.n_frames) / abs(point)
    scatter = run.camera.gain_scatter * np.hypot(image.light, 4 * image.light * (1 - image.light))
    columns = image.columns if run.camera.readout_mode == "rolling" else np.delete(image.columns, len(_SHAPE), axis=0)
    scale = np.linalg.norm(columns, axis=1)
    even = columns / scale[:, None]
    weighted = even.real / (noise**2 + scatter**2)
    inverse = np.linalg.pinv(weighted @ even.real.T + even.imag @ even.imag.T / noise**2, hermitian=True)
    per_gain = inverse @ weighted * scatter
    by_gain, outer, n = per_gain @ per_gain.T, np.outer(scale, scale), len(_SHAPE)
    return ImageErrors(noise=((inverse - by_gain) / outer)[:n, :n], gains=(by_gain / outer)[:n, :n])


def _around(sector: SectorShape) -> _Roi:
    """Region of the image that holds the opening and some of the plate around it."""
    reach = sector.outer_radius_px + 5 * sector.blur_px + 2
    polar = sector.bisector_rad + np.linspace(-0.5, 0.5, 181) * sector.opening_angle_rad
    rows = sector.axle_row_px + np.outer([sector.inner_radius_px, reach], np.sin(polar))
    sense = -1.0 if sector.mirrored else 1.0
    columns = sector.axle_column_px + sense * np.outer([sector.inner_radius_px, reach], np.cos(polar))
    edge = 5 * sector.blur_px + 2
    return (
        max(0, int(rows.min() - edge)), int(rows.max() + edge) + 1,
        max(0, int(columns.min() - edge)), int(columns.max() + edge) + 1,
    )  # fmt: skip


def _second_harmonic(sector: SectorShape, roi: _Roi) -> ComplexArray:
    """Image of exp(-2 i phi) over the sector; only its border is worked out point by point."""
    points = blurred_sector.border_points(sector)
    value = np.exp(-2j * (points.angle_rad + sector.bisector_rad))
    border = blurred_sector.image(points, value, blur_px=sector.blur_px, roi=roi)
    angle, radius = blurred_sector.pixel_places(sector, roi=roi)
    smear = _smear(radius, sector, 2)
    inside = smear * np.exp(-2j * (angle + sector.bisector_rad))
    return np.where(blurred_sector.well_inside(sector, roi=roi), inside, border)


def _root(matrix: Array) -> Array:
    """Columns whose products with themselves add up to the matrix, shape (n, n)."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))

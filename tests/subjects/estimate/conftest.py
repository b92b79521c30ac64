"""A lagging camera before a wheel, summed point by point in the time domain: no harmonic, no convolution."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial.transform import Rotation
from scipy.special import ndtr

from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.physics import blurred_sector
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.reduced import ContrastImage, Opening, ReducedRecording, RowSums
from irtiming.records.rig import CameraOptics, LightGates, MaskOpening, Measured, Rig, Wheel
from irtiming.records.row_timing import SectorFit, SectorShape
from irtiming.records.wheel_geometry import WheelModel

TURN = 2 * np.pi
CLOCK_HZ, START = 49_152_000, 7_000_000
EDGES = (0.0, 1.5718, 3.1421, 4.7125)


@dataclass(frozen=True, kw_only=True)
class BruteBolometer:
    """Sector of light and timing of a rolling camera; columns are counted as the camera sees them, clockwise wheel."""

    rows: int = 36
    columns: int = 64
    axle: tuple[float, float] = (35.2, 31.3)
    offset: tuple[float, float] = (0.0, 0.0)
    radii: tuple[float, float] = (8.3, 29.6)
    bisector_rad: float = float(np.radians(-91.2))
    opening_rad: float = float(np.radians(75))
    blur_px: float = 0.8
    blur_ellipticity: float = 0.0
    blur_correlation: float = 0.0
    blur_growth: float = 0.0
    edges: tuple[float, float, float, float] = EDGES
    gate_rad: float = float(np.pi / 2 + 0.2682)
    centre_rad: float = float(np.radians(-90))
    rate_hz: float = 3.0
    edge_delay_s: tuple[float, float, float, float] = (2.3e-3,) * 4
    time_constant_s: float = 6e-3
    row_delay_s: float = 60e-6
    sub: int = 10
    distortion: float = 0.0
    tilt_rad: tuple[float, float] = (0.0, 0.0)
    focal_px: float = 300.0
    lens_px: tuple[float, float] = (0.0, 0.0)
    camera_type: str = "microbolometer"
    readout_mode: str = "rolling"
    integration_time_s: float = 0.0

    @property
    def omega(self) -> float:
        """Angular frequency of the wheel."""
        return TURN * self.rate_hz

    @property
    def timing(self) -> dict[str, float]:
        """Delays of the edges, time constant and row delay, by name."""
        delays = {f"edge_delay_{k}": delay for k, delay in enumerate(self.edge_delay_s)}
        return delays | {"time_constant": self.time_constant_s, "row_delay": self.row_delay_s}

    @property
    def model(self) -> WheelModel:
        """Wheel as the package describes it."""
        return wheel_model(
            self.edges, self.gate_rad - np.pi / 2, opening_angle_rad=self.opening_rad, centre_angle_rad=self.centre_rad
        )

    @property
    def tilt(self) -> float:
        """Of the camera, rad; ``tilt_rad`` is about an axis along the rows' order and one along the columns'."""
        return math.hypot(*self.tilt_rad)

    @property
    def shape(self) -> SectorShape:
        """Sector as the package describes it."""
        unit = math.hypot(self.rows, self.columns) / 2
        return SectorShape(
            axle_row_px=self.axle[0],
            axle_column_px=self.axle[1],
            offset_row_px=self.offset[0],
            offset_column_px=self.offset[1],
            inner_radius_px=self.radii[0],
            outer_radius_px=self.radii[1],
            bisector_rad=self.bisector_rad,
            opening_angle_rad=self.opening_rad,
            blur_px=self.blur_px,
            blur_ellipticity=self.blur_ellipticity,
            blur_correlation=self.blur_correlation,
            blur_growth=self.blur_growth,
            distortion=self.distortion,
            keystone_row=-math.sin(self.tilt) * self.tilt_rad[1] / max(self.tilt, 1e-9) * unit / self.focal_px,
            keystone_column=math.sin(self.tilt) * self.tilt_rad[0] / max(self.tilt, 1e-9) * unit / self.focal_px,
            log_focal_length=math.log(self.focal_px / unit),
            lens_row_px=self.lens_px[0],
            lens_column_px=self.lens_px[1],
            image_rows=self.rows,
            image_columns=self.columns,
        )

    @cached_property
    def points(self):
        """Row, column, polar angle from the bisector and area of points all over the opening, a tenth of a pixel apart."""
        n_radius, n_angle = (round(self.sub * size) for size in (np.ptp(self.radii), self.opening_rad * self.radii[1]))
        radius = self.radii[0] + np.ptp(self.radii) * (np.arange(n_radius) + 0.5) / n_radius
        own = self.bisector_rad + self.opening_rad * ((np.arange(n_angle) + 0.5) / n_angle - 0.5)
        down = self.offset[0] + np.outer(radius, np.sin(own)).ravel()
        across = self.offset[1] + np.outer(radius, np.cos(own)).ravel()
        polar = np.angle(np.exp(1j * (np.arctan2(down, across) - self.bisector_rad)))
        area = np.repeat(radius, n_angle) * np.ptp(self.radii) / n_radius * self.opening_rad / n_angle
        row, column, larger = self.through_lens(down, across)
        return row, column, polar, area * larger

    def through_lens(self, down, across):
        """Where points beside the axle appear, and how much larger (differences): a turned plane before a pinhole, then the lens.

        The axle lies where its undistorted image is, found by fixed-point iteration; a px of the plane is as large as there.
        """
        unit = np.hypot(self.rows, self.columns) / 2
        middle = np.array([(self.rows - 1) / 2 + self.lens_px[0], (self.columns - 1) / 2 + self.lens_px[1]])
        seen = (np.array(self.axle) - middle) / unit
        flat = seen
        for _ in range(100):
            flat = seen / (1 + self.distortion * (flat @ flat))
        turned = Rotation.from_rotvec([*self.tilt_rad, 0.0]).as_matrix()  # rows, columns, along the camera's axis

        def image(down, across):
            place = turned[:, :2] @ np.array([down, across])
            place = place + np.array([*(unit * flat), self.focal_px])[:, None]
            y, x = self.focal_px * place[:2] / place[2] / unit
            bent = 1 + self.distortion * (x * x + y * y)
            return np.array([middle[0] + unit * y * bent, middle[1] + unit * x * bent])

        step = 1e-3
        by_down = (image(down + step, across) - image(down - step, across)) / (2 * step)
        by_across = (image(down, across + step) - image(down, across - step)) / (2 * step)
        row, column = image(down, across)
        return row, column, by_down[0] * by_across[1] - by_down[1] * by_across[0]

    @cached_property
    def light(self):
        """Angles (b,) and how much light from there falls into each pixel after the blur, shape (b, row, column), px^2."""
        row, column, angle, area = self._smeared
        pitch = np.radians(0.1)
        first = np.floor(angle.min() / pitch)
        place = angle / pitch - first
        below, part = place.astype(int), place % 1
        n_bin = below.max() + 2
        middle = (self.rows - 1) / 2, (self.columns - 1) / 2
        away = np.hypot(row - middle[0], column - middle[1]) / (np.hypot(self.rows, self.columns) / 2)
        wider = np.sqrt(1 + self.blur_growth * away**2)
        rows_px, columns_px = (wider * one for one in np.sqrt(np.square(self.blurs_px) - self._along_diagonal_px2))
        out = np.zeros((n_bin, self.rows, self.columns))
        for k, of_bin in enumerate(np.split(np.argsort(below), np.cumsum(np.bincount(below))[:-1])):
            by_row, by_column = (
                np.diff(ndtr((np.arange(n + 1) - 0.5 - x[of_bin, None]) / blur[of_bin, None]))
                for n, x, blur in ((self.rows, row, rows_px), (self.columns, column, columns_px))
            )
            for which, weight in ((k, 1 - part[of_bin]), (k + 1, part[of_bin])):
                out[which] += (by_row * (weight * area[of_bin])[:, None]).T @ by_column
        return (first + np.arange(n_bin)) * pitch, out

    @property
    def blurs_px(self):
        """Standard deviations over rows and over columns in the middle of the image."""
        return self.blur_px * (1 - self.blur_ellipticity), self.blur_px * (1 + self.blur_ellipticity)

    @property
    def _along_diagonal_px2(self):
        """Of the variances over rows and columns, what both share in moves along a diagonal."""
        return abs(self.blur_correlation) * math.prod(self.blurs_px)

    @property
    def _smeared(self):
        """The points; where the blur is correlated, moved along a diagonal to the nodes of a Gaussian."""
        if self.blur_correlation == 0:
            return self.points
        node, weight = np.polynomial.hermite_e.hermegauss(7)
        move = np.sqrt(self._along_diagonal_px2) * node[:, None]
        row, column, angle, area = self.points
        at_row, at_column = row + move, column + math.copysign(1, self.blur_correlation) * move
        many = np.ones((node.size, 1))
        return at_row.ravel(), at_column.ravel(), (many * angle).ravel(), np.outer(weight / weight.sum(), area).ravel()

    def seen(self, coordinate_rad):
        """Openness of a point at a wheel coordinate as the camera shows it, in closed form between the edges; any shape."""
        return (
            self._lagged(coordinate_rad) if self.camera_type == "microbolometer" else self._integrated(coordinate_rad)
        )

    def _integrated(self, coordinate_rad):
        """Share of the window, about its middle, in which the point is open."""
        edges = np.array(self.edges) - self.omega * np.array(self.edge_delay_s)
        corners = np.append(edges, edges[0] + TURN)
        open_before = np.cumsum([0.0, 0.0, edges[2] - edges[1], 0.0, corners[4] - corners[3]])

        def until(x):
            turns, angle = np.divmod(x - edges[0], TURN)
            return turns * open_before[-1] + np.interp(angle, corners - edges[0], open_before)

        half = self.omega * self.integration_time_s / 2
        return (until(coordinate_rad + half) - until(coordinate_rad - half)) / (2 * half)

    def _lagged(self, coordinate_rad):
        """Relaxing towards what the point shows."""
        edges = np.array(self.edges) - self.omega * np.array(self.edge_delay_s)
        since = np.mod(coordinate_rad - edges[0], TURN)
        arc = np.searchsorted(edges - edges[0], since, side="right") - 1
        late = (since - (edges - edges[0])[arc]) / (self.omega * self.time_constant_s)
        target = np.array([0.0, 1.0, 0.0, 1.0])
        return target[arc] + (self._levels - target)[arc] * np.exp(-late)

    @cached_property
    def _levels(self):
        """What it shows at each edge, after many turns."""
        edges = np.array(self.edges) - self.omega * np.array(self.edge_delay_s)
        arcs = np.diff(np.append(edges, edges[0] + TURN)) / (self.omega * self.time_constant_s)
        target, level = np.array([0.0, 1.0, 0.0, 1.0]), np.zeros(4)
        for _ in range(200):
            for k in range(4):
                level[(k + 1) % 4] = target[k] + (level[k] - target[k]) * np.exp(-arcs[k])
        return level

    def frames(self, theta):
        """Openness of each pixel at these wheel angles at the trigger, shape (n, row, column)."""
        angle, light = self.light
        out = np.zeros((theta.size, self.rows, self.columns))
        for row in np.flatnonzero(light.any(axis=(0, 2))):
            at = theta + self.gate_rad - self.centre_rad + self.omega * row * self.row_delay_s
            out[:, row] = self.seen(at[:, None] - angle) @ light[:, row]
        return out


@pytest.fixture(scope="session")
def brute_bolometer() -> type[BruteBolometer]:
    """Camera that counts."""
    return BruteBolometer


@pytest.fixture(scope="session")
def rig_with() -> Callable[..., Rig]:
    """The paper's rig with another lens, or with a counterclockwise wheel."""

    def make(*, distortion=None, mirrored=False):
        optics = CameraOptics() if distortion is None else CameraOptics(distortion=distortion)
        return Rig(
            wheel=Wheel(rotation="counterclockwise" if mirrored else "clockwise"),
            light_gates=LightGates(
                half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9
            ),
            mask_opening=MaskOpening(
                opening_angle_rad=Measured(float(np.radians(75))), centre_angle_rad=Measured(-TURN / 4)
            ),
            camera=optics,
        )

    return make


@pytest.fixture(scope="session")
def brute_frames() -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """Trigger ticks and openness of each pixel in the frames of a camera: ``brute_frames(camera, n=...)``; kept for reuse."""
    known = {}

    def frames(camera, *, n=400):
        if (camera, n) not in known:
            ticks = START + 40_000_000 + 1_622_016 * np.arange(n, dtype=np.int64)
            theta = camera.omega * (ticks - START) / CLOCK_HZ + 0.4
            known[camera, n] = ticks, camera.frames(theta)
        return known[camera, n]

    return frames


@pytest.fixture(scope="session")
def brute_rows(brute_frames, track_of) -> Callable[..., ReducedRecording]:
    """Reduced rows of a camera's frames, as the reduction hands them over.

    ``set_s`` is a set delay: the wheel angles that the analysis takes are that much later, the frames stay. ``keep`` picks
    frames; ``segment`` (n,) numbers them, ``offset_dn`` (n_segment,) is added to all pixels of each; ``gain`` multiplies
    pixels; ``mirror`` turns the image left to right; ``stated_s`` is the integration time that the recording tells; ``curve``
    is what a pixel shows of the contrast for what it would show were its response a straight line.
    """

    def make(camera, *, n=400, contrast_dn=-600.0, noise_dn=0.0, seed=0, set_s=0.0, keep=None, segment=None, **more):
        options = {
            "offset_dn": (0.0, 0.0), "gain": 1.0, "mirror": False, "name": "counted", "stated_s": None,
            "curve": lambda seen: seen,
        } | more  # fmt: skip
        ticks, openness = brute_frames(camera, n=n)
        keep = np.arange(n) if keep is None else keep
        ticks = ticks[keep] - round(set_s * CLOCK_HZ)
        segment = np.zeros(n, np.int64) if segment is None else segment
        segment = segment[keep]
        values = (
            5000
            + contrast_dn * options["curve"](openness[keep]) * options["gain"]
            + np.array(options["offset_dn"])[segment, None, None]
        )
        values = values + np.random.default_rng(seed).normal(0, noise_dn, values.shape) if noise_dn else values
        light = camera.light[1].sum(axis=0)
        if options["mirror"]:
            values, light = values[:, :, ::-1], light[:, ::-1]
        track = track_of(rate_hz=camera.rate_hz, start=START, duration_s=n * 0.033 + 2.5)
        theta = wheel_angle_rad(set_s, track, at_ticks=ticks)
        weight = 2 / theta.size * np.exp(-2j * theta)
        for number in np.unique(segment):
            weight[segment == number] -= weight[segment == number].mean()
        summed = ndimage.binary_dilation(light > 1e-3)
        row_px = np.flatnonzero(summed.any(axis=1))
        roi = (0, camera.rows, 0, camera.columns)
        return ReducedRecording(
            name=options["name"],
            source="",
            sha256="",
            camera_type=camera.camera_type,
            readout_mode=camera.readout_mode,
            integration_time_s=options["stated_s"],
            n_frames=n,
            trigger_ticks=ticks,
            frame_index=keep,
            segment=segment,
            rows=RowSums(
                row_px=row_px,
                row_sum_dn=(values * summed).sum(axis=2)[:, row_px],
                mask_row_sum_dn=(values * (light > 0.5)).sum(axis=2)[:, row_px],
                drift_dn=np.zeros(keep.size),
                edge_frame_dn=values[0].astype(np.uint16),
                edge_frame=0,
            ),
            samples_per_turn=1000,
            track=track,
            equal_track=track,
            opening=Opening(
                roi=roi,
                open_frame_dn=values[0],
                covered_frame_dn=values[0],
                mask=light > 0.5,
                summed=summed,
                weight=summed.astype(float),
                border_px=2,
                bad=np.zeros(summed.shape, bool),
                blackbody_is_colder=contrast_dn < 0,
            ),
            contrast=ContrastImage(
                projection_dn=np.einsum("n,nij->ij", weight, values),
                frame_weight=weight,
                u_dn=max(noise_dn, 0.05) * float(np.sqrt(2 / keep.size)),
                good=np.ones(summed.shape, bool),
                roi=roi,
            ),
            pixel_maps={"mean_dn": values[:, roi[0] : roi[1], roi[2] : roi[3]].mean(axis=0)},
            shutter_events=(),
            trigger_delay_time_set_s=set_s,
            rotation_speed_hz=camera.rate_hz,
        )

    return make


@pytest.fixture(scope="session")
def sector_of() -> Callable[..., SectorFit]:
    """The fit that a perfect image of the camera's sector would give; the whole image by default, any field by keyword."""

    def make(camera, *, roi=None, mirrored=False, **fields):
        roi = roi or (0, camera.rows, 0, camera.columns)
        nothing = np.zeros((roi[1] - roi[0], roi[3] - roi[2]))
        maps = (
            "contrast",
            "model_contrast",
            "ring",
            "excess",
            "ring_angle_rad",
            "borrowed",
            "borrowed_angle_rad",
            "excess_angle_rad",
        )
        values = dict.fromkeys(maps, nothing) | {
            "shape": camera.shape,
            "names": SHAPE_NUMBERS,
            "covariance": np.diag(
                np.array([1e-3] * 6 + [1e-5] * 2 + [1e-3, 1e-4] + [1e-5] * 5 + [1e-6] * 5 + [1e-3] * 9) ** 2
            ),
            "plate": 0.0,
            "swept": nothing + 1.0,
            "ring_angle_rad": blurred_sector.pixel_places(camera.shape, roi=roi)[0],
            "unevenness": 0.0,
            "field_height": 0.1,
            "gain_scatter": 0.0,
            "border_scatter": 0.0,
            "odd": nothing > 0,
            "summed": nothing == 0,
            "turn_rad": 0.0,
            "plate_reflection": 0.0,
            "ring_radii_px": (camera.radii[0] - 2, camera.radii[1] + 2),
            "row_delay_s": camera.row_delay_s,
            "u_row_delay_s": 1e-7,
            "reduced_chi_square": 1.0,
            "roi": roi,
            "n_rounds": 1,
            "gained": 0.0,
        }
        return SectorFit(**(values | fields))

    return make

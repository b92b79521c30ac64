"""A wheel on paper, and cameras that see it: recordings made by brute force, sharing nothing with the package's formulas."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import pytest

from irtiming.records.recording import NonuniformityReference, Recording
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel
from irtiming.reduce.wheel.edge_train import EdgeTrain, number_edges
from irtiming.twin.clockwork import spin
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import Ripple, Scene, SpeedWander, paper_scene, with_wheel_speed

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000


@dataclass(frozen=True, kw_only=True)
class PaperWheel:
    """theta(t) = theta_0 + omega t + sum of a sin(2 pi t / period + phase); every edge time is found by iteration."""

    rate_hz: float = 3.0
    theta_0: float = 1.0
    wander: tuple[tuple[float, float, float], ...] = ()
    slots: np.ndarray = field(default_factory=lambda: TURN * np.arange(100) / 100)
    gate_separation: float = 0.5697
    edges: tuple[float, ...] = (0.0, 1.5718, 3.1421, 4.7125)
    start: int = 7_000_000
    duration_s: float = 34.0
    jitter_s: float = 0.0

    def theta(self, t):
        return self.theta_0 + TURN * self.rate_hz * t + self._wander(t)

    def _wander(self, t):
        return sum((a * np.sin(TURN * t / period + phase) for a, period, phase in self.wander), 0.0 * t)

    def _when(self, angles):
        """Times at which the wheel is at the given angles, each repeated every turn, sorted, s."""
        n_turns = int(self.duration_s * self.rate_hz) + 2
        targets = (np.asarray(angles) + TURN * np.arange(-1, n_turns + 2)[:, None]).ravel()
        t = (targets - self.theta_0) / (TURN * self.rate_hz)
        for _ in range(60):
            t = (targets - self.theta_0 - self._wander(t)) / (TURN * self.rate_hz)
        return np.sort(t[(t >= 0) & (t <= self.duration_s)])

    def ticks(self, t):
        return self.start + np.ceil(np.asarray(t) * CLOCK_HZ).astype(np.int64)

    def _jittered(self, t, seed):
        return self.ticks(t + np.random.default_rng(seed).normal(0, self.jitter_s, t.size))

    def control_slot_ticks(self):
        return self._jittered(self._when(self.slots - self.gate_separation), 1)

    def application_slot_ticks(self):
        return self._jittered(self._when([self.edges[0], self.edges[2]]), 2)

    def application_edge_ticks(self):
        return self._jittered(self._when(list(self.edges)), 3)


class FramesInMemory:
    """A stack of frames that hands out blocks of 97, so that the last one is shorter."""

    def __init__(self, frames):
        self._frames = np.asarray(frames, np.uint16)

    @property
    def shape(self):
        return self._frames.shape

    def blocks(self):
        for first in range(0, len(self._frames), 97):
            yield first, self._frames[first : first + 97]

    def pick(self, indices):
        return self._frames[indices]


@pytest.fixture(scope="session")
def paper_wheel() -> type[PaperWheel]:
    """Wheel with known angle at any time."""
    return PaperWheel


@pytest.fixture(scope="session")
def frames_in_memory() -> type[FramesInMemory]:
    """Frame stack over an array."""
    return FramesInMemory


@dataclass(frozen=True, kw_only=True)
class SpunWheel:
    """What the twin's wheel did: numbered control edges, slot of the first one, true slots (mean zero), and the recording."""

    train: EdgeTrain
    first_slot: int
    slots: np.ndarray
    recording: Recording
    rig: Rig
    scene: Scene


@pytest.fixture(scope="session")
def spun() -> Callable[..., SpunWheel]:
    """Wheel of the twin: ``spun(seed, turns=40, hz=3.0, relative=1e-4, ripple=0.0)``.

    ``ripple`` is the relative speed ripple of order 1 at 3 Hz; it falls with the square of the speed, and order 2 has 0.6 of it.
    The wheel is that of ``rig_seed``.
    """

    def spin_it(
        seed, *, turns=40, hz=3.0, relative=1e-4, correlation_time_s=0.5, ripple=0.0, jitter_s=0.5e-6, rig_seed=1
    ):
        scene = with_wheel_speed(paper_scene(64, 64), hz)
        fallen = ripple * (3 / hz) ** 2
        ripples = (
            Ripple(order=1, relative=fallen),
            Ripple(order=2, relative=0.6 * fallen, phase_rad=1.0),
        )
        per_frame = scene.trigger.camera_period_ticks / scene.trigger.turn_period_ticks
        scene = replace(
            scene,
            wander=SpeedWander(relative=relative, correlation_time_s=correlation_time_s, ripples=ripples),
            beams=replace(scene.beams, jitter_s=jitter_s),
            trigger=replace(scene.trigger, n_triggers=int(turns / per_frame), start_angle_rad=1.234 * seed),
        )
        drawn = draw(scene, seed=rig_seed)
        wheel = drawn.scene.wheel
        uneven = (
            *wheel.ring_edges_rad[:2],
            np.pi + 4e-3,
            wheel.ring_edges_rad[3],
        )  # the reference edge is told in any wander
        scene = replace(drawn.scene, wheel=replace(wheel, ring_edges_rad=uneven))
        motion = spin(scene, seed=seed)
        recording = replace(simulate(scene, seed=seed, name=f"{hz:g} Hz, seed {seed}"), sha256=f"{seed}-{hz}")
        ticks = recording.control_slot_ticks
        since = (ticks[:1] - recording.camera_trigger_ticks[0]) / recording.clock_frequency_hz
        between = scene.beams.beta_1_rad + scene.beams.beta_2_rad
        first = round(float(motion.angle_at(since)[0] + between) / (TURN / 100)) % 100
        slots = np.array(scene.wheel.control_slot_errors_rad)
        return SpunWheel(
            train=number_edges(ticks, period_ticks=scene.trigger.turn_period_ticks / 100, name="control_slot"),
            first_slot=first,
            slots=slots - slots.mean(),
            recording=recording,
            rig=drawn.measured,
            scene=scene,
        )

    return spin_it


@pytest.fixture(scope="session")
def rig() -> Rig:
    """Return the rig of the paper: 75 deg mask at the top, nine slots between the gates."""
    return Rig(
        wheel=Wheel(),
        light_gates=LightGates(
            half_separation_m=Measured(13e-3, 5e-5),
            height_difference_m=Measured(5.5e-3, 5e-5),
            whole_slots_between=9,
        ),
        mask_opening=MaskOpening(
            opening_angle_rad=Measured(float(np.radians(75))), centre_angle_rad=Measured(float(np.radians(-90)), 5e-4)
        ),
    )


@pytest.fixture(scope="session")
def recorded() -> Callable[..., Recording]:
    """Recording of a wheel; ``recorded(wheel, frames=..., n_triggers=...)`` with any field replaced by keyword."""

    def record(wheel, *, frames=None, n_triggers=1000, first_s=0.35, **fields):
        triggers = wheel.ticks(first_s) + 1_622_016 * np.arange(n_triggers, dtype=np.int64)
        stack = FramesInMemory(np.zeros((n_triggers, 1, 1)) if frames is None else frames)
        values = {
            "name": "on paper",
            "camera_type": "photon",
            "readout_mode": "snapshot",
            "frames": stack,
            "frame_number": np.arange(stack.shape[0]),
            "clock_frequency_hz": float(CLOCK_HZ),
            "camera_trigger_ticks": triggers,
            "control_slot_ticks": wheel.control_slot_ticks(),
            "application_slot_ticks": wheel.application_slot_ticks(),
            "rotation_speed_hz": wheel.rate_hz,
            "integration_time_s": 250e-6,
            "bit_depth": 14,
        }
        return Recording(**(values | fields))

    return record


@dataclass(frozen=True, kw_only=True)
class PaperCamera:
    """Mask and wheel as an image: the opening is rendered once with sub x sub points a pixel, frames by the angle of each."""

    rows: int = 60
    columns: int = 80
    axle: tuple[float, float] = (48.0, 40.3)
    mask_centre: tuple[float, float] = (0.0, 0.0)
    radii: tuple[float, float] = (16.0, 36.0)
    opening_rad: float = float(np.radians(75))
    bisector_rad: float = float(np.radians(-90))
    blur_px: float = 0.7
    gate_rad: float = float(np.pi / 2) + 0.2682
    edges: tuple[float, ...] = (0.0, 1.5718, 3.1421, 4.7125)
    clockwise: bool = True
    plate_dn: float = 5000.0
    blackbody_dn: float = 6000.0
    wheel_dn: float = 4950.0
    noise_dn: float = 3.0
    delay_s: float = 4e-4
    integration_s: float = 250e-6
    sub: int = 8
    n_angles: int = 1440
    distortion: float = 0.0

    def beside_axle(self, row, column):
        """Places of the image before the lens, down and across from the axle; by fixed-point iteration."""
        middle, unit = np.array([self.rows - 1, self.columns - 1]) / 2, np.hypot(self.rows, self.columns) / 2

        def unbent(y, x):
            bend = self.distortion * (y**2 + x**2) / unit**2
            factor = np.ones_like(bend)
            for _ in range(30 if self.distortion else 0):
                np.multiply(factor, factor, out=factor)
                np.multiply(factor, bend, out=factor)
                np.add(factor, 1, out=factor)
                np.reciprocal(factor, out=factor)
            return factor * y, factor * x

        place = unbent(row - middle[0], column - middle[1])
        axle = unbent(self.axle[0] - middle[0], self.axle[1] - middle[1])
        return place[0] - axle[0], place[1] - axle[1]

    def points(self):
        """Rows and columns of the sub-pixel points and whether the mask lets them through."""
        place = (np.arange(self.sub) + 0.5) / self.sub - 0.5
        row = (np.arange(self.rows)[:, None] + place).ravel()
        column = (np.arange(self.columns)[:, None] + place).ravel()
        row, column = np.meshgrid(row, column, indexing="ij")
        down, across = self.beside_axle(row, column)
        own = (down - self.mask_centre[0], across - self.mask_centre[1])
        radius = np.hypot(*own)
        beside = np.mod(np.arctan2(*own) - self.bisector_rad + np.pi, TURN) - np.pi
        through = (radius > self.radii[0]) & (radius < self.radii[1]) & (np.abs(beside) < self.opening_rad / 2)
        return row, column, through

    def light_by_angle(self):
        """Blurred light of each pixel by wheel coordinate at theta = 0, shape (angle, row, column), which sums to the opening.

        Second the angles that have any, in steps of which a turn has ``n_angles``.
        """
        from scipy import ndimage

        (row, column, through), n_angles = self.points(), self.n_angles
        phi = np.arctan2(*self.beside_axle(row[through], column[through]))
        alpha = self.gate_rad - (phi if self.clockwise else np.pi - phi)
        pixel = np.repeat(np.arange(self.rows), self.sub)[:, None] * self.columns
        pixel = pixel + np.repeat(np.arange(self.columns), self.sub)[None, :]
        where = np.mod(np.floor(alpha / TURN * n_angles).astype(int), n_angles)
        used, place = np.unique(where, return_inverse=True)
        flat = place * (self.rows * self.columns) + pixel[through]
        light = np.bincount(flat, minlength=used.size * self.rows * self.columns) / self.sub**2
        light = light.reshape(used.size, self.rows, self.columns)
        light = ndimage.gaussian_filter(light, (0, self.blur_px, self.blur_px), mode="constant")
        return light, used

    def frames(self, theta_of, times, *, seed=0):
        """Frames for triggers at the given times: the wheel at 9 instants of the window."""
        light, used = self.light_by_angle()
        alpha = (used + 0.5) / self.n_angles * TURN
        light = light.reshape(used.size, -1)
        share = np.zeros((times.size, alpha.size))
        for instant in (np.arange(9) + 0.5) / 9 * self.integration_s:
            wheel = np.mod(theta_of(times + self.delay_s + instant)[:, None] + alpha, TURN)
            share += ((wheel >= self.edges[1]) & (wheel < self.edges[2])) | (wheel >= self.edges[3])
        share /= 9
        opening = light.sum(axis=0)
        scene = self.plate_dn + (self.wheel_dn - self.plate_dn) * opening
        lit = opening > 0
        scene = np.repeat(scene[None], times.size, axis=0)
        scene[:, lit] += (self.blackbody_dn - self.wheel_dn) * (share @ light[:, lit])
        noise = np.random.default_rng(seed).normal(0, self.noise_dn, scene.shape)
        return np.clip(np.rint(scene + noise), 0, 16383).astype(np.uint16).reshape(-1, self.rows, self.columns)


@pytest.fixture(scope="session")
def paper_camera() -> type[PaperCamera]:
    """Camera that sees mask and wheel by brute force."""
    return PaperCamera


@pytest.fixture(scope="session")
def flat_reference() -> Callable[..., NonuniformityReference]:
    """Non-uniformity reference of a camera with the given gain and offset per pixel (rows, columns)."""

    def make(gain, offset, *, noise=None, levels=(5000.0, 6000.0)):
        noise = np.full(gain.shape, 3.0) if noise is None else noise
        low, high = (offset + gain * level for level in levels)
        return NonuniformityReference(low_dn=low, high_dn=high, low_noise_dn=noise, high_noise_dn=noise, n_frames=50)

    return make


@dataclass(frozen=True, kw_only=True)
class PaperBolometer:
    """A rolling camera whose pixels lag: `PaperCamera`'s light, each ray relaxed by small steps, each row read on its own."""

    camera: PaperCamera = field(default_factory=lambda: PaperCamera(plate_dn=4950.0, blackbody_dn=4000.0))
    rate_hz: float = 3.0
    delay_s: float = 2.3e-3
    time_constant_s: float = 6e-3
    row_delay_s: float = 60e-6
    noise_dn: float = 5.0

    def response(self, n=7200):
        """Lagged opening of one ray over the wheel coordinate, shape (n,): Euler's method, three turns."""
        wheel = TURN * np.arange(n) / n
        edges = self.camera.edges
        target = ((wheel >= edges[1]) & (wheel < edges[2])) | (wheel >= edges[3])
        keep = np.exp(-1 / (n * self.rate_hz * self.time_constant_s))
        value, seen = 0.5, np.zeros(n)
        for _ in range(3):
            for k in range(n):
                value = target[k] + (value - target[k]) * keep
                seen[k] = value
        return wheel, seen

    def opening(self):
        """How much of each pixel is opening, shape (row, column)."""
        return self.camera.light_by_angle()[0].sum(axis=0)

    def scene(self, theta):
        """Values without noise for wheel angles at the triggers, shape (frame, row, column)."""
        camera = self.camera
        light, used = camera.light_by_angle()
        alpha = (used + 0.5) / camera.n_angles * TURN
        wheel, seen = self.response()
        values = np.empty((theta.size, camera.rows, camera.columns))
        for row in range(camera.rows):
            at = theta + TURN * self.rate_hz * (self.delay_s + row * self.row_delay_s)
            opening = light[:, row]
            values[:, row] = camera.plate_dn + (camera.wheel_dn - camera.plate_dn) * opening.sum(axis=0)
            if opening.any():
                share = np.interp(at[:, None] + alpha, wheel, seen, period=TURN)
                values[:, row] += (camera.blackbody_dn - camera.wheel_dn) * (share @ opening)
        return values

    def noisy(self, values, *, seed=0):
        """What the camera makes of them."""
        noisy = values + self.noise_dn * _white(seed, values.shape)
        return np.clip(np.rint(noisy, out=noisy), 0, 65535, out=noisy).astype(np.uint16)


@lru_cache(maxsize=2)
def _white(seed, shape):
    """Normal noise of standard deviation 1: drawn once for all recordings of a seed, for drawing takes longer than reducing."""
    return np.random.default_rng(seed).standard_normal(shape, dtype=np.float32)


@pytest.fixture(scope="session")
def paper_bolometer() -> type[PaperBolometer]:
    """Rolling camera that sees mask and wheel by brute force."""
    return PaperBolometer


@pytest.fixture(scope="session")
def rolled(paper_wheel, recorded) -> Callable[..., Recording]:
    """Recording of a rolling microbolometer: ``rolled(frames, triggers=..., **fields)``.

    Frame i belongs to trigger i unless ``frame_number`` says otherwise.
    """
    wheel = paper_wheel(duration_s=36.0)

    def record(frames, **fields):
        values = {
            "camera_type": "microbolometer",
            "readout_mode": "rolling",
            "bit_depth": 16,
            "integration_time_s": None,
            "n_triggers": len(frames),
        }
        return recorded(wheel, frames=frames, **(values | fields))

    return record


@pytest.fixture(scope="session")
def trigger_angles(paper_wheel) -> Callable[[int], np.ndarray]:
    """Wheel angle of `rolled` at each of its triggers, shape (n,)."""
    wheel = paper_wheel(duration_s=36.0)
    return lambda n: wheel.theta(0.35 + 0.033 * np.arange(n))


@pytest.fixture(scope="session")
def turning(paper_bolometer, trigger_angles) -> np.ndarray:
    """Thousand noise-free frames before a cold blackbody; copy before you write."""
    return paper_bolometer().scene(trigger_angles(1000))

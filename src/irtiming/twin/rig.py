"""The simulated rig: draws its imperfections, says what its owner measures on it, and records runs."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any, final

import numpy as np

from irtiming.errors import GeometryError
from irtiming.records.arrays import Ticks
from irtiming.records.camera_frame import SIMULATED_VENDOR, CameraIdentity
from irtiming.records.recording import FrameStack, NonuniformityReference, Recording
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel
from irtiming.twin import free_camera, kept_frames, window
from irtiming.twin.clockwork import Motion, TickStreams, spin, tick_streams
from irtiming.twin.defects import defects_of
from irtiming.twin.frames import SimulatedFrames, nonuniformity_reference
from irtiming.twin.noise import generator
from irtiming.twin.processed_frames import ProcessedFrames
from irtiming.twin.readout import pattern_of, wheel_shots
from irtiming.twin.scene import (
    BolometerTiming,
    CameraTiming,
    ChopperWheel,
    Detector,
    Radiance,
    Scene,
    Timing,
    readout_mode_of,
)
from irtiming.twin.upkeep import Drift

_NAMES = {
    (True, "snapshot"): "cooled",
    (True, "rolling"): "cmos",
    (False, "rolling"): "bolo",
    (False, "snapshot"): "lagging",
}
"""How recordings begin: whether of photons, and the readout."""


@final
@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """Standard deviations of a rig about its drawing, and of its owner's measurements about the rig.

    ``ring_edge_rad`` is half the width of a uniform spread. ``slot_eccentricity_rad`` is the amplitude of
    the slots' once-per-turn error, at a random phase. ``trigger_delay_s`` is a photon camera's; a microbolometer
    has ``bolometer_delay_s`` and ``time_constant_s``; ``row_delay_s`` is a rolling readout's.
    """

    ring_edge_rad: float = 0.5e-3
    cutout_error_rad: float = 0.05e-3
    slot_error_rad: float = 0.35e-3
    slot_eccentricity_rad: float = 0.4e-3
    beam_m: float = 0.02e-3
    mask_angle_rad: float = math.radians(0.1)
    mask_centre_m: float = 0.1e-3
    roll_rad: float = math.radians(0.5)
    wheel_centre_px: float = 1.0
    trigger_delay_s: float = 30e-6
    bolometer_delay_s: float = 300e-6
    time_constant_s: float = 300e-6
    row_delay_s: float = 1e-6
    u_beam_m: float = 0.05e-3
    u_mask_angle_rad: float = math.radians(0.03)


@final
@dataclass(frozen=True, kw_only=True)
class SimulatedRig:
    """One rig with its defects: the truth (``scene``) and what its owner measured (``measured``)."""

    scene: Scene
    measured: Rig


def draw(nominal: Scene, *, seed: int, tolerances: Tolerances | None = None) -> SimulatedRig:
    """Rig with random imperfections about the nominal scene; the same seed gives the same rig.

    Raises
    ------
    GeometryError
        If the tolerances tear the wheel or the gates apart.
    """
    spread = tolerances or Tolerances()
    random = generator(seed, "rig")
    scene = replace(
        nominal,
        wheel=_drawn_wheel(nominal.wheel, spread, random),
        beams=replace(
            nominal.beams,
            half_separation_m=random.normal(nominal.beams.half_separation_m, spread.beam_m),
            height_difference_m=random.normal(nominal.beams.height_difference_m, spread.beam_m),
            height_m=random.normal(nominal.beams.height_m, spread.beam_m),
        ),
        mask=replace(
            nominal.mask,
            centre_angle_rad=random.normal(nominal.mask.centre_angle_rad, spread.mask_angle_rad),
            centre_x_m=random.normal(nominal.mask.centre_x_m, spread.mask_centre_m),
            centre_y_m=random.normal(nominal.mask.centre_y_m, spread.mask_centre_m),
        ),
        optics=replace(
            nominal.optics,
            roll_rad=random.normal(nominal.optics.roll_rad, spread.roll_rad),
            wheel_centre_row_px=random.normal(nominal.optics.wheel_centre_row_px, spread.wheel_centre_px),
            wheel_centre_column_px=random.normal(nominal.optics.wheel_centre_column_px, spread.wheel_centre_px),
        ),
        timing=_drawn_timing(nominal.timing, spread, random),
        detector=replace(nominal.detector, pattern_seed=int(random.integers(2**31))),
    )
    measured = _measured(scene, spread, random)
    if nominal.optics.roll_rad:  # a camera that was rolled on purpose
        roll = Measured(nominal.optics.roll_rad, spread.roll_rad)
        measured = replace(measured, camera=replace(measured.camera, roll_rad=roll))
    return SimulatedRig(scene=scene, measured=measured)


def _drawn_timing(nominal: Timing, spread: Tolerances, random: np.random.Generator) -> Timing:
    """Timing of one camera of its kind."""
    photon = isinstance(nominal, CameraTiming)
    u_delay_s = spread.trigger_delay_s if photon else spread.bolometer_delay_s
    drawn = replace(nominal, trigger_delay_s=abs(random.normal(nominal.trigger_delay_s, u_delay_s)))
    if isinstance(drawn, BolometerTiming):
        drawn = replace(drawn, time_constant_s=abs(random.normal(drawn.time_constant_s, spread.time_constant_s)))
    if drawn.row_delay_s is not None:
        drawn = replace(drawn, row_delay_s=random.normal(drawn.row_delay_s, spread.row_delay_s))
    return drawn


def _drawn_wheel(nominal: ChopperWheel, spread: Tolerances, random: np.random.Generator) -> ChopperWheel:
    """Wheel with its own edges; edge 2 lies beyond half a turn, which makes edge 0 the reference."""
    off = random.uniform(-spread.ring_edge_rad, spread.ring_edge_rad, 4)
    ring = [edge + error for edge, error in zip(nominal.ring_edges_rad, off, strict=True)]
    longer = math.pi + max(abs(ring[2] - math.pi), 0.2 * spread.ring_edge_rad)
    cutout = random.normal(nominal.cutout_errors_rad, spread.cutout_error_rad)
    n_slots = len(nominal.control_slot_errors_rad)
    once = 2 * math.pi * np.arange(n_slots) / n_slots + random.uniform(0, 2 * math.pi)
    slots = random.normal(nominal.control_slot_errors_rad, spread.slot_error_rad)
    slots += spread.slot_eccentricity_rad * np.cos(once)
    return replace(
        nominal,
        ring_edges_rad=(0.0, ring[1], longer, ring[3]),
        cutout_errors_rad=(float(cutout[0]), float(cutout[1]), float(cutout[2]), float(cutout[3])),
        control_slot_errors_rad=tuple(float(slot) for slot in slots),
    )


def _measured(scene: Scene, spread: Tolerances, random: np.random.Generator) -> Rig:
    """The rig as its owner describes it: caliper, inclinometer, and edges taken from the ring."""

    def reading(truth: float, uncertainty: float) -> Measured:
        return Measured(float(random.normal(truth, uncertainty)), uncertainty)

    ring = scene.wheel.ring_edges_rad
    n_slots = len(scene.wheel.control_slot_errors_rad)
    return Rig(
        wheel=Wheel(
            control_slots=n_slots,
            rotation=scene.wheel.rotation,
            cutout_edges_rad=(Measured(ring[0]), Measured(ring[1]), Measured(ring[2]), Measured(ring[3])),
        ),
        light_gates=LightGates(
            half_separation_m=reading(scene.beams.half_separation_m, spread.u_beam_m),
            height_difference_m=reading(scene.beams.height_difference_m, spread.u_beam_m),
            whole_slots_between=whole_slots_between(scene),
        ),
        mask_opening=MaskOpening(
            opening_angle_rad=Measured(scene.mask.opening_angle_rad),
            centre_angle_rad=reading(scene.mask.centre_angle_rad, spread.u_mask_angle_rad),
        ),
        source="twin",
    )


def whole_slots_between(scene: Scene) -> int:
    """Whole control slots between the beams, as somebody counts them on the wheel.

    Raises
    ------
    GeometryError
        If the beams are on the wrong sides of the axle.
    """
    between = scene.beams.beta_1_rad + scene.beams.beta_2_rad
    if not 0 < between < math.pi:
        raise GeometryError(f"{between} rad between the beams; it must lie between 0 and pi: check d, dh and h")
    return math.floor(between * len(scene.wheel.control_slot_errors_rad) / (2 * math.pi))


def simulate(scene: Scene, *, seed: int, name: str = "twin") -> Recording:
    """One run of the scene; its frames are made when they are asked for, and always the same.

    Parameters
    ----------
    scene
        The rig as it truly is, and the run's trigger settings.
    seed
        Fixes noise, speed wander, jitter and faults of this run, not the rig.
    name
        Title of the recording.
    """
    motion = spin(scene, seed=seed)
    return recorded(scene, motion, ticks=tick_streams(scene, motion, seed=seed), seed=seed, name=name)


def recorded(scene: Scene, motion: Motion, *, ticks: TickStreams, seed: int, name: str = "twin") -> Recording:
    """One run of the scene with a wheel that turned so and timestamps that were taken so.

    Parameters
    ----------
    scene
        The rig as it truly is, and the run's trigger settings.
    motion
        Of the wheel, from before the first trigger, which is at time zero, to the end of the last frame.
    ticks
        Timestamps, of the twin's own clock or of a trigger generator.
    seed
        Fixes noise, jitter and lost frames.
    name
        Title of the recording.
    """
    kept, trigger, timing = _kept_frames(scene, seed), scene.trigger, scene.timing
    photon = isinstance(timing, CameraTiming)
    referenced = photon and scene.radiance.reference_frames > 0
    run = Recording(
        name=name,
        camera_type="photon" if photon else "microbolometer",
        readout_mode=readout_mode_of(timing),
        frames=_frames(scene, motion, kept=kept, seed=seed),
        frame_number=kept,
        clock_frequency_hz=trigger.clock_frequency_hz,
        camera_trigger_ticks=ticks.camera_trigger,
        control_slot_ticks=ticks.control_slot,
        application_slot_ticks=ticks.application_slot,
        application_edge_ticks=ticks.application_edges,
        spare_ticks=ticks.spare,
        rotation_speed_hz=trigger.wheel_hz,
        integration_time_s=_stated_window_s(timing),
        trigger_delay_time_set_s=trigger.trigger_delay_time_set_s,
        bit_depth=scene.detector.bits,
        camera_period_ticks=trigger.camera_period_ticks,
        wheel_period_ticks=trigger.turn_period_ticks,
        blackbody_temperature_k=scene.radiance.blackbody_k,
        nonuniformity=_reference(scene.radiance, scene.detector, _reference_seed(scene, seed)) if referenced else None,
        camera=_identity(scene, photon=photon),
        is_simulated=True,
        source=f"twin, seed {seed}",
    )
    return run if scene.free is None else replace(run, **free_camera.observed(scene, scene.free, kept=kept, seed=seed))


def _identity(scene: Scene, *, photon: bool) -> CameraIdentity:
    """The camera is the one with this pattern of gains and offsets."""
    return CameraIdentity(
        vendor=SIMULATED_VENDOR, model="Twin photon camera" if photon else "Twin microbolometer",
        serial_number=f"SIM{scene.detector.pattern_seed}", firmware="1.0", address="",
    )  # fmt: skip


def _frames(scene: Scene, motion: Motion, *, kept: Ticks, seed: int) -> FrameStack:
    """Frames that arrive; where each has something of those before it, all are made."""
    size = (scene.detector.rows, scene.detector.columns)
    if scene.in_camera.is_plain:
        return kept_frames.kept(
            SimulatedFrames(shape=(kept.size, *size), make=wheel_shots(scene, motion, kept=kept, seed=seed)),
            one_by_one=True,
        )
    all_triggers = np.arange(scene.trigger.n_triggers, dtype=np.int64)
    shots = wheel_shots(scene, motion, kept=all_triggers, seed=seed)
    detector = SimulatedFrames(shape=(all_triggers.size, *size), make=shots)
    return kept_frames.kept(ProcessedFrames(detector=detector, kept=kept, in_camera=scene.in_camera), one_by_one=False)


def _stated_window_s(timing: Timing) -> float | None:
    return timing.integration_time_s + timing.count_time_error_s if isinstance(timing, CameraTiming) else None


def _reference_seed(scene: Scene, seed: int) -> int:
    """What fixes the noise of the references: the detector, or the recording too."""
    return seed if scene.radiance.references_anew else scene.detector.pattern_seed


@lru_cache(maxsize=2)
def _reference(radiance: Radiance, detector: Detector, seed: int) -> NonuniformityReference:
    return nonuniformity_reference(radiance, pattern_of(detector), seed=seed)


def _kept_frames(scene: Scene, seed: int) -> Any:
    """Indices of the triggers whose frames arrive, shape (n_frame,)."""
    n = scene.trigger.n_triggers
    lost = generator(seed, "faults").choice(n, size=min(scene.faults.lost_frames, n), replace=False)
    return np.delete(np.arange(n, dtype=np.int64), lost)


def series(
    scene: Scene, delays_s: Sequence[float], *, repeats: int, seed: int, random_start: bool = False
) -> Iterator[Recording]:
    """Runs of one rig, one after the other: every extra delay, ``repeats`` times each.

    Parameters
    ----------
    scene
        The rig as it truly is.
    delays_s
        Extra delays set in the trigger generator, s.
    repeats
        Runs per delay.
    seed
        Fixes all runs; each has its own noise and wander.
    random_start
        Begin each run anywhere in the turn; otherwise at the same phase of the chopper's reference.
    """
    runs = [(delay_s, repeat) for delay_s in delays_s for repeat in range(repeats)]
    for index, (delay_s, repeat) in enumerate(runs):
        random = generator(seed, "run", index=index)
        start = random.uniform(0, 2 * math.pi) if random_start else scene.trigger.start_angle_rad
        trigger = replace(scene.trigger, trigger_delay_time_set_s=delay_s, start_angle_rad=start)
        kind = _NAMES[isinstance(scene.timing, CameraTiming), readout_mode_of(scene.timing)]
        name = f"{kind}-{trigger.wheel_hz:g}Hz-{delay_s * 1e3:g}ms" + (f"-run{repeat + 1:02d}" if repeats > 1 else "")
        yield simulate(replace(scene, trigger=trigger), seed=int(random.integers(2**31)), name=name)


def truth(scene: Scene) -> dict[str, object]:
    """True values of all that can be measured on the scene's recordings, flat, keys with their unit."""
    optics = scene.optics
    return {
        **_camera_truth(scene),
        "beta_1_rad": scene.beams.beta_1_rad,
        "beta_2_rad": scene.beams.beta_2_rad,
        "ring_edges_rad": list(scene.wheel.ring_edges_rad),
        "cutout_edges_rad": list(scene.wheel.cutout_edges_rad),
        "control_slot_angles_rad": list(scene.wheel.control_slot_angles_rad),
        "mask_centre_angle_rad": scene.mask.centre_angle_rad,
        "mask_opening_angle_rad": scene.mask.opening_angle_rad,
        "mask_centre_x_m": scene.mask.centre_x_m,
        "mask_centre_y_m": scene.mask.centre_y_m,
        "roll_rad": optics.roll_rad,
        "wheel_centre_row_px": optics.wheel_centre_row_px,
        "wheel_centre_column_px": optics.wheel_centre_column_px,
        "wheel_centre_row_column_px": [optics.wheel_centre_row_px, optics.wheel_centre_column_px],
        "pixel_pitch_m": optics.pixel_pitch_m,
        "blur_px": optics.blur_px,
        "rotation": scene.wheel.rotation,
        **asdict(defects_of(scene)),
    }


def _lag_truth(timing: BolometerTiming) -> dict[str, object]:
    """The one time constant, or the two of pixels that radiate."""
    if timing.radiative is None:
        return {"time_constant_s": timing.time_constant_s}
    return {
        "substrate_time_constant_s": timing.time_constant_s,
        "scene_time_constant_s": timing.radiative.scene_time_constant_s,
        "reference_temperature_k": timing.radiative.reference_k,
        "substrate_temperature_k": timing.radiative.substrate_k,
    }


def _camera_truth(scene: Scene) -> dict[str, object]:
    """What is true of this kind of camera only."""
    timing = scene.timing
    name, delay_s = _delay_truth(scene)
    shared: dict[str, object] = {"readout_mode": readout_mode_of(timing), name: delay_s}
    if timing.row_delay_s is not None:
        shared["row_delay_s"] = timing.row_delay_s
    if isinstance(timing, BolometerTiming):
        return {"camera": "microbolometer", **shared, **_lag_truth(timing), **_upkeep_truth(scene)}
    return {
        "camera": "photon",
        **shared,
        "exposure_midpoint_delay_s": delay_s + window.centre_s(timing),
        "integration_time_s": timing.integration_time_s,
        **(_upkeep_truth(scene) if scene.correction.events or scene.drift != Drift() else {}),
    }


def _delay_truth(scene: Scene) -> tuple[str, float]:
    """Name and true value of the first delay: from the trigger, or from the event of a camera that runs free."""
    after_s, free = scene.timing.trigger_delay_s, scene.free
    if free is None:
        return "trigger_delay_s", after_s
    name = "strobe_delay_s" if free.event == "strobe" else "timestamp_delay_s"
    return name, free_camera.delay_s(free, exposed_after_s=after_s)


def _upkeep_truth(scene: Scene) -> dict[str, object]:
    """What the camera does to keep its image even, and how it drifts."""
    drift, events = scene.drift, scene.correction.events
    return {
        "shutter_start_s": [event.start_s for event in events],
        "shutter_duration_s": [event.duration_s for event in events],
        "shutter_kind": " ".join(event.kind for event in events),
        "shutter_level_jump_dn": [event.level_jump_dn for event in events],
        "drift_per_second_dn": drift.per_second_dn,
        "drift_settling_dn": drift.settling_dn,
        "drift_settling_time_s": drift.settling_time_s,
    }

"""A rig as a laboratory has it: every defect at once, drawn at random, and what its owner knows of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from irtiming.records.rig import CameraOptics, Clock, Latency, Measured
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.noise import generator
from irtiming.twin.rig import SimulatedRig, whole_slots_between
from irtiming.twin.scene import CameraTiming, Scene
from irtiming.twin.upkeep import SelfCorrection, ShutterEvent

_LATE_S, _LATE_TRIGGER_S = (1e-6, 20e-6), (0.2e-6, 2e-6)
_CLOCK = 50e-6
_ASIDE_M = (0.05e-3, 0.2e-3)
_TILT_RAD, _FOCAL_WIDTHS = math.radians(1.5), (1.5, 4.5)
_LENS_CENTRE_WIDTHS, _DISTORTION = 0.03, -0.05
_BLUR_PX, _BLUR_RATIO, _BLUR_GROWTH = (0.5, 1.0), 2.0, (0.0, 1.0)
_GLARE, _GLARE_PX = (0.01, 0.03), (3.0, 8.0)
_BLADE, _SWAY = (0.003, 0.015), (0.01, 0.05)
_FILTER, _MEMORY = (0.0, 0.3), (0.0, 0.01)
_EDGE_S, _TAIL, _TAIL_S = (1e-6, 20e-6), (0.01, 0.04), (50e-6, 300e-6)
_OFF_S = (2e-6, 15e-6)
_SLOWEST_EDGE, _MOST_OFF = 0.25, 0.05
"""Of the window: how long it may rise at most, and by how much the time that the camera states may be off."""

_SHUTTER_K = 300.15
_BETWEEN, _UNSEEN_S = 0.6, 1e-3
"""Of a camera period after a trigger, and for how long: no frame is taken then."""

_EVENT, _EVENT_JUMP = (0.1, 0.85), 0.008
"""When in a run the camera corrects itself, and by how much its levels change then, in units of the contrast."""


@final
@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """How well the owner of a rig knows its defects: standard uncertainties of the values that rig.toml states.

    One that is None is not stated. ``u_integration_time_s`` is what is stated of the time that the camera says.
    """

    u_latency_s: float | None = 0.3e-6
    u_clock: float | None = 5e-6
    u_lateral_offset_m: float | None = 0.05e-3
    u_integration_time_s: float | None = None


def draw_defects(scene: Scene, *, seed: int, always: bool = False) -> Defects:
    """Every defect that this kind of camera may have, of the size that is usual; the same seed draws the same.

    Half of the cameras have neither filter nor memory, and half of the windows no tail.

    Parameters
    ----------
    scene
        The camera and the size of its image count.
    seed
        Of the rig.
    always
        Whether there is a filter, a memory and a tail in any case.
    """
    random, width = generator(seed, "laboratory"), scene.detector.columns
    tilt_rad, towards = random.uniform(0, _TILT_RAD), random.uniform(0, 2 * math.pi)
    lens_centre = random.uniform(-1, 1, 2) * _LENS_CENTRE_WIDTHS * width
    rows_px, columns_px = _blurs(random)
    shared = Defects(
        late_application_gate_s=random.uniform(*_LATE_S),
        late_control_gate_s=random.uniform(*_LATE_S),
        late_trigger_s=random.uniform(*_LATE_TRIGGER_S),
        clock_relative_error=random.uniform(-_CLOCK, _CLOCK),
        lateral_offset_m=_signed(random, *_ASIDE_M),
        tilt_about_row_rad=tilt_rad * math.cos(towards),
        tilt_about_column_rad=tilt_rad * math.sin(towards),
        focal_length_px=random.uniform(*_FOCAL_WIDTHS) * width,
        lens_centre_row_px=float(lens_centre[0]),
        lens_centre_column_px=float(lens_centre[1]),
        distortion=random.uniform(_DISTORTION, 0),
        blur_rows_px=rows_px,
        blur_columns_px=columns_px,
        blur_turn_rad=float(generator(seed, "laboratory", index=1).uniform(-math.pi / 2, math.pi / 2)),
        blur_growth=generator(seed, "laboratory", index=2).uniform(*_BLUR_GROWTH),
        glare_share=random.uniform(*_GLARE),
        glare_px=random.uniform(*_GLARE_PX),
        glare_shape="gaussian" if random.random() < 0.5 else "exponential",
        blade_share=_signed(random, *_BLADE),
        sway_share=random.uniform(*_SWAY),
    )
    often, tailed = (bool(random.random() < 0.5) or always for _ in range(2))
    if not isinstance(scene.timing, CameraTiming):
        return replace(shared, filter_share=random.uniform(*_FILTER) if often else 0.0)
    window_s = scene.timing.integration_time_s
    slowest_s = min(_EDGE_S[1], _SLOWEST_EDGE * window_s)
    return replace(
        shared,
        memory_share=random.uniform(*_MEMORY) if often else 0.0,
        rise_s=random.uniform(min(_EDGE_S[0], slowest_s), slowest_s),
        fall_s=random.uniform(min(_EDGE_S[0], slowest_s), slowest_s),
        tail_share=random.uniform(*_TAIL) if tailed else 0.0,
        tail_s=random.uniform(*_TAIL_S),
        count_time_error_s=float(generator(seed, "statement", index=2).standard_normal() * _u_window_s(window_s, seed)),
        references_anew=bool(random.random() < 0.5),
    )


def usual_knowledge(scene: Scene, *, seed: int) -> Knowledge:
    """How well a laboratory knows its defects, and the integration time that its camera states.

    Parameters
    ----------
    scene
        The camera's timing counts.
    seed
        Of the rig.
    """
    if not isinstance(scene.timing, CameraTiming):
        return Knowledge()
    return Knowledge(u_integration_time_s=_u_window_s(scene.timing.integration_time_s, seed))


def _u_window_s(window_s: float, seed: int) -> float:
    return min(float(generator(seed, "statement", index=1).uniform(*_OFF_S)), _MOST_OFF * window_s)


def with_self_correction(scene: Scene, *, seed: int, always: bool = False) -> Scene:
    """The scene of a camera that corrects itself once in the run: always a microbolometer camera, half of the others.

    A microbolometer camera closes its shutter for some frames. Another one is done between two frames, so that only its levels
    jump; where it does so ``always``, it closes a shutter too.

    Parameters
    ----------
    scene
        Of any camera.
    seed
        Of the rig.
    always
        Whether the shutter closes in any case.
    """
    random, run_s = generator(seed, "laboratory", index=1), _run_s(scene)
    start_s, seldom = run_s * random.uniform(*_EVENT), random.random() < 0.5 and not always
    if scene.correction.events or (isinstance(scene.timing, CameraTiming) and seldom):
        return scene
    radiance = scene.radiance
    contrast_dn = abs(radiance.level_dn(radiance.blackbody_k) - radiance.level_dn(radiance.wheel_k))
    event = ShutterEvent(start_s=start_s, level_jump_dn=_EVENT_JUMP * contrast_dn)
    if isinstance(scene.timing, CameraTiming) and not always:
        period_s = scene.trigger.camera_period_ticks / scene.trigger.clock_frequency_hz
        between_s = (math.floor(start_s / period_s) + _BETWEEN) * period_s
        event = replace(event, start_s=between_s, duration_s=_UNSEEN_S)
    return replace(scene, correction=SelfCorrection(surface_k=_SHUTTER_K, events=(event,)))


def _run_s(scene: Scene) -> float:
    return scene.trigger.n_triggers * scene.trigger.camera_period_ticks / scene.trigger.clock_frequency_hz


def known(rig: SimulatedRig, *, seed: int, knowledge: Knowledge | None = None) -> SimulatedRig:
    """The rig with what its owner measured of its defects: the truth and a normal draw with the stated uncertainty.

    Parameters
    ----------
    rig
        With its defects in place; what is measured of it is completed.
    seed
        Of the rig.
    knowledge
        How well the owner knows the defects; as is usual, if not given.
    """
    random, scene = generator(seed, "statement"), rig.scene
    told = knowledge or usual_knowledge(scene, seed=seed)

    def reading(truth: float, u: float | None) -> Measured | None:
        error = random.standard_normal()
        return None if u is None else Measured(float(truth + error * u), u)

    latency = Latency(
        application_gate_s=reading(scene.beams.late_application_gate_s, told.u_latency_s),
        control_gate_s=reading(scene.beams.late_control_gate_s, told.u_latency_s),
        trigger_s=reading(scene.trigger.late_trigger_s, told.u_latency_s),
    )
    clock = reading(scene.trigger.clock_relative_error, told.u_clock)
    gates = replace(
        rig.measured.light_gates,
        whole_slots_between=whole_slots_between(scene),
        lateral_offset_m=reading(scene.beams.lateral_offset_m, told.u_lateral_offset_m),
    )
    measured = replace(
        rig.measured,
        light_gates=gates,
        latency=None if told.u_latency_s is None else latency,
        clock=None if clock is None else Clock(relative_error=clock),
        camera=CameraOptics(
            distortion=rig.measured.camera.distortion, integration_time_u_s=told.u_integration_time_s
        ),
    )  # fmt: skip
    return replace(rig, measured=measured)


def in_laboratory(rig: SimulatedRig, *, seed: int, asked: Mapping[str, Any] | None = None) -> SimulatedRig:
    """The rig with every defect at once, and what its owner knows of them.

    Parameters
    ----------
    rig
        As it was drawn, without defects.
    seed
        Of the rig.
    asked
        Fields of `Defects` that are not drawn, with their values, none among them.
    """
    drawn = replace(draw_defects(rig.scene, seed=seed), **(asked or {}))
    scene = with_defects(with_self_correction(rig.scene, seed=seed), drawn)
    return known(replace(rig, scene=scene), seed=seed)


def _signed(random: np.random.Generator, least: float, most: float) -> float:
    """Something between two sizes, of either sign."""
    return float(random.uniform(least, most) * random.choice([-1, 1]))


def _blurs(random: np.random.Generator) -> list[float]:
    """Standard deviations from row to row and from column to column, px."""
    narrow = random.uniform(_BLUR_PX[0], sum(_BLUR_PX) / 2)
    wide = narrow * random.uniform(1, min(_BLUR_RATIO, _BLUR_PX[1] / narrow))
    return [float(blur) for blur in random.permutation([narrow, wide])]

"""Whole laboratories at random, in images small enough that hundreds of them can be tried."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Literal, TypeAlias, final, get_args

import numpy as np

from irtiming.records.recording import CameraType, ReadoutMode, Recording
from irtiming.twin import rig as rigs
from irtiming.twin.cameras import camera_scene
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.laboratory import draw_defects, known, with_self_correction
from irtiming.twin.noise import generator
from irtiming.twin.rig import SimulatedRig, Tolerances
from irtiming.twin.scene import BolometerTiming, CameraTiming, Scene, Timing, with_wheel_speed

Group: TypeAlias = Literal[
    "none", "latency", "clock", "aside", "tilt", "lens", "blur", "glare", "blades", "sway", "shutter", "references", "filter",
    "averaging", "memory", "window", "count-time",
]  # fmt: skip
"""Defects that come alone; "none" is a laboratory without any, whose owner does not know that."""

_FIELDS: dict[str, tuple[str, ...]] = {
    "latency": ("late_application_gate_s", "late_control_gate_s", "late_trigger_s"),
    "clock": ("clock_relative_error",),
    "aside": ("lateral_offset_m",),
    "tilt": ("tilt_about_row_rad", "tilt_about_column_rad", "focal_length_px"),
    "lens": ("lens_centre_row_px", "lens_centre_column_px", "distortion"),
    "blur": ("blur_rows_px", "blur_columns_px", "blur_turn_rad", "blur_growth"),
    "glare": ("glare_share", "glare_px", "glare_shape"),
    "blades": ("blade_share",),
    "sway": ("sway_share",),
    "references": ("references_anew",),
    "filter": ("filter_share",),
    "averaging": ("averaged_frames",),
    "memory": ("memory_share",),
    "window": ("rise_s", "fall_s", "tail_share", "tail_s"),
    "count-time": ("count_time_error_s",),
}
_ONLY: dict[CameraType, tuple[str, ...]] = {
    "photon": ("references", "memory", "window", "count-time"),
    "microbolometer": ("filter", "averaging"),
}
_WINDOW_S, _LAG_S = (0.15e-3, 1.5e-3), (3e-3, 12e-3)
_DELAY_S: dict[CameraType, float] = {"photon": 1e-3, "microbolometer": 4e-3}
_ROW_S = (30e-6, 100e-6)


@final
@dataclass(frozen=True, kw_only=True)
class Wanted:
    """A kind of laboratory: camera, image, frames of each recording, one at each wheel rate, and the defect that is alone there.

    ``only`` is None where all defects come at once; a lens shows the image's corners too near to the middle, as a barrel, or
    too far from it.
    """

    camera: CameraType = "photon"
    readout: ReadoutMode | None = None
    rows: int = 120
    columns: int = 160
    frames: int = 500
    wheel_hz: tuple[float, ...] = (3.0,)
    only: Group | None = None
    lens: Literal["barrel", "pincushion"] = "barrel"


def groups(camera: CameraType) -> tuple[Group, ...]:
    """Defects that this kind of camera may have alone."""
    foreign = [name for other, names in _ONLY.items() if other != camera for name in names]
    return tuple(group for group in get_args(Group) if group not in foreign)


def draw(wanted: Wanted, *, seed: int, experiment: Scene | None = None) -> SimulatedRig:
    """A laboratory with its own camera, wheel, gates, mask, optics and defects; the same seed gives the same one.

    Parameters
    ----------
    wanted
        Kind of laboratory.
    seed
        Of the rig.
    experiment
        As it is meant to be; None: that of `nominal`.

    Raises
    ------
    GeometryError
        If the image is smaller than 16 rows or columns.
    PlanError
        If this camera does not have that defect.
    """
    timed = Tolerances(trigger_delay_s=0.0, bolometer_delay_s=0.0, time_constant_s=0.0, row_delay_s=0.0)
    rig = rigs.draw(experiment or nominal(wanted, seed=seed), seed=seed, tolerances=timed)
    defects = draw_defects(rig.scene, seed=seed, always=wanted.only is not None)
    if wanted.lens == "pincushion" and defects.distortion is not None:
        defects = replace(defects, distortion=-defects.distortion)
    if wanted.only is None or wanted.only == "shutter":
        rig = replace(rig, scene=with_self_correction(rig.scene, seed=seed, always=wanted.only is not None))
    if wanted.only is not None:
        defects = alone(defects, wanted.only)
    return known(replace(rig, scene=with_defects(rig.scene, defects)), seed=seed)


def alone(defects: Defects, group: Group) -> Defects:
    """Those defects of a laboratory that belong to one group; references taken anew, and two frames averaged, where asked for.

    Parameters
    ----------
    defects
        Of a whole laboratory.
    group
        The one that stays.
    """
    kept = {
        field.name: getattr(defects, field.name) for field in fields(Defects) if field.name in _FIELDS.get(group, ())
    }
    if group == "references":
        kept["references_anew"] = True
    if group == "averaging":
        kept["averaged_frames"] = 2
    return Defects(**kept)


def recordings(rig: SimulatedRig, wanted: Wanted, *, seed: int) -> Iterator[Recording]:
    """One run at each wheel rate, made as they are asked for.

    Parameters
    ----------
    rig, wanted, seed
        As for `draw`.
    """
    for index, rate_hz in enumerate(wanted.wheel_hz):
        scene = with_wheel_speed(rig.scene, rate_hz, samples=wanted.frames)
        yield rigs.simulate(scene, seed=seed + 1_000_003 * (index + 1), name=f"{wanted.camera}-{rate_hz:g}Hz")


def nominal(wanted: Wanted, *, seed: int) -> Scene:
    """Another camera before the paper's experiment, without imperfections.

    Parameters
    ----------
    wanted, seed
        As for `draw`.

    Raises
    ------
    GeometryError
        If the image is smaller than 16 rows or columns.
    """
    random = generator(seed, "laboratory", index=2)
    scene = camera_scene(wanted.camera, wanted.readout, rows=wanted.rows, columns=wanted.columns)
    scene = with_wheel_speed(scene, wanted.wheel_hz[0], samples=wanted.frames)
    optics = replace(
        scene.optics,
        pixel_pitch_m=scene.optics.pixel_pitch_m * random.uniform(1.08, 1.2),
        roll_rad=random.uniform(-0.05, 0.05),
        wheel_centre_row_px=scene.optics.wheel_centre_row_px + random.uniform(-2, 2),
        wheel_centre_column_px=scene.optics.wheel_centre_column_px + random.uniform(-6, 6),
    )
    mirrored = random.random() < 0.25
    return replace(
        scene,
        optics=optics,
        wheel=replace(scene.wheel, rotation="counterclockwise" if mirrored else "clockwise"),
        timing=_timing(scene.timing, wanted, random),
        detector=replace(scene.detector, dead_pixels=5),
    )


def _timing(usual: Timing, wanted: Wanted, random: np.random.Generator) -> Timing:
    """Timing of another camera of the same kind."""
    row_delay_s = usual.row_delay_s
    if row_delay_s is not None:
        row_delay_s = float(random.uniform(*_ROW_S) * random.choice([-1, 1]))
    before_s = max(0.0, -(row_delay_s or 0.0) * wanted.rows)
    delay_s = before_s + random.uniform(0.1, 1) * _DELAY_S[wanted.camera]
    if isinstance(usual, BolometerTiming):
        lag_s = random.uniform(*_LAG_S)
        return replace(usual, trigger_delay_s=delay_s, time_constant_s=lag_s, row_delay_s=row_delay_s)
    window_s = float(np.exp(random.uniform(*np.log(_WINDOW_S))))
    timed: CameraTiming = replace(
        usual, trigger_delay_s=delay_s, integration_time_s=window_s, row_delay_s=row_delay_s, substeps=64
    )
    return timed

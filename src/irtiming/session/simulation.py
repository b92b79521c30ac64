"""Recordings of a simulated camera on a simulated rig, with the truth beside them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, final, get_args

from irtiming.archive import writer
from irtiming.archive.json_file import json_text, make_folder, write_atomically
from irtiming.archive.rig_writer import rig_text
from irtiming.errors import PlanError, listed
from irtiming.measurement import Progress
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.frame_events import FreeEvent
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode, Recording
from irtiming.records.rig import Rotation
from irtiming.records.words import require_word
from irtiming.twin.cameras import camera_scene
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.free_camera import draw_free
from irtiming.twin.laboratory import in_laboratory
from irtiming.twin.readout import refuse_slow_readout
from irtiming.twin.rig import SimulatedRig, draw, series, truth
from irtiming.twin.scene import CameraTiming, RadiativeExchange, Scene, Timing, with_wheel_speed
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent
from irtiming.units import readable_time

_STEEPEST_DRIFT = 1000.0  # DN per second
_LONGEST_DELAY_S = 60.0
_FURTHEST_M = 10e-3
_TIMES_S = {
    "trigger_delay_s": 0.0,
    "integration_time_s": 1e-6,
    "time_constant_s": 1e-6,
    "scene_time_constant_s": 1e-6,
    "row_delay_s": -1.0,
    "internal_delay_s": 0.0,
}
"""The shortest that each time may be; the longest is a second."""

_BLURS = ("blur_rows_px", "blur_columns_px")  # that of the order where they are not stated
_SLOWEST_HZ, _FASTEST_HZ = 1e-2, 1e5
_LAG_ONLY = (
    "time_constant_s", "scene_time_constant_s", "substrate_temperature_k", "blackbody_temperature_k",
)  # fmt: skip
_FOREIGN = {"photon": _LAG_ONLY, "microbolometer": ("integration_time_s", "reference_frames")}
_OTHER: dict[CameraType, CameraType] = {"photon": "microbolometer", "microbolometer": "photon"}


@final
@dataclass(frozen=True, kw_only=True)
class CameraOrder:
    """What a person wants of the camera; what is None, or empty, is as usual or drawn."""

    camera: CameraType = "photon"
    readout: ReadoutMode | None = None
    rows: int | None = None
    columns: int = 640
    trigger_delay_s: float | None = None
    integration_time_s: float | None = None
    reference_frames: int | None = None
    time_constant_s: float | None = None
    scene_time_constant_s: float | None = None
    substrate_temperature_k: float | None = None
    blackbody_temperature_k: tuple[float, ...] = ()
    row_delay_s: float | None = None
    nuc_at_s: tuple[float, ...] = ()
    drift_dn_per_s: float | None = None
    serial_number: str = ""
    internal_delay_s: float | None = None

    def __post_init__(self) -> None:
        require_word("camera", self.camera, known=get_args(CameraType), error=PlanError)
        require_word("readout", self.readout, known=get_args(ReadoutMode), error=PlanError, may_be_none=True)
        other = _OTHER[self.camera]
        self._refuse(_FOREIGN[self.camera], f"{{camera}} {self.camera}", cure=f"{{camera}} {other}")
        if (self.readout or USUAL_READOUT[self.camera]) == "snapshot":
            self._refuse(("row_delay_s",), f"{{camera}} {self.camera} {{readout}} snapshot", cure="{readout} rolling")
        for name, shortest_s in _TIMES_S.items():
            self._check_time(name, shortest_s)
        if not abs(drift := self.drift_dn_per_s or 0.0) <= _STEEPEST_DRIFT:
            raise PlanError(f"a drift of {drift} DN per second was asked for; it must lie within +-{_STEEPEST_DRIFT:g}")
        if self.substrate_temperature_k is not None and self.scene_time_constant_s is None:
            raise PlanError(
                "{substrate_temperature_k} is of use with {scene_time_constant_s} only; give that too, or leave it out",
                "substrate_temperature_k",
                "scene_time_constant_s",
            )

    def _refuse(self, foreign: tuple[str, ...], camera: str, *, cure: str) -> None:
        """Refuse what this camera has no use for."""
        given = [name for name in foreign if getattr(self, name) not in (None, ())]
        if given:
            raise PlanError(
                f"{listed(given)} with {camera}, which has no such thing; leave out {listed(given[:1])}, or take {cure}",
                *given,
                "camera",
                "readout",
            )

    def _check_time(self, name: str, shortest_s: float) -> None:
        time_s = getattr(self, name)
        if time_s is not None and not shortest_s <= time_s <= 1:
            words = name.removesuffix("_s").replace("_", " ")
            raise PlanError(
                f"{'an' if words[0] in 'aeiou' else 'a'} {words} of '{readable_time(time_s)}' was asked for; it must lie "
                f"between {readable_time(shortest_s)} and 1 s"
            )


@final
@dataclass(frozen=True, kw_only=True)
class SimulationOrder:
    """What a person wants simulated: a rig whose imperfections the ``seed`` draws, and runs at all speeds with all delays.

    ``asked`` are the names of what a ``laboratory`` does not draw although it has its usual value here: fields of `Defects`,
    ``blur_px`` and ``distortion``. ``force`` replaces recordings of those names, and the rig that the folder tells of.
    """

    folder: Path
    camera: CameraOrder
    delay_s: tuple[float, ...] = (0.0,)
    wheel_hz: tuple[float, ...] = (3.0,)
    frame_hz: float = 30.303
    frames: int = 1000
    runs: int = 1
    seed: int = 1
    blur_px: float = 0.7
    rotation: Rotation = "clockwise"
    distortion: float = 0.0
    mask_offset_m: float | None = None
    roll_rad: float = 0.0
    lost_frames: int = 0
    defects: Defects = field(default_factory=Defects)
    laboratory: bool = False
    asked: frozenset[str] = frozenset()
    free_running: FreeEvent | None = None
    force: bool = False

    def __post_init__(self) -> None:
        require_word("rotation", self.rotation, known=get_args(Rotation), error=PlanError)
        require_word("free_running", self.free_running, known=get_args(FreeEvent), error=PlanError, may_be_none=True)
        for delay_s in self.delay_s:
            if not abs(delay_s) <= _LONGEST_DELAY_S:
                raise PlanError(
                    f"a delay of '{readable_time(delay_s)}' was asked for; it must lie within +-{_LONGEST_DELAY_S:g} s"
                )
        for name, hertz in (*(("wheel rate", rate) for rate in self.wheel_hz), ("frame rate", self.frame_hz)):
            if not _SLOWEST_HZ <= hertz <= _FASTEST_HZ:
                raise PlanError(
                    f"a {name} of {hertz:g} Hz was asked for; it must lie between {_SLOWEST_HZ:g} Hz and {_FASTEST_HZ:g} Hz"
                )
        if not abs(aside := self.mask_offset_m or 0.0) <= _FURTHEST_M:
            raise PlanError(
                f"a mask offset of {1e3 * aside:g} mm was asked for; it must lie within +-{1e3 * _FURTHEST_M:g} mm: the mask "
                "itself is no larger"
            )
        if self.free_running is not None and any(self.delay_s):
            raise PlanError(
                "{delay_s} is set with {free_running}; a camera that runs free has no trigger to delay, leave out {delay_s}",
                "delay_s",
                "free_running",
            )
        if self.lost_frames >= self.frames:
            raise PlanError(
                f"{self.lost_frames} lost frames of {self.frames} were asked for; at least one must be left"
            )

    @property
    def all_frames(self) -> int:
        """Frames in all recordings."""
        speeds, blackbodies = len(self.wheel_hz), max(1, len(self.camera.blackbody_temperature_k))
        return (self.frames - self.lost_frames) * self.runs * len(self.delay_s) * speeds * blackbodies


@final
@dataclass(frozen=True, kw_only=True)
class Simulated:
    """Files that were made."""

    recordings: tuple[Path, ...]
    rig: Path
    truth: Path


def simulate(order: SimulationOrder, *, progress: Progress | None = None) -> Simulated:
    """Simulate a measurement, and write its recordings, rig.toml and truth.json.

    Raises
    ------
    IrTimingError
        If this camera or rig cannot be, or a file cannot be written.
    """
    rig = _drawn(order)
    if order.free_running is not None:
        rig = replace(rig, scene=replace(rig.scene, free=draw_free(order.free_running, seed=order.seed)))
    scenes = _scenes(rig.scene, order)
    for scene in scenes:
        _refuse_impossible(scene)
    make_folder(order.folder)
    known = truth(rig.scene)
    measured, true = order.folder / "rig.toml", order.folder / "truth.json"
    texts = {measured: rig_text(rig.measured), true: json_text(known)}
    if not order.force:
        for path, text in texts.items():
            _refuse_another_rig(path, text)
    for path, text in texts.items():
        write_atomically(text, path)
    recordings = list[Path]()
    for recording in _recordings(scenes, order):
        path = order.folder / f"{recording.name}.nxs"
        writer.write(
            recording, path, truth=known, overwrite=order.force, progress=_share(order, len(recordings), progress)
        )
        recordings.append(path)
    return Simulated(recordings=tuple(recordings), rig=measured, truth=true)


def _refuse_another_rig(path: Path, text: str) -> None:
    """Nothing, if a file is not there or says the same: recordings in its folder may be of the rig that it tells of."""
    if path.exists() and path.read_bytes() != text.encode():
        raise PlanError(
            f"{path}: exists already, and tells of another simulated rig, of which recordings may be there; choose another "
            "folder, or have it replaced with {force}",
            "force",
        )


def _drawn(order: SimulationOrder) -> SimulatedRig:
    """A rig with imperfections, but for what was asked for; rig.toml tells defects where a whole laboratory was."""
    rig = draw(_nominal(order), seed=order.seed)
    timing = _stated(rig.scene.timing, order.camera)
    internal_s = order.camera.internal_delay_s or 0.0
    scene = replace(rig.scene, timing=replace(timing, trigger_delay_s=timing.trigger_delay_s + internal_s))
    if order.mask_offset_m is not None:
        scene = replace(scene, mask=replace(scene.mask, centre_x_m=order.mask_offset_m, centre_y_m=0.0))
    if order.laboratory:
        scene = with_wheel_speed(scene, order.wheel_hz[0], frame_hz=order.frame_hz, samples=order.frames)
        return in_laboratory(replace(rig, scene=scene), seed=order.seed, asked=_asked(order))
    return replace(rig, scene=with_defects(scene, order.defects))


def _asked(order: SimulationOrder) -> dict[str, Any]:
    """Defects that a laboratory does not draw: those with another value than none, and those that were asked for anyhow."""
    names = {*order.asked, *(_BLURS if "blur_px" in order.asked else ())}
    said = {field.name: getattr(order.defects, field.name) for field in fields(Defects)}
    return {name: value for name, value in said.items() if name in names or value != getattr(Defects(), name)}


def _nominal(order: SimulationOrder) -> Scene:
    """Scene of the paper for this kind of camera, with what was asked for that is never drawn."""
    asked = order.camera
    scene = camera_scene(asked.camera, asked.readout, rows=asked.rows, columns=asked.columns)
    frames = scene.radiance.reference_frames if asked.reference_frames is None else asked.reference_frames
    events = tuple(ShutterEvent(start_s=start_s) for start_s in sorted(asked.nuc_at_s))
    return replace(
        scene,
        wheel=replace(scene.wheel, rotation=order.rotation),
        optics=replace(scene.optics, blur_px=order.blur_px, distortion=order.distortion, roll_rad=order.roll_rad),
        faults=replace(scene.faults, lost_frames=order.lost_frames),
        radiance=replace(scene.radiance, reference_frames=frames),
        correction=SelfCorrection(events=events),
        drift=Drift(per_second_dn=asked.drift_dn_per_s or 0.0),
    )


def _stated(drawn: Timing, asked: CameraOrder) -> Timing:
    """The camera's timing, with what was asked for in place of what was drawn."""
    own = "integration_time_s" if isinstance(drawn, CameraTiming) else "time_constant_s"
    names = ("trigger_delay_s", "row_delay_s", own)
    said = {name: getattr(asked, name) for name in names if getattr(asked, name) is not None}
    if isinstance(drawn, CameraTiming):
        return replace(drawn, **{"integration_time_s": 250e-6, **said})
    if asked.scene_time_constant_s is None:
        return replace(drawn, **said)
    substrate_k = 303.15 if asked.substrate_temperature_k is None else asked.substrate_temperature_k
    exchange = RadiativeExchange(scene_time_constant_s=asked.scene_time_constant_s, substrate_k=substrate_k)
    return replace(drawn, radiative=exchange, **said)


def _scenes(scene: Scene, order: SimulationOrder) -> list[Scene]:
    """The same rig at each wheel rate, before each blackbody."""
    return [
        replace(
            with_wheel_speed(scene, rate_hz, frame_hz=order.frame_hz, samples=order.frames),
            radiance=replace(scene.radiance, blackbody_k=blackbody_k),
        )
        for rate_hz in order.wheel_hz
        for blackbody_k in order.camera.blackbody_temperature_k or [scene.radiance.blackbody_k]
    ]


def _refuse_impossible(scene: Scene) -> None:
    """Refuse rows that take longer than a frame, and a correction outside the run."""
    refuse_slow_readout(scene)
    trigger = scene.trigger
    run_s = trigger.n_triggers * trigger.camera_period_ticks / trigger.clock_frequency_hz
    for event in scene.correction.events:
        if not -event.duration_s < event.start_s < run_s:
            raise PlanError(
                f"{{nuc_at_s}} {readable_time(event.start_s)} lies outside the run of {readable_time(run_s)}; "
                "give a time within it, or more {frames}",
                "nuc_at_s",
                "frames",
            )


def _share(order: SimulationOrder, n_before: int, progress: Progress | None) -> Callable[[int, int], None] | None:
    """Progress of one file as a part of all files."""
    if progress is None:
        return None
    before = n_before * (order.frames - order.lost_frames)
    return lambda done, _: progress(str(order.folder), before + done, order.all_frames)


def _recordings(scenes: list[Scene], order: SimulationOrder) -> Iterator[Recording]:
    """Every run, speed by speed; with what was asked for of the camera's name and settings."""
    settings = CameraSettings(internal_delay_set_s=order.camera.internal_delay_s)
    for index, scene in enumerate(scenes):
        for run in series(scene, order.delay_s, repeats=order.runs, seed=order.seed + 1_000_003 * index):
            blackbody = f"-{scene.radiance.blackbody_k:g}K" if len(order.camera.blackbody_temperature_k) > 1 else ""
            camera = run.camera
            if camera is not None and order.camera.serial_number:
                camera = replace(camera, serial_number=order.camera.serial_number)
            yield replace(run, name=f"{run.name}{blackbody}", camera=camera, settings=settings)

"""The scene at one instant of each frame, from a recording or any file of frames into a new file."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from irtiming.apply import conditions, kernels
from irtiming.apply.camera_timing import CameraTiming, MomentName
from irtiming.apply.frame_times import FrameTimes
from irtiming.apply.frames import Readout, Scene, SceneStream
from irtiming.apply.inverse_lag import LagOfValue, of_two_constants
from irtiming.apply.noise import noise_of
from irtiming.archive import layout
from irtiming.archive.frames.opening import files_read
from irtiming.archive.json_file import require_place
from irtiming.archive.nexus import program_version
from irtiming.archive.result_file import read_result
from irtiming.archive.scene_file import SceneHead, SceneWriter
from irtiming.errors import ArchiveError, EstimationError, about
from irtiming.records.arrays import Array
from irtiming.session import given_frames
from irtiming.session.apply_time import camera_at_setting, generator_of
from irtiming.session.given_frames import GivenFrames
from irtiming.units import readable_time

_NOISE_FRAMES = 16
_COUNTS = np.dtype(np.uint16)  # of whole pixels; what has a sign or more bits would be cut off
_COLDEST_K, _HOTTEST_K, _STEPS = 220.0, 620.0, 801


@final
@dataclass(frozen=True, kw_only=True)
class FramesOrder:
    """What a person wants: a result, the frames it is applied to, and the file to write.

    ``noise`` is the standard deviation of a pixel in the units of the frames, None: from the frames. For a file that does not
    tell when its frames were, ``stamps`` is a CSV of their trigger times, or ``period_s`` the time between them. ``instant_row``
    is the row to whose moment all others are brought; None: the middle one. ``keeps_fractions`` writes float32, not counts;
    so is what came neither as uint8 nor as uint16.
    ``series`` are results at other settings.
    """

    result: Path
    source: Path
    out: Path
    noise: float | None = None
    stamps: Path | None = None
    period_s: float | None = None
    instant_row: float | None = None
    keeps_fractions: bool = False
    kelvin_at_zero: float | None = None
    kelvin_per_count: float | None = None
    series: tuple[Path, ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class FramesDone:
    """What became of the frames: how many there were and are now, the noise counted on, mean gain and noise gain, and words."""

    n_frames: int
    n_written: int
    noise: float
    mean_gain: float
    mean_noise_gain: float
    description: tuple[str, ...]


def apply_frames(order: FramesOrder, *, progress: Callable[[int, int], None] | None = None) -> FramesDone:
    """Bring the rows of each frame to one instant and undo lag and filter, streamed: memory does not grow with the file.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, the frames tell no times, or the result does not hold for them.
    """
    taken = [order.result, *([order.stamps] if order.stamps else []), *order.series]
    require_place(order.out, besides=[*taken, *files_read(order.source)], is_text=False, is_new=True)
    if order.out.suffix.lower() != layout.SUFFIX:
        raise ArchiveError(
            f"the scene is written as {layout.SUFFIX}; give it a name that ends so", where=str(order.out)
        )
    result = read_result(order.result)
    with about(order.result):
        camera, remarks = camera_at_setting(result, order.series, source=order.source)
    given = given_frames.read(
        order.source, camera, stamps=order.stamps, period_s=order.period_s, generator=generator_of(result)
    )
    remarks += conditions.doubted_unit(camera.conditions, given.events.frame_period_s)
    given = replace(given, events=replace(given.events, remarks=(*remarks, *given.events.remarks)))
    of_value = _lag_of_value(order, camera, given.unit)
    readout = Readout(
        response=replace(camera.response, of_value=of_value),
        row_delay_s=camera.row_delay_s,
        instant_row=order.instant_row,
    )
    first = given.stack.pick(list(range(min(_NOISE_FRAMES, given.stack.shape[0]))))
    noise = noise_of(first) if order.noise is None else order.noise
    interval_s = given.events.frame_period_s
    if interval_s is None:
        raise EstimationError(f"{order.source}: has one frame; the scene between frames needs two or more")
    size = given.stack.shape[1:]
    stream = SceneStream(readout, size=size, interval_s=interval_s, noise=noise)
    times_s, u_s = _instants(camera, given, readout)
    is_counts = first.dtype.kind == "u" and first.dtype.itemsize <= _COUNTS.itemsize
    is_whole = is_counts and not order.keeps_fractions
    head = SceneHead(
        size=size, dtype=_COUNTS.str if is_whole else "f4", unit=given.unit, tile_px=kernels.TILE, time_errors_s=u_s,
        tiles=(-(-size[0] // kernels.TILE), -(-size[1] // kernels.TILE)),
        description=tuple(_described(order, camera, given, readout=readout, noise=noise)),
    )  # fmt: skip
    highest = np.iinfo(first.dtype).max if is_whole else None
    scenes = _scenes(given, stream, times_s=times_s, progress=progress)
    gains = _write(scenes, order.out, head=head, highest=highest, origin_s=given.events.origin_s)
    return FramesDone(
        n_frames=given.stack.shape[0], n_written=len(gains), noise=noise, mean_gain=float(gains[:, 0].mean()),
        mean_noise_gain=float(gains[:, 1].mean()), description=head.description,
    )  # fmt: skip


def _lag_of_value(order: FramesOrder, camera: CameraTiming, unit: str) -> LagOfValue | None:
    """The lag over values, where the result has two constants and it is known what temperature a value stands for."""
    if camera.two_constants is None or camera.substrate_temperature_k is None:
        return None
    zero_k, per_count = order.kelvin_at_zero, order.kelvin_per_count
    if unit == "K":
        zero_k, per_count = 0.0, 1.0
    if zero_k is None or per_count is None:
        return None
    if not per_count > 0:
        raise EstimationError(f"a count stands for {per_count} K, must be more than 0: check --kelvin-per-count")
    kelvin = np.linspace(_COLDEST_K, _HOTTEST_K, _STEPS)
    return of_two_constants(
        camera.two_constants,
        substrate_temperature_k=camera.substrate_temperature_k,
        lowest=(_COLDEST_K - zero_k) / per_count,
        highest=(_HOTTEST_K - zero_k) / per_count,
        scene_temperature_k=kelvin,
    )


def _instants(camera: CameraTiming, given: GivenFrames, readout: Readout) -> tuple[Array, float]:
    """The instant of each frame, shape (n_frame,), and the standard uncertainty of them all; s."""
    row = np.array([readout.instant(given.stack.shape[1])])
    name: MomentName = "reading" if camera.has_lag else "middle"
    moments = camera.moments(given.events.frame_period_s)
    times = FrameTimes(camera=camera, events=given.events, moments=moments, rows_px=row)
    return times.time_s(name)[:, 0], float(times.u_s(name)[0])


def _write(
    scenes: Iterator[Scene], path: Path, *, head: SceneHead, highest: int | None, origin_s: int
) -> NDArray[np.float64]:
    """Write all scenes; gives mean gain and mean noise gain of each, shape (n_scene, 2)."""
    counts, gains = np.zeros(head.size, _COUNTS), []
    with SceneWriter(path, head) as writer:
        for one in scenes:
            pixels: NDArray[Any] = one.pixels
            if highest is not None:
                kernels.to_counts(one.pixels, highest, counts)
                pixels = counts
            writer.append(
                pixels, number=one.index, time_s=origin_s + one.time_s, gain=one.gain, noise_gain=one.noise_gain
            )
            gains.append((float(one.gain.mean()), float(one.noise_gain.mean())))
        if not gains:
            raise EstimationError("no frame lies between others without a gap; nothing was written", where=str(path))
    return np.array(gains)


def _scenes(
    given: GivenFrames,
    stream: SceneStream,
    *,
    times_s: NDArray[np.float64],
    progress: Callable[[int, int], None] | None,
) -> Iterator[Scene]:
    """Scenes of all frames that have an event, each by the number of its frame."""
    place = {int(index): k for k, index in enumerate(given.kept)}
    total = given.stack.shape[0]
    for first, block in given.stack.blocks():
        for k, frame in enumerate(block):
            at = place.get(first + k)
            if at is not None:
                yield from stream.push(frame, index=int(given.numbers[at]), time_s=float(times_s[at]))
        if progress is not None:
            progress(first + len(block), total)
    yield from stream.end()


def _described(
    order: FramesOrder, camera: CameraTiming, given: GivenFrames, *, readout: Readout, noise: float
) -> Iterator[str]:
    response = readout.response
    yield f"{program_version()}: the scene at one instant of each frame of {order.source.name} by {order.result.name}"
    yield f"time: {given.events.scale}; " + (
        "when the instant row was read" if camera.has_lag else "middle of the integration of the instant row"
    )
    if readout.row_delay_s:
        row = readout.instant(given.stack.shape[1])
        yield (
            f"rows: brought to row {row:g} by cubics in time over four readings; row delay {readable_time(readout.row_delay_s)}"
        )
    if response.of_value is not None:
        yield "lag: time constants of substrate and scene undone frame to frame, by the temperature that each value stands for"
    elif response.time_constant_s:
        yield (
            f"lag: time constant {readable_time(response.time_constant_s)} undone frame to frame, exactly for a scene that is "
            "straight between frames"
        )
    if response.recursive_filter:
        yield f"filter in the camera: share {response.recursive_filter:.5f} of the frame before undone"
    if response.pixel_memory:
        yield f"memory of the pixels: share {response.pixel_memory:.5f} of the frame before undone"
    if response.is_none:
        yield "pixels: nothing to undo"
    else:
        yield (
            f"gain: Wiener gain of each tile of {kernels.TILE} x {kernels.TILE} pixels, for noise of {noise:.4g} "
            f"{given.unit}; noise_gain: noise of a pixel over that of the frame as it came"
        )
    if camera.two_constants is not None and response.of_value is None:
        yield "note: the result has two time constants; counts do not give temperatures, so the one at the wheel's was undone"
    for remark in given.events.remarks:
        yield f"note: {remark}"

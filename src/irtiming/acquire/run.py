"""One recording: camera armed, then triggers; frames and timestamps into one file; every frame given its trigger.

Nothing that is captured is lost, whatever ends the run, and a recording whose frames cannot be given their triggers beyond doubt
says so and is not analysed.
"""

import asyncio
from collections.abc import Awaitable, Iterator
from contextlib import suppress
from dataclasses import replace
from time import monotonic, thread_time
from typing import cast, final

import numpy as np

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.counter import Counter
from irtiming.acquire.frame_writer import FrameWriter
from irtiming.acquire.free_count import FreeCount
from irtiming.acquire.pairing import Pairing, Verdict
from irtiming.acquire.rig import Rig
from irtiming.acquire.run_order import ENOUGH, INTERRUPTED, RunOrder, RunOutcome
from irtiming.acquire.set_aside import set_aside
from irtiming.acquire.temperature import TemperatureWatch
from irtiming.acquire.trigger_train import Accompaniment, FreeAccompaniment, listen, trigger, wheel_at_speed
from irtiming.acquire.wheel_watch import WheelWatch
from irtiming.archive.layout import NOT_TRUSTED
from irtiming.archive.live.head import RecordingHead
from irtiming.archive.live.recording import COMPLETE, TickStream
from irtiming.errors import InstrumentError
from irtiming.records.camera_frame import CameraFrame, CameraSetup, StreamCounts
from irtiming.records.finding import Finding
from irtiming.records.recording import USUAL_READOUT
from irtiming.records.timestamps import Timestamps
from irtiming.units import counted, readable_time

_QUIET_S, _QUIET_PERIODS = 0.3, 4
"""So long the armed camera must be silent before the first trigger, whichever is longer."""

_SILENT_S, _SILENT_PERIODS, _SILENT_HOST_S = 2.0, 20, 1.0
"""So long no frame may come while triggers are made; the last of this computer's time, as it may be busy."""

_LAST_S, _LAST_PERIODS = 1.0, 4
"""So long after the last frame, and after the last trigger, more are waited for."""

_TICKS_S, _TICKS_SHARE = 0.1, 20
"""How often timestamps are fetched, at most for one part in so many of the time."""

_UNSURE_TICKS = 0.02
"""The youngest timestamps, s: the record after them may still say that they are wrong."""

_PACE_TOLERANCE = 0.01
_STREAMS: dict[TickStream, str] = {
    "camera_trigger": "camera_trigger_ticks",
    "camera_trigger_delayed": "camera_trigger_delayed_ticks",
    "control_slot": "control_slot_ticks",
    "application_slot": "application_slot_ticks",
    "application_edges": "application_edge_ticks",
    "camera_input": "camera_input_ticks",
    "spare": "spare_ticks",
}


async def record_run(rig: Rig, order: RunOrder, *, attendant: Attendant) -> RunOutcome:
    """Record one run: reference loaded, wheel at speed, camera armed, triggers, frames and timestamps into a file.

    Parameters
    ----------
    rig
        Connected, camera set.
    order
        What and where to.
    attendant
        Hears what happens, and may end it; the file is then closed with what it has.

    Returns
    -------
    What became of it, also where it ended early.

    Raises
    ------
    InstrumentError
        If it could not begin: no file was made then.
    ArchiveError
        If no file could be made, or none came of it.
    """
    await rig.generator.load(order.run, clock_frequency_hz=rig.generator.clock_frequency_hz)
    await _let_the_wheel_turn(rig)
    attendant.says("waiting for the wheel to come to its speed")
    await wheel_at_speed(rig.generator, order.run, poll_s=rig.poll_s, is_over=attendant.is_leaving)
    if attendant.is_leaving():
        raise InstrumentError(INTERRUPTED)
    if order.camera.runs_free:
        setup = await rig.camera.arm(free_hz=_frame_hz(rig, order))
        await rig.camera.disarm()  # it only sent its settings: it starts when its strobe is listened to
    else:
        setup = await rig.camera.arm()
    capture = _Capture(rig, order, setup=setup, attendant=attendant)
    try:
        return await capture.record()
    finally:
        with suppress(InstrumentError):
            await rig.camera.disarm()


def _frame_hz(rig: Rig, order: RunOrder) -> float:
    return rig.generator.clock_frequency_hz / order.run.scheme.camera_period_ticks


async def _let_the_wheel_turn(rig: Rig) -> None:
    """Start a wheel that stands; one that turns already follows the reference that was loaded."""
    if rig.chopper is not None and not (await rig.chopper.state()).is_enabled:
        await rig.chopper.prepare()
        await rig.chopper.start()


@final
class _Capture:
    """One run from the armed camera to the closed file."""

    def __init__(self, rig: Rig, order: RunOrder, *, setup: CameraSetup, attendant: Attendant) -> None:
        scheme, clock = order.run.scheme, rig.generator.clock_frequency_hz
        self._rig, self._order, self._attendant = rig, order, attendant
        self._setup = replace(setup, bit_depth=order.camera.bit_depth or setup.bit_depth)
        self._period_s = scheme.camera_period_ticks / clock
        self._n_triggers = scheme.samples_per_turn * order.run.repeats
        self._runs_free = order.camera.runs_free
        self._pairing = Pairing(
            period_s=self._period_s, n_triggers=self._n_triggers, device_frequency_hz=setup.timestamp_frequency_hz
        )
        self._free = FreeCount(event=order.camera.frame_event, period_s=self._period_s, n_frames=self._n_triggers)
        self._is_started, self._strobes_before = asyncio.Event(), 0
        self._counter = Counter(rig.generator, speed=rig.speed)
        self._wheel = WheelWatch(scheme)
        self._temperature: TemperatureWatch | None = None
        self._writer: FrameWriter | None = None
        self._armed_s = self._last_s = monotonic()
        self._early = self._overflowed = self._frames = 0
        self._in_file: dict[TickStream, int] = dict.fromkeys(_STREAMS, 0)
        self._ending: str | None = None

    async def record(self) -> RunOutcome:
        """The whole of it."""
        frames = asyncio.create_task(self._take_frames())
        beside = [asyncio.create_task(self._follow_timestamps())]
        if self._order.blackbody_before is not None:
            self._temperature = TemperatureWatch(
                self._rig, self._order.blackbody_before, tolerance_k=self._order.tolerance_k
            )
            beside.append(asyncio.create_task(self._temperature.watch()))
        try:
            timestamps = await self._until_it_fails(self._listen() if self._runs_free else self._trigger())
            await self._last_frames(timestamps)
            await self._last_look(timestamps, beside)
            counts = await self._disarm(frames)
        except BaseException as error:
            if self._writer is not None:
                why = f"{NOT_TRUSTED}broken off before its frames had their triggers: {str(error) or type(error).__name__}"
                path = await self._writer.abandon(why)
                if path is not None:
                    set_aside(path, attendant=self._attendant)
            raise
        finally:
            for task in (*beside, frames):
                task.cancel()
            await asyncio.gather(*beside, frames, return_exceptions=True)
        return await self._finished(timestamps, counts)

    async def _until_it_fails(self, timestamps: Awaitable[Timestamps]) -> Timestamps:
        """Of the whole run; where the generator fails, what it had sent until then."""
        try:
            return await timestamps
        except InstrumentError as error:
            if self._writer is None:
                raise
            self._ends(str(error))
            return self._rig.generator.captured()

    async def _trigger(self) -> Timestamps:
        """The train of triggers."""
        beside = Accompaniment(before_start=self._begin, is_over=self._is_over, progress=self._progress)
        return await trigger(
            self._rig.generator, self._order.run, counter=self._counter, beside=beside, poll_s=self._rig.poll_s
        )

    async def _listen(self) -> Timestamps:
        """A camera that runs free, from before its start to after its stop."""
        beside = FreeAccompaniment(
            start_camera=self._start_camera,
            look=self._look_at_clocks,
            stop_camera=self._stop_camera,
            has_all=lambda: self._free.has_all,
            is_over=self._is_over,
            progress=lambda: self._progress(min(self._free.last_number + 1, self._n_triggers), self._n_triggers),
        )
        return await listen(
            self._rig.generator, self._order.run, counter=self._counter, beside=beside, poll_s=self._rig.poll_s
        )

    async def _start_camera(self) -> None:
        self._strobes_before = int(self._rig.generator.captured().camera_input_ticks.size)
        await self._make_file()
        await self._look_at_clocks()
        await self._rig.camera.arm(free_hz=_frame_hz(self._rig, self._order))
        self._last_s = monotonic()
        self._is_started.set()

    async def _stop_camera(self) -> None:
        """The frames that were made until now still come; the strobe is silent then."""
        try:
            await self._rig.camera.disarm()
        except InstrumentError as error:
            self._ends(str(error))

    async def _look_at_clocks(self) -> None:
        """Counter, and camera where its stamps count, each between two looks at this computer's clock, in the rig's time."""
        if self._writer is None:
            return
        counter = await self._rig.generator.clock_exchange()
        self._writer.put_exchange("counter", counter.at_speed(self._rig.speed))
        if self._order.camera.frame_event == "stamp":
            camera = await self._rig.camera.clock_exchange()
            if camera is not None:
                self._writer.put_exchange("camera", camera.at_speed(self._rig.speed))

    async def _begin(self) -> None:
        """Just before the first trigger: the armed camera must have been silent; then the file is made."""
        quiet_s = self._rig.host_s(max(_QUIET_S, _QUIET_PERIODS * self._period_s))
        await asyncio.sleep(max(0.0, self._armed_s + quiet_s - monotonic()))
        if self._early:
            raise InstrumentError(
                f"{self._rig.camera.name} made {counted(self._early, 'frame')} before the first trigger: it does not wait for "
                f"triggers; check TriggerMode, and TriggerSource (it is {self._setup.trigger_source}), and the "
                "camera's trigger line"
            )
        await self._make_file()

    async def _make_file(self) -> None:
        chopper = None if self._rig.chopper is None else await self._rig.chopper.state()
        camera = self._order.camera
        head = RecordingHead(
            name=self._order.path.stem,
            camera_type=camera.camera_type,
            readout_mode=camera.readout_mode or USUAL_READOUT[camera.camera_type],
            clock_frequency_hz=self._rig.generator.clock_frequency_hz,
            run=self._order.run,
            camera=self._rig.camera.identity,
            setup=self._setup,
            chopper=chopper,
            blackbody=self._order.blackbody_before,
            integration_time_s=camera.integration_time_s,
            nonuniformity=self._order.nonuniformity,
            frame_event=camera.frame_event,
        )
        writer = FrameWriter(self._order.path, head=head, attendant=self._attendant)
        await writer.open()
        self._writer, self._last_s = writer, monotonic()
        self._attendant.begins(self._order.run, number=self._order.number, path=self._order.path)

    async def _take_frames(self) -> None:
        """Give each frame its place and queue it; what the camera says when it fails ends the run."""
        if self._runs_free:
            await self._is_started.wait()
        try:
            async for frame in self._rig.camera.frames():
                self._take(frame)
        except InstrumentError as error:
            self._ends(str(error))

    def _take(self, frame: CameraFrame) -> None:
        self._last_s = monotonic()
        if self._writer is None:
            self._early += 1
            return
        self._frames += 1
        if self._runs_free:
            frame = replace(frame, host_time_s=frame.host_time_s * self._rig.speed)
        place = (self._free if self._runs_free else self._pairing).take(frame)
        if place is None:
            return
        for number, frame_id in zip(place.lost_numbers, place.lost_ids, strict=True):
            self._writer.put_blank(number=number, frame_id=frame_id, host_time_s=frame.host_time_s)
        if not self._writer.put_frame(frame, number=place.number):
            self._overflowed += 1
            self._writer.put_blank(number=place.number, frame_id=frame.frame_id, host_time_s=frame.host_time_s)

    async def _follow_timestamps(self) -> None:
        """Timestamps into the file as they arrive, and the wheel by them."""
        pause_s = shortest_s = _TICKS_S / max(self._rig.speed, 1.0)
        while True:
            await asyncio.sleep(pause_s)
            if self._writer is None:
                continue
            begun = thread_time()
            so_far = self._rig.generator.captured()
            self._store(so_far)
            self._attendant.sees(so_far)
            wrong = self._wheel.complaint(so_far)
            if wrong is not None:
                self._ends(wrong)
            pause_s = max(shortest_s, _TICKS_SHARE * (thread_time() - begun))

    def _store(self, so_far: Timestamps) -> None:
        """Queue the timestamps that are new, the youngest excepted: they may still be taken back."""
        streams = {stream: getattr(so_far, name) for stream, name in _STREAMS.items()}
        youngest = max((int(ticks[-1]) for ticks in streams.values() if ticks.size), default=0)
        sure = youngest - round(_UNSURE_TICKS * so_far.clock_frequency_hz)
        for stream, ticks in streams.items():
            n_sure = int(np.searchsorted(ticks, sure))
            if self._runs_free and stream == "camera_input":
                n_sure = min(n_sure, self._free.last_number + 1)
            if self._writer is not None and n_sure > self._in_file[stream]:
                self._writer.put_ticks(stream, ticks[self._in_file[stream] : n_sure])
                self._in_file[stream] = n_sure

    def _is_over(self) -> bool:
        """Whether anything says that the run must end."""
        writer = self._writer
        if self._attendant.is_leaving():
            self._ends(INTERRUPTED)
        if writer is not None and writer.failure is not None:
            self._ends(str(writer.failure))
        if self._temperature is not None and self._temperature.complaint is not None:
            self._ends(self._temperature.complaint)
        if writer is not None and self._last_number < self._n_triggers - 1:
            silent_s = (monotonic() - self._last_s) * self._rig.speed
            patience_s = max(_SILENT_S, _SILENT_PERIODS * self._period_s, _SILENT_HOST_S * self._rig.speed)
            if silent_s > patience_s + self._delay_s:
                name, silent = self._rig.camera.name, readable_time(float(f"{silent_s:.2g}"))
                if self._runs_free:
                    self._ends(f"{name} sent no frame for {silent} while it ran free; check its cable")
                else:
                    self._ends(
                        f"{name} sent no frame for {silent} while it was triggered; check its cable, its trigger line and "
                        "TriggerSource"
                    )
        return self._ending is not None

    @property
    def _last_number(self) -> int:
        return (self._free if self._runs_free else self._pairing).last_number

    @property
    def _delay_s(self) -> float:
        return self._order.run.trigger_delay_ticks / self._rig.generator.clock_frequency_hz

    def _progress(self, made: int, total: int) -> None:
        waiting = 0 if self._writer is None else self._writer.waiting
        lost = max(0, self._last_number + 1 - self._frames)
        self._attendant.goes_on(made=made, total=total, frames=self._frames, lost=lost, waiting=waiting)
        if self._attendant.is_enough():
            self._ends(ENOUGH)

    def _ends(self, why: str) -> None:
        """The first reason to end is the one that is reported."""
        if self._ending is None:
            self._ending = " ".join(why.split())

    async def _last_frames(self, timestamps: Timestamps) -> None:
        """Wait for frames that are on their way."""
        begun, made = monotonic(), timestamps.camera_trigger_ticks.size
        patience_s = max(_LAST_S, self._rig.host_s(max(_LAST_S, _LAST_PERIODS * self._period_s)))
        while self._pairing.last_number < made - 1 and monotonic() - max(begun, self._last_s) < patience_s:
            await asyncio.sleep(patience_s / 20)

    async def _last_look(self, timestamps: Timestamps, beside: "list[asyncio.Task[None]]") -> None:
        """Wheel and blackbody once more: what was asked for last may have been some time before the last frame."""
        for task in beside:
            task.cancel()
        await asyncio.gather(*beside, return_exceptions=True)
        wrong = self._wheel.complaint(timestamps) if timestamps.is_whole else None
        if wrong is not None:
            self._ends(wrong)
        if self._temperature is not None and self._ending is None:
            await self._temperature.ask_at_the_end()
            if self._temperature.complaint is not None:
                self._ends(self._temperature.complaint)

    async def _disarm(self, frames: "asyncio.Task[None]") -> StreamCounts:
        """End the acquisition, and take what has arrived."""
        try:
            counts = await self._rig.camera.disarm()
        except InstrumentError as error:
            self._ends(str(error))
            return self._rig.camera.counts()
        await asyncio.wait([frames], timeout=self._rig.host_s(_LAST_S) + 1.0)
        return counts

    async def _finished(self, timestamps: Timestamps, counts: StreamCounts) -> RunOutcome:
        writer = cast("FrameWriter", self._writer)
        await writer.put_rest_of(self._free.own(timestamps) if self._runs_free else timestamps)
        if writer.failure is not None:
            self._ends(str(writer.failure))
        verdict = self._verdict(timestamps, writer)
        early = self._ending
        if verdict.reasons:
            why = "; ".join(verdict.reasons)
            ending = NOT_TRUSTED + (why if early is None else f"{why} (it ended early: {early})")
        else:
            ending = early or COMPLETE
        path = await writer.finish(ending)
        outcome = RunOutcome(
            order=self._order,
            path=path,
            ending=ending,
            verdict=verdict,
            counts=counts,
            findings=(*verdict.findings, *self._oddities(writer, counts)),
            overflowed=self._overflowed,
            longest_queue=writer.longest_queue,
            repeated=writer.repeated,
            blackbody_after=None if self._temperature is None else self._temperature.last,
        )
        self._attendant.ended(outcome)
        return outcome

    def _verdict(self, timestamps: Timestamps, writer: FrameWriter) -> Verdict:
        if self._runs_free:
            verdict = self._free.judge(timestamps, before_start=self._strobes_before)
        else:
            verdict = self._pairing.judge(
                timestamps,
                earliest_s=self._counter.earliest_s,
                speed=self._rig.speed,
                usual_latency_s=self._order.usual_latency_s,
            )
        if writer.repeated:
            frozen = (
                f"{counted(writer.repeated, 'frame')} equal to the one before: the camera sent old frames or is shut"
            )
            verdict = replace(verdict, reasons=(*verdict.reasons, frozen), latency_s=None)
        return verdict

    def _oddities(self, writer: FrameWriter, counts: StreamCounts) -> Iterator[Finding]:
        """What a person should know, though the recording stands."""
        if self._overflowed:
            what = f"{counted(self._overflowed, 'frame')} found the queue to the disk full, blank in the file"
            yield Finding(code="disk-too-slow", severity="warning", what=what, cure="use a faster disk")
        if counts.frames_damaged:
            what = f"{counted(counts.frames_damaged, 'frame')} came damaged, {counted(counts.packets_missing, 'packet')} missing"
            yield Finding(code="frames-came-damaged", severity="warning", what=what, cure="check link and MTU")
        if counts.queue_dropped:
            what = f"{counted(counts.queue_dropped, 'frame')} lost because this computer was too slow to take them"
            yield Finding(code="computer-too-slow", severity="warning", what=what)
        pace = self._counter.pace()
        if pace is not None and self._rig.speed == 1 and abs(pace - 1) > _PACE_TOLERANCE:
            what = f"the trigger generator's clock runs {pace - 1:+.1%} against this computer's"
            yield Finding(code="generator-clock-off", severity="warning", what=what, cure="check its clock frequency")

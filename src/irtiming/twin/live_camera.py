"""A camera of the twin that gives frames as it is triggered: each when its last row has been read, in order."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from os import cpu_count
from queue import SimpleQueue
from threading import Event, Lock, Thread
from time import monotonic
from types import TracebackType
from typing import Literal, Self, TypeAlias, final

import numpy as np

from irtiming.records.arrays import Pixels, Ticks
from irtiming.twin.live_view import LiveRun, Make, Moment, SeenWheel, Surroundings
from irtiming.twin.scene import CameraTiming, Scene

_POLL_S = 0.002
_LONGEST_GAP_S = 0.02
_MOST_BEHIND = 24
"""Frames that may be in the making. With more, whoever triggers waits, so that a simulated device's time does too."""

TriggerKind = Literal["line", "software", "none"]
"""Edges at the input, commands, or frames at a rate of the camera's own."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LiveFrame:
    """One frame, (row, column), and when it was taken."""

    moment: Moment
    pixels: Pixels


Deliver: TypeAlias = Callable[[LiveFrame], None]


@final
class LiveCamera:
    """Camera of a scene before a wheel that somebody turns; implements `gateware.model_device.TriggeredCamera`.

    It works while its ``with`` block runs, and only between `begin` and `end`. A trigger that comes while rows of the frame
    before are read is ignored, as cameras do. Run k (from 0) has the noise of ``seed`` + k.

    Parameters
    ----------
    scene
        The rig as it truly is; its triggers and faults do not count.
    wheel
        What the camera sees, and what tells it the time: `irtiming.twin.driven_wheel.DrivenWheel`.
    clock_frequency_hz
        Of the counter whose cycles are reported.
    seed
        Fixes noise and jitter.
    blackbody_k
        Temperature at a cycle, K; without it that of the scene for ever.
    """

    def __init__(
        self,
        scene: Scene,
        wheel: SeenWheel,
        *,
        clock_frequency_hz: int,
        seed: int,
        blackbody_k: Callable[[int], float] | None = None,
    ) -> None:
        self.bare_blackbody = False
        """Whether wheel and mask are taken out of the way; to be set at any time."""
        self.is_paced = False
        """Whether `run_until` says when it makes frames of its own accord, not its own look at the wheel."""
        self._scene, self._wheel, self._seed, self._clock_hz = scene, wheel, seed, clock_frequency_hz
        self._known: tuple[int, float] | None = None
        self._around = Surroundings(
            wheel=wheel,
            clock_frequency_hz=clock_frequency_hz,
            blackbody_k=blackbody_k or (lambda cycle: scene.radiance.blackbody_k),
            is_bare=lambda: self.bare_blackbody,
        )
        self._lock = Lock()
        self._run: _Acquisition | None = None
        self._runs = self._ignored = 0
        self._made: SimpleQueue[tuple[_Acquisition, Moment, Future[Pixels | None]] | None] = SimpleQueue()
        self._is_over = Event()
        self._failure: BaseException | None = None
        self._threads = [Thread(target=work, name=f"camera {work.__name__}") for work in (self._expose, self._deliver)]

    @property
    def scene(self) -> Scene:
        """The rig as it truly is."""
        return self._scene

    @property
    def is_rolling(self) -> bool:
        """Whether it reads row after row."""
        return self._scene.timing.row_delay_s is not None

    @property
    def integration_time_s(self) -> float | None:
        """As the scene has it; None for a microbolometer."""
        timing = self._scene.timing
        return timing.integration_time_s if isinstance(timing, CameraTiming) else None

    @property
    def clock_frequency_hz(self) -> int:
        """Of the counter whose cycles are reported."""
        return self._clock_hz

    @property
    def now_cycle(self) -> int:
        """The present."""
        return self._wheel.turned_until_cycle

    @property
    def triggers_ignored(self) -> int:
        """How many came too early after the one before."""
        return self._ignored

    def __enter__(self) -> Self:
        LiveRun(self._scene, self._around, seed=self._seed)  # traces the rays, which takes seconds
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()
        self._is_over.set()
        self._threads[0].join()
        self._made.put(None)
        self._threads[1].join()
        if self._failure is not None and error is None:
            raise self._failure

    def begin(
        self,
        deliver: Deliver,
        *,
        trigger: TriggerKind,
        frame_rate_hz: float = 30.0,
        integration_time_s: float | None = None,
    ) -> None:
        """Begin a run: from now on triggers make frames.

        Parameters
        ----------
        deliver
            Is given each frame in order, in a thread of the camera's own.
        trigger
            What it listens to.
        frame_rate_hz
            Where it triggers itself.
        integration_time_s
            Of a photon camera, if not that of the scene.
        """
        scene = self._scene
        if integration_time_s is not None and isinstance(scene.timing, CameraTiming):
            scene = replace(scene, timing=replace(scene.timing, integration_time_s=integration_time_s))
        run = LiveRun(scene, self._around, seed=self._seed + self._runs)
        period = self._clock_hz / frame_rate_hz if trigger == "none" else 0.0
        acquisition = _Acquisition(run, deliver, trigger, period=period, next_cycle=float(self.now_cycle))
        with self._lock:
            self._runs += 1
            self._run = acquisition

    def end(self) -> None:
        """End the run; frames that are not yet delivered never are."""
        with self._lock:
            if self._run is not None:
                self._run.is_over = True
            self._run = None

    def trigger(self, cycles: Ticks) -> None:
        """Rising edges of the line, in order.

        Parameters
        ----------
        cycles
            Shape (n,): counter at each edge.
        """
        while self._is_behind() and not self._is_over.wait(_POLL_S):
            pass
        self._hear("line", cycles.tolist())

    def run_until(self, cycle: int) -> Ticks:
        """Frames of its own accord that begin before a cycle; waits while it is behind, so that none is left out.

        Parameters
        ----------
        cycle
            Of the counter, rising from call to call.

        Returns
        -------
        When they begin, shape (n,); none where it waits for triggers, or nothing was begun.
        """
        self._known = cycle, monotonic()
        while self._is_behind() and not self._is_over.wait(_POLL_S):
            pass
        with self._lock:
            run = self._run
            if run is None or run.trigger != "none":
                return np.empty(0, np.int64)
            return np.array(run.begin_until(cycle), dtype=np.int64)

    def cycle_now(self, *, speed: float) -> int:
        """The present also between two calls of `run_until`, by this computer's clock; without them as `now_cycle`.

        Parameters
        ----------
        speed
            Seconds of the rig per second of this computer.
        """
        if self._known is None:
            return self.now_cycle
        cycle, since_s = self._known[0], monotonic() - self._known[1]
        return cycle + round(min(since_s, _LONGEST_GAP_S) * speed * self._clock_hz)

    def trigger_now(self) -> None:
        """What a software trigger does."""
        self._hear("software", [self.now_cycle])

    def _hear(self, kind: TriggerKind, cycles: list[int]) -> None:
        with self._lock:
            if self._run is not None and self._run.trigger == kind:
                self._run.heard.extend(cycles)

    def _is_behind(self) -> bool:
        run = self._run
        return run is not None and run.in_the_making > _MOST_BEHIND

    def _expose(self) -> None:
        with ThreadPoolExecutor(min(cpu_count() or 1, 4), thread_name_prefix="camera frame") as pool:
            while not self._is_over.wait(_POLL_S):
                try:
                    self._expose_what_is_over(pool)
                except BaseException as error:
                    self._failure = error
                    return

    def _expose_what_is_over(self, pool: ThreadPoolExecutor) -> None:
        """Hand over the frames whose last row has been read by now."""
        now = self.now_cycle
        with self._lock:
            run = self._run
            if run is None:
                return
            if run.trigger == "none" and not self.is_paced and not self._is_behind():
                run.trigger_itself(now)
            heard = [run.heard.popleft() for _ in range(len(run.heard))]
        for cycle in heard:
            moment = run.run.moment(cycle)
            if moment is None:
                self._ignored += 1
            else:
                run.exposing.append(moment)
        while run.exposing and run.exposing[0].end_cycle <= now:
            moment = run.exposing.popleft()
            run.exposed += 1
            self._made.put((run, moment, pool.submit(self._pixels, run, run.run.make(moment))))

    def _pixels(self, run: "_Acquisition", make: Make) -> Pixels | None:
        if run.is_over:
            return None
        shape = (self._scene.detector.rows, self._scene.detector.columns)
        out = np.empty(shape, np.uint16)
        make(np.empty(shape, np.float32), out)
        return out

    def _deliver(self) -> None:
        while (made := self._made.get()) is not None:
            run, moment, pixels = made
            try:
                frame = pixels.result()
                if frame is not None and not run.is_over:
                    run.deliver(LiveFrame(moment=moment, pixels=frame))
            except BaseException as error:
                self._failure = error
            run.delivered += 1


@final
class _Acquisition:
    """A run with its triggers: those heard, and those whose frames are being taken."""

    def __init__(
        self, run: LiveRun, deliver: Deliver, trigger: TriggerKind, *, period: float, next_cycle: float
    ) -> None:
        self.run, self.deliver, self.trigger = run, deliver, trigger
        self.is_over = False
        self.heard: deque[int] = deque()
        self.exposed = self.delivered = 0
        self.exposing: deque[Moment] = deque()
        self._period, self._next = period, next_cycle

    @property
    def in_the_making(self) -> int:
        """Frames taken and not yet delivered."""
        return self.exposed - self.delivered

    def begin_until(self, cycle: int) -> list[int]:
        """Frames of its own accord that begin before a cycle, each a period after the one before."""
        begun = []
        while self._next < cycle:
            begun.append(int(self._next))
            self._next += self._period
        self.heard.extend(begun)
        return begun

    def trigger_itself(self, now: int) -> None:
        """Triggers of the camera's own up to now; what it had no time for is left out."""
        self._next = max(self._next, now - _MOST_BEHIND * self._period)
        while self._next <= now:
            self.heard.append(int(self._next))
            self._next += self._period

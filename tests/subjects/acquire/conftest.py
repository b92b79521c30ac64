"""A rig in memory: devices that implement the protocols on one clock, faster than ours, with faults to set."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from time import monotonic

import numpy as np
import pytest

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.journal import Journal, digest_of
from irtiming.acquire.rig import Rig
from irtiming.acquire.series import Series, record_series
from irtiming.errors import InstrumentRefused, InstrumentSilent
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup, StreamCounts
from irtiming.records.clock_exchange import ClockExchange
from irtiming.records.instrument_state import BlackbodyState, ChopperState
from irtiming.records.series_plan import CameraWishes, DeviceAddresses, SeriesPlan
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme

CLOCK_HZ = 48_000_000
SPEED = 2.0
SCHEME = TriggerScheme(turn_period_ticks=480_000, camera_period_ticks=510_000, control_slots=10)
RUN = PlannedRun(scheme=SCHEME, trigger_delay_ticks=120_000, repeats=1, is_after_correction=False)
NEVER = 2**60


class FakeGenerator:
    """Trigger generator with a wheel; ``slow_from`` is when the wheel loses its lock, ``gone_from`` when the generator vanishes.

    Both count from the first trigger. What has vanished triggers no camera and stamps nothing.
    """

    name = "generator"
    clock_frequency_hz = CLOCK_HZ

    def __init__(self) -> None:
        self.born, self.speed = monotonic(), SPEED
        self.run: PlannedRun | None = None
        self.armed = self.started = NEVER
        self.stopped: int | None = None
        self.slow_from, self.gone_from, self.loses_stamps = NEVER, NEVER, False
        self.wheel_factor = 1.0
        self.strobes: Callable[[], list[int]] = list
        self.begun: list[str] = []

    def now(self) -> int:
        return int((monotonic() - self.born) * self.speed * CLOCK_HZ)

    def triggers(self, now: int | None = None) -> np.ndarray:
        """Delayed triggers until now, which a computer that is busy elsewhere meanwhile may have to know."""
        if self.run is None or self.started == NEVER:
            return np.empty(0, np.int64)
        n = self.run.scheme.samples_per_turn * self.run.repeats
        made = self.started + np.arange(n) * self.run.scheme.camera_period_ticks + self.run.trigger_delay_ticks
        until = self.now() if now is None else now
        return made[made <= min(until if self.stopped is None else self.stopped, self.started + self.gone_from)]

    def _check(self) -> None:
        if self.now() - min(self.started, self.now()) >= self.gone_from:
            raise InstrumentSilent("generator has vanished; plug it in again")

    async def load(self, run, *, clock_frequency_hz) -> None:
        self._check()
        self.begun.append("load")
        self.run, self.armed, self.started, self.stopped = run, NEVER, NEVER, None

    async def arm(self) -> None:
        self._check()
        self.begun.append("arm")
        self.armed, self.started, self.stopped = self.now(), NEVER, None

    async def start(self) -> None:
        self.begun.append("start")
        self.started = self.now() + 1000

    async def counter_ticks(self) -> int:
        await asyncio.sleep(0)
        self._check()
        return self.now()

    async def clock_exchange(self) -> ClockExchange:
        before_s = monotonic()
        ticks = await self.counter_ticks()
        return ClockExchange(before_s=before_s, ticks=ticks, after_s=monotonic())

    async def has_finished(self) -> bool:
        self._check()
        n = self.run.scheme.samples_per_turn * self.run.repeats
        return self.triggers().size == n

    def stamps(self):
        raise NotImplementedError

    async def stop(self) -> Timestamps:
        self._check()
        self.stopped = self.now()
        return self._timestamps(whole=not self.loses_stamps)

    def captured(self) -> Timestamps:
        return self._timestamps(whole=False)

    async def close(self) -> None:
        pass

    def _timestamps(self, *, whole: bool) -> Timestamps:
        now = self.now()
        until = min(now if self.stopped is None else self.stopped, self.started + self.gone_from)
        period = int(self.run.scheme.control_slot_period_ticks * self.wheel_factor)
        slots = np.arange(self.armed // period + 1, until // period + 1) * period
        late = np.maximum(slots - self.started - self.slow_from, 0) if self.slow_from < NEVER else 0 * slots
        slots = slots + late // 10
        quarter = self.run.scheme.turn_period_ticks // 4
        edges = np.arange(self.armed // quarter + 1, until // quarter + 1) * quarter
        delayed = self.triggers(now)
        empty = np.empty(0, np.int64)
        return Timestamps(
            clock_frequency_hz=CLOCK_HZ,
            camera_trigger_ticks=delayed - self.run.trigger_delay_ticks,
            camera_trigger_delayed_ticks=delayed,
            control_slot_ticks=slots[slots <= until],
            application_slot_ticks=edges[(edges // quarter) % 2 == 0],
            application_edge_ticks=edges,
            camera_input_ticks=np.array([tick for tick in self.strobes() if self.armed <= tick <= until], np.int64),
            spare_ticks=empty,
            lost_after_ticks=empty if whole else np.array([until]),
        )


@dataclass
class FakeCamera:
    """Camera that makes a frame ``latency_s`` after each edge; ``missed`` and ``lost`` are numbers of triggers."""

    generator: FakeGenerator
    missed: set[int] = field(default_factory=set)
    lost: set[int] = field(default_factory=set)
    damaged: set[int] = field(default_factory=set)
    extra_after: set[int] = field(default_factory=set)
    latency_s: float = 2e-3
    device_hz: float = 1e9
    free_running: bool = False
    frozen: bool = False
    gone_after: int = NEVER
    silent_after: int = NEVER
    shape: tuple[int, int] = (4, 6)
    level_dn: Callable[[], int] = lambda: 1000
    name: str = "camera"
    identity = CameraIdentity(vendor="Vendor", model="Model 7", serial_number="SN1", firmware="1", address="fake")
    features: dict[str, str] = field(
        default_factory=lambda: {"ExposureTime": "250", "TriggerSource": "Line1", "Width": "6", "Height": "4"}
    )
    armed: bool = False
    sent: int = 0
    free_hz: float | None = None
    starts: list[int] = field(default_factory=list)
    last_made: int = NEVER

    async def feature(self, name: str) -> str:
        if name not in self.features:
            raise InstrumentRefused(f"camera has no feature {name}")
        return self.features[name]

    async def set_feature(self, name: str, *, value: str) -> str:
        await self.feature(name)
        self.features[name] = value
        return value

    async def arm(self, *, free_hz: float | None = None) -> CameraSetup:
        self.generator.begun.append("camera")
        self.armed, self.sent, self.free_hz, self.last_made = True, 0, free_hz, NEVER
        self.starts.append(self.generator.now())
        self._since = monotonic()
        return CameraSetup(
            rows=self.shape[0],
            columns=self.shape[1],
            pixel_format="Mono16",
            bit_depth=14,
            trigger_source="Line1",
            trigger_activation="RisingEdge",
            timestamp_frequency_hz=self.device_hz,
            integration_time_s=250e-6,
        )

    async def frames(self):
        at, given, frame_id = 0, 0, 0
        while True:
            triggers = [int(tick) for tick in self.generator.triggers()]
            if self.free_hz is not None:
                triggers = self.made_by_itself()
            if self.free_running:
                period = int(0.02 * CLOCK_HZ)
                first = int((self._since - self.generator.born) * self.generator.speed * CLOCK_HZ)
                triggers = list(range(first, self.generator.now(), period))
            due = [tick for tick in triggers if tick + self.latency_s * CLOCK_HZ <= self.generator.now()]
            while at < len(due):
                number, tick = at, due[at]
                at += 1
                if number >= self.gone_after:
                    raise InstrumentSilent("camera has vanished; plug it in again")
                if number in self.missed or number >= self.silent_after:
                    continue
                for extra in range(1 + (number in self.extra_after)):
                    if number not in self.lost:
                        yield self._frame(frame_id, tick + extra * SCHEME.camera_period_ticks // 2, number)
                        given += 1
                    frame_id += 1
            if not self.armed:
                return
            await asyncio.sleep(1e-3)

    def _frame(self, frame_id, tick, number):
        self.sent += 1
        random = np.random.default_rng(0 if self.frozen else number)
        level = self.level_dn()
        pixels = random.integers(level, level + 50, self.shape).astype(np.uint16)
        return CameraFrame(
            pixels=pixels,
            frame_id=frame_id,
            device_timestamp_ticks=int(tick * self.device_hz / CLOCK_HZ) + 7,
            host_time_s=monotonic(),
            packets_missing=int(number in self.damaged),
        )

    def made_by_itself(self) -> list[int]:
        """When frames began since the last start, as ticks of the generator."""
        period = round(CLOCK_HZ / (self.free_hz or 1.0))
        return list(range(self.starts[-1] + 1000, min(self.generator.now(), self.last_made), period))

    async def clock_exchange(self) -> ClockExchange:
        before_s = monotonic()
        ticks = int(self.generator.now() * self.device_hz / CLOCK_HZ) + 7
        return ClockExchange(before_s=before_s, ticks=ticks, after_s=monotonic())

    async def disarm(self) -> StreamCounts:
        if self.armed:
            self.last_made = self.generator.now()
        self.armed = False
        return self.counts()

    def counts(self) -> StreamCounts:
        return StreamCounts(frames=self.sent)

    async def close(self) -> None:
        pass


@dataclass
class FakeChopper:
    """Chopper controller whose wheel is the generator's."""

    state_now: ChopperState = field(
        default_factory=lambda: ChopperState(
            model="MC2000B",
            blade="MC1F2",
            reference="external-inner",
            output="inner",
            harmonic_multiplier=1,
            harmonic_divider=1,
            is_enabled=False,
        )
    )
    done: list[str] = field(default_factory=list)
    name: str = "chopper"

    async def state(self) -> ChopperState:
        return self.state_now

    async def prepare(self) -> ChopperState:
        self.done.append("prepare")
        return self.state_now

    async def start(self) -> None:
        self.done.append("start")
        self.state_now = replace(self.state_now, is_enabled=True)

    async def stop(self) -> None:
        self.done.append("stop")
        self.state_now = replace(self.state_now, is_enabled=False)

    async def close(self) -> None:
        pass


@dataclass
class FakeBlackbody:
    """Blackbody that takes ``settling`` questions to become stable; ``drift_k`` is added at each question once it has."""

    temperature_k: float = 300.0
    target_k: float = 300.0
    settling: int = 2
    drift_k: float = 0.0
    left: int = 0
    name: str = "blackbody"
    targets: list[float] = field(default_factory=list)

    async def state(self) -> BlackbodyState:
        if self.left > 0:
            self.left -= 1
        else:
            self.temperature_k += self.drift_k
        is_there = self.left == 0
        temperature_k = self.temperature_k if is_there else self.temperature_k - 1.0
        return BlackbodyState(model="SR-800R", temperature_k=temperature_k, target_k=self.target_k, is_stable=is_there)

    async def set_target(self, temperature_k: float) -> None:
        self.targets.append(temperature_k)
        self.target_k = self.temperature_k = temperature_k
        self.left = self.settling

    async def close(self) -> None:
        pass


class Heard(Attendant):
    """Keeps what it is told and asked; says that it is enough after so many frames, and leaves when ``leaves`` says so."""

    def __init__(self, enough_after: int = NEVER) -> None:
        self.sentences: list[str] = []
        self.outcomes: list[object] = []
        self.numbers: list[int] = []
        self.enough_after = enough_after
        self.attended: list[str] = []
        self.leaves: Callable[[], bool] = lambda: False

    def says(self, text: str) -> None:
        self.sentences.append(text)

    def written(self, frame, *, number) -> None:
        self.numbers.append(number)

    def ended(self, outcome) -> None:
        self.outcomes.append(outcome)

    def is_enough(self) -> bool:
        return len(self.numbers) >= self.enough_after

    def is_leaving(self) -> bool:
        return self.leaves()

    async def move_wheel(self, what) -> None:
        self.attended.append(what)


@dataclass
class Laboratory:
    """The devices, a plan for them, and a folder; `recorded` makes the series."""

    folder: object
    generator: FakeGenerator = field(default_factory=FakeGenerator)
    chopper: FakeChopper | None = None
    blackbody: FakeBlackbody | None = None
    runs: tuple[PlannedRun, ...] = (RUN,)
    plan: SeriesPlan = field(
        default_factory=lambda: SeriesPlan(
            devices=DeviceAddresses(camera="gige:fake", trigger_generator="fake"),
            camera=CameraWishes(camera_type="photon"),
            file_name="{camera}_{speed}_{delay}_r{run}.nxs",
        )
    )
    heard: Heard = field(default_factory=Heard)

    def __post_init__(self) -> None:
        self.camera = FakeCamera(self.generator)

    @property
    def triggers(self) -> TriggerPlan:
        return TriggerPlan(clock_frequency_hz=CLOCK_HZ, schemes=(SCHEME,), runs=self.runs)

    @property
    def rig(self) -> Rig:
        return Rig(
            generator=self.generator,
            camera=self.camera,
            chopper=self.chopper,
            blackbody=self.blackbody,
            speed=self.generator.speed,
        )

    @property
    def series(self) -> Series:
        return Series(plan=self.plan, triggers=self.triggers, folder=self.folder)

    @property
    def journal(self) -> Journal:
        digest = digest_of(self.plan, self.triggers)
        return Journal.opened(self.folder, digest=digest, n_runs=len(self.series.runs))

    def recorded(self):
        """Outcome of the series."""
        session = record_series(self.rig, self.series, attendant=self.heard, journal=self.journal)
        return asyncio.run(asyncio.wait_for(session, timeout=30))


@pytest.fixture
def laboratory(tmp_path):
    """A laboratory whose devices do as they should."""
    return Laboratory(tmp_path)


@pytest.fixture
def with_blackbody(laboratory, monkeypatch):
    """A laboratory with chopper and blackbody, which is asked more often than a real one may be."""
    monkeypatch.setattr("irtiming.acquire.temperature._POLL_S", 0.2)
    laboratory.chopper, laboratory.blackbody = FakeChopper(), FakeBlackbody()
    return laboratory

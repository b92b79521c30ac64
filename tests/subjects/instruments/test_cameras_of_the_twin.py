"""Both drivers against the camera of the twin: triggers in, the twin's own frames out, over the bytes of GigE Vision."""

import asyncio
import os
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("genicam", reason="the extra irtiming[rig] is not installed")
pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")

from irtiming.errors import InstrumentError, InstrumentSilent
from irtiming.instruments.cameras import open_camera
from irtiming.instruments.genicam import aravis_library
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.gige_camera import GigeCamera
from irtiming.twin.devices.gige_registers import Address
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.scene import paper_scene

CLOCK_HZ, SLOT, PERIOD, N = 48_000_000, 160_000, 1_584_000, 16
PAUSE_S = PERIOD / CLOCK_HZ / 3


@pytest.fixture(params=["gige", "aravis"])
def scheme(request):
    if request.param == "aravis":
        try:
            aravis_library.library()
        except InstrumentError as error:
            pytest.skip(str(error))
    return request.param


class Rig:
    """A camera before a wheel, triggered three times as fast as in life; it keeps the frames that it made.

    All at once they are more than the computer's buffer holds, and a busy one takes none for a while.
    """

    def __init__(self, faults):
        scene = paper_scene()
        trigger = replace(
            scene.trigger,
            clock_frequency_hz=float(CLOCK_HZ),
            turn_period_ticks=100 * SLOT,
            camera_period_ticks=PERIOD,
            n_triggers=N,
        )
        scene = replace(scene, trigger=trigger)
        pid = os.getpid()
        self.host = f"127.{pid >> 14 & 63 | 128}.{pid >> 7 & 127}.{pid & 127 | 128}"
        self.wheel = DrivenWheel(scene, clock_frequency_hz=CLOCK_HZ, seed=3, remembers=True)
        self.camera = LiveCamera(scene, self.wheel, clock_frequency_hz=CLOCK_HZ, seed=11)
        self.device = GigeCamera(self.camera, self.host, faults=faults)

    def turn(self):
        triggers = PERIOD * (1 + np.arange(N))
        for cycle in range(240_000, PERIOD * (N + 3), 240_000):
            self.wheel.turn(cycle, slot_period_cycles=SLOT)
            now = triggers[(triggers >= cycle - 240_000) & (triggers < cycle)]
            if now.size:
                self.camera.trigger(now)
                time.sleep(PAUSE_S * now.size)


async def _has_come(camera, *, patience_s=2.0, first_s=25.0):
    """All frames that were triggered, or none more for a while; before the first one the twin may have to compile."""
    came, since = 0, time.monotonic()
    while came < N and time.monotonic() - since < (patience_s if came else first_s):
        await asyncio.sleep(0.02)
        if camera.counts().frames > came:
            came, since = camera.counts().frames, time.monotonic()


async def _recorded(scheme, rig):
    with rig.camera, rig.device:
        async with open_camera(f"{scheme}:{rig.host}") as camera:
            setup = await camera.arm()
            await asyncio.to_thread(rig.turn)
            await _has_come(camera)
            counts = await camera.disarm()
            return setup, [frame async for frame in camera.frames()], counts


def _run(scheme, faults=None):
    return asyncio.run(asyncio.wait_for(_recorded(scheme, Rig(faults or CameraFaults())), 60))


@pytest.fixture(scope="module")
def sound():
    """Frames of the twin over a sound line, by our own driver."""
    frames = _run("gige")[1]
    assert len(frames) == N
    return frames


def test_each_trigger_makes_a_frame(scheme, sound):
    """Oracle: the other driver, pixel by pixel; the camera's clock is 7e-6 fast against that of the triggers, by its traits."""
    setup, frames, counts = _run(scheme)
    assert (setup.trigger_source, setup.bit_depth, setup.integration_time_s) == ("Line1", 16, 250e-6)
    assert [frame.frame_id for frame in frames] == list(range(N))
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(frames, sound, strict=True))
    ticks = [frame.device_timestamp_ticks for frame in frames]
    period_s = (ticks[-1] - ticks[0]) / (N - 1) / setup.timestamp_frequency_hz
    assert period_s == pytest.approx(PERIOD / CLOCK_HZ * (1 + 7e-6), rel=2e-6)
    assert (counts.frames, counts.frames_damaged, counts.queue_dropped) == (N, 0, 0)


def test_packets_lost_late_and_double_do_no_harm_where_they_are_sent_again(scheme, sound):
    """Oracle: the frames of the sound line."""
    faults = CameraFaults(packets_lost_per_mille=5, packets_late_per_mille=5, packets_doubled_per_mille=5)
    _, frames, counts = _run(scheme, faults)
    assert [frame.frame_id for frame in frames] == list(range(N))
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(frames, sound, strict=True))
    assert counts.packets_resent > 0
    assert counts.frames_damaged == 0


def test_packets_that_stay_lost_mark_their_frame(scheme, sound):
    """Oracle: the sound line: a frame that calls itself whole is, one that does not has zeros and the rest."""
    _, frames, counts = _run(scheme, CameraFaults(packets_lost_per_mille=5, resend_honoured=False))
    assert 0 < counts.frames_damaged < N
    for frame in frames:
        true = sound[frame.frame_id].pixels
        if frame.is_whole:
            assert np.array_equal(frame.pixels, true)
        else:
            assert not np.array_equal(frame.pixels, true)
            assert ((frame.pixels == true) | (frame.pixels == 0)).all()


def test_frame_of_which_nothing_came_is_a_gap(scheme, sound):
    """Oracle: the frames that the twin keeps to itself: the first and the eighth.

    They never come; the others all do, where the computer is not too busy to take them: of three runs in one at least.
    """
    lost, numbers = frozenset({0, 7}), list[int]()
    for _ in range(3):
        _, frames, _ = _run(scheme, CameraFaults(frames_lost=lost))
        numbers = [frame.frame_id for frame in frames]
        assert not lost & set(numbers)
        assert all(np.array_equal(frame.pixels, sound[frame.frame_id].pixels) for frame in frames)
        if len(numbers) == N - len(lost):
            break
    assert numbers == [i for i in range(N) if i not in lost]


def test_unplugged_camera_keeps_what_had_come():
    """Oracle: all frames had come before; then the camera falls silent."""

    async def test(rig):
        with rig.camera, rig.device:
            async with open_camera(f"gige:{rig.host}") as camera:
                await camera.arm()
                await asyncio.to_thread(rig.turn)
                await _has_come(camera)
                rig.device.faults.unplugged = True
                taken = camera.frames()
                frames = [await anext(taken) for _ in range(N)]
                with pytest.raises(InstrumentSilent, match="does not answer"):
                    await asyncio.wait_for(anext(taken), 8)
                assert [frame.frame_id for frame in frames] == list(range(N))
                assert (await camera.disarm()).frames == N

    asyncio.run(asyncio.wait_for(test(Rig(CameraFaults())), 30))


def test_a_busy_program_has_time_to_be_heard_and_the_camera_is_left_as_it_was():
    """Oracle: the camera's own register: 3 s by the standard, more while this program has it."""

    async def test(rig):
        silence_ms = lambda: rig.device._registers.word(Address.HEARTBEAT_TIMEOUT)  # noqa: E731
        with rig.camera, rig.device:
            assert silence_ms() == 3000
            async with open_camera(f"gige:{rig.host}"):
                assert silence_ms() == 5000
            assert silence_ms() == 3000

    asyncio.run(asyncio.wait_for(test(Rig(CameraFaults())), 30))

"""Cameras by the Aravis library: its project's fake camera, and one that misbehaves as told."""

import asyncio

import numpy as np
import pytest

pytest.importorskip("genicam", reason="the extra irtiming[rig] is not installed")

from gige_responder import COLUMNS, ROWS, Responder, aravis_fake, image

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.instruments.genicam import aravis_camera, aravis_library
from irtiming.instruments.genicam.aravis_camera import connected


@pytest.fixture(scope="module", autouse=True)
def library():
    try:
        aravis_library.library()
    except InstrumentError as error:
        pytest.skip(str(error))


def _run(test):
    asyncio.run(asyncio.wait_for(test, 20))


async def _taken(camera, n):
    taken = []
    async for frame in camera.frames():
        taken.append(frame)
        if len(taken) == n:
            break
    return taken


async def _stream(responder, send):
    async with connected(responder.host) as camera:
        setup = await camera.arm()
        await asyncio.to_thread(send)
        await asyncio.sleep(0.1)
        counts = await camera.disarm()
        return setup, [frame async for frame in camera.frames()], counts


def test_frames_of_the_fake_camera():
    """Oracle: the Aravis project's program at the rate that was set, twice in a row; ids count from 0 each time.

    It cannot send a packet again, so its frames are small: all of them fit into the buffer of a computer that is busy.
    """

    async def test():
        async with connected("127.0.0.1") as camera:
            assert camera.identity.model == "Fake"
            assert camera.identity.address == "aravis:127.0.0.1"
            await camera.set_feature("Width", value="64")
            await camera.set_feature("Height", value="48")
            await camera.set_feature("AcquisitionFrameRate", value="100")
            await camera.set_feature("TriggerMode", value="Off")
            for _ in range(2):
                setup = await camera.arm()
                assert (setup.rows, setup.columns, setup.pixel_format) == (48, 64, "Mono16")
                assert await camera.feature("TriggerMode") == "On"
                await camera.set_feature("TriggerMode", value="Off")  # its line never fires
                frames = await _taken(camera, 20)
                counts = await camera.disarm()
                assert [frame.frame_id for frame in frames] == list(range(20))
                assert all(frame.is_whole for frame in frames)
                ticks = np.diff([frame.device_timestamp_ticks for frame in frames])
                assert np.median(ticks) / setup.timestamp_frequency_hz == pytest.approx(0.01, rel=0.1)
                assert counts.frames_damaged == counts.queue_dropped == 0
        async with connected("127.0.0.1") as camera:
            assert await camera.feature("TriggerMode") == "Off"

    with aravis_fake():
        _run(test())


def test_lost_packets_of_the_fake_camera_are_marked():
    """Oracle: the fake camera, told to lose packets; every frame is delivered all the same, the damaged ones with zeros."""

    async def test():
        async with connected("127.0.0.1") as camera:
            await camera.set_feature("Width", value="128")
            await camera.set_feature("Height", value="96")
            await camera.set_feature("AcquisitionFrameRate", value="100")
            await camera.arm()
            await camera.set_feature("TriggerMode", value="Off")
            frames = await _taken(camera, 50)
            await camera.disarm()
        damaged = [frame for frame in frames if not frame.is_whole]
        assert 5 < len(damaged) < 50
        assert [frame.frame_id for frame in frames] == sorted({frame.frame_id for frame in frames})
        assert all(frame.pixels.shape == (96, 128) and (frame.pixels == 0).any() for frame in damaged)
        own_zeros = max(np.count_nonzero(frame.pixels == 0) for frame in frames if frame.is_whole)
        assert np.median([np.count_nonzero(frame.pixels == 0) for frame in damaged]) > 4 * own_zeros

    with aravis_fake("-r", "20"):
        _run(test())


def test_camera_that_is_unplugged():
    """Oracle: a camera that falls silent while it waits for triggers; plugged in again it is not taken for the same."""

    async def test(responder):
        async with connected(responder.host) as camera:
            await camera.arm()
            responder.is_silent = True
            with pytest.raises(InstrumentSilent, match=f"camera {responder.host} does not answer"):
                await asyncio.wait_for(_taken(camera, 1), 10)
            responder.is_silent = False
            with pytest.raises(InstrumentSilent, match="connect again"):
                await camera.feature("Width")
            await camera.disarm()

    with Responder() as responder:
        _run(test(responder))


def test_frames_are_those_that_were_sent():
    """Oracle: the images of the responder, ids across the wrap from 65535 to 1, timestamps of a clock of 1 MHz in ns."""
    numbers = [65534, 65535, 1, 2]
    with Responder() as camera:
        setup, frames, counts = asyncio.run(
            _stream(camera, lambda: [camera.say(n, image(n), ticks=5 * n) for n in numbers])
        )
    assert (setup.rows, setup.columns, setup.trigger_source) == (ROWS, COLUMNS, "Line1")
    assert [frame.frame_id for frame in frames] == [0, 1, 2, 3]
    assert all(np.array_equal(f.pixels, image(n)) for f, n in zip(frames, numbers, strict=True))
    assert [frame.device_timestamp_ticks for frame in frames] == [5000 * n for n in numbers]
    assert counts.frames == 4


def test_feature_errors_are_the_same_as_those_of_the_other_driver():
    """Oracle: the words for a wrong name, a wrong choice and a fixed value."""

    async def test(host):
        async with connected(host) as camera:
            for name, value, words in (
                ("TriggerSorce", "Line1", "nearest names: TriggerSource"),
                ("TriggerSource", "Line9", "may be Software, Line0, Line1"),
                ("Width", "9", "cannot be set"),
            ):
                with pytest.raises(InstrumentRefused, match=words):
                    await camera.set_feature(name, value=value)

    with Responder() as responder:
        _run(test(responder.host))


def test_two_programs_and_one_camera(monkeypatch):
    """Oracle: the standard: control is for one. The library would open the camera to look at it only."""
    monkeypatch.setattr(aravis_camera, "_STALE_CONTROL_S", 0.1)

    async def test(responder):
        responder.controller = ("127.0.0.1", 1)  # somebody else
        with pytest.raises(InstrumentRefused, match="controlled by another program"):
            async with connected(responder.host):
                pass

    with Responder() as responder:
        _run(test(responder))


def test_nobody_answers():
    """Oracle: a loopback address at which nothing listens."""

    async def test():
        with pytest.raises(InstrumentSilent, match=r"camera 127\.9\.9\.9 does not answer"):
            async with connected("127.9.9.9"):
                pass

    _run(test())


def test_library_that_is_not_installed(monkeypatch):
    """Oracle: the package that has it."""
    monkeypatch.setattr(aravis_library, "_NAMES", ("libnothing-of-that-name.so.0",))
    aravis_library.library.cache_clear()
    try:
        with pytest.raises(InstrumentError, match="apt install libaravis"):
            aravis_library.library()
    finally:
        aravis_library.library.cache_clear()

"""GigE Vision cameras: the Aravis project's fake camera as the independent program, and one that misbehaves as told."""

import asyncio
import struct

import numpy as np
import pytest

pytest.importorskip("genicam", reason="the extra irtiming[rig] is not installed")
pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")

from gige_responder import COLUMNS, ROWS, Responder, aravis_fake, image

from irtiming.errors import InstrumentRefused, InstrumentSilent
from irtiming.instruments.genicam import gige_assembly, gige_control, gige_datagrams, gige_stream
from irtiming.instruments.genicam.gige_control import parse_place
from irtiming.instruments.genicam.gige_vision_camera import connected
from irtiming.records.camera_frame import CameraIdentity


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """No waiting for test packets of sizes that do not pass; more patience with resends, since tests run side by side."""
    monkeypatch.setattr(gige_stream, "_TEST_S", 0.02)
    monkeypatch.setitem(gige_assembly._PATIENCE_S, True, 1.0)


@pytest.fixture
def small_packets(monkeypatch):
    """Four packets of pixels in an image: 1 to 4, between leader 0 and trailer 5."""
    monkeypatch.setattr(gige_stream, "_USUAL_SIZE", 576)


def _run(test):
    asyncio.run(asyncio.wait_for(test, 20))


async def _taken(camera, n):
    """The next n frames."""
    taken = []
    async for frame in camera.frames():
        taken.append(frame)
        if len(taken) == n:
            break
    return taken


async def _rest(camera):
    return [frame async for frame in camera.frames()]


async def _stream(responder, send):
    """Frames and counts of one acquisition in which the responder sends what it is told."""
    async with connected(responder.host) as camera:
        await camera.arm()
        await asyncio.to_thread(send)
        await asyncio.sleep(0.03)
        counts = await camera.disarm()
        return await _rest(camera), counts


def test_frames_of_the_fake_camera():
    """Oracle: the Aravis project's program: its ramp moves by one from frame to frame, at the rate that was set."""

    async def test():
        async with connected("127.0.0.1") as camera:
            assert camera.identity.model == "Fake"
            assert camera.identity.serial_number == "SIM01"
            await camera.set_feature("Width", value="640")
            await camera.set_feature("Height", value="480")
            await camera.set_feature("AcquisitionFrameRate", value="100")
            setup = await camera.arm()
            assert (setup.rows, setup.columns, setup.bit_depth) == (480, 640, 16)
            assert (setup.pixel_format, setup.trigger_source) == ("Mono16", "Line0")
            assert setup.timestamp_frequency_hz == 1e9
            assert await camera.feature("TriggerMode") == "On"
            await camera.set_feature("TriggerMode", value="Off")  # its line never fires
            frames = await _taken(camera, 30)
            counts = await camera.disarm()
        assert [frame.frame_id for frame in frames] == list(range(30))
        assert all(frame.is_whole and frame.pixels.shape == (480, 640) for frame in frames)
        assert np.ptp(frames[0].pixels) > 1000
        assert not np.array_equal(frames[0].pixels, frames[1].pixels)
        ticks = np.diff([frame.device_timestamp_ticks for frame in frames])
        assert np.median(ticks) == pytest.approx(1e7, rel=0.1)
        assert counts.frames >= 30
        assert counts.packets_missing == counts.queue_dropped == 0

    with aravis_fake():
        _run(test())


def test_lost_packets_of_the_fake_camera_are_counted_and_blank():
    """Oracle: the same fake camera, told to lose 2 % of its packets; it knows no resend. Each missing one leaves zeros."""

    async def test():
        async with connected("127.0.0.1") as camera:
            await camera.set_feature("AcquisitionFrameRate", value="100")
            await camera.arm()
            await camera.set_feature("TriggerMode", value="Off")
            frames = await _taken(camera, 60)
            counts = await camera.disarm()
        ids = [frame.frame_id for frame in frames]
        assert ids == sorted(set(ids))
        damaged = [frame for frame in frames if not frame.is_whole]
        assert 5 < len(damaged) < 60
        assert counts.frames_damaged >= len(damaged)
        for frame in damaged:
            if frame.device_timestamp_ticks:  # its leader came
                assert np.count_nonzero(frame.pixels == 0) >= (frame.packets_missing - 1) * (9000 - 36) // 2
        assert counts.packets_resent == 0

    with aravis_fake("-r", "20"):
        _run(test())


def test_camera_is_given_back_as_it_was():
    """Oracle: the fake camera read by a second connection: trigger off as found, and nobody in control."""

    async def test():
        async with connected("127.0.0.1") as camera:
            await camera.set_feature("TriggerMode", value="Off")
            await camera.arm()
            assert await camera.feature("TriggerMode") == "On"
            with pytest.raises(InstrumentRefused, match="armed already"):
                await camera.arm()
        async with connected("127.0.0.1") as camera:
            assert await camera.feature("TriggerMode") == "Off"
            await camera.arm()
            await camera.disarm()
            await camera.close()
            await camera.close()

    with aravis_fake():
        _run(test())


def test_camera_that_is_unplugged():
    """Oracle: the fake camera killed while it waits for triggers: quiet either way, only the heartbeat tells."""

    async def test(process):
        async with connected("127.0.0.1") as camera:
            await camera.arm()
            process.kill()
            with pytest.raises(InstrumentSilent, match=r"127\.0\.0\.1 does not answer"):
                await asyncio.wait_for(_rest(camera), 6)
            await camera.disarm()

    with aravis_fake() as process:
        _run(test(process))


@pytest.mark.parametrize("wide", [False, True], ids=["16 bit", "64 bit"])
def test_frame_ids_count_from_0_and_never_wrap(wide):
    """Oracle: the standard: numbers of 16 bits go from 65535 to 1, those of 64 bits go on."""
    numbers = [65533, 65534, 65535, *((65536, 65537) if wide else (1, 2))]
    with Responder() as camera:
        frames, counts = asyncio.run(
            _stream(camera, lambda: [camera.say(n, image(n), wide=wide, ticks=7 * n) for n in numbers])
        )
    assert [frame.frame_id for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.device_timestamp_ticks for frame in frames] == [7 * n for n in numbers]
    assert all(np.array_equal(f.pixels, image(n)) for f, n in zip(frames, numbers, strict=True))
    assert counts.frames == 5
    assert counts.packets_missing == 0


@pytest.mark.parametrize("wide", [False, True], ids=["16 bit", "64 bit"])
@pytest.mark.parametrize("lose", [(1,), (0,), (2, 3), (0, 1, 2, 3, 4), (5,), (0, 1, 2, 3, 4, 5)])
def test_lost_packets_are_asked_for_again(lose, wide, small_packets):
    """Oracle: the responder, which holds every packet ready: the frame is whole in the end, and in its order."""
    with Responder(largest_packet=576) as camera:

        def send():
            camera.say(1, image(1), wide=wide)
            camera.say(2, image(2), wide=wide, lose=lose)
            camera.say(3, image(3), wide=wide)

        frames, counts = asyncio.run(_stream(camera, send))
    assert [frame.frame_id for frame in frames] == [0, 1, 2]
    assert all(frame.is_whole and np.array_equal(frame.pixels, image(i + 1)) for i, frame in enumerate(frames))
    if lose != (5,):  # the trailer, which holds nothing
        assert {number for number, _, _ in camera.asked} == {2}
        assert counts.packets_resent == len([i for i in lose if 0 < i < 5])
    assert counts.packets_missing == 0


@pytest.mark.parametrize("wide", [False, True], ids=["16 bit", "64 bit"])
def test_frames_lost_as_a_whole_are_asked_for(wide, small_packets):
    """Oracle: the responder, which holds every packet ready; three frames in a row, the numbers of 16 bits wrap among them."""
    numbers = [65533, 65534, 65535, *((65536, 65537) if wide else (1, 2))]
    with Responder(largest_packet=576) as camera:

        def send():
            for n in numbers:
                camera.say(n, image(n), wide=wide, ticks=7 * n, lose=range(6) if n in numbers[1:4] else ())

        frames, counts = asyncio.run(_stream(camera, send))
    assert [frame.frame_id for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.device_timestamp_ticks for frame in frames] == [7 * n for n in numbers]
    assert all(np.array_equal(f.pixels, image(n)) for f, n in zip(frames, numbers, strict=True))
    assert (counts.frames, counts.packets_resent, counts.packets_missing) == (5, 12, 0)


def test_a_first_frame_that_is_lost_is_asked_for(small_packets):
    """Oracle: the responder; by the standard the first number of an acquisition is 1."""
    with Responder(largest_packet=576) as camera:
        frames, _ = asyncio.run(
            _stream(camera, lambda: (camera.say(1, image(1), lose=range(6)), camera.say(2, image(2))))
        )
    assert [frame.frame_id for frame in frames] == [0, 1]
    assert all(frame.is_whole and np.array_equal(frame.pixels, image(i + 1)) for i, frame in enumerate(frames))


def test_packets_that_the_camera_no_longer_has_leave_zeros(small_packets):
    """Oracle: the places of packets 2 and 3 in the image by hand; a packet with an error as status is no pixels."""
    with Responder(largest_packet=576) as camera:

        def send():
            camera.say(1, image(1), spoil=(2,), lose=(3,))
            camera.sent.clear()
            camera.say(3, image(3))
            camera.sent.clear()

        (first, last), counts = asyncio.run(_stream(camera, send))
        share = (camera.get(0x0D04) - 36) // 2
    expected = image(1).ravel()
    expected[share : 3 * share] = 0
    assert np.array_equal(first.pixels.ravel(), expected)
    assert first.packets_missing == 2
    assert (first.frame_id, last.frame_id) == (0, 2)  # of frame 1 nothing came
    assert (counts.frames, counts.frames_damaged, counts.packets_missing) == (2, 1, 2)


def test_without_resend_nothing_is_asked_for():
    """Oracle: the capability register of a camera that cannot; the first frame lost as a whole leaves id 1 as the first."""
    with Responder(resends=False) as camera:
        frames, counts = asyncio.run(
            _stream(camera, lambda: (camera.say(2, image(2), lose=(1,)), camera.say(3, image(3))))
        )
    assert camera.asked == []
    assert [(frame.frame_id, frame.packets_missing) for frame in frames] == [(1, 1), (2, 0)]
    assert counts.packets_resent == 0


@pytest.mark.parametrize("reader", [gige_datagrams.ManyAtOnce, gige_datagrams.OneByOne])
def test_both_ways_to_receive_give_the_same(reader, monkeypatch):
    """Oracle: the images that were sent, 200 of them in one go."""
    monkeypatch.setattr(
        gige_stream, "datagrams", lambda opened, longest, sender: reader(opened, slot_bytes=longest, sender=sender)
    )
    with Responder() as camera:
        frames, counts = asyncio.run(_stream(camera, lambda: [camera.say(n, image(n)) for n in range(1, 201)]))
    assert [frame.frame_id for frame in frames] == list(range(200))
    assert all(np.array_equal(frame.pixels, image(i + 1)) for i, frame in enumerate(frames))
    assert counts.queue_dropped == 0


@pytest.mark.parametrize(("passes", "size"), [(1500, 1500), (5000, 4096), (9000, 9000)])
def test_largest_packets_that_pass(passes, size):
    """Oracle: a camera whose network takes packets of at most so many bytes."""
    with Responder(largest_packet=passes) as camera:
        frames, _ = asyncio.run(_stream(camera, lambda: camera.say(1, image(1))))
        assert camera.get(0x0D04) == size
    assert frames[0].is_whole


@pytest.mark.parametrize("zipped", [False, True])
def test_description_at_an_address_of_digits_only(zipped):
    """Oracle: the standard: the address 10000 in the place of the description is hexadecimal."""

    async def test(host):
        async with connected(host) as camera:
            assert await camera.feature("Width") == str(COLUMNS)
            assert camera.identity == CameraIdentity(
                vendor="Test", model="Small", serial_number="T7", firmware="", address=f"gige:{host}"
            )

    with Responder(zipped=zipped) as camera:
        _run(test(camera.host))


@pytest.mark.parametrize(
    "place", ["http://somewhere/camera.xml", "Local:a.xml", "Local:a.xml;xyz;10", "File:a.xml;10;10", ""]
)
def test_description_elsewhere_is_refused(place):
    """Oracle: the standard's form Local:name;address;length."""
    with pytest.raises(InstrumentRefused, match="not in its memory"):
        parse_place(place)


def test_arming_sets_what_a_trigger_needs():
    """Oracle: the registers of the camera itself; a source that is no line gives way to Line1, and close brings all back."""

    async def test(responder):
        async with connected(responder.host) as camera:
            setup = await camera.arm()
            assert (setup.trigger_source, setup.trigger_activation) == ("Line1", "RisingEdge")
            assert (setup.rows, setup.columns, setup.timestamp_frequency_hz) == (ROWS, COLUMNS, 1e6)
            assert setup.integration_time_s is None
            held = [responder.chosen(name) for name in ("PixelFormat", "TriggerSelector", "AcquisitionMode")]
            assert held == ["Mono16", "FrameStart", "Continuous"]
            assert [responder.get(responder.at["TriggerMode"] + 4 * i) for i in (0, 1)] == [1, 0]
            assert responder.get(responder.at["AcquisitionStart"]) == 1
            await camera.disarm()
            assert responder.get(responder.at["AcquisitionStop"]) == 1

    with Responder() as responder:
        responder.set(responder.at["TriggerMode"] + 4, 1)  # the acquisition would wait for a trigger of its own
        responder.choose("TriggerActivation", "LevelHigh")
        responder.choose("TriggerSelector", "AcquisitionStart")
        _run(test(responder))
        assert [responder.get(responder.at["TriggerMode"] + 4 * i) for i in (0, 1)] == [0, 1]
        assert responder.chosen("TriggerSelector") == "AcquisitionStart"
        assert responder.controller is None


def test_line_and_edge_that_are_set_are_kept():
    """Oracle: what the camera was set to before."""

    async def test(responder):
        async with connected(responder.host) as camera:
            setup = await camera.arm()
            assert (setup.trigger_source, setup.trigger_activation, setup.pixel_format) == (
                "Line0",
                "FallingEdge",
                "Mono12",
            )
            assert setup.bit_depth == 12

    with Responder() as responder:
        for name, choice in (
            ("TriggerSource", "Line0"),
            ("TriggerActivation", "FallingEdge"),
            ("PixelFormat", "Mono12"),
        ):
            responder.choose(name, choice)
        _run(test(responder))


@pytest.mark.parametrize("without", ["TriggerSelector", "TriggerSource", "TriggerActivation", "AcquisitionMode"])
def test_what_a_camera_has_no_choice_about_is_done_without(without):
    """Oracle: a camera that lacks the feature is armed, and a frame comes."""
    with Responder(without=(without,)) as camera:
        frames, _ = asyncio.run(_stream(camera, lambda: camera.say(1, image(1))))
    assert len(frames) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"without": ("TriggerMode",)}, "no feature TriggerMode"),
        ({"without": ("AcquisitionStart",)}, "no feature 'AcquisitionStart'"),
        ({"choices": {"PixelFormat": ("Mono8", "Mono12p")}}, "no PixelFormat of 16 bits.*only Mono8, Mono12p"),
        ({"choices": {"TriggerSource": ("Software", "Action0")}}, "no hardware input.*only Software, Action0"),
        ({"choices": {"TriggerSelector": ("ExposureActive",)}}, "no trigger for the start of a frame, only for Exp"),
    ],
)
def test_camera_that_cannot_be_triggered_is_refused(options, words):
    """Oracle: what the camera lacks, in one line; its triggers are as they were."""
    from gige_responder import CHOICES

    async def test(host):
        async with connected(host) as camera:
            with pytest.raises(InstrumentRefused, match=words) as told:
                await camera.arm()
            assert "\n" not in str(told.value)

    options = options | {"choices": CHOICES | options.get("choices", {})}
    with Responder(**options) as responder:
        _run(test(responder.host))
        assert responder.controller is None


def test_setting_that_the_camera_does_not_keep():
    """Oracle: a register that takes every value and stays Off."""

    async def test(responder):
        async with connected(responder.host) as camera:
            with pytest.raises(InstrumentRefused, match="TriggerMode .* was set to On, but the camera holds Off"):
                await camera.arm()

    with Responder() as responder:
        responder.stuck.add(responder.at["TriggerMode"])
        _run(test(responder))


def test_two_programs_and_one_camera(monkeypatch):
    """Oracle: the standard: control is for one; the second is told so, and the first goes on."""
    monkeypatch.setattr(gige_control, "_STALE_CONTROL_S", 0.1)

    async def test(responder):
        async with connected(responder.host) as camera:
            with pytest.raises(InstrumentRefused, match="controlled by another program"):
                async with connected(responder.host):
                    pass
            assert await camera.feature("Height") == str(ROWS)

    with Responder() as responder:
        _run(test(responder))


def test_nobody_answers():
    """Oracle: a loopback address at which nothing listens."""

    async def test():
        with pytest.raises(InstrumentSilent, match=r"camera 127\.9\.9\.9 does not answer; check its cable"):
            async with connected("127.9.9.9"):
                pass

    _run(test())


def test_camera_without_description():
    """Oracle: a device that speaks the control protocol, with empty memory."""

    async def test(responder):
        with pytest.raises(InstrumentRefused, match="does not describe its features"):
            async with connected(responder.host):
                pass

    with Responder() as responder:
        responder.memory[0x200:0x600] = bytes(0x400)
        _run(test(responder))


def test_camera_that_forgets_who_controls_it():
    """Oracle: a camera that was switched off and on answers, but its control register is 0."""

    async def test(responder):
        async with connected(responder.host) as camera:
            await camera.arm()
            responder.say(1, image(1))
            await asyncio.sleep(0.1)
            responder.set(0x0A00, 0)
            assert len(await _taken(camera, 1)) == 1
            with pytest.raises(InstrumentSilent, match="switched off and on"):
                await _rest(camera)
            assert (await camera.disarm()).frames == 1

    with Responder() as responder:
        _run(test(responder))


def test_image_of_another_size_is_refused():
    """Oracle: a leader that says another number of rows than the feature."""

    async def test(responder):
        async with connected(responder.host) as camera:
            await camera.arm()
            responder.say(1, np.zeros((ROWS - 1, COLUMNS), np.uint16))
            with pytest.raises(InstrumentRefused, match=f"sends {COLUMNS} x {ROWS - 1} pixels of 16 bits"):
                await _rest(camera)
            await camera.disarm()

    with Responder() as responder:
        _run(test(responder))


def test_strangers_packets_change_nothing():
    """Oracle: the frames that were sent; between them packets too short, of far numbers and of unknown kinds."""
    with Responder() as camera:

        def send():
            camera.say(1, image(1))
            for packet in (b"", b"abc", bytes(8), bytes(100), struct.pack(">HHI", 0, 30000, 3 << 24 | 1) + bytes(64)):
                camera._stream(packet)
            camera.say(2, image(2))

        frames, counts = asyncio.run(_stream(camera, send))
    assert [frame.frame_id for frame in frames] == [0, 1]
    assert all(np.array_equal(frame.pixels, image(i + 1)) for i, frame in enumerate(frames))
    assert counts.frames_damaged == 0


def test_frames_that_nobody_takes_are_counted(monkeypatch):
    """Oracle: a queue for four frames and seven that come: the first four stay, the others are counted and leave a gap."""
    from irtiming.instruments.genicam import camera

    monkeypatch.setattr(camera, "frames_that_fit", lambda frame_bytes: 4)
    with Responder() as camera:
        frames, counts = asyncio.run(_stream(camera, lambda: [camera.say(n, image(n)) for n in range(1, 8)]))
    assert [frame.frame_id for frame in frames] == [0, 1, 2, 3]
    assert (counts.frames, counts.queue_dropped, counts.longest_queue) == (7, 3, 4)


def test_second_acquisition_counts_anew():
    """Oracle: a camera that starts again at 1, and one that counts on: the first frame is 0 either way."""

    async def test(responder, first_number):
        async with connected(responder.host) as camera:
            for start in (1, first_number):
                await camera.arm()
                for n in range(3):
                    responder.say(start + n, image(n))
                frames = await _taken(camera, 3)
                await camera.disarm()
                assert [frame.frame_id for frame in frames] == [0, 1, 2]

    with Responder() as responder:
        for first_number in (1, 4):
            _run(test(responder, first_number))

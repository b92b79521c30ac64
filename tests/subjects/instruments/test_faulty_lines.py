"""The driver over lines that change and drop bytes at random: never a wrong timestamp that is taken for a right one."""

import asyncio
from collections import Counter

import numpy as np
import pytest

from irtiming.errors import InstrumentError
from irtiming.gateware.event_model import Latencies, recorded_to_edge_ticks
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import Channel
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import SerialTriggerGenerator

CLOCK_HZ = 48_000_000
STREAMS = {
    "camera_trigger_ticks": Channel.CAMERA_TRIGGER,
    "camera_trigger_delayed_ticks": Channel.CAMERA_TRIGGER_DELAYED,
    "control_slot_ticks": Channel.CONTROL_SLOT,
    "application_slot_ticks": Channel.APPLICATION_SLOT,
    "application_edge_ticks": Channel.APPLICATION_SLOT | Channel.APPLICATION_OTHER_EDGE,
}


async def _run(line, run):
    """What the driver has at the end, and whether it said that all is well."""
    generator = SerialTriggerGenerator(line, patience=Patience(reply_s=0.01, tries=4, poll_s=0.001))
    try:
        await generator.identify()
        await generator.load(run, clock_frequency_hz=CLOCK_HZ)
        await generator.arm()
        await generator.start()
        while not await generator.has_finished():
            await asyncio.sleep(0)
        return await generator.stop()
    except InstrumentError:
        return None if generator._stream is None else generator.captured()
    finally:
        await generator.close()


def _sent(line, channel):
    """What the device sent, read before it came to harm; pin edges as the driver gives them."""
    times = np.array([r.time_ticks for r in line.records if r.channels & channel], dtype=np.int64)
    return recorded_to_edge_ticks(times, channel, latencies=Latencies())


@pytest.mark.parametrize("block", range(3))
def test_either_every_timestamp_is_right_or_a_loss_is_marked(memory_line, steady_wheel, short_run, harm, block):
    """Oracle: the records that the device sent, taken off the line before they came to harm; 72 seeds in all."""
    seen = Counter()
    for seed in range(24 * block, 24 * block + 24):
        rate = 10.0 ** -(2 + seed % 5 / 2)  # of bytes: from 1 % to 0.01 %
        kind = {"garbled": rate} if seed % 2 else {"dropped": rate}
        line = memory_line(ModelDevice(steady_wheel()), to_computer=harm(seed, **kind), to_device=harm(-seed, **kind))
        found = asyncio.run(asyncio.wait_for(_run(line, short_run), timeout=20))
        if found is None:
            seen["refused"] += 1
            continue
        seen["whole" if found.is_whole else "lossy"] += 1
        for name, channel in STREAMS.items():
            given, sent = getattr(found, name), _sent(line, channel)
            assert np.all(np.isin(given, sent)), f"seed {seed}: {name} has times that never were"
            assert np.all(np.diff(given) > 0)
            if found.is_whole:
                assert np.array_equal(given, sent), f"seed {seed}: {name} lacks times, and nothing says so"
    assert seen["whole"]
    assert seen["lossy"]

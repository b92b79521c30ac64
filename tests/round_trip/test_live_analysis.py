"""The analysis beside a recording: what it says of a growing file, and of finished ones."""

import os
import signal
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive import reader, writer
from irtiming.archive.live.head import RecordingHead
from irtiming.archive.live.recording import LiveRecording
from irtiming.measurement import analyse
from irtiming.records.analysis import Analysis
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup
from irtiming.records.rig import Rig
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme
from irtiming.report import outside
from irtiming.report.verdict import verdict
from irtiming.session.analyst import Analyst, told_of
from irtiming.session.live import FEWEST_FRAMES, LiveAnalysis
from irtiming.session.live_estimate import LiveEstimate
from irtiming.twin import rig as twin
from irtiming.twin.scene import microbolometer_scene, paper_scene, with_wheel_speed

SETUP = CameraSetup(
    rows=48, columns=64, pixel_format="Mono14", bit_depth=14, trigger_source="Line1", trigger_activation="RisingEdge"
)
WHO = CameraIdentity(vendor="", model="", serial_number="", firmware="", address="")


@pytest.fixture(scope="module")
def rig():
    return twin.draw(paper_scene(48, 64), seed=7)


@pytest.fixture(scope="module")
def finished(rig, tmp_path_factory):
    """Recordings at two wheel speeds."""
    folder, paths = tmp_path_factory.mktemp("finished"), []
    for k, speed in enumerate((3.0, 12.0)):
        scene = with_wheel_speed(rig.scene, speed, samples=300)
        paths.append(folder / f"{k}.nxs")
        writer.write(twin.simulate(scene, seed=70 + k), paths[-1])
    return paths


@cache
def _analysed(paths: tuple[Path, ...], measured: Rig) -> Analysis:
    return analyse([reader.read(path) for path in paths], measured)


def _same(found: LiveEstimate, paths, rig) -> None:
    analysis = _analysed(tuple(paths), rig.measured)
    result, expected = analysis.result, analysis.result.estimate
    assert found.doubt == ""
    assert list(found.values.values()) == expected.values.tolist()
    assert [found.uncertainties[name] for name in expected.names] == expected.standard_uncertainties.tolist()
    assert found.not_in_uncertainty == result.not_in_uncertainty
    assert outside.behind(found.not_in_uncertainty) == verdict(analysis).outside


@pytest.fixture(scope="module")
def growing(tmp_path_factory):
    """File of a run that grows."""
    return tmp_path_factory.mktemp("growing") / "growing.nxs"


@pytest.fixture(scope="module")
def told(rig, finished, growing):
    """What it says, by name, of a series: a file that is none, a run, and a second one that grows and then is finished."""
    none, recording, said = growing.with_name("none.nxs"), reader.read(finished[1]), {}
    none.write_text("no recording")
    written = _grown(recording, growing, upto=150)
    with LiveAnalysis(rig.measured) as live:
        try:
            live.keep(none)
            said["none"] = live.settled()
            live.keep(finished[0])
            said["one run"] = live.settled()
            live.begins()
            for name, frames in {"too few": FEWEST_FRAMES - 1, "half": 150, "hardly more": 160}.items():
                live.grows(growing, frames)
                said[name] = live.settled()
            _grow(written, recording, first=150, upto=300)
            live.grows(growing, 300)
            said["whole"] = live.settled()
        finally:
            written.finish()
            written.__exit__(None, None, None)
        live.keep(growing)
        said["two runs"] = live.settled()
        assert live.latest is said["two runs"]
    return said


def test_what_it_says_at_the_end_is_what_analyse_says_of_what_can_be_analysed(rig, finished, growing, told):
    """Oracle: `measurement.analyse` of the same files, to the last digit, and its message of a file that is none."""
    assert "none.nxs: is not an HDF5 file" in told["none"].doubt
    _same(told["one run"], finished[:1], rig)
    _same(told["two runs"], [finished[0], growing], rig)
    assert told["two runs"].frames == 600


def test_of_a_microbolometer_too(tmp_path):
    """Oracle: `measurement.analyse`."""
    rig = twin.draw(microbolometer_scene(48, 64), seed=3)
    path = tmp_path / "one.nxs"
    writer.write(twin.simulate(with_wheel_speed(rig.scene, 3.0, samples=250), seed=3), path)
    _same(told_of(Analyst(rig.measured).keep(path)), [path], rig)


def _grown(recording, path: Path, *, upto: int) -> LiveRecording:
    """A file into which a recording goes frame by frame, so far."""
    scheme = TriggerScheme(
        turn_period_ticks=recording.wheel_period_ticks, camera_period_ticks=recording.camera_period_ticks
    )
    run = PlannedRun(scheme=scheme, trigger_delay_ticks=0, repeats=1, is_after_correction=False)
    head = RecordingHead(
        name="growing",
        camera_type="photon",
        readout_mode="snapshot",
        clock_frequency_hz=int(recording.clock_frequency_hz),
        run=run,
        camera=WHO,
        setup=SETUP,
        integration_time_s=recording.integration_time_s,
        nonuniformity=recording.nonuniformity,
    )
    live = LiveRecording(path, head=head)
    live.__enter__()
    return _grow(live, recording, first=0, upto=upto)


def _grow(live: LiveRecording, recording, *, first: int, upto: int) -> LiveRecording:
    """Frames and all ticks from one trigger to before another."""
    triggers = recording.camera_trigger_ticks
    since = triggers[first] if first else 0
    until = triggers[upto - 1] + recording.camera_period_ticks if upto < triggers.size else np.inf
    for stream, ticks in {
        "camera_trigger": triggers,
        "control_slot": recording.control_slot_ticks,
        "application_slot": recording.application_slot_ticks,
        "application_edges": recording.application_edge_ticks,
    }.items():
        live.append_ticks(stream, ticks[(ticks >= since) & (ticks < until)])
    for index, pixels in zip(range(first, upto), recording.frames.pick(list(range(first, upto))), strict=True):
        frame = CameraFrame(pixels=pixels, frame_id=index, device_timestamp_ticks=0, host_time_s=0.0)
        live.append_frame(frame, frame_number=index)
    return live


def test_the_estimate_tightens_while_the_file_grows(rig, finished, growing, told):
    """Oracle: more frames of the same run beside a finished one at another speed; the truth within four uncertainties."""
    assert told["too few"].frames == 300  # too few to be looked at
    assert told["hardly more"] is told["half"]  # not enough more
    few, half, whole = (told[name] for name in ("too few", "half", "whole"))
    assert (half.frames, whole.frames) == (450, 600)
    name, truth = "trigger_delay", rig.scene.timing.trigger_delay_s
    assert few.uncertainties[name] > 3 * half.uncertainties[name] > 3 * whole.uncertainties[name]
    for found in (few, half, whole):
        assert abs(found.values[name] - truth) < 4 * found.uncertainties[name]
    _same(whole, [finished[0], growing], rig)


def test_a_wish_is_reached_when_every_uncertainty_is():
    """Oracle: by hand; no wish is never reached."""
    found = LiveEstimate(frames=1, values={"a": 1.0}, uncertainties={"a": 2e-6, "b": 5e-6})
    assert found.reaches({"a": 2e-6})
    assert found.reaches({"a": 3e-6, "b": 5e-6})
    assert not found.reaches({"a": 3e-6, "b": 4e-6})
    assert not found.reaches({"c": 1.0})
    assert not found.reaches({})


def test_a_process_that_dies_is_told_and_nothing_waits_for_it(rig, finished):
    """Oracle: the process killed by its number."""
    with LiveAnalysis(rig.measured) as live:
        os.kill(live._process.pid, signal.SIGKILL)
        live._process.join()
        live.keep(finished[0])
        assert "has ended; the recording goes on without" in live.settled().doubt
        live.grows(finished[0], 1000)
        assert not live.latest.reaches({"trigger_delay": 1.0})

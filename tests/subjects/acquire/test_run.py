"""One recording from the armed camera to the closed file, and every way in which it can end."""

import asyncio
from dataclasses import replace
from time import sleep

import numpy as np
import pytest

from irtiming.acquire.run import NOT_TRUSTED
from irtiming.acquire.run_order import ENOUGH, INTERRUPTED
from irtiming.archive import reader
from irtiming.archive.live.recording import LiveRecording
from irtiming.errors import ArchiveError


def test_a_run_is_recorded(with_blackbody):
    """Oracle: what the devices of the test made: 16 triggers, 16 frames, frame k of trigger k, the wheel's periods."""
    outcome = with_blackbody.recorded()
    assert outcome.ending == "complete"
    assert outcome.is_good
    (made,) = outcome.outcomes
    recording = reader.read(made.path)
    assert recording.frames.shape == (16, 4, 6)
    assert recording.frame_number.tolist() == list(range(16))
    assert recording.frames.pick([5])[0].tolist() == np.random.default_rng(5).integers(1000, 1050, (4, 6)).tolist()
    assert set(np.diff(recording.camera_trigger_ticks)) == {510_000}
    assert set(np.diff(recording.control_slot_ticks)) == {48_000}
    assert recording.control_slot_ticks[0] < recording.camera_trigger_ticks[0] - 900_000
    assert recording.control_slot_ticks[-1] > recording.camera_trigger_ticks[-1] + 900_000
    assert recording.blackbody_temperature_k == 300.0
    assert recording.trigger_delay_time_set_s == 2.5e-3
    assert recording.ending == "complete"
    assert with_blackbody.heard.numbers == list(range(16))


def test_the_camera_is_armed_before_the_generator(laboratory):
    """Oracle: the order in which the devices were spoken to; the first arm is that of the wheel's proof."""
    laboratory.recorded()
    assert laboratory.generator.begun == ["load", "arm", "camera", "arm", "start"]


def test_a_wheel_that_stands_is_started_and_left_turning(with_blackbody):
    """Oracle: what the chopper was asked to do."""
    with_blackbody.recorded()
    assert with_blackbody.chopper.done == ["prepare", "start"]


def test_a_camera_that_does_not_wait_is_refused_before_any_file(laboratory):
    """Oracle: the words, and an empty folder but for the journal."""
    laboratory.camera.free_running = True
    outcome = laboratory.recorded()
    assert "frames before the first trigger: it does not wait for triggers" in outcome.ending
    assert "start" not in laboratory.generator.begun
    assert [path.name for path in laboratory.folder.iterdir()] == ["series.json"]


@pytest.mark.parametrize(
    ("fault", "value", "says"),
    [
        ("extra_after", {4}, "the camera makes frames without triggers"),
        ("frozen", True, "frames equal to the one before"),
        ("missed", {0}, "which were missed cannot be determined"),
    ],
)
def test_a_recording_that_is_in_doubt_says_so(laboratory, fault, value, says):
    """Oracle: the words in the file's ending; nothing that came is thrown away."""
    setattr(laboratory.camera, fault, value)
    (made,) = laboratory.recorded().outcomes
    assert made.ending.startswith(NOT_TRUSTED)
    assert says in made.ending
    assert not made.is_complete
    assert made.verdict.frames >= 15


def test_lost_and_missed_frames_are_told_and_the_others_keep_their_triggers(laboratory):
    """Oracle: trigger 3's frame was lost, trigger 9 made none, the frame of 12 came damaged."""
    laboratory.camera.lost, laboratory.camera.missed, laboratory.camera.damaged = {3}, {9}, {12}
    (made,) = laboratory.recorded().outcomes
    assert made.is_complete
    assert (made.verdict.lost, made.verdict.missed) == (1, 1)
    kept = reader.read(made.path)
    assert kept.frame_number.tolist() == [k for k in range(16) if k not in (3, 9, 12)]


def test_no_frame_at_all_leaves_no_file(laboratory):
    """Oracle: a camera that sleeps through the train; the words."""
    laboratory.camera.missed = set(range(16))
    outcome = laboratory.recorded()
    assert not outcome.is_good
    assert [path.name for path in laboratory.folder.iterdir()] == ["series.json"]


def _long(laboratory):
    """A run of 1280 triggers, 7 s of this computer: something ends it long before."""
    laboratory.runs = (replace(laboratory.runs[0], repeats=80),)
    return laboratory


def _kept(outcome):
    """Frames in the file of the only run, which ended early."""
    (made,) = outcome.outcomes
    recording = reader.read(made.path)
    n = recording.frames.shape[0]
    assert 5 < n < 1280
    assert recording.frame_number.tolist() == list(range(n))
    assert recording.ending == made.ending
    return made


def test_a_person_may_end_it(laboratory):
    """Oracle: what came until then is in the file, all of it."""
    laboratory.heard.leaves = lambda: len(laboratory.heard.numbers) > 20
    outcome = _long(laboratory).recorded()
    assert outcome.ending == INTERRUPTED
    made = _kept(outcome)
    assert made.verdict.frames == made.verdict.triggers == laboratory.camera.sent


def test_a_run_that_is_torn_away_is_no_recording_of_the_series(laboratory):
    """Oracle: the folders; what came is in a file set aside, which nobody can take for a recording whose frames are proven."""

    def torn():
        if len(laboratory.heard.numbers) > 20:
            raise asyncio.CancelledError
        return False

    laboratory.heard.leaves = torn
    with pytest.raises(asyncio.CancelledError):
        _long(laboratory).recorded()
    assert list(laboratory.folder.glob("*.nxs")) == []
    (path,) = laboratory.folder.glob("set-aside/*.nxs")
    with pytest.raises(
        ArchiveError, match=f"{NOT_TRUSTED}broken off before its frames had their triggers: CancelledError"
    ):
        reader.read(path)


def test_it_ends_when_it_is_enough(laboratory):
    """Oracle: a listener that is content with 30 frames."""
    laboratory.heard.enough_after = 30
    outcome = _long(laboratory).recorded()
    assert outcome.ending == ENOUGH
    assert outcome.is_good
    assert _kept(outcome).verdict.frames >= 30


def test_a_camera_that_is_unplugged(laboratory):
    """Oracle: it vanishes after 50 frames, and all of them are in the file.

    Which triggers made them is told by how soon they come: slowly, or a busy computer takes them a trigger late.
    """
    laboratory.generator.speed, laboratory.camera.gone_after = 0.5, 50
    made = _kept(_long(laboratory).recorded())
    assert made.ending == "camera has vanished; plug it in again"
    assert made.verdict.frames == 50


def test_a_camera_that_falls_silent(laboratory):
    """Oracle: no frame after the fiftieth; it is noticed after two seconds of the rig."""
    laboratory.camera.silent_after = 50
    made = _kept(_long(laboratory).recorded())
    assert "camera sent no frame for 2" in made.ending
    assert made.verdict.frames == 50


def test_a_generator_that_is_unplugged(laboratory, monkeypatch):
    """Oracle: it vanishes 1 s after the first trigger; frames and timestamps until then are in the file.

    It is asked so seldom that the watch for the wheel looks several times first: no slot comes any more, nor anything else.
    """
    laboratory.generator.gone_from = 48_000_000
    has_finished = laboratory.generator.has_finished

    async def seldom():
        await asyncio.sleep(0.2)
        return await has_finished()

    monkeypatch.setattr(laboratory.generator, "has_finished", seldom)
    outcome = _long(laboratory).recorded()
    (made,) = outcome.outcomes
    assert "generator has vanished" in made.ending
    assert 80 < made.verdict.frames < 110


def test_a_wheel_that_loses_its_lock(laboratory):
    """Oracle: from 1 s on it takes a tenth longer; seen from its slots while the run goes on."""
    laboratory.generator.slow_from = 48_000_000
    made = _kept(_long(laboratory).recorded())
    assert "the wheel lost its lock: a turn lasted 1" in made.ending
    assert made.verdict.triggers < 250


def test_a_wheel_at_another_speed_never_begins(laboratory, monkeypatch):
    """Oracle: a slot every 1.1 ms where 1 ms is planned; no file, no trigger."""
    monkeypatch.setattr("irtiming.acquire.trigger_train._SETTLING_S", 0.2)
    laboratory.generator.wheel_factor = 1.1
    outcome = laboratory.recorded()
    assert "a control slot passes every 1.1 ms, it must be every 1 ms" in outcome.ending
    assert "start" not in laboratory.generator.begun


def test_a_blackbody_that_leaves_its_temperature(with_blackbody, monkeypatch):
    """Oracle: 0.07 K at each question; the second from the start is beyond 0.1 K."""
    monkeypatch.setattr("irtiming.acquire.temperature._POLL_S", 0.4)
    with_blackbody.blackbody.drift_k = 0.07
    made = _kept(_long(with_blackbody).recorded())
    assert "the blackbody went from" in made.ending


def test_a_disk_that_is_full(laboratory, monkeypatch):
    """Oracle: no room after 40 frames; these are in the file."""
    append = LiveRecording.append_frame

    def full(self, frame, *, frame_number):
        if frame_number >= 40:
            raise ArchiveError(f"{self.part}: the disk is full")
        append(self, frame, frame_number=frame_number)

    monkeypatch.setattr(LiveRecording, "append_frame", full)
    made = _kept(_long(laboratory).recorded())
    assert made.ending.endswith("the disk is full")
    assert reader.read(made.path).frames.shape[0] == 40


def test_a_slow_disk_makes_blanks_not_shifts(laboratory, monkeypatch):
    """Oracle: a queue of two frames and a disk that takes three periods; what is kept has its own trigger's pixels."""
    append = LiveRecording.append_frame

    def slow(self, frame, *, frame_number):
        sleep(0.016)
        append(self, frame, frame_number=frame_number)

    monkeypatch.setattr(LiveRecording, "append_frame", slow)
    monkeypatch.setattr("irtiming.acquire.frame_writer._FEWEST", 2)
    monkeypatch.setattr("irtiming.acquire.frame_writer._QUEUE_BYTES", 1)
    (made,) = laboratory.recorded().outcomes
    assert made.overflowed > 3
    assert made.longest_queue == 2
    assert any("found the queue to the disk full" in finding.what for finding in made.findings)
    kept = reader.read(made.path)
    assert kept.frames.shape[0] == 16 - made.overflowed
    for row, number in enumerate(kept.frame_number):
        expected = np.random.default_rng(number).integers(1000, 1050, (4, 6))
        assert np.array_equal(kept.frames.pick([row])[0], expected)


def test_lost_timestamps_are_not_a_complete_run(laboratory):
    """Oracle: a generator that says that records were lost."""
    laboratory.generator.loses_stamps = True
    (made,) = laboratory.recorded().outcomes
    assert made.ending.startswith(f"{NOT_TRUSTED}timestamps were lost at 1 place")
    with pytest.raises(ArchiveError, match="timestamps were lost"):
        reader.read(made.path)


def test_a_blackbody_that_leaves_its_temperature_at_the_end(with_blackbody, monkeypatch):
    """Oracle: it is not asked during the run, and is 1 K warmer when it is asked after it."""
    monkeypatch.setattr("irtiming.acquire.temperature._POLL_S", 60.0)
    body = with_blackbody.blackbody

    def enough_frames():
        if with_blackbody.heard.numbers and body.temperature_k == 300.0:
            body.temperature_k = 301.0
        return False

    with_blackbody.heard.leaves = enough_frames
    (made,) = with_blackbody.recorded().outcomes
    assert "the blackbody went from 26.85 °C to 27.85 °C" in made.ending


def test_a_temperature_that_came_to_harm_ends_nothing(with_blackbody):
    """Oracle: one answer of a line without check sums has another digit."""
    body, state = with_blackbody.blackbody, with_blackbody.blackbody.state
    answers = []

    async def harmed():
        answers.append(await state())
        return replace(answers[-1], temperature_k=380.0) if len(answers) % 3 == 0 else answers[-1]

    body.state = harmed
    outcome = _long(with_blackbody).recorded()
    assert outcome.ending == "complete"
    assert len(answers) > 6
    assert reader.read(outcome.outcomes[0].path).blackbody_temperature_k == 300.0


def test_a_temperature_that_is_another_each_time_is_refused(with_blackbody):
    """Oracle: the words; no file is made."""
    with_blackbody.blackbody.drift_k = 1.0
    outcome = with_blackbody.recorded()
    assert "wait until it is stable, or see to its line" in outcome.ending
    assert not outcome.outcomes

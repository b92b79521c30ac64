"""Many runs: in order, with references, going on where they were interrupted."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

from irtiming.acquire.references import drift
from irtiming.acquire.run_order import INTERRUPTED
from irtiming.acquire.series import lacks_reference
from irtiming.archive import reader
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.unfinished import claimed
from irtiming.errors import ArchiveError
from irtiming.records.recording import NonuniformityReference
from irtiming.records.series_plan import BlackbodyWishes, CameraWishes, ReferenceWishes, StopWishes


def _names(laboratory):
    return sorted(path.name for path in laboratory.folder.iterdir())


def _journal(laboratory):
    return json.loads((laboratory.folder / "series.json").read_text())


@pytest.fixture
def two_delays(laboratory):
    """A laboratory with two runs, the second 5 ms later."""
    (first,) = laboratory.runs
    laboratory.runs = (first, replace(first, trigger_delay_ticks=360_000))
    return laboratory


def test_runs_are_made_in_order_under_their_names(two_delays):
    """Oracle: the pattern of the names, by hand."""
    outcome = two_delays.recorded()
    assert outcome.is_good
    assert _names(two_delays) == ["Model-7_100Hz_2.5ms_r01.nxs", "Model-7_100Hz_7.5ms_r02.nxs", "series.json"]
    journal = json.loads((two_delays.folder / "series.json").read_text())
    assert [entry["file"] for entry in journal["runs"].values()] == _names(two_delays)[:2]
    assert journal["runs"]["2"]["ending"] == "complete"
    assert journal["events"][-1]["text"] == "ended: complete"


def test_an_interrupted_series_goes_on(two_delays):
    """Oracle: the second run is made when the series is asked for again, the first is not touched; nothing is overwritten."""
    two_delays.heard.leaves = lambda: len(two_delays.heard.numbers) > 20
    short = two_delays.recorded()
    assert short.ending == INTERRUPTED
    assert short.outcomes[1].path == two_delays.folder / "set-aside" / "Model-7_100Hz_7.5ms_r02.nxs"
    assert reader.read(short.outcomes[1].path).ending == INTERRUPTED
    assert _journal(two_delays)["runs"]["2"]["file"] == "set-aside/Model-7_100Hz_7.5ms_r02.nxs"
    first = (two_delays.folder / _names(two_delays)[0]).read_bytes()
    two_delays.heard.leaves = lambda: False
    outcome = two_delays.recorded()
    assert outcome.is_good
    assert outcome.made_before == (1,)
    assert [made.order.number for made in outcome.outcomes] == [2]
    assert _names(two_delays) == [
        "Model-7_100Hz_2.5ms_r01.nxs", "Model-7_100Hz_7.5ms_r02.nxs", "series.json", "set-aside",
    ]  # fmt: skip
    assert (two_delays.folder / _names(two_delays)[0]).read_bytes() == first
    assert two_delays.recorded().outcomes == ()


def test_a_recording_that_was_taken_away_is_made_again(two_delays):
    """Oracle: the run whose file is gone."""
    two_delays.recorded()
    (two_delays.folder / "Model-7_100Hz_2.5ms_r01.nxs").unlink()
    assert [made.order.number for made in two_delays.recorded().outcomes] == [1]


def test_what_a_killed_program_left_is_recovered_and_the_run_repeated(laboratory, monkeypatch):
    """Oracle: a file that was never finished; its frames are in the recovered one, the run is made anew."""
    monkeypatch.setattr(LiveRecording, "finish", _never)
    monkeypatch.setattr(LiveRecording, "__exit__", lambda self, *_: self._close())
    assert "killed" in laboratory.recorded().ending
    assert _names(laboratory) == ["Model-7_100Hz_2.5ms_r01.nxs.part", "series.json"]
    monkeypatch.undo()
    outcome = laboratory.recorded()
    assert outcome.is_good
    assert [path.name for path in outcome.recovered] == ["Model-7_100Hz_2.5ms_r01.nxs"]
    assert outcome.recovered[0].parent == laboratory.folder / "set-aside"
    assert [made.path.name for made in outcome.outcomes] == ["Model-7_100Hz_2.5ms_r01.nxs"]
    with h5py.File(outcome.recovered[0]) as file:
        assert file["entry/instrument/camera/data"].shape[0] == 16
    with pytest.raises(ArchiveError, match="not trusted"):
        reader.read(outcome.recovered[0])


def test_what_cannot_be_recovered_is_set_aside_as_it_is(laboratory):
    """Oracle: a file of which nothing is left is told of once, and its bytes are kept under another name each time."""
    laboratory.folder.mkdir(exist_ok=True)
    part = laboratory.folder / "Model-7_100Hz_2.5ms_r01.nxs.part"
    for name in ("Model-7_100Hz_2.5ms_r01.nxs.part", "Model-7_100Hz_2.5ms_r01-2.nxs.part"):
        part.write_bytes(name.encode())
        laboratory.recorded()
        assert (laboratory.folder / "set-aside" / name).read_bytes() == name.encode()
        assert sum(f"(kept as set-aside/{name})" in text for text in laboratory.heard.sentences) == 1
    assert _names(laboratory) == ["Model-7_100Hz_2.5ms_r01.nxs", "series.json", "set-aside"]


def test_a_file_that_another_program_writes_is_left_alone(laboratory):
    """Oracle: the lock of a recording in progress."""
    laboratory.recorded()
    (whole,) = laboratory.folder.glob("*.nxs")
    part = laboratory.folder / "other.nxs.part"
    part.write_bytes(whole.read_bytes())
    with claimed(part):
        laboratory.recorded()
        assert part.exists()


def _never(self, ended, *, frame_number=None):
    raise ArchiveError("killed")


def test_a_folder_of_another_series_is_refused(laboratory):
    """Oracle: a plan with another integration time."""
    laboratory.recorded()
    camera = CameraWishes(camera_type="photon", integration_time_s=1e-4)
    laboratory.plan = replace(laboratory.plan, camera=camera)
    with pytest.raises(ArchiveError, match="belongs to another series"):
        laboratory.recorded()


def test_a_run_that_fails_ends_the_series(two_delays):
    """Oracle: the first run is in doubt; the second is not begun."""
    two_delays.camera.extra_after = {5}
    outcome = two_delays.recorded()
    assert not outcome.is_good
    assert len(outcome.outcomes) == 1
    assert outcome.ending.startswith(str(two_delays.folder))


def test_the_camera_is_set_as_planned(laboratory):
    """Oracle: 100 us in the unit of SFNC's ExposureTime, and a feature by its name."""
    camera = CameraWishes(camera_type="photon", integration_time_s=1e-4, features=(("TriggerSource", "Line2"),))
    laboratory.plan = replace(laboratory.plan, camera=camera)
    laboratory.recorded()
    assert laboratory.camera.features["ExposureTime"] == "100"
    assert laboratory.camera.features["TriggerSource"] == "Line2"


def test_the_camera_corrects_itself_before_runs_that_begin_so(two_delays):
    """Oracle: the plan's own word on each run; the command was carried out once."""
    first, second = two_delays.runs
    two_delays.runs = (replace(first, is_after_correction=False), replace(second, is_after_correction=True))
    camera = replace(two_delays.plan.camera, correction="Shutter")
    two_delays.plan = replace(two_delays.plan, camera=camera)
    two_delays.camera.features["Shutter"] = ""
    told = []
    set_feature = two_delays.camera.set_feature

    async def noted(name, *, value):
        told.append((name, value))
        return await set_feature(name, value=value)

    two_delays.camera.set_feature = noted
    assert two_delays.recorded().is_good
    assert [each for each in told if each[0] == "Shutter"] == [("Shutter", "execute")]


def test_the_drift_between_two_references_is_told_in_shares_of_the_contrast():
    """Oracle: by hand: all pixels 20 DN up and one in four 40 DN more, at a contrast of 1000 DN."""
    low, shape = np.full((20, 20), 500.0), (20, 20)
    moved = 20.0 + 40.0 * (np.arange(400).reshape(shape) % 4 == 0)
    noise = np.ones(shape)
    made = [
        NonuniformityReference(
            low_dn=low + add, high_dn=low + 1000 + add, low_noise_dn=noise, high_noise_dn=noise, n_frames=50
        )
        for add in (0.0, moved)
    ]
    mean, spread = drift(*made)
    assert mean == pytest.approx(0.02)
    assert spread == pytest.approx(0.04 * np.sqrt(0.25 * 0.75))


def test_each_temperature_has_its_runs(with_blackbody):
    """Oracle: two temperatures and one run are two recordings, each before a stable blackbody."""
    with_blackbody.plan = replace(with_blackbody.plan, blackbody=BlackbodyWishes(temperatures_k=(310.0, 320.0)))
    outcome = with_blackbody.recorded()
    assert outcome.is_good
    assert with_blackbody.blackbody.targets == [310.0, 320.0]
    assert [reader.read(made.path).blackbody_temperature_k for made in outcome.outcomes] == [310.0, 320.0]


def test_a_blackbody_that_never_settles_is_told(with_blackbody):
    """Oracle: the words; no run is begun."""
    wishes = BlackbodyWishes(temperatures_k=(310.0,), settle_within_s=2.0)
    with_blackbody.plan = replace(with_blackbody.plan, blackbody=wishes)
    with_blackbody.blackbody.settling = 10**6
    outcome = with_blackbody.recorded()
    assert "and not stable at 36.85 °C after 2 s" in outcome.ending
    assert outcome.outcomes == ()


def test_the_wheel_is_stopped_where_that_is_wished(with_blackbody):
    """Oracle: the last thing the chopper was asked to do, also after a failure."""
    with_blackbody.plan = replace(with_blackbody.plan, stop=StopWishes(chopper=True))
    with_blackbody.camera.free_running = True
    with_blackbody.recorded()
    assert with_blackbody.chopper.done[-1] == "stop"


@pytest.fixture
def with_references(with_blackbody):
    """Frames of the bare blackbody are wished for; the camera's level follows its temperature."""
    body = with_blackbody.blackbody
    with_blackbody.camera.level_dn = lambda: round(10 * body.temperature_k) - 2000
    with_blackbody.plan = replace(
        with_blackbody.plan, references=ReferenceWishes(low_k=290.0, high_k=330.0, frames=20, when="before")
    )
    return with_blackbody


def test_references_are_recorded_before_the_runs(with_references):
    """Oracle: levels of 900 and 1300 DN plus 25 on average, by construction of the camera; who was asked to step in."""
    (made,) = with_references.recorded().outcomes
    reference = reader.read(made.path).nonuniformity
    assert reference.n_frames == 20
    assert np.mean(reference.low_dn) == pytest.approx(925, abs=5)
    assert np.mean(reference.high_dn) == pytest.approx(1325, abs=5)
    assert (reference.low_temperature_k, reference.high_temperature_k) == (290.0, 330.0)
    assert with_references.heard.attended == ["remove", "insert"]
    assert with_references.blackbody.targets == [290.0, 330.0]


def test_references_after_the_runs_join_their_files(with_references):
    """Oracle: the same levels; the recording is otherwise as it was."""
    plan = with_references.plan
    with_references.plan = replace(plan, references=replace(plan.references, when="after"))
    outcome = with_references.recorded()
    assert outcome.is_good
    recording = reader.read(outcome.outcomes[0].path)
    assert np.mean(recording.nonuniformity.low_dn) == pytest.approx(925, abs=5)
    assert recording.frames.shape[0] == 16
    with h5py.File(outcome.outcomes[0].path) as file:
        assert file["entry/nonuniformity_reference/low"].attrs["temperature"] == 290.0


def test_a_recording_that_cannot_be_read_is_not_one_without_references(with_references, hand_made):
    """Oracle: by hand; a file with references, one without, and one that is no recording, which is refused."""
    (made,) = with_references.recorded().outcomes
    assert not lacks_reference(made.path)
    assert lacks_reference(hand_made(lambda file: file.pop("entry/nonuniformity_reference")))
    made.path.write_bytes(b"no recording")
    with pytest.raises(ArchiveError):
        lacks_reference(made.path)


def test_references_that_alone_are_missing_are_recorded_as_planned(with_references):
    """Oracle: by hand; runs were made at 100 us, the camera was switched to 250 us since, and only the references lack."""
    plan = with_references.plan
    camera = CameraWishes(camera_type="photon", integration_time_s=1e-4)
    with_references.plan = replace(plan, camera=camera, references=replace(plan.references, when="after"))
    assert with_references.recorded().is_good
    (with_references.folder / "references-after.npz").unlink()
    with_references.camera.features["ExposureTime"] = "250"
    assert with_references.recorded().is_good
    assert (with_references.folder / "references-after.npz").exists()
    assert with_references.camera.features["ExposureTime"] == "100"


def test_references_on_both_sides_say_how_far_the_camera_drifted(with_references):
    """Oracle: the journal; both stacks are kept, and a camera that does not drift moves by less than its noise."""
    plan = with_references.plan
    with_references.plan = replace(plan, references=replace(plan.references, when="both"))
    assert with_references.recorded().is_good
    assert {"references-before.npz", "references-after.npz"} <= set(_names(with_references))
    journal = json.loads((with_references.folder / "series.json").read_text())
    (told,) = [event["text"] for event in journal["events"] if "pixels moved by" in event["text"]]
    assert float(told.split("moved by ")[1].split("%")[0]) == pytest.approx(0.0, abs=0.5)


def test_references_are_not_recorded_twice(with_references):
    """Oracle: a series that was interrupted after its references has them in its folder."""
    with_references.heard.leaves = lambda: with_references.heard.attended == ["remove", "insert"]
    assert with_references.recorded().ending == INTERRUPTED
    with_references.heard.leaves = lambda: False
    (made,) = with_references.recorded().outcomes
    assert reader.read(made.path).nonuniformity is not None
    assert with_references.heard.attended == ["remove", "insert"]


def test_references_before_a_wheel_are_refused(with_references):
    """Oracle: a level that does not follow the blackbody: something stands before it."""
    with_references.camera.level_dn = lambda: 1000
    outcome = with_references.recorded()
    assert "take wheel and mask out of the way" in outcome.ending
    assert outcome.outcomes == ()


def test_references_of_an_earlier_recording_are_taken(with_references, tmp_path):
    """Oracle: the frames of the earlier file."""
    (made,) = with_references.recorded().outcomes
    earlier = made.path.rename(tmp_path / "earlier.nxs")
    with_references.plan = replace(with_references.plan, references=ReferenceWishes(file=str(earlier)))
    with_references.folder = tmp_path / "second"
    with_references.folder.mkdir()
    (again,) = with_references.recorded().outcomes
    assert np.array_equal(reader.read(again.path).nonuniformity.low_dn, reader.read(earlier).nonuniformity.low_dn)

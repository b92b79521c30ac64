"""From a simulated camera that runs free to its delay, through its file: the twin and the estimator share no formula."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from irtiming.archive import reader, writer
from irtiming.archive.verify import verify
from irtiming.cli.main import app
from irtiming.errors import ArchiveError, EstimationError
from irtiming.measurement import analyse
from irtiming.records.frame_events import NOUNS
from irtiming.twin import rig as twin
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.scene import paper_scene, with_wheel_speed

SMALL = ("--rows", "48", "--columns", "64", "--frames", "240", "--reference-frames", "10", "--seed", "6")


@pytest.mark.parametrize(("event", "name"), [("strobe", "strobe_delay"), ("arrival", "timestamp_delay")])
def test_the_delay_of_a_free_running_camera_under_its_own_name(event, name, tmp_path):
    """Oracle: truth.json of the twin; 3.5 u leave one chance in 2000. No word of a trigger is left in the result."""
    run = CliRunner().invoke
    made = run(app, ["simulate", str(tmp_path), "--free-running", event, "--lost-frames", "3", *SMALL])
    assert made.exit_code == 0, made.output
    file = str(next(tmp_path.glob("*.nxs")))
    order = ["analyse", file, "--rig", str(tmp_path / "rig.toml"), "--json", str(tmp_path / "result.json")]
    told = run(app, order)
    assert told.exit_code == 0, told.output
    assert name in told.output
    result, truth = (json.loads((tmp_path / file).read_text()) for file in ("result.json", "truth.json"))
    found = result["parameters"][name]
    assert abs(found["value"] - truth[f"{name}_s"]) < 3.5 * found["standard_uncertainty"]
    assert found["standard_uncertainty"] < 150e-6
    assert "trigger" not in found["sign"] + result["headline"] + " ".join(result["parameters"])
    assert result["frame_event"] == event
    jitter = result["inputs"][0]["event"]["jitter"]
    assert sum(jitter["histogram"]["counts"]) == 237
    assert list(jitter["quantiles"]) == ["0.05", "0.5", "0.95", "0.99"]
    explained = run(app, ["explain", str(tmp_path / "result.json")])
    assert NOUNS[event] in explained.output
    assert ("One frame of twenty arrives more than" in explained.output) == (event == "arrival")
    applied = run(app, ["apply", "time", str(tmp_path / "result.json"), file, "--out", str(tmp_path / "times.csv")])
    assert applied.exit_code == 0, applied.output
    assert "times of 237 frames" in applied.output
    looped = run(app, ["latency", "loopback", file, "--line", "camera_input"])
    assert "has no camera_trigger" in str(looped.exception)
    sources = {line["source"]: line["type"] for line in result["contributions"]}
    if event == "arrival":
        assert sources["relation of the computer's clock to the counter"] == "B"
        assert sources["scatter of the frames' stamps"] == "A"


def test_a_file_says_what_its_frames_count_from(tmp_path):
    """Oracle: the recording that was written, field by field; and files that lack what they name."""
    scene = replace(with_wheel_speed(paper_scene(16, 16), 3.0, samples=20), free=FreeRunning(event="stamp"))
    scene = replace(scene, radiance=replace(scene.radiance, reference_frames=2))
    run = twin.simulate(scene, seed=1)
    writer.write(run, tmp_path / "stamp.nxs")
    read = reader.read(tmp_path / "stamp.nxs")
    assert read.frame_event == "stamp"
    assert read.camera_trigger_ticks.size == 0
    for name in ("frame_id", "frame_timestamp_ticks", "counter_exchange_before_s", "counter_exchange_ticks",
                 "camera_exchange_after_s", "camera_exchange_ticks"):  # fmt: skip
        assert (getattr(read, name) == getattr(run, name)).all()
    assert verify(tmp_path / "stamp.nxs")[0].code == "recording-sound"
    for change, words in (
        ({"frame_event": "strobe"}, "camera_input is missing while frame_event is 'strobe'"),
        ({"trigger_delay_time_set_s": 1e-3}, "knows no set delay"),
        ({"camera_exchange_after_s": None}, "not as many entries"),
        ({"counter_exchange_after_s": run.counter_exchange_before_s - 1.0}, "earlier than exchange_before"),
    ):
        with pytest.raises(ArchiveError, match=words):
            writer.write(replace(run, **change), tmp_path / "odd.nxs")


def test_recordings_that_count_from_different_events_are_not_mixed():
    """Oracle: hand-made: a triggered run and one of the strobe."""
    rig = twin.draw(with_wheel_speed(paper_scene(32, 40), 3.0, samples=120), seed=2)
    free = replace(rig.scene, free=FreeRunning(event="strobe"))
    runs = [twin.simulate(scene, seed=k, name=f"run{k}") for k, scene in enumerate((rig.scene, free))]
    with pytest.raises(EstimationError, match="counts from the strobe"):
        analyse(runs, rig.measured)

"""From the recording of a microbolometer camera to its result and report, through the command line."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app
from irtiming.errors import IrTimingError
from irtiming.session.simulation import CameraOrder, SimulationOrder, simulate


@pytest.fixture(scope="module")
def bolo(shared_recordings):
    """Folder with a recording of a microbolometer camera and its truth."""
    folder = shared_recordings / "bolo"
    if not (folder / "truth.json").is_file():
        pytest.skip(f"no truth.json in {folder}")
    return folder


def _analyse(folder, *options, recording="bolo-3Hz-0ms.nxs"):
    words = ["analyse", str(folder / recording), "--rig", str(folder / "rig.toml"), *map(str, options)]
    return CliRunner(env={"COLUMNS": "130"}).invoke(app, words)


@pytest.fixture(scope="module")
def analysed(bolo, tmp_path_factory):
    """Text of the terminal, result and page."""
    folder = tmp_path_factory.mktemp("analysed")
    done = _analyse(bolo, "--json", folder / "result.json", "--report", folder / "report.html")
    assert done.exception is None, done.output
    return done.output, json.loads((folder / "result.json").read_text()), (folder / "report.html").read_text()


def test_the_result_is_the_truth_within_its_uncertainties(analysed, bolo):
    """Oracle: truth.json beside the recording; three of the stated uncertainties, which are not huge.

    The time constant comes within 10 us, the row delay within 0.3 us; the camera of truth.json has no filter.
    """
    _, result, _ = analysed
    truth = json.loads((bolo / "truth.json").read_text())
    assert (result["camera"], result["method"]) == ("microbolometer", "row-sum")
    assert list(result["parameters"]) == ["trigger_delay", "time_constant", "row_delay", "recursive_filter"]
    for name, most_s, off_s in (
        ("trigger_delay", 60e-6, np.inf), ("time_constant", 30e-6, 10e-6), ("row_delay", 0.5e-6, 0.3e-6),
    ):  # fmt: skip
        found = result["parameters"][name]
        assert found["unit"] == "s"
        assert abs(found["value"] - truth[f"{name}_s"]) < min(3 * found["standard_uncertainty"], off_s)
        assert found["standard_uncertainty"] < most_s
    filtered = result["parameters"]["recursive_filter"]
    assert abs(filtered["value"]) < 3.5 * filtered["standard_uncertainty"]
    axle = [result["opening"][f"axle_{name}_px"]["value"] for name in ("row", "column")]
    assert axle == pytest.approx(truth["wheel_centre_row_column_px"], abs=0.05)
    assert set(result["other_method"]["parameters"]) == {"trigger_delay", "time_constant", "row_delay"}


def test_terminal_and_page_say_the_same(analysed):
    """Oracle: verdict first in both, and the three tables of the terminal."""
    text, _, page = analysed
    said = " ".join(text.split())
    assert said.index("Image row 0 is read 2.") < said.index("warning:") < said.index("Timing of the camera")
    for title in ("Timing of the camera", "Uncertainty budget"):
        assert title in text
        assert title in page
    assert page.count("<svg") >= 12
    assert text.count("shutter is closed") == page.count("the shutter is closed") == 2


def test_the_published_method_is_the_result_when_asked_for(tmp_path):
    """Oracle: the result's method, and the other method beside it, of a small simulated recording."""
    small = CameraOrder(camera="microbolometer", rows=48, columns=64)
    made = simulate(SimulationOrder(folder=tmp_path, camera=small, frames=200)).recordings[0]
    done = _analyse(tmp_path, "--method", "published", "--json", tmp_path / "result.json", recording=made)
    assert done.exception is None, done.output
    result = json.loads((tmp_path / "result.json").read_text())
    assert (result["method"], result["other_method"]["method"]) == ("published", "row-sum")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--threshold-dn", "5000"), "--threshold-dn with bolo-3Hz-0ms"),
        (("--slope-limits", "0.1,0.9", "--plateau-margin", "0.2"), "--plateau-margin, --slope-limits with bolo"),
    ],
)
def test_options_of_the_other_camera_are_refused(bolo, options, says):
    """Oracle: one line that names the option; nothing is analysed."""
    done = _analyse(bolo, *options)
    assert isinstance(done.exception, IrTimingError)
    assert says in str(done.exception)
    assert "\n" not in str(done.exception)

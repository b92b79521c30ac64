"""Page, result and terminal of all four cameras: photon or microbolometer, snapshot or rolling."""

import io
import json
from dataclasses import replace

import pytest
from rich.console import Console

from irtiming.archive import result_file
from irtiming.cli.result_table import print_result
from irtiming.records.finding import Finding
from irtiming.report import certificate
from irtiming.report import result as result_of
from irtiming.report.verdict import verdict
from irtiming.session import analysis as session_analysis

FIRST = {
    ("photon", "snapshot"): "The start of integration comes 400 ± 30 µs after the trigger edge that the camera accepts",
    (
        "photon",
        "rolling",
    ): "The start of integration of image row 0 comes 3.000 ± 0.030 ms after the trigger edge that the camera "
    "accepts, each row below it later by 40.00 ± 0.20 µs, by row sums",
    (
        "microbolometer",
        "snapshot",
    ): "The image is read 4.000 ± 0.030 ms after the trigger edge that the camera accepts; a pixel "
    "needs 5.0000 ± 0.0040 ms for 63 % of its response to a step of the scene, by row sums",
    (
        "microbolometer",
        "rolling",
    ): "Image row 0 is read 4.000 ± 0.030 ms after the trigger edge that the camera accepts, each row "
    "below it later by 40.00 ± 0.20 µs; a pixel needs 5.0000 ± 0.0040 ms for 63 % of its response",
}
SECTIONS = {
    ("photon", "snapshot"): {"Exposed fraction and fit"},
    ("photon", "rolling"): {"Exposed fraction and fit", "Row by row"},
    ("microbolometer", "snapshot"): {"Exposed fraction and fit", "Row by row", "Lag and delay"},
    ("microbolometer", "rolling"): {"Exposed fraction and fit", "Row by row", "Lag and delay"},
}
EVERY = ["Result", "Relative delays", "Joint fit", "Uncertainty", "What the camera recorded", "Rig and model"]
EVERY += ["What the wheel did", "Choices, inputs, software"]


def _kind(analysis):
    return analysis.camera_type, analysis.readout_mode


def test_the_verdict_says_what_each_camera_does(any_camera):
    """Oracle: the sentences by hand, from response and readout."""
    assert verdict(any_camera).sentence.startswith(FIRST[_kind(any_camera)])


@pytest.mark.usefixtures("sketched")
def test_each_page_has_the_sections_that_its_camera_has(any_camera):
    """Oracle: the table above; the heading names response and readout."""
    titles = [section.title for section in certificate.sections(any_camera)]
    assert set(titles) == {*EVERY, *SECTIONS[_kind(any_camera)]}
    assert len(titles) == len(set(titles))
    camera, readout = _kind(any_camera)
    assert f"Timing of a {readout} {camera} camera" in certificate.page(any_camera)


def test_each_result_is_what_the_model_of_the_file_says(any_camera, tmp_path):
    """Oracle: the model of the result file, which refuses unknown and missing keys; findings and warnings say the same."""
    found = result_of.result(any_camera)
    result_file.write_result(found, tmp_path / "result.json")
    told = json.loads((tmp_path / "result.json").read_text())
    assert (told["camera"], told["readout_mode"]) == _kind(any_camera)
    assert list(told["parameters"]) == list(any_camera.best.estimate.names)
    assert [one["code"] for one in told["findings"]] == ["made-by-hand"] * 2
    assert [one["what"] for one in told["findings"]][1] == told["warnings"][1]
    for line in told["contributions"]:
        assert list(line["standard_uncertainty"]) == list(told["parameters"])


def test_the_terminal_shows_verdict_parameters_and_budget(any_camera):
    """Oracle: every parameter with its value, in the order of the estimate; nothing is missing."""
    screen = io.StringIO()
    print_result(any_camera, Console(file=screen, width=140))
    text = screen.getvalue()
    places = [text.index(f"\n  {name} ") for name in any_camera.best.estimate.names]
    assert places == sorted(places)
    assert text.index("warning:") < text.index("Timing of the camera") < text.index("Uncertainty budget")


def test_the_terminal_tells_doubts_from_warnings(any_camera):
    """Oracle: by hand; a doubt stands before every warning, under its own word, and the sentence above names it."""
    doubt = Finding(code="edges-disagree", severity="doubt", what="the edges disagree")
    best = replace(any_camera.best, findings=(*any_camera.best.findings, doubt))
    screen = io.StringIO()
    print_result(replace(any_camera, best=best), Console(file=screen, width=140))
    text = " ".join(screen.getvalue().split())
    assert text.index("1 doubt, see below") < text.index("doubt: the edges disagree") < text.index("warning:")


def test_relative_delays_keep_their_own_files(rolling):
    """Oracle: the fixture's files; a result with one entry fewer, or in another order, moves no value to another file."""
    entries = rolling.best.relative_delays
    for kept in (entries, entries[::-1], entries[1:]):
        told = result_of._core(rolling, replace(rolling.best, relative_delays=kept))["relative_delays"]
        assert {one["file"]: one["nominal"] for one in told} == {one.file: one.nominal_s for one in kept}


@pytest.mark.usefixtures("sketched")
def test_a_result_alone_is_the_page_s_and_draws_no_figure(any_camera, tmp_path, monkeypatch):
    """Oracle: what comes with the page; a page would be drawn by what is gone here."""
    with_page = session_analysis.write(any_camera, result=tmp_path / "with.json", report=tmp_path / "page.html")
    monkeypatch.delattr("irtiming.report.sheet.svg")  # after which no page can be made
    assert session_analysis.write(any_camera, result=tmp_path / "alone.json") == with_page
    assert (tmp_path / "alone.json").read_bytes() == (tmp_path / "with.json").read_bytes()

"""`irtiming series`, from results as from the command line."""

import json

import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app
from irtiming.errors import IrTimingError
from results_by_hand import english_words_in, result_by_hand


def _write(folder, name, result):
    path = folder / name
    path.write_text(result.model_dump_json())
    return str(path)


def _run(*arguments):
    done = CliRunner().invoke(app, ["series", *map(str, arguments)], env={"COLUMNS": "200"})
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def test_internal_delays_are_calibrated(tmp_path):
    """Oracle: by hand: delays set in the camera of 0, 25 and 50 us are 1 % too long; errors of the rig cancel."""
    files = [
        _write(tmp_path, f"{set_us}.json",
               result_by_hand(400e-6 + 1.01e-6 * set_us, settings={"internal_delay_set": set_us * 1e-6}))
        for set_us in (0, 25, 50)
    ]  # fmt: skip
    said = _run(*files, "--json", tmp_path / "series.json", "-o", tmp_path / "series.html")
    assert "trigger delay over internal delay set: slope 1.010" in said
    over = json.loads((tmp_path / "series.json").read_text())["cameras"][0]["over_settings"][0]
    assert over["beyond_first"] == pytest.approx([0, 25.25e-6, 50.5e-6])
    assert over["beyond_first_standard_uncertainty"][1:] == pytest.approx([2**0.5 * 0.3e-6] * 2, rel=1e-6)
    page = (tmp_path / "series.html").read_text()
    assert "internal delay" in page
    assert "+0.50" in page


def test_the_page_of_a_series_in_german(tmp_path):
    """Oracle: the same delays by hand, with a comma; the common English words are not on the page."""
    files = [
        _write(tmp_path, f"{set_us}.json",
               result_by_hand(400e-6 + 1.01e-6 * set_us, settings={"internal_delay_set": set_us * 1e-6}))
        for set_us in (0, 25, 50)
    ]  # fmt: skip
    said = _run(*files, "-o", tmp_path / "series.html", "--language", "de")
    assert "slope 1.010" in said
    page = (tmp_path / "series.html").read_text()
    assert "Triggerverzögerung über „eingestellte innere Verzögerung“: Steigung 1,010" in page
    assert "+0,50" in page
    assert english_words_in(page) == set()


def test_what_cannot_be_compared_is_refused(tmp_path):
    """Oracle: by hand: a recording needs rig.toml; one file cannot be read and written."""
    result = _write(tmp_path, "one.json", result_by_hand(400e-6))
    with pytest.raises(IrTimingError, match=r"needs the rig's numbers; give --rig"):
        _run(tmp_path / "one.nxs")
    with pytest.raises(IrTimingError, match="would be overwritten"):
        _run(result, "--json", result)

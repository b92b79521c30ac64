"""The tutorials of the Python interface are run, and print what they say."""

import contextlib
import io
import re
from pathlib import Path

import pytest

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"


def _run(page: str, names: dict[str, object]) -> list[tuple[str, str, str]]:
    """Each block that has an output beneath it: its code, what it printed, what the page says."""
    blocks = re.findall(r"^```(python|text)\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    found, printed, code = [], "", ""
    for language, text in blocks:
        if language == "text":
            found.append((code, printed, text))
            continue
        code, out = text, io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(text, "tutorial", "exec"), names)
        printed = out.getvalue()
    return found


PAGES = ["python-cooled-camera", "python-microbolometer", "python-rolling-photon", "python-snapshot-lag"]


@pytest.mark.parametrize("name", PAGES)
def test_a_tutorial_prints_what_it_says(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: the page itself, block by block; the truth of the simulation is compared on the page."""
    monkeypatch.chdir(tmp_path)
    found = _run((TUTORIALS / f"{name}.md").read_text(), {})
    assert len(found) >= 3
    for code, printed, said in found:
        assert printed == said, code

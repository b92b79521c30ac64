"""The page about running a rig against the program: its messages, its endings, its commands."""

import ast
import re
import runpy
from pathlib import Path

import pytest

from irtiming.acquire.run_order import ENOUGH, INTERRUPTED
from irtiming.archive.layout import NOT_TRUSTED
from irtiming.archive.live.recording import COMPLETE

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "how-to" / "run-your-rig.md").read_text()


def _texts():
    """Every text of the program, with an ellipsis for each value that is put into it."""
    in_place_of = runpy.run_path(str(ROOT / "scripts" / "findings-reference"))["in_place_of"]
    for path in (ROOT / "src" / "irtiming").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.JoinedStr):
                yield "".join(str(v.value) if isinstance(v, ast.Constant) else in_place_of(v) for v in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value


@pytest.fixture(scope="module")
def texts():
    """Every text of the program."""
    return list(_texts())


def test_every_message_on_the_page_is_one_of_the_program(texts):
    """Oracle: the texts in the source, values left out; what is and what to do may be two texts of one finding."""
    quoted = re.findall(r"^\| `([^`]+)` \|", PAGE.split("## 6.")[1], flags=re.MULTILINE)
    assert len(quoted) > 40
    parts = [part for message in quoted for part in message.split("; ")]
    assert [part for part in parts if not any(part in text for text in texts)] == []


def test_every_ending_on_the_page_is_one_of_the_program():
    """Oracle: the constants of the program."""
    endings = re.findall(r"^\| `([^`]+)` \|", PAGE.split("## 5.")[1].split("## 6.")[0], flags=re.MULTILINE)
    assert endings == [COMPLETE, ENOUGH, INTERRUPTED, f"{NOT_TRUSTED}…"]

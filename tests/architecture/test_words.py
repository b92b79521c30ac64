"""Words that people read: pages, messages, help and schemas say what is determined, reported, found or unknown."""

import ast
import re
from pathlib import Path

import pytest
from syntax import nodes

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "irtiming"
SCHEMAS = sorted((SOURCE / "archive" / "schemas").glob("*.json"))
INSTEAD = {
    "told": "distinguished, determined, reported, stated or recognised",
    "seen": "found, recorded, observed, visible or shown",
    "nobody": "unknown, not stated, not measured, or no one",
    "grow sure": "the uncertainty shrinks",
    "grows sure": "the uncertainty shrinks",
}
# A word within a code, such as no-lag-seen, is part of a name that never changes.
WORDS = re.compile(rf"(?<![\w-])({'|'.join(INSTEAD)})(?![\w-])", flags=re.IGNORECASE)


def _pages() -> list[Path]:
    """Pages for those who use the program; decisions are history."""
    below = [page for page in sorted((ROOT / "docs").rglob("*.md")) if "decisions" not in page.parts]
    return [ROOT / "README.md", ROOT / "SECURITY.md", *below, *sorted((ROOT / "news").glob("*.md")), *SCHEMAS]


def _docstrings(path: Path) -> set[ast.expr]:
    """Texts that stand alone: those of commands are read on the page of the command line, the others by developers."""
    bodies = [body for node in nodes(path) if isinstance(body := getattr(node, "body", None), list)]
    return {one.value for body in bodies for one in body if isinstance(one, ast.Expr)}


def _complaints(text: str, *, where: str) -> list[str]:
    return [
        f"{where}: {found[0]!r} in {_around(text, found)!r}: say {INSTEAD[found[0].lower()]}"
        for found in WORDS.finditer(text)
    ]


def _around(text: str, found: re.Match[str]) -> str:
    return " ".join(text[max(0, found.start() - 40) : found.end() + 40].split())


@pytest.mark.parametrize("page", _pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_uses_the_words_of_the_field(page):
    """Oracle: the list of words above, each with what to say instead."""
    assert _complaints(page.read_text(), where=str(page.relative_to(ROOT))) == []


def test_texts_of_the_program_use_the_words_of_the_field():
    """Oracle: the same list; a text has a space, which names and keys have not."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        docstrings = _docstrings(path)
        texts = [node for node in nodes(path) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
        for text in (one for one in texts if one not in docstrings and " " in one.value):
            found += _complaints(text.value, where=f"{path.relative_to(ROOT)}:{text.lineno}")
    assert found == []

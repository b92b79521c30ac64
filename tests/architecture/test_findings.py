"""Findings: each kind has one code, written once, and the page of the codes is current."""

import re
import runpy
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

from irtiming.report.catalogue import entries

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "findings-reference"


@cache
def _codes() -> dict[str, object]:
    """What stands for the code at each place that makes a finding; a place that hands its caller's code on is left out."""
    names = runpy.run_path(str(SCRIPT))
    found = {}
    for path, call, inside in names["sites"]():
        if not names["is_passed_on"](call, inside):
            code = names["argument"](call, "code")
            found[f"{path.relative_to(ROOT)}:{call.lineno}"] = getattr(code, "value", None)
    return found


def test_every_finding_is_made_with_a_code_in_plain_text():
    """Oracle: the syntax tree; a program asks for a code, and a person looks it up, so it is written out, kebab-case."""
    found = _codes()
    assert len(found) > 80
    wrong = {
        place: code
        for place, code in found.items()
        if not (isinstance(code, str) and re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", code))
    }
    assert wrong == {}


def test_each_code_is_written_at_one_place():
    """Oracle: the syntax tree; two meanings never share a code, and two places that find the same share a function."""
    assert [code for code, times in Counter(_codes().values()).items() if times > 1] == []


def test_every_finding_that_a_result_can_have_is_told_in_german():
    """Oracle: the page of the codes; what is an error ends a command, and never stands in a certificate."""
    page = (ROOT / "docs" / "reference" / "findings.md").read_text()
    rows = re.findall(r"^\| `([a-z0-9-]+)` \| ([a-z ]+) \|", page, flags=re.MULTILINE)
    told = {code for code, severity in rows if severity not in ("error", "ok")}
    german = {code: one.translations[0] for (context, code), one in entries("de").items() if context == "finding"}
    assert len(told) > 80
    assert sorted(told - set(german)) == []
    assert sorted(set(german) - told) == []
    assert [code for code, text in german.items() if not text.strip() or text.endswith(".")] == []


def test_the_page_of_the_findings_lists_every_code():
    """Oracle: the source; if this fails, run scripts/findings-reference > docs/reference/findings.md."""
    made = subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, timeout=60, check=True).stdout
    assert (ROOT / "docs" / "reference" / "findings.md").read_text() == made

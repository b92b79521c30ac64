"""Files that the pages write, and work that they name."""

import ast
import re
import tomllib
from pathlib import Path

from irtiming.archive.certificate_file import read_certificate_file
from irtiming.web.certificate_form import FIELDS, MORE, as_toml, rest_of

ROOT = Path(__file__).parents[3]
WEB = ROOT / "src" / "irtiming" / "web"


def test_the_form_writes_a_certificate_file_whatever_is_typed(tmp_path):
    """Oracle: the reader of certificate.toml, and the text that was typed."""
    values = {one.name: 'a "quoted" \\ Müller\t]' for group in FIELDS.values() for one in group}
    values |= {"laboratory.country": "DE", "customer.country": "AT", "certificate.language": "de", "person.role": " "}
    values["certificate.issued"] = "2026-11-23"
    path = tmp_path / "certificate.toml"
    path.write_text(as_toml(values, MORE), encoding="utf-8")
    found = read_certificate_file(path)
    assert found.laboratory.street == 'a "quoted" \\ Müller ]'  # a tab is a blank on paper
    assert (found.customer.country, found.certificate.language, found.person[0].role) == ("AT", "de", None)


def test_what_the_page_has_no_field_for_is_kept():
    """Oracle: the example file read by the standard library, without what the page has fields for."""
    text = (ROOT / "examples" / "certificate.toml").read_text()
    kept, whole = tomllib.loads(rest_of(text)), tomllib.loads(text)
    wanted = {name: content for name, content in whole.items() if name not in ("certificate", "laboratory", "customer")}
    assert kept == wanted | {"person": whole["person"][1:]}


def test_all_work_that_the_pages_name_is_there():
    """Oracle: the syntax tree of the tasks; a page names its work in text, so that the server loads nothing of it."""
    named = {task for path in WEB.rglob("*.py") for task in re.findall(r'"([a-z_]+:[a-z_]+)"', path.read_text())}
    there = {
        f"{path.stem}:{node.name}"
        for path in (WEB / "tasks").glob("*.py")
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.FunctionDef)
    }
    assert len(named) > 10
    assert named <= there

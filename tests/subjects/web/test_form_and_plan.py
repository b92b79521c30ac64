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
    own = {one.name for group in FIELDS.values() for one in group}
    for name in ("certificate", "laboratory", "customer"):
        beside = {key: said for key, said in whole.pop(name).items() if f"{name}.{key}" not in own}
        assert kept.pop(name, {}) == beside
    first, *others = whole.pop("person")
    beside = {key: said for key, said in first.items() if f"person.{key}" not in own}
    assert kept.pop("person", []) == [*([beside] if beside else []), *others]
    assert kept == whole


def test_an_earlier_form_taken_over_is_the_same_but_for_what_is_of_one_certificate():
    """Oracle: a law; a file with keys beside the fields, two persons and lines of several kinds, read by the standard library."""
    address = 'name = "N"\nstreet = "S"\npostcode = "1"\ncity = "C"\ncountry = "DE"\nemail = "a@b"\n'
    text = (
        '[certificate]\nnumber = "1"\nissued = 2026-01-01\nlanguage = "en"\nreplaces = "0"\namendment = "the address"\n'
        'remarks = [\n  "at the customer\'s",  # as agreed\n  "number = 7"\n]\n'
        f'[laboratory]\n{address}accreditation = "D-K-1"\naccreditation_body = "DAkkS"\n[customer]\n{address}phone = "+49"\n'
        '[[person]]\nname = "P"\nemail = "p@b"\nrole = "head"\n[[person]]\nname = "Q"\nsigns = false\n[place]\nname = "lab"\n'
    )
    whole = tomllib.loads(text)
    tables = whole | {"person": whole["person"][0]}
    values = {one.name: str(tables[one.section].get(one.key, "")) for group in FIELDS.values() for one in group}
    del whole["certificate"]["replaces"], whole["certificate"]["amendment"]
    assert tomllib.loads(as_toml(values, rest_of(text))) == whole


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

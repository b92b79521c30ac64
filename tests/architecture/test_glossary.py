"""The page of definitions against the records."""

import ast
import re
from pathlib import Path

import pytest
from syntax import tree

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "explanation" / "definitions.md"
BASES = ("NamedTuple",)


def _is_record(node: ast.AST) -> bool:
    if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
        return False
    decorators = [ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list]
    return "dataclass" in decorators or any(ast.unparse(base) in BASES for base in node.bases)


def _records() -> dict[str, list[str]]:
    """Every public record and its public fields, from the source."""
    found = {}
    for path in sorted((ROOT / "src" / "irtiming" / "records").glob("*.py")):
        for node in filter(_is_record, tree(path).body):
            names = [part.target.id for part in node.body if isinstance(part, ast.AnnAssign)]
            found[node.name] = [name for name in names if not name.startswith("_")]
    return found


def _sections() -> dict[str, list[str]]:
    """Every record that the page describes, and the fields in its table."""
    parts = re.split(r"^### `(\w+)`$", PAGE.read_text(), flags=re.MULTILINE)[1:]
    tables = zip(parts[::2], parts[1::2], strict=True)
    return {name: re.findall(r"^\| `(\w+)` \|", text.split("\n## ")[0], flags=re.MULTILINE) for name, text in tables}


@pytest.mark.parametrize("record", sorted(_records()))
def test_each_field_of_a_record_is_defined(record):
    """Oracle: the syntax tree of the records, field by field in their order."""
    assert _sections().get(record) == _records()[record]


def test_no_record_is_defined_that_is_gone():
    """Oracle: the syntax tree of the records."""
    assert sorted(_sections()) == sorted(_records())

"""Rules of the house that a machine can check."""

import ast
from collections.abc import Iterator
from pathlib import Path

from syntax import functions, nodes, tree

import irtiming

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src" / "irtiming").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("test_*.py"))
HOMES = {
    "GTC": "report",
    "astropy": "archive",
    "av": "archive",
    "dask": "distribute",
    "distributed": "distribute",
    "sqlalchemy": "archive",
    "fasthcc": "archive",
    "imagecodecs": "archive",
    "tifffile": "archive",
    "genicam": "instruments",
    "h5py": "archive",
    "hdf5plugin": "archive",
    "tomllib": "archive",
    "matplotlib": "report",
    "nicegui": "web",
    "fastapi": "web",
    "uvicorn": "web",
    "PIL": "web",
    "jinja2": "report",
    "pyGigEVision": "instruments",
    "pyarrow": "archive",
    "pydantic": "archive",
    "pydantic_core": "archive",
    "pymeasure": "instruments",
    "pyvisa": "instruments",
    "rich": "cli",
    "serial": "instruments",
    "typer": "cli",
    "uncertainties": "report",
    "vcd": "archive",
    "weasyprint": "report",
}
COMMANDS = (
    "plan",
    "simulate",
    "verify",
    "calibrate_wheel",
    "clock",
    "gates",
    "loopback",
    "analyse",
    "certificate",
    "time",
    "frames",
    "export",
    "import_capture",
    "export_vcd",
    "info",
    "convert",
    "demo",
    "build",
    "firmware",
    "identify",
    "record",
    "combine",
    "discover",
    "camera",
    "doctor",
    "recover",
    "rig",
    "serve",
    "campaign",
    "history",
    "series",
)
LONGEST_FILE, LONGEST_FUNCTION, MOST_PARAMETERS, MOST_POSITIONAL = 450, 60, 6, 2
ONE_SCREEN = 150


def _folder(path: Path) -> str:
    return path.relative_to(ROOT / "src" / "irtiming").parts[0]


def _imported(path: Path) -> set[str]:
    names = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def test_the_story_is_one_screen():
    """Oracle: the lines of measurement.py."""
    assert len((ROOT / "src" / "irtiming" / "measurement.py").read_text().splitlines()) <= ONE_SCREEN


def test_each_library_has_one_home():
    """Oracle: the table HOMES; a file format, a plot library or a terminal has one folder that knows it."""
    strays = [
        f"{_name(path)} imports {name}, which lives in {HOMES[name]}"
        for path in SOURCES
        for name in sorted(_imported(path))
        if name in HOMES and HOMES[name] != _folder(path)
    ]
    assert strays == []


def test_files_keep_their_budget():
    """Oracle: the budget at the top of this file."""
    lines = {_name(path): len(path.read_text().splitlines()) for path in SOURCES}
    assert {name: count for name, count in lines.items() if count > LONGEST_FILE} == {}


def test_functions_keep_their_budgets():
    """Oracle: the budgets at the top of this file. Command-line functions list their options as parameters."""
    assert [complaint for path in SOURCES for one in functions(path) for complaint in _over_budget(path, one)] == []


def _over_budget(path: Path, function: ast.FunctionDef) -> Iterator[str]:
    where = f"{_name(path)}:{function.lineno} {function.name}"
    args = function.args
    positional = [a.arg for a in args.posonlyargs + args.args if a.arg not in ("self", "cls")]
    body = (function.end_lineno or 0) - function.lineno + 1
    if _folder(path) == "cli" and function.name in COMMANDS:
        return
    if body > LONGEST_FUNCTION:
        yield f"{where}: {body} lines"
    if len(positional) + len(args.kwonlyargs) > MOST_PARAMETERS:
        yield f"{where}: too many parameters"
    is_public = not function.name.startswith("_") and path.name not in ("kernels.py", "array_kernels.py", "progress.py")
    if is_public and len(positional) > MOST_POSITIONAL:
        yield f"{where}: {positional} may be given by position"


def test_public_functions_are_documented_and_annotated():
    """Oracle: the syntax tree; a public function has a docstring, and every parameter and result a type."""
    assert [complaint for path in SOURCES for one in functions(path) for complaint in _undocumented(path, one)] == []


def _undocumented(path: Path, function: ast.FunctionDef) -> Iterator[str]:
    if function.name.startswith("_"):
        return
    where = f"{_name(path)}:{function.lineno} {function.name}"
    parameters = [a for a in function.args.args + function.args.kwonlyargs if a.arg not in ("self", "cls")]
    if not all(a.annotation for a in parameters):
        yield f"{where}: a parameter without type"
    if function.returns is None:
        yield f"{where}: no result type"
    if not ast.get_docstring(function):
        yield f"{where}: no docstring"


def test_folders_do_nothing_when_imported():
    """Oracle: every __init__ below the top one is empty, so a driver reads one file without loading a stage."""
    assert [
        _name(p) for p in SOURCES if p.name == "__init__.py" and p.parent.name != "irtiming" and p.read_text()
    ] == []


def test_top_names_are_sorted_and_exist():
    """Oracle: __all__ itself."""
    assert irtiming.__all__ == sorted(irtiming.__all__)
    assert all(hasattr(irtiming, name) for name in irtiming.__all__)


def test_every_test_names_its_oracle_and_every_function_is_a_test():
    """Oracle: the syntax tree; a check whose name lacks test_ would never run, one without docstring has no oracle."""
    assert [complaint for path in TESTS for complaint in _no_test(path)] == []


def _no_test(path: Path) -> Iterator[str]:
    for function in tree(path).body:
        if not isinstance(function, ast.FunctionDef):
            continue
        fixture = any("fixture" in ast.unparse(d) or "composite" in ast.unparse(d) for d in function.decorator_list)
        where = f"{_name(path)}:{function.lineno} {function.name}"
        if not fixture and not function.name.startswith(("test_", "_")):
            yield f"{where}: neither test, fixture nor private"
        if function.name.startswith("test_") and not ast.get_docstring(function):
            yield f"{where}: no oracle named"


def test_no_two_test_files_have_one_name():
    """Oracle: the names; pytest imports each file by its own, and refuses a second one."""
    names = [path.name for path in TESTS]
    assert sorted({name for name in names if names.count(name) > 1}) == []


def test_nothing_points_outside_the_project():
    """Oracle: a search of the tracked text for paths and hosts that mean nothing to a user."""
    forbidden = ("../" + "shared", "/wo" + "rk/", "pypi" + ".org", "files.python" + "hosted")
    for path in [*SOURCES, ROOT / "README.md", ROOT / "Makefile", *(ROOT / "docs").rglob("*.md")]:
        text = path.read_text()
        assert not [word for word in forbidden if word in text], _name(path)

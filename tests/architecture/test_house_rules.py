"""Rules of the house that a machine can check."""

import ast
from pathlib import Path

import pytest

import irtiming

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src" / "irtiming").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("test_*.py"))
HOMES = {
    "GTC": "report",
    "astropy": "archive",
    "av": "archive",
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
)
LONGEST_FILE, LONGEST_FUNCTION, MOST_PARAMETERS, MOST_POSITIONAL = 450, 60, 6, 2


def _folder(path: Path) -> str:
    return path.relative_to(ROOT / "src" / "irtiming").parts[0]


def _functions(path: Path) -> list[ast.FunctionDef]:
    """Functions of the module and methods of its public classes; a function inside a function is part of that one."""
    body = ast.parse(path.read_text()).body
    classes = [node for node in body if isinstance(node, ast.ClassDef)]
    methods = [method for owner in classes if not owner.name.startswith("_") for method in owner.body]
    return [node for node in [*body, *methods] if isinstance(node, ast.FunctionDef)]


def _imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_each_library_has_one_home(path):
    """Oracle: the table HOMES; a file format, a plot library or a terminal has one folder that knows it."""
    strays = {name: HOMES[name] for name in _imported(path) if name in HOMES and HOMES[name] != _folder(path)}
    assert not strays, f"{_name(path)} imports {list(strays)}; they live in {list(strays.values())}"


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_files_and_functions_keep_their_budgets(path):
    """Oracle: the budgets at the top of this file. Command-line functions list their options as parameters."""
    assert len(path.read_text().splitlines()) <= LONGEST_FILE
    for function in _functions(path):
        where = f"{_name(path)}:{function.lineno} {function.name}"
        args = function.args
        positional = [a.arg for a in args.posonlyargs + args.args if a.arg not in ("self", "cls")]
        body = (function.end_lineno or 0) - function.lineno + 1
        if _folder(path) == "cli" and function.name in COMMANDS:
            continue
        assert body <= LONGEST_FUNCTION, f"{where}: {body} lines"
        assert len(positional) + len(args.kwonlyargs) <= MOST_PARAMETERS, f"{where}: too many parameters"
        if not function.name.startswith("_") and path.name not in ("kernels.py", "progress.py"):
            assert len(positional) <= MOST_POSITIONAL, f"{where}: {positional} may be given by position"


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_public_functions_are_documented_and_annotated(path):
    """Oracle: the syntax tree; a public function has a docstring, and every parameter and result a type."""
    for function in _functions(path):
        if function.name.startswith("_"):
            continue
        where = f"{_name(path)}:{function.lineno} {function.name}"
        parameters = [a for a in function.args.args + function.args.kwonlyargs if a.arg not in ("self", "cls")]
        assert all(a.annotation for a in parameters), f"{where}: a parameter without type"
        assert function.returns is not None, f"{where}: no result type"
        assert ast.get_docstring(function), f"{where}: no docstring"


def test_folders_do_nothing_when_imported():
    """Oracle: every __init__ below the top one is empty, so a driver reads one file without loading a stage."""
    assert [
        _name(p) for p in SOURCES if p.name == "__init__.py" and p.parent.name != "irtiming" and p.read_text()
    ] == []


def test_top_names_are_sorted_and_exist():
    """Oracle: __all__ itself."""
    assert irtiming.__all__ == sorted(irtiming.__all__)
    assert all(hasattr(irtiming, name) for name in irtiming.__all__)


@pytest.mark.parametrize("path", TESTS, ids=_name)
def test_every_test_names_its_oracle_and_every_function_is_a_test(path):
    """Oracle: the syntax tree; a check whose name lacks test_ would never run, one without docstring has no oracle."""
    for function in ast.parse(path.read_text()).body:
        if not isinstance(function, ast.FunctionDef):
            continue
        fixture = any("fixture" in ast.unparse(d) or "composite" in ast.unparse(d) for d in function.decorator_list)
        where = f"{_name(path)}:{function.lineno} {function.name}"
        assert fixture or function.name.startswith(("test_", "_")), f"{where}: neither test, fixture nor private"
        if function.name.startswith("test_"):
            assert ast.get_docstring(function), f"{where}: no oracle named"


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

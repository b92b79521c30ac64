"""The microcontroller's firmware as files: complete, handed out as it is, and described as it is."""

import ast
import fnmatch
import re
import sys
import tomllib
from pathlib import Path

import pytest
from emulated_pico import FIRMWARE, MODULES, PINS
from typer.testing import CliRunner

from irtiming.cli.gateware_firmware_command import firmware
from irtiming.errors import ArchiveError
from irtiming.gateware.firmware_files import firmware_files
from irtiming.session.firmware import write_firmware

ROOT = Path(__file__).parents[2]
MICROPYTHON_ONLY = {"machine", "micropython", "rp2", "uctypes"}
README = (FIRMWARE / "README.md").read_text()


def _imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


def _pins():
    """What main.py calls PINS; the file itself cannot be imported here."""
    (value,) = (
        node.value
        for node in ast.parse((FIRMWARE / "main.py").read_text()).body
        if isinstance(node, ast.Assign) and node.targets[0].id == "PINS"
    )
    return ast.literal_eval(value)


def test_what_is_written_is_what_the_package_holds(tmp_path):
    """Oracle: the files themselves; a second time changes nothing and complains of nothing."""
    for _ in range(2):
        written = write_firmware(tmp_path / "made" / "pico")
        assert {path.name: path.read_bytes() for path in written} == {
            path.name: path.read_bytes() for path in FIRMWARE.iterdir() if path.is_file()
        }
    assert {path.stem for path in written if path.suffix == ".py"} == set(MODULES)


def test_files_of_somebody_are_not_overwritten(tmp_path):
    """Oracle: by hand; the message names the file, and nothing else was written."""
    (tmp_path / "main.py").write_text("PINS = {}")
    with pytest.raises(ArchiveError, match=r"main\.py: is there and differs; .* name a new folder"):
        write_firmware(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["main.py"]


def test_a_place_that_cannot_be_is_refused_in_one_line(tmp_path):
    """Oracle: by hand; a file stands where the folder should be."""
    (tmp_path / "file").write_text("")
    with pytest.raises(ArchiveError, match="cannot be made .*; give another folder"):
        write_firmware(tmp_path / "file" / "pico")


def test_the_command_lists_what_it_wrote(tmp_path):
    """Oracle: names of the files."""
    import typer

    app = typer.Typer()
    app.command()(firmware)
    result = CliRunner().invoke(app, ["--into", str(tmp_path / "pico")])
    assert result.exit_code == 0, result.output
    assert {Path(line).name for line in result.output.splitlines()} == set(firmware_files())


def test_an_installed_package_has_the_files():
    """Oracle: the patterns of the package's data in pyproject.toml."""
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]["irtiming"]
    for name in firmware_files():
        assert any(fnmatch.fnmatch(f"gateware/microcontroller/{name}", pattern) for pattern in patterns), name
    assert not (FIRMWARE / "__init__.py").exists()  # files for a board, no package for this computer


@pytest.mark.parametrize("path", sorted(FIRMWARE.glob("*.py")), ids=lambda path: path.name)
def test_the_firmware_imports_itself_micropython_and_nothing_else(path):
    """Oracle: the syntax tree; names of the firmware's files, of MicroPython, and of the standard library that it has."""
    allowed = set(MODULES) | MICROPYTHON_ONLY | {"array", "collections", "gc", "select", "struct", "sys", "time"}
    assert set(_imports(path)) <= allowed
    assert {"array", "collections", "select", "struct"} <= sys.stdlib_module_names


def test_the_readme_names_every_file_and_every_pin():
    """Oracle: the folder, and PINS of main.py, which the tests' emulated board has too."""
    assert _pins() == PINS
    rows = re.findall(r"^\| GP(\d+) \| \d+ \| `(\w+)`", README, flags=re.MULTILINE)
    assert {name: int(number) for number, name in rows} == PINS
    assert set(re.findall(r"^\| `([\w.]+)` \|", README, flags=re.MULTILINE)) == {
        path.name for path in FIRMWARE.iterdir() if path.suffix in (".py", ".pio")
    }


def test_the_readme_names_the_clocks_that_the_firmware_sets():
    """Oracle: the two clocks in chip.py, two cycles to a count, both divisible by 3000."""
    clocks = [
        int(number.replace("_", "")) for number in re.findall(r"1[25]0_000_000", (FIRMWARE / "chip.py").read_text())
    ]
    assert sorted(clocks) == [120_000_000, 150_000_000]
    for clock in clocks:
        assert clock % 3000 == 0
        counts = f"{clock // 2:,}".replace(",", " ")
        assert counts in README
        assert f"{2e9 / clock:.2f} ns" in README

"""What every command has in common: help, version, JSON on the standard output, counting."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from irtiming.archive.json_file import require_place, write_json
from irtiming.cli.main import app
from irtiming.errors import EstimationError
from irtiming.records.choices import Choices
from irtiming.units import counted


def _commands() -> list[list[str]]:
    """Every command and group, as they are typed."""
    found: list[list[str]] = [[]]
    for name, command in typer.main.get_command(app).commands.items():
        found.append([name])
        found += [[name, part] for part in getattr(command, "commands", {})]
    return found


def _run(*options: object, **more: object) -> subprocess.CompletedProcess[str]:
    arguments = [sys.executable, "-m", "irtiming", *map(str, options)]
    return subprocess.run(arguments, capture_output=True, text=True, check=False, timeout=120, **more)


@pytest.mark.parametrize("command", _commands(), ids=" ".join)
def test_every_command_has_its_whole_help_at_h(command: list[str]) -> None:
    """Oracle: --help; brackets of sections in plan.toml and rig.toml are text, not markup that vanishes."""
    short, long = (CliRunner().invoke(app, [*command, option]) for option in ("-h", "--help"))
    assert (short.exit_code, short.output) == (0, long.output)
    assert "irtiming" in short.output or "Usage" in short.output
    if command == ["record"]:
        assert "[stop]" in short.output


def test_the_version_is_that_of_the_package() -> None:
    """Oracle: the metadata of the installed package."""
    done = CliRunner().invoke(app, ["--version"])
    assert (done.exit_code, done.output) == (0, f"irtiming {metadata.version('irtiming')}\n")
    assert CliRunner().invoke(app, ["doctor", "--version"]).exit_code == 2


def test_json_on_the_standard_output_is_json_alone(tmp_path: Path) -> None:
    """Oracle: a JSON parser; what people are told goes to standard error, and no file is made."""
    wishes = ("--clock-hz", "49152000", "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "1000")
    done = _run("plan", *wishes, "--json", "-", cwd=tmp_path)
    assert done.returncode == 0
    assert json.loads(done.stdout)["clock_frequency_hz"] == 49_152_000
    assert "Sampling order" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_json_goes_to_the_standard_output_that_was(capfd: pytest.CaptureFixture[str]) -> None:
    """Oracle: the words that are printed meanwhile come out at the other end."""
    with contextlib.redirect_stdout(sys.stderr):
        write_json({"a": 1}, "-")
        require_place("-")
        print("words")
    assert tuple(capfd.readouterr()) == ('{\n "a": 1\n}\n', "words\n")


@pytest.mark.parametrize(
    "command",
    [
        "convert by-hand.nxs there.nxs",
        "convert by-hand.nxs there.npy",
        "apply time result.json by-hand.nxs --out there.nxs",
        "apply frames result.json by-hand.nxs there.nxs",
        "export-vcd by-hand.nxs --out there.vcd",
        "import-capture ticks.vcd --map camera_trigger=D0 --frames by-hand.nxs --out there.nxs",
        "gateware record PORT --plan plan.json --out there.nxs",
        "gateware combine stamps.nxs by-hand.nxs --out there.nxs",
        "recover killed.nxs.part --out there.nxs",
    ],
)
def test_recordings_and_what_is_made_of_them_replace_nothing(
    hand_made: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """Oracle: the bytes of a file of that name before and after, and the one message; the other inputs are not even there."""
    hand_made()
    monkeypatch.chdir(tmp_path)
    words = command.split()
    place = next(Path(word) for word in words if word.startswith("there"))
    place.write_bytes(b"mine")
    assert str(CliRunner().invoke(app, words).exception) == f"{place}: exists already; choose another name"
    assert place.read_bytes() == b"mine"


def test_a_simulation_replaces_only_when_it_is_told_to(tmp_path: Path) -> None:
    """Oracle: a file of the recording's name, left alone, then replaced with --force; one recording is one recording."""
    (tmp_path / "bolo-3Hz-0ms.nxs").write_bytes(b"mine")
    command = [
        "simulate",
        str(tmp_path),
        *["--camera", "microbolometer", "--rows", "16", "--columns", "16", "--frames", "20"],
    ]
    assert "exists already" in str(CliRunner().invoke(app, command).exception)
    assert (tmp_path / "bolo-3Hz-0ms.nxs").read_bytes() == b"mine"
    done = CliRunner().invoke(app, [*command, "--force"])
    assert done.output.splitlines()[-1].startswith("1 recording, rig.toml and truth.json in")


def test_a_simulation_of_another_rig_leaves_a_folder_as_it_is(tmp_path: Path) -> None:
    """Oracle: the bytes of rig.toml and truth.json; the same rig at another speed goes in beside, another rig does not."""
    command = ["simulate", str(tmp_path), *["--rows", "16", "--columns", "16", "--frames", "20"]]
    assert CliRunner().invoke(app, command).exit_code == 0
    before = [(tmp_path / name).read_bytes() for name in ("rig.toml", "truth.json")]
    refused = CliRunner().invoke(app, [*command, "--seed", "2"])
    assert "tells of another simulated rig" in str(refused.exception)
    assert "--force" in str(refused.exception)
    assert [(tmp_path / name).read_bytes() for name in ("rig.toml", "truth.json")] == before
    assert CliRunner().invoke(app, [*command, "--wheel-hz", "5"]).exit_code == 0


def test_methods_are_called_as_results_call_them(hand_made) -> None:
    """Oracle: the three names in results; row sums of a snapshot photon camera there are none."""
    from irtiming.archive import reader

    assert [Choices(method=name).method for name in ("pixel-sum", "row-sum", "published")]
    with pytest.raises(EstimationError, match="whose rows are all read at once"):
        Choices(method="row-sum").check_for(reader.read(hand_made()))


def test_one_is_not_many() -> None:
    """Oracle: English."""
    assert [counted(n, "recording") for n in (0, 1, 2)] == ["0 recordings", "1 recording", "2 recordings"]

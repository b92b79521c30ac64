"""Options of a wide temperature range: what is simulated, what is refused, and how a temperature is read."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from irtiming.archive import reader
from irtiming.cli.main import app
from irtiming.errors import IrTimingError, UnitError
from irtiming.units import kelvin

_SMALL = ("--rows", "24", "--columns", "32", "--frames", "40", "--camera", "microbolometer")


def _run(*options: str) -> None:
    done = CliRunner().invoke(app, list(options))
    if done.exception is not None:
        raise done.exception


@pytest.mark.parametrize(
    ("text", "value"), [("303 K", 303.0), ("30 C", 303.15), ("30°C", 303.15), (" -40 degC ", 233.15), ("2.9e2K", 290.0)]
)
def test_temperatures_are_read(text: str, value: float) -> None:
    """Oracle: 0 degrees Celsius are 273.15 K."""
    assert kelvin(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["303", "30 F", "", "K", "30 K", "2000 K", "nan K"])
def test_what_is_no_temperature_is_refused(text: str) -> None:
    """Oracle: the message repeats the text and names a temperature that would do, or the limits."""
    with pytest.raises(UnitError, match=f"'{text}'"):
        kelvin(text)


def test_one_recording_before_each_blackbody(tmp_path: Path) -> None:
    """Oracle: the options; the truth tells both constants and no single one."""
    _run(
        "simulate", str(tmp_path), *_SMALL, "--time-constant", "6 ms", "--scene-time-constant", "20 ms",
        "--substrate-temperature", "310 K", "--blackbody-temperature", "288.15 K", "--blackbody-temperature", "45 C",
    )  # fmt: skip
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert truth["substrate_time_constant_s"] == pytest.approx(6e-3)
    assert truth["scene_time_constant_s"] == pytest.approx(20e-3)
    assert truth["substrate_temperature_k"] == 310.0
    assert "time_constant_s" not in truth
    names = {path.stem: reader.read(path).blackbody_temperature_k for path in tmp_path.glob("*.nxs")}
    assert names == {
        "bolo-3Hz-0ms-288.15K": pytest.approx(288.15),
        "bolo-3Hz-0ms-318.15K": pytest.approx(318.15),
    }


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("simulate", "new", "--blackbody-temperature", "300 K"), "--blackbody-temperature with --camera photon"),
        (("simulate", "new", *_SMALL, "--substrate-temperature", "300 K"), "with --scene-time-constant only"),
        (("simulate", "new", *_SMALL, "--scene-time-constant", "0 s"), "scene time constant of '0 s'"),
        (("analyse", "a.nxs", "--rig", "r", "--wheel-temperature", "300 K"), "with --substrate-temperature only"),
        (("analyse", "a.nxs", "--rig", "r", "--substrate-temperature", "hot"), "'hot' is not a temperature"),
    ],
)
def test_what_makes_no_sense_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], says: str
) -> None:
    """Oracle: the message names the option; no file is written."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(IrTimingError, match=".") as refused:
        _run(*options)
    assert says in str(refused.value)
    assert list(tmp_path.iterdir()) == []

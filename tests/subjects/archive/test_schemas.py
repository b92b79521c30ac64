"""The JSON Schemas that lie in the package: as the models make them, and of use to a validator that is not ours."""

import json
import subprocess
import sys
import tomllib
from importlib.resources import files
from pathlib import Path

import jschon
import pytest

ROOT = Path(__file__).parents[3]
NAMES = ("certificate", "limits", "plan", "result", "rig", "wheel")
pytestmark = pytest.mark.filterwarnings("ignore:Please use rfc3986:DeprecationWarning")
RIG = {
    "beams": {"half_separation_mm": 13.0, "height_difference_mm": 5.5, "whole_slots_between": 9},
    "mask": {"opening_angle_deg": 75, "centre_angle_deg": -90.0},
}


def _shipped(name: str) -> Path:
    return Path(str(files("irtiming") / "archive" / "schemas" / f"{name}.json"))


@pytest.fixture
def fits():
    """Return a function that says whether a validator of another house takes a value for what a schema describes."""
    jschon.create_catalog("2020-12", name="edge")

    def check(name: str, value: object) -> bool:
        schema = json.loads(_shipped(name).read_text())
        uri = jschon.URI(f"https://irtiming.test/{name}")
        return jschon.JSONSchema(schema, uri=uri, catalog="edge").evaluate(jschon.JSON(value)).valid

    return check


def test_the_schemas_are_what_the_models_say(tmp_path):
    """Oracle: the models; if this fails, run scripts/schemas src/irtiming/archive/schemas."""
    subprocess.run([sys.executable, ROOT / "scripts" / "schemas", tmp_path], check=True, timeout=60)
    assert sorted(path.stem for path in tmp_path.iterdir()) == list(NAMES)
    for name in NAMES:
        assert (tmp_path / f"{name}.json").read_text() == _shipped(name).read_text()


def test_a_validator_takes_the_examples(fits):
    """Oracle: the examples, which the reader takes; a misspelt key and a number out of range, which it refuses."""
    for name in ("plan", "rig"):
        examples = list((ROOT / "examples").glob(f"*.{name}.toml"))
        assert examples
        assert all(fits(name, tomllib.loads(path.read_text())) for path in examples)
    assert fits("rig", RIG)
    assert not fits("rig", RIG | {"mask": {"opening_angle_deg": 400, "centre_angle_deg": 0}})
    assert not fits("rig", RIG | {"masque": {}})

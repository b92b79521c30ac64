"""The page about plan.toml against the program that reads it."""

import re
from pathlib import Path

import pytest

from irtiming.archive.series_file import DEFAULT_NAME, NAME_FIELDS, PlanFile, read_series
from irtiming.archive.typed_misfit import model_in
from irtiming.gateware.register_map import Polarity
from irtiming.instruments.device_address import BLACKBODIES, CAMERAS, CHOPPERS, drivers
from irtiming.records.series_plan import MEASURANDS

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "plan-file.md").read_text()
_KEYS = {name: tuple(model_in(field.annotation).model_fields) for name, field in PlanFile.model_fields.items()}
_DEVICES = '[devices]\ncamera = "gige:1"\ntrigger_generator = "/dev/x"\nchopper = "mc2000b:/dev/y"\nblackbody = "sr800r:/dev/z"\n'
_NEEDED = {
    "devices": {},
    "camera": {"type": '"photon"'},
    "series": {"wheel_hz": "3", "frame_hz": "30.303", "samples": "1000"},
    "blackbody": {"temperature": '"15 C"'},
    "references": {"low": '"15 C"', "high": '"30 C"'},
}


def _section(name):
    return re.search(rf"^## {name}\n(.*?)(?=^## |\Z)", PAGE, flags=re.MULTILINE | re.DOTALL)[1]


def _rows(name):
    """Cells of the table of keys in one section of the page, by key."""
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in _section(name).splitlines()
        if re.match(r"\| `\w+`( \*)? \|", line)
    ]
    return {re.search(r"`(\w+)`", row[0])[1]: row for row in rows}


def _read(text, folder):
    path = folder / "plan.toml"
    path.write_text(text)
    return read_series(path)


def test_every_section_is_on_the_page():
    """Oracle: the sections that the reader knows, in their order."""
    assert re.findall(r"^## (\w+)$", PAGE, flags=re.MULTILINE) == list(_KEYS)


@pytest.mark.parametrize("section", _KEYS)
def test_every_key_is_on_the_page(section):
    """Oracle: the keys that the reader knows; it refuses any other."""
    assert sorted(_rows(section)) == sorted(_KEYS[section])


@pytest.mark.parametrize(("section", "key"), [(section, key) for section, keys in _KEYS.items() for key in keys])
def test_every_example_is_read(section, key, tmp_path):
    """Oracle: the reader, which takes the example of each key with nothing beside it but what the page calls needed."""
    values = {name: dict(needed) for name, needed in _NEEDED.items()}
    example = _rows(section)[key][4].strip("`")
    if key in ("plan", "file"):
        values[section] = {}
    if section != "devices":
        values.setdefault(section, {})[key] = example
    texts = [
        f"[{name}]\n" + "".join(f"{k} = {v}\n" for k, v in keys.items())
        for name, keys in values.items()
        if name != "devices"
    ]
    devices = re.sub(rf"^{key} = .*\n", "", _DEVICES, flags=re.MULTILINE) if section == "devices" else _DEVICES
    devices += f"{key} = {example}\n" if section == "devices" else ""
    _read(devices + "".join(texts), tmp_path)


@pytest.mark.parametrize(("section", "key"), [(s, k) for s, needed in _NEEDED.items() for k in needed])
def test_what_is_marked_as_needed_is(section, key, tmp_path):
    """Oracle: the reader, which refuses a file that lacks it."""
    texts = [
        f"[{name}]\n" + "".join(f"{k} = {v}\n" for k, v in keys.items() if (name, k) != (section, key))
        for name, keys in _NEEDED.items()
        if name != "devices"
    ]
    with pytest.raises(Exception, match=f"{key} is missing"):
        _read(_DEVICES + "".join(texts), tmp_path)
    assert "*" in _rows(section)[key][0]


def test_the_plan_at_the_top_of_the_page_is_read(tmp_path):
    """Oracle: the reader."""
    (text,) = re.findall(r"^```toml\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert _read(text, tmp_path).camera.camera_type == "photon"


def test_words_on_the_page_are_those_of_the_program():
    """Oracle: drivers, lines, names of uncertainties and of files in the program."""
    for group in (CAMERAS, CHOPPERS, BLACKBODIES):
        assert all(f"| `{driver.scheme}:" in PAGE for driver in drivers(group) if driver.distribution == "irtiming")
    assert all(f"`{line.lower()}`" in _section("wiring") for line in Polarity.__members__)
    assert all(f"`{name}`" in _section("stop") for name in MEASURANDS)
    assert all(f"`{name}`" in _section("files") for name in NAME_FIELDS)
    assert DEFAULT_NAME in _section("files")

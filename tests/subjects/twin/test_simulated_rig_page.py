"""The page about the simulated rig against the devices."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from irtiming.twin.devices.bench import LineFaults
from irtiming.twin.devices.blackbody import BlackbodyFaults
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.chopper import ChopperFaults
from irtiming.twin.devices.console import WORDS

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "simulated-rig.md").read_text()
_FAULTS = {
    "camera": CameraFaults(),
    "chopper": ChopperFaults(),
    "blackbody": BlackbodyFaults(),
    "generator": LineFaults(),
}
_KINDS = {"number": (int, float), "truth": (bool,), "set": (frozenset,), "text": (str,)}


def _rows(title, *, level):
    """Cells of the table under a title, without its head."""
    (text,) = re.findall(rf"^{level} {title}\n(.*?)(?=^#|\Z)", PAGE, flags=re.MULTILINE | re.DOTALL)
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| `")]


def test_every_device_that_can_break_is_on_the_page():
    """Oracle: the devices whose faults a rig has, by name."""
    assert re.findall(r"^### (\w+)$", PAGE, flags=re.MULTILINE) == list(_FAULTS)


@pytest.mark.parametrize("device", _FAULTS)
def test_every_fault_is_on_the_page_with_its_kind_and_first_value(device):
    """Oracle: the fields of the faults, in their order."""
    faults = _FAULTS[device]
    rows = _rows(device, level="###")
    assert [row[0].strip("`") for row in rows] == [field.name for field in fields(faults)]
    for name, kind, first, _ in rows:
        value = getattr(faults, name.strip("`"))
        assert type(value) in _KINDS[kind]
        if kind == "truth":
            assert first == str(value).lower()
        elif name != "`seed`":
            assert first == (f"{value:g}" if kind == "number" else "none")
            assert not value


def test_every_word_of_the_console_is_on_the_page():
    """Oracle: the console's own list."""
    words = [re.split(r"  +", line, maxsplit=1) for line in WORDS]
    rows = _rows("Words", level="##")
    assert [(row[0].strip("`"), row[1].replace("`", "")) for row in rows] == [tuple(line) for line in words]

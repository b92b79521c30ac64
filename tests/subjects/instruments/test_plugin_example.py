"""The drivers on the page about drivers, run as they stand there."""

import asyncio
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from irtiming.errors import InstrumentRefused
from irtiming.instruments.protocols import Blackbody, Camera, Chopper

PAGE = (Path(__file__).parents[3] / "docs" / "how-to" / "write-a-driver.md").read_text()


def _block(language):
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return text


@pytest.fixture
def module(monkeypatch, tmp_path):
    """The module of the page."""
    (tmp_path / "my_rig.py").write_text(_block("python"))
    monkeypatch.syspath_prepend(tmp_path)
    import my_rig

    yield my_rig
    del sys.modules["my_rig"]


def test_the_doctor_says_what_the_page_prints(tmp_path):
    """Oracle: the page; its entry points are made known as an installer would."""
    project = tomllib.loads(_block("toml"))["project"]
    (tmp_path / "my_rig.py").write_text(_block("python"))
    about = tmp_path / "my_rig-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    points = "".join(
        f"[{group}]\n" + "".join(f"{name} = {place}\n" for name, place in names.items())
        for group, names in project["entry-points"].items()
    )
    (about / "entry_points.txt").write_text(points)
    said = _block("text").splitlines()
    words = said[0].removeprefix("$ irtiming ").split()
    done = subprocess.run(
        [sys.executable, "-c", "from irtiming.cli.main import run; run()", *words],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    printed = done.stdout.splitlines()
    expected = [line for line in said[1:] if line != "…"]
    assert len(expected) == 4
    assert [line for line in expected if line not in printed] == []


@pytest.mark.parametrize(
    ("name", "protocol"), [("MyCamera", Camera), ("TurnsByItself", Chopper), ("HeatedPlate", Blackbody)]
)
def test_the_drivers_have_all_that_is_asked_of_them(module, name, protocol):
    """Oracle: the names in the protocols."""
    asked = {word for word in vars(protocol) if not word.startswith("_")} - {"name", "identity"}
    assert asked <= set(dir(getattr(module, name)))


def test_frames_come_with_their_numbers(module):
    """Oracle: by hand: a camera that stands at 7 when armed, makes four frames, and loses the third on the way."""
    picture = np.arange(24 * 32, dtype=np.uint16).reshape(24, 32)

    async def test():
        async with module.camera("17") as camera:
            setup = await camera.arm()
            send = camera._library.on_frame
            sender = Thread(target=lambda: [send(7 + k, 1000 * k, picture + k) for k in (0, 1, 3)])
            sender.start()
            sender.join()
            counts = await camera.disarm()
            return setup, [frame async for frame in camera.frames()], counts

    setup, frames, counts = asyncio.run(test())
    assert (setup.rows, setup.columns) == picture.shape
    assert [frame.frame_id for frame in frames] == [0, 1, 3]
    assert [frame.device_timestamp_ticks for frame in frames] == [0, 1000, 3000]
    assert all(np.array_equal(frame.pixels, picture + frame.frame_id) for frame in frames)
    assert counts.frames == 3


def test_what_the_example_cannot_do_is_refused(module):
    """Oracle: the page: a wheel that is stopped by hand, a plate of one temperature, a feature that is not there."""

    async def test():
        async with module.camera("1") as camera, module.chopper("") as chopper, module.blackbody("300") as plate:
            for asked in (camera.feature("Gain"), chopper.stop(), plate.set_target(310.0)):
                with pytest.raises(InstrumentRefused):
                    await asked

    asyncio.run(test())

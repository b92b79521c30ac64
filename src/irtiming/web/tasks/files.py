"""Files looked at, checked and converted, away from the server: a file that is not sound harms no more than this."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from irtiming.archive.rig_file import read_rig
from irtiming.archive.verify import verify as verify_file
from irtiming.records.frame_view import ViewOrder
from irtiming.session import frame_files
from irtiming.session.frame_views import view
from irtiming.units import readable_time
from irtiming.web.orders import CheckOrder, ConvertOrder
from irtiming.web.tasks.jpeg import jpeg
from irtiming.web.work import Line, give_way

_PLAIN = ("format", "frames", "rows", "columns", "dtype", "unit", "bit_depth", "start_time")


def warm_up(line: Line, order: None) -> None:
    """Nothing: the process has then loaded what the next task needs."""


def picture(line: Line, order: ViewOrder) -> dict[str, Any]:
    """A frame as JPEG, and which it is."""
    found = view(order)
    facts = {"index": found.index, "n_frames": found.n_frames, "lowest": found.lowest, "highest": found.highest}
    return facts | {"content": jpeg(found)}


def about(line: Line, path: Path) -> dict[str, str]:
    """What ``irtiming info`` says of a file, as text by name."""
    found = frame_files.look_into(path)
    facts = {name.replace("_", " "): str(found[name]) for name in _PLAIN if found[name] not in (None, "")}
    if numbers := frame_files.numbers_in_words(found["frame_id"]):
        facts["frame numbers"] = numbers
    for name in ("integration_time", "frame_period"):
        if found[name] is not None:
            facts[name.replace("_", " ")] = readable_time(found[name]["value"])
    for name in ("frame_times", "trigger_times"):
        if (times := found[name]) is not None:
            scale = f" ({times['scale']})" if times.get("scale") else ""
            facts[name.replace("_", " ")] = f"from {times['first']:.6f} s to {times['last']:.6f} s{scale}"
    more = {**(found["camera"] or {}), **found["more"]}
    return facts | {name.replace("_", " "): str(value)[:300] for name, value in more.items() if value not in (None, "")}


def check(line: Line, order: CheckOrder) -> list[dict[str, Any]]:
    """What ``irtiming verify`` finds."""
    give_way()
    rig = None if order.rig is None else read_rig(order.rig)
    return [asdict(one) for one in verify_file(order.path, progress=_steps(line, order.path.name), rig=rig)]


def convert(line: Line, order: ConvertOrder) -> dict[str, Any]:
    """What ``irtiming convert`` does; gives the file, and what has no place in its format."""
    give_way()
    lost = frame_files.convert(order.path, order.out, progress=_steps(line, order.path.name))
    return {"out": str(order.out), "lost": lost}


def _steps(line: Line, name: str) -> Callable[[int, int], None]:
    return lambda done, total: line.step(name, done=done, total=total)

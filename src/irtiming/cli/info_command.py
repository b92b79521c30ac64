"""`irtiming info`: what a file of frames holds, whatever program wrote it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from irtiming.archive.json_file import require_places, write_json
from irtiming.cli.screen import say
from irtiming.units import readable_time

_PLAIN = ("format", "frames", "rows", "columns", "dtype", "unit", "bit_depth", "start_time", "first_frame_sha256")


def info(
    file: Annotated[
        Path, typer.Argument(help="File of frames of any format that is known, or a folder with one for each frame.")
    ],
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write all of it there.")] = None,
) -> None:
    """Say what a file of frames holds: size, type, camera, times, integration time.

    Which formats are read stands in docs/reference/frame-files.md; a format is recognised by the content, not by the name.
    """
    from irtiming.archive.frames.opening import files_read
    from irtiming.session.frame_files import look_into, numbers_in_words

    require_places({"JSON": [json]}, inputs=files_read(file))
    found = look_into(file)
    for name in _PLAIN:
        if found[name] not in (None, ""):
            say(f"{name.replace('_', ' ')}: {found[name]}")
    if numbers := numbers_in_words(found["frame_id"]):
        say(f"frame numbers: {numbers}")
    _say_times(found)
    for name, value in {**(found["camera"] or {}), **found["more"]}.items():
        if value not in (None, ""):
            say(f"{name.replace('_', ' ')}: {value}")
    if json is not None:
        write_json(found, json)


def _say_times(found: Mapping[str, Any]) -> None:
    for name in ("integration_time", "frame_period"):
        if found[name] is not None:
            say(f"{name.replace('_', ' ')}: {readable_time(found[name]['value'])}")
    for name in ("frame_times", "trigger_times"):
        if found[name] is not None:
            times = found[name]
            scale = f" ({times['scale']})" if times.get("scale") else ""
            each = times["median_interval"]
            between = "" if each is None else f", every {readable_time(each)}"
            say(f"{name.replace('_', ' ')}: from {times['first']:.6f} s to {times['last']:.6f} s{between}{scale}")

"""`irtiming convert`: frames of any format into a file of another one."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from irtiming.archive.json_file import require_place
from irtiming.cli.progress import shown
from irtiming.cli.screen import say


def convert(
    file: Annotated[
        Path, typer.Argument(metavar="IN", help="File of frames of any format that is known, or a folder of them.")
    ],
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="File to make: .nxs or .h5 (NeXus), .tif (BigTIFF), .npy (and .npy.json), or .hcc (Telops).",
        ),
    ],
) -> None:
    """Convert frames, with what is known of them, into NeXus, BigTIFF, NumPy or HCC.

    Frames go through memory block by block. The file is whole or not there. What is known and has no place in the format is said.
    """
    from irtiming.archive.frames.opening import files_read
    from irtiming.session.frame_files import convert as convert_frames

    require_place(out, besides=files_read(file), is_text=False, is_new=True)
    with shown("frames") as progress:
        lost = convert_frames(file, out, progress=partial(progress, escape(file.name)))
    say(f"{out}: written" + (f"; this format has no place for {', '.join(lost)}" if lost else ""))

"""`irtiming export-vcd`: timestamps of a recording for a waveform viewer."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from irtiming.cli.screen import say

if TYPE_CHECKING:
    from irtiming.archive.timestamps_file import TimedRun
    from irtiming.records.recording import Recording


def export_vcd(
    recording: Annotated[Path, typer.Argument(help="Recording, or timestamps of gateware record.")],
    out: Annotated[
        Path | None,
        typer.Option(
            ..., "--out", "-o", metavar="OUT", help="File to write; if not given, the recording's name with .vcd."
        ),
    ] = None,
) -> None:
    """Write the timestamps of a recording as a value change dump (VCD), which any waveform viewer shows.

    Times are in ns, and rounded so that each tick comes back exactly when the file is read with import-capture.
    """
    from irtiming.archive import reader
    from irtiming.archive.json_file import require_places
    from irtiming.archive.timestamps_file import read_timestamps
    from irtiming.archive.vcd_export import write_vcd
    from irtiming.errors import ArchiveError

    target = recording.with_suffix(".vcd") if out is None else out
    require_places({"VCD": [target]}, inputs=[recording])
    found: Recording | TimedRun
    try:
        found = reader.read(recording)
    except ArchiveError as error:
        try:
            found = read_timestamps(recording)  # a run that waits for its frames
        except ArchiveError:
            raise error from None
    write_vcd(found, target)
    say(f"{target}: ticks of {found.clock_frequency_hz:.15g} Hz as times")

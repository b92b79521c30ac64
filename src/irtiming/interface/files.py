"""Files as Python has them: a recording, a rig, a result."""

from pathlib import Path

from irtiming.archive import reader, result_file, rig_file
from irtiming.archive.frames import opening
from irtiming.archive.frames.source import FrameSource
from irtiming.interface.timing_result import TimingResult
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig


def open_recording(path: str | Path) -> Recording:
    """A recording file, every field checked; its frames stay in the file and are read when they are needed.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or is no sound recording; the message says field, what is, and what to do.
    """
    return reader.read(path)


def open_frames(path: str | Path) -> FrameSource:
    """Frames in a file of any format that is known, or in a folder; they stay there and are read when they are needed.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or is of no format that is known.
    """
    return opening.open_frames(path)


def read_rig(path: str | Path) -> Rig:
    """What a person measured on the rig, from rig.toml, in SI units.

    Raises
    ------
    IrTimingError
        If the file cannot be read, or a number in it cannot be.
    """
    return rig_file.read_rig(Path(path))


def read_result(path: str | Path) -> TimingResult:
    """The result that ``irtiming analyse --json`` or `TimingResult.write` wrote.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or is no result.
    """
    return TimingResult(result_file.read_result(path))

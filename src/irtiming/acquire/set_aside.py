"""Recordings that are not whole: all of them are kept, out of the way of those that are."""

from pathlib import Path

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.journal import Journal
from irtiming.archive.layout import PART, SET_ASIDE
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.unfinished import is_claimed
from irtiming.errors import ArchiveError


def set_aside(path: Path, *, attendant: Attendant) -> Path:
    """Move a file into the folder for those that are not whole; it stays where that cannot be done.

    The folder is beside the whole recordings of a series, so that all files of the series' own folder can be analysed together.

    Parameters
    ----------
    path
        Of the file.
    attendant
        Learns where it stays.

    Returns
    -------
    Where it is now.
    """
    folder = path.parent / SET_ASIDE
    try:
        folder.mkdir(exist_ok=True)
        return path.rename(free_path(folder, path.name))
    except OSError as error:
        attendant.says(
            f"{path} cannot be moved to {folder} ({error.strerror}); move it away before you analyse the others"
        )
        return path


def free_path(folder: Path, name: str) -> Path:
    """A recording's name that is free in a folder; one that is taken, also by an unfinished file, gets a number behind it.

    Parameters
    ----------
    folder
        Where it is to be.
    name
        With its suffixes.
    """
    stem, dot, suffixes = name.partition(".nxs")
    path, again = folder / name, 1
    while path.exists() or path.with_name(f"{path.name}{PART}").exists():
        again += 1
        path = folder / f"{stem}-{again}{dot}{suffixes}"
    return path


def recovered_parts(folder: Path, *, journal: Journal, attendant: Attendant) -> tuple[Path, ...]:
    """Finish recordings that a killed program left in a folder and set them aside; their runs are made again all the same.

    Parameters
    ----------
    folder
        Of the series.
    journal, attendant
        Learns of each.

    Returns
    -------
    Where the finished ones are; one of which nothing can be made is set aside as it is.
    """
    found = []
    for part in sorted(folder.glob(f"*.nxs{PART}")):
        try:
            found.append(set_aside(recover(part), attendant=attendant))
        except ArchiveError as error:
            outcome = f"cannot be recovered: {error}"
            if not is_claimed(part):
                outcome += f" (kept as {set_aside(part, attendant=attendant).relative_to(folder)})"
        else:
            outcome = f"recovered what an interrupted program left: {found[-1].relative_to(folder)}"
        journal.note(outcome)
        attendant.says(outcome)
    return tuple(found)

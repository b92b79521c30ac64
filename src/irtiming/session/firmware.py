"""The firmware of a microcontroller board, put into a folder from which it is copied to the board."""

from pathlib import Path

from irtiming.archive.json_file import make_folder, write_atomically
from irtiming.errors import ArchiveError
from irtiming.gateware.firmware_files import firmware_files


def write_firmware(folder: Path) -> tuple[Path, ...]:
    """Put all files of the firmware into a folder, which is made if it is not there.

    Parameters
    ----------
    folder
        Files of other names in it are left alone.

    Returns
    -------
    What is there now.

    Raises
    ------
    ArchiveError
        If a file of the same name says something else (somebody's pins, perhaps), or the folder cannot be written to.
    """
    texts = firmware_files()
    for name, text in texts.items():
        there = folder / name
        if there.exists() and (there.is_dir() or there.read_bytes() != text.encode()):
            raise ArchiveError(
                f"{there}: is there and differs; it may hold your pins: name a new folder, or move it away"
            )
    make_folder(folder)
    for name, text in texts.items():
        write_atomically(text, folder / name)
    return tuple(folder / name for name in texts)

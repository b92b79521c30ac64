"""Read a logic analyser's capture, whatever program wrote it."""

from collections.abc import Sequence
from pathlib import Path

from irtiming.archive.captures.capture import Capture, broken
from irtiming.archive.captures.csv_file import read_csv
from irtiming.archive.captures.saleae import IDENTIFIER, read_saleae
from irtiming.archive.captures.sigrok import read_sigrok
from irtiming.archive.captures.vcd import read_vcd
from irtiming.errors import ArchiveError

_ZIP = b"PK"
_SNIFFED_BYTES = 4096


def read_capture(path: str | Path, names: Sequence[str]) -> Capture:
    """Some lines of a capture; its kind is recognised by what is in it, not from its name.

    Parameters
    ----------
    path
        A value change dump, a table (CSV), a sigrok session, or the folder of a Saleae raw binary export.
    names
        Of the lines, or their numbers such as D3.

    Raises
    ------
    ArchiveError
        If it cannot be read, is cut short or damaged, a line is not in it, or data were lost while it was recorded.
    """
    where = Path(path)
    try:
        if where.is_dir():
            return read_saleae(where, names)
        if where.exists() and not where.is_file():
            raise broken(where, "is no file but a device or a pipe; name a capture")
        with where.open("rb") as file:
            begin = file.read(_SNIFFED_BYTES)
        if not begin:
            raise broken(where, "is empty (0 bytes); export or copy it again")
        if begin.startswith(IDENTIFIER):
            raise broken(where, "is one channel of a Saleae raw binary export; give the folder that holds all of them")
        if begin.startswith(_ZIP):
            return read_sigrok(where, names)
        if begin.lstrip().startswith(b"$"):
            return read_vcd(where, names)
        if b"\0" in begin:
            raise broken(where, "is no capture that can be read; export it as VCD, CSV or sigrok session (.sr)")
        return read_csv(where, names)
    except FileNotFoundError as error:
        raise ArchiveError(f"{where}: does not exist; check the name") from error
    except OSError as error:
        raise ArchiveError(f"{where}: cannot be read ({error.strerror or error}); check its permissions") from error

"""What the suffix of a file says that is to be written: a name that says one format is not given to another."""

from pathlib import Path
from typing import Literal

from irtiming.archive.layout import SUFFIX
from irtiming.errors import ArchiveError

Kind = Literal["JSON", "HTML", "SVG", "CSV", "Parquet", "VCD", "YAML", "certificate", "recording"]

SUFFIXES: dict[Kind, tuple[str, ...]] = {
    "JSON": (".json",),
    "HTML": (".html", ".htm"),
    "SVG": (".svg",),
    "CSV": (".csv",),
    "Parquet": (".parquet",),
    "VCD": (".vcd",),
    "YAML": (".yaml", ".yml"),
    "certificate": (".pdf", ".html", ".xml"),
    "recording": (SUFFIX, ".h5", ".hdf5"),
}
"""What names of each kind of file end in, the usual one first."""

NO_TEXT: frozenset[Kind] = frozenset({"Parquet", "recording"})
"""What goes neither to the standard output nor to a pipe."""

NEVER_REPLACED: frozenset[Kind] = frozenset({"VCD", "recording"})
"""What takes the place of no file: it may be the only copy."""

_FORMATS = {
    ".avi", ".bmp", ".csv", ".docx", ".eps", ".gif", ".h5", ".hcc", ".hdf5", ".htm", ".html", ".jpeg", ".jpg", ".json", ".md",
    ".mp4", ".npy", ".npz", ".ods", ".parquet", ".pdf", ".png", ".ps", ".sqlite", ".svg", ".tif", ".tiff", ".toml", ".tsv",
    ".vcd", ".webp", ".xlsx", ".xml", ".yaml", ".yml", ".zip", SUFFIX,
}  # fmt: skip
"""Suffixes that people and programs take for a format; any other, or none, says nothing."""


def require_suffix(path: Path, *kinds: Kind) -> None:
    """Refuse a name whose suffix says another format than is written there.

    Parameters
    ----------
    path
        Of the file to write.
    kinds
        What may be written there, by its suffix.

    Raises
    ------
    ArchiveError
        If it has the suffix of another format.
    """
    fitting = [suffix for kind in kinds for suffix in SUFFIXES[kind]]
    if path.suffix.lower() not in _FORMATS.difference(fitting):
        return
    what = " or ".join("a recording" if kind == "recording" else kind for kind in kinds)
    usual = " or ".join(SUFFIXES[kind][0] for kind in kinds)
    raise ArchiveError(
        f"ends in {path.suffix}, but {what} is to be written there; give a name that ends in {usual}", where=str(path)
    )

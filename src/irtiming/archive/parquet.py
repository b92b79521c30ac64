"""The library that writes Parquet, which not everybody has."""

from typing import Any

from irtiming.errors import ArchiveError


def require_parquet() -> tuple[Any, Any]:
    """Its modules ``pyarrow`` and ``pyarrow.parquet``.

    Raises
    ------
    ArchiveError
        If it is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise ArchiveError("Parquet needs the library pyarrow: pip install 'irtiming[parquet]'") from error
    return pyarrow, parquet

"""HDF5 files being written: what stops the command waits until it can do HDF5 no harm, and reaches its own handler then."""

import signal
from pathlib import Path

import pytest

from irtiming.archive.hdf5_output import whole_hdf5


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_reaches_its_handler_when_the_file_is_closed(tmp_path: Path, number: signal.Signals) -> None:
    """Oracle: the handler that was there is called once, with its number and after the block; nothing is left of the file."""
    heard: list[int] = []
    before = signal.signal(number, lambda which, _: heard.append(which))
    try:
        with pytest.raises(KeyboardInterrupt), whole_hdf5(tmp_path / "a.h5") as file:  # noqa: PT012 - the rest of the block passes
            signal.raise_signal(number)
            file["x"] = 1
            assert heard == []
        signal.raise_signal(number)
    finally:
        signal.signal(number, before)
    assert heard == [number, number]
    assert list(tmp_path.iterdir()) == []

"""Raw binary export of Saleae's Logic 2: a folder with one file per channel, version 0 or 1."""

import re
import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from irtiming.archive.captures.bounds import MOST_CHANGES, too_many_changes
from irtiming.archive.captures.capture import PICOSECONDS, Capture, Line, broken, cut_short, find_lines, goes_back, lost

IDENTIFIER = b"<SALEAE>"
_DIGITAL = 0
_LONGEST_S = 1e6
_FILE_NAME = re.compile(r"digital_(\d+)\.bin")


class _Channel(NamedTuple):
    line: Line
    begin_ps: int
    end_ps: int
    sample_rate_hz: float | None


def read_saleae(folder: Path, names: Sequence[str]) -> Capture:
    """Channels of a folder of raw binary files, ``digital_0.bin`` and so on.

    Raises
    ------
    ArchiveError
        If a file is none of these or cut short, a channel is not there, or has more than one chunk: a gap.
    """
    files = sorted(path for path in folder.iterdir() if _FILE_NAME.fullmatch(path.name))
    if not files:
        raise broken(
            folder, "is a folder without digital_0.bin and so on; name a capture or a Saleae raw binary export"
        )
    there = [f"Channel {int(path.stem.split('_')[1])}" for path in files]
    places = find_lines(names, there, path=folder)
    channels = {name: _read_channel(files[place], name) for name, place in places.items()}
    rates = {one.sample_rate_hz for one in channels.values()}
    rate = rates.pop() if len(rates) == 1 else None
    return Capture(
        lines={name: one.line for name, one in channels.items()},
        counts_per_second=PICOSECONDS,
        begin=max(one.begin_ps for one in channels.values()),
        end=min(one.end_ps for one in channels.values()),
        sample_rate_hz=None if rate is None else round(rate),
    )


def _read_channel(path: Path, name: str) -> _Channel:
    with path.open("rb") as file:
        identifier, version, kind = _unpack(path, file, "<8sii")
        if identifier != IDENTIFIER:
            raise broken(path, "is no raw binary export of Logic 2; export the capture again")
        if version not in (0, 1) or kind != _DIGITAL:
            raise broken(
                path, f"is of version {version} and type {kind}; only digital data (type 0) of version 0 or 1 is read"
            )
        rate = None
        if version == 0:
            initial, begin_s, end_s, count = _unpack(path, file, "<IddQ")
        else:
            (n_chunks,) = _unpack(path, file, "<Q")
            if n_chunks == 0:
                raise broken(path, "holds no data; was the channel switched on?")
            initial, rate, begin_s, end_s, count = _unpack(path, file, "<IdddQ")
            if n_chunks > 1:
                raise lost(path, name, time_s=end_s)
        if count > MOST_CHANGES:
            raise too_many_changes(path, name)
        data = file.read(8 * count + 1)
    if len(data) != 8 * count:
        raise cut_short(path, f"holds {len(data) // 8} of {count} changes")
    times = np.frombuffer(data, dtype="<f8")
    bounds = np.array([begin_s, end_s, 1.0 if rate is None else rate])
    if not np.all(np.isfinite(times)) or not np.all(np.isfinite(bounds)) or max(abs(bounds[:2])) > _LONGEST_S:
        raise broken(path, "holds times that cannot be; it is damaged, export it again")
    if initial not in (0, 1) or bounds[2] <= 0 or (times.size and max(abs(times[0]), abs(times[-1])) > _LONGEST_S):
        raise broken(path, "holds a level, rate or time that cannot be; it is damaged, export it again")
    if np.any(back := np.diff(times) < 0):
        raise goes_back(path, times[np.argmax(back)])
    counts = np.rint(times * float(PICOSECONDS)).astype(np.int64)
    line = Line(initial=initial, changes=counts)
    return _Channel(line, round(Fraction(begin_s) * PICOSECONDS), round(Fraction(end_s) * PICOSECONDS), rate)


def _unpack(path: Path, file: BinaryIO, layout: str) -> tuple[Any, ...]:
    data = file.read(struct.calcsize(layout))
    if len(data) < struct.calcsize(layout):
        raise cut_short(path, "ends within its header")
    return struct.unpack(layout, data)

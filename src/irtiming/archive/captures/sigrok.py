"""Session files of sigrok and PulseView: a ZIP of raw samples, read block by block."""

import configparser
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import final

import numpy as np
import numpy.typing as npt

from irtiming.archive.captures.bounds import MOST_CHANGES, MOST_HEADER_BYTES, MOST_SAMPLE_BYTES, too_many_changes
from irtiming.archive.captures.capture import Capture, Line, broken, cut_short, find_lines, hertz
from irtiming.records.arrays import Ticks

_BLOCK_BYTES = 2**24
_ZIP_ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    OSError,
    ValueError,
    struct.error,
)


@final
@dataclass(frozen=True, kw_only=True)
class _Session:
    """What the session's metadata say: lines by name and bit, samples of some bytes, names of the data files."""

    bits: dict[str, int]
    sample_rate_hz: int
    unit_bytes: int
    data: list[str]


def read_sigrok(path: Path, names: Sequence[str]) -> Capture:
    """Lines of a sigrok session, in samples; data of any length are read block by block.

    Raises
    ------
    ArchiveError
        If the file is none or damaged, a line is not in it, or a piece of its data is missing.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            session = _session(path, archive)
            there = list(session.bits)
            places = find_lines(names, there, path=path)
            bits = [session.bits[there[places[name]]] for name in names]
            initial, changes, n_samples = _follow(path, archive, session, bits)
    except _ZIP_ERRORS as error:
        raise broken(
            path, f"cannot be read as a sigrok session ({error}); it is damaged or cut short, copy it again"
        ) from error
    lines = {name: Line(initial=at, changes=found) for name, at, found in zip(names, initial, changes, strict=True)}
    return Capture(
        lines=lines,
        counts_per_second=Fraction(session.sample_rate_hz),
        begin=0,
        end=n_samples - 1,
        sample_rate_hz=session.sample_rate_hz,
    )


def _session(path: Path, archive: zipfile.ZipFile) -> _Session:
    inside = archive.namelist()
    if "meta.json" in inside:
        raise broken(path, "is a session of Saleae's Logic 2; export its raw data as CSV or binary and give that")
    if "metadata" not in inside:
        raise broken(path, "is a ZIP but no sigrok session; give a .sr file")
    parser = configparser.ConfigParser(interpolation=None, delimiters=("=",), strict=False)
    try:
        if (n_bytes := archive.getinfo("metadata").file_size) > MOST_HEADER_BYTES:
            raise broken(
                path, f"has {n_bytes} bytes of metadata, at most {MOST_HEADER_BYTES} are meant; save the session again"
            )
        parser.read_string(archive.read("metadata").decode("utf-8", "replace"))
    except configparser.Error as error:
        raise broken(path, f"has metadata that cannot be read ({error.message}); save the session again") from error
    device = next((parser[name] for name in parser.sections() if name.startswith("device")), None)
    probes = {} if device is None else {k: v for k, v in device.items() if re.fullmatch(r"probe[0-9]{1,4}", k)}
    rate = None if device is None else hertz(device.get("samplerate", ""))
    if device is None or not probes or rate is None or not re.fullmatch("[0-9]{1,9}", device.get("unitsize", "")):
        raise broken(path, "has no device with probes, samplerate and unitsize in its metadata; save the session again")
    bits = {name: int(key[len("probe") :]) - 1 for key, name in probes.items()}
    unit_bytes = int(device["unitsize"])
    if unit_bytes > MOST_SAMPLE_BYTES:
        raise broken(path, f"has samples of {unit_bytes} bytes; no analyser has more than {MOST_SAMPLE_BYTES}")
    if min(bits.values()) < 0 or max(bits.values()) >= 8 * unit_bytes:
        raise broken(path, f"has more probes than bits in its {unit_bytes} bytes a sample; save the session again")
    data = _data_names(path, inside, device.get("capturefile", "logic-1"), rate_hz=rate)
    return _Session(bits=bits, sample_rate_hz=rate, unit_bytes=unit_bytes, data=data)


def _data_names(path: Path, inside: list[str], stem: str, *, rate_hz: int) -> list[str]:
    """Names of the pieces of data in their order."""
    if stem in inside:
        return [stem]
    numbers = sorted(
        int(name[len(stem) + 1 :]) for name in inside if re.fullmatch(rf"{re.escape(stem)}-[0-9]{{1,9}}", name)
    )
    if not numbers:
        raise broken(path, f"holds no data '{stem}'; record logic lines, not analog ones")
    if numbers != list(range(1, len(numbers) + 1)):
        gap = next(want for want, there in enumerate(numbers, start=1) if want != there)
        raise broken(path, f"lacks its piece of data '{stem}-{gap}': data were lost there; save or copy it again")
    return [f"{stem}-{number}" for number in numbers]


def _follow(
    path: Path, archive: zipfile.ZipFile, session: _Session, bits: Sequence[int]
) -> tuple[list[int], list[Ticks], int]:
    """First level and changes of each bit, and the number of samples."""
    changes: list[list[Ticks]] = [[] for _ in bits]
    last: npt.NDArray[np.uint8] | None = None
    first: npt.NDArray[np.uint8] | None = None
    n_samples = 0
    for block in _blocks(path, archive, session):
        if first is None:
            first = block[0]
        before = first if last is None else last
        for byte in sorted({bit // 8 for bit in bits}):
            used = np.uint8(sum(1 << (bit % 8) for bit in set(bits) if bit // 8 == byte))
            column = np.concatenate([before[byte : byte + 1], block[:, byte]]) & used
            at = np.flatnonzero(column[1:] != column[:-1])
            flipped = column[at + 1] ^ column[at]
            for bit, found in zip(bits, changes, strict=True):
                if bit // 8 == byte:
                    found.append(n_samples + at[(flipped >> (bit % 8)) & 1 == 1])
                    if sum(map(len, found)) > MOST_CHANGES:
                        raise too_many_changes(path, f"of bit {bit}")
        last = block[-1].copy()
        n_samples += len(block)
    if first is None:
        raise cut_short(path, "holds no samples")
    return (
        [int(first[bit // 8] >> (bit % 8)) & 1 for bit in bits],
        [np.concatenate(found) for found in changes],
        n_samples,
    )


def _blocks(path: Path, archive: zipfile.ZipFile, session: _Session) -> Iterator[npt.NDArray[np.uint8]]:
    """Samples, shape (n, byte)."""
    rest = b""
    for name in session.data:
        with archive.open(name) as file:
            while data := file.read(_BLOCK_BYTES):
                data = rest + data
                whole = len(data) - len(data) % session.unit_bytes
                rest = data[whole:]
                if whole:
                    yield np.frombuffer(data, np.uint8, count=whole).reshape(-1, session.unit_bytes)
    if rest:
        raise cut_short(path, f"ends within a sample of {session.unit_bytes} bytes")

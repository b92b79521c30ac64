"""Value change dumps: the format that all logic analysers and simulators can write."""

import io
import re
from array import array
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO, final

import numpy as np
from vcd.reader import Token, TokenKind, VarDecl, VCDParseError, tokenize

from irtiming.archive.captures.bounds import MOST_CHANGES, MOST_HEADER_BYTES, bounded_lines, too_many_changes
from irtiming.archive.captures.capture import (
    Capture,
    Line,
    broken,
    cut_short,
    find_lines,
    goes_back,
    hertz,
    lost,
)

_MOST_DIGITS = 30
_UNITS = {"s": 0, "ms": 3, "us": 6, "ns": 9, "ps": 12, "fs": 15}
_RATE_IN_COMMENT = re.compile(r"\bat ([\d.]+ ?[kMG]?Hz)\b", flags=re.IGNORECASE)
_SKIPPED = (b"$dumpvars", b"$dumpall", b"$dumpon", b"$dumpoff", b"$end")


@final
class _Seen:
    """One line while it is read; its level is None as long as it is unknown."""

    def __init__(self, path: Path, name: str) -> None:
        self._path = path
        self.name = name
        self.level: int | None = None
        self.known_from = 0
        self.initial = 0
        self.changes = array("q")

    def see(self, level: int, now: int) -> None:
        """Take note of what the line is from now on."""
        if self.level is None:
            self.initial, self.known_from = level, now
        elif level != self.level:
            if len(self.changes) >= MOST_CHANGES:
                raise too_many_changes(self._path, self.name)
            self.changes.append(now)
        self.level = level


def read_vcd(path: Path, names: Sequence[str]) -> Capture:
    """Lines of a value change dump, in counts of its time scale.

    The sample rate is taken from a comment such as sigrok writes: "Acquisition with 3/8 channels at 24 MHz".

    Raises
    ------
    ArchiveError
        If the file is none or damaged, a line is not in it, or was unknown (x, z) at some time.
    """
    with path.open("rb") as file:
        per_second, variables, rate = _header(path, file)
        places = find_lines(
            names, _short_names([one for one, _ in variables], [one for _, one in variables]), path=path
        )
        seen = {name: _Seen(path, name) for name in names}
        by_code: dict[bytes, list[_Seen]] = {}
        for name, place in places.items():
            _, variable = variables[place]
            if variable.size != 1:
                raise broken(path, f"'{name}' is a bus of {variable.size} lines; name a single line")
            by_code.setdefault(variable.id_code.encode(), []).append(seen[name])
        begin, end = _follow(path, _statements(path, _words(path, file)), by_code, per_second)
    return Capture(
        lines={
            name: Line(initial=one.initial, changes=np.frombuffer(one.changes, np.int64)) for name, one in seen.items()
        },
        counts_per_second=per_second,
        begin=begin,
        end=end,
        sample_rate_hz=rate,
    )


def _header(path: Path, file: BinaryIO) -> tuple[Fraction, list[tuple[str, VarDecl]], int | None]:
    """Counts per second, the variables with their scopes, and the sample rate of the declarations."""
    lines = []
    n_bytes = 0
    for line in bounded_lines(path, file):
        lines.append(line)
        n_bytes += len(line)
        if b"$enddefinitions" in line:
            break
        if n_bytes > MOST_HEADER_BYTES:
            raise broken(
                path, f"has a header of more than {MOST_HEADER_BYTES} bytes; export fewer lines of the analyser"
            )
    else:
        raise cut_short(path, "has no $enddefinitions")
    head, keyword, rest = b"".join(lines).partition(b"$enddefinitions")
    if b"$end" not in rest:
        raise cut_short(path, "has no $end after $enddefinitions")
    file.seek(len(head) + len(keyword) + rest.index(b"$end") + len(b"$end"))
    per_second, variables, rate, scope = None, [], None, []
    for token in _tokens(path, head):
        match token.kind:
            case TokenKind.TIMESCALE:
                scale = token.timescale
                per_second = Fraction(10 ** _UNITS[scale.unit.value], scale.magnitude.value)
            case TokenKind.COMMENT:
                found = _RATE_IN_COMMENT.search(token.comment)
                rate = hertz(found[1]) if found else rate
            case TokenKind.SCOPE:
                scope.append(token.scope.ident)
            case TokenKind.UPSCOPE:
                del scope[-1:]
            case TokenKind.VAR:
                variables.append((".".join(scope), token.var))
            case _:
                pass
    if per_second is None:
        raise broken(path, "has no $timescale; without it no time can be determined, so export it again")
    return per_second, variables, rate


def _tokens(path: Path, head: bytes) -> Iterator[Token]:
    try:
        yield from tokenize(io.BytesIO(head))
    except (VCDParseError, ValueError, IndexError) as error:
        raise broken(path, f"is no value change dump ({error}); export the capture again") from error


def _short_names(scopes: list[str], variables: list[VarDecl]) -> list[str]:
    """Name of each variable, with its scope where the name alone stands for several lines."""
    codes: dict[str, set[str]] = {}
    for variable in variables:
        codes.setdefault(variable.ref_str, set()).add(variable.id_code)
    names: dict[str, None] = {}
    for scope, variable in zip(scopes, variables, strict=True):
        name = variable.ref_str
        if len(codes[name]) > 1:
            name = f"{scope}.{name}"
        while name in names:
            name += " (again)"
        names[name] = None
    return list(names)


def _follow(
    path: Path, statements: Iterator[tuple[bytes, bytes]], by_code: dict[bytes, list[_Seen]], per_second: Fraction
) -> tuple[int, int]:
    """Fill the lines with what the body says, and return its first and last count."""
    begin, now = None, 0
    for value, code in statements:
        if value == b"#":
            later = int(code)
            if later >= 2**63:
                raise broken(path, f"holds a time of {later} units; more than 63 bits cannot be meant")
            if begin is None:
                begin = later
            elif later < now:
                raise goes_back(path, now / per_second)
            now = later
            continue
        for line in by_code.get(code, ()):
            if value in (b"0", b"1"):
                line.see(int(value), now)
            elif line.level is not None:
                raise lost(path, line.name, time_s=now / per_second)
    begin = begin or 0
    for line in (line for lines in by_code.values() for line in lines):
        if line.level is None or line.known_from > begin:
            raise lost(path, line.name, time_s=begin / per_second)
    return begin, now


def _statements(path: Path, words: Iterator[bytes]) -> Iterator[tuple[bytes, bytes]]:
    """Times as ``#`` and digits, changes as value and code of the line."""
    for word in words:
        first, rest = word[:1], word[1:]
        if first in b"01xXzZ" or (first == b"#" and rest.isdigit() and len(rest) < _MOST_DIGITS):
            yield first, rest
        elif first in b"bBrRsS":
            yield rest, next(words, b"")
        elif word == b"$comment":
            while next(words, b"$end") != b"$end":
                pass
        elif word not in _SKIPPED:
            text = word[:20].decode("ascii", "replace")
            raise broken(path, f"holds '{text}' among its changes; export the capture again")


def _words(path: Path, file: BinaryIO) -> Iterator[bytes]:
    """Words of the body, block by block."""
    last = b"\n"
    for last in bounded_lines(path, file):
        yield from last.split()
    if not last.endswith(b"\n"):
        raise cut_short(path, "ends in the middle of a line")

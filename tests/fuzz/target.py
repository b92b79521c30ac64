"""What a target of the fuzzer is, and the sanity that every refusal must keep."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mutations

from irtiming.errors import IrTimingError


@dataclass(frozen=True, kw_only=True)
class Target:
    """``take`` does with an input what the program does; only the project's own errors may come out.

    One that is slow for what it does, such as a database, has its turn in every ``round``-th round alone.
    """

    seeds: Callable[[], list[bytes]]
    take: Callable[[bytes], object]
    changes: tuple[mutations.Mutation, ...] = (mutations.of_bytes,)
    round: int = 1


def in_file(name: str, *takes: Callable[[Path], object]) -> Callable[[bytes], object]:
    """All of ``takes`` on a file with the input; what one refuses the next one gets all the same."""

    def take(data: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(data)
            for one in takes:
                try:
                    one(path)
                except IrTimingError as error:
                    require_sane(error)

    return take


def require_sane(error: IrTimingError) -> None:
    said = str(error)
    assert len(said) < 2100, f"a message of {len(said)} characters"
    assert said.isprintable(), f"a message with control characters: {said!r:.200}"


OF_TEXT = (mutations.of_words, mutations.of_words, mutations.of_bytes)
OF_JSON = (mutations.of_json, mutations.of_json, mutations.of_bytes)

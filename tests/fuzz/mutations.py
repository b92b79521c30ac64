"""Changes of valid inputs, drawn by a seeded generator: the same seed, the same inputs."""

import json
import random
from collections.abc import Callable, Sequence
from typing import Any

_LONG = 10_000
NUMBERS = (
    0, 1, -1, 2**31, 2**32 - 1, 2**62, 2**63, 2**64, 10**12, -(10**18), 1e308, -1e308, 5e-324, 1e-9, 0.1,
    float("nan"), float("inf"), float("-inf"), 10**400,
)  # fmt: skip
TEXTS = ("", "²", "nan", "x" * 3000, "\x1b[31m", "\0", "-1 s", "1e400", "9" * 5000, "../..", "[[[", "µs", "\ud7ff")


def of_bytes(rng: random.Random, seed: bytes, others: Sequence[bytes]) -> bytes:
    """One to eight changes: bits flipped, bytes set, pieces cut out, doubled, spliced in, numbers that lie, a cut end."""
    data = bytearray(seed)
    for _ in range(rng.choice((1, 1, 2, 3, 8))):
        at = rng.randrange(len(data) + 1)
        length = min(len(data) - at, rng.choice((1, 2, 4, 8, 64, 512)))
        match rng.randrange(8):
            case 0 if at < len(data):
                data[at] ^= 1 << rng.randrange(8)
            case 1:
                data[at : at + length] = bytes(rng.choice((0, 1, 0x7F, 0x80, 0xFF)) for _ in range(length))
            case 2:
                del data[at : at + length]
            case 3:
                data[at:at] = data[at : at + length] * rng.choice((1, 2, 50))
            case 4:
                donor = rng.choice(others)
                begin = rng.randrange(len(donor) + 1)
                data[at : at + length] = donor[begin : begin + length]
            case 5:
                n_bytes = rng.choice((2, 4, 8))
                number = rng.choice((0, 1, 2**15, 2**31 - 1, 2**32 - 1, 2**40, 2**63, 2**64 - 1)) % 256**n_bytes
                data[at : at + n_bytes] = number.to_bytes(n_bytes, rng.choice(("little", "big")))
            case 6:
                del data[at:]
            case _:
                data[at : at + length] = rng.randbytes(length)
    return bytes(data)


def of_words(rng: random.Random, seed: bytes, others: Sequence[bytes]) -> bytes:
    """A text with words taken out, put elsewhere, or in whose place something odd stands."""
    lines = [line.split(b" ") for line in seed.split(b"\n")]
    for _ in range(rng.choice((1, 1, 2, 4))):
        words = rng.choice(lines)
        at = rng.randrange(len(words))
        match rng.randrange(5):
            case 0:
                words[at] = str(rng.choice(NUMBERS)).encode()
            case 1:
                words[at] = rng.choice(TEXTS).encode("utf-8", "replace")
            case 2:
                del words[at:]
                words.append(b"")
            case 3:
                lines.insert(rng.randrange(len(lines)), list(words))
            case _:
                words[at] = words[at] * (rng.choice((2, 400)) if len(words[at]) < _LONG else 2)
    return b"\n".join(b" ".join(words) for words in lines)


def of_json(rng: random.Random, seed: bytes, others: Sequence[bytes]) -> bytes:
    """The same document with one to four values in whose place others stand, or keys that are gone or new."""
    content, many = json.loads(seed), 500
    for _ in range(rng.choice((1, 1, 2, 4))):
        place, key = _somewhere(rng, content)
        if place is None:
            continue
        match rng.randrange(4):
            case 0:
                place[key] = rng.choice((None, True, [], {}, *NUMBERS[:-1], *TEXTS[:-1]))
            case 1:
                n = rng.choice((1, 2, many))
                place[key], many = (
                    [place[key]] * n,
                    many if n < many else 3,
                )  # many of many are no file that anybody has
            case 2:
                del place[key]
            case _ if isinstance(place, dict):
                place[rng.choice(TEXTS[:-1])] = place[key]
    return json.dumps(content).encode()


def _somewhere(rng: random.Random, content: Any) -> tuple[Any, Any]:
    place, key = None, None
    while isinstance(content, dict | list) and content and (place is None or rng.random() < 0.75):
        place, key = content, rng.choice(list(content) if isinstance(content, dict) else range(len(content)))
        content = place[key]
    return place, key


Mutation = Callable[[random.Random, bytes, Sequence[bytes]], bytes]

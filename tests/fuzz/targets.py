"""What is fuzzed: for each kind of input some small valid ones, and the part of the program that takes them.

`FOUND` are inputs that once did harm; they are tried first, always.
"""

import json

import capture_files
import device_words
import frame_files
import recording_files
import result_files
import settings_files
from target import Target

TARGETS: dict[str, Target] = {
    **recording_files.TARGETS,
    **capture_files.TARGETS,
    **settings_files.TARGETS,
    **result_files.TARGETS,
    **device_words.TARGETS,
    **frame_files.TARGETS,
}


def _short_matrix() -> bytes:
    """A result whose matrix of correlations lacks the row of its last name."""
    content = json.loads(result_files.documents()["integrating"])
    content["correlation"]["matrix"].pop()
    return json.dumps(content).encode()


def _odd_share() -> bytes:
    """A result with a quantile of something that is no number."""
    return result_files.documents()["lagging"].replace(b'"0.05":', b'"0g5":')


FOUND: dict[str, list[bytes]] = {
    "rig.toml": [b"a = " + b"9" * 5000, b"a = " + b"[" * 5000],
    "result.json": [b'{"a": ' + b"9" * 5000 + b"}", b"[" * 100_000, _short_matrix(), _odd_share()],
    "plan.json": [b'{"a": ' + b"9" * 5000 + b"}", b"[" * 100_000],
    "journal": [b'{"a": ' + b"9" * 5000 + b"}", b"[" * 100_000],
    "state of a campaign": [b'{"a": ' + b"9" * 5000 + b"}", b"[" * 100_000],
    "list of recordings": [b"file\na\0.nxs\n", b"file\n" + b"x" * 200_000],
    "frames .pgm": [b"P5" + b"\n# " * 100 + b"?"],
}
"""Inputs that did harm once."""

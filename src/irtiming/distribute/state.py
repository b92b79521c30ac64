"""What of a campaign is done, in its folder: one result per unit of work, written whole or not at all.

The name of a unit's file is a checksum of everything that goes in: recordings, rig.toml, wheel calibration and program version.
So a restart does what is missing, and what changed, and nothing else; kill -9 at any moment costs the units that were under way.
"""

import hashlib
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, final

from irtiming.archive.json_file import make_folder, write_json
from irtiming.archive.nexus import program_version
from irtiming.archive.result_file import read_result, write_result
from irtiming.archive.result_model import Result
from irtiming.archive.typed_file import json_of
from irtiming.distribute.pieces import Seen
from irtiming.errors import ArchiveError

RESULTS, REFUSED = "results", "refused"
_KEY_LETTERS = 24


@final
class State:
    """Results and refusals in a campaign's folder.

    ``folder`` is made where it is not there.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        for name in (RESULTS, REFUSED):
            make_folder(folder / name)

    def path_of(self, key: str) -> Path:
        """Where the result of a unit is, or will be."""
        return self._folder / RESULTS / f"{key}.json"

    def result(self, key: str) -> Result | None:
        """The result of a unit; None where it is not there, or cannot be read and must be made anew."""
        path = self.path_of(key)
        if not path.exists():
            return None
        try:
            return read_result(path)
        except ArchiveError:
            return None

    def keep(self, key: str, result: Mapping[str, Any]) -> None:
        """Write the result of a unit."""
        write_result(result, self.path_of(key))

    def refusal(self, key: str) -> str | None:
        """Why a unit was refused before, which would be so again; None where it was not."""
        try:
            return str(
                json_of(self._folder / REFUSED / f"{key}.json", what="refusal of a unit", cure="delete it")["what"]
            )
        except (ArchiveError, KeyError, TypeError):
            return None

    def keep_refusal(self, key: str, what: str) -> None:
        """Write down why a unit is refused."""
        write_json({"what": what}, self._folder / REFUSED / f"{key}.json")


def key_of(unit: Sequence[Seen], *, rig_sha256: str, wheel_sha256: str) -> str:
    """Name of a unit: its camera for people, and a checksum of all that goes in."""
    parts = [*sorted(one.sha256 for one in unit), rig_sha256, wheel_sha256, program_version()]
    serial = re.sub(r"[^A-Za-z0-9]+", "-", unit[0].camera.serial_number).strip("-")[:_KEY_LETTERS]
    return f"{serial or 'camera'}-{hashlib.sha256(' '.join(parts).encode()).hexdigest()[:_KEY_LETTERS]}"

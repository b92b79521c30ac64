"""What has been done of a series, in a file beside its recordings: an interrupted series goes on from there."""

import hashlib
import os
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self, final
from uuid import uuid4

from irtiming.acquire.run_order import ENOUGH, RunOutcome
from irtiming.archive.json_file import write_json
from irtiming.archive.live.recording import COMPLETE
from irtiming.archive.typed_file import json_of
from irtiming.errors import ArchiveError
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.trigger_plan import TriggerPlan

NAME = "series.json"


@final
class Journal:
    """Series in a folder: its identity, the runs that were made, and what happened, written anew after each event."""

    def __init__(self, path: Path, content: dict[str, Any]) -> None:
        self._path = path
        self._content = content

    @classmethod
    def opened(cls, folder: Path, *, digest: str, n_runs: int) -> Self:
        """Journal of a folder, a new one where there is none; nothing is written yet.

        Raises
        ------
        ArchiveError
            If the folder holds another series, or its journal cannot be read.
        """
        path = folder / NAME
        if not path.exists():
            return cls(path, {"uid": str(uuid4()), "plan_digest": digest, "n_runs": n_runs, "runs": {}, "events": []})
        content = json_of(path, what="journal of a series", cure="name another folder")
        if not _is_journal(content):
            raise ArchiveError(f"{path}: is no journal of a series; name another folder")
        if content["plan_digest"] != digest:
            raise ArchiveError(
                f"{path}: belongs to another series (its plan or the camera's settings differ); name another folder, "
                "or go on with the plan that it was begun with"
            )
        return cls(path, content)

    @property
    def uid(self) -> str:
        """Of the series."""
        return str(self._content["uid"])

    def file_of(self, number: int) -> Path | None:
        """Recording of a run that is complete, or was enough, and still there; None for a run that is to be made."""
        entry = self._content["runs"].get(str(number))
        if entry is None or entry["ending"] not in (COMPLETE, ENOUGH):
            return None
        path = self._path.parent / entry["file"]
        return path if os.path.exists(path) else None

    def note(self, text: str) -> None:
        """Add an event.

        Raises
        ------
        ArchiveError
            If the journal cannot be written.
        """
        self._content["events"].append({"time": now_utc(), "text": text})
        write_json(self._content, self._path)

    def add(self, outcome: RunOutcome) -> None:
        """Add a run that has ended; one of the same number that was made before is replaced.

        Raises
        ------
        ArchiveError
            If the journal cannot be written.
        """
        verdict = outcome.verdict
        self._content["runs"][str(outcome.order.number)] = {
            "file": outcome.path.relative_to(self._path.parent).as_posix(),
            "ending": outcome.ending,
            "triggers": verdict.triggers,
            "frames": verdict.frames,
            "lost": verdict.lost,
            "missed": verdict.missed,
            "latency_s": verdict.latency_s,
            "overflowed": outcome.overflowed,
            "longest_queue": outcome.longest_queue,
            "stream": asdict(outcome.counts),
            "warnings": [finding.sentence() for finding in outcome.findings],
            "findings": [asdict(finding) for finding in outcome.findings],
        }
        self.note(f"run {outcome.order.number}: {outcome.ending}")

    def as_json(self) -> dict[str, Any]:
        """All of it as plain data."""
        return dict(self._content)


def _is_journal(content: object) -> bool:
    """Whether it has all that is asked of a journal, each of its kind."""
    if not isinstance(content, dict):
        return False
    runs, keys = content.get("runs"), (content.get("uid"), content.get("plan_digest"))
    if not isinstance(runs, dict) or not isinstance(content.get("events"), list) or not _are_texts(*keys):
        return False
    return all(isinstance(run, dict) and _are_texts(run.get("file"), run.get("ending")) for run in runs.values())


def _are_texts(*values: object) -> bool:
    return all(isinstance(value, str) for value in values)


def digest_of(plan: SeriesPlan, triggers: TriggerPlan) -> str:
    """What makes two series the same: runs, camera settings, temperatures and references, but not where the devices are."""
    same = (plan.camera, plan.wiring, plan.blackbody, plan.references, triggers)
    return hashlib.sha256(repr(same).encode()).hexdigest()


def now_utc() -> str:
    """Time now in ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")

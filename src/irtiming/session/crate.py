"""Everything that it takes to repeat an analysis, as one RO-Crate 1.1 (a zip): recordings, rig.toml, results, certificates."""

import hashlib
import json
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path, PurePath
from pprint import pformat
from typing import Any

from irtiming.archive.checksum import sha256_of
from irtiming.archive.whole_file import whole_file
from irtiming.errors import ArchiveError
from irtiming.report.calibration.content import MeasuredItem, Sheet

_KINDS = {".pdf": "application/pdf", ".html": "text/html", ".xml": "application/xml", ".json": "application/json",
          ".toml": "application/toml", ".nxs": "application/x-hdf5", ".py": "text/x-python", ".txt": "text/plain"}  # fmt: skip
_USUAL = {
    "threshold": "threshold_dn",
    "substrate_temperature": "substrate_temperature_k",
    "wheel_temperature": "wheel_temperature_k",
}
_NO_CHOICE = ("search_started_at", "fit_arrived_at")
_SELF = "irtiming"
_FROM_SOURCES = """\
# irtiming {versions} made the results. There is no release of it yet, so no index has it: it is installed from its
# sources, with all else that stands here in the versions of the analysis, by
#
#     pip install FOLDER-OF-ITS-SOURCES -r requirements.txt
#
# where the folder is the one with pyproject.toml of that version in it.
"""
_REPEAT = '''"""Repeat the analyses of this crate: install what requirements.txt says, as it says, then python repeat.py"""

import irtiming

ANALYSES = {analyses}

for name, (recordings, rig, choices) in ANALYSES.items():
    lists = {{key: tuple(value) if isinstance(value, list) else value for key, value in choices.items()}}
    found = irtiming.analyse(recordings, rig, choices=irtiming.Choices(**lists))
    said = irtiming.read_result(name)
    for parameter in said:
        off = abs(found[parameter].value - said[parameter].value) / said[parameter].u
        print(f"{{name}} {{parameter}}: {{found[parameter]}}, {{off:.1e}} u from what the result says")
'''


def write(
    sheet: Sheet, path: Path, *, results: Sequence[Path], form: Path, certificates: Mapping[Path, str | bytes]
) -> None:
    """Write the crate, complete or not at all.

    Parameters
    ----------
    sheet
        The certificate.
    path
        Zip to write.
    results, form
        Results and certificate.toml behind it.
    certificates
        What was written of it, by name.

    Raises
    ------
    ArchiveError
        If a recording or rig.toml is no longer where the result says, or has changed since.
    """
    parts: dict[str, Path | bytes] = {}
    analyses: dict[str, Any] = {}
    for number, (file, one) in enumerate(zip(results, sheet.results, strict=True), 1):
        _refuse_foreign_slots(one)
        folder = f"analysis{number}"
        inside = f"{folder}/{file.name}"
        parts[inside] = file
        recordings = []
        for each in one.result.inputs:
            name = f"{folder}/{PurePath(each.file).name}"
            if name in parts:
                raise ArchiveError(
                    f"two recordings of {file} are called {PurePath(each.file).name}; rename one, and analyse again"
                )
            parts[name] = _found(each.file, each.sha256, beside=file.parent)
            recordings.append(name)
        rig = f"{folder}/rig.toml"
        parts[rig] = _found(one.result.rig.file, one.result.rig.sha256, beside=file.parent)
        analyses[inside] = (recordings, rig, _choices(one))
    parts["certificate.toml"] = form
    parts |= {f"certificate/{place.name}": _bytes(content) for place, content in certificates.items()}
    parts["repeat.py"] = _REPEAT.format(analyses=pformat(analyses, width=110, sort_dicts=False)).encode()
    parts["requirements.txt"] = _requirements(sheet).encode()
    described = _described(sheet, parts)
    with whole_file(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_STORED, allowZip64=True) as crate:
        crate.writestr("ro-crate-metadata.json", json.dumps(described, indent=1, ensure_ascii=False))
        for name, content in parts.items():
            crate.write(content, name) if isinstance(content, Path) else crate.writestr(name, content)


def _refuse_foreign_slots(one: MeasuredItem) -> None:
    """Slots that other recordings determined are not in the crate."""
    slots_from = (one.result.wheel or {}).get("slots_from")
    if isinstance(slots_from, list) and len(slots_from) > len(one.result.inputs):
        raise ArchiveError(
            f"{one.file.name} took slots of the wheel from {len(slots_from)} recordings, its own "
            f"{len(one.result.inputs)} among them, and the crate would lack the others; "
            "analyse without --wheel-calibration for a crate"
        )


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def _found(file: str, sha256: str, *, beside: Path) -> Path:
    """The file that a result names, from here or from beside the result; as it was."""
    places = [Path(file), beside / PurePath(file).name]
    there = [place for place in places if place.is_file()]
    same = next((place for place in there if not sha256 or sha256_of(place) == sha256), None)
    if same is not None:
        return same
    if there:
        raise ArchiveError(f"{there[0]} has changed since the analysis (its SHA-256 is another); analyse it again")
    raise ArchiveError(
        f"{file} is not there, but the crate needs it; put it where the result says, or beside the result"
    )


def _choices(one: MeasuredItem) -> dict[str, Any]:
    """What a person decided, as `Choices` has it."""
    said = one.result.choices
    chosen = {
        _USUAL.get(name, name): value for name, value in said.items() if value is not None and name not in _NO_CHOICE
    }
    if one.result.method == "published":
        chosen["method"] = "published"
    return chosen


def _requirements(sheet: Sheet) -> str:
    """The versions that made the results; those of irtiming stand in a comment, since no index has it yet."""
    named = {name: version for one in sheet.results for name, version in one.result.software.items()}
    own = sorted({one.result.software[_SELF] for one in sheet.results if _SELF in one.result.software})
    head = _FROM_SOURCES.format(versions=" and ".join(own) or "the version in the results")
    others = (name for name in named if name not in ("python", "platform", _SELF))
    return head + "".join(f"{name}=={named[name]}\n" for name in others)


def _described(sheet: Sheet, parts: Mapping[str, Path | bytes]) -> dict[str, Any]:
    """The metadata of RO-Crate 1.1."""
    laboratory, head = sheet.form.laboratory, sheet.form.certificate
    return {
        "@context": "https://w3id.org/ro/crate/1.1/context",
        "@graph": [
            {
                "@id": "ro-crate-metadata.json", "@type": "CreativeWork", "about": {"@id": "./"},
                "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
            },
            {
                "@id": "./", "@type": "Dataset", "name": f"Calibration certificate {head.number} with its evidence",
                "description": "Recordings, rig, results and certificate; repeat.py repeats the analyses.",
                "datePublished": head.issued.isoformat(), "dateCreated": datetime.now(UTC).isoformat(timespec="seconds"),
                "license": "As agreed between laboratory and customer.",
                "identifier": head.number, "creator": {"@id": "#laboratory"}, "hasPart": [{"@id": name} for name in parts],
            },
            {"@id": "#laboratory", "@type": "Organization", "name": laboratory.name, "email": laboratory.email},
            *_files(parts),
            {
                "@id": "#analysis", "@type": "CreateAction", "name": "irtiming analyse",
                "instrument": {"@id": "#irtiming"},
                "object": [{"@id": name} for name in parts if name.endswith((".nxs", "rig.toml"))],
                "result": [{"@id": name} for name in parts if name.endswith(".json")],
            },
            {
                "@id": "#irtiming", "@type": "SoftwareApplication", "name": "irtiming",
                "softwareVersion": sheet.results[0].result.software.get("irtiming", ""),
            },
        ],
    }  # fmt: skip


def _files(parts: Mapping[str, Path | bytes]) -> Iterator[dict[str, Any]]:
    for name, content in parts.items():
        size = content.stat().st_size if isinstance(content, Path) else len(content)
        sha256 = sha256_of(content) if isinstance(content, Path) else hashlib.sha256(content).hexdigest()
        kind = _KINDS.get(PurePath(name).suffix.lower(), "application/octet-stream")
        yield {
            "@id": name, "@type": "File", "name": PurePath(name).name, "encodingFormat": kind, "contentSize": str(size),
            "sha256": sha256,
        }  # fmt: skip

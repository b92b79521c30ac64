"""Certificates of hand-made results, for the tests beside."""

import copy
import hashlib
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from irtiming.archive.certificate_file import CertificateFile
from irtiming.archive.result_file import checked_result
from irtiming.records.analysis import Analysis
from irtiming.records.camera_frame import CameraIdentity
from irtiming.report.calibration.content import ResultFile, Sheet, collect
from irtiming.report.result import result

EXAMPLE = Path(__file__).parents[3] / "examples" / "certificate.toml"
EVERY_KEY = {
    "certificate": {"replaces": "2026-0814", "amendment": "the customer's address", "remarks": ["made for a test"]},
    "method": {"sampling": "every run", "external": "angles, by others", "customer_data": "the data sheet"},
    "item": {"adjusted": "none between the runs"},
}


def form(**changes: dict[str, Any]) -> CertificateFile:
    """The example's file with keys of sections changed, or left out where the value is None."""
    table: dict[str, Any] = tomllib.loads(EXAMPLE.read_text())
    for section, keys in copy.deepcopy(changes).items():
        if not isinstance(keys, dict):
            table[section] = keys
            continue
        table.setdefault(section, {}).update(keys)
        table[section] = {key: value for key, value in table[section].items() if value is not None}
    return CertificateFile.model_validate(table)


def result_file(analysis: Analysis, name: str = "result.json", *, camera: CameraIdentity | None = None) -> ResultFile:
    """Its result as if read from a file; all recordings name the camera, where one is given."""
    if camera is not None:
        named = tuple(replace(one, camera=camera) for one in analysis.recordings)
        analysis = replace(analysis, recordings=named)
    content = checked_result(result(analysis))
    return ResultFile(name=name, sha256=hashlib.sha256(content.model_dump_json().encode()).hexdigest(), content=content)


def sheet(analysis: Analysis, **changes: dict[str, Any]) -> Sheet:
    """The certificate of one result."""
    return collect([result_file(analysis)], form(**changes))

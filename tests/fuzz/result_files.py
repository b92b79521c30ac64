"""Results, and everything that is made of them: certificates, plain words, times of frames, a register."""

import random
import sqlite3
import tempfile
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from typing import get_args
from xml.etree import ElementTree

import documents as written
import mutations
from target import OF_JSON, OF_TEXT, Target, in_file

from irtiming.apply import camera_timing, export, handover
from irtiming.archive.certificate_check import check_certificate
from irtiming.archive.certificate_file import read_certificate_file
from irtiming.archive.register import entries
from irtiming.archive.result_camera import read_camera
from irtiming.archive.result_file import read_result
from irtiming.errors import IrTimingError
from irtiming.estimate.series import over_settings, points
from irtiming.records.application import Program
from irtiming.report import series_page
from irtiming.report.calibration import dcc, page
from irtiming.report.calibration.content import ResultFile, Sheet, collect
from irtiming.session import hand_over, history
from irtiming.session.apply_time import TimeOrder, apply_time
from irtiming.session.frame_stamps import StampsWanted
from irtiming.session.history import HistoryOrder
from irtiming.web.certificate_form import rest_of

EXAMPLES = Path(__file__).parents[2] / "examples"
_STAMPS = "\n".join(f"{1 + 0.033 * k:.6f}" for k in range(20))


@cache
def documents() -> dict[str, bytes]:
    """Results, written by hand."""
    return written.documents()


def _results() -> list[bytes]:
    return [documents()[name] for name in ("result", "lagging", "integrating")]


def _hand_over(path: Path) -> None:
    given = handover.of_camera(camera_timing.of_result(read_result(path)))
    for program in get_args(Program):
        with suppress(IrTimingError):
            export.text_for(program, given)


def _applied(path: Path) -> None:
    """Times of frames by stamps of the kind that the result counts from."""
    stamps = path.with_suffix(".csv")
    stamps.write_text(f"t_s\n{_STAMPS}\n")
    apply_time(TimeOrder(result=path, stamps=StampsWanted(source=stamps, unit="s"), out=path.with_name("times.csv")))


def _compared(path: Path) -> None:
    found = [points.point(read_result(one), label=one.name) for one in (path, path)]
    series = over_settings.by_camera(found)
    series_page.as_json(series)
    series_page.page(series)


def _entered(path: Path) -> None:
    register = str(path.with_name("r.sqlite"))
    history.add([path], register)
    for one in history.cameras(register):
        history.of_camera(
            HistoryOrder(serial_number=one.serial_number, register=register, history=path.with_suffix(".h"))
        )


def _certified(path: Path) -> Sheet:
    """A certificate of a result, as a page and as XML."""
    form = read_certificate_file(EXAMPLES / "certificate.toml")
    sheet = collect([ResultFile(name=path.name, sha256="0" * 64, content=read_result(path))], form)
    ElementTree.fromstring(dcc.xml(sheet, page=page.html(sheet, beside=path.parent)))
    return sheet


@cache
def _certificate() -> bytes:
    """Of the result among the documents."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "r.json"
        path.write_bytes(documents()["result"])
        return dcc.xml(_certified(path)).encode()


@cache
def _register() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "r.json"
        path.write_bytes(documents()["integrating"])
        _entered(path)
        return path.with_name("r.sqlite").read_bytes()


def _known(path: Path) -> None:
    """What a register knows of each camera in it."""
    for one in entries.cameras(str(path)):
        history.of_camera(
            HistoryOrder(serial_number=one.serial_number, register=str(path), history=path.with_suffix(".json"))
        )


def _of_register(rng: random.Random, seed: bytes, _: object) -> bytes:
    """The register with one to four cells in whose place something else stands, of whatever type."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "r.sqlite"
        path.write_bytes(seed)
        with closing(sqlite3.connect(path, isolation_level=None)) as register:
            for _ in range(rng.choice((1, 1, 2, 4))):
                (table,) = rng.choice(
                    register.execute("select name from sqlite_master where type = 'table'").fetchall()
                )
                columns = [one[1] for one in register.execute(f'pragma table_info("{table}")')]
                odd = rng.choice((b"\xa6", "", "nan", 1e308, -1, 2**62, "x" * 3000, "\x1b[31m", 0.1))
                with suppress(sqlite3.Error):
                    register.execute(f'update "{table}" set "{rng.choice(columns)}" = ?', (odd,))
        return path.read_bytes()


TARGETS = {
    "result.json": Target(
        seeds=_results,
        take=in_file("r.json", read_result, _hand_over, hand_over.explain, read_camera, _applied),
        changes=OF_JSON,
    ),
    "results over settings": Target(seeds=_results, take=in_file("r.json", _compared), changes=OF_JSON),
    "result into a register": Target(seeds=_results, take=in_file("r.json", _entered), changes=OF_JSON, round=32),
    "register": Target(
        seeds=lambda: [_register()],
        take=in_file("r.sqlite", _known),
        changes=(mutations.of_bytes, _of_register),
        round=16,
    ),
    "certificate.toml": Target(
        seeds=lambda: [(EXAMPLES / "certificate.toml").read_bytes()],
        take=in_file(
            "certificate.toml",
            read_certificate_file,
            lambda path: rest_of(path.read_text(encoding="utf-8", errors="replace")),
        ),
        changes=OF_TEXT,
    ),
    "certificate of a result": Target(seeds=_results, take=in_file("r.json", _certified), changes=OF_JSON, round=8),
    "certificate.xml": Target(
        seeds=lambda: [_certificate()], take=in_file("certificate.xml", check_certificate), changes=OF_TEXT
    ),
}

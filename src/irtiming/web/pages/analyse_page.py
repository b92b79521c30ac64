"""Analysing: recordings in, and out come what is doubtful first, then the timing, then the report."""

import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import ui

from irtiming.archive import layout
from irtiming.errors import IrTimingError
from irtiming.web import files, frame, one_job, show
from irtiming.web.desk import Desk
from irtiming.web.orders import AnalyseOrder

RESULTS = "results"
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_METHODS = {"pixel-sum": "the project's own", "published": "as published in 2023"}


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/analyse")
    def analyse(result: str = "") -> None:
        with frame.page(desk, "/analyse"):
            if result:
                _result(desk, result)
            with show.card("Analyse recordings"):
                _form(desk)
            with show.card("Results"):
                _results(desk)


def _form(desk: Desk) -> None:
    recordings = [one for one in desk.folder.files(".nxs") if one.parent.name not in layout.NOT_MEASURED]
    newest = of_one_series(recordings)
    names = [desk.folder.name_of(one) for one in recordings]
    rigs = [desk.folder.name_of(one) for one in desk.folder.files("rig.toml")]
    with ui.element("div").classes("form"):
        chosen = ui.select(
            names, multiple=True, value=[desk.folder.name_of(one) for one in newest], label="Recordings of one camera"
        )
        chosen.props("use-chips").style("grid-column: 1 / -1").mark("recordings")
        rig = ui.select(rigs, value=rigs[0] if rigs else None, label="What was measured on the rig")
        method = ui.select(_METHODS, value="pixel-sum", label="Method")
        language = show.language("Language of the report")
        name = ui.input("Name of the result", value=newest[0].parent.name if newest else "result")

    def start() -> None:
        try:
            if not chosen.value:
                raise IrTimingError("no recording is chosen; choose one or more")
            result = desk.folder.free(f"{name.value or 'result'}.json", within=RESULTS, beside=(".html",))
            order = AnalyseOrder(
                recordings=tuple(desk.folder.existing(str(one)) for one in chosen.value),
                rig=desk.folder.existing(str(rig.value or "")),
                method=str(method.value),
                language=language.value,
                result=result,
                report=result.with_suffix(".html"),
            )
            desk.jobs.start("analysis", f"the analysis {name.value}", task="analysis:analyse", order=order)
        except IrTimingError as error:
            show.complain(error)

    one_job.controls(
        desk, "analysis", label="Analyse", start=start, goes_on="goes on; closing this page stops nothing",
        address=lambda answer: f"/analyse?result={quote(desk.folder.name_of(Path(answer['result'])))}",
    )  # fmt: skip


def of_one_series(recordings: Sequence[Path]) -> list[Path]:
    """The first, and those of its folder that are named alike but for their numbers: of another camera, perhaps, are the others.

    Parameters
    ----------
    recordings
        The newest first; no file is opened, which is for a process of its own.
    """
    names = [(one.parent, _NUMBER.sub("", one.stem)) for one in recordings]
    return [one for one, name in zip(recordings, names, strict=True) if name == names[0]]


def _results(desk: Desk) -> None:
    found = desk.folder.files(".json")
    found = [one for one in found if one.parent.name == RESULTS]
    if not found:
        ui.label("None yet.").classes("note")
        return
    names = map(desk.folder.name_of, found[:50])
    show.html(show.links_html({f"/analyse?result={quote(name)}": Path(name).stem for name in names}))


def _result(desk: Desk, name: str) -> None:
    """A result: what is doubtful first, then the numbers, then the report."""
    try:
        path = desk.folder.existing(name)
    except IrTimingError as error:
        show.html(show.finding_html("error", str(error)))
        return
    report = path.with_suffix(".html")
    with show.card(f"Result: {path.stem}"):
        body = show.html('<p class="note">reading …</p>')
        with ui.element("div").classes("actions"):
            ui.link("Save the result (JSON)", files.link(desk, path)).classes("button")
            if report.is_file():
                ui.link("Open the report", files.link(desk, report), new_tab=True).classes("button")
            ui.link("Make a certificate", f"/certificate?result={quote(name)}").classes("button")
    if report.is_file():
        with show.card("Report"):
            show.html(f'<iframe class="inside" title="report" src="{escape(files.link(desk, report))}"></iframe>')

    async def read() -> None:
        found = await desk.ask("analysis:read", path)
        show.put(body, _told(found.answer) if found.is_good else show.finding_html("error", found.text))

    ui.timer(0.05, read, once=True)


def _told(result: dict[str, Any]) -> str:
    findings, parts = result["findings"], []
    doubts = [one for one in findings if one["severity"] not in ("ok", "info")]
    notes = [one for one in findings if one["severity"] in ("ok", "info")]
    parts.append(show.findings_html(doubts) or show.finding_html("ok", "nothing is doubtful", title="findings:"))
    if notes:
        parts.append(f"<details><summary>{len(notes)} more notes</summary>{show.findings_html(notes)}</details>")
    if result["is_simulated"]:
        parts.append(show.finding_html("info", "the camera is a simulated one", title="mark:"))
    parts.append(f'<div class="verdict"><p>{escape(result["headline"])}</p></div>')
    parts.append(show.table_html(["", "value ± standard uncertainty", "what it is"], result["parameters"]))
    if len(result["relative_delays"]) > 1:
        parts.append(show.table_html(["recording", "relative delay"], result["relative_delays"]))
    return "".join(parts)

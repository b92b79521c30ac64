"""A certificate: what the laboratory states, a preview, and the files to hand over."""

from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import final

from nicegui import ui

from irtiming.archive.json_file import write_atomically
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.web import files, frame, show
from irtiming.web.certificate_form import FIELDS, MORE, as_toml, rest_of
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job
from irtiming.web.orders import CertifyOrder
from irtiming.web.pages.analyse_page import RESULTS

PLACE = "certificates"
PREVIEW = "preview"


@final
@dataclass(frozen=True, kw_only=True)
class _Form:
    """What a person fills in: results, fields by their names, and further sections of certificate.toml."""

    results: ui.select
    fields: dict[str, ui.input]
    more: ui.textarea

    def order(self, desk: Desk, suffixes: tuple[str, ...], *, name: str) -> CertifyOrder:
        """The order, with certificate.toml written beside the files that are wanted.

        Raises
        ------
        IrTimingError
            If no result is chosen, or a name is that of no file.
        """
        if not self.results.value:
            raise ArchiveError("no result is chosen; choose one, or analyse recordings first")
        values = {key: str(field.value or "") for key, field in self.fields.items()}
        place = desk.folder.inside(PLACE)
        place.mkdir(exist_ok=True)
        form = place / f"{name}.toml"
        write_atomically(as_toml(values, str(self.more.value or "")), form)
        return CertifyOrder(
            results=tuple(desk.folder.existing(str(one)) for one in self.results.value),
            form=form,
            out=tuple(place / f"{name}{suffix}" for suffix in suffixes),
        )


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/certificate")
    def certificate(result: str = "") -> None:
        with frame.page(desk, "/certificate"), show.columns("wide-right"):
            with show.card("What stands on it"):
                form = _form(desk, result)
            with show.card("Certificate"):
                _deeds(desk, form)
        ui.timer(0.05, lambda: _fill_in(desk, form), once=True)


def _form(desk: Desk, result: str) -> _Form:
    names = [desk.folder.name_of(one) for one in desk.folder.files(".json") if one.parent.name == RESULTS]
    chosen = [result] if result in names else names[:1]
    results = ui.select(names, multiple=True, value=chosen, label="Results").props("use-chips").classes("wide")
    if not names:
        show.html(show.finding_html("info", "there is no result yet", cure="Analyse recordings first."))
    fields: dict[str, ui.input] = {}
    for title, group in FIELDS.items():
        with ui.element("h3"):
            ui.label(title)
        with ui.element("div").classes("form narrow"):
            fields |= {one.name: ui.input(one.label).mark(one.name) for one in group}
    fields["certificate.issued"].set_value(datetime.now(UTC).date().isoformat())
    fields["certificate.language"].set_value("en")
    with ui.element("h3"):
        ui.label("More, as in certificate.toml")
    more = ui.textarea(value=MORE).props('autogrow outlined aria-label="more of certificate.toml"').classes("wide mono")
    return _Form(results=results, fields=fields, more=more)


async def _fill_in(desk: Desk, form: _Form) -> None:
    """What the laboratory stated last; number and day are new on each certificate."""
    earlier = [one for one in desk.folder.files(".toml") if one.parent.name == PLACE or one.name == "certificate.toml"]
    if not earlier:
        return
    found = await desk.ask("certificates:form_of", earlier[0])
    if not found.is_good:
        return
    answer = found.answer | {"person": found.answer["person"][0]}
    for name, field in form.fields.items():
        section, _, key = name.partition(".")
        if name not in ("certificate.number", "certificate.issued") and answer[section].get(key):
            field.set_value(str(answer[section][key]))
    form.more.set_value(rest_of(earlier[0].read_text(encoding="utf-8")))


def _deeds(desk: Desk, form: _Form) -> None:
    """Preview and files, and what came of them."""
    jobs: list[Job] = []
    shown = [""]

    def make(suffixes: tuple[str, ...], name: str) -> None:
        try:
            order = form.order(desk, suffixes, name=name)
            jobs.append(
                desk.jobs.start("certificate", f"the certificate {name}", task="certificates:make", order=order)
            )
        except (IrTimingError, OSError) as error:
            show.complain(error)

    def files_to_hand_over() -> None:
        number = str(form.fields["certificate.number"].value or "").strip()
        if not number:
            show.complain("the certificate has no number; give it one")
            return
        name = desk.folder.free(f"{number.replace('.', '-')}.pdf", within=PLACE, beside=(".xml", ".html")).stem
        make((".pdf", ".xml", ".html"), name)

    with ui.element("div").classes("actions"):
        ui.button("Preview", on_click=lambda: make((".html",), PREVIEW)).props("outline color=primary")
        ui.button("Make PDF and XML", on_click=files_to_hand_over).props("unelevated color=primary")
    said = show.html(
        '<p class="note">The preview shows here. Nothing is computed anew: each number stands in the result.</p>'
    )
    preview = show.html()

    def refresh() -> None:
        if not jobs:
            return
        job = jobs[-1]
        show.put(said, _said(desk, job))
        if job.ending is not None and job.ending.is_good and shown[0] != str(id(job)):
            shown[0] = str(id(job))
            page = next(Path(one) for one in job.ending.answer["out"] if one.endswith(".html"))
            address = f"{files.link(desk, page)}&n={page.stat().st_mtime_ns}"
            show.put(preview, f'<iframe class="inside" title="certificate" src="{escape(address)}"></iframe>')

    ui.timer(0.3, refresh)


def _said(desk: Desk, job: Job) -> str:
    if job.ending is None:
        return '<p class="note">being made …</p>'
    if not job.ending.is_good:
        return show.finding_html("error", job.ending.text)
    answer = job.ending.answer
    made = [Path(one) for one in answer["out"]]
    mark = (
        show.finding_html("warning", "a specimen, for the camera is simulated", title="mark:")
        if answer["is_simulated"]
        else ""
    )
    if made[0].stem == PREVIEW:
        return mark
    links = " ".join(f'<a class="button" href="{escape(files.link(desk, one))}">{escape(one.name)}</a>' for one in made)
    return mark + f'<div class="actions">{links}</div>'

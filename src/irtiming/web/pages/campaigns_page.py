"""Campaigns: recordings of many cameras in, and out come one table, one page, and the register of results."""

from html import escape
from pathlib import Path
from urllib.parse import quote

from nicegui import ui

from irtiming.errors import IrTimingError
from irtiming.web import files, frame, one_job, show
from irtiming.web.desk import Desk
from irtiming.web.orders import CampaignOrder

CAMPAIGNS, PAGE, REGISTER = "campaigns", "campaign.html", "register.sqlite"
_KEPT = ("table.csv", "table.parquet", "campaign.json")
_NO_LIMITS = "(none: nothing is judged)"


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/campaigns")
    def campaigns(result: str = "") -> None:
        with frame.page(desk, "/campaigns"):
            if result:
                _result(desk, result)
            with show.card("Measure many cameras"):
                _form(desk)
            with show.card("Campaigns"):
                _results(desk)


def _form(desk: Desk) -> None:
    folders = dict.fromkeys(one.parent for one in desk.folder.files(".nxs") if one.parent != desk.folder.root)
    lists = [one for one in desk.folder.files(".csv") if CAMPAIGNS not in one.parts]
    sources = [desk.folder.name_of(one) for one in (*folders, *lists)]
    rigs = [desk.folder.name_of(one) for one in desk.folder.files("rig.toml")]
    limits = [desk.folder.name_of(one) for one in desk.folder.files("limits.toml")]
    with ui.element("div").classes("form"):
        source = ui.select(
            sources, value=sources[0] if sources else None, label="Folder of recordings, or a CSV that lists them"
        )
        rig = ui.select(rigs, value=rigs[0] if rigs else None, label="What was measured on the rig")
        limit = ui.select(
            [_NO_LIMITS, *limits], value=limits[0] if limits else _NO_LIMITS, label="Limits (limits.toml)"
        )
        language = show.language("Language of the page")
        workers = ui.number("Processes", value=1, min=1, max=64, precision=0)
        name = ui.input("Name of the campaign; the same name goes on", value="campaign")

    def start() -> None:
        try:
            wanted = str(name.value or "campaign").strip()
            order = CampaignOrder(
                source=desk.folder.existing(str(source.value or "")),
                rig=desk.folder.existing(str(rig.value or "")),
                out=desk.folder.inside(f"{CAMPAIGNS}/{wanted}"),
                register=desk.folder.inside(REGISTER),
                limits=None if limit.value == _NO_LIMITS else desk.folder.existing(str(limit.value)),
                workers=int(workers.value or 1),
                language=language.value,
            )
            desk.jobs.start("campaign", f"the campaign {wanted}", task="campaigns:measure", order=order)
        except IrTimingError as error:
            show.complain(error)

    one_job.controls(
        desk, "campaign", label="Measure", start=start,
        goes_on="goes on; closing this page stops nothing, and what is done stays done",
        address=lambda answer: f"/campaigns?result={quote(desk.folder.name_of(Path(answer['page'])))}",
    )  # fmt: skip


def _results(desk: Desk) -> None:
    found = [one for one in desk.folder.files(".html") if one.name == PAGE]
    if not found:
        ui.label("None yet.").classes("note")
        return
    names = map(desk.folder.name_of, found[:50])
    show.html(show.links_html({f"/campaigns?result={quote(name)}": Path(name).parent.name for name in names}))


def _result(desk: Desk, name: str) -> None:
    """A campaign: its page, and its files to keep."""
    try:
        path = desk.folder.existing(name)
    except IrTimingError as error:
        show.html(show.finding_html("error", str(error)))
        return
    with show.card(f"Campaign: {path.parent.name}"):
        with ui.element("div").classes("actions"):
            ui.link("Open the page", files.link(desk, path), new_tab=True).classes("button")
            for kept in (path.with_name(one) for one in _KEPT):
                if kept.is_file():
                    ui.link(f"Save {kept.name}", files.link(desk, kept)).classes("button")
        show.html(f'<iframe class="inside" title="campaign" src="{escape(files.link(desk, path))}"></iframe>')

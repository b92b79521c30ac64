"""History: what the register of results knows of a camera, its control charts, and its drift since the last calibration."""

from html import escape
from typing import Any

from nicegui import ui

from irtiming.errors import IrTimingError
from irtiming.web import frame, show
from irtiming.web.desk import Desk
from irtiming.web.orders import EnterOrder, HistoryOrder
from irtiming.web.pages.analyse_page import RESULTS
from irtiming.web.pages.campaigns_page import REGISTER

_NO_DRIFT = "no drift yet: that takes results of two days at one setting"
_NO_CHART = "no control chart yet: that takes four results at one setting"


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/history")
    def history(camera: str = "") -> None:
        with frame.page(desk, "/history"):
            with show.card("Camera"):
                choose = _choice(desk, camera)
            with show.card("Enter results"):
                _entry(desk, done=choose)


def _choice(desk: Desk, camera: str) -> Any:
    """Camera, register and day; below them what is known. Gives what asks for the cameras anew."""
    registers = [desk.folder.name_of(one) for one in desk.folder.files(".sqlite")] or [REGISTER]
    with ui.element("div").classes("form"):
        serial = ui.select([], label="Serial number")
        register = ui.select(
            registers, value=REGISTER if REGISTER in registers else registers[0], label="Register of results"
        )
        since = ui.input("Drift since (a day)")
    said = show.html()
    with ui.element("div").props("aria-live=polite"):
        body = show.html()

    async def ask_cameras(wanted: str = camera) -> None:
        try:
            path = desk.folder.inside(str(register.value))
        except IrTimingError as error:
            show.complain(error)
            return
        if not path.is_file():
            show.put(
                said,
                show.finding_html("info", "there is no register yet", cure="Enter results, or measure a campaign."),
            )
            return
        found = await desk.ask("history:cameras", path)
        if not found.is_good:
            show.put(said, show.finding_html("error", found.text))
            return
        show.put(said, "")
        names = {one["serial_number"]: _name(one) for one in found.answer}
        chosen = next((one for one in (wanted, serial.value, *names) if one in names), None)
        if chosen == serial.value:
            await ask_history()
        serial.set_options(names, value=chosen)

    async def ask_history() -> None:
        if not serial.value:
            show.put(body, "")
            return
        try:
            order = HistoryOrder(
                register=desk.folder.existing(str(register.value)), serial_number=str(serial.value),
                since=str(since.value or ""),
            )  # fmt: skip
        except IrTimingError as error:
            show.complain(error)
            return
        show.put(body, '<p class="note">reading …</p>')
        found = await desk.ask("history:of_camera", order)
        show.put(body, _told(found.answer) if found.is_good else show.finding_html("error", found.text))

    serial.on_value_change(ask_history)
    register.on_value_change(lambda: ask_cameras())
    since.on("keydown.enter", ask_history)
    since.on("blur", ask_history)
    ui.timer(0.05, lambda: ask_cameras(), once=True)
    return ask_cameras


def _entry(desk: Desk, *, done: Any) -> None:
    """Results of single analyses; a campaign enters its own."""
    results = [desk.folder.name_of(one) for one in desk.folder.files(".json") if one.parent.name == RESULTS]
    chosen = ui.select(results, multiple=True, value=results[:1], label="Results").props("use-chips").classes("wide")
    said = show.html('<p class="note">A campaign enters its own results.</p>')

    async def enter() -> None:
        try:
            if not chosen.value:
                raise IrTimingError("no result is chosen; choose one or more")
            paths = tuple(desk.folder.existing(str(one)) for one in chosen.value)
            found = await desk.ask("history:enter", EnterOrder(results=paths, register=desk.folder.inside(REGISTER)))
        except IrTimingError as error:
            show.complain(error)
            return
        if not found.is_good:
            show.put(said, show.finding_html("error", found.text))
            return
        show.put(said, show.finding_html("ok", f"{found.answer['new']} new of {len(paths)}", title="entered:"))
        await done(found.answer["serial_number"])

    with ui.element("div").classes("actions"):
        ui.button("Enter", on_click=enter).props("unelevated color=primary")


def _name(one: dict[str, Any]) -> str:
    n = one["n_results"]
    return " ".join(filter(None, (one["serial_number"], one["model"]))) + f" ({n} result{'' if n == 1 else 's'})"


def _told(found: dict[str, Any]) -> str:
    """Drift first, then the charts, then every result."""
    parts = [show.finding_html("info", "of a simulated camera", title="mark:")] if found["is_simulated"] else []
    parts.append(_table(found["drift"]) if found["drift"]["rows"] else f'<p class="note">{_NO_DRIFT}</p>')
    parts.append("<h3>Control charts</h3>")
    parts += map(_chart, found["charts"])
    parts += [] if found["charts"] else [f'<p class="note">{_NO_CHART}</p>']
    parts.append(_table(found["results"]))
    return "".join(parts)


def _chart(one: dict[str, str]) -> str:
    return (
        f'<figure><div class="drawing" tabindex="0" role="group" aria-label="{escape(one["title"])}">{one["svg"]}</div>'
        f'<figcaption>{escape(one["title"])}</figcaption></figure><p class="note">{escape(one["caption"])}</p>'
    )


def _table(table: dict[str, Any]) -> str:
    drawn = show.table_html(table["columns"], table["rows"], right=table["right"])
    note = f'<p class="note">{escape(table["note"])}</p>' if table["note"] else ""
    return f"<h3>{escape(table['title'])}</h3>{drawn}{note}"

"""The rig: what is ready, which devices answer, and a simulated one."""

from typing import Any

from nicegui import ui

from irtiming.errors import IrTimingError
from irtiming.web import frame, show
from irtiming.web.cameras import CAMERAS
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job
from irtiming.web.orders import RigOrder
from irtiming.web.work import LEAVE


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/rig")
    def rig() -> None:
        with frame.page(desk, "/rig"):
            with show.columns():
                with show.card("Simulated rig"):
                    _simulated(desk)
                with show.card("Devices"):
                    _devices(desk)
            with show.card("This computer"):
                _computer(desk)


def _simulated(desk: Desk) -> None:
    ui.label(
        "Camera, trigger generator, chopper and blackbody over the same wires as real ones. Its plan.toml and rig.toml go into "
        "the folder; Record finds them there."
    ).classes("note")
    with ui.element("div").classes("form") as form:
        camera = ui.select(CAMERAS, value="photon snapshot", label="Camera").mark("camera")
        rows = ui.number("Rows", value=120, min=16, max=4096, precision=0)
        columns = ui.number("Columns", value=160, min=16, max=4096, precision=0)
        speed = ui.number("Seconds of the rig in one of yours", value=1, min=0.01, max=100)
        seed = ui.number("Seed of its imperfections", value=1, min=0, precision=0)
    state = show.html()

    def start() -> None:
        kind, readout = str(camera.value).split()
        try:
            order = RigOrder(
                camera=kind, readout=readout, rows=_whole(rows.value, "rows"), columns=_whole(columns.value, "columns"),
                speed=float(speed.value or 1), seed=_whole(seed.value, "seed"), folder=desk.folder.free("simulated-rig"),
            )  # fmt: skip
            desk.jobs.start("rig", "the simulated rig", task="simulated_rig:serve_rig", order=order)
        except (IrTimingError, ValueError) as error:
            show.complain(error)
        refresh()

    def stop() -> None:
        if desk.jobs.running("recording"):
            show.complain("a recording goes on; stop that first")
        elif job := desk.jobs.running("rig"):
            job.say(LEAVE)

    with ui.element("div").classes("actions"):
        begin = ui.button("Start the simulated rig", on_click=start).props("unelevated color=primary")
        end = ui.button("Stop it", on_click=stop).props("outline color=primary")

    def refresh() -> None:
        job = desk.jobs.latest("rig")
        is_on = job is not None and not job.is_over
        begin.set_enabled(not is_on)
        end.set_enabled(is_on)
        form.set_visibility(not is_on)
        show.put(state, "" if job is None else _state(desk, job))

    refresh()
    ui.timer(0.5, refresh)


def _whole(value: Any, name: str) -> int:
    if value is None or float(value) != int(value):
        raise ValueError(f"{name} is {value}; it must be a whole number")
    return int(value)


def _state(desk: Desk, job: Job) -> str:
    if job.ending is not None:
        return "" if job.ending.is_good else show.finding_html("error", job.ending.text)
    if "folder" not in job.facts:
        return show.finding_html("info", "is being set up", title="the rig")
    place = job.facts["folder"].removeprefix(f"{desk.folder.root}/")
    return show.finding_html("ok", f"its files are in {place}", title="ready:") + show.facts_html(
        job.facts["addresses"]
    )


def _devices(desk: Desk) -> None:
    hosts = ui.input("Addresses to ask besides", placeholder="192.168.0.7 127.0.0.2").classes("wide")
    found = show.html()

    async def look() -> None:
        show.put(found, '<p class="note">looking …</p>')
        simulated = desk.jobs.running("rig")
        known = (
            [] if simulated is None else [simulated.facts.get("addresses", {}).get("camera", "").removeprefix("gige:")]
        )
        asked = [*filter(None, known), *str(hosts.value or "").replace(",", " ").split()[:20]]
        answer = await desk.ask("computer:discover", tuple(asked))
        show.put(found, _devices_html(answer.answer) if answer.is_good else show.finding_html("error", answer.text))

    ui.label("Cameras and serial ports with the addresses that plan.toml takes. Nothing is opened or changed.").classes(
        "note"
    )
    with ui.element("div").classes("actions"):
        ui.button("Look for devices", on_click=look).props("outline color=primary")


def _devices_html(found: dict[str, Any]) -> str:
    cameras = [[one["address"], f"{one['vendor']} {one['model']}", one["serial_number"]] for one in found["cameras"]]
    parts = [
        show.table_html(["camera", "what it is", "serial number"], cameras)
        if cameras
        else show.finding_html("warning", "no camera answers", cure="check power, cable and network", title="cameras:"),
        *(show.finding_html("ok", text, title="port:") for text in found["ports"]),
        *(show.finding_html("warning", text, title="note:") for text in found["notes"]),
    ]
    return "".join(parts)


def _computer(desk: Desk) -> None:
    found = show.html('<p class="note">Packages, drivers, disk and network, with a cure for each fault.</p>')

    async def check() -> None:
        show.put(found, '<p class="note">checking …</p>')
        answer = await desk.ask("computer:check", desk.folder.root)
        if not answer.is_good:
            show.put(found, show.finding_html("error", answer.text))
            return
        findings = [
            {"severity": one["status"], "what": f"{one['part']}: {one['found']}", "cure": one["cure"]}
            for one in answer.answer
        ]
        show.put(found, show.findings_html(findings))

    with ui.element("div").classes("actions"):
        ui.button("Check this computer", on_click=check).props("outline color=primary")

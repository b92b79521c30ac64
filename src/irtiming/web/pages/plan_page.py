"""Planning: a series tried out with sliders, what it should tell, and its triggers drawn."""

import re
from html import escape
from typing import Any, final

from nicegui import ui

from irtiming.archive.json_file import write_atomically
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.web import frame, show
from irtiming.web.cameras import CAMERAS
from irtiming.web.desk import Desk
from irtiming.web.orders import PlanOrder

_SPEEDS = {
    text: f"{text} Hz" for text in ("2", "3", "4", "5", "6", "8", "9", "10", "12", "15", "20", "25", "30", "40", "50")
}
_USUAL_RIG = "(a usual rig)"
_WAIT_S = 0.25


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/plan")
    def plan() -> None:
        with frame.page(desk, "/plan"):
            wishes = _Wishes(desk)
            with show.columns():
                with show.card("The series"):
                    wishes.show()
                with show.card("What to expect"):
                    expected = show.html('<p class="note">being foretold …</p>')
            with show.card("For an uncertainty that is wanted"):
                _shortest(desk, wishes)
            with show.card("Order of the samples"):
                picture = show.html()
            with show.card("Take it along"):
                _save(desk, wishes)

        async def refresh() -> None:
            if (order := wishes.changed()) is None:
                return
            found = await desk.ask("planning:foretell", order)
            show.put(expected, _expected(found.answer) if found.is_good else show.finding_html("error", found.text))
            show.put(picture, f'<div class="drawing">{found.answer["picture"]}</div>' if found.is_good else "")

        ui.timer(_WAIT_S, refresh)


@final
class _Wishes:
    """The sliders, and the order that they make."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._asked: PlanOrder | None = None

    def show(self) -> None:
        """Make them."""
        rigs = [_USUAL_RIG, *(self._desk.folder.name_of(one) for one in self._desk.folder.files("rig.toml"))]
        with ui.element("div").classes("form"):
            self.camera = ui.select(CAMERAS, value="photon snapshot", label="Camera")
            self.rig = ui.select(rigs, value=_USUAL_RIG, label="The rig's numbers")
        self.wheel = (
            ui.select(_SPEEDS, multiple=True, value=["3", "9"], label="Wheel speeds").props("use-chips").classes("wide")
        )
        self.frame_hz = _slider("Frame rate", unit="Hz", limits=(5, 200), value=30)
        self.samples = _slider("Samples in a turn", limits=(100, 3000), step=50, value=1000)
        self.runs = _slider("Runs of each speed", limits=(1, 20), value=1)
        self.noise = _slider("Noise of a pixel", unit="mK", limits=(5, 200), value=38)
        self.contrast = _slider("Blackbody minus wheel", unit="K", limits=(1, 60), value=9)
        self.window = _slider("Integration time", unit="µs", limits=(10, 5000), step=10, value=250)
        self.lag = _slider("Time constant", unit="ms", limits=(1, 20), step=0.5, value=5)
        self.window.bind_visibility_from(self.camera, "value", lambda value: str(value).startswith("photon"))
        self.lag.bind_visibility_from(self.camera, "value", lambda value: not str(value).startswith("photon"))

    def order(self, wanted: str = "") -> PlanOrder:
        """What the sliders say now."""
        kind, readout = str(self.camera.value).split()
        is_photon = kind == "photon"
        return PlanOrder(
            camera=kind,
            readout=readout,
            wheel_hz=tuple(sorted(map(str, self.wheel.value), key=float)),
            frame_hz=f"{self.frame_hz.value:g}",
            samples=f"{self.samples.value:g}",
            runs=f"{self.runs.value:g}",
            noise_k=1e-3 * float(self.noise.value),
            contrast_k=float(self.contrast.value),
            window_or_lag_s=1e-6 * float(self.window.value) if is_photon else 1e-3 * float(self.lag.value),
            rig=None if self.rig.value == _USUAL_RIG else self._desk.folder.existing(str(self.rig.value)),
            wanted=wanted,
        )

    def changed(self) -> PlanOrder | None:
        """The order, if it is another than when it was asked for last."""
        order = self.order()
        if order == self._asked or not order.wheel_hz:
            return None
        self._asked = order
        return order

    def section(self) -> str:
        """The same as section of plan.toml."""
        order = self.order()
        return (
            f"[series]\nwheel_hz = [{', '.join(order.wheel_hz)}]\nframe_hz = {order.frame_hz}\nsamples = {order.samples}\n"
            f"repeats = {order.runs}\n"
        )


def _slider(name: str, *, unit: str = "", limits: tuple[float, float], step: float = 1, value: float) -> ui.slider:
    """A slider that says its value, with its name for those who do not see it."""
    label = ui.label()
    slider = ui.slider(min=limits[0], max=limits[1], step=step, value=value).props(f'aria-label="{name}"')
    label.bind_text_from(slider, "value", lambda now: f"{name}: {now:g} {unit}".rstrip())
    label.bind_visibility_from(slider, "visible")
    return slider


def _expected(found: dict[str, Any]) -> str:
    lines = "".join(
        f'<div class="number">u({escape(name)}) = {escape(size)}</div><p class="note">most of it: {escape(part)}</p>'
        for name, size, part in found["uncertainties"][:1]
    )
    rest = show.table_html(["parameter", "u", "most of it"], found["uncertainties"][1:])
    schemes = show.table_html(["wheel / Hz", "camera / Hz", "samples"], found["schemes"], right=(0, 1, 2))
    assumed = "".join(f"<li>{escape(one)}</li>" for one in found["assumptions"])
    folded = (
        f"<details><summary>{len(found['assumptions'])} assumptions</summary><ul class='note'>{assumed}</ul></details>"
    )
    time = f'<p class="note">standard uncertainty, k = 1; the triggers last {escape(found["duration"])}</p>'
    return f'<div class="verdict">{lines}{time}</div>{rest}{schemes}{folded if found["assumptions"] else ""}'


def _shortest(desk: Desk, wishes: _Wishes) -> None:
    ui.label("The shortest measurements that should reach it, whatever wheel speeds and runs that takes.").classes(
        "note"
    )
    wanted = ui.input("Parameter and standard uncertainty", value="trigger_delay=0.5us")
    found = show.html()

    async def seek() -> None:
        show.put(found, '<p class="note">being sought …</p>')
        answer = await desk.ask("planning:shortest", wishes.order(str(wanted.value or "")))
        if not answer.is_good:
            show.put(found, show.finding_html("error", answer.text))
            return
        rows = [[" and ".join(speeds), ", ".join(map(str, runs)), lasts, u] for speeds, runs, lasts, u in answer.answer]
        show.put(found, show.table_html(["wheel / Hz", "runs of each", "lasts", "u"], rows, right=(2, 3)))

    with ui.element("div").classes("actions"):
        ui.button("Find the shortest", on_click=seek).props("outline color=primary")


def _save(desk: Desk, wishes: _Wishes) -> None:
    """The series into a copy of a plan.toml, which names the devices."""
    plans = [desk.folder.name_of(one) for one in desk.folder.files("plan.toml")]
    if not plans:
        show.html(
            show.finding_html(
                "info", "there is no plan.toml that names the devices", cure="Start a simulated rig, or write one."
            )
        )
        return
    with ui.element("div").classes("form"):
        base = ui.select(plans, value=plans[0], label="Devices and camera as in")
        name = ui.input("Name of the new plan", value="planned")

    def save() -> None:
        try:
            path = desk.folder.existing(str(base.value))
            text, n = re.subn(
                r"(?ms)^\[series\].*?(?=^\[|\Z)", f"{wishes.section()}\n", path.read_text(encoding="utf-8")
            )
            if n != 1:
                raise ArchiveError(f"{base.value}: has no section [series] that could be replaced; choose another")
            within = desk.folder.name_of(path.parent) if path.parent != desk.folder.root else ""
            made = desk.folder.free(f"{name.value or 'planned'}-plan.toml", within=within)
            write_atomically(text, made)
            ui.notify(f"{desk.folder.name_of(made)}: written; Record has it in its list", type="positive")
        except (IrTimingError, OSError) as error:
            show.complain(error)

    with ui.element("div").classes("actions"):
        ui.button("Write the plan", on_click=save).props("unelevated color=primary")

"""Recording a series: the live image, the estimate as it tightens, how the edges come; it goes on whoever looks."""

from collections.abc import Callable
from typing import Any

from nicegui import ui

from irtiming.errors import IrTimingError
from irtiming.web import frame, live_parts, show
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job
from irtiming.web.orders import RecordingOrder
from irtiming.web.work import LEAVE, MOVED

_PICTURE_S, _STATE_S = 0.12, 0.4
_NO_RIG = "(no estimate while recording)"


def add(desk: Desk) -> None:
    """Serve it."""
    live_parts.serve_pictures(desk)

    @ui.page("/record")
    def record_page() -> None:
        with frame.page(desk, "/record"):
            with show.card():
                refresh_form = _form(desk)
            with show.columns("wide-left"):
                with show.card("Live image"):
                    refresh_image = live_parts.image(desk)
                with show.card("Edges and frames"):
                    edges = show.html()
            with show.card("What is known so far"):
                estimate = show.html()
            with show.card("What was said"):
                log = show.html()

        def refresh() -> None:
            job = desk.jobs.latest("recording")
            refresh_form(job)
            show.put(edges, live_parts.edges_html(job))
            show.put(estimate, live_parts.estimates_html(job))
            show.put(log, '<p class="note">Nothing yet.</p>' if job is None else show.log_html(job))

        refresh()
        ui.timer(_STATE_S, refresh)
        ui.timer(_PICTURE_S, refresh_image)


def _form(desk: Desk) -> Callable[[Job | None], None]:
    """Plan, rig and folder, the buttons, and what stands in the way."""
    plans = [desk.folder.name_of(one) for one in desk.folder.files("plan.toml")]
    rigs = [_NO_RIG, *(desk.folder.name_of(one) for one in desk.folder.files("rig.toml"))]
    with ui.element("div").classes("form") as form:
        plan = ui.select(plans, value=plans[0] if plans else None, label="Plan of the series").mark("plan")
        rig = ui.select(rigs, value=_beside(plans[:1], rigs), label="The rig's numbers")
        into = ui.input("Folder for the recordings", value="recordings")
        plan.on_value_change(lambda: rig.set_value(_beside([str(plan.value)], rigs)))
    silent = ui.checkbox("Ask nothing: wheel and mask are as they must be")
    if not plans:
        show.html(
            show.finding_html(
                "info", "there is no plan.toml in the folder", cure="Start a simulated rig, or write one."
            )
        )
    command, state = show.html(), show.html()

    async def tell_command() -> None:
        name = str(plan.value or "")
        found = await _command(desk, name)
        if name == str(plan.value or ""):
            show.put(command, found)

    plan.on_value_change(tell_command)
    ui.timer(0.05, tell_command, once=True)

    def start(*, checks_only: bool) -> None:
        try:
            order = RecordingOrder(
                plan=desk.folder.existing(str(plan.value or "")),
                folder=desk.folder.inside(str(into.value or "")),
                rig=None if rig.value == _NO_RIG else desk.folder.existing(str(rig.value)),
                checks_only=checks_only,
                is_silent=bool(silent.value),
            )
            desk.jobs.start("recording", f"the recording into {into.value}", task="recording:record", order=order)
        except IrTimingError as error:
            show.complain(error)

    with ui.element("div").classes("actions"):
        begin = ui.button("Record", on_click=lambda: start(checks_only=False)).props("unelevated color=primary")
        check = ui.button("Only check", on_click=lambda: start(checks_only=True)).props("outline color=primary")
        stop = ui.button("Stop", on_click=lambda: _say(desk, LEAVE)).props("outline color=negative")
        moved = ui.button("Done, go on", on_click=lambda: _say(desk, MOVED)).props("unelevated color=primary")

    def refresh(job: Job | None) -> None:
        is_on = job is not None and not job.is_over
        for button in (begin, check):
            button.set_enabled(not is_on)
        stop.set_enabled(is_on)
        form.set_visibility(not is_on)
        silent.set_visibility(not is_on)
        moved.set_visibility(job is not None and is_on and bool(job.facts.get("question")))
        show.put(state, "" if job is None else _state(job))

    return refresh


def _beside(plans: list[str], rigs: list[str]) -> str:
    """The rig.toml in the folder of the plan, where there is one."""
    wanted = [f"{one.removesuffix('plan.toml')}rig.toml" for one in plans]
    return next((one for one in wanted if one in rigs), rigs[0])


async def _command(desk: Desk, name: str) -> str:
    """The program that a plan runs, to be read before it does; what is wrong with a plan that cannot be read."""
    try:
        found = await desk.ask("recording:command_of", desk.folder.existing(name))
    except IrTimingError:
        return ""
    if not found.is_good:
        return show.finding_html("error", found.text)
    return show.finding_html("info", found.answer, title="This plan runs a program:") if found.answer else ""


def _say(desk: Desk, word: str) -> None:
    if job := desk.jobs.running("recording"):
        job.say(word)


def _state(job: Job) -> str:
    if job.ending is None:
        question = job.facts.get("question")
        asked = show.finding_html("warning", question, title="Please:") if question else ""
        return (
            asked
            + show.finding_html("info", f"{job.title} goes on; closing this page stops nothing", title="now:")
            + show.steps_html(job)
        )
    complaints = [{"severity": "error", "what": one} for one in job.facts.get("complaints", ())]
    if not job.ending.is_good:
        return show.finding_html("error", job.ending.text) + show.findings_html(complaints)
    return _ended(job.ending.answer)


def _ended(answer: dict[str, Any]) -> str:
    if (ready := answer.get("ready")) is not None:
        camera = ready["camera"]
        text = (
            f"{camera['vendor']} {camera['model']} {camera['serial_number']}; {ready['n_pending']} of {ready['n_runs']} runs to "
            f"make, {ready['duration_s']:.3g} s of triggers. Nothing has moved."
        )
        return show.finding_html("ok", text, title="ready:")
    n_made, before = len(answer["files"]), answer["made_before"]
    text = f"{n_made} recordings made now" + (
        f", runs {', '.join(map(str, before))} were there before" if before else ""
    )
    if answer["is_good"]:
        return show.finding_html("ok", text, title="complete:", cure="Analyse is the next page.")
    return show.finding_html(
        "warning", f"{answer['ending']}; {text}", title="ended early:", cure="Record again goes on where it ended."
    )

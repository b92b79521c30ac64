"""A job of which there is one at a time, as its page shows it: begun and broken off by buttons, its state, and where it leads."""

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from irtiming.web import show
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job, JobKind

_EVERY_S = 0.4


def controls(
    desk: Desk, kind: JobKind, *, label: str, start: Callable[[], None], goes_on: str,
    address: Callable[[Mapping[str, Any]], str],
) -> None:  # fmt: skip
    """Put the buttons and the state into the page.

    Parameters
    ----------
    desk, kind
        Whose job.
    label, start
        Of the button that begins it, and what that does.
    goes_on
        What is said while it does.
    address
        Page to go to when it has ended well, by its answer.
    """
    said = show.html()
    with ui.element("div").classes("actions"):
        begin = ui.button(label, on_click=start).props("unelevated color=primary")
        stop = ui.button("Break it off", on_click=lambda: _break_off(desk, kind)).props("outline color=negative")
    was_on = [desk.jobs.running(kind) is not None]

    def refresh() -> None:
        job = desk.jobs.latest(kind)
        is_on = job is not None and not job.is_over
        begin.set_enabled(not is_on)
        stop.set_visibility(is_on)
        show.put(said, "" if job is None else _state(job, goes_on))
        if was_on[0] and not is_on and job is not None and job.ending is not None and job.ending.is_good:
            ui.navigate.to(address(job.ending.answer))
        was_on[0] = is_on

    refresh()
    ui.timer(_EVERY_S, refresh)


def _break_off(desk: Desk, kind: JobKind) -> None:
    if job := desk.jobs.running(kind):
        job.break_off()


def _state(job: Job, goes_on: str) -> str:
    if job.ending is None:
        return show.finding_html("info", goes_on, title=f"{job.title}:") + show.steps_html(job)
    return "" if job.ending.is_good else show.finding_html("error", job.ending.text)

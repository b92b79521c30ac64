"""A result put to use on other frames of the camera: before and after, side by side."""

import base64
from html import escape
from pathlib import Path

from nicegui import ui

from irtiming.archive import layout
from irtiming.errors import IrTimingError
from irtiming.records.frame_view import PairOrder
from irtiming.web import files, frame, show
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job
from irtiming.web.orders import ApplyOrder
from irtiming.web.pages.analyse_page import RESULTS


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/apply")
    def apply() -> None:
        with frame.page(desk, "/apply"):
            with show.card():
                _form(desk)
            with show.card("Before and after"):
                _compared(desk)


def _form(desk: Desk) -> None:
    results = [desk.folder.name_of(one) for one in desk.folder.files(".json") if one.parent.name == RESULTS]
    sources = [one for one in desk.folder.files(*files.FRAMES) if one.parent.name != layout.APPLIED]
    names = [desk.folder.name_of(one) for one in sources]
    with ui.element("div").classes("form"):
        result = ui.select(results, value=results[0] if results else None, label="Result")
        source = ui.select(names, value=names[0] if names else None, label="Frames of the same camera")
        series = ui.select(results, value=[], multiple=True, label="Results at other settings, to interpolate")
        period = ui.input("Frame period, if not stated", placeholder="33.3 ms")
        times = ui.checkbox("Write the times of all rows, too (CSV)")
        alone = ui.checkbox("Take each stamp by itself, not its place among all").bind_visibility_from(times, "value")
    ui.label(
        "A result for another camera, integration time, readout or image size is refused. The frames are left as they are."
    ).classes("note")
    said = show.html()

    def start() -> None:
        try:
            path = desk.folder.existing(str(source.value or ""))
            order = ApplyOrder(
                result=desk.folder.existing(str(result.value or "")),
                source=path,
                out=desk.folder.free(f"{path.stem}-at-one-instant.nxs", within=layout.APPLIED),
                series=tuple(desk.folder.existing(name) for name in series.value if name != result.value),
                period=str(period.value or "").strip(),
                alone=bool(alone.value),
                times=desk.folder.free(f"{path.stem}-times.csv", within=layout.APPLIED) if times.value else None,
            )
            desk.jobs.start("application", f"the result on {path.name}", task="applying:apply", order=order)
        except IrTimingError as error:
            show.complain(error)

    with ui.element("div").classes("actions"):
        ui.button("Apply", on_click=start).props("unelevated color=primary")
    ui.timer(0.4, lambda: show.put(said, _said(desk, desk.jobs.latest("application"))))


def _said(desk: Desk, job: Job | None) -> str:
    if job is None:
        return ""
    if job.ending is None:
        return show.finding_html("info", "goes on", title=f"{job.title}:") + show.steps_html(job)
    if not job.ending.is_good:
        return show.finding_html("error", job.ending.text)
    done = job.ending.answer
    text = (
        f"{done['n_written']} of {done['n_frames']} frames; mean gain {done['mean_gain']:.3f}, noise times "
        f"{done['mean_noise_gain']:.3f}, for pixel noise of {done['noise']:.4g}"
    )
    lines = "".join(f"<li>{escape(one)}</li>" for one in done["description"])
    links = " ".join(
        f'<a class="button" href="{escape(files.link(desk, Path(one)))}">{escape(Path(one).name)}</a>'
        for one in (done["after"], done["times"])
        if one
    )
    return (
        show.finding_html("ok", text, title="made:")
        + f'<ul class="note">{lines}</ul><div class="actions">{links}</div>'
    )


def _compared(desk: Desk) -> None:
    """The frame as it came and as it was made, with one slider for both."""
    pictures = show.html('<p class="note">Both show here when a result was applied.</p>')
    slider = ui.slider(min=0, max=1, value=0).props('aria-label="frame"')
    shown: list[Job] = []

    async def turn(index: int) -> None:
        job = desk.jobs.latest("application")
        if job is None or job.ending is None or not job.ending.is_good:
            return
        order = PairOrder(before=Path(job.ending.answer["before"]), after=Path(job.ending.answer["after"]), index=index)
        found = await desk.ask("applying:compare", order)
        if not found.is_good:
            show.put(pictures, show.finding_html("error", found.text))
            return
        view = found.answer
        slider.props(f"max={view['n_frames'] - 1}")
        slider.set_value(view["index"])
        both = "".join(
            f'<figure><div class="live"><img alt="{title}" src="data:image/jpeg;base64,{base64.b64encode(view[name]).decode()}">'
            f"</div><figcaption>{title}</figcaption></figure>"
            for name, title in (("before", "before: as it came"), ("after", "after: the scene at one instant"))
        )
        note = f'<p class="note">frame {view["frame"]}; black is {view["lowest"]:.5g}, white {view["highest"]:.5g} in both</p>'
        show.put(pictures, f'<div class="columns">{both}</div>{note}')

    async def refresh() -> None:
        job = desk.jobs.latest("application")
        slider.set_visibility(bool(shown))
        if job is not None and job.ending is not None and job.ending.is_good and job not in shown:
            shown[:] = [job]
            await turn(-1)

    slider.on("change", lambda: turn(int(slider.value)))
    ui.timer(0.4, refresh)

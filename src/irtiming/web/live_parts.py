"""The parts of the page Record that change while frames arrive."""

from collections.abc import Callable
from html import escape
from math import log10
from typing import Any

from fastapi import Response
from nicegui import app as pages_app
from nicegui import ui

from irtiming.report import outside
from irtiming.report.rounding import time_text
from irtiming.web import show
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job

_WIDTH, _HEIGHT = 640, 150
_DASHES = ("", "6 4", "2 3", "8 2 2 2", "1 4")
_SHOWN = ("trigger_delay", "time_constant", "row_delay", "strobe_delay", "timestamp_delay")


def serve_pictures(desk: Desk) -> None:
    """Serve the latest picture of the recording."""

    @pages_app.get("/live.jpg")
    def picture() -> Response:
        job = desk.jobs.latest("recording")
        if job is None or job.picture is None:
            return Response(status_code=404)
        return Response(job.picture, media_type="image/jpeg", headers={"cache-control": "no-store"})


def image(desk: Desk) -> Callable[[], None]:
    """The live image; gives what brings it up to date."""
    with ui.element("div").classes("live"):
        shown = ui.interactive_image(sanitize=False).props('alt="live image of the camera"').mark("live")
    caption = show.html('<p class="note">The first frame shows here; the border of the opening is orange.</p>')
    seen = [0, 0]

    def refresh() -> None:
        job = desk.jobs.latest("recording")
        if job is None or job.picture is None or (now := [id(job), job.n_pictures]) == seen:
            return
        seen[:] = now
        shown.set_source(f"/live.jpg?n={job.n_pictures}")
        view = job.facts.get("view", {})
        show.put(
            caption,
            f'<p class="note">frame {view.get("frame")}, {view.get("lowest")} to {view.get("highest")} DN; what changes as the '
            "wheel turns has an orange border</p>",
        )

    return refresh


def edges_html(job: Job | None) -> str:
    """How the lines and frames stand."""
    if job is None or not job.facts.get("frames"):
        return (
            '<p class="note">Each line of the trigger generator, with the edges that came, while a run is recorded.</p>'
        )
    frames, found = job.facts["frames"], job.facts.get("edges")
    parts = [_frames_html(frames)]
    if found is not None:
        parts.append(_speed_html(found))
        parts += [
            show.finding_html(
                "ok" if is_well else "error",
                f"{one['edges']} edges"
                + ("" if one["per_turn"] is None else f", {one['per_turn']:.2f} in a turn of {one['expected']}"),
                title=f"{one['name']}:",
                cure="" if is_well else "see that the light gate is free, and its plug in its place",
            )
            for one, is_well in zip(found["lines"], found["is_well"], strict=True)
        ]
        if not found["is_whole"]:
            parts.append(show.finding_html("warning", "some were lost on the line", title="stamps:"))
    return "".join(parts)


def _frames_html(frames: dict[str, int]) -> str:
    lost, waiting = frames["lost"], frames["waiting"]
    text = f"{frames['frames']} came, {lost} lost, {waiting} wait for the disk"
    return show.finding_html("warning" if lost else "ok", text, title="frames:")


def _speed_html(found: dict[str, Any]) -> str:
    if found["wheel_hz"] is None:
        return show.finding_html("info", "no whole turn yet", title="wheel:")
    text = f"{found['wheel_hz']:.4f} Hz in the last turn, {found['planned_hz']:.4f} Hz planned"
    return show.finding_html("ok", text, title="wheel:")


def estimates_html(job: Job | None) -> str:
    """The latest estimate in words, and how its uncertainties shrank."""
    estimates = (
        [] if job is None else [*job.facts.get("estimates", []), *filter(None, [job.facts.get("last_estimate")])]
    )
    if not estimates:
        return '<p class="note">With the rig\'s numbers, the first estimate comes after about 120 frames.</p>'
    latest = estimates[-1]
    if latest["doubt"]:
        return show.finding_html("info", latest["doubt"], title="not sure yet:")
    names = [name for name in _SHOWN if name in latest["values"]]
    lines = "".join(
        f'<div class="number">{name.replace("_", " ")} {time_text(latest["values"][name], latest["uncertainties"][name])}</div>'
        for name in names
    )
    said = [
        f"from {latest['frames']} frames",
        "standard uncertainty, k = 1",
        outside.behind(latest["not_in_uncertainty"]),
    ]
    note = f'<p class="note">{escape("; ".join(filter(None, said)))}</p>'
    return f'<div class="verdict">{lines}{note}</div>{_shrinking_svg(estimates, names)}'


def _shrinking_svg(estimates: list[dict[str, Any]], names: list[str]) -> str:
    """Standard uncertainties over the frames, both on logarithmic scales."""
    points = {name: [(one["frames"], one["uncertainties"].get(name)) for one in estimates] for name in names}
    known = {name: [(log10(x), log10(y)) for x, y in some if x and y] for name, some in points.items()}
    curves = {name: some for name, some in known.items() if len(some) > 1}
    if not curves:
        return ""
    xs, ys = zip(*(point for some in curves.values() for point in some), strict=True)
    right, down = 480 / (max(xs) - min(xs) or 1.0), 100 / (max(ys) - min(ys) or 1.0)
    parts = []
    for dash, (name, some) in zip(_DASHES, curves.items(), strict=False):
        at = [(60 + right * (x - min(xs)), 20 + down * (max(ys) - y)) for x, y in some]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
        parts.append(f'<polyline points="{line}" fill="none" stroke="currentColor" stroke-dasharray="{dash}"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="currentColor"/>' for x, y in at]
        parts.append(_text(at[-1][0] + 8, at[-1][1] + 4, f"u {name.replace('_', ' ')}"))
    parts.append(_text(60, _HEIGHT - 4, f"{estimates[0]['frames']} to {estimates[-1]['frames']} frames"))
    size = f'viewBox="0 0 {_WIDTH} {_HEIGHT}" style="color:var(--blue);width:100%;max-width:{_WIDTH}px"'
    return f'<svg {size} role="img" aria-label="how the uncertainty shrank">{"".join(parts)}</svg>'


def _text(x_px: float, y_px: float, words: str) -> str:
    return f'<text x="{x_px:.1f}" y="{y_px:.1f}" font-size="12" fill="currentColor">{escape(words)}</text>'

"""The library: recordings and files of frames with a picture of each; what is in one, whether it is sound, and another format."""

import shutil
from collections.abc import Callable
from datetime import datetime
from html import escape
from pathlib import Path
from urllib.parse import quote

from nicegui import events, ui

from irtiming.archive import layout
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.web import files, frame, show
from irtiming.web.desk import Desk
from irtiming.web.jobs import Job
from irtiming.web.orders import CheckOrder, ConvertOrder

MOST_SHOWN = 60
_DRAGGED = "dragged-in"
_TAKEN = (*files.FRAMES, ".json", ".toml", ".csv")
_RESERVE_BYTES = 2**30
_READ_S = 3.0
"""For what was said of each file to be read."""

_FORMATS = {".nxs": "NeXus (.nxs)", ".tif": "BigTIFF (.tif)", ".npy": "NumPy (.npy)", ".hcc": "Telops (.hcc)"}


def add(desk: Desk, *, upload_bytes: int) -> None:
    """Serve it."""

    @ui.page("/library")
    def library(file: str = "", find: str = "") -> None:
        with frame.page(desk, "/library"):
            if file:
                with show.card(file):
                    _one(desk, file)
            with show.card("Files of frames"):
                _list(desk, find, chosen=file)
            with show.card("Drag files in"):
                _drag_in(desk, upload_bytes)


def _list(desk: Desk, find: str, *, chosen: str) -> None:
    found = [one for one in desk.folder.files(*files.FRAMES) if find.lower() in desk.folder.name_of(one).lower()]
    field = ui.input("Find by name", value=find).classes("wide").props("clearable")
    field.on("keydown.enter", lambda: ui.navigate.to(f"/library?find={quote(str(field.value or ''))}"))
    if not found:
        show.html(show.finding_html("info", "there are none here yet", cure="Record some, or drag files in below."))
    rows = "".join(_row(desk, one, is_chosen=desk.folder.name_of(one) == chosen) for one in found[:MOST_SHOWN])
    show.html(f'<ul class="files">{rows}</ul>')
    if len(found) > MOST_SHOWN:
        ui.label(f"{MOST_SHOWN} of {len(found)} are shown, the newest; find the others by name.").classes("note")


def _row(desk: Desk, path: Path, *, is_chosen: bool) -> str:
    name, stat = desk.folder.name_of(path), path.stat()
    changed = datetime.fromtimestamp(stat.st_mtime).strftime("%Y-%m-%d %H:%M")
    size = f"{stat.st_size / 1e6:.1f} MB" if stat.st_size < 1e9 else f"{stat.st_size / 1e9:.2f} GB"
    place, _, last = name.rpartition("/")
    here = ' aria-current="true"' if is_chosen else ""
    return (
        f'<li><a href="/library?file={quote(name)}"{here}><img class="thumb" loading="lazy" alt="" '
        f'src="{escape(files.picture_link(name, is_thumb=True))}"><span><b>{escape(last)}</b><br>'
        f'<span class="note">{escape(place or "the folder itself")} · {size} · {changed}</span></span></a></li>'
    )


def _one(desk: Desk, name: str) -> None:
    """A file: a frame of it, what it tells, and what can be done with it."""
    try:
        path = desk.folder.existing(name)
    except ArchiveError as error:
        show.html(show.finding_html("error", str(error)))
        return
    with show.columns():
        with ui.element("div"):
            picture = show.html()
            slider = ui.slider(min=0, max=1, value=0).props('aria-label="frame"')
            caption = ui.label().classes("note")
        facts = show.html('<p class="note">looking …</p>')

    def turn(to: int) -> None:
        show.put(
            picture,
            f'<div class="live"><img alt="frame {to}" src="{escape(files.picture_link(name, index=to))}"></div>',
        )
        caption.set_text(f"frame {to}; black to white is the frame's own range")

    async def look() -> None:
        reply = await desk.ask("files:about", path)
        if not reply.is_good:
            show.put(facts, show.finding_html("error", reply.text))
            slider.set_visibility(False)
            return
        show.put(facts, show.facts_html(reply.answer))
        n_frames = int(reply.answer["frames"])
        slider.props(f"max={n_frames - 1}")
        slider.set_visibility(n_frames > 1)
        slider.set_value(n_frames // 2)
        turn(n_frames // 2)

    slider.on_value_change(lambda event: turn(int(event.value)))
    _deeds(desk, path)
    ui.timer(0.05, look, once=True)


def _deeds(desk: Desk, path: Path) -> None:
    """Buttons for a file, and what came of them."""
    jobs: list[Job] = []

    def verify() -> None:
        beside = path.with_name("rig.toml")
        order = CheckOrder(path=path, rig=beside if beside.is_file() else None)
        _begin(lambda: desk.jobs.start("check", f"the check of {path.name}", task="files:check", order=order))

    def convert() -> None:
        suffix = str(kind.value)

        def start() -> Job:
            out = desk.folder.free(f"{path.stem}{suffix}", within=layout.CONVERTED)
            order = ConvertOrder(path=path, out=out)
            return desk.jobs.start("conversion", f"the conversion of {path.name}", task="files:convert", order=order)

        _begin(start)

    def _begin(start: Callable[[], Job]) -> None:
        try:
            jobs.append(start())
        except IrTimingError as error:
            show.complain(error)

    with ui.element("div").classes("actions"):
        ui.button("Verify", on_click=verify).props("unelevated color=primary")
        ui.link("Save a copy", files.link(desk, path)).classes("button")
        kind = ui.select(_FORMATS, value=".tif", label="Format").props("dense")
        ui.button("Convert", on_click=convert).props("outline color=primary")
    said = show.html()
    ui.timer(0.4, lambda: show.put(said, _said(desk, jobs[-1]) if jobs else ""))


def _said(desk: Desk, job: Job) -> str:
    if job.ending is None:
        return show.steps_html(job) or '<p class="note">begins …</p>'
    if not job.ending.is_good:
        return show.finding_html("error", job.ending.text)
    if job.kind == "check":
        return show.findings_html(job.ending.answer)
    name = desk.folder.name_of(Path(job.ending.answer["out"]))
    lost = job.ending.answer["lost"]
    cure = f"This format has no place for {', '.join(lost)}." if lost else ""
    return show.finding_html("ok", name, title="written:", cure=cure)


def _drag_in(desk: Desk, upload_bytes: int) -> None:
    async def take(event: events.UploadEventArguments) -> None:
        name = event.file.name
        if not name.lower().endswith(_TAKEN):
            show.complain(
                f"{name:.80}: is no file of frames, result, table or rig.toml by its ending; {', '.join(_TAKEN)} are taken"
            )
        elif shutil.disk_usage(desk.folder.root).free < event.file.size() + _RESERVE_BYTES:
            show.complain(f"{name:.80}: there is no room for it on the disk; make room")
        else:
            place = desk.folder.free(name, within=_DRAGGED)
            await event.file.save(place)
            ui.notify(f"{desk.folder.name_of(place)}: is here", type="positive")

    ui.label(
        f"Makers' files are recognised by their content. At most {upload_bytes // 2**20} MiB at once; copy larger ones into "
        f"{desk.folder.root}."
    ).classes("note")
    upload = ui.upload(
        label="Drop files here, or press +", multiple=True, auto_upload=True, max_file_size=upload_bytes, on_upload=take,
        on_rejected=lambda: show.complain(f"larger than {upload_bytes // 2**20} MiB; copy it into {desk.folder.root}"),
    )  # fmt: skip
    upload.props("flat bordered").classes("wide")
    upload.on("finish", lambda: ui.timer(_READ_S, lambda: ui.navigate.to("/library"), once=True))

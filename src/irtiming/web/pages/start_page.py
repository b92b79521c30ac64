"""The first page: the way through a measurement."""

from nicegui import ui

from irtiming.web import frame
from irtiming.web.desk import Desk


def add(desk: Desk) -> None:
    """Serve it."""

    @ui.page("/")
    def start() -> None:
        with frame.page(desk, "/"):
            frame.heading("When was this thermal frame exposed?", "The way through a measurement, step by step.")
            with ui.element("div").classes("steps"):
                for number, place in enumerate(frame.PLACES, 1):
                    with ui.element("a").props(f"href={place.address}"):
                        with ui.element("b"):
                            ui.label(f"{number}  {place.name}")
                        with ui.element("span"):
                            ui.label(place.purpose)
            ui.label(f"All files are in {desk.folder.root}.").classes("note").style("margin-top: 18px")

"""What every page has: the way to the other pages, a heading, and a sentence that says what the page is for."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

from nicegui import ui

from irtiming.web.desk import Desk


@final
@dataclass(frozen=True, kw_only=True)
class Place:
    """A page: its address, its name and what it is for."""

    address: str
    name: str
    purpose: str


PLACES = (
    Place(address="/plan", name="Plan", purpose="From wishes to trigger schemes, and the uncertainty to expect of them."),
    Place(address="/rig", name="Rig", purpose="What is ready, which devices answer; a simulated rig at a click."),
    Place(address="/record", name="Record", purpose="A series of recordings, with live image and estimate."),
    Place(address="/library", name="Library", purpose="Recordings and files of frames: look, check, convert, drag in."),
    Place(address="/analyse", name="Analyse", purpose="From recordings to the timing of the camera, with its report."),
    Place(address="/campaigns", name="Campaigns", purpose="Many cameras: one table, verdicts by a rule, one page."),
    Place(address="/history", name="History", purpose="A camera over the years: every result, and its drift."),
    Place(address="/certificate", name="Certificate", purpose="From results to a calibration certificate."),
    Place(address="/apply", name="Apply", purpose="A result put to use on other frames: before and after, side by side."),
)  # fmt: skip


@contextmanager
def page(desk: Desk, address: str) -> Iterator[None]:
    """A page with its head; what is made inside the ``with`` block is its content."""
    here = next((one for one in PLACES if one.address == address), None)
    ui.colors(primary="#1f5fa8")
    ui.add_head_html('<link rel="stylesheet" href="/look/page.css"><link rel="icon" href="/look/icon.svg">')
    ui.page_title(f"{here.name} · irtiming" if here else "irtiming")
    ui.html('<a class="skip" href="#content">To the content</a>', sanitize=False)
    with ui.element("header").classes("top"), ui.element("nav").props('aria-label="pages"'):
        ui.link("irtiming", "/").classes("brand")
        for one in PLACES:
            link = ui.link(one.name, one.address)
            if one is here:
                link.classes("here").props("aria-current=page")
    with ui.element("div").classes("body").props("id=content role=main"):
        if here is not None:
            heading(here.name, here.purpose)
        yield


def heading(title: str, lead: str) -> None:
    """The page's heading, and a sentence below it."""
    with ui.element("h1"):
        ui.label(title)
    ui.label(lead).classes("lead")

"""`irtiming discover`: cameras and serial ports of this computer, with the addresses that a plan takes."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from irtiming.archive.json_file import require_places, write_json
from irtiming.cli.screen import say
from irtiming.instruments.cameras import find
from irtiming.instruments.serial_line import ports
from irtiming.records.camera_frame import CameraIdentity


def discover(
    hosts: Annotated[
        list[str] | None,
        typer.Argument(help="Addresses to ask besides, such as of a camera behind a router.", metavar="[HOST]..."),
    ] = None,
    timeout_s: Annotated[float, typer.Option("--timeout", help="Time for the answers, s.", min=0.05, max=60.0)] = 1.0,
    json: Annotated[Path | None, typer.Option("--json", help="Write what was found there.", metavar="OUT")] = None,
) -> None:
    """List cameras and serial ports, each with its address for plan.toml. No device is opened, and none is changed."""
    screen = Console()
    require_places({"JSON": [json]})
    cameras, complaints = find(hosts=hosts or [], timeout_s=timeout_s)
    lines = ports()
    _show_cameras(cameras, screen)
    say("serial ports: " + ("; ".join(lines) or "none"), screen)
    for complaint in complaints:
        say(f"note: {complaint}", screen)
    if json is not None:
        found = {"cameras": [asdict(camera) for camera in cameras], "serial_ports": lines, "notes": complaints}
        write_json(found, json)


def _show_cameras(cameras: list[CameraIdentity], screen: Console) -> None:
    if not cameras:
        say(
            "cameras: none answers; check power and cable, and that camera and computer have addresses of one network",
            screen,
        )
        return
    if not screen.is_terminal:
        for camera in cameras:
            line = (
                f'camera = "{camera.address}"  # {camera.vendor} {camera.model}, serial number {camera.serial_number}'
            )
            say(line, screen)
        return
    table = Table(title="cameras", title_justify="left")
    for heading in ("address for plan.toml", "vendor", "model", "serial number", "firmware"):
        table.add_column(heading, overflow="fold")
    for camera in cameras:
        cells = (f'"{camera.address}"', camera.vendor, camera.model, camera.serial_number, camera.firmware)
        table.add_row(*(escape(cell) for cell in cells))
    screen.print(table)

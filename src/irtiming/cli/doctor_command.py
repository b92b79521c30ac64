"""`irtiming doctor`: what of this computer is ready to record, and what would help."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast, get_args

import typer

from irtiming.cli.screen import say
from irtiming.errors import InstrumentError

if TYPE_CHECKING:
    from irtiming.session.computer import Device


def doctor(
    device: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND=ADDRESS",
            help="Ask a device what it is and how it stands; it is neither set nor moved. KIND is camera, chopper, blackbody or "
            "generator, such as chopper=mc2000b:/dev/ttyUSB0. May be repeated.",
        ),
    ] = None,
    folder: Annotated[Path, typer.Option(help="Where recordings would be written.", metavar="FOLDER")] = Path(),
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write what was found there.")] = None,
) -> None:
    """Say what of this computer is ready to record: packages, drivers, ports, disk and network, with a cure for each fault.

    Exit status 0 whatever is found.
    """
    from irtiming.archive.json_file import require_places, write_json
    from irtiming.session.computer import checks

    require_places({"JSON": [json]})
    devices = [_device(text) for text in device or ()]
    found = []
    for check in checks(folder, devices):
        found.append(asdict(check))
        say(f"{check.status:<8} {check.part}: {check.found}" + (f"; {check.cure}" if check.cure else ""))
    if json is not None:
        write_json({"checks": found}, json)


def _device(text: str) -> "Device":
    from irtiming.session.computer import Device, DeviceKind

    kinds = get_args(DeviceKind)
    kind, sign, address = text.partition("=")
    if kind not in kinds or not sign or not address:
        raise InstrumentError(f"--device {text!r} is no device; write KIND=ADDRESS with KIND one of {', '.join(kinds)}")
    return Device(kind=cast("DeviceKind", kind), address=address)

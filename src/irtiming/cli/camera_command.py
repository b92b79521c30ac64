"""`irtiming camera`: what a camera says of itself, and its features by their names of GenICam SFNC."""

import asyncio
from collections.abc import Sequence
from typing import Annotated

import typer

from irtiming.cli.screen import say
from irtiming.errors import InstrumentError, UnitError

_USUAL = (
    "Width", "Height", "PixelFormat", "AcquisitionMode", "TriggerSelector", "TriggerMode", "TriggerSource",
    "TriggerActivation", "ExposureTime", "AcquisitionFrameRate", "GevSCPSPacketSize", "GevTimestampTickFrequency",
    "DeviceTemperature",
)  # fmt: skip
"""Asked for where nothing else is; a camera need not have them all."""


def camera(
    address: Annotated[str, typer.Argument(help="As irtiming discover prints it, such as gige:192.168.0.7.")],
    get: Annotated[list[str] | None, typer.Option("--get", metavar="NAME", help="Feature to read; repeatable.")] = None,
    feature: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Feature to set, such as TriggerSource=Line1, or a command: NAME=execute; repeatable.",
        ),
    ] = None,
) -> None:
    """Say what a camera is, read its features, and set those that are named; each is read back."""
    from rich.console import Console

    screen = Console(highlight=False)
    for line in asyncio.run(_lines(address, get or [], named(feature or []))):
        say(line, screen)


def named(texts: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Names and values of texts such as ``"TriggerSource=Line1"``.

    Parameters
    ----------
    texts
        As typed.

    Raises
    ------
    UnitError
        If one has no name or no value.
    """
    found = []
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (name and sign and value):
            raise UnitError(f"--set '{text}' names no feature and value; write it like TriggerSource=Line1")
        found.append((name, value))
    return tuple(found)


async def _lines(address: str, get: Sequence[str], to_set: Sequence[tuple[str, str]]) -> list[str]:
    """What is to be said, one line each."""
    from irtiming.instruments.cameras import open_camera

    async with open_camera(address) as opened:
        who = opened.identity
        lines = [f"{who.vendor} {who.model}, serial number {who.serial_number}, firmware {who.firmware}, at {address}"]
        for name, value in to_set:
            lines.append(f"{name} = {await opened.set_feature(name, value=value)}")
        lines += [f"{name} = {await opened.feature(name)}" for name in get]
        for name in _USUAL if not get and not to_set else ():
            try:
                lines.append(f"{name} = {await opened.feature(name)}")
            except InstrumentError:
                continue
        return lines

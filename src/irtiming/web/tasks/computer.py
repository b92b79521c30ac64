"""What of this computer is ready, and which cameras and ports there are."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from irtiming.instruments.cameras import find
from irtiming.instruments.serial_line import ports
from irtiming.session.computer import checks
from irtiming.web.work import Line


def check(line: Line, folder: Path) -> list[dict[str, Any]]:
    """All checks of ``irtiming doctor``."""
    return [asdict(one) for one in checks(folder)]


def discover(line: Line, hosts: tuple[str, ...]) -> dict[str, Any]:
    """Cameras and serial ports, as ``irtiming discover`` finds them."""
    cameras, complaints = find(hosts=list(hosts), timeout_s=1.0)
    return {"cameras": [asdict(one) for one in cameras], "ports": ports(), "notes": complaints}

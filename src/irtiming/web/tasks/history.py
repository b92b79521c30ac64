"""The register of results asked for a camera's history, and results entered into it."""

from dataclasses import asdict
from datetime import date
from pathlib import Path
from typing import Any

from irtiming.archive.result_file import read_result
from irtiming.errors import UnitError
from irtiming.report.blocks import Table
from irtiming.report.sections import control_chart
from irtiming.report.sections import history as section
from irtiming.session import history
from irtiming.web.orders import EnterOrder, HistoryOrder
from irtiming.web.work import Line


def cameras(line: Line, register: Path) -> list[dict[str, Any]]:
    """Every camera of a register."""
    return [asdict(one) for one in history.cameras(str(register))]


def of_camera(line: Line, order: HistoryOrder) -> dict[str, Any]:
    """What ``irtiming history SERIAL`` shows, and the control chart of each leading parameter."""
    wanted = history.HistoryOrder(
        serial_number=order.serial_number, register=str(order.register), since=_day(order.since)
    )
    found = history.of_camera(wanted)
    panels = [control_chart.panel(one) for one in control_chart.charts(found.points)]
    return {
        "drift": _plain(section.drift(found.drifts)),
        "results": _plain(section.results(found.points)),
        "charts": [{"title": one.title, "caption": one.caption, "svg": one.svg} for one in panels],
        "is_simulated": any(one.simulated for one in found.points),
    }


def enter(line: Line, order: EnterOrder) -> dict[str, Any]:
    """What ``irtiming history --add`` does; gives how many were new, and the camera of the last."""
    new = history.add(order.results, str(order.register))
    return {"new": new, "serial_number": read_result(order.results[-1]).item.serial_number}


def _plain(table: Table) -> dict[str, Any]:
    right = [column for column, side in enumerate(table.align) if side == "r"]
    return {"title": table.title, "columns": table.columns, "rows": table.rows, "right": right, "note": table.note}


def _day(text: str) -> date | None:
    try:
        return date.fromisoformat(text.strip()) if text.strip() else None
    except ValueError as error:
        raise UnitError(f"drift counts from '{text:.40}', must be a day such as 2026-01-31") from error

"""Recordings analysed in a process of their own, and results read for a page."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

from irtiming.interface.files import read_result
from irtiming.records.choices import Choices, Method
from irtiming.session.analysis import AnalysisOrder
from irtiming.session.analysis import analyse as analyse_files
from irtiming.web.orders import AnalyseOrder
from irtiming.web.work import Line, give_way


def analyse(line: Line, order: AnalyseOrder) -> dict[str, Any]:
    """Analyse, and write result and report; gives their files."""
    give_way()
    wanted = AnalysisOrder(
        recordings=order.recordings, rig=order.rig, choices=Choices(method=cast("Method", order.method)), result=order.result,
        report=order.report, language=order.language,
    )  # fmt: skip
    analyse_files(wanted, progress=lambda name, done, total: line.step(name, done=done, total=total))
    return {"result": str(order.result), "report": str(order.report)}


def read(line: Line, path: Path) -> dict[str, Any]:
    """What a page shows of a result."""
    found = read_result(path)
    return {
        "headline": found.headline,
        "item": " ".join(filter(None, (found.item.manufacturer, found.item.model, found.item.serial_number))),
        "is_simulated": found.is_simulated,
        "findings": [asdict(one) for one in found.findings],
        "parameters": [[name.replace("_", " "), str(one), one.event] for name, one in found.items()],
        "relative_delays": [[Path(one.name).name, str(one)] for one in found.relative_delays],
        "recordings": [one.file for one in found.content.inputs],
    }

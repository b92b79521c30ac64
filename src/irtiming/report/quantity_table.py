"""Quantities and findings as a small table of HTML, for notebooks."""

from collections.abc import Sequence
from html import escape

from irtiming.records.finding import Finding
from irtiming.report.quantity import Quantity
from irtiming.report.rounding import significant, uncertainty_text


def html(quantities: Sequence[Quantity], *, heading: str = "", findings: Sequence[Finding] = ()) -> str:
    """A table with value, U and k (95 %), and what each is; below it one line for each finding."""
    rows = "".join(_row(one) for one in quantities)
    doubts = "".join(f"<li>{escape(one.sentence())}</li>" for one in findings)
    return (
        (f"<p><b>{escape(heading)}</b></p>" if heading else "")
        + "<table><thead><tr><th>parameter</th><th>value ± u</th><th>U (95 %)</th><th>k</th><th>what it is</th></tr></thead>"
        + f"<tbody>{rows}</tbody></table>"
        + (f"<ul>{doubts}</ul>" if doubts else "")
    )


def _row(one: Quantity) -> str:
    wide = one.expanded()
    expanded = uncertainty_text(wide) if one.unit == "s" else significant(wide)
    cells = (one.name, str(one), expanded, f"{one.coverage_factor():.2f}", one.event)
    return f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"

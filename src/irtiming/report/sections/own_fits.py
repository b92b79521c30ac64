"""The fits of single recordings, before they are put together: their quality, and what each finds beside the delays."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.estimate import SHARES, EdgeDelayFit, Estimate
from irtiming.report.blocks import DEG, MRAD, MS, US, Table
from irtiming.report.language import decimal, t
from irtiming.report.meanings import words
from irtiming.report.rounding import in_unit, significant
from irtiming.report.row_curves import whole

_OF_THE_LIGHT = {
    "bow": "Bow: by how much of its mean the opening is brighter at both ends than in its middle.",
    "blade_share": "Blade share: by how much the blade between edges 2 and 3 is warmer than the other, over the contrast.",
    "blade_share_beside": "Blade share beside: the same where cutouts sweep beside the opening.",
    "quadratic_nonlinearity": "Nonlinearities b and c: a pixel that is open to the share w shows w + b w (1 − w) + "
    "c w (1 − w) (1 − 2 w).",
}
"""Local numbers of 1 that a table explains."""


def table(analysis: Analysis) -> Table:
    """Quality of each recording's own fit, and what it finds beside the delays."""
    names = [name for name in analysis.fits[0].estimate.names if not name.startswith("edge_delay")]
    rows = []
    for recording, fit in zip(analysis.recordings, analysis.fits, strict=True):
        if isinstance(fit, EdgeDelayFit):
            used, n_rows, residual, noise = int(fit.kept.sum()), "–", fit.residual, fit.noise
        else:
            used, n_rows = fit.wheel_angle_rad.size, f"{fit.row_px.size} ({fit.row_px[0]} … {fit.row_px[-1]})"
            residual, noise = whole(fit).residual, float(np.median(fit.noise))
        rows.append(
            (
                fit.name,
                t("{n} of {total}", n=used, total=recording.n_frames),
                n_rows,
                significant(1e3 * float(np.sqrt(np.mean(residual**2)))),
                significant(1e3 * noise),
                decimal(f"{fit.variance_inflation**0.5:.2f}"),
                *(_local(fit.estimate, name) for name in names),
            )
        )  # fmt: skip
    return Table(
        title=t("Fits, recording by recording"),
        columns=(
            t("recording"),
            t("frames used"),
            t("rows"),
            t("rms residual, whole opening (10⁻³)"),
            t("noise of a sum (10⁻³)"),
            t("factor on u"),
            *(f"{words(name)} ({_local_unit(name)[1]})" for name in names),
        ),
        align="lrrrrr" + "r" * len(names),
        rows=tuple(rows),
        note=t(
            "Residuals in 10⁻³ of the step from covered to open; noise of a row sum, the median over the rows. "
            "Factor on u: root of the variance inflation because residuals are correlated; 1 when they are white."
        )
        + "".join(f" {t(what)}" for name, what in _OF_THE_LIGHT.items() if name in names),
    )


def _local_unit(name: str) -> tuple[float, str]:
    if name in SHARES:
        return 0.01, "%"
    if name in _OF_THE_LIGHT or name.endswith("_nonlinearity"):
        return 1e-3, "10⁻³"
    if name == "opening_angle":
        return DEG, "°"
    return (MRAD, "mrad") if name.startswith("lean") else (MS, "ms") if name == "time_constant" else (US, "µs")


def _local(found: Estimate, name: str) -> str:
    if name not in found:
        return "–"
    scale = _local_unit(name)[0]
    return f"{in_unit(found.value(name), found.u(name), unit_s=scale)} ± {significant(found.u(name) / scale)}"

"""What went in: choices and who made them, files with checksums, software."""

import platform
from importlib import metadata

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices
from irtiming.records.reduced import ReducedRecording
from irtiming.report.blocks import MS, US, Section, Table, common
from irtiming.report.language import decimal, heads, t
from irtiming.report.meanings import has_lag, method_name
from irtiming.report.sections import pixel_sums


def section(analysis: Analysis) -> Section:
    """Enough to repeat the analysis."""
    return Section(title=t("Choices, inputs, software"), blocks=(choices(analysis), inputs(analysis), software()))


def choices(analysis: Analysis) -> Table:
    """Every choice of the analysis, its value, and whether it was made automatically or by a person."""
    chosen, usual, recordings = analysis.choices, Choices(), analysis.recordings
    roll = analysis.geometry.camera_roll_rad

    def maker(name: str) -> str:
        return t("automatic") if getattr(chosen, name) == getattr(usual, name) else t("by you")

    rows = [
        (
            t("method"),
            method_name(analysis.result.method),
            t("by you") if chosen.method == "published" else t("default"),
        ),
        (t("region of interest"), common(recordings, _roi_text), maker("roi")),
        (
            t("threshold level between covered and open"),
            decimal(f"{chosen.threshold_level:.0%}"),
            maker("threshold_level"),
        ),
        (
            t("border of the summed region"),
            common(recordings, lambda r: f"{r.opening.border_px} px"),
            maker("border_px"),
        ),
        (t("bad pixels, replaced"), common(recordings, lambda r: str(r.opening.n_bad_pixels)), t("automatic")),
        (t("blackbody"), common(recordings, _side), t("automatic")),
        (t("axle in the image (row, column)"), common(recordings, _axle_text), t("automatic")),
        (
            t("camera roll, from the mask’s image"),
            t("not found") if roll is None else decimal(f"{np.degrees(roll):+.3f}°"),
            t("automatic"),
        ),
        (t("reference edge"), t(chosen.reference_edge), maker("reference_edge")),
        (t("cutout edges from"), t(analysis.geometry.edges_from), t("automatic")),
        (t("control slots"), t("learned from their timestamps (published method: equal)"), t("automatic")),
    ]
    if recordings[0].opening.histogram is not None:
        rows.append((t("threshold"), common(recordings, _threshold_text), maker("threshold_dn")))
        low, high = chosen.slope_limits
        margin = t("{share:.0%} of their width", share=chosen.plateau_margin)
        rows.append((t("margin of the plateaus"), margin, maker("plateau_margin")))
        rows.append(
            (t("lines fitted between fractions"), t("{low:g} and {high:g}", low=low, high=high), maker("slope_limits"))
        )
    for fit in pixel_sums.published_fits(analysis):
        plateaus = [decimal(f"{np.degrees(a):.1f}–{np.degrees(b):.1f}° ({level})") for a, b, level in fit.data.plateaus]
        rows.append(
            (
                t("plateaus, {set_ms:g} ms set", set_ms=fit.data.trigger_delay_time_set_s / MS),
                ", ".join(plateaus),
                t("automatic"),
            )
        )
    if has_lag(analysis) and chosen.substrate_temperature_k is not None:
        rows.append((t("substrate"), decimal(f"{chosen.substrate_temperature_k:.2f} K"), t("by you")))
    return Table(title=t("Choices"), columns=heads("what", "value", "chosen"), align="lll", rows=tuple(rows))


def _roi_text(recording: ReducedRecording) -> str:
    row0, row1, column0, column1 = recording.opening.roi
    return t(
        "rows {row0}–{row1}, columns {column0}–{column1}",
        row0=row0,
        row1=row1 - 1,
        column0=column0,
        column1=column1 - 1,
    )


def _threshold_text(recording: ReducedRecording) -> str:
    found = recording.opening.histogram
    if found is None:
        return "–"
    return t(
        "{threshold:.0f} DN, peaks at {plate:.0f} and {blackbody:.0f} DN",
        threshold=found.threshold_dn,
        plate=found.plate_dn,
        blackbody=found.blackbody_dn,
    )


def _side(recording: ReducedRecording) -> str:
    return t("colder than the wheel") if recording.opening.blackbody_is_colder else t("warmer than the wheel")


def _axle_text(recording: ReducedRecording) -> str:
    view = recording.axle
    return t("not found") if view is None else t("({row:.1f}, {column:.1f}) px", row=view.row_px, column=view.column_px)


def inputs(analysis: Analysis) -> Table:
    """Every file that was read, with what it says and its checksum."""
    rows = [
        (
            recording.file,
            str(recording.n_frames),
            decimal(f"{recording.trigger_delay_time_set_s / MS:g}"),
            "–" if recording.integration_time_s is None else decimal(f"{recording.integration_time_s / US:g}"),
            decimal(f"{recording.rotation_speed_hz:g}"),
            recording.sha256,
        )
        for recording in analysis.recordings
    ]
    rows.append((analysis.rig.source or "rig", "–", "–", "–", "–", analysis.rig.sha256))
    return Table(
        title=t("Inputs"),
        columns=heads("file", "frames", "delay set (ms)", "integration (µs)", "wheel (Hz)", "sha256"),
        align="lrrrrl",
        rows=tuple(rows),
    )


def software() -> Table:
    """Versions of everything that had a hand in the numbers."""
    return Table(title=t("Software"), columns=heads("package", "version"), align="ll", rows=tuple(versions().items()))


def versions() -> dict[str, str]:
    """Versions by name; a package that is not installed is left out."""
    found = {}
    for name in ("irtiming", "numpy", "scipy", "numba", "h5py", "hdf5plugin", "matplotlib", "GTC"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {**found, "python": platform.python_version(), "platform": platform.platform()}

"""What went in: choices and who made them, files with checksums, software."""

import platform
from importlib import metadata

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices
from irtiming.records.reduced import ReducedRecording
from irtiming.report.blocks import MS, US, Section, Table, common
from irtiming.report.meanings import METHOD_NAMES, has_lag
from irtiming.report.sections import pixel_sums


def section(analysis: Analysis) -> Section:
    """Enough to repeat the analysis."""
    return Section(title="Choices, inputs, software", blocks=(choices(analysis), inputs(analysis), software()))


def choices(analysis: Analysis) -> Table:
    """Every choice of the analysis, its value, and whether it was made automatically or by a person."""
    chosen, usual, recordings = analysis.choices, Choices(), analysis.recordings
    roll = analysis.geometry.camera_roll_rad

    def maker(name: str) -> str:
        return "automatic" if getattr(chosen, name) == getattr(usual, name) else "by you"

    rows = [
        ("method", METHOD_NAMES[analysis.result.method], "by you" if chosen.method == "published" else "default"),
        ("region of interest", common(recordings, _roi_text), maker("roi")),
        ("threshold level between covered and open", f"{chosen.threshold_level:.0%}", maker("threshold_level")),
        ("border of the summed region", common(recordings, lambda r: f"{r.opening.border_px} px"), maker("border_px")),
        ("bad pixels, replaced", common(recordings, lambda r: str(r.opening.n_bad_pixels)), "automatic"),
        ("blackbody", common(recordings, _side), "automatic"),
        ("axle in the image (row, column)", common(recordings, _axle_text), "automatic"),
        (
            "camera roll, from the mask’s image",
            "not found" if roll is None else f"{np.degrees(roll):+.3f}°",
            "automatic",
        ),
        ("reference edge", chosen.reference_edge, maker("reference_edge")),
        ("cutout edges from", analysis.geometry.edges_from, "automatic"),
        ("control slots", "learned from their timestamps (published method: equal)", "automatic"),
    ]
    if recordings[0].opening.histogram is not None:
        rows.append(("threshold", common(recordings, _threshold_text), maker("threshold_dn")))
        low, high = chosen.slope_limits
        rows.append(("margin of the plateaus", f"{chosen.plateau_margin:.0%} of their width", maker("plateau_margin")))
        rows.append(("lines fitted between fractions", f"{low:g} and {high:g}", maker("slope_limits")))
    for fit in pixel_sums.published_fits(analysis):
        plateaus = [f"{np.degrees(a):.1f}–{np.degrees(b):.1f}° ({level})" for a, b, level in fit.data.plateaus]
        rows.append((f"plateaus, {fit.data.trigger_delay_time_set_s / MS:g} ms set", ", ".join(plateaus), "automatic"))
    if has_lag(analysis) and chosen.substrate_temperature_k is not None:
        rows.append(("substrate", f"{chosen.substrate_temperature_k:.2f} K", "by you"))
    return Table(title="Choices", columns=("what", "value", "chosen"), align="lll", rows=tuple(rows))


def _roi_text(recording: ReducedRecording) -> str:
    row0, row1, column0, column1 = recording.opening.roi
    return f"rows {row0}–{row1 - 1}, columns {column0}–{column1 - 1}"


def _threshold_text(recording: ReducedRecording) -> str:
    found = recording.opening.histogram
    if found is None:
        return "–"
    return f"{found.threshold_dn:.0f} DN, peaks at {found.plate_dn:.0f} and {found.blackbody_dn:.0f} DN"


def _side(recording: ReducedRecording) -> str:
    return "colder than the wheel" if recording.opening.blackbody_is_colder else "warmer than the wheel"


def _axle_text(recording: ReducedRecording) -> str:
    view = recording.axle
    return "not found" if view is None else f"({view.row_px:.1f}, {view.column_px:.1f}) px"


def inputs(analysis: Analysis) -> Table:
    """Every file that was read, with what it says and its checksum."""
    rows = [
        (
            recording.file,
            str(recording.n_frames),
            f"{recording.trigger_delay_time_set_s / MS:g}",
            "–" if recording.integration_time_s is None else f"{recording.integration_time_s / US:g}",
            f"{recording.rotation_speed_hz:g}",
            recording.sha256,
        )
        for recording in analysis.recordings
    ]
    rows.append((analysis.rig.source or "rig", "–", "–", "–", "–", analysis.rig.sha256))
    return Table(
        title="Inputs",
        columns=("file", "frames", "delay set (ms)", "integration (µs)", "wheel (Hz)", "sha256"),
        align="lrrrrl",
        rows=tuple(rows),
    )


def software() -> Table:
    """Versions of everything that had a hand in the numbers."""
    return Table(title="Software", columns=("package", "version"), align="ll", rows=tuple(versions().items()))


def versions() -> dict[str, str]:
    """Versions by name; a package that is not installed is left out."""
    found = {}
    for name in ("irtiming", "numpy", "scipy", "numba", "h5py", "hdf5plugin", "matplotlib", "GTC"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {**found, "python": platform.python_version(), "platform": platform.platform()}

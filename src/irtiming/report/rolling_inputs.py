"""What went into a rolling camera's result: choices, the opening in the image, files."""

import numpy as np

from irtiming.report.evidence import RollingEvidence
from irtiming.report.rolling_tables import METHOD_NAMES
from irtiming.report.rounding import significant
from irtiming.report.tables import Table

MS = 1e-3
_SHAPE = (
    ("axle, row (px)", "axle_row_px", 1.0),
    ("axle, column (px)", "axle_column_px", 1.0),
    ("mask centre beside the axle, rows (px)", "offset_row_px", 1.0),
    ("mask centre beside the axle, columns (px)", "offset_column_px", 1.0),
    ("inner radius (px)", "inner_radius_px", 1.0),
    ("outer radius (px)", "outer_radius_px", 1.0),
    ("bisector (degrees)", "bisector_rad", 180 / np.pi),
    ("opening angle (degrees)", "opening_angle_rad", 180 / np.pi),
    ("blur, standard deviation (px)", "blur_px", 1.0),
    ("distortion of the lens", "distortion", 1.0),
)


def choices(evidence: RollingEvidence) -> Table:
    """Every choice of the analysis, its value, and whether it was made automatically or by a person."""
    chosen = evidence.choices
    first = evidence.recordings[0]
    row0, row1, column0, column1 = first.opening.roi
    roll = evidence.geometry.camera_roll_rad
    automatic = chosen.reference_edge == "automatic"
    rows = [
        ("method", METHOD_NAMES[evidence.result.method], "by you" if chosen.method == "published" else "default"),
        (
            "region of interest",
            f"rows {row0}–{row1 - 1}, columns {column0}–{column1 - 1}",
            "automatic" if chosen.roi is None else "by you",
        ),
        (
            "border of the summed region",
            f"{first.opening.border_px} px",
            "automatic" if chosen.border_px is None else "by you",
        ),
        (
            "mask’s place between covered and open contrast",
            f"{chosen.threshold_level:.0%}",
            "automatic" if chosen.threshold_level == 0.5 else "by you",
        ),
        ("bad pixels in the summed region", str(first.opening.n_bad_pixels), "automatic"),
        ("blackbody", "colder than the wheel" if first.opening.blackbody_is_colder else "warmer", "automatic"),
        (
            "camera roll, from the mask’s image",
            "not found" if roll is None else f"{np.degrees(roll):+.3f}°",
            "automatic",
        ),
        ("reference edge", chosen.reference_edge, "automatic" if automatic else "by you"),
        ("cutout edges from", evidence.geometry.edges_from, "automatic"),
        ("control slots", "learned from their timestamps (published method: equal)", "automatic"),
    ]
    return Table(title="Choices", columns=("what", "value", "chosen"), align="lll", rows=tuple(rows))


def sector(evidence: RollingEvidence) -> Table:
    """The opening in the image as fitted."""
    found = evidence.sector
    u = np.sqrt(np.diag(found.covariance))
    rows = [
        (words, f"{getattr(found.shape, name) * factor:.4f}".replace("-", "−"), significant(float(u[k]) * factor))
        for k, (words, name, factor) in enumerate(_SHAPE)
    ]
    rows.append(
        ("row delay by the pixels’ phases (µs)", f"{1e6 * found.row_delay_s:.3f}".replace("-", "−"),
         significant(1e6 * found.u_row_delay_s))
    )  # fmt: skip
    return Table(
        title="The opening in the image",
        columns=("what", "value", "u"),
        align="lrr",
        rows=tuple(rows),
        note="An annular sector, blurred, fitted to the contrast image of all recordings; reduced χ² "
        f"{found.reduced_chi_square:.3g}. Above 1 the opening is no perfect sector or pixels differ in gain: what is left over "
        "enters the model as it is.",
    )


def inputs(evidence: RollingEvidence) -> Table:
    """Every file that was read, with what it says and its checksum."""
    rows = [
        (
            recording.source or recording.name,
            str(recording.n_frames),
            f"{recording.trigger_delay_time_set_s / MS:g}",
            f"{recording.rotation_speed_hz:g}",
            recording.sha256,
        )
        for recording in evidence.recordings
    ]
    rows.append((evidence.rig.source or "rig", "–", "–", "–", evidence.rig.sha256))
    return Table(
        title="Inputs",
        columns=("file", "frames", "delay set (ms)", "wheel (Hz)", "sha256"),
        align="lrrrl",
        rows=tuple(rows),
    )

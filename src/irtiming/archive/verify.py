"""Everything that is wrong with a recording file, at once."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

import h5py
import numpy as np

from irtiming.archive import consistency, layout
from irtiming.archive.consistency import Contents
from irtiming.archive.fields import near_misses, read_field, read_temperature
from irtiming.archive.finding import Complaint, error_at, warning_at
from irtiming.archive.frame_stack import FileFrames
from irtiming.archive.frame_status import leave_out
from irtiming.archive.frame_survey import FrameSurvey, survey
from irtiming.archive.hdf5_bounds import DEEPEST, MOST_OBJECTS
from irtiming.archive.hdf5_file import H5_ERRORS, opened, reason_of
from irtiming.archive.layout import Field
from irtiming.archive.live.unfinished import unfinished
from irtiming.archive.reader import check_version, reduce_reference
from irtiming.archive.recording_checks import check_stamps
from irtiming.archive.signal_checks import check_signal
from irtiming.archive.tick_checks import duration
from irtiming.errors import ArchiveError
from irtiming.records.finding import Finding
from irtiming.records.recording import FEWEST_FRAMES
from irtiming.records.rig import Rig
from irtiming.units import counted

Progress: TypeAlias = Callable[[int, int], None]
"""Called with frames read and all frames."""

_MUCH_CLIPPED = 0.01
_SOME_CLIPPED = 0.001
_LARGE_CHUNK = 64 * 2**20


def verify(path: str | Path, *, progress: Progress | None = None, rig: Rig | None = None) -> list[Finding]:
    """Read a whole recording file and list every complaint, errors first.

    Never raises because of the file. Without an error the list begins with one finding "ok" that says what
    the file holds.

    Parameters
    ----------
    path
        The recording.
    progress
        Called with frames read and all frames while the frames are streamed.
    rig
        On which it was recorded: then what the frames show is held against it.
    """
    findings: list[Finding] = []
    contents: Contents = {}
    if str(path).endswith(layout.PART):
        return [unfinished(path)]
    try:
        with opened(path) as file:
            findings += _of_fields(file, contents)
            findings += _strangers(file)
            findings += _storage(file, contents)
    except Complaint as complaint:
        return [complaint.finding]
    except H5_ERRORS as error:
        what = f"cannot be read ({reason_of(error)})"
        return [error_at("", what, code="file-damaged", cure="the file is damaged; copy or record it again")]
    stored_shape = contents[layout.FRAMES]
    contents, kept, left_out = leave_out(contents)
    findings += left_out
    findings += consistency.check(contents)
    findings += check_stamps(contents)
    findings += _too_few(contents)
    findings += _what_a_photon_detector_needs(contents)
    whole = None if stored_shape is None else FileFrames(path, shape=stored_shape, kept=kept)
    findings += _of_frames(Path(path), contents, whole=whole, progress=progress, rig=rig)
    order = ("error", "doubt", "warning", "info")
    findings.sort(key=lambda finding: order.index(finding.severity))
    if not any(finding.severity == "error" for finding in findings):
        findings.insert(0, _summary(contents))
    return findings


def _of_fields(file: h5py.File, contents: Contents) -> Iterator[Finding]:
    """Read every field into ``contents`` and complain about each that cannot be."""
    try:
        check_version(file)
    except Complaint as complaint:
        yield complaint.finding
    for field in layout.FIELDS:
        contents[field] = None
        try:
            contents[field] = read_field(file, field)
        except Complaint as complaint:
            yield complaint.finding
    temperatures: dict[Field, float | None] = {}
    for field in (layout.REFERENCE_LOW, layout.REFERENCE_HIGH):
        try:
            temperatures[field] = None if contents[field] is None else read_temperature(file, field)
        except Complaint as complaint:
            yield complaint.finding
    yield from consistency.check_temperatures(temperatures)
    yield from near_misses(file)


def _strangers(file: h5py.File) -> list[Finding]:
    """Datasets that no reader of this program looks at."""
    known = {field.path for field in layout.FIELDS} | {layout.ACQUISITION_MODE}
    findings: list[Finding] = []
    n_objects = 0

    def _look(name: str, item: object) -> bool | None:
        nonlocal n_objects
        n_objects += 1
        path = f"/{name}"
        if path.count("/") > DEEPEST or n_objects > MOST_OBJECTS:
            what = f"is as far as this program looks: {n_objects} objects, {path.count('/')} deep"
            findings.append(Finding(code="objects-many", severity="info", where=f"{path[:80]}", what=what))
            return True
        ours = path in known or path.startswith((f"{layout.TRUTH}/", f"{layout.PLOT}/", f"{layout.ACQUISITION}/"))
        if isinstance(item, h5py.Dataset) and not ours:
            findings.append(
                Finding(code="dataset-unknown", severity="info", where=path, what="is not read by irtiming")
            )
        return None

    file.visititems(_look)
    return findings


def _storage(file: h5py.File, contents: Contents) -> Iterator[Finding]:
    """Ways of storing frames that are allowed but slow."""
    if contents[layout.FRAMES] is None:
        return
    chunks = file[layout.FRAMES.path].chunks
    where, cure = layout.FRAMES.path, "store one frame per chunk"
    if chunks is None:
        return
    if tuple(chunks[1:]) != tuple(contents[layout.FRAMES][1:]):
        what = f"has chunks of {chunks} that are not whole frames: reading is slow"
        yield warning_at(where, what, code="chunks-not-whole-frames", cure=cure)
    elif (size := 2 * math.prod(chunks)) > _LARGE_CHUNK and chunks[0] > 1:
        what = f"has chunks of {chunks[0]} frames, {size // 2**20} MiB: reading is slow and takes memory"
        yield warning_at(where, what, code="chunks-large", cure=cure)


def _what_a_photon_detector_needs(contents: Contents) -> Iterator[Finding]:
    if contents[layout.CAMERA_TYPE] != "photon":
        return
    needed = (
        (layout.INTEGRATION_TIME, "analyse can then give the middle of the integration only, not its start"),
        (layout.REFERENCE_LOW, "the frames cannot be corrected for non-uniformity"),
    )
    for field, consequence in needed:
        if contents[field] is None:
            what = f"is absent or unreadable in a photon recording: {consequence}"
            yield warning_at(field.path, what, code="photon-field-absent", cure="write it if it is known")


def _of_frames(
    path: Path, contents: Contents, *, whole: FileFrames | None, progress: Progress | None, rig: Rig | None
) -> Iterator[Finding]:
    """Stream all stacks and complain about their values."""
    for field in (layout.FRAMES, layout.REFERENCE_LOW, layout.REFERENCE_HIGH):
        shape = contents[field]
        if shape is None:
            continue
        frames = whole if field is layout.FRAMES and whole else FileFrames(path, field.path, shape=shape)
        bit_depth = contents[layout.BIT_DEPTH] or 16
        try:
            surveyed = survey(frames, bit_depth=bit_depth, progress=progress if field is layout.FRAMES else None)
        except ArchiveError as error:
            cause = error.__cause__
            wrong = Finding(code="stack-unreadable", severity="error", where=field.path, what=str(error))
            yield cause.finding if isinstance(cause, Complaint) else wrong
            continue
        yield from _of_survey(surveyed, field, bit_depth=bit_depth)
        if field is layout.FRAMES and not surveyed.dead_frames.size:
            yield from check_signal(contents, surveyed.tiles_dn, rig=rig)
    yield from _of_reference(path, contents)


def _too_few(contents: Contents) -> Iterator[Finding]:
    shape = contents[layout.FRAMES]
    if shape is not None and shape[0] < FEWEST_FRAMES:
        yield warning_at(
            layout.FRAMES.path,
            f"has {counted(int(shape[0]), 'frame')}, at least {FEWEST_FRAMES} are needed: analyse refuses the recording",
            code="frames-few",
            cure="record a whole measurement (irtiming plan)",
        )


def _of_survey(surveyed: FrameSurvey, field: Field, *, bit_depth: int) -> Iterator[Finding]:
    highest = 2**bit_depth - 1
    where = field.path
    if (largest := int(surveyed.highest_dn.max())) > highest:
        what = f"reaches {largest}, which does not fit into bit_depth_readout = {bit_depth} bits"
        yield error_at(where, what, code="bit-depth-exceeded", cure="correct bit_depth_readout")
    if surveyed.dead_frames.size:
        first = int(surveyed.dead_frames[0])
        what = (
            f"has {counted(surveyed.dead_frames.size, 'dead frame')}, the first is frame {first}: "
            f"all pixels are {int(surveyed.lowest_dn[first])}"
        )
        yield error_at(where, what, code="frames-dead", cure="check camera and link, record again")
    living = np.setdiff1d(surveyed.repeated_frames, surveyed.dead_frames)
    if living.size:
        what = f"has {counted(living.size, 'frame')} equal to the one before, the first is frame {living[0]}"
        yield error_at(where, what, code="frames-repeated", cure="the camera missed triggers; record again")
    for share, name in ((surveyed.saturated_share, f"saturated ({highest})"), (surveyed.zero_share, "clipped at 0")):
        if share > _SOME_CLIPPED:
            yield Finding(
                code="values-clipped",
                severity="error" if share > _MUCH_CLIPPED else "warning",
                where=where,
                what=f"has {share:.2%} of its values {name}",
                cure="choose another integration time, gain or blackbody temperature",
            )


def _of_reference(path: Path, contents: Contents) -> Iterator[Finding]:
    low, high = contents[layout.REFERENCE_LOW], contents[layout.REFERENCE_HIGH]
    if low is None or high is None or low[1:] != high[1:]:
        return
    low_frames = FileFrames(path, layout.REFERENCE_LOW.path, shape=low)
    high_frames = FileFrames(path, layout.REFERENCE_HIGH.path, shape=high)
    try:
        low_dn, high_dn, low_noise_dn, high_noise_dn = reduce_reference(low_frames, high_frames)
    except ArchiveError:
        return  # the survey has reported
    noise = math.hypot(float(np.median(low_noise_dn)), float(np.median(high_noise_dn)))
    step = float(np.median(high_dn - low_dn))
    if step < -3 * noise:
        yield error_at(
            layout.REFERENCE,
            f"has low and high exchanged: high is {-step:.4g} DN darker than low, at a noise of {noise:.2g} DN",
            code="references-exchanged",
            cure="exchange the two: high is the brighter one, of the warmer blackbody",
        )
    elif step <= 3 * noise:
        yield warning_at(
            layout.REFERENCE,
            f"rises by {step:.4g} DN from low to high at a noise of {noise:.2g} DN",
            code="reference-contrast-low",
            cure="high must be clearly brighter; record the two at temperatures further apart",
        )


def _summary(contents: Contents) -> Finding:
    n_frames, rows, columns = contents[layout.FRAMES]
    camera = f"{contents[layout.CAMERA_TYPE]}, {contents[layout.READOUT_MODE]}"
    triggers, n_edges = contents[layout.CAMERA_TRIGGER], contents[layout.APPLICATION_SLOT].size
    beside = (
        f"of a camera that runs free, counted from the {contents[layout.FRAME_EVENT]}"
        if triggers is None
        else f"for {triggers.size} triggers in {duration(contents)}"
    )
    what = f"{camera}: {n_frames} frames of {rows} x {columns} {beside}, {(n_edges - 1) // 2} turns"
    return Finding(code="recording-sound", severity="ok", where="", what=what)

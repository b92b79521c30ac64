"""From a recording file to a checked `Recording`; its frames stay in the file and are streamed."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.checksum import sha256_of
from irtiming.archive.consistency import Contents
from irtiming.archive.contents import Checked, checked, read_contents
from irtiming.archive.fields import as_text
from irtiming.archive.finding import Complaint, archive_error, refuse
from irtiming.archive.frame_stack import FileFrames
from irtiming.archive.hdf5_file import damage_at, opened
from irtiming.archive.layout import Field
from irtiming.archive.live.unfinished import unfinished
from irtiming.records.arrays import Array, Ticks, read_only
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.recording import FrameStack, NonuniformityReference, Recording


def read(path: str | Path) -> Recording:
    """Recording in a file, every field checked; only its frames stay in the file.

    Optional fields that are absent get the defaults of `Recording`: no extra trigger delay, 16 bits, frame i
    made by trigger i, None for the others. Oddities that do not stop an analysis stand in ``findings``.

    Returns
    -------
    The recording; ``frames`` opens the file anew for each pass.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or a field is missing, of the wrong type, shape or unit, out of range, or
        contradicts another. One line: file, field, what is, what to do.
    """
    if str(path).endswith(layout.PART):
        raise archive_error(path, unfinished(path))
    try:
        with opened(path) as file:
            check_version(file)
            found = checked(file, read_contents(file))
        return recording_of(path, found, sha256=sha256_of(path))
    except Complaint as complaint:
        raise complaint.as_error(path) from complaint


def recording_of(path: str | Path, found: Checked, *, sha256: str = "", is_growing: bool = False) -> Recording:
    """Recording of what was found in a file, its frames streamed from there.

    Parameters
    ----------
    path
        The file.
    found
        What it says.
    sha256
        Its checksum, empty if it has none yet.
    is_growing
        Whether it is still being written.

    Raises
    ------
    ArchiveError
        If a reference stack cannot be read.
    """
    contents = found.contents

    def _frames(field: Field, kept: Ticks | None = None) -> FileFrames:
        shape = found.stored_shape if field is layout.FRAMES else contents[field]
        return FileFrames(path, field.path, shape=shape, kept=kept, is_growing=is_growing)

    nonuniformity = None
    if contents[layout.REFERENCE_LOW] is not None:
        nonuniformity = nonuniformity_of(
            _frames(layout.REFERENCE_LOW),
            _frames(layout.REFERENCE_HIGH),
            low_k=found.temperatures[layout.REFERENCE_LOW],
            high_k=found.temperatures[layout.REFERENCE_HIGH],
        )
    return replace(
        _recording(Path(path), contents, frames=_frames(layout.FRAMES, found.kept)),
        nonuniformity=nonuniformity,
        sha256=sha256,
        findings=found.findings,
        is_simulated=found.is_simulated,
    )


def read_truth(path: str | Path) -> dict[str, Any]:
    """What a simulation knows about its recording, by name (the unit is the suffix of the name).

    Returns
    -------
    Numbers, texts and arrays as they were given to the writer; empty for a recording of a real camera.

    Raises
    ------
    ArchiveError
        If the file cannot be read.
    """
    return _flat(path, layout.TRUTH)


def read_acquisition(path: str | Path) -> dict[str, Any]:
    """What the instruments said of themselves when a recording began, by name, such as ``"chopper_blade"``.

    Returns
    -------
    Numbers and texts; empty for a recording that another program made.

    Raises
    ------
    ArchiveError
        If the file cannot be read.
    """
    return _flat(path, layout.ACQUISITION)


def _flat(path: str | Path, where: str) -> dict[str, Any]:
    """Numbers, texts and arrays of one group, by name."""
    values: dict[str, Any] = {}
    try:
        with opened(path) as file, damage_at(where):
            group = file.get(where)
            for name, dataset in group.items() if isinstance(group, h5py.Group) else ():
                if not isinstance(dataset, h5py.Dataset):
                    continue
                value = dataset[()]
                text = as_text(value)
                values[name] = value if text is None else text
                if isinstance(value, np.generic) and text is None:
                    values[name] = value.item()
    except Complaint as complaint:
        raise complaint.as_error(path) from complaint
    return values


def check_version(file: h5py.File) -> None:
    """Refuse a file of a later layout than this program knows; a file without a version is taken as it is.

    Raises
    ------
    Complaint
        If the version is later than `layout.VERSION`, or no number.
    """
    where = f"{layout.ENTRY}@{layout.VERSION_ATTRIBUTE}"
    with damage_at(where):
        entry = file.get(layout.ENTRY)
        version = None if entry is None else entry.attrs.get(layout.VERSION_ATTRIBUTE)
    if version is None:
        return
    if not isinstance(version, (int, np.integer)):
        raise refuse(
            where, f"is {as_text(version) or version!r}", code="version-not-an-integer", cure="it must be an integer"
        )
    if version > layout.VERSION:
        raise refuse(
            where,
            f"= {version} is later than {layout.VERSION}",
            code="version-too-new",
            cure="update irtiming to read this file",
        )


def reduce_reference(low: FrameStack, high: FrameStack) -> tuple[Array, Array, Array, Array]:
    """Mean and standard deviation over the frames of two reference stacks, streamed.

    Returns
    -------
    Mean of low and of high, standard deviation of low and of high (0 for a single frame); shape
    (row, column), DN.
    """
    low_mean, low_noise = _mean_and_deviation(low)
    high_mean, high_noise = _mean_and_deviation(high)
    return low_mean, high_mean, low_noise, high_noise


def _mean_and_deviation(frames: FrameStack) -> tuple[Array, Array]:
    n_frames, rows, columns = frames.shape
    origin = np.zeros((rows, columns))
    total = np.zeros((rows, columns))
    squares = np.zeros((rows, columns))
    for first, block in frames.blocks():
        if first == 0:
            origin = block[0].astype(np.float64)
        for frame in block:
            offset = frame - origin
            total += offset
            squares += offset * offset
    mean = origin + total / n_frames
    variance = (squares - total * total / n_frames) / max(n_frames - 1, 1)
    return mean, np.sqrt(np.maximum(variance, 0.0))


def nonuniformity_of(
    low_frames: FrameStack, high_frames: FrameStack, *, low_k: float | None, high_k: float | None
) -> NonuniformityReference:
    """Reference from raw frames of the bare blackbody, streamed.

    Parameters
    ----------
    low_frames, high_frames
        Frames at the colder and at the warmer temperature.
    low_k, high_k
        These temperatures, None where they are not known.

    Raises
    ------
    ArchiveError
        If a frame cannot be read.
    """
    low, high, low_noise, high_noise = (read_only(a) for a in reduce_reference(low_frames, high_frames))
    return NonuniformityReference(
        low_dn=low,
        high_dn=high,
        low_noise_dn=low_noise,
        high_noise_dn=high_noise,
        n_frames=min(low_frames.shape[0], high_frames.shape[0]),
        low_temperature_k=low_k,
        high_temperature_k=high_k,
        low_frames=low_frames,
        high_frames=high_frames,
    )


def _recording(path: Path, contents: Contents, *, frames: FrameStack) -> Recording:
    values = {field.attribute: contents[field] for field in layout.FIELDS if field.attribute}
    found = {name: value for name, value in values.items() if value is not None}
    found["name"] = found.get("name") or path.stem
    found.setdefault("frame_number", read_only(np.arange(frames.shape[0], dtype=np.int64)))
    found.setdefault("camera_trigger_ticks", read_only(np.zeros(0, np.int64)))
    told = {name: contents[field] for name, field in layout.SETTINGS.items() if contents[field] is not None}
    settings = CameraSettings(**told)
    return Recording(frames=frames, camera=_identity(contents), settings=settings, source=str(path), **found)


def _identity(contents: Contents) -> CameraIdentity | None:
    if all(contents[field] is None for field in layout.IDENTITY):
        return None
    return CameraIdentity(**{field.name: contents[field] or "" for field in layout.IDENTITY})

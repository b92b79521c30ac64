"""Which recipe reduces a recording: pixel sums where all pixels are read at once and do not lag, else row sums."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from irtiming.errors import EstimationError, ReductionError
from irtiming.records.choices import Choices
from irtiming.records.recording import FEWEST_FRAMES, Recording
from irtiming.records.reduced import Opening, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import clipping, motion_filter, pixel_sums, row_sums, suspicions
from irtiming.reduce.events import period
from irtiming.reduce.wheel import wheel_angles

_MOVED_PX = 1.0


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None] = lambda n: None,
    before: Opening | None = None, maps: bool = False,
) -> ReducedRecording:  # fmt: skip
    """Sums of every frame that shows the scene, the wheel's track, and the contrast of each pixel.

    Parameters
    ----------
    recording
        Its frames are read once in a stream, after a look at some of them.
    rig
        As measured by its owner.
    choices
        What a person decided instead of the automatic choice.
    progress
        Is given the number of frames done so far.
    before
        Opening of an earlier recording of the same camera, taken over where it is still in place.
    maps
        Whether to gather what maps of every pixel are made of.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    wheel_angles.refuse_lost_timestamps(recording)
    if recording.frames.shape[0] < FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {recording.frames.shape[0]} frames, at least {FEWEST_FRAMES} are needed; record a whole "
            "measurement (irtiming plan)"
        )
    is_instant = (recording.camera_type, recording.readout_mode) == ("photon", "snapshot")
    recipe = pixel_sums if is_instant else row_sums
    with suspicions.explained(recording, rig, choices=choices):
        reduced = recipe.reduce(recording, rig, choices=choices, progress=progress, before=before, maps=maps)
        clipping.refuse(recording, reduced.opening.mask)
    reduced = replace(reduced, findings=(*reduced.findings, *motion_filter.findings(recording)))
    if before is not None:
        _refuse_another(recording, reduced.opening, before)
    return period.refined(reduced)


def _refuse_another(recording: Recording, opening: Opening, before: Opening) -> None:
    """Refuse an opening that lies elsewhere than before, or is of another size.

    Masks of an opening in its place differ by some pixels of their border, which move their middle by a part of a pixel; then
    that of the first recording is taken for all.
    """
    (row, column), (row_before, column_before) = (np.argwhere(one.mask).mean(axis=0) for one in (opening, before))
    if np.hypot(row - row_before, column - column_before) > _MOVED_PX:
        raise ReductionError(
            f"{recording.name}: the middle of the opening lies in row {row:.1f}, column {column:.1f}, in the recordings before "
            f"in row {row_before:.1f}, column {column_before:.1f}; all must be of one camera in one place: it or the mask was "
            "moved, or it is another camera; analyse them apart"
        )
    if opening.roi != before.roi:
        raise ReductionError(
            f"{recording.name}: the opening has {opening.mask.sum()} pixels, {before.mask.sum()} in the recordings before; all "
            "must show the same one: check that type and readout_mode are those of the camera, and that neither focus nor "
            "temperatures differ; else analyse them apart"
        )


def check_goes_with(recording: Recording, before: Sequence[ReducedRecording], *, choices: Choices) -> None:
    """Refuse what cannot be analysed together.

    Parameters
    ----------
    recording
        The next one.
    before
        Those that it is to go with.
    choices
        What a person decided.

    Raises
    ------
    EstimationError
        If it is one of them again, of another camera, of another size, or has a reference edge named that may be another
        one in it.
    """
    size = recording.frames.shape[1:]
    same = next((other for other in before if recording.sha256 and other.sha256 == recording.sha256), None)
    if same is not None:
        raise EstimationError(
            f"{recording.source} and {same.source} are the same recording (sha256 {recording.sha256[:12]}…): counted twice it "
            "would make the uncertainty too small; name each recording once"
        )
    for other in before:
        _refuse_another_camera(recording, other)
        kinds = [one.events.kind if one.events else "trigger" for one in (recording, other)]
        if kinds[0] != kinds[1]:
            raise EstimationError(
                f"{recording.name} counts from the {kinds[0]} (frame_event), {other.name} from the {kinds[1]}: all must count "
                "from one event; analyse them apart"
            )
    if before and choices.reference_edge != "automatic":
        raise EstimationError(
            f"the {choices.reference_edge} application edge was named as reference, which may be another edge in "
            f"{recording.name} than in {before[0].name}; name it for one recording at a time"
        )
    if before and before[0].opening.mask.shape != size:
        raise EstimationError(
            f"{recording.name} has frames of {size[0]} x {size[1]} pixels, {before[0].name} of "
            f"{before[0].opening.mask.shape[0]} x {before[0].opening.mask.shape[1]}: all must be of one camera with one window; "
            "analyse them apart"
        )


def check_one_opening(recordings: Sequence[ReducedRecording]) -> None:
    """Refuse recordings that were reduced each for itself: their sums are of other pixels.

    Parameters
    ----------
    recordings
        One or more, of one analysis.

    Raises
    ------
    EstimationError
        If the opening of one is not that of the others; the message names both.
    """
    first = recordings[0]
    for other in recordings[1:]:
        if other.opening.roi != first.opening.roi or not np.array_equal(other.opening.mask, first.opening.mask):
            raise EstimationError(
                f"{other.name} was reduced with an opening of {other.opening.mask.sum()} pixels in {_place(other)}, {first.name} "
                f"with one of {first.opening.mask.sum()} in {_place(first)}: all must have the same; give the recordings before "
                "to measurement.reduce as before=, or let measurement.analyse do it"
            )


def _place(one: ReducedRecording) -> str:
    row0, row1, column0, column1 = one.opening.roi
    return f"rows {row0} to {row1 - 1}, columns {column0} to {column1 - 1}"


def _refuse_another_camera(recording: Recording, other: ReducedRecording) -> None:
    """Refuse where both say which camera made them, and differ; what a recording does not say is no difference."""
    _refuse_another_setting(recording, other)
    if recording.camera is None or other.camera is None:
        return
    for name in ("vendor", "model", "serial_number", "firmware"):
        here, there = getattr(recording.camera, name), getattr(other.camera, name)
        if here and there and here != there:
            raise EstimationError(
                f"{recording.name} is of a camera with {name.replace('_', ' ')} '{here}', {other.name} of one with '{there}': "
                "all must be of one camera, with one firmware; analyse them apart"
            )


def _refuse_another_setting(recording: Recording, other: ReducedRecording) -> None:
    """Refuse where both say what the camera was set to, and differ: its timing may be another one."""
    here, there = recording.settings, other.settings
    for words, one, two in (
        ("gain setting", here.gain_setting, there.gain_setting),
        ("internal delay (s)", here.internal_delay_set_s, there.internal_delay_set_s),
        ("first row of the region", here.region_first_row, there.region_first_row),
    ):
        if one not in (None, "") and two not in (None, "") and one != two:
            raise EstimationError(
                f"{recording.name} was made with {words} {one}, {other.name} with {two}: all must be of one setting; analyse "
                "them apart, or give them to irtiming series"
            )

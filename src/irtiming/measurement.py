"""The story on one screen: recordings in, analysis out. Needs no rig, so it can be repeated years later."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

from irtiming.archive.recording_checks import check_recording
from irtiming.errors import EstimationError, computing
from irtiming.estimate import diagnosis, pixel_maps, profiles, timing, two_constants
from irtiming.estimate.published import procedure
from irtiming.estimate.timing import Timing
from irtiming.plan import hindsight
from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices
from irtiming.records.finding import doubted, noted
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.series_order import in_order
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.reduce import recipes
from irtiming.reduce.events import placing
from irtiming.reduce.published import average_runs, row_averages
from irtiming.reduce.wheel import common_reference, pooled_slots

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called with the recording's name, frames done and frames in all."""

Extra: TypeAlias = Literal["published", "profiles", "prediction", "diagnosis", "maps"]
"""What is made beside the estimate on request: the paper's procedure, profile likelihoods, what the recordings should tell, what
explains structured residuals, and maps of every pixel, for which `reduce` gathers more."""

ALL_EXTRAS: tuple[Extra, ...] = ("published", "profiles", "prediction", "diagnosis")


def analyse(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None,
    wheel_calibration: WheelCalibration | None = None, extras: Collection[Extra] = (),
) -> Analysis:  # fmt: skip
    """Timing of a camera from its recordings.

    Parameters
    ----------
    recordings
        One per run; of any nominal delays and wheel speeds, all of one camera on one rig, in any order.
    rig
        As measured by its owner.
    choices
        What a person decided instead of the automatic choice, the method among it.
    progress
        Called as frames are read.
    wheel_calibration
        Slots of the same wheel from other recordings, to be taken together with what these tell.
    extras
        What to make beside the estimate.

    Raises
    ------
    IrTimingError
        If a recording cannot be reduced or the data do not determine the timing; a note names the stage.
    """
    reduced: list[ReducedRecording] = []
    for recording in common_reference.clear_first(in_order(recordings)):
        one = reduce(recording, rig, before=reduced, choices=choices, progress=progress, maps="maps" in extras)
        reduced.append(one)
    return estimate(reduced, rig, choices=choices, wheel_calibration=wheel_calibration, extras=extras)


def reduce(
    recording: Recording, rig: Rig, *, before: Sequence[ReducedRecording] = (), choices: Choices | None = None,
    progress: Progress | None = None, maps: bool = False,
) -> ReducedRecording:  # fmt: skip
    """One recording read through, all frames to sums; those ``before`` go with it, and give their opening. See `analyse`."""
    choices, total = choices or Choices(), recording.frames.shape[0]
    recording = placing.placed(recording)
    recording = replace(recording, findings=(*recording.findings, *check_recording(recording)))
    recipes.check_goes_with(recording, before, choices=choices)

    def done(n_frames: int) -> None:
        if progress is not None:
            progress(recording.name, n_frames, total)

    with noted(f"while reducing {recording.source or recording.name}", recording.findings), computing(recording.name):
        return recipes.reduce(
            recording,
            placing.rig_for(rig, [recording.events]),
            choices=common_reference.named(recording, [one.track for one in before], rig=rig, choices=choices),
            progress=done,
            before=before[0].opening if before else None,
            maps=maps,
        )


def estimate(
    recordings: Sequence[ReducedRecording], rig: Rig, *, choices: Choices | None = None,
    wheel_calibration: WheelCalibration | None = None, extras: Collection[Extra] = (),
) -> Analysis:  # fmt: skip
    """Timing from all that was reduced; parameters as for `analyse`.

    Raises
    ------
    IrTimingError
        If there is no recording, if they do not share one opening, or if they do not determine the timing.
    """
    if not recordings:
        raise EstimationError("no recording given; name at least one recording file")
    recipes.check_one_opening(recordings)
    choices = choices or Choices()
    ordered = in_order(recordings)
    with doubted(one.findings for one in ordered), computing(", ".join(one.name for one in ordered)):
        tracks, wheel = pooled_slots.pool(ordered, before=wheel_calibration)
        used = placing.rig_for(rig, [one.events for one in ordered])
        found = timing.estimate([replace(one, track=track) for one, track in zip(ordered, tracks, strict=True)], used)
    kind = found.recordings[0]
    analysis = Analysis(
        camera_type=kind.camera_type, readout_mode=kind.readout_mode, rig=rig, choices=choices, recordings=found.recordings,
        geometry=found.geometry, sectors=found.sectors, fits=found.fits, joint=found.found.joint_fit, best=found.found.result,
        wheel=wheel, two_constants=two_constants.of_result(found.found.result, choices=choices),
        maps=pixel_maps.maps(found, used) if "maps" in extras else None,
    )  # fmt: skip
    return _with_extras(analysis, found, {*extras, choices.method})


def _with_extras(analysis: Analysis, found: Timing, asked: Collection[str]) -> Analysis:
    """The same with what was asked for."""
    if analysis.choices.method == "published" or ("published" in asked and procedure.is_for(analysis.recordings[0])):
        averages = (_average(runs, analysis.choices) for runs in procedure.groups(analysis.recordings))
        analysis = replace(analysis, published=procedure.estimate(averages, analysis.recordings, rig=analysis.rig,
                           choices=analysis.choices))  # fmt: skip
    if "profiles" in asked:
        analysis = replace(analysis, profiles=profiles.profiles(found))
    if "prediction" in asked:
        analysis = replace(analysis, prediction=hindsight.predict(analysis))
    if "diagnosis" in asked:
        analysis = replace(analysis, diagnosis=diagnosis.diagnose(found))
    return analysis


def _average(runs: Sequence[ReducedRecording], choices: Choices) -> procedure.Average:
    """Opening fractions of one nominal delay, as the paper averages them."""
    if runs[0].rows is not None:
        return row_averages.average(list(runs))
    return average_runs.average(list(runs), plateau_margin=choices.plateau_margin)

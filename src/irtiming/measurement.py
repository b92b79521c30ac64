"""The story on one screen: recordings in, certificate out. Needs no rig, so it can be repeated years later."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from typing import final

import numpy as np

from irtiming.errors import EstimationError, IrTimingError
from irtiming.estimate import (
    by_blackbody,
    edge_delays,
    published,
    rig_wide,
    rolling_camera,
    rolling_published,
    row_delay_and_lag,
    slopes,
    trigger_delay,
    two_constants,
    wheel_geometry,
)
from irtiming.plan import hindsight
from irtiming.plan.photon_information import KNOWN_WINDOW, SHARED_SHAPE
from irtiming.records.choices import Choices
from irtiming.records.estimate import DelayResult, EdgeDelayFit, PublishedFit
from irtiming.records.joint_fit import JointFit
from irtiming.records.lag_estimate import PublishedLagFit, WheelInImage
from irtiming.records.prediction import AngleErrors, Prediction
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.rolling_result import RollingResult
from irtiming.records.row_timing import RowLikelihood, RowTimingFit, SectorFit, TimeConstantScan
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.records.wheel_geometry import WheelGeometry
from irtiming.reduce import recipes
from irtiming.reduce.published import average_runs, row_averages
from irtiming.reduce.wheel import pooled_slots

Progress = Callable[[str, int, int], None]
"""Told the recording's name, frames done and frames in all."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Analysis:
    """Everything that a report needs: the chosen result, its counterpart, and what led to them."""

    rig: Rig
    choices: Choices
    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    equal_geometry: WheelGeometry
    edge_fits: tuple[EdgeDelayFit, ...]
    published_fits: tuple[PublishedFit, ...]
    joint: JointFit
    best: DelayResult
    as_published: DelayResult
    wheel: WheelCalibration | None = None
    prediction: Prediction | None = None

    @property
    def result(self) -> DelayResult:
        """The result by the method that was chosen."""
        return self.as_published if self.choices.method == "published" else self.best

    @property
    def warnings(self) -> tuple[str, ...]:
        """All warnings, each once, in order."""
        texts = [finding.sentence() for recording in self.recordings for finding in recording.findings]
        without = () if self.published_fits else self.as_published.warnings
        return tuple(dict.fromkeys([*texts, *_doubts(self.wheel), *self.result.warnings, *without]))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingAnalysis:
    """The same for a rolling microbolometer camera."""

    rig: Rig
    choices: Choices
    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    sector: SectorFit
    row_fits: tuple[RowTimingFit, ...]
    scan: TimeConstantScan
    likelihood: RowLikelihood
    published_fits: tuple[PublishedLagFit, ...]
    best: RollingResult
    as_published: RollingResult
    wheel: WheelCalibration | None = None
    two_constants: TwoConstantsResult | None = None
    prediction: Prediction | None = None

    @property
    def result(self) -> RollingResult:
        """The result by the method that was chosen."""
        return self.as_published if self.choices.method == "published" else self.best

    @property
    def warnings(self) -> tuple[str, ...]:
        """All warnings, each once, in order."""
        texts = [finding.sentence() for recording in self.recordings for finding in recording.findings]
        without = () if self.published_fits else self.as_published.warnings
        two = self.two_constants.warnings if self.two_constants else ()
        return tuple(dict.fromkeys([*texts, *_doubts(self.wheel), *self.result.warnings, *without, *two]))


def analyse(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None,
    wheel_calibration: WheelCalibration | None = None,
) -> Analysis | RollingAnalysis:  # fmt: skip
    """Timing of a camera from its recordings, by both methods; the first recording tells the kind of camera.

    Parameters
    ----------
    recordings
        One per run; of any nominal delays and wheel speeds, all of one camera on one rig. Taken one after the other, so a
        generator keeps only one open.
    rig
        As measured by its owner.
    choices
        What a person decided instead of the automatic choice, the method among it.
    progress
        Called as frames are read.
    wheel_calibration
        Slots of the same wheel from other recordings, to be taken together with what these tell.

    Raises
    ------
    IrTimingError
        If a recording cannot be reduced or the data do not determine the timing; a note names the stage.
    """
    stream = iter(recordings)
    first = next(stream, None)
    if first is None:
        raise EstimationError("no recording given; name at least one recording file")
    if first.camera_type == "microbolometer":
        kind: Callable[..., Analysis | RollingAnalysis] = analyse_rolling
    else:
        kind = analyse_snapshot
    return kind(chain([first], stream), rig, choices=choices, progress=progress, wheel_calibration=wheel_calibration)


def analyse_snapshot(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None,
    wheel_calibration: WheelCalibration | None = None,
) -> Analysis:  # fmt: skip
    """Trigger delay of a snapshot photon camera; parameters and errors as for `analyse`."""
    reduced: list[ReducedRecording] = []
    for recording in recordings:
        reduced.append(reduce_snapshot(recording, rig, before=reduced, choices=choices, progress=progress))
    return estimate_snapshot(reduced, rig, choices=choices, wheel_calibration=wheel_calibration)


def analyse_rolling(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None,
    wheel_calibration: WheelCalibration | None = None,
) -> RollingAnalysis:  # fmt: skip
    """Trigger delay, time constant and row delay of a rolling microbolometer camera; parameters and errors as for `analyse`."""
    reduced: list[ReducedRecording] = []
    for recording in recordings:
        reduced.append(reduce_rolling(recording, rig, before=reduced, choices=choices, progress=progress))
    return estimate_rolling(reduced, rig, choices=choices, wheel_calibration=wheel_calibration)


def reduce_snapshot(
    recording: Recording, rig: Rig, *, before: Sequence[ReducedRecording] = (), choices: Choices | None = None,
    progress: Progress | None = None,
) -> ReducedRecording:  # fmt: skip
    """One recording of a photon camera read through, all frames to sums; its opening is that of those ``before``.

    Parameters and errors as for `analyse`; ``before`` are the recordings that go with it.
    """
    choices = choices or Choices()
    _check_fits_with(recording, before, choices)
    opening, told = before[0].opening if before else None, _told(recording, progress)
    with _noted(recording):
        return recipes.reduce(recording, rig, choices=choices, progress=told, before=opening)


def reduce_rolling(
    recording: Recording, rig: Rig, *, before: Sequence[ReducedRecording] = (), choices: Choices | None = None,
    progress: Progress | None = None,
) -> ReducedRecording:  # fmt: skip
    """The same of a rolling microbolometer camera."""
    choices = choices or Choices()
    _check_fits_with(recording, before, choices)
    opening, told = before[0].opening if before else None, _told(recording, progress)
    with _noted(recording):
        return recipes.reduce(recording, rig, choices=choices, progress=told, before=opening)


def estimate_snapshot(
    recordings: Sequence[ReducedRecording], rig: Rig, *, choices: Choices | None = None,
    wheel_calibration: WheelCalibration | None = None,
) -> Analysis:  # fmt: skip
    """Trigger delay from all that was reduced; parameters and errors as for `analyse`."""
    choices = choices or Choices()
    reduced = sorted(recordings, key=lambda r: (r.rotation_speed_hz, r.trigger_delay_time_set_s))
    tracks, wheel = pooled_slots.pool(reduced, before=wheel_calibration)
    reduced = [replace(recording, track=track) for recording, track in zip(reduced, tracks, strict=True)]
    integration_s = _common_integration_time(reduced)
    geometry = wheel_geometry.geometry(reduced, rig, slots="learned", off_axle_mask=True)
    equal = wheel_geometry.geometry(reduced, rig, slots="equal", off_axle_mask=False)
    edge_fits = [edge_delays.estimate(recording, geometry.model) for recording in reduced]
    published_fits: tuple[PublishedFit, ...] = ()
    try:
        published_fits = _as_published(reduced, equal, choices)
        as_published = published.estimate(list(published_fits), equal.model, integration_time_s=integration_s)
    except IrTimingError as error:
        if choices.method == "published":
            raise
        as_published = published.without(str(error))
    timing = trigger_delay.estimate(reduced, edge_fits, geometry=geometry, integration_time_s=integration_s)
    structure = SHARED_SHAPE if integration_s is None else KNOWN_WINDOW
    return Analysis(
        rig=rig,
        choices=choices,
        recordings=tuple(reduced),
        geometry=geometry,
        equal_geometry=equal,
        edge_fits=tuple(edge_fits),
        published_fits=published_fits,
        joint=timing.joint,
        best=timing.result,
        as_published=as_published,
        wheel=wheel,
        prediction=hindsight.photon(
            reduced, edge_fits, model=geometry.model, angles=_angle_errors(edge_fits, geometry), structure=structure
        ),
    )


def estimate_rolling(
    recordings: Sequence[ReducedRecording], rig: Rig, *, choices: Choices | None = None,
    wheel_calibration: WheelCalibration | None = None,
) -> RollingAnalysis:  # fmt: skip
    """Trigger delay, time constant and row delay from all that was reduced; parameters and errors as for `analyse`."""
    choices = choices or Choices()
    reduced = sorted(
        recordings,
        key=lambda r: (r.rotation_speed_hz, r.trigger_delay_time_set_s, r.blackbody_temperature_k or 0.0),
    )
    tracks, wheel = pooled_slots.pool(reduced, before=wheel_calibration)
    best = rolling_camera.estimate([replace(one, track=track) for one, track in zip(reduced, tracks, strict=True)], rig)
    published_fits: tuple[PublishedLagFit, ...] = ()
    try:
        published_fits = _rolling_as_published(best.recordings, rig)
        as_published = rolling_published.estimate(published_fits)
    except IrTimingError as error:
        if choices.method == "published":
            raise
        as_published = rolling_published.without(str(error))
    return RollingAnalysis(
        rig=rig,
        choices=choices,
        recordings=best.recordings,
        geometry=best.geometry,
        sector=best.sector,
        row_fits=best.fits,
        scan=best.scan,
        likelihood=best.likelihood,
        published_fits=published_fits,
        best=best.result,
        as_published=as_published,
        wheel=wheel,
        prediction=hindsight.rolling(
            best.fits, best.sector, model=best.geometry.model, angles=_angle_errors(best.fits, best.geometry)
        ),
        two_constants=_two_constants(best.result, choices),
    )


def _two_constants(result: RollingResult, choices: Choices) -> TwoConstantsResult | None:
    """Constants of substrate and scene, where a person told how warm the substrate is."""
    if choices.substrate_temperature_k is None:
        return None
    if result.effective is None:
        raise EstimationError(
            "the substrate's temperature was given, but not every recording tells that of its blackbody "
            "(entry/instrument/blackbody/temperature); write it, or leave the substrate's out"
        )
    return two_constants.estimate(
        result.effective,
        substrate_temperature_k=choices.substrate_temperature_k,
        wheel_temperature_k=choices.wheel_temperature_k,
    )


def _angle_errors(fits: Sequence[rig_wide.EdgeDelays], geometry: WheelGeometry) -> AngleErrors:
    """Sizes of the angle errors that the estimation takes, for what it should be able to reach with them."""
    return AngleErrors(
        common=tuple((source, u) for source, _, u in geometry.angle_budget),
        edge_rad=rig_wide.edge_uncertainty(fits, geometry),
    )


def _as_published(
    recordings: Sequence[ReducedRecording], geometry: WheelGeometry, choices: Choices
) -> tuple[PublishedFit, ...]:
    """The procedure of the paper for each nominal delay."""
    return tuple(
        slopes.fit(
            average_runs.average(runs, plateau_margin=choices.plateau_margin),
            geometry.model,
            angular_frequency_rad_per_s=float(np.mean([r.equal_track.angular_frequency_rad_per_s for r in runs])),
            limits=choices.slope_limits,
        )
        for runs in _by_delay(recordings)
    )


def _rolling_as_published(recordings: tuple[ReducedRecording, ...], rig: Rig) -> tuple[PublishedLagFit, ...]:
    """The procedure of the paper for each nominal delay; wheel centre and roll are those of the contrast image."""
    equal = wheel_geometry.geometry(recordings, rig, slots="equal", off_axle_mask=False)
    axle = recordings[0].axle
    if axle is None:
        raise EstimationError("the wheel centre is not known; fit the contrast image first")
    wheel = WheelInImage(
        row_px=axle.row_px,
        column_px=axle.column_px,
        roll_rad=equal.camera_roll_rad or 0.0,
        rotation=rig.wheel.rotation,
    )
    return tuple(
        row_delay_and_lag.fit(
            row_averages.average(runs),
            equal.model,
            wheel=wheel,
            initial_row_delay_s=_frame_period_s(runs[0]) / runs[0].opening.mask.shape[0],
        )
        for runs in _by_delay(recordings, blackbody=_blackbodies(recordings))
    )


def _blackbodies(recordings: Sequence[ReducedRecording]) -> list[int]:
    """Which blackbody each recording shows, counted from 0."""
    groups = by_blackbody.groups(
        [one.blackbody_temperature_k for one in recordings],
        is_colder=[one.opening.blackbody_is_colder for one in recordings],
    )
    return [next(g for g, members in enumerate(groups) if k in members) for k in range(len(recordings))]


def _check_fits_with(recording: Recording, before: Sequence[ReducedRecording], choices: Choices) -> None:
    size = recording.frames.shape[1:]
    same = next((other for other in before if recording.sha256 and other.sha256 == recording.sha256), None)
    if same is not None:
        raise EstimationError(
            f"{recording.source} and {same.source} are the same recording (sha256 {recording.sha256[:12]}…): counted twice it "
            "would make the uncertainty too small; name each recording once"
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


def _doubts(wheel: WheelCalibration | None) -> tuple[str, ...]:
    return wheel.warnings if wheel else ()


def _told(recording: Recording, progress: Progress | None) -> Callable[[int], None]:
    total = recording.frames.shape[0]

    def told(done: int) -> None:
        if progress is not None:
            progress(recording.name, done, total)

    return told


@contextmanager
def _noted(recording: Recording) -> Iterator[None]:
    """An error on the way says at which recording."""
    try:
        yield
    except IrTimingError as error:
        said = [finding.sentence() for finding in recording.findings]
        error.add_note("; ".join([f"while reducing {recording.source or recording.name}", *said]))
        raise


def _frame_period_s(rows: ReducedRecording) -> float:
    return float(np.median(np.diff(rows.trigger_ticks))) / rows.track.clock_frequency_hz


def _by_delay(
    reduced: Sequence[ReducedRecording], *, blackbody: Sequence[int] | None = None
) -> list[list[ReducedRecording]]:
    """Runs of the same nominal delay, wheel speed and blackbody together, sorted."""
    groups: dict[tuple[float, float, int], list[ReducedRecording]] = {}
    for recording, shown in zip(reduced, blackbody or [0] * len(reduced), strict=True):
        key = (recording.rotation_speed_hz, round(recording.trigger_delay_time_set_s, 9), shown)
        groups.setdefault(key, []).append(recording)
    return list(groups.values())


def _common_integration_time(reduced: Sequence[ReducedRecording]) -> float | None:
    times = {recording.integration_time_s for recording in reduced}
    if len(times) > 1:
        stated = ", ".join(f"{r.name}: {r.integration_time_s}" for r in reduced)
        raise EstimationError(
            f"the recordings differ in integration time (count_time; {stated} s), which must be one for all; analyse them apart"
        )
    return times.pop()

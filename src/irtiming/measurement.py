"""The story on one screen: recordings in, certificate out. Needs no rig, so it can be repeated years later."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from typing import TypeVar, final

import numpy as np

from irtiming.errors import EstimationError, IrTimingError
from irtiming.estimate import (
    edge_delays,
    published,
    rolling_camera,
    rolling_published,
    row_delay_and_lag,
    slopes,
    trigger_delay,
    wheel_geometry,
)
from irtiming.estimate.wheel_geometry import WheelGeometry
from irtiming.records.estimate import DelayResult, EdgeDelayFit, PublishedFit
from irtiming.records.lag_estimate import PublishedLagFit, WheelInImage
from irtiming.records.recording import Recording
from irtiming.records.reduced import Choices, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.rolling import ReducedRows
from irtiming.records.rolling_result import RollingResult
from irtiming.records.row_timing import RowTimingFit, SectorFit, TimeConstantScan
from irtiming.reduce import average_runs, cooled, microbolometer, pooled_slots, row_averages

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
    best: DelayResult
    as_published: DelayResult

    @property
    def result(self) -> DelayResult:
        """The result by the method that was chosen."""
        return self.as_published if self.choices.method == "published" else self.best

    @property
    def warnings(self) -> tuple[str, ...]:
        """All warnings, each once, in order."""
        texts = [text for recording in self.recordings for text in recording.warnings]
        return tuple(dict.fromkeys([*texts, *self.result.warnings]))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingAnalysis:
    """The same for a rolling microbolometer camera."""

    rig: Rig
    choices: Choices
    recordings: tuple[ReducedRows, ...]
    geometry: WheelGeometry
    sector: SectorFit
    row_fits: tuple[RowTimingFit, ...]
    scan: TimeConstantScan
    published_fits: tuple[PublishedLagFit, ...]
    best: RollingResult
    as_published: RollingResult

    @property
    def result(self) -> RollingResult:
        """The result by the method that was chosen."""
        return self.as_published if self.choices.method == "published" else self.best

    @property
    def warnings(self) -> tuple[str, ...]:
        """All warnings, each once, in order."""
        texts = [text for recording in self.recordings for text in recording.warnings]
        without = () if self.published_fits else self.as_published.warnings
        return tuple(dict.fromkeys([*texts, *self.result.warnings, *without]))


def analyse(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None
) -> Analysis | RollingAnalysis:
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
        return analyse_rolling(chain([first], stream), rig, choices=choices, progress=progress)
    return analyse_snapshot(chain([first], stream), rig, choices=choices, progress=progress)


def analyse_snapshot(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None
) -> Analysis:
    """Trigger delay of a snapshot photon camera; parameters and errors as for `analyse`."""
    choices = choices or Choices()
    reduced: list[ReducedRecording] = []
    for recording in recordings:
        _check_fits_with(recording, reduced, choices)
        before = reduced[0].opening if reduced else None
        with _noted(recording):
            reduced.append(
                cooled.reduce(recording, rig, choices=choices, progress=_told(recording, progress), before=before)
            )
    reduced.sort(key=lambda r: (r.rotation_speed_hz, r.trigger_delay_time_set_s))
    tracks = pooled_slots.pool([recording.track for recording in reduced])
    reduced = [replace(recording, track=track) for recording, track in zip(reduced, tracks, strict=True)]
    integration_s = _common_integration_time(reduced)
    geometry = wheel_geometry.geometry(reduced, rig, slots="learned", off_axle_mask=True)
    equal = wheel_geometry.geometry(reduced, rig, slots="equal", off_axle_mask=False)
    edge_fits = [edge_delays.estimate(recording, geometry.model) for recording in reduced]
    groups = _by_delay(reduced)
    published_fits = [
        slopes.fit(
            average_runs.average(runs, plateau_margin=choices.plateau_margin),
            equal.model,
            angular_frequency_rad_per_s=float(np.mean([r.equal_track.angular_frequency_rad_per_s for r in runs])),
            limits=choices.slope_limits,
        )
        for runs in groups
    ]
    return Analysis(
        rig=rig,
        choices=choices,
        recordings=tuple(reduced),
        geometry=geometry,
        equal_geometry=equal,
        edge_fits=tuple(edge_fits),
        published_fits=tuple(published_fits),
        best=trigger_delay.estimate(edge_fits, geometry, integration_time_s=integration_s),
        as_published=published.estimate(published_fits, equal.model, integration_time_s=integration_s),
    )


def analyse_rolling(
    recordings: Iterable[Recording], rig: Rig, *, choices: Choices | None = None, progress: Progress | None = None
) -> RollingAnalysis:
    """Trigger delay, time constant and row delay of a rolling microbolometer camera; parameters and errors as for `analyse`."""
    choices = choices or Choices()
    reduced: list[ReducedRows] = []
    for recording in recordings:
        _check_fits_with(recording, reduced, choices)
        before = reduced[0].opening if reduced else None
        with _noted(recording):
            reduced.append(
                microbolometer.reduce(
                    recording, rig, choices=choices, progress=_told(recording, progress), before=before
                )
            )
    reduced.sort(key=lambda r: (r.rotation_speed_hz, r.trigger_delay_time_set_s))
    tracks = pooled_slots.pool([one.track for one in reduced])
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
        published_fits=published_fits,
        best=best.result,
        as_published=as_published,
    )


def _rolling_as_published(recordings: tuple[ReducedRows, ...], rig: Rig) -> tuple[PublishedLagFit, ...]:
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
        for runs in _by_delay(recordings)
    )


def _check_fits_with(recording: Recording, before: Sequence[ReducedRecording | ReducedRows], choices: Choices) -> None:
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
        error.add_note("; ".join([f"while reducing {recording.source or recording.name}", *recording.warnings]))
        raise


def _frame_period_s(rows: ReducedRows) -> float:
    return float(np.median(np.diff(rows.trigger_ticks))) / rows.track.clock_frequency_hz


_Reduced = TypeVar("_Reduced", ReducedRecording, ReducedRows)


def _by_delay(reduced: Sequence[_Reduced]) -> list[list[_Reduced]]:
    """Runs of the same nominal delay and wheel speed together, sorted."""
    groups: dict[tuple[float, float], list[_Reduced]] = {}
    for recording in reduced:
        key = (recording.rotation_speed_hz, round(recording.trigger_delay_time_set_s, 9))
        groups.setdefault(key, []).append(recording)
    return list(groups.values())


def _common_integration_time(reduced: list[ReducedRecording]) -> float | None:
    times = {recording.integration_time_s for recording in reduced}
    if len(times) > 1:
        stated = ", ".join(f"{r.name}: {r.integration_time_s}" for r in reduced)
        raise EstimationError(
            f"the recordings differ in integration time (count_time; {stated} s), which must be one for all; analyse them apart"
        )
    return times.pop()

"""The default method for a camera that lags or is read row by row: contrast image and row sums, in turns, until they agree."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import (
    by_blackbody,
    frame_steps,
    image_doubts,
    rivals,
    row_fit,
    row_light,
    sector_fit,
    shape,
    steady_image,
    wheel_geometry,
)
from irtiming.estimate.contrast_look import IMAGE_ORDER
from irtiming.estimate.row_light import RowLight
from irtiming.estimate.sector_search import Slopes
from irtiming.inference.one_thread import one_thread
from irtiming.inference.optimiser import Linearised
from irtiming.physics import wheel_harmonics
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import BESIDE, BLADE, EDGE_DELAYS, Timing, completed, timing_names
from irtiming.records.arrays import ComplexArray
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry, WheelModel

_FEWEST_ROUNDS, _MOST_ROUNDS = 3, 40  # and one that takes the slopes of the image anew
_WHOLE_ROUNDS = 12  # after so many each goes but half of its way, lest it go to and fro
_AGREED = 0.05  # standard uncertainties, by the noise of the rows, between two rounds
_NEAR = 1.0  # of them: an image that is told to less than that may go to and fro
_STAYED = 1.0  # sum of squares that a search gains of each image from where the round before left it
_FIRST_RESPONSE_S = 1e-4  # of pixels that answer at once, nearly: with it a sector is guessed


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FittedRows:
    """Each recording by itself: fits and sectors in the order of ``recordings``, which now know the axle.

    ``geometry`` is the rig's with the axle known, ``bare`` the wheel that the rows were fitted with, ``lights`` their light.
    """

    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    bare: WheelModel
    sectors: tuple[SectorFit, ...]
    lights: tuple[RowLight, ...]
    fits: tuple[RowTimingFit, ...]

    @property
    def likelihoods(self) -> tuple[Callable[[Timing], Linearised], ...]:
        """How well any numbers fit each recording."""
        every = zip(self.recordings, self.lights, self.fits, strict=True)
        return tuple(row_fit.likelihood(one, self.bare, light=light, before=fit) for one, light, fit in every)


def rows(recordings: Sequence[ReducedRecording], rig: Rig) -> FittedRows:
    """Contrast images and row sums of recordings of any camera, each fitted by itself.

    Parameters
    ----------
    recordings
        Of one camera on one rig; one or more, of any set delays and wheel speeds.
    rig
        As measured by its owner.

    Raises
    ------
    EstimationError
        If the recordings do not determine the opening or the timing.
    GeometryError
        If the rig's numbers contradict each other.
    """
    with one_thread():
        return _rows(recordings, rig)


def _rows(recordings: Sequence[ReducedRecording], rig: Rig) -> FittedRows:
    bare = wheel_geometry.geometry(recordings, rig, slots="learned", off_axle_mask=False).model
    views, fits = _in_turns(recordings, bare, rig=rig)
    view_of = [next(view for view in views if k in view.members) for k in range(len(recordings))]
    changes = {id(view): _changes(view, recordings, fits=fits, model=bare, rig=rig) for view in views}
    fits = tuple(
        row_fit.with_shape_effect(fit, one, wheel=bare, light=view.light, changes=changes[id(view)])
        for one, view, fit in zip(recordings, view_of, fits, strict=True)
    )
    seen = tuple(
        replace(
            one,
            axle=shape.view(view.sector, one.opening.summed),
            findings=(
                *one.findings,
                *image_doubts.of_opening(view.sector, rig.mask_opening.opening_angle_rad),
                *image_doubts.of_lens_found(view.sector, rig.camera),
                *_at_once(view, recordings, fits=fits, model=bare, rig=rig),
            ),
        )
        for one, view in zip(recordings, view_of, strict=True)
    )
    return FittedRows(
        recordings=seen,
        geometry=wheel_geometry.geometry(seen, rig, slots="learned", off_axle_mask=False),
        bare=bare,
        sectors=tuple(view.sector for view in view_of),
        lights=tuple(view.light for view in view_of),
        fits=fits,
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _View:
    """What the recordings before one blackbody (``members``) show: sector, seen with ``timing``, and light of the rows."""

    members: list[int]
    sector: SectorFit
    light: RowLight
    timing: Timing


def _in_turns(
    recordings: Sequence[ReducedRecording], model: WheelModel, *, rig: Rig
) -> tuple[list[_View], tuple[RowTimingFit, ...]]:
    """Contrast image and rows by turns, until the rows' numbers stay."""
    kind = camera(recordings[0].camera_type, recordings[0].readout_mode)
    groups = by_blackbody.of_recordings(recordings)
    begins = [_begin([recordings[k] for k in members], model, rig=rig) for members in groups]
    filtered = {
        k: share
        for members, one in zip(groups, begins, strict=True)
        for k, share in zip(members, one.filtered, strict=True)
    }
    turns = _Turns(recordings=recordings, model=model, rig=rig, groups=groups, filtered=filtered)
    views, fits = turns.next([one.timing for one in begins])
    before, is_searched = fits, False
    for n_round in range(1, _MOST_ROUNDS):
        (earlier, before), is_start = (before, fits), n_round + 1 < _FEWEST_ROUNDS
        views, fits = turns.next(turns.timings(fits), views=views, before=before)
        if not is_start and (_stay(views, before, fits) or _are_settled(earlier, before, fits)):
            if is_searched:
                break
            before, fits, is_searched = fits, turns.searched(fits, views=views), True
            if _move(before, fits) <= _NEAR:
                break
    if _move(before, fits) <= _NEAR:
        return turns.next(turns.timings(fits), views=views, before=fits, is_last=True)
    raise EstimationError(
        f"contrast image and row sums did not agree within {_MOST_ROUNDS} rounds "
        f"({kind.response.PARAMETER.replace('_', ' ')} {1e3 * fits[0].timing[kind.response.PARAMETER]:.3f} ms); "
        "the recordings must show the whole opening and nothing else that turns with the wheel"
    )


@dataclass(kw_only=True, eq=False)
class _Turns:
    """Images and rows by turns; ``groups`` holds the numbers of the recordings before each blackbody.

    ``filtered`` is the share of a recursive filter that the first image of each recording is rid of.
    """

    recordings: Sequence[ReducedRecording]
    model: WheelModel
    rig: Rig
    groups: list[list[int]]
    filtered: Mapping[int, float]
    slopes: list[Slopes] = field(init=False)

    def __post_init__(self) -> None:
        """No slopes are known yet."""
        self.slopes = [Slopes() for _ in self.groups]

    def next(
        self, timings: list[Timing], *, views: Sequence[_View] = (), before: tuple[RowTimingFit, ...] = (),
        is_last: bool = False,
    ) -> tuple[list[_View], tuple[RowTimingFit, ...]]:  # fmt: skip
        """Images seen with these numbers, from the views of the turn before on, and then the rows."""
        starts: list[SectorFit | None] = [view.sector for view in views] or [None] * len(self.groups)
        every = zip(self.groups, timings, starts, self.slopes, strict=True)
        found = [
            self._view(members, timing, start, fits=before, slopes=slopes, is_last=is_last)
            for members, timing, start, slopes in every
        ]
        return found, _rows_fitted(self.recordings, self.model, views=found, before=before)

    def searched(self, fits: tuple[RowTimingFit, ...], *, views: list[_View]) -> tuple[RowTimingFit, ...]:
        """The rows once more, each at the lowest of its minima, or at that which goes better with the others of its group."""
        anew = _rows_fitted(self.recordings, self.model, views=views, before=fits, is_searched=True)
        agreed = list(anew)
        for group in self.groups:
            found = rivals.consistent([anew[k] for k in group], frame_memory=self.rig.camera.frame_memory)
            for k, fit in zip(group, found, strict=True):
                agreed[k] = fit
        return tuple(agreed)

    def timings(self, fits: Sequence[RowTimingFit]) -> list[Timing]:
        """Of each group."""
        return [_mean([fits[k].timing for k in members]) for members in self.groups]

    def _view(
        self, members: list[int], timing: Timing, start: SectorFit | None, *, fits: Sequence[RowTimingFit],
        slopes: Slopes, is_last: bool,
    ) -> _View:  # fmt: skip
        seen = (
            _seen(self.recordings, members, fits=fits)
            if fits
            else [frame_steps.unfiltered(self.recordings[k], self.filtered[k]) for k in members]
        )
        if is_last and start is not None:
            sector = sector_fit.settled(seen, self.model, rig=self.rig, timing=timing, start=start, slopes=slopes)
        elif start is not None and start.n_rounds >= _WHOLE_ROUNDS:
            sector = sector_fit.half_way(seen, self.model, rig=self.rig, timing=timing, start=start, slopes=slopes)
        else:
            sector = sector_fit.fit(seen, self.model, rig=self.rig, timing=timing, start=start, slopes=slopes)
        first = self.recordings[members[0]]
        light = row_light.row_light(
            first.row_sums.row_px,
            sector,
            n_harmonics=camera(first.camera_type, first.readout_mode).n_harmonics,
            **(_blades([fits[k] for k in members], self.model) if fits else {}),
        )
        return _View(members=members, sector=sector, light=light, timing=timing)


@final
@dataclass(frozen=True, kw_only=True)
class _Begin:
    """Where the turns of a group begin: timing, and the share of a recursive filter in each of its recordings."""

    timing: Timing
    filtered: tuple[float, ...]


def _begin(members: Sequence[ReducedRecording], model: WheelModel, *, rig: Rig) -> _Begin:
    """What the rows say in a sector that is but guessed; where they say nothing, pixels that answer at once.

    The search for the sector depends on it: where the response turns the phases of unlike pixels by unlike amounts, it may end in
    a sector that there is not. So it may where frames of few turns hold much of those before.
    """
    kind = camera(members[0].camera_type, members[0].readout_mode)
    at_once = dict.fromkeys(timing_names(kind), 0.0) | {kind.response.PARAMETER: _FIRST_RESPONSE_S}
    sector = sector_fit.guess(members, model, rig=rig, timing=at_once)
    try:
        lights = [row_light.row_light(one.row_sums.row_px, sector, n_harmonics=kind.n_harmonics) for one in members]
        fits = [row_fit.fit(one, model, light=light) for one, light in zip(members, lights, strict=True)]
    except EstimationError:
        return _Begin(timing=at_once, filtered=(0.0,) * len(members))
    return _Begin(timing=_mean([fit.timing for fit in fits]), filtered=tuple(row_fit.to_undo(fit) for fit in fits))


def _blades(fits: Sequence[RowTimingFit], model: WheelModel) -> dict[str, float]:
    """What a warmer second blade takes of the contrasts in an image, which is of the second order of the wheel's angle."""
    steps = wheel_harmonics.open_harmonics(model, IMAGE_ORDER)[:, IMAGE_ORDER]
    part = float((steps[2:].sum() / steps.sum()).real)
    mean = _mean([completed(fit.timing) for fit in fits])
    return {"blade": part * mean[BLADE], "beside": part * mean[BESIDE]}


def _rows_fitted(
    recordings: Sequence[ReducedRecording], model: WheelModel, *, views: list[_View], before: tuple[RowTimingFit, ...],
    is_searched: bool = False,
) -> tuple[RowTimingFit, ...]:  # fmt: skip
    """All rows of each recording, from the round before on if there was one, and from a search of their own where they are."""
    light_of = {k: view.light for view in views for k in view.members}
    bent = {k for view in views if before and row_fit.are_bent([before[k] for k in view.members]) for k in view.members}
    starts = tuple(replace(fit, is_bent=k in bent) for k, fit in enumerate(before)) or (None,) * len(recordings)
    fits = tuple(
        row_fit.fit(one, model, light=light_of[k], start=start, is_searched=is_searched)
        for k, (one, start) in enumerate(zip(recordings, starts, strict=True))
    )
    return (
        fits
        if not before
        else tuple(
            replace(
                now,
                start=then.start,
                n_steps=then.n_steps + now.n_steps,
                rival=now.rival if is_searched else then.rival,
            )
            for then, now in zip(before, fits, strict=True)
        )
    )


def _seen(
    recordings: Sequence[ReducedRecording], members: list[int], *, fits: Sequence[RowTimingFit]
) -> list[ReducedRecording]:
    """Recordings before one blackbody, with images that know what the round before found in the rows."""
    return [
        steady_image.by_rows(frame_steps.unfiltered(recordings[k], row_fit.to_undo(fits[k])), fits[k]) for k in members
    ]


def _at_once(
    view: _View, recordings: Sequence[ReducedRecording], *, fits: Sequence[RowTimingFit], model: WheelModel, rig: Rig
) -> tuple[Finding, ...]:
    """What the image says of a camera that is said to read all rows at once."""
    if camera(recordings[0].camera_type, recordings[0].readout_mode).readout.PARAMETERS:
        return ()
    seen = _seen(recordings, view.members, fits=fits)
    return image_doubts.of_rows(sector_fit.fit_row_by_row(seen, model, rig=rig, timing=view.timing, start=view.sector))


def _changes(
    view: _View, recordings: Sequence[ReducedRecording], *, fits: Sequence[RowTimingFit], model: WheelModel, rig: Rig
) -> ComplexArray:
    """Derivatives of the light to the sector's numbers."""
    members = _seen(recordings, view.members, fits=fits)
    varied = sector_fit.variations(members, model, rig=rig, timing=view.timing, found=view.sector)
    return row_light.changes(view.light, varied)


def _mean(timings: list[dict[str, float]]) -> Timing:
    """Mean of each number that some of the fits hold; where others do not hold it, it is as `completed` has it."""
    whole = [completed(timing) for timing in timings]
    names = dict.fromkeys(name for timing in timings for name in timing)
    return {name: float(np.mean([timing[name] for timing in whole])) for name in names}


def _stay(views: list[_View], before: tuple[RowTimingFit, ...], now: tuple[RowTimingFit, ...]) -> bool:
    """Whether images are where they were, within what they can tell at all, and rows near.

    By Cauchy and Schwarz, an image that moved by a sum of squares d moves a number of the rows by the root of d of what the
    image's uncertainty leaves of it, at most.
    """
    return all(view.sector.gained <= _STAYED for view in views) and _move(before, now) <= _NEAR


def _are_settled(
    earlier: tuple[RowTimingFit, ...], before: tuple[RowTimingFit, ...], now: tuple[RowTimingFit, ...]
) -> bool:
    """Whether the rows' numbers stay for two rounds, for one may be chance, or go to and fro between two places that are near."""
    move = _move(before, now)
    if move <= _AGREED:
        return _move(earlier, before) <= _AGREED
    return move <= _NEAR and _move(earlier, now) <= _AGREED


def _move(before: tuple[RowTimingFit, ...], now: tuple[RowTimingFit, ...]) -> float:
    """How far what a response and a readout are made of has gone since the round before, at most, in standard uncertainties."""
    moves = [
        abs(a.timing.get(name, np.inf) - b.timing[name]) / b.estimate.u(name)
        for a, b in zip(before, now, strict=True)
        for name in b.estimate.names
        if name not in EDGE_DELAYS
    ]
    return max(moves, default=0.0)

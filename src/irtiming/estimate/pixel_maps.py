"""Maps of a camera's timing: pixels of all recordings together, beside the fit, which all rows share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import map_findings, map_patterns, pixel_fit, steady_image, wheel_geometry
from irtiming.estimate.map_patterns import MappedDelays
from irtiming.estimate.pixel_fit import PixelsOfRecording, Reference
from irtiming.estimate.timing import Timing
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import BLADE
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate
from irtiming.records.frame_events import DELAYS
from irtiming.records.pixel_maps import LineMeans, PixelMaps
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import RowTimingFit, SectorFit

_MIDDLE, _LAG, _ROW_DELAY = "exposure_midpoint_delay", "time_constant", "row_delay"
_FEWEST_PIXELS = 30


def maps(found: Timing, rig: Rig) -> PixelMaps:
    """Timing of every pixel of the opening.

    Parameters
    ----------
    found
        What the recordings say together; they were reduced with what maps are made of.
    rig
        As measured by its owner.

    Raises
    ------
    EstimationError
        If the image shows no opening, or a recording's frames leave much of the turn out.
    """
    wheel = wheel_geometry.geometry(found.recordings, rig, slots="learned", off_axle_mask=False).model
    parts: list[PixelsOfRecording] = []
    references: list[Reference] = []
    first: _First | None = None
    for recording, fit, sector in zip(found.recordings, found.fits, found.views, strict=True):
        if sector is None:
            continue
        reference = _reference(recording, fit, found.found.joint_fit.parameters)
        part = pixel_fit.fit(steady_image.with_waves(recording, fit), sector, wheel=wheel, reference=reference)
        if part is not None:
            first = first or _First(recording=recording, sector=sector, part=part)
            parts.append(part)
            references.append(reference)
    if first is None or parts[0].row_px.size < _FEWEST_PIXELS:
        raise EstimationError(
            "no map of the pixels: the images show no opening of the mask that a fit could be laid through, or fewer than "
            f"{_FEWEST_PIXELS} pixels of it; ask for no maps, or mend what the other findings tell"
        )
    together = _together(
        parts, references, fitted=found.found.result.estimate, shape=first.recording.opening.mask.shape
    )
    return _maps(together, parts, first=first, estimate=found.found.result.estimate)


def _reference(recording: ReducedRecording, fit: EdgeDelayFit | RowTimingFit, joint: Estimate) -> Reference:
    """What a recording's own fit says of all pixels."""
    kind = camera(recording.camera_type, recording.readout_mode)
    if isinstance(fit, RowTimingFit):
        return Reference(
            read_s=fit.edge_delay_s,
            row_delay_s=fit.row_delay_s,
            response_s=fit.timing[kind.response.PARAMETER],
            memory=fit.timing.get(kind.memory.PARAMETER, 0.0),
            blade=fit.timing.get(BLADE, 0.0),
        )
    window_s = recording.integration_time_s
    if window_s is None:
        window_s = joint.value(kind.response.PARAMETER) if kind.response.PARAMETER in joint else 0.0
    own, memory = fit.estimate, kind.memory.PARAMETER
    return Reference(
        read_s=np.array([own.value(name) for name in EDGE_DELAYS]),
        row_delay_s=0.0,
        response_s=window_s,
        memory=own.value(memory) if memory in own else 0.0,
        blade=fit.blades,
    )


Places: TypeAlias = tuple[Ticks, ...]
"""Rows and columns of pixels."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _First:
    """The first recording, whose contrast and noise are shown, and images of its region of interest, nan elsewhere."""

    recording: ReducedRecording
    sector: SectorFit
    part: PixelsOfRecording

    @property
    def box(self) -> tuple[slice, slice]:
        """Region of interest in the image."""
        return slice(*self.sector.roi[:2]), slice(*self.sector.roi[2:])

    @property
    def noise_dn(self) -> Array:
        """Of the whole image."""
        return self._whole((self.part.row_px, self.part.column_px), self.part.noise_dn)

    def image(self, values: Array) -> Array:
        """Of the recording's pixels, values of shape (p,)."""
        return self.at((self.part.row_px, self.part.column_px), values)

    def at(self, places: Places, values: Array) -> Array:
        """Of pixels anywhere, values of shape (p,)."""
        return np.asarray(self._whole(places, values)[self.box])

    def _whole(self, places: Places, values: Array) -> Array:
        made = np.full(self.recording.opening.mask.shape, np.nan)
        made[places] = values
        return made


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Together:
    """Pixels as all recordings tell them, on the whole image, shape (row, column), nan where there is none.

    ``covariance`` (row, column, k, k) is of delay and time constant; ``expected_s`` what the fit says. Pixels are ``is_sound``
    that are so in all recordings.
    """

    delay_s: Array
    lag_s: Array | None
    covariance: Array
    expected_s: Array
    is_sound: Mask
    fitted_row_delay_s: float
    u_common_s: float
    u_common_lag_s: float | None


def _together(
    parts: Sequence[PixelsOfRecording], references: Sequence[Reference], *, fitted: Estimate, shape: tuple[int, ...]
) -> _Together:
    """Each recording's deviations from its own fit, weighted by what it tells, on top of the result of all."""
    n = parts[0].covariance.shape[1] - 1
    information, score, sound = np.zeros((*shape, n, n)), np.zeros((*shape, n)), np.ones(shape, bool)
    middle = float(np.average(parts[0].row_px, weights=1 / parts[0].covariance[:, 1, 1]))
    for part, reference in zip(parts, references, strict=True):
        less = [part.delay_s - middle * reference.row_delay_s, part.response_s - reference.response_s][:n]
        own = np.linalg.inv(part.covariance[:, 1:, 1:])
        at = part.row_px, part.column_px
        information[at] += own
        sound[at] &= part.is_sound
        score[at] += np.einsum("pkl,lp->pk", own, np.array(less))
    is_determined = information[..., 0, 0] > 0
    covariance = np.full(information.shape, np.nan)
    covariance[is_determined] = np.linalg.inv(information[is_determined])
    values = np.full(score.shape, np.nan)
    values[is_determined] = np.einsum("pkl,pl->pk", covariance[is_determined], score[is_determined])
    level, u_level, row_delay = _level(fitted, references, middle=middle)
    rows = np.broadcast_to(np.arange(shape[0])[:, None], shape)
    constant, u_constant = _constant(fitted, references)
    return _Together(
        delay_s=values[..., 0] + level,
        lag_s=values[..., 1] + constant if n > 1 else None,
        covariance=covariance,
        expected_s=np.where(is_determined, level + (rows - middle) * row_delay, np.nan),
        is_sound=sound & is_determined,
        fitted_row_delay_s=row_delay,
        u_common_s=u_level,
        u_common_lag_s=u_constant if n > 1 else None,
    )


def _level(fitted: Estimate, references: Sequence[Reference], *, middle: float) -> tuple[float, float, float]:
    """Delay of the middle row as the result states it, its standard uncertainty, and the row delay, s."""
    delay = next((name for name in (_MIDDLE, "trigger_delay") if name in fitted), None)
    row_delay = fitted.value(_ROW_DELAY) if _ROW_DELAY in fitted else references[0].row_delay_s
    if delay is None:  # the result holds bounds alone
        return float(references[0].read_s.mean()) + middle * row_delay, np.inf, row_delay
    if _ROW_DELAY not in fitted:
        return fitted.value(delay) + middle * row_delay, fitted.u(delay), row_delay
    both, weights = fitted.pick(delay, _ROW_DELAY), np.array([1.0, middle])
    return float(weights @ both.values), float(np.sqrt(weights @ both.covariance @ weights)), row_delay


def _constant(fitted: Estimate, references: Sequence[Reference]) -> tuple[float, float]:
    """Time constant as the result states it, and its standard uncertainty, s."""
    if _LAG in fitted:
        return fitted.value(_LAG), fitted.u(_LAG)
    return references[0].response_s, np.inf


def _maps(found: _Together, parts: Sequence[PixelsOfRecording], *, first: _First, estimate: Estimate) -> PixelMaps:
    """All that there is, in images of the region of interest."""
    is_determined, sound, box = np.isfinite(found.delay_s), np.nonzero(found.is_sound), first.box
    u_s, lag = np.sqrt(found.covariance[..., 0, 0]), _Lag.of(found)
    every = _delays(found, first, at=np.nonzero(is_determined))
    delays = every.some(found.is_sound[is_determined])
    clock = map_patterns.row_clock(delays)
    strays = map_findings.deviating(
        delays, clock, lag_pulls=None if lag is None else lag.pulls[sound], noise_dn=first.noise_dn[sound]
    )
    delays = map_patterns.near(delays, clock)
    at, clock = (delays.row_px, delays.column_px), map_patterns.row_clock(delays)
    u_shape_s = map_patterns.u_shape_s(delays, every)
    means = [_line_means(line, delays, expected_s=found.expected_s[at], lag=lag) for line in at]
    part, recording = first.part, first.recording
    made = PixelMaps(
        roi=first.sector.roi,
        delay_name=_MIDDLE if _MIDDLE in estimate else DELAYS[recording.events.kind if recording.events else "trigger"],
        delay_s=found.delay_s[box], u_delay_s=u_s[box], expected_delay_s=found.expected_s[box],
        contrast_dn=first.image(part.contrast_dn), u_contrast_dn=first.image(np.sqrt(part.covariance[:, 0, 0])),
        time_constant_s=None if lag is None else lag.value_s[box], u_time_constant_s=None if lag is None else lag.u_s[box],
        correlation=None if lag is None else (found.covariance[..., 0, 1] / (u_s * lag.u_s))[box],
        noise_dn=first.image(part.noise_dn), noise_degrees_of_freedom=part.n_quiet,
        u_shape_s=first.at(np.nonzero(is_determined), u_shape_s), u_common_delay_s=found.u_common_s,
        u_common_time_constant_s=found.u_common_lag_s,
        is_border=first.image(part.is_border.astype(float)) == 1,
        is_dead=(recording.opening.bad & recording.opening.mask)[box],
        is_deviating=(is_determined & ~found.is_sound)[box] | (first.at(sound, strays.astype(float)) == 1),
        rows=means[0], columns=means[1],
        row_delay_s=clock.row_delay_s, u_row_delay_s=clock.u_row_delay_s, fitted_row_delay_s=found.fitted_row_delay_s,
        unseen_row_px=np.flatnonzero(~is_determined.any(axis=1)),
        patterns=map_patterns.patterns(delays, clock),
        reduced_chi_square=_reduced_chi_square(parts), n_recordings=len(parts),
    )  # fmt: skip
    return map_findings.with_findings(made, delays, clock=clock)


def _delays(found: _Together, first: _First, *, at: Places) -> MappedDelays:
    """Of the pixels at these places, with what the opening's shape does to them."""
    return MappedDelays(
        row_px=at[0],
        column_px=at[1],
        delay_s=found.delay_s[at],
        u_s=np.sqrt(found.covariance[..., 0, 0][at]),
        shape_s=map_patterns.shape_effect_s(
            first.sector,
            row_px=at[0],
            column_px=at[1],
            omega=first.recording.track.angular_frequency_rad_per_s,
        ),
        image_rows=found.delay_s.shape[0],
        image_columns=found.delay_s.shape[1],
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Lag:
    """Time constants and their standard uncertainties, images."""

    value_s: Array
    u_s: Array

    @classmethod
    def of(cls, found: _Together) -> "_Lag | None":
        """None where the camera does not lag."""
        if found.lag_s is None:
            return None
        return cls(value_s=found.lag_s, u_s=np.sqrt(found.covariance[..., 1, 1]))

    @property
    def pulls(self) -> Array:
        """From the median, in standard uncertainties."""
        return np.asarray((self.value_s - np.nanmedian(self.value_s)) / self.u_s)


def _reduced_chi_square(parts: Sequence[PixelsOfRecording]) -> float:
    """Of sound pixels about what their numbers say; a noise by few degrees of freedom is too small in the mean."""
    squares = sum(float(np.sum(part.misfit[part.is_sound])) * (part.n_quiet - 2) / part.n_quiet for part in parts)
    freedom = sum((part.n_harmonics - part.covariance.shape[1]) * int(part.is_sound.sum()) for part in parts)
    return squares / freedom


def _line_means(line: Ticks, delays: MappedDelays, *, expected_s: Array, lag: _Lag | None) -> LineMeans:
    """Weighted means over the pixels of each row, or of each column."""
    lines, place = np.unique(line, return_inverse=True)

    def mean(values: Array, u: Array) -> list[Array]:
        weight = np.bincount(place, 1 / u**2)
        return [np.bincount(place, values / u**2) / weight, 1 / np.sqrt(weight)]

    delay, u_delay = mean(delays.delay_s, delays.u_s)
    at = delays.row_px, delays.column_px
    constants = [None, None] if lag is None else mean(lag.value_s[at], lag.u_s[at])
    return LineMeans(
        line_px=lines,
        n_pixels=np.bincount(place),
        delay_s=delay,
        u_delay_s=u_delay,
        deviation_s=mean(delays.delay_s - expected_s, delays.u_s)[0],
        time_constant_s=constants[0],
        u_time_constant_s=constants[1],
    )

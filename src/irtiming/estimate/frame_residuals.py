"""Residuals of a fit frame by frame, in the order of the triggers, beside the model that left them: what a diagnosis looks at."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.physics import robust
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Ticks
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.row_timing import RowTimingFit

_BANDS = 12
_GRID = 1024


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameResiduals:
    """Of one recording, in bands of rows; a snapshot photon camera's pixel sums are one band.

    Shapes: angle_rad, time (from -1 to 1) and number (of the trigger) (n,), fraction and residual (n, n_band), opening fractions;
    row (n_band,) from -1 to 1, noise (n_band,) of a residual, from neighbours along the wheel angle. ``middle_px`` and
    ``half_px`` are rows of the image: where row is 0, and how far it is from there to 1.
    """

    name: str
    omega_rad_per_s: float
    angle_rad: Array
    time: Array
    number: Ticks
    fraction: Array
    residual: Array
    row: Array
    noise: Array
    middle_px: float = 0.0
    half_px: float = 1.0

    def filtered(self, factor: ComplexArray) -> Array:
        """The model with each harmonic of the wheel times a factor, shape (n, n_band).

        Parameters
        ----------
        factor
            Shape (513,), for the harmonics from 0.
        """
        grid = np.asarray(np.arange(_GRID) * (TURN / _GRID), dtype=np.float64)
        spectrum = np.fft.rfft(self._on(grid), axis=0)
        found = np.fft.irfft(spectrum * factor[:, None], _GRID, axis=0)
        columns = [np.interp(self.angle_rad, grid, band, period=TURN) for band in found.T]
        return np.stack(columns, axis=1)

    def _on(self, grid: Array) -> Array:
        order = np.argsort(self.angle_rad)
        return np.stack(
            [np.interp(grid, self.angle_rad[order], band[order], period=TURN) for band in self.fraction.T], axis=1
        )

    @property
    def slope(self) -> Array:
        """Change of the model per second of later exposure, shape (n, n_band)."""
        return self.filtered(1j * harmonics()) * self.omega_rad_per_s

    @property
    def open_at_rad(self) -> float:
        """Wheel angle in the middle of an open plateau; the other is half a turn away."""
        second = np.mean(self.fraction.mean(axis=1) * np.exp(2j * self.angle_rad))
        return float(np.angle(second)) / 2


def harmonics() -> Array:
    """Numbers of the harmonics that `FrameResiduals.filtered` has factors for, shape (513,)."""
    return np.arange(_GRID // 2 + 1, dtype=np.float64)


def of_fit(reduced: ReducedRecording, fit: EdgeDelayFit | RowTimingFit) -> FrameResiduals:
    """Residuals of one recording.

    Parameters
    ----------
    reduced
        The recording.
    fit
        Of it.
    """
    if isinstance(fit, RowTimingFit):
        fraction, residual, row = _banded(fit)
        ticks, (middle, half) = reduced.trigger_ticks[fit.kept], _middle_and_half(fit)
        made = _made(fit, fit.wheel_angle_rad, ticks, fraction=fraction, residual=residual, row=row)
        return replace(made, middle_px=middle, half_px=half)
    ticks = reduced.trigger_ticks[fit.kept]
    middle_s = float(np.mean(fit.edge_delay_s))
    angle = np.mod(
        wheel_angle_rad(middle_s, reduced.track, at_ticks=ticks, set_s=reduced.trigger_delay_time_set_s), TURN
    )
    order = np.argsort(angle)
    residual, fraction = np.empty((2, ticks.size, 1))
    residual[order, 0], fraction[order, 0] = fit.residual, fit.fraction - fit.residual
    return _made(fit, angle, ticks, fraction=fraction, residual=residual, row=np.zeros(1))


def with_residual(frames: FrameResiduals, residual: Array) -> FrameResiduals:
    """The same with other residuals, shape (n, n_band), and their noise."""
    return replace(frames, residual=residual, noise=_noise(frames.angle_rad, residual))


def _noise(angle: Array, residual: Array) -> Array:
    """Standard deviation of a residual from its neighbours along the wheel angle, shape (n_band,)."""
    beside = np.diff(residual[np.argsort(angle)], axis=0)
    return np.asarray(np.maximum(robust.OF_NORMAL * np.median(np.abs(beside), axis=0) / np.sqrt(2), 1e-12))


def _made(
    fit: EdgeDelayFit | RowTimingFit, angle: Array, ticks: Ticks, *, fraction: Array, residual: Array, row: Array
) -> FrameResiduals:
    span = max(1, int(np.ptp(ticks)))
    period = float(np.median(np.diff(ticks)))
    return FrameResiduals(
        name=fit.name,
        omega_rad_per_s=fit.angular_frequency_rad_per_s,
        angle_rad=angle,
        time=2 * (ticks - ticks[0]) / span - 1,
        number=np.rint((ticks - ticks[0]) / period).astype(np.int64),
        fraction=fraction,
        residual=residual,
        row=row,
        noise=_noise(angle, residual),
    )


def _banded(fit: RowTimingFit) -> tuple[Array, Array, Array]:
    """Model, residuals, (n, n_band), and place of bands of rows, each row weighted by its noise."""
    rows, (middle, half) = fit.row_px.astype(np.float64), _middle_and_half(fit)
    made = []
    for part in np.array_split(np.arange(rows.size), min(_BANDS, rows.size)):
        weight = fit.noise[part] ** -2.0
        weight = weight / weight.sum()
        made.append(
            (fit.model[:, part] @ weight, fit.residual[:, part] @ weight, (rows[part] @ weight - middle) / half)
        )
    fraction, residual, place = zip(*made, strict=True)
    return np.stack(fraction, axis=1), np.stack(residual, axis=1), np.array(place)


def _middle_and_half(fit: RowTimingFit) -> tuple[float, float]:
    """Middle of the fitted rows, and how far it is from there to the last."""
    return float(fit.row_px.max() + fit.row_px.min()) / 2, max(float(np.ptp(fit.row_px)) / 2, 1.0)

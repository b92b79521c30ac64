"""Contrast, delay and, of a camera that lags, time constant of every pixel from the harmonics of its signal: one recording."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import frame_steps
from irtiming.estimate.pixel_harmonics import SumsWithWaves, sums_with_waves
from irtiming.estimate.pixel_light import LightOfPixels, light_of_pixels
from irtiming.physics import wheel_harmonics
from irtiming.physics.camera import camera
from irtiming.physics.light import pixel
from irtiming.physics.light.pixel import PixelLight, PixelNumbers
from irtiming.physics.response import first_order_lag
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.pixel_waves import PixelWaves
from irtiming.records.reduced import ReducedRecording
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

_HIGHEST = 1024  # order of which the leak knows
_STEPS, _LEAKS = 4, 2
_LEAST_SHARE = 0.5  # of a pixel in the light: with less of it, there is little but border
_UNIT_S = 1e-6
_UNLIKE, _NOISY, _MISFIT = (
    3.0,
    3.0,
    5.0,
)  # times the median: contrasts, noises and sums of squares beyond are no pixels' own


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """What the fit of a recording says of all pixels: where it begins, and what they share.

    ``read_s`` (4,) is when row 0 is read, or the middle of its window, by each of the wheel's edges, ``response_s`` time constant
    or window, ``memory`` the share of the frame before in each frame, ``blade`` by how much the second blade is warmer, of the
    contrast.
    """

    read_s: Array
    row_delay_s: float
    response_s: float
    memory: float
    blade: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelsOfRecording:
    """Numbers of the pixels at ``row_px``, ``column_px``, shapes (p,), as one recording tells them.

    ``delay_s`` is counted from the mean of the edges' delays that the fit of the recording found, ``response_s`` is the parameter
    itself; ``covariance`` (p, k, k) of contrast, delay and, where it is fitted, that parameter, DN and s, from ``noise_dn``.
    ``contrast_dn`` is what the pixel shows of the light; ``misfit`` (p,) the sum of squares of what is left of the harmonics,
    over the noise. Pixels are not ``is_sound`` (p,) that hardly follow the wheel, or otherwise than its harmonics say, or blink.
    """

    row_px: Ticks
    column_px: Ticks
    is_border: Mask
    contrast_dn: Array
    delay_s: Array
    response_s: Array
    covariance: Array
    noise_dn: Array
    misfit: Array
    is_sound: Mask
    n_harmonics: int
    n_quiet: int


def fit(
    recording: ReducedRecording, sector: SectorFit, *, wheel: WheelModel, reference: Reference
) -> PixelsOfRecording | None:
    """Numbers of the pixels that are more in the light than not; None where the reduction gathered no waves.

    Parameters
    ----------
    recording
        One, its waves rid of levels that sway.
    sector
        The opening in its image.
    wheel
        The wheel, with the opening's centre at the mask's bisector.
    reference
        Of the recording.

    Raises
    ------
    EstimationError
        If its frames leave much of the turn out.
    """
    waves = recording.waves
    if waves is None:
        return None
    light = light_of_pixels(sector, waves.signal_orders, row_px=waves.row_px, column_px=waves.column_px)
    bad = recording.opening.bad[waves.row_px, waves.column_px]
    at = np.flatnonzero((light.share > _LEAST_SHARE) & ~bad)
    some = LightOfPixels(
        harmonics=light.harmonics[:, at], share=light.share[at], angle_rad=light.angle_rad[at],
        reach_rad=light.reach_rad[at], is_inside=light.is_inside[at],
    )  # fmt: skip
    return _fit(recording, wheel, waves=_some(waves, at), light=some, reference=reference)


def _some(waves: PixelWaves, at: Ticks) -> PixelWaves:
    return replace(waves, row_px=waves.row_px[at], column_px=waves.column_px[at], sums_dn=waves.sums_dn[:, at])


def _fit(
    recording: ReducedRecording, wheel: WheelModel, *, waves: PixelWaves, light: LightOfPixels, reference: Reference
) -> PixelsOfRecording:
    kind = camera(recording.camera_type, recording.readout_mode)
    omega = recording.track.angular_frequency_rad_per_s
    shared = _shared(recording, wheel, reference)
    response = kind.response.transfer(omega, reference.response_s, n_harmonics=_HIGHEST)
    angle = wheel_angle_rad(
        0.0, recording.track, at_ticks=recording.trigger_ticks, set_s=recording.trigger_delay_time_set_s
    )
    in_sums = recording.contrast_image.in_sums
    gain = np.ones(angle.size) if in_sums is None else in_sums.relative_gain
    sums = sums_with_waves(waves, angle, relative_gain=gain, point=shared * response, name=recording.name)
    pixels = PixelLight(
        orders=waves.signal_orders, light=light.harmonics, wheel=shared[waves.signal_orders],
        angular_frequency_rad_per_s=omega, response=kind.response,
    )  # fmt: skip
    n_free = 3 if kind.response.PARAMETER == first_order_lag.PARAMETER else 2
    found, noise, slopes, left = _iterated(sums, pixels, light, reference=reference, n_free=n_free)
    normal = np.einsum("kjp,ljp->pkl", slopes, slopes)
    unit = np.array([1.0, _UNIT_S, _UNIT_S])[:n_free]
    covariance = np.linalg.inv(normal * np.outer(unit, unit)) * np.outer(unit, unit) * noise[:, None, None] ** 2
    covariance[:, 0, :] *= light.share[:, None]
    covariance[:, :, 0] *= light.share[:, None]
    misfit = np.sum((left / noise) ** 2, axis=0)
    return PixelsOfRecording(
        row_px=waves.row_px, column_px=waves.column_px, is_border=~light.is_inside,
        contrast_dn=found.contrast_dn * light.share, delay_s=found.delay_s, response_s=found.response_s,
        covariance=covariance, noise_dn=noise, misfit=misfit, is_sound=_sound(found, noise, misfit),
        n_harmonics=2 * waves.signal_orders.size, n_quiet=2 * waves.quiet_orders.size,
    )  # fmt: skip


def _sound(found: PixelNumbers, noise_dn: Array, misfit: Array) -> Mask:
    """Pixels that follow the wheel as the others do, shape (p,)."""
    relative = found.contrast_dn / np.median(found.contrast_dn)
    return np.asarray(
        (relative > 1 / _UNLIKE) & (relative < _UNLIKE) & (noise_dn < _NOISY * np.median(noise_dn))
        & (misfit < _MISFIT * np.median(misfit)) & np.isfinite(found.delay_s)
    )  # fmt: skip


def _shared(recording: ReducedRecording, wheel: WheelModel, reference: Reference) -> ComplexArray:
    """Harmonics of a point at the bisector before the response, its delay counted from the mean of the edges', (M + 1,)."""
    kind, omega = camera(recording.camera_type, recording.readout_mode), recording.track.angular_frequency_rad_per_s
    edges = wheel_harmonics.open_harmonics(wheel, _HIGHEST) * wheel_harmonics.later(
        omega * (reference.read_s - reference.read_s.mean()), n_harmonics=_HIGHEST
    )
    modelled = edges.sum(axis=0) - reference.blade * edges[2:].sum(axis=0)
    step = frame_steps.step_rad(recording)
    mean = wheel_harmonics.later(np.array(omega * reference.read_s.mean()), n_harmonics=_HIGHEST)
    return np.asarray(modelled * mean * kind.memory.transfer(step, reference.memory, n_harmonics=_HIGHEST))


def _iterated(
    sums: SumsWithWaves, pixels: PixelLight, light: LightOfPixels, *, reference: Reference, n_free: int
) -> tuple[PixelNumbers, Array, Array, Array]:
    """Numbers, noise, derivatives (k, 2 s, p) and what is left (2 s, p), both white but for the noise's size."""
    found = _first(sums, pixels, response_s=reference.response_s)
    for _ in range(_LEAKS):
        turned = light.angle_rad - pixels.angular_frequency_rad_per_s * found.delay_s
        leak = found.contrast_dn * light.share * sums.leak.of(turned, light.reach_rad)
        target = sums.root @ sums.harmonics(leak)
        for _ in range(_STEPS):
            modelled, slopes = pixel.linearised(pixels, found)
            left = target - sums.root @ _packed(modelled)
            jacobian = np.matmul(sums.root, _packed(slopes[:n_free]))
            found = _stepped(found, jacobian, left)
    modelled, slopes = pixel.linearised(pixels, found)
    jacobian = np.matmul(sums.root, _packed(slopes[:n_free]))
    return found, sums.noise(leak), jacobian, target - sums.root @ _packed(modelled)


def _first(sums: SumsWithWaves, pixels: PixelLight, *, response_s: float) -> PixelNumbers:
    """Contrast and delay by the lowest order alone."""
    harmonics = sums.harmonics(np.zeros((len(sums.signal), 1)))
    n, omega = pixels.orders.size, pixels.angular_frequency_rad_per_s
    n_pixels = harmonics.shape[1]
    start = PixelNumbers(
        contrast_dn=np.ones(n_pixels), delay_s=np.zeros(n_pixels), response_s=np.full(n_pixels, response_s)
    )
    ratio = (harmonics[0] - 1j * harmonics[n]) / pixel.linearised(pixels, start)[0][0]
    sign = np.sign(np.sum(ratio.real))
    return PixelNumbers(
        contrast_dn=sign * np.abs(ratio),
        delay_s=np.angle(sign * ratio) / (omega * pixels.orders[0]),
        response_s=start.response_s,
    )


def _stepped(at: PixelNumbers, jacobian: Array, left: Array) -> PixelNumbers:
    """One Gauss-Newton step in all pixels at once; ``jacobian`` (k, 2 s, p), ``left`` (2 s, p)."""
    unit = np.array([1.0, _UNIT_S, _UNIT_S])[: len(jacobian)]
    scaled = jacobian * unit[:, None, None]
    normal = np.einsum("kjp,ljp->pkl", scaled, scaled)
    step = np.linalg.solve(normal, np.einsum("kjp,jp->pk", scaled, left)[:, :, None])[:, :, 0] * unit
    response = at.response_s if len(jacobian) < 3 else np.maximum(at.response_s + step[:, 2], at.response_s / 2)
    return PixelNumbers(contrast_dn=at.contrast_dn + step[:, 0], delay_s=at.delay_s + step[:, 1], response_s=response)


def _packed(harmonics: ComplexArray) -> Array:
    """Real parts, then minus the imaginary ones; shape (..., 2 s, p)."""
    return np.concatenate([harmonics.real, -harmonics.imag], axis=-2)

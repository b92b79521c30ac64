r"""Separate time constants of the exchange with substrate and scene, from recordings at several blackbody temperatures.

With the share s of the scene in the exchange of heat at the reference temperature, and both exchanges together,
:math:`1/\tau_0 = 1/\tau_{substrate} + 1/\tau_{scene}`, the effective constant at blackbody temperature k is

.. math:: \tau_k = \tau_0\,h_k(s), \qquad h_k = \frac{1 + 1.4\,\varepsilon_k^2}{1 - s + s\,L'(T_k) / L'(T_0)}

T_k is the middle of the two steady temperatures of a pixel, before the blackbody and before the wheel; it depends on s alone.
So tau_0 is solved for and s searched. The term with epsilon (`physics.response.two_constants.bending`) is there because a single
exponential, fitted to an answer that is none, is slower than the middle: 1.4 was found by fits to stepped solutions, and
holds to 0.2 for an opening of 75 degrees and pixels that spend as long before the wheel as before the blackbody. What speeds the
end of a warming slows the end of a cooling: to first order that moves the edges' delays apart and leaves tau alone. Neglected:
pixels of the mask plate, which keep the wheel's time constant; with 0.3 K between plate and wheel that is 2 us of tau at s = 1/3.

Errors that the recordings share stand in the covariance and cancel in what tells s: differences of the tau_k. At s = 0 their
derivative is zero, for it grows as s squared; so bounds come from the deviance itself.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from scipy import optimize, special

from irtiming.errors import EstimationError
from irtiming.physics.radiance import in_band_radiance
from irtiming.physics.response.two_constants import (
    REFERENCE_TEMPERATURE_K,
    TwoConstants,
    bending,
    effective_time_constant,
    steady_temperature,
)
from irtiming.records.arrays import Array
from irtiming.records.choices import Choices
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.result import Bound, EffectiveTimeConstants, Result
from irtiming.records.two_constants import NAMES, PixelSurroundings, TwoConstantsResult
from irtiming.units import counted

_SHARES = np.linspace(0.0, 0.98, 50)
_UNDETERMINED = 0.25  # relative standard uncertainty of the share from which the constants are no numbers any more
_BENT = 1.4
_TWO_U = 4.0  # deviance
_SIGNIFICANCE = 0.003
_ASSUMED_WHEEL_K, _PLAUSIBLE_WHEEL_K = 296.15, (273.15, 323.15)
_CURVE_POINTS, _CURVE_BEYOND_K = 61, 8.0
_NUDGE, _NUDGE_K = 1e-4, 1.0
_MOVED = 0.1  # of the share by a kelvin, at most


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Problem:
    """Time constants with the inverse of their covariance, and where they were measured."""

    effective: EffectiveTimeConstants
    inverse: Array
    around: PixelSurroundings

    def relative(self, share: float) -> Array:
        """The h_k of a share, shape (k,)."""
        return _relative(share, self.effective.blackbody_temperature_k, self.around)[0]

    @cached_property
    def scan(self) -> Array:
        """The h_k of all shares that are tried, shape (m, k)."""
        return np.array([self.relative(share) for share in _SHARES])

    @cached_property
    def deviances(self) -> Array:
        """Of all shares that are tried, shape (m,)."""
        return np.array([self._deviance(h) for h in self.scan])

    def sum_of_both(self, share: float) -> float:
        """tau_0 at its best, s."""
        return self._scale(self.relative(share))

    def deviance(self, share: float) -> float:
        """Sum of squares over the covariance, with tau_0 at its best."""
        return self._deviance(self.relative(share))

    def _scale(self, h: Array) -> float:
        return float(h @ self.inverse @ self.effective.time_constant_s / (h @ self.inverse @ h))

    def _deviance(self, h: Array) -> float:
        left = self.effective.time_constant_s - self._scale(h) * h
        return float(left @ self.inverse @ left)

    def constants(self, share: float) -> Array:
        """Substrate and scene, s."""
        both = self.sum_of_both(share)
        return np.array([both / (1 - share), both / share if share > 0 else np.inf])

    def covariance(self, share: float) -> Array:
        """Of tau_0 and the share, shape (2, 2)."""
        step = min(_NUDGE, share / 2) if share > 0 else _NUDGE
        slope = (self.relative(share + step) - self.relative(max(share - step, 0.0))) / (step + min(step, share))
        return self.spread(self.relative(share), slope)

    def spread(self, h: Array, slope: Array) -> Array:
        """The same from the h_k and their derivatives to the share."""
        design = np.stack([h, self._scale(h) * slope], axis=1)
        return np.asarray(np.linalg.pinv(design.T @ self.inverse @ design, rcond=1e-14))

    def best_share(self) -> float:
        """Where the deviance is least."""
        k = int(np.argmin(self.deviances))
        share, least = self.least_between(_SHARES[max(k - 1, 0)], _SHARES[min(k + 1, _SHARES.size - 1)])
        return share if least < self.deviances[k] else float(_SHARES[k])

    def least_between(self, low: float, high: float) -> tuple[float, float]:
        """Share of least deviance in an interval, and that deviance."""
        found = optimize.minimize_scalar(self.deviance, bounds=(low, high), method="bounded", options={"xatol": 1e-9})
        return float(found.x), float(found.fun)


def estimate(
    effective: EffectiveTimeConstants, *, substrate_temperature_k: float, wheel_temperature_k: float | None = None
) -> TwoConstantsResult:
    """Both constants where the temperatures lie far enough apart; bounds where not.

    Parameters
    ----------
    effective
        Time constants by blackbody temperature, with the covariance that their common errors make.
    substrate_temperature_k
        Of the detector's substrate, K: as the camera tells it, or the temperature that its housing settles at.
    wheel_temperature_k
        What the solid wheel looks like, K. None: where the contrast of the recordings would vanish, for there blackbody and
        wheel look alike.
    """
    around = _surroundings(effective, substrate_temperature_k, wheel_temperature_k)
    problem = _Problem(
        effective=effective,
        inverse=np.asarray(np.linalg.pinv(effective.covariance_s2), dtype=np.float64),
        around=around,
    )
    share = problem.best_share()
    deviation = problem.deviances - problem.deviance(share)
    is_number = effective.time_constant_s.size > 1 and 0 < _u_share(problem, share) < _UNDETERMINED * share
    h, pixel_k, bend = _relative(share, effective.blackbody_temperature_k, around)
    curve_k = np.linspace(
        effective.blackbody_temperature_k[0] - _CURVE_BEYOND_K,
        effective.blackbody_temperature_k[-1] + _CURVE_BEYOND_K,
        _CURVE_POINTS,
    )
    least = _least_share(problem)
    bounds = () if is_number else _bounds(problem, deviation)
    return TwoConstantsResult(
        estimate=_estimate(problem, share) if is_number else _nothing(),
        reference_temperature_k=REFERENCE_TEMPERATURE_K,
        surroundings=around,
        effective=effective,
        pixel_temperature_k=pixel_k,
        model_time_constant_s=problem.sum_of_both(share) * h,
        scene_share=share,
        share_scan=_SHARES,
        deviation=deviation,
        least_share=least,
        curve_blackbody_k=curve_k,
        curve_time_constant_s=problem.sum_of_both(share) * _relative(share, curve_k, around)[0],
        change_per_k_s=_changes(problem, share) if is_number else np.full((2, 2), np.nan),
        bend_s=problem.sum_of_both(share) * h * bend / (1 + bend),
        bounds=bounds,
        findings=_findings(problem, share, bounds=bounds, least=least),
    )


def _relative(share: float, blackbody_k: Array, around: PixelSurroundings) -> tuple[Array, Array, Array]:
    """The h_k, the pixel's middle temperature, K, and what bending adds, as a share; each of shape (k,)."""
    model = TwoConstants(
        substrate_time_constant_s=1 / (1 - share), scene_time_constant_s=1 / share if share > 0 else np.inf
    )
    temperatures_k = np.array([*blackbody_k, around.wheel_temperature_k])
    steady = steady_temperature(model, temperatures_k, substrate_temperature_k=around.substrate_temperature_k)
    exposed, covered = steady[:-1], np.full(len(blackbody_k), steady[-1])
    middle = (exposed + covered) / 2
    bend = _BENT * bending(model, exposed, second_k=covered) ** 2
    return effective_time_constant(model, middle) * (1 + bend), middle, bend


def _surroundings(effective: EffectiveTimeConstants, substrate_k: float, wheel_k: float | None) -> PixelSurroundings:
    if wheel_k is not None:
        return PixelSurroundings(
            substrate_temperature_k=substrate_k, wheel_temperature_k=wheel_k, wheel_temperature_from="you"
        )
    by_contrast = _wheel_by_contrast(effective)
    return PixelSurroundings(
        substrate_temperature_k=substrate_k,
        wheel_temperature_k=_ASSUMED_WHEEL_K if by_contrast is None else by_contrast,
        wheel_temperature_from="assumption" if by_contrast is None else "contrast",
    )


def _wheel_by_contrast(effective: EffectiveTimeConstants) -> float | None:
    """Temperature at which the straight line of contrast over radiance crosses zero; None where it does at no room's."""
    if effective.contrast_dn.size < 2:
        return None
    slope, level = np.polyfit(in_band_radiance(effective.blackbody_temperature_k), effective.contrast_dn, 1)
    low, high = in_band_radiance(_PLAUSIBLE_WHEEL_K)
    if slope <= 0 or not low < -level / slope < high:
        return None
    return float(optimize.brentq(lambda kelvin: float(in_band_radiance(kelvin)) + level / slope, *_PLAUSIBLE_WHEEL_K))


def _u_share(problem: _Problem, share: float) -> float:
    return float(np.sqrt(problem.covariance(share)[1, 1]))


def _least_share(problem: _Problem) -> float | None:
    """Smallest share in the scan from which on it would be determined by such data."""
    if problem.effective.time_constant_s.size < 2:
        return None
    slopes = np.gradient(problem.scan, _SHARES, axis=0)
    u = np.array([np.sqrt(problem.spread(h, slope)[1, 1]) for h, slope in zip(problem.scan, slopes, strict=True)])
    determined = _SHARES[1:][u[1:] < _UNDETERMINED * _SHARES[1:]]
    return float(determined[0]) if determined.size else None


def _estimate(problem: _Problem, share: float) -> Estimate:
    both = problem.sum_of_both(share)
    change = np.array([[1 / (1 - share), both / (1 - share) ** 2], [1 / share, -both / share**2]])
    return Estimate(
        names=NAMES,
        units=("s",) * len(NAMES),
        values=problem.constants(share),
        covariance=change @ problem.covariance(share) @ change.T,
    )


def of_result(result: Result, *, choices: Choices) -> TwoConstantsResult | None:
    """Constants of substrate and scene, where the substrate's temperature is stated; else None.

    Parameters
    ----------
    result
        Its effective time constants.
    choices
        Temperatures of substrate and wheel.

    Raises
    ------
    EstimationError
        If not every recording tells its blackbody's temperature.
    """
    if choices.substrate_temperature_k is None:
        return None
    if result.effective is None:
        raise EstimationError(
            "the substrate's temperature was given, but not every recording states that of its blackbody "
            "(entry/instrument/blackbody/temperature); write it, or leave the substrate's out"
        )
    return estimate(
        result.effective,
        substrate_temperature_k=choices.substrate_temperature_k,
        wheel_temperature_k=choices.wheel_temperature_k,
    )


def _nothing() -> Estimate:
    return Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0)))


def _bounds(problem: _Problem, deviation: Array) -> tuple[Bound, ...]:
    """Either constant over the shares that cost two standard uncertainties at most."""
    allowed = _SHARES[deviation <= _TWO_U]
    if problem.effective.time_constant_s.size < 2 or not allowed.size:
        allowed = _SHARES
    low, high = float(allowed[0]), float(allowed[-1])
    first, last = problem.constants(low), problem.constants(high)
    return (
        Bound(
            name=NAMES[0], lower=float(first[0]), upper=None if high == _SHARES[-1] else float(last[0])
        ),
        Bound(name=NAMES[1], lower=float(last[1]), upper=None if low == 0 else float(first[1])),
    )  # fmt: skip


def _changes(problem: _Problem, share: float) -> Array:
    """Change of the constants per kelvin of substrate and of wheel, shape (2, 2), s per K."""
    around, here = problem.around, problem.constants(share)
    warmer = (
        replace(around, substrate_temperature_k=around.substrate_temperature_k + _NUDGE_K),
        replace(around, wheel_temperature_k=around.wheel_temperature_k + _NUDGE_K),
    )
    moved = [replace(problem, around=one) for one in warmer]
    reach = (max(share - _MOVED, 0.0), min(share + _MOVED, float(_SHARES[-1])))
    return np.stack([(one.constants(one.least_between(*reach)[0]) - here) / _NUDGE_K for one in moved], axis=1)


def _findings(
    problem: _Problem, share: float, *, bounds: tuple[Bound, ...], least: float | None
) -> tuple[Finding, ...]:  # fmt: skip
    """Why there is no number, and whether the model describes the data."""
    effective, found = problem.effective, []
    kelvin = effective.blackbody_temperature_k
    if kelvin.size < 2:
        found.append(
            Finding(
                code="constants-one-temperature",
                severity="warning",
                what=f"the constants of substrate and scene are not separated: all recordings show a blackbody of "
                f"{kelvin[0]:.1f} K",
                cure="record at two temperatures or more, 20 K apart or wider",
            )
        )
    elif bounds:
        scatter = 1e6 * float(np.sqrt(np.mean(np.diag(effective.covariance_s2))))
        allowed = _SHARES[problem.deviances <= problem.deviances.min() + _TWO_U]
        cure = "no share would show in them" if least is None else f"one from {least:.2f} on would show"
        found.append(
            Finding(
                code="constants-not-separated",
                severity="warning",
                what=f"the constants of substrate and scene are not separated: blackbodies from {kelvin[0]:.1f} K to "
                f"{kelvin[-1]:.1f} "
                f"K with u = {scatter:.2g} µs of each time constant allow a share of the scene in the exchange of heat "
                f"of {allowed[0]:.2f} to {allowed[-1]:.2f} (2 u)",
                cure=f"{cure}; record wider apart, or longer",
            )
        )
    misfit = problem.deviance(share)
    freedom = kelvin.size - 2
    if freedom > 0 and special.chdtrc(freedom, misfit) < _SIGNIFICANCE:
        found.append(
            Finding(
                code="constants-do-not-fit",
                severity="warning",
                what=f"time constants over the blackbody's temperature do not follow the two-constant model (chi squared "
                f"{misfit:.1f} "
                f"with {counted(freedom, 'degree')} of freedom)",
                cure="check the temperatures, and whether the camera changed between recordings",
            )
        )
    if problem.around.wheel_temperature_from == "assumption":
        found.append(
            Finding(
                code="wheel-temperature-assumed",
                severity="warning",
                what=f"wheel taken to look like {_ASSUMED_WHEEL_K:g} K, which the contrast of the recordings does not tell",
                cure="give --wheel-temperature",
            )
        )
    return tuple(found)

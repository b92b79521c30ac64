r"""Undoing, frame to frame, what a pixel and its camera did to the scene in time.

A pixel with a first-order lag (Schatz 2023, eq. 2) that sees a scene which goes in a straight line from :math:`s_{n-1}` to
:math:`s_n` between two readings, a time :math:`\Delta` apart, stands at the second one at

.. math:: p_n = e\,p_{n-1} + a\,s_{n-1} + b\,s_n, \qquad e = e^{-\Delta/\tau}, \quad
          a = \frac{\tau}{\Delta}(1 - e) - e, \quad b = 1 - \frac{\tau}{\Delta}(1 - e)

so that :math:`s_n = (p_n - e\,p_{n-1} - a\,s_{n-1}) / b`, exactly for such a scene. The recursion forgets its beginning: a < b
for every :math:`x = \Delta/\tau > 0`, since that is tanh(x/2) < x/2. A photon detector's pixel that keeps a share s of the frame
before (`physics.response.pixel_memory`) is the same with e = 0, a = s, b = 1 - s.

A pixel that exchanges heat with substrate and scene apart (`physics.response.two_constants`) has, in units that are linear in
radiance, as counts are, :math:`\dot R = (S - R) / \tau(T_{pixel})`: the same lag with a time constant that depends on the value
alone. `LagOfValue` has it in steps.

Before it comes the camera's own recursive filter (`physics.response.in_camera_filter`): :math:`p_n = (y_n - k\,y_{n-1})/(1 - k)`.

Noise that enters before that filter is white over the frames. `responses` tells how such noise goes through: what the frames as
they came hold of it, and what the correction :math:`s_n - y_n` adds.
"""

from dataclasses import dataclass, replace
from math import exp, expm1
from typing import final

import numpy as np
from numpy.typing import NDArray

from irtiming.errors import EstimationError
from irtiming.physics.response import two_constants
from irtiming.physics.response.two_constants import TwoConstants
from irtiming.records.arrays import Array

_TAPS = 64
_MOST_SHARE = 0.9
_LONGEST_LAG = 20.0  # in frames; beyond, a frame holds less than a twentieth of what changed since the one before


@final
@dataclass(frozen=True, kw_only=True)
class LagOfValue:
    """Time constants over the values of a pixel: ``time_constants_s`` at equal steps from ``lowest`` to ``highest``; s."""

    lowest: float
    highest: float
    time_constants_s: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.time_constants_s) < 2 or not self.highest > self.lowest or min(self.time_constants_s) <= 0:
            raise EstimationError("a lag over values needs two time constants or more, above 0, and a range of values")


@final
@dataclass(frozen=True, kw_only=True)
class Response:
    """What lies between scene and frames, for each pixel alike; all zero: nothing.

    ``time_constant_s`` is tau of the lag, ``recursive_filter`` the share k of the frame before in the camera's noise filter, and
    ``pixel_memory`` the share s that a photon detector's pixel keeps. ``of_value`` takes the place of tau where the lag
    depends on the value of the pixel; tau then is the one about which noise is reckoned.
    """

    time_constant_s: float = 0.0
    recursive_filter: float = 0.0
    pixel_memory: float = 0.0
    of_value: LagOfValue | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.time_constant_s < np.inf:
            raise EstimationError(f"the time constant is {self.time_constant_s} s, must be 0 or more")
        if abs(self.recursive_filter) > _MOST_SHARE or abs(self.pixel_memory) >= 0.5:
            raise EstimationError(
                f"the shares of the frame before are {self.recursive_filter} (filter) and {self.pixel_memory} (memory), must be "
                f"within ±{_MOST_SHARE} and ±0.5; beyond, frames do not determine the scene"
            )

    @property
    def is_none(self) -> bool:
        """Whether frames already are the scene."""
        return self == Response()


@final
@dataclass(frozen=True, kw_only=True)
class Step:
    """Numbers of one step from frame to frame: k of the filter; e, a and b of the lag."""

    filter_share: float
    decay: float
    before: float
    now: float


def step(response: Response, interval_s: float) -> Step:
    """The step over one frame interval.

    Parameters
    ----------
    response
        Of the pixels.
    interval_s
        From the reading of the frame before to that of this one, more than 0; s.

    Raises
    ------
    EstimationError
        If the lag is so long against the interval that one frame hardly tells from the next.
    """
    tau_s = response.time_constant_s
    if tau_s > _LONGEST_LAG * interval_s:
        raise EstimationError(
            f"the time constant, {1e3 * tau_s:.3f} ms, is more than {_LONGEST_LAG:.0f} times the frame interval, "
            f"{1e3 * interval_s:.3f} ms; frames do not hold the scene frame by frame: check the times of the frames"
        )
    if response.pixel_memory:
        return Step(
            filter_share=response.recursive_filter,
            decay=0.0,
            before=response.pixel_memory,
            now=1 - response.pixel_memory,
        )
    if tau_s == 0:
        return Step(filter_share=response.recursive_filter, decay=0.0, before=0.0, now=1.0)
    decay = exp(-interval_s / tau_s)
    mean = -expm1(-interval_s / tau_s) * tau_s / interval_s  # (tau / Delta) (1 - e)
    return Step(filter_share=response.recursive_filter, decay=decay, before=mean - decay, now=1 - mean)


def numbers(response: Response, interval_s: float) -> NDArray[np.float32]:
    """The step in the form of `kernels.correct`: k, e, a, b, and then the lowest value and the steps per unit of value.

    Returns
    -------
    Shape (1, 6), or (step of values, 6) where the lag depends on the value.

    Raises
    ------
    EstimationError
        As for `step`.
    """
    table = response.of_value
    lags = (response.time_constant_s,) if table is None else table.time_constants_s
    found = np.zeros((len(lags), 6), np.float32)
    for row, time_constant_s in zip(found, lags, strict=True):
        one = step(replace(response, time_constant_s=time_constant_s, of_value=None), interval_s)
        row[:4] = one.filter_share, one.decay, one.before, one.now
    if table is not None:
        found[:, 4:] = table.lowest, (len(lags) - 1) / (table.highest - table.lowest)
    return found


def of_two_constants(
    model: TwoConstants, *, substrate_temperature_k: float, lowest: float, highest: float, scene_temperature_k: Array
) -> LagOfValue:
    """Lag over values of a pixel with two time constants.

    Parameters
    ----------
    model
        Its constants.
    substrate_temperature_k
        Of the detector's substrate, K.
    lowest, highest
        Values of the first and the last temperature, in units that are linear in what the pixels see.
    scene_temperature_k
        Shape (step of values,): temperature of a scene at rest that is shown as each value from ``lowest`` to ``highest``; K.

    Raises
    ------
    EstimationError
        If there are fewer than two values.
    """
    pixel_k = two_constants.steady_temperature(
        model, scene_temperature_k, substrate_temperature_k=substrate_temperature_k
    )
    lags_s = two_constants.effective_time_constant(model, pixel_k)
    return LagOfValue(lowest=lowest, highest=highest, time_constants_s=tuple(float(one) for one in lags_s))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseResponses:
    """How white noise of the pixels goes on over the frames, shape (n_tap,) each, per frame since it came.

    ``as_it_came`` is what the camera's frames hold; ``added`` what the whole correction adds to that.
    """

    as_it_came: Array
    added: Array

    @property
    def correction_power(self) -> float:
        """Variance of the correction plus its covariance with the frame, over the variance of the noise in a frame."""
        own = float(self.as_it_came @ self.as_it_came)
        return float(self.added @ (self.added + self.as_it_came)) / own


def responses(one: Step) -> NoiseResponses:
    """How noise that enters before the camera's filter goes on, for steps that are all alike."""
    k = one.filter_share
    taps = np.arange(_TAPS)
    direct = (1 - k) * np.power(k, taps, dtype=np.float64) if k else (taps == 0).astype(np.float64)
    scene = np.zeros(_TAPS)
    for n in taps:
        came = (n == 0) - one.decay * (n == 1)
        scene[n] = (came - one.before * (scene[n - 1] if n else 0.0)) / one.now
    return NoiseResponses(as_it_came=direct, added=scene - direct)

"""Wheel speeds for a camera that runs free: those at which its frames visit all angles evenly within a run.

Frame n sees the wheel at n f P turns, f being the wheel's rate and P the camera's period. What is left of it modulo a turn are
points on a circle, whose largest gap tells how even they are: it is 1/N at best. Neither rate is known exactly, and a small
change may turn an even sequence into one that visits few angles again and again, so a speed counts by its largest gap over all
that may be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd
from typing import final

import numpy as np

from irtiming.plan.prediction import RELATIVE, Setting, parameters_of, uncertainties
from irtiming.records.prediction import PredictedUncertainty
from irtiming.records.trigger_plan import TriggerScheme

_TRIED, _PLACES = 201, 15
_EVEN = 8.0
"""Times 1/N that the largest gap may be: beyond, the run does not see all angles."""

_FINENESS = 100


@final
@dataclass(frozen=True, kw_only=True)
class FreeSpeed:
    """A wheel rate, the largest gap between neighbouring angles over the even one (1 at best), and what a run should tell."""

    wheel_rate_hz: float
    largest_gap: float
    uncertainties: tuple[PredictedUncertainty, ...] = ()

    @property
    def is_even(self) -> bool:
        """Whether a run sees all angles."""
        return self.largest_gap <= _EVEN


def largest_gap(wheel_rate_hz: float, *, period_s: float, frames: int, tolerance: float = 0.0) -> float:
    """Largest gap between neighbouring wheel angles of a run, over a turn divided by its frames; the worst within a tolerance.

    Parameters
    ----------
    wheel_rate_hz
        Turns per second.
    period_s
        Of the camera.
    frames
        In a run.
    tolerance
        Relative, of the product of rate and period.
    """
    off = np.linspace(-tolerance, tolerance, _PLACES if tolerance else 1)[:, None]
    turns = np.sort(np.mod(np.arange(frames) * (wheel_rate_hz * period_s * (1 + off)), 1.0), axis=1)
    gaps = np.diff(turns, axis=1, append=turns[:, :1] + 1.0)
    return float(gaps.max()) * frames


def even_speed(around: tuple[float, float], *, period_s: float, frames: int, tolerance: float) -> FreeSpeed:
    """The most even wheel rate between two.

    Parameters
    ----------
    around
        Lowest and highest rate, Hz.
    period_s, frames, tolerance
        As for `largest_gap`.
    """
    tried = np.unique(np.linspace(*around, _TRIED))
    found = [largest_gap(float(f), period_s=period_s, frames=frames, tolerance=tolerance) for f in tried]
    best = int(np.argmin(found))
    return FreeSpeed(wheel_rate_hz=float(tried[best]), largest_gap=found[best])


def predicted(setting: Setting, speed: FreeSpeed, *, period_s: float, frames: int) -> FreeSpeed:
    """The same with the standard uncertainties of a run, as if each frame's event were stamped by the counter itself.

    Parameters
    ----------
    setting
        Camera and rig.
    speed
        An even one.
    period_s, frames
        As for `largest_gap`.
    """
    slots = _FINENESS * 100
    per_frame = _coprime(round(frames * speed.wheel_rate_hz * period_s), frames)
    scheme = TriggerScheme(turn_period_ticks=frames * slots, camera_period_ticks=per_frame * slots)
    clock_hz = round(scheme.turn_period_ticks * speed.wheel_rate_hz)
    prediction = Setting(
        camera=setting.camera, rig=setting.rig, clock_frequency_hz=clock_hz, structure=setting.structure
    ).one_run(scheme)
    names = [
        name for name in parameters_of(setting.camera) if name != RELATIVE and _is_determined(name, prediction.names)
    ]
    return FreeSpeed(
        wheel_rate_hz=speed.wheel_rate_hz,
        largest_gap=speed.largest_gap,
        uncertainties=uncertainties([(prediction, 1)], names),
    )


def _is_determined(name: str, names: Sequence[str]) -> bool:
    return name in names or (name == "exposure_midpoint_delay" and "integration_time" in names)


def _coprime(wanted: int, to: int) -> int:
    """Nearest positive whole number that has no divisor in common with another; one of as many in a row never has."""
    near = sorted(range(max(1, wanted - to), wanted + to + 1), key=lambda k: abs(k - wanted))
    return next(k for k in near if gcd(k, to) == 1)

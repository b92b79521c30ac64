"""How a camera keeps its image even: shutter, residual offsets, and how its levels drift and sway in between."""

import itertools
from dataclasses import dataclass
from typing import Literal, final

from irtiming.errors import PlanError

ShutterKind = Literal["closed", "frozen"]


@final
@dataclass(frozen=True, kw_only=True)
class ShutterEvent:
    """The camera corrects itself, from ``start_s`` after the first trigger on, which may be before it.

    While the shutter is "closed", frames show its uniform surface, with the pixels' lag into it and out of it.
    A "frozen" camera repeats the last frame before, and its pixels have settled on the scene when it goes on.
    Afterwards each pixel has another residual offset, and all values are ``level_jump_dn`` higher.
    """

    start_s: float
    duration_s: float = 0.6
    kind: ShutterKind = "closed"
    level_jump_dn: float = 5.0


@final
@dataclass(frozen=True, kw_only=True)
class SelfCorrection:
    """What a microbolometer camera does to keep its image even.

    Its shutter has the temperature ``surface_k``, at which no gain error shows. Offsets that are left have
    the standard deviation of the detector's ``offset_spread_dn``.
    """

    surface_k: float = 303.15
    events: tuple[ShutterEvent, ...] = ()

    def __post_init__(self) -> None:
        """Refuse events that are not one after the other."""
        if any(event.duration_s <= 0 for event in self.events):
            raise PlanError("a shutter event lasts 0 s or less; its duration must be positive")
        for before, after in itertools.pairwise(self.events):
            if after.start_s < before.start_s + before.duration_s:
                raise PlanError(
                    f"shutter event at {after.start_s:g} s after one from {before.start_s:g} s for "
                    f"{before.duration_s:g} s; events must be given in order and not overlap"
                )


@final
@dataclass(frozen=True, kw_only=True)
class Drift:
    """Slow change of all values alike: a straight line, and a settling that fades away.

    At time t after the first trigger, ``per_second_dn`` t + ``settling_dn`` exp(-t / ``settling_time_s``).
    """

    per_second_dn: float = 0.0
    settling_dn: float = 0.0
    settling_time_s: float = 10.0


@final
@dataclass(frozen=True, kw_only=True)
class Sway:
    """Levels that follow the camera's own temperature, smoothly and without any law; each run by itself.

    What a pixel gives is wheel + (1 + g(t)) (signal - wheel) + o(t) contrast. g goes up and down by ``gain_share`` in the
    ``within_s`` from the first trigger on, from the lowest value to the highest, and o by ``offset_share``.
    """

    gain_share: float = 0.0
    offset_share: float = 0.0
    within_s: float = 33.0

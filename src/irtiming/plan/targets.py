"""Text to targets: "trigger_delay=0.5us" asks for a standard uncertainty."""

from dataclasses import dataclass
from difflib import get_close_matches
from typing import final

from irtiming.errors import PlanError
from irtiming.plan.prediction import parameters_of
from irtiming.records.camera_description import Camera
from irtiming.units import seconds


@final
@dataclass(frozen=True, kw_only=True)
class Target:
    """A parameter and the standard uncertainty (k = 1) that is wanted for it, s."""

    name: str
    standard_uncertainty_s: float


def targets(texts: list[str], camera: Camera) -> tuple[Target, ...]:
    """Targets from texts such as ``"trigger_delay=0.5us"`` or ``"row_delay=0.03 us"``.

    Raises
    ------
    PlanError
        If the camera has no such parameter, one is named twice, or an uncertainty is not positive.
    UnitError
        If it is not a time.
    """
    known, found = parameters_of(camera), list[Target]()
    for text in texts:
        name, equals, size = (part.strip() for part in text.partition("="))
        if not equals:
            raise PlanError(
                f"--for is '{text}', must be a parameter and its uncertainty, such as 'trigger_delay=0.5us'"
            )
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise PlanError(f"--for asks for '{name}', this camera has {', '.join(known)}{hint}")
        if name in [target.name for target in found]:
            raise PlanError(f"--for asks for {name} twice; give it once, with the smaller uncertainty")
        wanted = seconds(size)
        if not wanted > 0:
            raise PlanError(f"--for asks for {name} to {size}, an uncertainty must be greater than 0")
        found.append(Target(name=name, standard_uncertainty_s=wanted))
    return tuple(found)

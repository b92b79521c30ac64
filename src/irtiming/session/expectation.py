"""What a series should tell of a camera, for wheel speeds and runs that a person tries out."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from irtiming.archive.rig_file import read_rig
from irtiming.errors import PlanError
from irtiming.plan.assumptions import assumed
from irtiming.plan.drawing import sampling_svg
from irtiming.plan.prediction import RELATIVE, Setting, parameters_of
from irtiming.plan.proposals import Proposal, foretell
from irtiming.records.series_plan import TriggerWishes
from irtiming.session.camera import Described, camera
from irtiming.session.triggers import exact


@final
@dataclass(frozen=True, kw_only=True)
class ExpectOrder:
    """Wishes that are complete, with the runs of each speed as ``repeats``; camera and rig as for ``irtiming plan --for``."""

    wishes: TriggerWishes
    camera: Described = field(default_factory=Described)
    rig: Path | None = None

    def __post_init__(self) -> None:
        if not self.wishes.clock_hz:
            raise PlanError("{clock_hz} must be given", "clock_hz")


@final
@dataclass(frozen=True, kw_only=True)
class Expected:
    """The series, what it should tell, what was assumed of the rig, and the sampling order of its first scheme as SVG."""

    proposal: Proposal
    assumptions: tuple[str, ...]
    picture: str


def expect(order: ExpectOrder) -> Expected:
    """What should come of it.

    Raises
    ------
    IrTimingError
        If a wish cannot be read, no scheme meets them, or rig.toml cannot be read.
    """
    wishes = exact(order.wishes, clock_frequency_hz=0)
    described = camera(order.camera)
    rig = assumed(None if order.rig is None else read_rig(order.rig), described)
    setting = Setting(camera=described, rig=rig, clock_frequency_hz=wishes.clock_frequency_hz)
    names = [name for name in parameters_of(described) if name != RELATIVE or len(wishes.trigger_delays_s) > 1]
    found = foretell(setting, wishes, names=names)
    picture = sampling_svg(found.plan.schemes[0], wishes.clock_frequency_hz)
    return Expected(proposal=found, assumptions=rig.remarks, picture=picture)

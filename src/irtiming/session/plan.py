"""Planning a measurement: trigger schemes for what is wished of it, or measurements for an uncertainty that is wanted."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, final

from irtiming.archive.json_file import require_places, write_atomically, write_json
from irtiming.archive.rig_file import read_rig
from irtiming.errors import PlanError, listed
from irtiming.plan.assumptions import assumed
from irtiming.plan.drawing import sampling_svg
from irtiming.plan.photon_information import KNOWN_WINDOW, SHARED_SHAPE
from irtiming.plan.prediction import Setting
from irtiming.plan.proposals import USUAL_SPEEDS_HZ, Proposals, propose
from irtiming.plan.schedule import schedule
from irtiming.plan.search import Options, search
from irtiming.plan.targets import Target, targets
from irtiming.records.series_plan import TriggerWishes
from irtiming.records.trigger_plan import TriggerPlan, TriggerScheme, Wishes
from irtiming.session.camera import Described, camera
from irtiming.session.plan_json import camera_as_json, plan_as_json, predicted_as_json, scheme_as_json
from irtiming.session.triggers import exact

MOST_IN_FILE = 10_000
"""Options that the JSON file lists at most; ``n_options`` in it says how many there are."""

PAPER = {"clock_hz": "49152000", "frame_hz": "30.303", "samples": "1000"}
"""Schatz 2023, section 2.3: taken for a wanted uncertainty where nothing is said."""

_WINDOW_UNKNOWN = (
    "The integration time counts as unknown. Analysis takes one that recordings state on trust, and u is smaller then: plan it "
    "as known (--known-integration-time) for that."
)


@final
@dataclass(frozen=True, kw_only=True)
class PlanOrder:
    """What a person wants planned, and written: ``json`` with all of it, ``picture`` of the sampling order of the best.

    ``wanted`` are uncertainties such as ``"trigger_delay=0.5us"``; where there is none, the ``wishes`` must be complete. ``most``
    are the options to be shown.
    """

    wishes: TriggerWishes
    wanted: tuple[str, ...] = ()
    camera: Described = field(default_factory=Described)
    rig: Path | None = None
    most: int = 10
    json: Path | None = None
    picture: Path | None = None

    def __post_init__(self) -> None:
        missing = [name for name in ("clock_hz", "wheel_hz", "frame_hz", "samples") if not getattr(self.wishes, name)]
        if not self.wanted and missing:
            raise PlanError(
                f"{listed(missing)} must be given; only with {{wanted}}, such as {{wanted}} 'trigger_delay=0.5us', "
                "are they found",
                *missing,
                "wanted",
            )
        if not self.wanted and (self.camera != Described() or self.rig is not None):
            raise PlanError(
                "camera and rig are described, but nothing is asked of them; add {wanted} 'trigger_delay=0.5us'",
                "wanted",
            )
        if self.wanted and self.wishes.repeats.strip() != "1":
            raise PlanError(
                f"{{repeats}} {self.wishes.repeats} with {{wanted}}, which finds the number of runs itself; "
                "leave one of them out",
                "repeats",
                "wanted",
            )


@final
@dataclass(frozen=True, kw_only=True)
class Planned:
    """Schemes that meet the wishes, best first, and the runs of the best."""

    options: Options
    best: TriggerPlan
    wishes: Wishes

    def as_json(self) -> dict[str, Any]:
        """All schemes and the plan as plain data."""
        return {
            "clock_frequency_hz": self.wishes.clock_frequency_hz,
            "n_options": self.options.n_options,
            "n_schemes": list(self.options.n_schemes),
            "is_complete": self.options.is_complete,
            "shares_camera_period": self.options.shares_camera_period,
            "schemes": [
                {"rank": rank, **self._scheme(scheme), "used_tolerance": float(option.used_tolerance)}
                for rank, option in enumerate(self.options.best, 1)
                for scheme in option.schemes
            ],
            "plan": plan_as_json(self.best),
        }

    def _scheme(self, scheme: TriggerScheme) -> dict[str, Any]:
        return scheme_as_json(scheme, self.wishes.clock_frequency_hz)


@final
@dataclass(frozen=True, kw_only=True)
class Proposed:
    """Measurements that should reach what was asked, shortest first."""

    found: Proposals
    asked: tuple[Target, ...]
    setting: Setting

    @property
    def best(self) -> TriggerPlan:
        """Runs of the shortest."""
        return self.found.best[0].plan

    def as_json(self) -> dict[str, Any]:
        """All proposals and the plan of the shortest as plain data."""
        clock = self.setting.clock_frequency_hz
        return {
            "clock_frequency_hz": clock,
            "targets": {
                target.name: {"standard_uncertainty": target.standard_uncertainty_s, "unit": "s"}
                for target in self.asked
            },
            "camera": camera_as_json(self.setting.camera),
            "assumptions": list(self.setting.rig.remarks),
            "predicted_uncertainty": predicted_as_json(self.found.best[0].uncertainties),
            "plan": plan_as_json(self.best),
            "proposals": [
                {
                    "rank": rank,
                    "duration_s": proposal.duration_s,
                    "runs_of_each": list(proposal.runs_of_each),
                    "schemes": [scheme_as_json(scheme, clock) for scheme in proposal.plan.schemes],
                    "predicted_uncertainty": predicted_as_json(proposal.uncertainties),
                }
                for rank, proposal in enumerate(self.found.best, 1)
            ],
        }


def plan(order: PlanOrder) -> Planned | Proposed:
    """Trigger schemes that meet the wishes, or the shortest measurements that should reach what is wanted.

    Raises
    ------
    IrTimingError
        If a wish cannot be read, nothing meets all of them, or a file cannot be read or written.
    """
    require_places({"JSON": [order.json], "SVG": [order.picture]}, inputs=[order.rig])
    wishes = exact(_completed(order), clock_frequency_hz=0)
    planned = _proposed(order, wishes) if order.wanted else _schemes(order, wishes)
    if order.json is not None:
        write_json(planned.as_json(), order.json)
    if order.picture is not None:
        write_atomically(sampling_svg(planned.best.schemes[0], wishes.clock_frequency_hz), order.picture)
    return planned


def _completed(order: PlanOrder) -> TriggerWishes:
    """The wishes with what is usual where nothing is said; a relative delay takes two of them."""
    given = order.wishes
    return replace(
        given,
        clock_hz=given.clock_hz or PAPER["clock_hz"],
        frame_hz=given.frame_hz or PAPER["frame_hz"],
        samples=given.samples or PAPER["samples"],
        wheel_hz=given.wheel_hz or tuple(map(str, USUAL_SPEEDS_HZ)),
        delays=given.delays or ("0 s", "25 ms")[: 1 + any("relative" in text for text in order.wanted)],
    )


def _schemes(order: PlanOrder, wishes: Wishes) -> Planned:
    options = search(wishes, most=order.most if order.json is None else max(order.most, MOST_IN_FILE))
    return Planned(options=options, best=schedule(options.best[0].schemes, wishes), wishes=wishes)


def _proposed(order: PlanOrder, wishes: Wishes) -> Proposed:
    described = camera(order.camera)
    asked = targets(list(order.wanted), described)
    rig = assumed(None if order.rig is None else read_rig(order.rig), described)
    is_known = order.camera.known_integration_time
    if (described.camera_type, described.readout_mode, is_known) == ("photon", "snapshot", False):
        rig = replace(rig, remarks=(*rig.remarks, _WINDOW_UNKNOWN))
    setting = Setting(
        camera=described, rig=rig, clock_frequency_hz=wishes.clock_frequency_hz,
        structure=KNOWN_WINDOW if is_known else SHARED_SHAPE,
    )  # fmt: skip
    return Proposed(found=propose(setting, wishes, targets=asked, most=order.most), asked=asked, setting=setting)

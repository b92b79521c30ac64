"""The joint fit of a photon camera as tables: what all recordings share, how the search went, what the wheel speeds tell."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.report.evidence import Evidence
from irtiming.report.rounding import fixed, in_unit, significant
from irtiming.report.tables import SIGN, Table

US, MRAD, DEG = 1e-6, 1e-3, float(np.pi / 180)
EDGES = slice(1, 5)
"""Places of the edges' angles among the shared numbers."""

LEAST_WHITENESS = 1e-4
"""Probability below which residuals are not called white."""

_EARLY = "wheel edge {}: angle by which it comes earlier than rig.toml says"
_LEAN = "mask edge at the {} wheel angle: angle by which it misses the axle, at the mean radius"


@final
@dataclass(frozen=True, kw_only=True)
class Shared:
    """A number that all recordings share, SI units; ``scale`` and ``shown_unit`` are those of the tables."""

    name: str
    meaning: str
    unit: str
    scale: float
    shown_unit: str
    start: float
    value: float
    standard_uncertainty: float
    prior_uncertainty: float | None = None

    @property
    def over_prior(self) -> float | None:
        """Estimate over the standard uncertainty that was expected of it; None without one."""
        return None if not self.prior_uncertainty else self.value / self.prior_uncertainty


_NUMBERS = (
    ("middle_of_window", "middle of the integration window after the trigger edge", "s", US, "µs"),
    *((f"edge_angle_{edge}", _EARLY.format(edge), "rad", MRAD, "mrad") for edge in range(4)),
    ("opening_angle", "opening angle of the mask", "rad", DEG, "°"),
    ("window", "length of the integration window", "s", US, "µs"),
    *((f"lean_{which}", _LEAN.format(f"{which}er"), "rad", MRAD, "mrad") for which in ("low", "high")),
)


def shared(evidence: Evidence) -> tuple[Shared, ...]:
    """The nine shared numbers, in the order of the fit."""
    joint = evidence.joint
    u = np.sqrt(np.diag(joint.covariance))
    prior = dict(zip(range(EDGES.start, EDGES.stop), np.sqrt(np.diag(joint.prior_covariance_rad2)), strict=True))
    return tuple(
        Shared(
            name=name,
            meaning=meaning,
            unit=unit,
            scale=scale,
            shown_unit=shown,
            start=float(joint.start[k]),
            value=float(joint.shared[k]),
            standard_uncertainty=float(u[k]),
            prior_uncertainty=float(prior[k]) if k in prior else None,
        )
        for k, (name, meaning, unit, scale, shown) in enumerate(_NUMBERS)
    )


def angles(evidence: Evidence) -> tuple[Shared, ...]:
    """The edges' common angle, and of each edge what it differs from it."""
    joint = evidence.joint
    common = np.full(4, 0.25)
    rows = [("common_angle", "all edges together: angle by which they come earlier than rig.toml says", common)]
    rows += [
        (f"edge_{edge}_alone", f"edge {edge}, beyond what all have in common", np.eye(4)[edge] - common)
        for edge in range(4)
    ]
    return tuple(
        Shared(
            name=name,
            meaning=meaning,
            unit="rad",
            scale=MRAD,
            shown_unit="mrad",
            start=float(weight @ joint.start[EDGES]),
            value=float(weight @ joint.shared[EDGES]),
            standard_uncertainty=float(np.sqrt(max(0.0, weight @ joint.covariance[EDGES, EDGES] @ weight))),
            prior_uncertainty=float(np.sqrt(max(0.0, weight @ joint.prior_covariance_rad2 @ weight))),
        )
        for name, meaning, weight in rows
    )


def moved(evidence: Evidence) -> tuple[float, float]:
    """How far the middle of the window is from where the search began, s, and in its own standard uncertainties."""
    first = shared(evidence)[0]
    way = first.value - first.start
    return way, way / first.standard_uncertainty if first.standard_uncertainty > 0 else 0.0


def has_several_speeds(evidence: Evidence) -> bool:
    """Whether recordings at more than one wheel speed tell angles from delays."""
    return len({round(recording.rotation_speed_hz, 6) for recording in evidence.recordings}) > 1


def blocks(evidence: Evidence) -> tuple[Table, ...]:
    """All tables of the joint fit."""
    return (numbers(evidence), search(evidence), *((by_speeds(evidence),) if has_several_speeds(evidence) else ()))


def numbers(evidence: Evidence) -> Table:
    """Shared numbers with the start of the search and what was known before."""
    rows = tuple(
        (f"{one.meaning} ({one.shown_unit})", _shown(one, one.start), _shown(one, one.value),
         significant(one.standard_uncertainty / one.scale), *_prior(one))
        for one in shared(evidence)
    )  # fmt: skip
    return Table(
        title="What all recordings share",
        columns=("quantity", "start", "estimate", "u", "prior u", "estimate / prior u"),
        align="lrrrrr",
        rows=rows,
        note=f"One likelihood over all recordings. The delay is {SIGN}; an angle is positive where an edge comes early. Prior u: "
        "what rig.toml, the images and the residuals allow an angle to be off before the fit. The window is what the rounded "
        "corners say; the delays count on the integration time that the recordings state, where they state one. The leans start "
        "where the image shows them.",
    )


def _shown(one: Shared, value: float) -> str:
    return in_unit(value, one.standard_uncertainty, unit_s=one.scale)


def _prior(one: Shared) -> tuple[str, str]:
    if one.prior_uncertainty is None or one.over_prior is None:
        return "–", "–"
    return significant(one.prior_uncertainty / one.scale), fixed(one.over_prior, 2)


def search(evidence: Evidence) -> Table:
    """How the search went, and whether recordings and model agree."""
    joint = evidence.joint
    way_s, own = moved(evidence)
    least = float(np.min(joint.whiteness))
    low = int(np.sum(joint.whiteness < LEAST_WHITENESS))
    return Table(
        title="How the fit went",
        columns=("what", "found", "expected"),
        align="lrl",
        rows=(
            ("steps taken", str(joint.n_steps), "some, below 40"),
            ("distance of the window's middle from its start",
             f"{significant(way_s / US, digits=3)} µs = {fixed(own, 2)} u",
             "not 0: a fit that stays at its start has found nothing"),
            ("reduced chi-square of the frames", f"{joint.reduced_chi_square:.2f}",
             "about 1: one set of shared numbers does as well as each recording's own; less where noise was widened"),
            ("Birge ratio of the recordings' delays", f"{joint.birge:.2f}", "about 1: they scatter as their noise says"),
            ("least probability of white residuals", f"{least:.2g}", f"{LEAST_WHITENESS:g} or more"),
            ("recordings below that", f"{low} of {joint.whiteness.size}", "0"),
        ),
        note="Delays of single recordings count from the trigger edge, with the delay set taken off. Residuals stand under the "
        "pixel sums in the section before.",
    )  # fmt: skip


def by_speeds(evidence: Evidence) -> Table:
    """What several wheel speeds say of the angles in rig.toml."""
    rows = tuple(
        (
            one.meaning,
            f"{_shown(one, one.value)} ± {significant(one.standard_uncertainty / one.scale)}",
            *_prior(one),
            check,
        )
        for one, check in zip(
            angles(evidence), ("[mask] centre_angle_deg, [beams]", *["[wheel] cutout_edges_rad"] * 4), strict=True
        )
    )
    return Table(
        title="What the wheel speeds say of rig.toml",
        columns=("angle", "measured ± u (mrad)", "rig.toml: u (mrad)", "measured / u of rig.toml", "belongs to"),
        align="lrrrl",
        rows=rows,
        note="A delay is an angle that grows with the wheel's speed, an error of rig.toml is one that does not: recordings at "
        "several speeds measure it. Positive: the edge comes early. Within about 2 u of rig.toml nothing need be "
        "done: the delay is already corrected for it.",
    )

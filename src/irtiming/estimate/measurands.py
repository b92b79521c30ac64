"""What is reported of a camera, from the joint fit: by its response, not by its kind.

An integration window (eq. 1) is fitted by its middle; its start is half the integration time earlier. That time is what the
recordings state, if they do; what the sums say of it is reported beside it and stands in where none is stated. A first-order lag
(eq. 2) has a delay to the reading of row 0, and a time constant of its own for each blackbody temperature.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from irtiming.estimate.joint import Joint, Measurand
from irtiming.estimate.shared_numbers import DELAY, MEMORIES
from irtiming.inference.information import NOISE, prior
from irtiming.physics.camera import EXACT_SHARE
from irtiming.physics.covariance import inverse
from irtiming.physics.response.integration_window import TAILS, tail_delay_s
from irtiming.records import sources
from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.records.finding import Finding
from irtiming.records.result import Bound, Contribution

WINDOW, LAG, ROW_DELAY = "integration_time", "time_constant", "row_delay"
UNKNOWN_S = 0.1
"""Standard uncertainty of a window that no frame tells anything of."""

_MIDDLE = "exposure_midpoint_delay"
_FALLING, _RISING = (EDGE_DELAYS[0], EDGE_DELAYS[2]), (EDGE_DELAYS[1], EDGE_DELAYS[3])
_SHORTEST_SHOWN = 2.0  # standard uncertainties: a window that is shorter cannot be distinguished from none
_CONTRADICTS = 4.0  # standard uncertainties
_UNDETERMINED = 0.25  # relative standard uncertainty of tau from which it is no number any more
_SHORTEST_LAG_S = 0.5e-3  # of any microbolometer: an uncertainty below it would have shown the lag


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Reported:
    """Parameters with their covariance, what each source adds to each, bounds of those not determined, and doubts.

    ``profiled`` are those that are one sum of shared numbers; ``not_held`` is in words what no uncertainty holds;
    ``midpoint_leads`` whether the middle of the window is to be reported before its start, ``is_length_checked`` whether the
    frames alone tell its length about as well as what is stated.
    """

    estimate: Estimate
    budget: tuple[Contribution, ...]
    profiled: tuple[Measurand, ...]
    bounds: tuple[Bound, ...] = ()
    findings: tuple[Finding, ...] = ()
    not_held: tuple[str, ...] = ()
    midpoint_leads: bool = False
    is_length_checked: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class Window:
    """What is known of the integration window beside the fit.

    ``stated_s`` is its length as the recordings state it, None where they do not, ``u_stated_s`` the standard uncertainty of
    that, None where it is taken on trust; ``is_determined`` whether the recordings determine its length at all; ``tails_s`` the
    time constants of what comes after its end, by name, none where it is taken on trust that nothing does.
    """

    stated_s: float | None
    is_determined: bool
    u_stated_s: float | None = None
    tails_s: Mapping[str, float] = field(default_factory=dict)


def of_window(joint: Joint, window: Window, *, degrees_of_freedom: float) -> Reported:
    """Start and middle of the integration, the same by falling and by rising slopes alone, its length, the row delay.

    Parameters
    ----------
    joint
        Shared numbers ``delay`` (of the window's middle), ``integration_time`` unless it was held, ``row_delay`` of a rolling
        readout, and those of `TAILS` where they are thought of.
    window
        What else is known of its length.
    degrees_of_freedom
        Of the frames' noise.
    """
    base = [
        Measurand(name=_MIDDLE, weights={DELAY: 1.0}),
        Measurand(name="trigger_delay_falling", weights={DELAY: 1.0}, forgotten=_RISING),
        Measurand(name="trigger_delay_rising", weights={DELAY: 1.0}, forgotten=_FALLING),
    ]
    base += [
        Measurand(name=name, weights={name: _sign(joint, name)}) for name in (WINDOW, ROW_DELAY) if name in joint.names
    ]
    base += _shares(joint, (*TAILS, *MEMORIES))
    found = joint.estimate(base)
    is_significant = (
        window.is_determined and WINDOW in found and found.value(WINDOW) > _SHORTEST_SHOWN * found.u(WINDOW)
    )
    start = _Start.of(found, window, is_significant=is_significant)
    rows = _rows(found, start, is_significant=is_significant)
    own = {one.name: one for one in base}
    reported = {
        name: replace(_sum([own[part] for part in parts], list(parts.values())), name=name, offset=start.offset_s(name))
        for name, parts in rows.items()
    }
    budget = _budget(joint, reported, degrees_of_freedom=degrees_of_freedom)
    profiled = [
        replace(own[next(iter(parts))], name=name, offset=start.offset_s(name))
        for name, parts in rows.items()
        if list(parts.values()) == [1.0] and name not in MEMORIES
    ]
    estimate = joint.estimate(list(reported.values()))
    follows = np.array([start.u_beside_s(name) for name in rows])
    trusted = _trusted(_of_frames(joint, window) if is_significant else None, window, u_middle_s=found.u(_MIDDLE))
    return Reported(
        estimate=replace(estimate, covariance=estimate.covariance + np.outer(follows, follows)),
        budget=(*budget, *_of_statement(rows, start)),
        profiled=tuple(profiled),
        findings=trusted.findings,
        not_held=trusted.not_held,
        midpoint_leads=trusted.midpoint_leads,
        is_length_checked=trusted.is_checked,
    )


@final
@dataclass(frozen=True, kw_only=True)
class _Start:
    """The start of the window: so much earlier than the delay as shared numbers say, and as is stated beside them.

    ``weights`` are of the numbers found, ``before_s`` half of a stated length that is none of them, with ``u_before_s``; None
    where there is no start to tell.
    """

    weights: Mapping[str, float] | None
    before_s: float = 0.0
    u_before_s: float = 0.0

    @classmethod
    def of(cls, found: Estimate, window: Window, *, is_significant: bool) -> "_Start":
        """By the length that was found where frames, or frames and its stated u together, tell it; else by the stated one."""
        length_s = window.stated_s or (found.value(WINDOW) if WINDOW in found else 0.0)
        tail = {name: -tail_delay_s(length_s, fades_s) for name, fades_s in window.tails_s.items() if name in found}
        if WINDOW in found and (window.stated_s is None or window.u_stated_s is not None):
            has_start = is_significant or window.stated_s is not None
            return cls(weights={WINDOW: -0.5} | tail if has_start else None)
        if window.stated_s is None:
            return cls(weights=None)
        return cls(weights=tail, before_s=window.stated_s / 2, u_before_s=(window.u_stated_s or 0.0) / 2)

    def offset_s(self, name: str) -> float:
        """What the stated length adds to a parameter."""
        return -self.before_s if name.startswith("trigger_delay") else 0.0

    def u_beside_s(self, name: str) -> float:
        """What its uncertainty adds, signed."""
        return -self.u_before_s if name.startswith("trigger_delay") else 0.0


def _rows(found: Estimate, start: _Start, *, is_significant: bool) -> dict[str, dict[str, float]]:
    """What is reported, as sums of what was found."""
    rows = {_MIDDLE: {_MIDDLE: 1.0}}
    if start.weights is not None:
        back = dict(start.weights)
        rows = {"trigger_delay": {_MIDDLE: 1.0} | back, **rows}
        rows |= {name: {name: 1.0} | back for name in ("trigger_delay_falling", "trigger_delay_rising")}
    if is_significant:
        rows[WINDOW] = {WINDOW: 1.0}
    if ROW_DELAY in found:
        rows[ROW_DELAY] = {ROW_DELAY: 1.0}
    return rows | {name: {name: 1.0} for name in MEMORIES if name in found}


def _of_statement(rows: Iterable[str], start: _Start) -> tuple[Contribution, ...]:
    """What the stated length adds where it is none of the shared numbers."""
    u_s = 2 * start.u_before_s
    if u_s == 0:
        return ()
    sizes = {name: abs(start.u_beside_s(name)) for name in rows}
    return (Contribution(source=sources.WINDOW, kind="B", standard_uncertainty=sizes, measured=(u_s, "s")),)


def _of_frames(joint: Joint, window: Window) -> Estimate:
    """The length as the frames alone say it, whatever is stated; as if nothing came after it where that is taken on trust."""
    priors = [one for one in joint.priors if window.u_stated_s is None or WINDOW not in one.names]
    if len(priors) < len(joint.priors):
        gap = -joint.found.values[WINDOW]
        priors.append(prior(WINDOW, UNKNOWN_S, source=sources.WINDOW, gap=gap))
    trusted = [name for name in TAILS if name in joint.names and name not in window.tails_s]
    priors += [prior(name, EXACT_SHARE, source=sources.TAIL, gap=-joint.found.values[name]) for name in trusted]
    return replace(joint, priors=tuple(priors)).estimate([Measurand(name=WINDOW, weights={WINDOW: 1.0})])


def of_lag(joint: Joint, constants: Sequence[str], *, degrees_of_freedom: float) -> Reported:
    """Reading of row 0, time constant, row delay.

    Parameters
    ----------
    joint
        Shared numbers ``delay``, ``row_delay`` of a rolling readout, and ``constants``.
    constants
        Names of the time constants, one per blackbody; of several their weighted mean is reported.
    degrees_of_freedom
        Of the frames' noise.
    """
    taus = joint.estimate([Measurand(name=name, weights={name: 1.0}) for name in constants])
    weights = inverse(taus.covariance).sum(axis=0)
    mean = dict(zip(constants, (weights / weights.sum()).tolist(), strict=True))
    measurands = [Measurand(name="trigger_delay", weights={DELAY: 1.0}), Measurand(name=LAG, weights=mean)]
    if ROW_DELAY in joint.names:
        measurands.append(Measurand(name=ROW_DELAY, weights={ROW_DELAY: 1.0}))
    measurands += _shares(joint, MEMORIES)
    found = joint.estimate(measurands)
    budget = _budget(joint, {one.name: one for one in measurands}, degrees_of_freedom=degrees_of_freedom)
    keep, bounds, findings = _determined(found)
    return Reported(
        estimate=found.pick(*keep),
        budget=budget,
        profiled=tuple(one for one in measurands if one.name in keep and one.name not in MEMORIES),
        bounds=bounds,
        findings=findings,
    )


def _shares(joint: Joint, names: Sequence[str]) -> list[Measurand]:
    """Those of these shares that were fitted, as measurands."""
    return [Measurand(name=name, unit="1", weights={name: 1.0}) for name in names if name in joint.names]


def mixed(found: Estimate, rows: Mapping[str, Mapping[str, float]]) -> Estimate:
    """Weighted sums of the numbers of an estimate, with their covariance.

    Parameters
    ----------
    found
        Numbers.
    rows
        By the name of each sum, the weights of the numbers.
    """
    mix = np.array([[weights.get(name, 0.0) for name in found.names] for weights in rows.values()])
    return Estimate(
        names=tuple(rows),
        units=tuple(found.units[found.names.index(next(iter(weights)))] for weights in rows.values()),
        values=mix @ found.values,
        covariance=mix @ found.covariance @ mix.T,
    )


def _sign(joint: Joint, name: str) -> float:
    """With which a number is told: an even model leaves that of the window's length open, and its search may pass zero."""
    return -1.0 if name == WINDOW and joint.values[joint.names.index(name)] < 0 else 1.0


def _sum(parts: Sequence[Measurand], shares: Sequence[float]) -> Measurand:
    """A weighted sum of measurands, judged with the edges of the first."""
    weights: dict[str, float] = {}
    for one, share in zip(parts, shares, strict=True):
        for name, weight in one.weights.items():
            weights[name] = weights.get(name, 0.0) + share * weight
    return replace(parts[0], weights=weights)


def _budget(
    joint: Joint, measurands: Mapping[str, Measurand], *, degrees_of_freedom: float
) -> tuple[Contribution, ...]:
    """What each source adds to the uncertainty of each parameter."""
    whole, known = joint.combined(), _with_known_memory(joint)
    kinds = {part.source: part.kind for part in whole.parts}
    measured = {one.source: one.measured for one in joint.shared}
    shares = {name: known.combined(one.forgotten).shares(one.weights) for name, one in measurands.items()}
    lines = tuple(
        Contribution(
            source=source,
            kind=kind,
            standard_uncertainty={name: float(np.sqrt(max(0.0, of[source]))) for name, of in shares.items()},
            degrees_of_freedom=degrees_of_freedom if source == whole.parts[0].source else float("inf"),
            measured=measured.get(source),
        )
        for source, kind in kinds.items()
    )
    if known is joint:
        return lines
    beside = {
        name: sum(joint.combined(one.forgotten).shares(one.weights).values()) - sum(shares[name][s] for s in kinds)
        for name, one in measurands.items()
    }
    return (*lines, Contribution(
        source=sources.FRAME_BEFORE, kind="A", degrees_of_freedom=degrees_of_freedom,
        standard_uncertainty={name: float(np.sqrt(max(0.0, size))) for name, size in beside.items()},
    ))  # fmt: skip


def _with_known_memory(joint: Joint) -> Joint:
    """The same as if the shares of the frame before were stated; itself where nothing was free.

    What they add to a variance then is the difference: the square of what one unit of the share does, times its variance.
    """
    free = [one.name for one in joint.shared if one.name in MEMORIES and one.source == NOISE]
    known = tuple(prior(name, EXACT_SHARE, source=sources.FRAME_BEFORE, kind="A", gap=0.0) for name in free)
    return replace(joint, priors=(*joint.priors, *known)) if free else joint


@final
@dataclass(frozen=True, kw_only=True)
class _Trust:
    """How far the stated length can be trusted: what to say of it, whether the middle comes first, and what frames say of it."""

    findings: tuple[Finding, ...] = ()
    not_held: tuple[str, ...] = ()
    midpoint_leads: bool = False
    is_checked: bool = False


def _trusted(by_frames: Estimate | None, window: Window, *, u_middle_s: float) -> _Trust:
    """What the sums, where they tell it, say of the integration time that the recordings state."""
    stated_s, u_stated_s = window.stated_s, window.u_stated_s
    if stated_s is None:
        return _Trust()
    if by_frames is not None:
        length_s, u_s = abs(by_frames.value(WINDOW)), float(np.hypot(by_frames.u(WINDOW), u_stated_s or 0.0))
        if abs(length_s - stated_s) > _CONTRADICTS * u_s:
            return _Trust(
                findings=(_contradicted(length_s, u_s, stated_s=stated_s),), midpoint_leads=True, is_checked=True
            )
    is_fine = by_frames is not None and by_frames.u(WINDOW) <= 2 * max(u_middle_s, u_stated_s or 0.0)
    if u_stated_s is not None:
        return _Trust(is_checked=is_fine)
    if by_frames is None:
        what, within = (
            "the recordings' count_time is taken on trust, and half of its error is in trigger_delay; so is that nothing "
            "comes after the window",
            "",
        )
    else:
        what = "rig.toml states no u of the recordings' count_time: the wheel speeds confirm it"
        within = f" within u = {1e6 * by_frames.u(WINDOW):.2g} µs, half of which is not in u of trigger_delay"
    return _Trust(
        findings=(
            Finding(
                code="integration-time-on-trust",
                severity="info" if is_fine else "doubt",
                what=what + within,
                cure="state [camera] integration_time_u_us; exposure_midpoint_delay does not depend on it",
            ),
        ),
        not_held=() if is_fine else ("integration time (count_time)",),
        midpoint_leads=by_frames is None,
        is_checked=is_fine,
    )


def _contradicted(length_s: float, u_s: float, *, stated_s: float) -> Finding:
    return Finding(
        code="integration-time-contradicted",
        severity="doubt",
        what=f"the corners of the sums say {1e6 * length_s:.1f} µs of integration (u = {1e6 * u_s:.1f} µs), their count_time "
        f"says {1e6 * stated_s:.1f} µs",
        cure="trigger_delay counts on the latter, exposure_midpoint_delay on neither",
    )


def _determined(found: Estimate) -> tuple[tuple[str, ...], tuple[Bound, ...], tuple[Finding, ...]]:
    """Which parameters are numbers; bounds and a finding for the others."""
    tau, u = found.value(LAG), found.u(LAG)
    if u < _UNDETERMINED * tau:
        return found.names, (), ()
    if u < _SHORTEST_LAG_S:
        doubt = Finding(
            code="no-lag-seen",
            severity="warning",
            what=f"no thermal lag is found: the time constant is {1e3 * tau:.3f} ms with u = {1e3 * u:.3f} ms (k = 1), a "
            "microbolometer has some ms",
            cure="if this is a photon camera, its recording must say so (camera type photon)",
        )
        longest = Bound(name=LAG, lower=0.0, upper=max(0.0, tau) + 2 * u)
        return tuple(name for name in found.names if name != LAG), (longest,), (doubt,)
    lowest, highest = max(0.0, tau - 2 * u), tau + 2 * u
    delay, u_delay = found.value("trigger_delay"), found.u("trigger_delay")
    bounds = (
        Bound(name=LAG, lower=lowest, upper=highest),
        Bound(name="trigger_delay", lower=delay - 2 * u_delay, upper=delay + 2 * u_delay),
    )
    doubt = Finding(
        code="lag-not-determined",
        severity="warning",
        what=f"the time constant is not determined (u = {1e3 * u:.3g} ms, k = 1): the plateaus are too short or too noisy to "
        f"tell a lag from a delay; it lies between {1e3 * lowest:.3g} and {1e3 * highest:.3g} ms (2 u), the trigger delay "
        f"between {1e3 * (delay - 2 * u_delay):.3g} and {1e3 * (delay + 2 * u_delay):.3g} ms",
        cure="record longer or with more contrast",
    )
    return tuple(name for name in found.names if name in (ROW_DELAY, *MEMORIES)), bounds, (doubt,)


def edge_angles(joint: Joint, angular_frequency_rad_per_s: float) -> tuple[Measurand, ...]:
    """Angles by which the edges come earlier than rig.toml says, ``edge_angle_0`` .. ``edge_angle_3``, rad.

    Parameters
    ----------
    joint
        Its shared numbers that turn edges.
    angular_frequency_rad_per_s
        Of the wheel in the first recording.
    """
    errors = [one for one in joint.shared if one.turns_edges]
    omega = angular_frequency_rad_per_s
    return tuple(
        Measurand(
            name=f"edge_angle_{k}",
            unit="rad",
            weights={one.name: omega * one.effects[0].get(edge, 0.0) for one in errors},
        )
        for k, edge in enumerate(EDGE_DELAYS)
    )


def known_before(joint: Joint, measurands: Sequence[Measurand]) -> Estimate:
    """Sums of numbers as they were known beforehand, with their covariance; errors of the rig were expected to be none.

    Parameters
    ----------
    joint
        Its shared numbers, of which the rig's errors count.
    measurands
        Sums of shared numbers; those that hold others than errors of the rig are left out.
    """
    stated = [one for one in joint.shared if one.turns_edges or one.measured is not None]
    known = [one for one in measurands if set(one.weights) <= {number.name for number in stated}]
    weights = np.array([[one.weights.get(number.name, 0.0) for number in stated] for one in known])
    weights = weights.reshape(len(known), len(stated))
    per_unit = weights * np.array([number.u or 0.0 for number in stated])
    return Estimate(
        names=tuple(one.name for one in known),
        units=tuple(one.unit for one in known),
        values=weights @ np.array([number.known for number in stated]),
        covariance=per_unit @ per_unit.T,
    )

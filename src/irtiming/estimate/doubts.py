"""Doubts about a result: each a finding with its code, whatever the camera."""

from collections.abc import Sequence

import numpy as np
from scipy import special

from irtiming.estimate.measurands import mixed
from irtiming.physics.covariance import inverse
from irtiming.physics.light.row_sum import BLADE
from irtiming.records.estimate import EdgeDelayFit, Estimate
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import LEAST_WHITENESS, EffectiveTimeConstants, JointFit, Result
from irtiming.records.row_timing import RowTimingFit
from irtiming.units import counted

_CONTRADICTS = 4.0  # standard uncertainties
_LARGEST_EDGE_RAD = 5e-3
_CORRELATED = 2.0  # variance inflation of pixel sums from which it is said
_CORRELATED_ROWS = 4.0  # the same of row sums, whose frames are judged over all rows
_SWAY, _BLADES = 0.005, 0.002  # of the contrast, from which levels are worth a word
_SIGNIFICANCE = 0.003  # time constants that differ as much by chance are taken for one


def of_edges(u_edge_rad: float) -> tuple[Finding, ...]:
    """Where the edges differ by more than wheels are cut to.

    Parameters
    ----------
    u_edge_rad
        Standard uncertainty of one cutout edge.
    """
    if u_edge_rad <= _LARGEST_EDGE_RAD:
        return ()
    return (
        Finding(
            code="edges-disagree",
            severity="warning",
            what=f"the four wheel edges disagree by {1e3 * u_edge_rad:.1f} mrad (standard uncertainty of one edge), wheels "
            "are cut to "
            f"better than {1e3 * _LARGEST_EDGE_RAD:.0f} mrad",
            cure="check [wheel] rotation and cutout_edges_rad",
        ),
    )


def of_window(estimate: Estimate) -> tuple[Finding, ...]:
    """Where a camera seems to expose before its trigger: a doubt beyond what the uncertainty allows, since no camera can.

    Parameters
    ----------
    estimate
        Of the delays; the first is the camera's own.
    """
    delay_s = float(estimate.values[0])
    if delay_s >= 0:
        return ()
    return (
        Finding(
            code="delay-negative",
            severity="doubt" if delay_s < -_CONTRADICTS * float(estimate.standard_uncertainties[0]) else "warning",
            what=f"the trigger delay is negative ({1e3 * delay_s:.3f} ms): integration would start before the trigger",
            cure="check frame_number, [beams] whole_slots_between, [mask] centre_angle_deg, trigger_delay_time_set, the "
            "trigger's edge, and that application_slot holds edges 0 and 2",
        ),
    )


def of_reading(estimate: Estimate, *, n_rows: int) -> tuple[Finding, ...]:
    """Where a row seems to be read before the trigger: a doubt beyond what the uncertainty allows, since no camera can.

    Of all rows that one counts which is the most standard uncertainties early: the earliest may be known worse than others.

    Parameters
    ----------
    estimate
        Of the delays.
    n_rows
        Rows of the image: the last is read ``(n_rows - 1) row_delay`` after the first.
    """
    if "trigger_delay" not in estimate:
        return ()
    places = range(n_rows) if "row_delay" in estimate else range(1)
    rows = mixed(estimate, {f"row {k}": {"trigger_delay": 1.0, "row_delay": float(k)} for k in places})
    off = rows.values / rows.standard_uncertainties
    earliest = int(np.argmin(off))
    if off[earliest] >= 0:
        return ()
    return (
        Finding(
            code="rows-read-before-trigger",
            severity="doubt" if off[earliest] < -_CONTRADICTS else "warning",
            what=f"rows would be read before the trigger, row {earliest} at {1e3 * rows.values[earliest]:.3f} ms (u = "
            f"{1e3 * rows.standard_uncertainties[earliest]:.3f} ms)",
            cure="check frame_number, [beams] whole_slots_between, [mask] centre_angle_deg, trigger_delay_time_set, the "
            "trigger's edge, and that application_slot holds edges 0 and 2",
        ),
    )


_OF_TRIGGERS = ("rows-read-before-trigger", "delay-negative")


def of_events(findings: Sequence[Finding], recordings: Sequence[ReducedRecording]) -> tuple[Finding, ...]:
    """The same without those that a camera that runs free gives no reason for: it may well expose before its strobe or stamp.

    Parameters
    ----------
    findings
        About the result.
    recordings
        That it is of.
    """
    runs_free = recordings[0].events is not None
    return tuple(one for one in findings if not (runs_free and one.code in _OF_TRIGGERS))


def of_next_trigger(result: Result, *, recordings: Sequence[ReducedRecording]) -> tuple[Finding, ...]:
    """Where the first row is read when the next trigger has already come.

    A camera may do so, but then nothing in the frames says which trigger made them: a camera that missed its first trigger, or a
    frame number that is one off, looks the same. The bound is the shortest time between two triggers.

    Parameters
    ----------
    result
        Of the delays.
    recordings
        With their triggers, and the rows of their images.
    """
    name = next((name for name in ("trigger_delay", "exposure_midpoint_delay") if name in result.estimate), None)
    triggers = [one for one in recordings if one.trigger_ticks.size > 1 and one.events is None]
    if name is None or not triggers:
        return ()
    period_s = min(float(np.diff(one.trigger_ticks).min()) / one.track.clock_frequency_hz for one in triggers)
    n_rows, row_s = recordings[0].opening.mask.shape[0], 0.0
    if "row_delay" in result.estimate:
        row_s = result.estimate.value("row_delay")
    earliest_s = result.estimate.value(name) + min(0.0, (n_rows - 1) * row_s)
    if earliest_s < period_s:
        return ()
    return (
        Finding(
            code="delay-beyond-next-trigger",
            severity="doubt",
            what=f"the first row is read {1e3 * earliest_s:.3f} ms after its trigger, but the next trigger comes after "
            f"{1e3 * period_s:.3f} ms: frames may belong to another trigger, and the delay be whole frame periods off",
            cure="check frame_number, and that application_slot holds edges 0 and 2; the camera's own time stamps, or a trigger "
            "left out on purpose, prove which trigger made which frame",
        ),
    )


def of_angles(joint: JointFit) -> tuple[Finding, ...]:
    """Where several wheel speeds find the edges' common angle far from where rig.toml allows it.

    Parameters
    ----------
    joint
        Its angles, and what was known of them.
    """
    angles = joint.prior.pick(*(name for name in joint.prior.names if name.startswith("edge_angle")))
    found = float(np.mean([joint.parameters.value(name) for name in angles.names]))
    allowed = float(np.sqrt(angles.covariance.mean()))
    if abs(found) <= _CONTRADICTS * allowed:
        return ()
    return (
        Finding(
            code="speeds-contradict-rig",
            severity="doubt",
            what=f"the wheel speeds agree on edges that come {1e3 * found:+.2f} mrad early, rig.toml allows u = "
            f"{1e3 * allowed:.2f} mrad",
            cure="check [mask] centre_angle_deg, [beams], and that trigger and gates are stamped at the right edge",
        ),
    )


def of_start(joint: JointFit) -> tuple[Finding, ...]:
    """Where a search that does not begin at the recordings' own estimates stayed where it began.

    Parameters
    ----------
    joint
        The joint fit.
    """
    if joint.parameters.value("delay") != joint.start["delay"]:
        return ()
    return (
        Finding(
            code="start-not-left",
            severity="warning",
            what="the joint fit did not leave its start value: nothing in the recordings moved it",
        ),
    )


def of_joint(joint: JointFit) -> tuple[Finding, ...]:
    """Where the joint fit did not settle, or left residuals that are not white.

    Parameters
    ----------
    joint
        The joint fit.
    """
    doubts, white = [], joint.whiteness
    if joint.decrement > 1:
        doubts.append(
            Finding(
                code="minimum-not-reached",
                severity="warning",
                what=f"the joint fit ended {joint.decrement:.1f} standard uncertainties from its minimum after {joint.n_steps} "
                "evaluations",
                cure="analyse the recordings apart to see which differs",
            )
        )
    if np.any(white < LEAST_WHITENESS):
        doubts.append(
            Finding(
                code="residuals-not-white",
                severity="warning",
                what=f"residuals of {int(np.sum(white < LEAST_WHITENESS))} of {counted(white.size, 'recording')} are not white "
                f"along the wheel angle (smallest probability {white.min():.1g})",
                cure="their uncertainty is widened for it",
            )
        )
    return tuple(doubts)


def of_pixel_fits(fits: Sequence[EdgeDelayFit]) -> tuple[Finding, ...]:
    """Frames that were left out, what levels do, and residuals that are correlated.

    Parameters
    ----------
    fits
        One per recording.
    """
    left_out = [
        Finding(
            code="frames-wild",
            severity="warning",
            recording=fit.name,
            what=f"{counted(fit.n_dropped, 'frame')} left out: outlying, or at the ends of the recording",
        )
        for fit in fits
        if fit.n_dropped
    ]
    inflations = [fit.variance_inflation**0.5 for fit in fits if fit.variance_inflation > _CORRELATED]
    if not inflations:
        return (*left_out, *of_levels(fits))
    return (
        *left_out,
        *of_levels(fits),
        Finding(
            code="residuals-correlated",
            severity="warning",
            what=f"residuals of {len(inflations)} of {counted(len(fits), 'recording')} are correlated along the wheel angle: the "
            "rig differs from the model by more than noise (figure of the residuals)",
            cure=f"their uncertainty was widened by up to {max(inflations):.1f}",
        ),
    )


def of_levels(fits: Sequence[EdgeDelayFit]) -> tuple[Finding, ...]:
    """What the levels of photon cameras do beyond a straight line: it is fitted, and costs next to nothing.

    Parameters
    ----------
    fits
        One per recording.
    """
    found = []
    for fit in fits:
        levels = fit.levels
        if levels is not None and levels.jumps:
            what = (
                f"the levels jump at {counted(len(levels.jumps), 'frame')}, as they do where a camera corrects itself"
            )
            cure = "each stretch has levels of its own; switch the camera's own correction off"
            found.append(Finding(code="levels-jump", severity="info", recording=fit.name, what=what, cure=cure))
        elif levels is not None and levels.sway > _SWAY:
            what = f"the levels sway by {levels.sway:.1%} of the contrast; {levels.n_numbers} numbers take it out"
            found.append(Finding(code="levels-sway", severity="info", recording=fit.name, what=what))
        found += _of_blades(fit.name, fit.blades, u=fit.u_blades)
    return tuple(found)


def _of_blades(recording: str, share: float, *, u: float) -> list[Finding]:
    """Where one blade is warmer beyond doubt, as a share of the contrast."""
    if abs(share) <= max(_CONTRADICTS * u, _BLADES):
        return []
    warmer = f"one blade of the wheel looks {abs(share):.2%} of the contrast warmer than the other: it is fitted"
    return [Finding(code="blades-differ", severity="info", recording=recording, what=warmer)]


def of_row_fits(fits: Sequence[RowTimingFit]) -> tuple[Finding, ...]:
    """Residuals that are correlated, and blades that differ.

    Parameters
    ----------
    fits
        One per recording.
    """
    doubts = []
    inflations = [fit.variance_inflation**0.5 for fit in fits if fit.variance_inflation > _CORRELATED_ROWS]
    if inflations:
        doubts.append(
            Finding(
                code="row-residuals-correlated",
                severity="warning",
                what=f"residuals of {len(inflations)} of {counted(len(fits), 'recording')} are correlated: the rig differs from "
                "the model by more than noise (figure of the residuals)",
                cure=f"their uncertainty was widened by up to {max(inflations):.1f}",
            )
        )
    for fit in fits:
        if BLADE in fit.estimate:
            doubts += _of_blades(fit.name, fit.estimate.value(BLADE), u=fit.estimate.u(BLADE))
    return tuple(doubts)


def of_mixture(effective: EffectiveTimeConstants | None) -> tuple[Finding, ...]:
    """Where the time constants before several blackbodies differ by more than chance.

    Parameters
    ----------
    effective
        One per blackbody temperature.
    """
    if effective is None or effective.time_constant_s.size < 2:
        return ()
    tau, kelvin = effective.time_constant_s, effective.blackbody_temperature_k
    weights = inverse(effective.covariance_s2).sum(axis=0)
    apart = tau - weights @ tau / weights.sum()
    if special.chdtrc(tau.size - 1, float(apart @ np.linalg.solve(effective.covariance_s2, apart))) > _SIGNIFICANCE:
        return ()
    return (
        Finding(
            code="lag-depends-on-blackbody",
            severity="warning",
            what=f"the time constant changes with the blackbody, from {1e3 * tau[0]:.4f} ms at {kelvin[0]:.1f} K to "
            f"{1e3 * tau[-1]:.4f} ms at {kelvin[-1]:.1f} K: time_constant is an effective one, a mean over these recordings "
            "(--substrate-temperature separates the constants of substrate and scene)",
        ),
    )

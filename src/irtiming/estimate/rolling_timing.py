r"""From the fits of all recordings to trigger delay, time constant and row delay, with one covariance.

Each recording f gives six numbers with correlated noise: four edge delays d_fi, tau_f and t_row,f. They differ from the
camera's own by

    d_fi = t_delay + (e + e_i) / omega_f + ...        tau_f = tau + ...        t_row,f = t_row + ...

where the angle errors e (mask, gates, slots) and e_i (cutout edge i) are common to all recordings, as are the errors of the
opening's shape in the image. All numbers are combined by generalised least squares with just this covariance, so that
several wheel speeds separate delays from angles by themselves.

A warmer pixel is faster (`response.two_constants`): each blackbody temperature has a tau of its own, and so has it a sector, for
plate and wheel differ from it in contrast. Of several taus the mean is told, and they themselves in `EffectiveTimeConstants`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import stats

from irtiming.estimate import by_blackbody, rig_wide
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate, RelativeDelay
from irtiming.records.rolling_result import Bound, EffectiveTimeConstants, RollingContribution, RollingResult
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry

NAMES = ("trigger_delay", "time_constant", "row_delay")
_RUNS_THAT_TELL = 4
_UNDETERMINED = 0.25  # relative standard uncertainty of tau from which it is no number any more
_SHORTEST_LAG_S = 0.5e-3  # of any microbolometer: an uncertainty below it would have shown the lag
_SUSPICIOUS = 2.0
_DISAGREE = 4.0  # standard uncertainties
_NOISE = "noise of the frames"
_PARAMETERS_OF_A_ROW = 6  # fitted to each row of all frames
_BY_CHANCE = 0.003  # time constants that differ as much by chance are taken for one


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Parts:
    """Six numbers of each fit in a row, shape (6 n,), and the parts of their covariance: source, kind, (6 n, 6 n)."""

    values: Array
    parts: tuple[tuple[str, str, Array], ...]

    @property
    def total(self) -> Array:
        return np.asarray(np.sum([part for _, _, part in self.parts], axis=0))


def estimate(
    fits: Sequence[RowTimingFit], geometry: WheelGeometry, *, sectors: Sequence[SectorFit], n_rows: int
) -> RollingResult:
    """Combine the fits.

    Parameters
    ----------
    fits
        One per recording.
    geometry
        Wheel model that the fits used, and the uncertainties of its angles.
    sectors
        The opening in the image that each fit used; the uncertainty of one is common to all fits that used it.
    n_rows
        Rows of the image: the last is read ``(n_rows - 1) row_delay`` after the first.
    """
    u_edge = rig_wide.edge_uncertainty(fits, geometry)
    told = _parts(fits, geometry, sectors=sectors, u_edge_rad=u_edge)
    groups = _by_blackbody(fits)
    each, mix = _each_and_mix(told, groups)
    weights = mix @ each
    values, covariance = weights @ told.values, weights @ told.total @ weights.T
    frames = float(sum(fit.wheel_angle_rad.size - _PARAMETERS_OF_A_ROW for fit in fits))
    budget = tuple(
        RollingContribution(
            source=source,
            kind=kind,
            degrees_of_freedom=frames if source == _NOISE else np.inf,
            **_three(np.sqrt(np.maximum(np.diag(weights @ part @ weights.T), 0))),
        )
        for source, kind, part in told.parts
    )
    keep, bounds, undetermined = _determined(values, covariance)
    effective = _effective(fits, groups, each=each[2:], told=told)
    noise = np.sqrt(np.mean([fit.estimate.standard_uncertainties[:4] ** 2 for fit in fits], axis=0) / len(fits))
    return RollingResult(
        method="row-sum",
        estimate=Estimate(
            names=tuple(NAMES[k] for k in keep), units=("s",) * len(keep), values=values[keep],
            covariance=covariance[np.ix_(keep, keep)],
        ),
        relative_delays=_relative(fits, told),
        budget=budget,
        edge_delay_s=np.mean([fit.edge_delay_s for fit in fits], axis=0),
        u_edge_delay_s=noise,
        bounds=bounds,
        warnings=geometry.warnings + undetermined + _doubts(values, u_edge, n_rows=n_rows)
        + _remarks(fits, sectors[0]) + _mixture(effective),
        effective=effective,
    )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Structure:
    """What the six numbers of each fit are made of, were nothing in error.

    ``design`` (n_fit, 6, k) makes them from delay, row delay, and what each blackbody has of its own; ``mix`` (3, k) makes
    trigger delay, mean time constant and row delay from the same. ``factor`` (n_fit,) is by how much the variances of each
    fit are larger than those of its own white residuals, on the mean.
    """

    design: Array
    mix: Array
    factor: Array


def structure(fits: Sequence[RowTimingFit], geometry: WheelGeometry, *, sectors: Sequence[SectorFit]) -> Structure:
    """The same recordings and sectors as for `estimate`."""
    groups = _by_blackbody(fits)
    told = _parts(fits, geometry, sectors=sectors, u_edge_rad=rig_wide.edge_uncertainty(fits, geometry))
    _, mix = _each_and_mix(told, groups)
    design = _design(groups, own_delays=False).reshape(len(fits), 6, -1)
    return Structure(
        design=design,
        mix=np.hstack([mix, np.zeros((3, design.shape[2] - mix.shape[1]))]),
        factor=np.array([fit.widening for fit in fits]) * _run_to_run(fits),
    )


def _each_and_mix(told: _Parts, groups: list[list[int]]) -> tuple[Array, Array]:
    """Weights (2 + k, 6 n) of delay, row delay and the tau of each of k groups; and what makes the three numbers of them."""
    each = _weights(told.total, _design(groups, own_delays=False))[: 2 + len(groups)]
    return each, _one_time_constant(each, each @ told.total @ each.T)


_PARAMETER_OF = np.array([[1, 0, 0]] * 4 + [[0, 1, 0], [0, 0, 1]], float)


def _by_blackbody(fits: Sequence[RowTimingFit]) -> list[list[int]]:
    return by_blackbody.groups(
        [fit.blackbody_temperature_k for fit in fits], is_colder=[bool(np.median(fit.gain_dn) < 0) for fit in fits]
    )


def _design(groups: list[list[int]], *, own_delays: bool) -> Array:
    """What each number of each fit is made of, shape (6 n, ...): delay, one or one per fit; row delay; tau of each group.

    Of several groups also by how much edges that uncover are later than those that cover: a pixel that is faster when it is
    warm warms later and cools earlier than the one time constant says.
    """
    n, n_groups = sum(map(len, groups)), len(groups)
    n_delays = n if own_delays else 1
    design = np.zeros((6 * n, n_delays + 1 + n_groups * (2 if n_groups > 1 else 1)))
    for g, members in enumerate(groups):
        for k in members:
            design[6 * k : 6 * k + 4, k if own_delays else 0] = 1
            design[6 * k + 4, n_delays + 1 + g] = design[6 * k + 5, n_delays] = 1
            if n_groups > 1:
                design[6 * k : 6 * k + 4, n_delays + 1 + n_groups + g] = [-1, 1, -1, 1]
    return design


def _one_time_constant(each: Array, covariance: Array) -> Array:
    """Delay, mean tau and row delay from delay, row delay and all taus; shape (3, 2 + k)."""
    n_tau = len(each) - 2
    mix = np.zeros((3, 2 + n_tau))
    mix[0, 0] = mix[2, 1] = 1
    mix[1, 2:] = _weights(covariance[2:, 2:], np.ones((n_tau, 1)))[0]
    return mix


def _effective(
    fits: Sequence[RowTimingFit], groups: list[list[int]], *, each: Array, told: _Parts
) -> EffectiveTimeConstants | None:
    """The taus, coldest blackbody first; ``each`` (k, 6 n) makes them from the six numbers of the fits."""
    found = [
        [kelvin for kelvin in (fits[k].blackbody_temperature_k for k in members) if kelvin is not None]
        for members in groups
    ]
    if not all(found):
        return None
    temperature_k = np.array([np.mean(kelvins) for kelvins in found])
    order = np.argsort(temperature_k)
    contrast = np.array([np.mean([fits[k].gain_dn.mean() for k in members]) for members in groups])
    weights = each[order]
    return EffectiveTimeConstants(
        blackbody_temperature_k=temperature_k[order],
        time_constant_s=weights @ told.values,
        covariance_s2=weights @ told.total @ weights.T,
        contrast_dn=contrast[order],
    )


def _mixture(effective: EffectiveTimeConstants | None) -> tuple[str, ...]:
    """A warning where the taus differ by more than chance."""
    if effective is None or effective.time_constant_s.size < 2:
        return ()
    tau, kelvin = effective.time_constant_s, effective.blackbody_temperature_k
    mean = _weights(effective.covariance_s2, np.ones((tau.size, 1)))[0] @ tau
    chi_square = float((tau - mean) @ np.linalg.solve(effective.covariance_s2, tau - mean))
    if stats.chi2.sf(chi_square, tau.size - 1) > _BY_CHANCE:
        return ()
    return (
        f"the time constant changes with the blackbody, from {1e3 * tau[0]:.4f} ms at {kelvin[0]:.1f} K to "
        f"{1e3 * tau[-1]:.4f} ms at {kelvin[-1]:.1f} K: time_constant is an effective one, a mean over these recordings "
        "(--substrate-temperature separates the constants of substrate and scene)",
    )


def _three(numbers: Array) -> dict[str, float]:
    return {f"{name}_s": float(number) for name, number in zip(NAMES, numbers, strict=True)}


def _parts(
    fits: Sequence[RowTimingFit], geometry: WheelGeometry, *, sectors: Sequence[SectorFit], u_edge_rad: float
) -> _Parts:
    n = 6 * len(fits)
    is_edge = np.tile([1.0, 1, 1, 1, 0, 0], len(fits))
    per_rad = is_edge * np.repeat([1 / fit.angular_frequency_rad_per_s for fit in fits], 6)
    noise = np.zeros((n, n))
    for k, (fit, factor) in enumerate(zip(fits, _run_to_run(fits), strict=True)):
        noise[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = fit.estimate.covariance * factor
    shape = np.zeros((n, n))
    for sector in {id(sector): sector for sector in sectors}.values():
        effect = np.concatenate([fit.shape_effect * (own is sector) for fit, own in zip(fits, sectors, strict=True)])
        shape += effect @ sector.covariance @ effect.T
    same_edge = np.equal.outer(np.arange(n) % 6, np.arange(n) % 6)
    edges = u_edge_rad**2 * np.outer(per_rad, per_rad) * same_edge
    parts: list[tuple[str, str, Array]] = [
        (_NOISE, "A", noise),
        ("axle, mask and blur in the image", "A", shape),
        ("cutout edges", "A" if geometry.u_edge_rad is None else "B", edges),
    ]
    parts += [(source, kind, u**2 * np.outer(per_rad, per_rad)) for source, kind, u in geometry.angle_budget]
    return _Parts(values=np.concatenate([_six(fit) for fit in fits]), parts=tuple(parts))


def _six(fit: RowTimingFit) -> Array:
    return fit.estimate.values


def _weights(total: Array, design: Array) -> Array:
    """Weights of generalised least squares, shape (k, n): their product with the values is the estimate."""
    scale = np.sqrt(np.diag(total))
    scaled = total / np.outer(scale, scale) + 1e-12 * np.eye(
        len(total)
    )  # a recording given twice has no noise of its own
    through = np.linalg.solve(scaled, design / scale[:, None])
    return np.linalg.solve((design / scale[:, None]).T @ through, through.T) / scale


def _determined(values: Array, covariance: Array) -> tuple[list[int], tuple[Bound, ...], tuple[str, ...]]:
    """Which of the three are numbers; bounds and a warning for the others."""
    u = np.sqrt(np.diag(covariance))
    if u[1] < _UNDETERMINED * values[1]:
        return [0, 1, 2], (), ()
    if u[1] < _SHORTEST_LAG_S:
        text = (
            f"no thermal lag is seen: the time constant is {1e3 * values[1]:.3f} ms with u = {1e3 * u[1]:.3f} ms (k = 1), a "
            "microbolometer has some ms; if this is a photon camera, its recording must say so (camera type photon)"
        )
        longest = Bound(name="time_constant", lower_s=0.0, upper_s=max(0.0, float(values[1])) + 2 * float(u[1]))
        return [0, 2], (longest,), (text,)
    lowest, highest = max(0.0, float(values[1] - 2 * u[1])), float(values[1] + 2 * u[1])
    bounds = (
        Bound(name="time_constant", lower_s=lowest, upper_s=highest),
        Bound(name="trigger_delay", lower_s=float(values[0] - 2 * u[0]), upper_s=float(values[0] + 2 * u[0])),
    )
    text = (
        f"the time constant is not determined (u = {1e3 * u[1]:.3g} ms, k = 1): the plateaus are too short or too noisy to "
        f"tell a lag from a delay; it lies between {1e3 * lowest:.3g} and {1e3 * highest:.3g} ms (2 u), the trigger delay "
        f"between {1e3 * (values[0] - 2 * u[0]):.3g} and {1e3 * (values[0] + 2 * u[0]):.3g} ms; record longer or with more "
        "contrast"
    )
    return [2], bounds, (text,)


def _relative(fits: Sequence[RowTimingFit], told: _Parts) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus the mean of those with the smallest set delay; one t_row for all, one tau per blackbody."""
    weights = _weights(told.total, _design(_by_blackbody(fits), own_delays=True))[: len(fits)]
    return rig_wide.relative_delays(fits, weights, values=told.values, total=told.total)


def _birge_ratio(group: list[RowTimingFit]) -> float:
    """Scatter of delay, tau and row delay over recordings at one speed, over what their own noise explains."""
    three = np.array([_PARAMETER_OF.T @ _six(fit) / [4, 1, 1] for fit in group])
    mix = _PARAMETER_OF.T / np.array([[4], [1], [1]])
    inverses = np.array([np.linalg.inv(mix @ fit.estimate.covariance @ mix.T) for fit in group])
    mean = np.linalg.solve(inverses.sum(axis=0), np.einsum("fij,fj->i", inverses, three))
    apart = three - mean
    return float(np.sqrt(np.einsum("fi,fij,fj->", apart, inverses, apart) / (3 * (len(group) - 1))))


def _alike(fits: Sequence[RowTimingFit]) -> list[tuple[float, list[int]]]:
    """Wheel rate in Hz and the indices of the fits of one rate and blackbody, for each such pair."""
    groups = _by_blackbody(fits)
    return [
        (speed, both)
        for speed, members in rig_wide.by_speed(fits)
        for group in groups
        if (both := [k for k in members if k in group])
    ]


def _run_to_run(fits: Sequence[RowTimingFit]) -> Array:
    """Factor on the noise covariance of each fit, shape (n_fit,): the Birge ratio squared where it exceeds 1."""
    factor = np.ones(len(fits))
    for _, members in _alike(fits):
        if len(members) >= _RUNS_THAT_TELL:
            factor[members] = max(1.0, _birge_ratio([fits[k] for k in members]) ** 2)
    return factor


def _doubts(values: Array, u_edge_rad: float, *, n_rows: int) -> tuple[str, ...]:
    doubts = []
    latest = max(values[0], values[0] + (n_rows - 1) * values[2])
    if latest < 0:
        doubts.append(
            f"every row would be read before the trigger (the last at {1e3 * latest:.3f} ms); check [beams] whole_slots_between, "
            "[mask] centre_angle_deg and the trigger's edge"
        )
    return (*doubts, *rig_wide.edge_doubts(u_edge_rad))


def _remarks(fits: Sequence[RowTimingFit], sector: SectorFit) -> tuple[str, ...]:
    """Doubts about the fits: correlated residuals, recordings that disagree, a row delay that the image contradicts."""
    remarks = []
    widened = [fit.widening**0.5 for fit in fits if fit.widening > _SUSPICIOUS**2]
    if widened:
        remarks.append(
            f"residuals of {len(widened)} of {len(fits)} recordings are correlated: the rig differs from the model by more than "
            f"noise (figure of the residuals); their uncertainty was widened by up to {max(widened):.1f}"
        )
    row_delay = float(np.mean([fit.row_delay_s for fit in fits]))
    u = float(np.hypot(sector.u_row_delay_s, np.sqrt(np.mean([fit.estimate.u("row_delay") ** 2 for fit in fits]))))
    if abs(row_delay - sector.row_delay_s) > _DISAGREE * u:
        remarks.append(
            f"row delay by the row sums {1e6 * row_delay:.3f} us, by the phases of the pixels {1e6 * sector.row_delay_s:.3f} us: "
            f"they differ by {abs(row_delay - sector.row_delay_s) / u:.1f} u; lens distortion or a moved camera may be the cause"
        )
    for speed, members in _alike(fits):
        if len(members) < 2:
            continue
        birge = _birge_ratio([fits[k] for k in members])
        if birge > 1 + _SUSPICIOUS / np.sqrt(6 * (len(members) - 1)):
            remarks.append(
                f"{len(members)} recordings at {speed:.4g} Hz scatter {birge:.2f} times more than their noise explains "
                "(Birge ratio); something changed between them"
            )
    return tuple(remarks)

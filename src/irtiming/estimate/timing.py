"""The project's own method, for every camera: fits of single recordings, one likelihood over all, and what is reported of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import (
    by_blackbody,
    doubts,
    joint,
    measurands,
    pixel_sums,
    rolling_camera,
    scatter,
    shared_numbers,
    shared_residual,
    wheel_geometry,
)
from irtiming.estimate.joint import Joint, LocalModel, Measurand
from irtiming.estimate.measurands import LAG, WINDOW, Reported, Window
from irtiming.estimate.pixel_sums import SHAPE
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.inference.correlated_noise import ljung_box_p_value
from irtiming.inference.optimiser import Linearised, Model
from irtiming.physics.camera import camera
from irtiming.physics.light import row_sum
from irtiming.physics.wheel import TURN
from irtiming.records.analysis import Fits
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, RecordingFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import EffectiveTimeConstants, JointFit, RelativeDelay, Result
from irtiming.records.rig import Rig
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry

if TYPE_CHECKING:
    from irtiming.records.arrays import Array

_SPEED_RATIO = 1.2  # of the wheel, from which it tells a window from mask edges that round the corners as well
_CORNER_RAD = 4.5e-3  # what rounds the corners besides the window and is not in the model, as simulated rigs showed
_WINDOW_SHARE = 0.02  # of its length: by how much windows came out wrong on simulated rigs, cause unknown
_UNKNOWN_WINDOW_S = 0.1  # standard uncertainty of a window that no frame tells anything of
_LEAST_U_LEAN_RAD = 1e-5


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Timing:
    """Result, and what led to it: recordings (which now know the axle), geometry, sectors, fits, and the joint fit.

    ``exact`` are models of the recordings where ``joint`` takes parabolas; the same where it takes none. ``profiled`` are the
    parameters of the result that are one sum of shared numbers.
    """

    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    sectors: tuple[SectorFit, ...]
    fits: Fits
    joint: Joint
    exact: tuple[LocalModel, ...]
    profiled: tuple[Measurand, ...]
    joint_fit: JointFit
    result: Result


def estimate(recordings: Sequence[ReducedRecording], rig: Rig) -> Timing:
    """Timing of the camera that made the recordings.

    Parameters
    ----------
    recordings
        Of one camera on one rig; one or more, of any set delays and wheel speeds.
    rig
        As measured by its owner.

    Raises
    ------
    EstimationError
        If the recordings do not determine the timing, or cannot be those of one camera.
    GeometryError
        If the rig's numbers contradict each other.
    """
    return _of_row_sums(recordings, rig) if recordings[0].pixels is None else _of_pixel_sums(recordings, rig)


def _of_pixel_sums(recordings: Sequence[ReducedRecording], rig: Rig) -> Timing:
    geometry = wheel_geometry.geometry(recordings, rig, slots="learned", off_axle_mask=True)
    fits = tuple(pixel_sums.fit(one, geometry.model) for one in recordings)
    residual = shared_residual.split(fits)
    groups = scatter.alike(fits, [range(len(fits))])
    factor = residual.own_share * scatter.run_to_run(fits, groups)
    models = tuple(
        _model(one, fit, geometry, factor=float(scale))
        for one, fit, scale in zip(recordings, fits, factor, strict=True)
    )
    u_edge = scatter.edge_uncertainty(fits, geometry)
    shared = [
        *_opening_and_window(recordings, fits, geometry),
        *shared_numbers.rig_errors(fits, geometry, u_edge_rad=u_edge, residuals_rad2=residual.shared_rad2),
    ]
    found = joint.fit(models, shared)
    fastest, slowest = (pick(fit.angular_frequency_rad_per_s for fit in fits) for pick in (max, min))
    alone = found.estimate([Measurand(name=WINDOW, weights={WINDOW: 1.0})])
    unknown_s = _CORNER_RAD**2 / (2 * max(abs(alone.value(WINDOW)), alone.u(WINDOW)) * fastest**2)
    window = Window(
        stated_s=common_integration_time(recordings),
        u_beside_s=float(np.hypot(unknown_s, _WINDOW_SHARE * alone.value(WINDOW))),
        is_told=fastest > _SPEED_RATIO * slowest,
    )
    freedom = float(sum(fit.residual.size - len(EDGE_DELAYS) - 1 - pixel_sums.N_OWN for fit in fits))
    reported = measurands.of_window(found, window, degrees_of_freedom=freedom)
    record = _record(
        found, fits, whiteness=[ljung_box_p_value(fit.residual) for fit in fits],
        n_residuals=sum(fit.residual.size - 1 - pixel_sums.N_OWN for fit in fits), u_edge_rad=u_edge,
    )  # fmt: skip
    result = _result(found, fits, reported=reported, recordings=recordings)
    findings = (
        *geometry.findings, *doubts.of_window(result.estimate), *doubts.of_edges(u_edge), *reported.findings,
        *doubts.of_angles(record), *doubts.of_pixel_fits(fits), *scatter.birge_findings(fits, groups), *doubts.of_joint(record),
    )  # fmt: skip
    return Timing(
        recordings=tuple(recordings), geometry=geometry, sectors=(), fits=fits, joint=found, exact=models,
        profiled=reported.profiled, joint_fit=record,
        result=replace(result, findings=findings),
    )  # fmt: skip


def _model(one: ReducedRecording, fit: EdgeDelayFit, geometry: WheelGeometry, *, factor: float) -> LocalModel:
    """Frames that the recording's own fit kept, with its noise, widened for all that makes frames less than independent."""
    noise = fit.noise * float(np.sqrt(fit.widening * factor)) * abs(fit.step)
    given = replace(pixel_sums.pixel_sums(one, geometry.model), kept=fit.kept, noise=noise)
    return LocalModel(names=(*EDGE_DELAYS, *SHAPE), at=given.at)


def _opening_and_window(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], geometry: WheelGeometry
) -> list[SharedNumber]:
    """Delay, opening, window and leans, beginning at the earliest recording, rig.toml, one sample, and the images."""
    clockwise = geometry.rotation == "clockwise"
    seen = [pixel_sums.leans_in_image(one, turns_clockwise=clockwise) for one in recordings]
    leans = np.mean([lean for lean, _ in seen], axis=0)
    u_lean = max(_LEAST_U_LEAN_RAD, float(np.mean([u for _, u in seen])))
    sample_s = min(
        TURN / one.samples_per_turn / fit.angular_frequency_rad_per_s for one, fit in zip(recordings, fits, strict=True)
    )
    middle_s = min(float(np.mean([fit.estimate.value(name) for name in EDGE_DELAYS])) for fit in fits)
    return [
        shared_numbers.delay(fits, start=middle_s),
        shared_numbers.same("opening_angle", fits, unit="rad", start=geometry.model.opening_angle_rad),
        shared_numbers.same(WINDOW, fits, start=sample_s, prior=(sample_s, _UNKNOWN_WINDOW_S)),
        *(
            shared_numbers.same(name, fits, unit="rad", start=float(lean), prior=(float(lean), u_lean))
            for name, lean in zip(("lean_low", "lean_high"), leans, strict=True)
        ),
    ]


def _of_row_sums(recordings: Sequence[ReducedRecording], rig: Rig) -> Timing:
    rows = rolling_camera.rows(recordings, rig)
    fits, blackbodies = rows.fits, _blackbodies(rows.recordings)
    groups = scatter.alike(fits, blackbodies)
    factor = scatter.run_to_run(fits, groups)
    u_edge = scatter.edge_uncertainty(fits, rows.geometry)
    first = min(fits, key=lambda fit: float(np.mean(fit.edge_delay_s)))
    shared = [
        shared_numbers.delay(fits, start=float(np.mean(first.edge_delay_s))),
        *_of_camera(fits, first, blackbodies=blackbodies),
        *shared_numbers.rig_errors(fits, rows.geometry, u_edge_rad=u_edge, residuals_rad2=np.zeros((4, 4))),
        *shared_numbers.image_errors(fits, rows.sectors),
    ]
    models = tuple(joint.parabola(fit.estimate, factor=float(scale)) for fit, scale in zip(fits, factor, strict=True))
    names = row_sum.timing_names(camera(recordings[0].camera_type, recordings[0].readout_mode))
    exact = tuple(
        _exact(fit, model, names=names, factor=float(scale) * fit.widening)
        for fit, model, scale in zip(fits, rows.likelihoods, factor, strict=True)
    )
    found = joint.fit(models, shared)
    freedom = float(sum(fit.wheel_angle_rad.size - len(fit.estimate.names) for fit in fits))
    constants = [one.name for one in shared if one.name.startswith(LAG)]
    if constants:
        reported = measurands.of_lag(found, constants, degrees_of_freedom=freedom)
    else:
        window = Window(stated_s=common_integration_time(recordings), u_beside_s=0.0, is_told=True)
        reported = measurands.of_window(found, window, degrees_of_freedom=freedom)
    record = _record(
        found, fits, whiteness=[_whiteness(fit) for fit in fits],
        n_residuals=sum(len(fit.estimate.names) for fit in fits), u_edge_rad=u_edge,
    )  # fmt: skip
    result = _result(found, fits, reported=reported, recordings=recordings)
    effective = _effective(found, fits, blackbodies=blackbodies, constants=constants)
    findings = (
        *rows.geometry.findings, *reported.findings,
        *doubts.of_reading(result.estimate, n_rows=recordings[0].opening.mask.shape[0]), *doubts.of_edges(u_edge),
        *doubts.of_row_fits(fits, rows.sectors[0]), *scatter.birge_findings(fits, groups), *doubts.of_mixture(effective),
        *doubts.of_joint(record),
    )  # fmt: skip
    return Timing(
        recordings=rows.recordings, geometry=rows.geometry, sectors=rows.sectors, fits=fits, joint=found, exact=exact,
        profiled=reported.profiled, joint_fit=record, result=replace(result, findings=findings, effective=effective),
    )  # fmt: skip


def _exact(fit: RowTimingFit, model: Model, *, names: tuple[str, ...], factor: float) -> LocalModel:
    """The rows' own likelihood over the numbers that were fitted, its variances that much larger than white residuals have."""
    columns, spread = [names.index(name) for name in fit.estimate.names], float(np.sqrt(factor))

    def at(numbers: Mapping[str, float]) -> Linearised:
        there = model({name: numbers.get(name, fit.timing[name]) for name in names})
        return Linearised(residual=there.residual / spread, jacobian=there.jacobian[:, columns] / spread)

    return LocalModel(names=fit.estimate.names, at=at)


def _of_camera(
    fits: Sequence[RowTimingFit], first: RowTimingFit, *, blackbodies: Sequence[Sequence[int]]
) -> list[SharedNumber]:
    """What response and readout have: of a lag one time constant per blackbody, since a pixel is faster the warmer it gets.

    Of several also by how much edges that uncover are later than those that cover: a pixel that is faster when it is warm warms
    later and cools earlier than the one time constant says.
    """
    names = list(dict.fromkeys(name for fit in fits for name in fit.estimate.names if name not in EDGE_DELAYS))
    several = len(blackbodies) > 1 and LAG in names
    found = [
        shared_numbers.same(name, fits, start=first.estimate.value(name))
        for name in names
        if name != LAG or not several
    ]
    if not several:
        return found
    sense = dict(zip(EDGE_DELAYS, (-1.0, 1.0, -1.0, 1.0), strict=True))
    for g, members in enumerate(blackbodies):
        for name, effect, start in ((LAG, {LAG: 1.0}, first.timing[LAG]), ("uncovering_later", sense, 0.0)):
            effects = [effect if k in members else {} for k in range(len(fits))]
            found.append(SharedNumber(name=f"{name} of blackbody {g}", effects=effects, start=start))
    return found


def _record(
    found: Joint, fits: Sequence[RecordingFit], *, whiteness: Sequence[float], n_residuals: int, u_edge_rad: float
) -> JointFit:
    own = [one for one in found.shared if one.unit != "1"]
    angles = measurands.edge_angles(found, fits[0].angular_frequency_rad_per_s)
    every = [Measurand(name=one.name, unit=one.unit, weights={one.name: 1.0}) for one in own]
    return JointFit(
        parameters=found.estimate([*every, *angles]),
        start={one.name: one.start for one in own} | {one.name: 0.0 for one in angles},
        prior=measurands.known_before(angles),
        u_edge_rad=u_edge_rad,
        reduced_chi_square=found.found.at.deviance / max(1, n_residuals),
        birge=joint.disagreement(found),
        whiteness=np.array(whiteness),
        n_steps=found.found.n_steps,
        decrement=found.found.decrement,
    )


def _result(found: Joint, fits: Fits, *, reported: Reported, recordings: Sequence[ReducedRecording]) -> Result:
    noise = np.sqrt(np.mean([np.diag(fit.estimate.covariance)[:4] for fit in fits], axis=0) / len(fits))
    return Result(
        method="row-sum" if recordings[0].pixels is None else "pixel-sum",
        estimate=reported.estimate,
        relative_delays=_relative_delays(found, fits, recordings=recordings),
        budget=reported.budget,
        edge_delay_s=np.mean([fit.edge_delay_s for fit in fits], axis=0),
        u_edge_delay_s=noise,
        bounds=reported.bounds,
    )


def _relative_delays(
    found: Joint, fits: Sequence[RecordingFit], *, recordings: Sequence[ReducedRecording]
) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus the mean of those with the smallest set delay, including what was set."""
    nominal = np.array([fit.trigger_delay_time_set_s for fit in fits])
    _, setting = np.unique(np.round(nominal, 9), return_inverse=True)
    each, covariance = joint.each_delay(found, setting.tolist())
    reference = np.isclose(nominal, nominal.min(), rtol=0, atol=1e-12)
    difference = np.eye(len(fits)) - reference / reference.sum()
    value, u = difference @ (each + nominal), np.sqrt(np.maximum(np.diag(difference @ covariance @ difference.T), 0))
    return tuple(
        RelativeDelay(
            file=one.source or one.name,
            nominal_s=float(nominal[k] - nominal.min()),
            value_s=float(value[k]),
            standard_uncertainty_s=float(u[k]),
        )
        for k, one in enumerate(recordings)
    )


def _effective(
    found: Joint, fits: Sequence[RowTimingFit], *, blackbodies: Sequence[Sequence[int]], constants: Sequence[str]
) -> EffectiveTimeConstants | None:
    """The time constants of the blackbodies, the coldest first; None where their temperatures are not known."""
    kelvins = [[fits[k].blackbody_temperature_k for k in members] for members in blackbodies]
    known = [[kelvin for kelvin in group if kelvin is not None] for group in kelvins]
    if not constants or not all(known):
        return None
    temperature_k = np.array([np.mean(group) for group in known])
    order = np.argsort(temperature_k)
    contrast = np.array([np.mean([fits[k].gain_dn.mean() for k in members]) for members in blackbodies])
    taus = found.estimate([Measurand(name=constants[k], weights={constants[k]: 1.0}) for k in order])
    return EffectiveTimeConstants(
        blackbody_temperature_k=temperature_k[order],
        time_constant_s=taus.values,
        covariance_s2=taus.covariance,
        contrast_dn=contrast[order],
    )


def _blackbodies(recordings: Sequence[ReducedRecording]) -> list[list[int]]:
    return by_blackbody.groups(
        [one.blackbody_temperature_k for one in recordings],
        is_colder=[one.opening.blackbody_is_colder for one in recordings],
    )


def _whiteness(fit: RowTimingFit) -> float:
    """Of the frames' mean residuals, each row in units of its noise, along the wheel angle."""
    mean: Array = np.mean(fit.residual / fit.noise, axis=1)
    return ljung_box_p_value(mean[np.argsort(np.mod(fit.wheel_angle_rad, TURN))])


def common_integration_time(recordings: Sequence[ReducedRecording]) -> float | None:
    """What all recordings state, s; None where they do not.

    Parameters
    ----------
    recordings
        Of one camera.

    Raises
    ------
    EstimationError
        If they differ.
    """
    times = {recording.integration_time_s for recording in recordings}
    if len(times) > 1:
        stated = ", ".join(f"{r.name}: {r.integration_time_s}" for r in recordings)
        raise EstimationError(
            f"the recordings differ in integration time (count_time; {stated} s), which must be one for all; analyse them apart"
        )
    return times.pop()

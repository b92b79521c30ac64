"""The project's own method, for every camera: fits of single recordings, one likelihood over all, and what is reported of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import (
    agreement,
    by_blackbody,
    doubts,
    frame_jitter,
    frame_memory,
    image_doubts,
    integration_time,
    joint,
    measurands,
    nonlinearity,
    on_trust,
    own_noise,
    pixel_numbers,
    pixel_sums,
    reference_noise,
    relative_delays,
    rig_errors,
    rivals,
    rolling_camera,
    row_numbers,
    scatter,
    shape,
    shared_numbers,
    shared_residual,
    slope_split,
    wheel_geometry,
)
from irtiming.estimate.joint import Joint, LocalModel, Measurand
from irtiming.estimate.measurands import LAG, WINDOW, Reported, Window
from irtiming.estimate.pixel_sums import CORNERS, GLARE, SHAPE
from irtiming.estimate.rig_errors import CLOCK, RigErrors
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.inference.correlated_noise import ljung_box_p_value
from irtiming.inference.optimiser import Linearised, Model
from irtiming.physics.camera import camera
from irtiming.physics.light import row_sum
from irtiming.physics.light.bent_rows import NONLINEARITIES
from irtiming.physics.response.integration_window import TAILS, tails
from irtiming.physics.wheel import TURN
from irtiming.records.analysis import Fits
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, RecordingFit
from irtiming.records.finding import Finding, doubted
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import EffectiveTimeConstants, JointFit, Method, Result
from irtiming.records.rig import Rig, WindowTail
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry

_SHARES = (CLOCK, GLARE, *TAILS, *shared_numbers.MEMORIES, *NONLINEARITIES)  # of unit 1, and no errors over their u
_SPEED_RATIO = 1.2  # of the wheel, from which it tells a window from mask edges that round the corners as well
_NOTHING_MORE = RigErrors()


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Combination:
    """What fits of single recordings say together.

    The joint fit, what a report shows of it, the result, those of its parameters that are one sum of shared numbers, and whether
    frames check the integration time that is stated.
    """

    joint: Joint
    joint_fit: JointFit
    result: Result
    profiled: tuple[Measurand, ...]
    is_length_checked: bool


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Timing:
    """The combination, and what led to it: recordings (which now know the axle), geometry, sectors and fits.

    ``sectors`` are those of row sums, ``views`` the opening in any camera's images, None where there is none; ``exact`` are
    models of the recordings where the joint fit takes parabolas; the same where it takes none.
    """

    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    sectors: tuple[SectorFit, ...]
    views: tuple[SectorFit | None, ...]
    fits: Fits
    exact: tuple[LocalModel, ...]
    found: Combination


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
    stated_s = integration_time.common(recordings)
    bare = wheel_geometry.geometry(recordings, rig, slots="learned", off_axle_mask=False).model
    recordings, views = shape.seen(recordings, bare, rig=rig)
    geometry = wheel_geometry.geometry(recordings, rig, slots="learned", off_axle_mask=True)
    with doubted(one.findings for one in recordings):  # what the image says
        fits = tuple(pixel_sums.fit(one, geometry.model) for one in recordings)
    errors = rig_errors.of(recordings, fits, rig=rig, geometry=geometry)
    models = tuple(
        _model(one, fit, geometry, tail=errors.window_tail) for one, fit in zip(recordings, fits, strict=True)
    )
    own = [
        *pixel_numbers.opening_and_window(recordings, fits, geometry=geometry),
        *reference_noise.shared(recordings, fits, wheel=geometry.model, rotation=geometry.rotation),
    ]
    combined = of_pixel_fits(fits, geometry, models=models, own=own, stated_s=stated_s, rig=errors)
    found = _of_recordings(combined, recordings, rig, fits=fits)
    models = found.joint.models
    return Timing(
        recordings=recordings, geometry=geometry, sectors=(), views=views, fits=fits, exact=models, found=found
    )


def _of_recordings(found: Combination, recordings: Sequence[ReducedRecording], rig: Rig, *, fits: Fits) -> Combination:
    """The same with each recording's file beside its relative delay, and with what only the recordings tell of the result."""
    result, scattering = found.result, frame_jitter.of_all(recordings, fits)
    findings = (
        *doubts.of_events(result.findings, recordings),
        *doubts.of_next_trigger(result, recordings=recordings),
        *scatter.of_triggers(fits, recordings),
        *frame_jitter.findings(scattering),
        *image_doubts.of_lens(rig.camera, recordings[0]),
        *on_trust.of(recordings, rig=rig, is_length_checked=found.is_length_checked),
    )
    delays = [replace(delay, file=one.file) for delay, one in zip(result.relative_delays, recordings, strict=True)]
    whole = replace(result, relative_delays=tuple(delays), findings=findings, delay_scatter=scattering)
    return replace(found, result=whole)


def of_pixel_fits(
    fits: Sequence[EdgeDelayFit], geometry: WheelGeometry, *, models: Sequence[LocalModel], own: Sequence[SharedNumber],
    stated_s: float | None, rig: RigErrors = _NOTHING_MORE,
) -> Combination:  # fmt: skip
    """Timing of a snapshot photon camera from fits of its pixel sums.

    Parameters
    ----------
    fits
        One per recording.
    geometry
        The wheel model that the fits used, and the uncertainties of its angles.
    models
        What each recording says of its local numbers, with the noise of its own fit.
    own
        Numbers of opening and window that all recordings share; beside them are the delay and the rig's errors.
    stated_s
        Integration time as the recordings state it; None where they do not.
    rig
        What else is known of the rig.
    """
    groups, u_edge = scatter.alike(fits, [range(len(fits))]), scatter.edge_uncertainty(fits, geometry)
    middle_s = min(float(np.mean([fit.estimate.value(name) for name in EDGE_DELAYS])) for fit in fits)
    errors = [*shared_numbers.rig_errors(fits, geometry, u_edge_rad=u_edge), *rig.shared]
    own = _with_stated(own, fits, rig, stated_s=stated_s)
    plain = joint.fit(models, [shared_numbers.delay(fits, start=middle_s), *own, *errors])
    parts = shared_residual.split(joint.traces(plain)) or shared_residual.all_own(len(fits))
    found = own_noise.weighed(plain, fits, groups=groups, parts=parts)
    freedom = float(sum(fit.degrees_of_freedom for fit in fits))
    window = _window(found, fits, stated_s=stated_s, rig=rig)
    reported = measurands.of_window(found, window, degrees_of_freedom=min(freedom, parts.degrees_of_freedom))
    record = _record(
        found, fits, whiteness=[ljung_box_p_value(fit.residual) for fit in fits], u_edge_rad=u_edge,
        n_residuals=sum(fit.degrees_of_freedom + len(fit.estimate.names) for fit in fits),
    )  # fmt: skip
    findings = (
        *geometry.findings, *frame_memory.of_result(reported.estimate), *frame_memory.of_stated(fits, rig.frame_memory),
        *doubts.of_window(reported.estimate), *doubts.of_edges(u_edge), *reported.findings,
        *doubts.of_angles(record), *doubts.of_pixel_fits(fits), *scatter.birge_findings(fits, groups), *doubts.of_start(record),
        *doubts.of_joint(record), *agreement.findings(found, fits), *rig.findings,
    )  # fmt: skip
    return Combination(
        joint=found, joint_fit=record, profiled=reported.profiled, is_length_checked=reported.is_length_checked,
        result=_result(found, fits, reported=reported, rig=rig, findings=findings),
    )  # fmt: skip


def _window(
    found: Joint, fits: Sequence[EdgeDelayFit], *, stated_s: float | None, rig: RigErrors = _NOTHING_MORE
) -> Window:
    """What is stated of the window, and whether several wheel speeds tell it from an angle that rounds the corners too."""
    fastest, slowest = (pick(fit.angular_frequency_rad_per_s for fit in fits) for pick in (max, min))
    if WINDOW not in found.names:
        return _stated_window(stated_s, rig, is_determined=False)
    return _stated_window(stated_s, rig, is_determined=fastest > _SPEED_RATIO * slowest)


def _stated_window(stated_s: float | None, rig: RigErrors, *, is_determined: bool) -> Window:
    parts = {} if rig.window_tail is None or rig.is_window_on_trust else tails(rig.window_tail)
    tails_s = {name: part.time_constant_s for name, part in parts.items()}
    return Window(stated_s=stated_s, u_stated_s=rig.u_window_s, is_determined=is_determined, tails_s=tails_s)


def _with_stated(
    own: Sequence[SharedNumber], fits: Sequence[RecordingFit], rig: RigErrors, *, stated_s: float | None
) -> list[SharedNumber]:
    """The camera's numbers with what is stated of memory and window."""
    own = shared_numbers.with_stated_memory(own, rig.frame_memory)
    if stated_s is not None:
        own = shared_numbers.with_stated_window(own, stated_s=stated_s, u_s=rig.u_window_s)
    if rig.window_tail is None:
        return own
    return [*own, *shared_numbers.window_tails(fits, rig.window_tail, integration_time_s=stated_s)]


def _model(
    one: ReducedRecording, fit: EdgeDelayFit, geometry: WheelGeometry, *, tail: WindowTail | None = None
) -> LocalModel:
    """Frames that the recording's own fit kept, with its noise, widened where residuals are correlated."""
    noise = fit.noise * float(np.sqrt(fit.variance_inflation)) * abs(fit.step)
    tails_s = {} if tail is None else {name: part.time_constant_s for name, part in tails(tail).items()}
    given = replace(pixel_sums.pixel_sums(one, geometry.model), kept=fit.kept, noise=noise, tails_s=tails_s)
    given = given if fit.levels is None else replace(given, levels=fit.levels)
    return LocalModel(names=(*EDGE_DELAYS, *SHAPE, CORNERS, *tails_s), at=given.at, trace=given.trace)


def _of_row_sums(recordings: Sequence[ReducedRecording], rig: Rig) -> Timing:
    stated_s = integration_time.common(recordings)
    rows = rolling_camera.rows(recordings, rig)
    names = (*row_sum.timing_names(camera(recordings[0].camera_type, recordings[0].readout_mode)), *NONLINEARITIES)
    errors = rig_errors.of(rows.recordings, rows.fits, rig=rig, geometry=rows.geometry)
    found = of_row_fits(
        rows.fits, rows.geometry, sectors=rows.sectors, stated_s=stated_s, n_rows=recordings[0].opening.mask.shape[0],
        rig=errors,
    )  # fmt: skip
    factor = _run_to_run(rows.fits)
    return Timing(
        recordings=rows.recordings, geometry=rows.geometry, sectors=rows.sectors, views=rows.sectors, fits=rows.fits,
        exact=tuple(
            _exact(fit.holding(*row_sum.BLADES), model, names=names).inflated(float(scale) * fit.variance_inflation)
            for fit, model, scale in zip(rows.fits, rows.likelihoods, factor, strict=True)
        ),
        found=_of_recordings(found, recordings, rig, fits=rows.fits),
    )  # fmt: skip


def of_row_fits(
    fits: Sequence[RowTimingFit], geometry: WheelGeometry, *, sectors: Sequence[SectorFit], n_rows: int,
    stated_s: float | None = None, rig: RigErrors = _NOTHING_MORE,
) -> Combination:  # fmt: skip
    """Timing of any camera whose rows are summed, from fits of its rows; each is taken for a parabola.

    Parameters
    ----------
    fits, sectors
        In the same order, one per recording; the uncertainty of a sector is common to all fits that used it.
    geometry
        The wheel model that the fits used, and the uncertainties of its angles.
    n_rows
        Rows of the image.
    stated_s
        Integration time as the recordings state it; None where they do not, or where there is no window.
    rig
        What else is known of the rig.
    """
    whole, fits = fits, [fit.holding(*row_sum.BLADES) for fit in fits]
    blackbodies, u_edge = _blackbodies(fits), scatter.edge_uncertainty(fits, geometry)
    first = min(fits, key=lambda fit: float(np.mean(fit.edge_delay_s)))
    own = _with_stated(row_numbers.of_camera(fits, first, blackbodies=blackbodies), fits, rig, stated_s=stated_s)
    shared = [
        shared_numbers.delay(fits, start=float(np.mean(first.edge_delay_s))),
        *own,
        *shared_numbers.image_errors(fits, sectors),
        *shared_numbers.rig_errors(fits, geometry, u_edge_rad=u_edge),
        *rig.shared,
    ]
    factor, groups = _run_to_run(fits), scatter.alike(fits, blackbodies)
    found = joint.fit(
        [joint.parabola(fit.estimate).inflated(float(f)) for fit, f in zip(fits, factor, strict=True)], shared
    )
    freedom = float(sum(fit.wheel_angle_rad.size - len(fit.estimate.names) for fit in fits))
    constants = [one.name for one in own if one.name.startswith(LAG)]
    if constants:
        reported = measurands.of_lag(found, constants, degrees_of_freedom=freedom)
    else:
        window = _stated_window(stated_s, rig, is_determined=True)
        reported = measurands.of_window(found, window, degrees_of_freedom=freedom)
    record = _record(
        found, fits, whiteness=[_whiteness(fit) for fit in fits],
        n_residuals=sum(len(fit.estimate.names) for fit in fits), u_edge_rad=u_edge,
    )  # fmt: skip
    effective = _effective(found, fits, blackbodies=blackbodies, constants=constants)
    findings = (
        *geometry.findings, *reported.findings, *doubts.of_reading(reported.estimate, n_rows=n_rows), *doubts.of_edges(u_edge),
        *frame_memory.of_result(reported.estimate), *frame_memory.of_row_fits(fits, reported.estimate),
        *frame_memory.of_stated(fits, rig.frame_memory),
        *nonlinearity.of_joint(found),
        *doubts.of_row_fits(whole), *rivals.findings(whole), *image_doubts.of_sectors(whole, sectors),
        *scatter.birge_findings(fits, groups), *doubts.of_mixture(effective), *doubts.of_angles(record),
        *doubts.of_joint(record), *agreement.findings(found, fits), *rig.findings,
    )  # fmt: skip
    result = _result(found, fits, reported=reported, rig=rig, findings=findings)
    return Combination(
        joint=found, joint_fit=record, result=replace(result, effective=effective), profiled=reported.profiled,
        is_length_checked=reported.is_length_checked,
    )  # fmt: skip


def _run_to_run(fits: Sequence[RowTimingFit]) -> Array:
    """Factor on the variances of each fit, shape (n_fit,), where runs that should agree scatter more than their noise."""
    return scatter.run_to_run(fits, scatter.alike(fits, _blackbodies(fits)))


def _exact(fit: RowTimingFit, model: Model, *, names: tuple[str, ...]) -> LocalModel:
    """The rows' own likelihood over the numbers that were fitted, were residuals white; ``names`` those of the camera's rows."""
    names = tuple(name for name in names if name in fit.timing)  # the model's
    columns = [names.index(name) for name in fit.estimate.names]

    def at(numbers: Mapping[str, float]) -> Linearised:
        there = model({name: numbers.get(name, fit.timing[name]) for name in names})
        return Linearised(residual=there.residual, jacobian=there.jacobian[:, columns])

    return LocalModel(names=fit.estimate.names, at=at)


def _record(
    found: Joint, fits: Sequence[RecordingFit], *, whiteness: Sequence[float], n_residuals: int, u_edge_rad: float
) -> JointFit:
    own = [one for one in found.shared if one.unit != "1" or one.name in _SHARES]
    angles = measurands.edge_angles(found, fits[0].angular_frequency_rad_per_s)
    every = [Measurand(name=one.name, unit=one.unit, weights={one.name: 1.0}) for one in own]
    return JointFit(
        parameters=found.estimate([*every, *angles]),
        start={one.name: one.start for one in own} | {one.name: 0.0 for one in angles},
        prior=measurands.known_before(found, [*angles, *every]),
        u_edge_rad=u_edge_rad,
        reduced_chi_square=found.found.at.deviance / max(1, n_residuals - sum(one.u is None for one in found.shared)),
        birge=joint.disagreement(found),
        whiteness=np.array(whiteness),
        n_steps=found.found.n_steps,
        decrement=found.found.decrement,
    )


def _result(
    found: Joint, fits: Sequence[EdgeDelayFit] | Sequence[RowTimingFit], *, reported: Reported, rig: RigErrors,
    findings: tuple[Finding, ...],
) -> Result:  # fmt: skip
    method: Method = "pixel-sum" if isinstance(fits[0], EdgeDelayFit) else "row-sum"
    noise = np.sqrt(np.mean([np.diag(fit.estimate.covariance)[:4] for fit in fits], axis=0) / len(fits))
    return Result(
        method=method,
        estimate=reported.estimate,
        relative_delays=relative_delays.of(found, fits, clock=rig.clock),
        not_in_uncertainty=(*rig.not_held, *reported.not_held),
        midpoint_leads=reported.midpoint_leads,
        falling_rising=slope_split.of(found, fits),
        budget=reported.budget,
        edge_delay_s=np.mean([fit.edge_delay_s for fit in fits], axis=0),
        u_edge_delay_s=noise,
        bounds=reported.bounds,
        findings=findings,
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


def _blackbodies(fits: Sequence[RowTimingFit]) -> list[list[int]]:
    return by_blackbody.groups(
        [fit.blackbody_temperature_k for fit in fits], is_colder=[bool(np.median(fit.gain_dn) < 0) for fit in fits]
    )


def _whiteness(fit: RowTimingFit) -> float:
    """Of the frames' mean residuals, each row in units of its noise, along the wheel angle."""
    mean: Array = np.mean(fit.residual / fit.noise, axis=1)
    return ljung_box_p_value(mean[np.argsort(np.mod(fit.wheel_angle_rad, TURN))])

"""What recordings that were made should tell: the same information as in planning, with the noise and angles that they show.

The report holds this against what the estimation states. A ratio of 1 says that all information was used; a larger one that the
residuals are correlated, runs scatter more than their noise, or something else was found that noise and rig do not explain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from irtiming.errors import PlanError
from irtiming.inference.information import Information
from irtiming.inference.lens_knowledge import knowledge
from irtiming.physics.camera import camera
from irtiming.physics.latency import window_tail
from irtiming.physics.light.summed_region import border_rad, radii_px
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.plan import information, photon_information, rolling_information
from irtiming.plan.beside_angles import Beside, clock_u, of_budget
from irtiming.plan.information import RunInformation
from irtiming.plan.photon_information import KNOWN_WINDOW, SHARED_SHAPE, FrameNoise, Sampling, Structure
from irtiming.plan.rolling_information import RollingRun
from irtiming.records import sources
from irtiming.records.analysis import Analysis
from irtiming.records.camera_description import Microbolometer, PhotonCamera
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.prediction import AngleErrors, PredictedRelativeDelay, Prediction
from irtiming.records.reduced import ReducedRecording
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelModel

_LEAST_NOISE = 1e-9
_SHORTEST_S = 1e-6

_Groups: TypeAlias = dict[tuple[float, float], list[RunInformation]]


def predict(analysis: Analysis) -> Prediction | None:
    """What the recordings of an analysis should tell; None where they tell too little, or their camera has no prediction.

    Parameters
    ----------
    analysis
        Recordings, fits, and the sizes of the angle errors.
    """
    angles = AngleErrors(
        common=tuple((source, u) for source, _, u in analysis.geometry.angle_budget), edge_rad=analysis.joint.u_edge_rad,
        window_tail=window_tail(analysis.rig.camera),
    )  # fmt: skip
    recordings, fits, model = analysis.recordings, analysis.fits, analysis.geometry.model
    sums = [fit for fit in fits if isinstance(fit, EdgeDelayFit)]
    if sums:
        is_stated, u_window_s = recordings[0].integration_time_s is not None, analysis.rig.camera.integration_time_u_s
        structure = KNOWN_WINDOW if is_stated and u_window_s is None else SHARED_SHAPE
        found = photon(recordings, sums, model=model, angles=angles, structure=structure, stated=_stated(analysis))
    else:
        found = row_sums(analysis, angles)
    return None if found is None else _with_rig(found, analysis)


def _stated(analysis: Analysis) -> tuple[Information, ...]:
    """What rig.toml knows of the camera's own numbers."""
    memory = analysis.rig.camera.frame_memory
    u, u_window_s = None if memory is None else memory.standard_uncertainty, analysis.rig.camera.integration_time_u_s
    known = information.stated_memory(camera(analysis.camera_type, analysis.readout_mode), u)
    if u_window_s is None or any(one.integration_time_s is None for one in analysis.recordings):
        return known
    return (*information.stated_window(u_window_s), *known)


def _with_rig(found: Prediction, analysis: Analysis) -> Prediction:
    """The same with latencies and clock, as the analysis has them in its budget: no recording tells anything of them."""
    beside, u_clock = _beside(found, analysis), clock_u(analysis.rig)
    return replace(
        found,
        uncertainties=tuple(information.with_parts(one, beside.get(one.name, {})) for one in found.uncertainties),
        relative_delays=tuple(
            replace(one, standard_uncertainty_s=float(np.hypot(one.standard_uncertainty_s, one.nominal_s * u_clock)))
            for one in found.relative_delays
        ),
    )


def _beside(found: Prediction, analysis: Analysis) -> Beside:
    has_own = analysis.rig.camera.integration_time_u_s is not None and any(
        one.name == "integration_time" for one in found.uncertainties
    )
    has_tail = has_own and any(isinstance(fit, EdgeDelayFit) for fit in analysis.fits)
    told = {sources.WINDOW: has_own, sources.TAIL: has_tail}
    return of_budget(analysis.best.budget, told=[source for source, is_told in told.items() if is_told])


def photon(
    recordings: Sequence[ReducedRecording],
    fits: Sequence[EdgeDelayFit],
    *,
    model: WheelModel,
    angles: AngleErrors,
    structure: Structure,
    stated: Sequence[Information] = (),
) -> Prediction | None:
    """Prediction for the recordings of a photon camera; None where they tell too little for one.

    Parameters
    ----------
    recordings, fits
        In the same order; of the fits the noise and the delay count.
    model
        Wheel and opening.
    angles
        Sizes of the angle errors.
    structure
        What each recording has for itself in the estimation, and what all share.
    stated
        What is known of parameters beforehand.
    """
    groups: _Groups = {}
    for recording, fit in zip(recordings, fits, strict=True):
        key = recording.rotation_speed_hz, round(recording.trigger_delay_time_set_s, 9)
        run = photon_information.one_run(
            _sampling(recording, fit), _noise(recording, fit), model=model, angles=angles, structure=structure
        )
        groups.setdefault(key, []).append(run)
    every = replace(information.total([one for members in groups.values() for one in members]), stated=tuple(stated))
    half = {"integration_time": 0.5} if "integration_time" in structure.shared else {}
    weights = {
        "trigger_delay": {"trigger_delay": 1.0},
        "exposure_midpoint_delay": {"trigger_delay": 1.0, **half, **every.centre},
    }
    if any(recording.integration_time_s is None for recording in recordings):
        del weights["trigger_delay"]
    if half:
        weights["integration_time"] = {"integration_time": 1.0}
    pixels = float(np.median([max(1, recording.opening.mask.sum()) for recording in recordings]))
    noise = float(np.sqrt(np.mean([fit.noise**2 for fit in fits])))
    try:
        return Prediction(
            noise_to_contrast=noise * photon_information.contrast_per_noise(pixels),
            opening_pixels=pixels,
            uncertainties=information.uncertainties(every, weights),
            relative_delays=_relative(groups),
        )
    except (PlanError, np.linalg.LinAlgError):
        return None


def row_sums(analysis: Analysis, angles: AngleErrors) -> Prediction | None:
    """Prediction for the recordings of a camera whose rows are summed; None where they tell too little for one.

    Parameters
    ----------
    analysis
        Its fits tell noise, timing and what counted as known, its sector the light of the rows.
    angles
        Sizes of the angle errors.
    """
    fits, sector = [fit for fit in analysis.fits if isinstance(fit, RowTimingFit)], analysis.sectors[0]
    camera_model = camera(analysis.camera_type, analysis.readout_mode)
    rows = rolling_information.rows_of(sector.shape, n_harmonics=camera_model.n_harmonics)
    image = rolling_information.sector_image(sector.shape)
    noises = [_pixel_noise(fit, rows) for fit in fits]
    runs = [
        RollingRun(
            camera=_described(analysis, fit, noise_to_contrast=noise, sector=sector),
            rows=rows,
            angular_frequency_rad_per_s=fit.angular_frequency_rad_per_s,
            n_frames=fit.wheel_angle_rad.size,
            step_rad=fit.step_rad,
            knows_response=all(camera_model.response.PARAMETER in one.held for one in fits),
        )
        for fit, noise in zip(fits, noises, strict=True)
    ]
    model = analysis.geometry.model
    known = knowledge(analysis.rig.camera, image=(sector.shape.image_rows, sector.shape.image_columns))
    lens = rolling_information.lens_information(runs, image, model=model, known=known)
    of_runs = [
        rolling_information.one_run(run, model=model, angles=angles, image=errors)
        for run, errors in zip(runs, rolling_information.image_errors(runs, image, model=model, lens=lens), strict=True)
    ]
    names = rolling_information.timing_names(runs[0])
    weights = {name: {name: 1.0} for name in names if name != camera_model.memory.PARAMETER}
    if analysis.camera_type == "photon":
        weights |= _window(analysis, weights)
    try:
        found = information.uncertainties(replace(information.total(of_runs), stated=_stated(analysis)), weights)
    except (PlanError, np.linalg.LinAlgError):
        return None
    return Prediction(
        noise_to_contrast=float(np.sqrt(np.mean(np.square(noises)))),
        opening_pixels=float(image.light.sum()),
        uncertainties=found,
    )


def _window(analysis: Analysis, weights: Mapping[str, dict[str, float]]) -> dict[str, dict[str, float]]:
    """The window's middle, and its start half the stated window earlier; without a statement the start is a result of its own."""
    middle = {"trigger_delay": 1.0, **({"integration_time": 0.5} if "integration_time" in weights else {})}
    is_stated = all(one.integration_time_s is not None for one in analysis.recordings)
    return {"exposure_midpoint_delay": middle, **({"trigger_delay": middle} if is_stated else {})}


def _described(
    analysis: Analysis, fit: RowTimingFit, *, noise_to_contrast: float, sector: SectorFit
) -> PhotonCamera | Microbolometer:
    """The camera as one recording's fit shows it."""
    row_delay_s = None if analysis.readout_mode == "snapshot" else fit.row_delay_s
    shared: dict[str, Any] = {
        "noise_to_contrast": noise_to_contrast,
        "gain_scatter": sector.gain_scatter,
        "border_scatter": sector.border_scatter,
        "row_delay_s": row_delay_s,
    }
    if analysis.camera_type == "photon":
        return PhotonCamera(**shared, integration_time_s=max(fit.timing["integration_time"], _SHORTEST_S))
    return Microbolometer(**shared, time_constant_s=max(fit.timing["time_constant"], _SHORTEST_S))


def _pixel_noise(fit: RowTimingFit, rows: rolling_information.Rows) -> float:
    """Noise of one pixel over the contrast, from that of the row sums."""
    places = {int(row): k for k, row in enumerate(rows.row_px)}
    light = rows.harmonics[:, 0].real
    summed = rolling_information.summed_pixels(rows.harmonics)
    found = [
        noise * light[places[row]] / np.sqrt(summed[places[row]])
        for row, noise in zip(fit.row_px.tolist(), fit.noise, strict=True)
        if row in places
    ]
    return max(_LEAST_NOISE, float(np.median(found)) if found else _LEAST_NOISE)


def _sampling(recording: ReducedRecording, fit: EdgeDelayFit) -> Sampling:
    """Wheel angles at the start of integration of all frames whose exposure the wheel's timestamps cover."""
    ticks = recording.trigger_ticks
    delay_s, set_s = float(fit.edge_delay_s.mean()), recording.trigger_delay_time_set_s
    angle = wheel_angle_rad(delay_s, recording.track, at_ticks=ticks, set_s=set_s)
    is_known = np.isfinite(angle)
    time = (ticks - ticks.mean()) / max(1.0, float(np.ptp(ticks)))
    return Sampling(
        wheel_angle_rad=angle[is_known],
        time=time[is_known],
        angular_frequency_rad_per_s=fit.angular_frequency_rad_per_s,
        step_rad=fit.angular_frequency_rad_per_s * recording.trigger_period_s,
    )


def _noise(recording: ReducedRecording, fit: EdgeDelayFit) -> FrameNoise:
    """The residuals of the fit hold pixels and jitter alike."""
    distance = radii_px(recording.opening, recording.axle)
    return FrameNoise(
        share=max(fit.noise, _LEAST_NOISE),
        jitter_s=0.0,
        integration_time_s=recording.integration_time_s or 0.0,
        border_rad=border_rad(recording.opening.border_px, radii_px=distance),
    )


def _relative(groups: _Groups) -> tuple[PredictedRelativeDelay, ...]:
    """Each set delay at each speed against all runs with the smallest set delay."""
    smallest = min(delay for _, delay in groups)
    reference = information.total(
        [one for (_, delay), members in groups.items() if delay == smallest for one in members]
    )
    found = []
    for (speed, delay), members in sorted(groups.items()):
        if delay == smallest:
            continue
        both = information.apart(information.total(members), reference)
        square = information.variances(both, {"relative_delay": {"relative_delay": 1.0}})[0]
        found.append(
            PredictedRelativeDelay(
                nominal_s=delay - smallest,
                rotation_speed_hz=speed,
                standard_uncertainty_s=float(np.sqrt(max(square, 0.0))),
            )
        )
    return tuple(found)

"""What a number of runs at some wheel speeds can tell of a camera: every kind of camera behind one door."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias, final

import numpy as np

from irtiming.errors import PlanError
from irtiming.inference.lens_knowledge import knowledge
from irtiming.physics import camera as physics_camera
from irtiming.physics.wheel import TURN
from irtiming.plan import information, photon_information, rolling_information
from irtiming.plan.assumptions import AssumedRig
from irtiming.plan.information import RunInformation
from irtiming.plan.photon_information import Sampling, Structure
from irtiming.plan.sampling import sampling_order
from irtiming.records.camera_description import Camera, PhotonCamera
from irtiming.records.prediction import PredictedUncertainty
from irtiming.records.trigger_plan import TriggerScheme

RELATIVE = "relative_delay"
_USUAL_HZ, _USUAL_FRAMES = 3.0, 1000  # of a run whose image tells which lenses are left: they hardly depend on it
_PHASES = 4  # places between two samples where a run may begin; what it tells is their mean
_OWN = {
    "photon": ("trigger_delay", "exposure_midpoint_delay", "integration_time"),
    "microbolometer": ("trigger_delay", "time_constant"),
}


def parameters_of(camera: Camera) -> tuple[str, ...]:
    """Names of what can be asked of this kind of camera."""
    rows = ("row_delay",) if camera.readout_mode == "rolling" else ()
    return (*_OWN[camera.camera_type], *rows, RELATIVE)


@final
@dataclass(frozen=True, kw_only=True)
class Setting:
    """Camera, rig and clock of a measurement, and what is unknown of a photon camera's runs."""

    camera: Camera
    rig: AssumedRig
    clock_frequency_hz: int
    structure: Structure = photon_information.SHARED_SHAPE

    @cached_property
    def one_run(self) -> Callable[[TriggerScheme], RunInformation]:
        """Information of one run of a scheme."""
        if isinstance(self.camera, PhotonCamera) and self.camera.readout_mode == "snapshot":
            of_scheme = _pixel_sums(self, self.camera)
        else:
            of_scheme = _row_sums(self)
        return lambda scheme: self._with_rig(of_scheme(scheme))

    def _with_rig(self, run: RunInformation) -> RunInformation:
        """The same with what rig.toml knows beside angles."""
        camera = physics_camera.camera(self.camera.camera_type, self.camera.readout_mode)
        known = information.stated_memory(camera, self.rig.u_frame_memory)
        if "integration_time" in run.names:
            known = (*information.stated_window(self.rig.u_window_s), *known)
        return replace(run, beside=self.rig.beside, stated=known)


Runs: TypeAlias = Sequence[tuple[RunInformation, int]]
"""For each wheel speed what one run tells, and how many there are of each set delay."""


def uncertainties(runs: Runs, names: Sequence[str], *, n_delays: int = 1) -> tuple[PredictedUncertainty, ...]:
    """Predicted uncertainties of the named parameters.

    Parameters
    ----------
    runs
        All of one camera on one rig.
    names
        Of `parameters_of` the camera.
    n_delays
        Number of set delays: they are known, so all runs tell the camera's own timing. ``relative_delay`` is the difference
        between two of them.
    """
    asked = [(one, weights) for one, weights in _asked(runs, names, n_delays=n_delays) if weights]
    found = {each.name: each for one, weights in asked for each in information.uncertainties(one, weights)}
    return tuple(found[name] for name in names)


def sizes_s(runs: Runs, names: Sequence[str], *, n_delays: int = 1) -> dict[str, float]:
    """The same without parts: standard uncertainties by name, s."""
    found: dict[str, float] = {}
    for one, weights in _asked(runs, names, n_delays=n_delays):
        if weights:
            squares = information.variances(one, weights)
            found.update(zip(weights, np.sqrt(np.maximum(squares, 0.0)).tolist(), strict=True))
    return found


def _asked(runs: Runs, names: Sequence[str], *, n_delays: int) -> list[tuple[RunInformation, information.Asked]]:
    """What is asked of all runs as one camera's timing, and of pairs of them with two set delays."""
    every = information.total([one.times(n) for one, n in runs])
    absolute = {name: _weights(name, every) for name in names if name != RELATIVE}
    relative = {RELATIVE: {RELATIVE: 1.0}} if RELATIVE in names else {}
    return [(every.times(n_delays), absolute), (information.apart(every, every), relative)]


def _weights(name: str, one: RunInformation) -> dict[str, float]:
    """The parameter as a sum of those that the information is about."""
    if name == "exposure_midpoint_delay":
        return {"trigger_delay": 1.0, "integration_time": 0.5, **one.centre}
    if name not in one.names:
        raise PlanError(f"{name} counts as known, so it has no uncertainty to plan for; leave it out")
    return {name: 1.0}


def nominal_sampling(scheme: TriggerScheme, clock_frequency_hz: int) -> Sampling:
    """Wheel angles and times of one run, from `_PHASES` places where it may begin."""
    n = scheme.samples_per_turn
    places = (np.arange(_PHASES) + 0.5) / _PHASES
    sample = (sampling_order(scheme)[None, :] + places[:, None]).ravel()
    return Sampling(
        wheel_angle_rad=TURN / n * sample,
        time=np.tile((np.arange(n) + 0.5) / n - 0.5, _PHASES),
        angular_frequency_rad_per_s=TURN * clock_frequency_hz / scheme.turn_period_ticks,
        step_rad=TURN * scheme.camera_period_ticks / scheme.turn_period_ticks,
        weight=1 / _PHASES,
    )


def _pixel_sums(setting: Setting, camera: PhotonCamera) -> Callable[[TriggerScheme], RunInformation]:
    noise = photon_information.frame_noise(camera)

    def one_run(scheme: TriggerScheme) -> RunInformation:
        return photon_information.one_run(
            nominal_sampling(scheme, setting.clock_frequency_hz),
            noise,
            model=setting.rig.model,
            angles=setting.rig.angles,
            structure=setting.structure,
        )

    return one_run


def _row_sums(setting: Setting) -> Callable[[TriggerScheme], RunInformation]:
    camera = setting.camera
    opening = rolling_information.sector_of(camera, setting.rig.model.opening_angle_rad)
    known = knowledge(setting.rig.optics, image=(opening.image_rows, opening.image_columns))
    sector, model = rolling_information.through(opening, known), setting.rig.model
    n_harmonics = physics_camera.camera(camera.camera_type, camera.readout_mode).n_harmonics
    rows = rolling_information.rows_of(sector, n_harmonics=n_harmonics)
    image = rolling_information.sector_image(sector)
    usual = rolling_information.RollingRun(
        camera=camera,
        rows=rows,
        angular_frequency_rad_per_s=TURN * _USUAL_HZ,
        n_frames=_USUAL_FRAMES,
        step_rad=TURN / _USUAL_FRAMES,
        knows_response=camera.camera_type == "photon" and setting.structure is photon_information.KNOWN_WINDOW,
    )
    lens = rolling_information.lens_information([usual], image, model=model, known=known)

    def one_run(scheme: TriggerScheme) -> RunInformation:
        run = replace(
            usual,
            angular_frequency_rad_per_s=TURN * setting.clock_frequency_hz / scheme.turn_period_ticks,
            n_frames=scheme.samples_per_turn,
            step_rad=TURN * scheme.camera_period_ticks / scheme.turn_period_ticks,
        )
        (errors,) = rolling_information.image_errors([run], image, model=model, lens=lens)
        return rolling_information.one_run(run, model=model, angles=setting.rig.angles, image=errors)

    return one_run

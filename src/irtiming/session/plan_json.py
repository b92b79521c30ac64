"""Plans as plain data, for a file or a page."""

from typing import Any

from irtiming.plan import sampling
from irtiming.plan.schedule import plan_duration_s, run_length_ticks
from irtiming.records.camera_description import Camera, PhotonCamera
from irtiming.records.prediction import PredictedUncertainty
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme

_COUNTS = (
    "turn_period_ticks", "control_slot_period_ticks", "camera_period_ticks", "sampling_interval_ticks", "samples_per_turn",
    "samples_per_frame", "control_slots",
)  # fmt: skip


def plan_as_json(plan: TriggerPlan) -> dict[str, Any]:
    """Runs of a plan in order, its duration, and which sample of the turn each trigger takes."""
    return {
        "runs": [_run(run, plan.clock_frequency_hz) for run in plan],
        "duration_s": float(plan_duration_s(plan)),
        "sampling_orders": [sampling.sampling_order(scheme).tolist() for scheme in plan.schemes],
    }


def _run(run: PlannedRun, clock_hz: int) -> dict[str, Any]:
    length = run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
    return {
        **vars(run.scheme),
        "trigger_delay_ticks": run.trigger_delay_ticks,
        "trigger_delay_s": run.trigger_delay_ticks / clock_hz,
        "repeats": run.repeats,
        "is_after_correction": run.is_after_correction,
        "duration_s": length / clock_hz,
    }


def scheme_as_json(scheme: TriggerScheme, clock_frequency_hz: int) -> dict[str, Any]:
    """Numbers of one scheme: ticks exactly, rates and duration as float and as fraction."""
    exact = {
        "wheel_rate_hz": sampling.wheel_rate_hz(scheme, clock_frequency_hz),
        "frame_rate_hz": sampling.frame_rate_hz(scheme, clock_frequency_hz),
        "run_duration_s": sampling.run_duration_s(scheme, clock_frequency_hz),
    }
    return {
        **{name: getattr(scheme, name) for name in _COUNTS},
        "triggers_to_neighbour": sampling.triggers_to_neighbour(scheme),
        **{name: float(value) for name, value in exact.items()},
        **{f"{name}_exact": str(value) for name, value in exact.items()},
    }


def predicted_as_json(found: tuple[PredictedUncertainty, ...]) -> dict[str, Any]:
    """Predicted standard uncertainties by parameter, with their parts."""
    return {
        each.name: {
            "standard_uncertainty": each.standard_uncertainty_s,
            "unit": "s",
            "parts": [
                {"source": part.source, "standard_uncertainty": part.standard_uncertainty_s} for part in each.parts
            ],
        }
        for each in found
    }


def camera_as_json(camera: Camera) -> dict[str, Any]:
    """What a prediction takes the camera to be."""
    shared: dict[str, Any] = {
        "camera": camera.camera_type,
        "readout_mode": camera.readout_mode,
        "noise_to_contrast": camera.noise_to_contrast,
        "opening_pixels": camera.opening_pixels,
        "unit": "s",
    }
    if camera.row_delay_s is not None:
        shared["row_delay"] = camera.row_delay_s
    if isinstance(camera, PhotonCamera):
        return {**shared, "integration_time": camera.integration_time_s}
    return {**shared, "time_constant": camera.time_constant_s}

"""Plans as plain data, for a file or a page."""

from typing import Any

from irtiming.plan import sampling
from irtiming.plan.schedule import plan_duration_s, run_length_ticks
from irtiming.records.camera_description import Camera, PhotonCamera
from irtiming.records.prediction import PredictedUncertainty
from irtiming.records.trigger_plan import TriggerPlan, TriggerScheme


def plan_as_json(plan: TriggerPlan) -> dict[str, Any]:
    """Runs of a plan in order, its duration, and which sample of the turn each trigger takes."""
    clock = plan.clock_frequency_hz
    runs = [
        {
            "turn_period_ticks": run.scheme.turn_period_ticks,
            "camera_period_ticks": run.scheme.camera_period_ticks,
            "control_slots": run.scheme.control_slots,
            "trigger_delay_ticks": run.trigger_delay_ticks,
            "trigger_delay_s": run.trigger_delay_ticks / clock,
            "repeats": run.repeats,
            "is_after_correction": run.is_after_correction,
            "duration_s": run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
            / clock,
        }
        for run in plan
    ]
    return {
        "runs": runs,
        "duration_s": float(plan_duration_s(plan)),
        "sampling_orders": [sampling.sampling_order(scheme).tolist() for scheme in plan.schemes],
    }


def scheme_as_json(scheme: TriggerScheme, clock_frequency_hz: int) -> dict[str, Any]:
    """Numbers of one scheme: ticks exactly, rates and duration as float and as fraction."""
    wheel = sampling.wheel_rate_hz(scheme, clock_frequency_hz)
    camera = sampling.frame_rate_hz(scheme, clock_frequency_hz)
    duration = sampling.run_duration_s(scheme, clock_frequency_hz)
    return {
        "turn_period_ticks": scheme.turn_period_ticks,
        "control_slot_period_ticks": scheme.control_slot_period_ticks,
        "camera_period_ticks": scheme.camera_period_ticks,
        "sampling_interval_ticks": scheme.sampling_interval_ticks,
        "samples_per_turn": scheme.samples_per_turn,
        "samples_per_frame": scheme.samples_per_frame,
        "control_slots": scheme.control_slots,
        "triggers_to_neighbour": sampling.triggers_to_neighbour(scheme),
        "wheel_rate_hz": float(wheel),
        "wheel_rate_hz_exact": str(wheel),
        "frame_rate_hz": float(camera),
        "frame_rate_hz_exact": str(camera),
        "run_duration_s": float(duration),
        "run_duration_s_exact": str(duration),
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
    shared = {"noise_to_contrast": camera.noise_to_contrast, "opening_pixels": camera.opening_pixels}
    if isinstance(camera, PhotonCamera):
        return {"camera": "photon", **shared, "integration_time": camera.integration_time_s, "unit": "s"}
    return {"camera": "microbolometer", **shared, "time_constant": camera.time_constant_s, "unit": "s"}

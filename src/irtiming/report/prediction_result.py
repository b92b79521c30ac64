"""What the recordings should have told, as plain data for JSON, beside what the estimation states."""

from typing import Any, Literal

from irtiming.report.evidence import Evidence, RollingEvidence


def predicted(
    evidence: Evidence | RollingEvidence, *, kind: Literal["photon", "microbolometer"]
) -> dict[str, Any] | None:
    """Predicted standard uncertainties with their parts, and the camera in the words of `irtiming plan --like`.

    Returns
    -------
    Keys camera, parameters and relative_delays; None where nothing was predicted. ``ratio`` is the stated standard uncertainty
    of the default method over the predicted one.
    """
    found = evidence.prediction
    if found is None:
        return None
    estimate = evidence.best.estimate
    stated = dict(zip(estimate.names, estimate.standard_uncertainties.tolist(), strict=True))
    values = dict(zip(estimate.names, estimate.values.tolist(), strict=True))
    camera: dict[str, Any] = {
        "camera": kind, "noise_to_contrast": found.noise_to_contrast, "opening_pixels": found.opening_pixels, "unit": "s"
    }  # fmt: skip
    if kind == "photon":
        camera["integration_time"] = getattr(evidence.recordings[0], "integration_time_s", None)
    else:
        camera["time_constant"] = values.get("time_constant")
    return {
        "camera": camera,
        "parameters": {
            each.name: {
                "predicted_standard_uncertainty": each.standard_uncertainty_s,
                "ratio": stated[each.name] / each.standard_uncertainty_s
                if each.name in stated and each.standard_uncertainty_s > 0
                else None,
                "parts": [
                    {"source": part.source, "standard_uncertainty": part.standard_uncertainty_s} for part in each.parts
                ],
                "unit": "s",
            }
            for each in found.uncertainties
        },
        "relative_delays": [
            {
                "nominal": each.nominal_s,
                "rotation_speed": {"value": each.rotation_speed_hz, "unit": "Hz"},
                "predicted_standard_uncertainty": each.standard_uncertainty_s,
                "unit": "s",
            }
            for each in found.relative_delays
        ],
    }

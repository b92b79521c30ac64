"""The joint fit of a photon camera as plain data, for JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.joint_fit import Profile
from irtiming.records.reduced import ReducedRecording
from irtiming.report import joint_tables
from irtiming.report.evidence import Evidence
from irtiming.report.joint_tables import LEAST_WHITENESS, Shared
from irtiming.report.tables import REFERENCE_EVENTS, SIGN


def result(evidence: Evidence) -> dict[str, Any]:
    """Everything that the section of the certificate shows, SI units.

    Returns
    -------
    Keys shared, correlation, steps, moved, reduced_chi_square, birge, whiteness, angles and profiles.
    """
    joint = evidence.joint
    u = np.sqrt(np.diag(joint.covariance))
    way_s, own = joint_tables.moved(evidence)
    numbers = joint_tables.shared(evidence)
    return {
        "shared": {one.name: _number(one) for one in numbers},
        "correlation": {
            "names": [one.name for one in numbers],
            "matrix": (joint.covariance / np.outer(u, u)).tolist(),
        },
        "steps": joint.n_steps,
        "moved": {"value": way_s, "over_standard_uncertainty": own, "unit": "s"},
        "reduced_chi_square": joint.reduced_chi_square,
        "birge": joint.birge,
        "whiteness": whiteness(evidence.recordings, joint.whiteness),
        "whiteness_limit": LEAST_WHITENESS,
        "angles": {one.name: _number(one) for one in joint_tables.angles(evidence)},
        "angles_measured": joint_tables.has_several_speeds(evidence),
        "profiles": {
            one.name: profile(
                one,
                event=REFERENCE_EVENTS.get(one.name, one.name),
                sign=None if one.name == "integration_time" else SIGN,
            )
            for one in joint.profiles
        },
    }


def _number(one: Shared) -> dict[str, Any]:
    return {
        "value": one.value,
        "standard_uncertainty": one.standard_uncertainty,
        "start": one.start,
        "prior_standard_uncertainty": one.prior_uncertainty,
        "value_over_prior": one.over_prior,
        "unit": one.unit,
        "meaning": one.meaning,
        "sign": SIGN if one.name == "middle_of_window" else _SIGNS.get(one.name.split("_")[0]),
    }


_SIGNS = {"edge": "positive: early", "common": "positive: early"}


def profile(one: Profile, *, event: str, sign: str | None) -> dict[str, Any]:
    """One profile likelihood as plain data, with what its parameter is counted from and its sign."""
    return {
        "value": one.value,
        "standard_uncertainty": one.standard_uncertainty,
        "values": [float(value) for value in one.values],
        "deviation": [float(deviation) for deviation in one.deviation],
        "lower": one.lower,
        "upper": one.upper,
        "unit": one.unit,
        "reference_event": event,
        "sign": sign,
    }


def whiteness(recordings: Sequence[ReducedRecording], probability: Array) -> list[dict[str, Any]]:
    """Probability (n_recording,) of residuals at least as correlated, were they white, beside each recording's file."""
    return [
        {"file": recording.source or recording.name, "probability": float(one)}
        for recording, one in zip(recordings, probability, strict=True)
    ]

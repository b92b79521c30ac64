"""How the noise of the frames alone ties the camera's parameters together."""

from collections.abc import Mapping

import numpy as np

from irtiming.physics.camera import camera
from irtiming.physics.covariance import inverse
from irtiming.records.analysis import Analysis
from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.report.meanings import delay_name

OF_CAMERA = ("integration_time", "time_constant", "row_delay")
"""Local numbers of a recording, beside the delays, that are the camera's own."""


def noise(analysis: Analysis) -> Estimate:
    """Of all recordings and wheel edges together, were there no other error: the least that any weighing of them could have.

    Recordings are independent of each other; their four edges are of one delay, and what a frame keeps of the one before is one
    number, too.

    Returns
    -------
    The delay and the camera's other parameters that all fits have.
    """
    fits = [fit.estimate for fit in analysis.fits]
    beside = [name for name in OF_CAMERA if all(name in fit for fit in fits)]
    memory = camera(analysis.camera_type, analysis.readout_mode).memory.PARAMETER
    shared = [*beside, *([memory] if all(memory in fit for fit in fits) else [])]
    design = np.zeros((4 + len(shared), 1 + len(shared)))
    design[:4, 0], design[4:, 1:] = 1.0, np.eye(len(shared))
    numbers = [fit.pick(*EDGE_DELAYS, *shared) for fit in fits]
    weighed = [design.T @ inverse(one.covariance) for one in numbers]
    covariance = inverse(np.sum([weight @ design for weight in weighed], axis=0))
    values = covariance @ np.sum([weight @ one.values for weight, one in zip(weighed, numbers, strict=True)], axis=0)
    whole = Estimate(
        names=(delay_name(analysis.best), *shared),
        units=("s", *numbers[0].units[4:]),
        values=values,
        covariance=covariance,
    )
    return whole.pick(*whole.names[: 1 + len(beside)])


def u_of_sum(found: Estimate, weights: Mapping[str, float]) -> float:
    """Standard uncertainty of a weighted sum of numbers, s."""
    row = np.array([weights.get(name, 0.0) for name in found.names])
    return float(np.sqrt(max(float(row @ found.covariance @ row), 0.0)))

"""How the noise of the frames alone ties the camera's parameters together."""

from collections.abc import Mapping

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.report.meanings import delay_name

OF_CAMERA = ("integration_time", "time_constant", "row_delay")
"""Local numbers of a recording, beside the delays, that are the camera's own."""


def noise(analysis: Analysis) -> Estimate:
    """Of the mean over all recordings and the four wheel edges, recordings being independent of each other.

    Returns
    -------
    The delay and the camera's other parameters that all fits have; values are the means of the fits.
    """
    fits = [fit.estimate for fit in analysis.fits]
    beside = [name for name in OF_CAMERA if all(name in fit for fit in fits)]
    numbers = [fit.pick(*EDGE_DELAYS, *beside) for fit in fits]
    to_mean = np.zeros((1 + len(beside), 4 + len(beside)))
    to_mean[0, :4], to_mean[1:, 4:] = 0.25, np.eye(len(beside))
    covariance = np.sum([one.covariance for one in numbers], axis=0) / len(numbers) ** 2
    return Estimate(
        names=(delay_name(analysis.best), *beside),
        units=("s",) * (1 + len(beside)),
        values=to_mean @ np.mean([one.values for one in numbers], axis=0),
        covariance=to_mean @ covariance @ to_mean.T,
    )


def u_of_sum(found: Estimate, weights: Mapping[str, float]) -> float:
    """Standard uncertainty of a weighted sum of numbers, s."""
    row = np.array([weights.get(name, 0.0) for name in found.names])
    return float(np.sqrt(max(float(row @ found.covariance @ row), 0.0)))

"""Delays of recordings against those with the smallest set delay, in SI seconds and in the generator's own time."""

from collections.abc import Sequence

import numpy as np

from irtiming.estimate import joint
from irtiming.estimate.joint import Joint
from irtiming.records.estimate import RecordingFit
from irtiming.records.result import RelativeDelay
from irtiming.records.rig import Measured


def of(found: Joint, fits: Sequence[RecordingFit], *, clock: Measured) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus the mean of those with the smallest set delay, including what was set.

    Parameters
    ----------
    found
        The joint fit.
    fits
        One per recording.
    clock
        Relative error of the clock with its standard uncertainty. A delay that was set lasts by as much longer or shorter;
        measured minus nominal, in the generator's own time, does not know of it.
    """
    nominal = np.array([fit.trigger_delay_time_set_s for fit in fits])
    _, setting = np.unique(np.round(nominal, 9), return_inverse=True)
    each, covariance = joint.each_delay(found, setting.tolist())
    reference = np.isclose(nominal, nominal.min(), rtol=0, atol=1e-12)
    difference = np.eye(len(fits)) - reference / reference.sum()
    beyond, u = difference @ each, np.sqrt(np.maximum(np.diag(difference @ covariance @ difference.T), 0))
    was_set, rate = nominal - nominal.min(), 1 + clock.value
    return tuple(
        RelativeDelay(
            file=fit.name,
            nominal_s=float(was_set[k]),
            value_s=float(beyond[k] + was_set[k] / rate),
            standard_uncertainty_s=float(np.hypot(u[k], was_set[k] * clock.standard_uncertainty)),
            deviation_s=float(beyond[k] * rate),
            u_deviation_s=float(u[k]),
        )
        for k, fit in enumerate(fits)
    )

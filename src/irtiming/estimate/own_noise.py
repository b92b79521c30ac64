"""The joint fit of pixel sums once more, with the noise that is each recording's own and with what their residuals share."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.estimate import joint, scatter, shared_numbers
from irtiming.estimate.joint import Joint
from irtiming.estimate.shared_residual import SharedResidual
from irtiming.records.estimate import EdgeDelayFit


def weighed(
    plain: Joint, fits: Sequence[EdgeDelayFit], *, groups: Sequence[scatter.Alike], parts: SharedResidual
) -> Joint:
    """The joint fit with variances that are the recordings' own, and with errors of the edges' angles that residuals stand for.

    Parameters
    ----------
    plain
        With the noise of each single fit; returned as it is where that is what the recordings have.
    fits, groups
        One per recording, and which of them should agree: where these scatter more, their variances grow.
    parts
        From `shared_residual.split`.
    """
    own = [scatter.with_variance(fit, float(part)) for fit, part in zip(fits, parts.own, strict=True)]
    factor = parts.own * scatter.run_to_run(own, groups)
    if np.all(factor == 1) and not np.any(parts.shared):
        return plain
    errors = []
    if np.any(parts.shared):
        shared_rad2 = [
            fit.covariance_s2 * part * fit.angular_frequency_rad_per_s**2
            for fit, part in zip(fits, parts.shared, strict=True)
        ]
        errors = shared_numbers.residual_errors(fits, np.mean(shared_rad2, axis=0))
    return joint.fit(
        [model.inflated(float(f)) for model, f in zip(plain.models, factor, strict=True)],
        [*(replace(one, start=plain.found.values[one.name]) for one in plain.shared), *errors],
    )

r"""Covariance of values whose budgets name their sources: an input that several have in common errs alike in all of them.

.. math:: V_{ij} = \sum_k c_{ik} c_{jk} \quad (i \ne j), \qquad V_{ii} = u_i^2

k runs over the common inputs, c is what each adds to a value, with its sign (GUM, F.1.2.3). What is left of a variance is the
value's own. So the mean of many values keeps all of a common input, and their differences and slopes keep little of it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from irtiming.records.arrays import Array

_LEAST_OWN = 1e-12  # of a variance, so that the matrix stays positive definite where numbers were rounded


def covariance(u: Array, common: Sequence[Mapping[str, float]]) -> Array:
    """Covariance matrix of n values.

    Parameters
    ----------
    u
        Shape (n,); standard uncertainties, whole.
    common
        For each value what each common input adds to it, with its sign, by the input's name; where they make more than ``u``
        together, they are scaled to it.

    Returns
    -------
    Shape (n, n), positive definite where every u > 0.
    """
    names = sorted({name for one in common for name in one})
    added = np.array([[one.get(name, 0.0) for name in names] for one in common]).reshape(len(common), len(names))
    whole = np.square(np.asarray(u, dtype=np.float64))
    shared = np.sum(added**2, axis=1)
    added = added * np.sqrt(np.minimum(1.0, whole / np.where(shared > 0, shared, 1.0)))[:, None]
    own = np.maximum(whole - np.sum(added**2, axis=1), _LEAST_OWN * whole)
    return added @ added.T + np.diag(own)

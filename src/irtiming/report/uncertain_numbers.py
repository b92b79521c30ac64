"""Quantities as other libraries have them, correlations kept: GUM Tree Calculator, uncertainties, pandas."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from math import isfinite
from typing import Any

import GTC
import numpy as np

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array
from irtiming.records.reduced import Region
from irtiming.report.quantity import Quantity

_LEAST_CORRELATION = 1e-12


def gtc_numbers(quantities: Sequence[Quantity], correlation: Array) -> dict[str, Any]:
    """Uncertain real numbers by name.

    Parameters
    ----------
    quantities
        In the order of the matrix. Those of one ensemble must have one number of degrees of freedom: the smallest of theirs.
    correlation
        Shape (n, n).
    """
    freedom = min((one.degrees_of_freedom for one in quantities), default=float("inf"))
    names = [one.name for one in quantities]
    numbers = GTC.multiple_ureal(
        [one.value for one in quantities], [one.u for one in quantities], max(1.0, freedom), names
    )
    for i in range(len(names)):
        for j in range(i):
            r = float(correlation[i, j])
            if isfinite(r) and abs(r) > _LEAST_CORRELATION:
                GTC.set_correlation(max(-1.0, min(1.0, r)), numbers[i], numbers[j])
    return dict(zip(names, numbers, strict=True))


def uncertainties_numbers(quantities: Sequence[Quantity], covariance: Array) -> dict[str, Any]:
    """Numbers of the package ``uncertainties`` by name; ``covariance`` has shape (n, n).

    Raises
    ------
    EstimationError
        If the package is not installed.
    """
    package = _installed("uncertainties")
    numbers = package.correlated_values([one.value for one in quantities], covariance)
    return {one.name: number for one, number in zip(quantities, numbers, strict=True)}


def data_frame(quantities: Sequence[Quantity]) -> Any:
    """One row each, by name.

    Raises
    ------
    EstimationError
        If pandas is not installed.
    """
    rows = [
        {
            "parameter": one.name,
            "value": one.value,
            "u": one.u,
            "U": one.expanded(),
            "k": one.coverage_factor(),
            "degrees_of_freedom": one.degrees_of_freedom,
            "unit": one.unit,
            "event": one.event,
        }
        for one in quantities
    ]
    return _installed("pandas").DataFrame(rows).set_index("parameter")


def pixel_frame(images: Mapping[str, Array], roi: Region) -> Any:
    """One row for each pixel that has a value in the first image, with its place and all images as columns.

    Parameters
    ----------
    images, roi
        By name, shape (roi rows, roi columns), and where in the image they lie.

    Raises
    ------
    EstimationError
        If pandas is not installed.
    """
    at = np.nonzero(np.isfinite(next(iter(images.values()))))
    places = {"row_px": at[0] + roi[0], "column_px": at[1] + roi[2]}
    return _installed("pandas").DataFrame(places | {name: image[at] for name, image in images.items()})


def _installed(name: str) -> Any:
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise EstimationError(f"the package {name} is not installed; pip install {name}") from error

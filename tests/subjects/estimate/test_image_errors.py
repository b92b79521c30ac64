"""Errors of the opening's numbers in the image: what a report calls them."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import shared_numbers
from irtiming.report.language import with_numbers, writing_in

AT_AXLE = "axle, mask and blur in the image, combination"
OF_LENS = "tilt of the camera, and its lens, combination"


def _errors(n_images):
    covariance = np.diag([1.0, 4.0, 9.0])
    sectors = [
        SimpleNamespace(names=("axle_row_px", "axle_column_px", "distortion"), covariance=covariance)
        for _ in range(n_images)
    ]
    fits = [SimpleNamespace(estimate=SimpleNamespace(names=("x",)), shape_effect=np.ones((1, 3))) for _ in sectors]
    return shared_numbers.image_errors(fits, sectors)


@pytest.mark.parametrize(
    ("n_images", "names"),
    [
        (1, [f"{AT_AXLE} 1", f"{AT_AXLE} 2", f"{OF_LENS} 1"]),
        (2, [f"{name} of image {k}" for k in (1, 2) for name in (f"{AT_AXLE} 1", f"{AT_AXLE} 2", f"{OF_LENS} 1")]),
    ],
)
def test_an_error_of_the_image_has_a_name_in_words(n_images, names):
    """Oracle: by hand; two independent errors of axle and blur, one of the lens; each has its German."""
    assert [one.name for one in _errors(n_images)] == names
    with writing_in("de"):
        german = [with_numbers(name) for name in names]
    assert all("Kombination" in name for name in german)

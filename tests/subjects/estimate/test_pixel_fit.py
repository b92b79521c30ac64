"""Which pixels of a map follow the wheel as the others do: by hand."""

import numpy as np
import pytest

from irtiming.estimate import pixel_fit
from irtiming.physics.light.pixel import PixelNumbers

_MANY = 9


@pytest.mark.parametrize(
    ("contrast_dn", "sound"), [(-300.0, False), (99.0, False), (101.0, True), (899.0, True), (901.0, False)]
)
def test_a_pixel_shows_a_third_to_three_times_the_usual_contrast(contrast_dn, sound):
    """Oracle: by hand; of many pixels of 300 DN a third are 100, three times 900."""
    contrast = np.append(np.full(_MANY, 300.0), contrast_dn)
    found = PixelNumbers(contrast_dn=contrast, delay_s=np.zeros(contrast.size), response_s=np.zeros(contrast.size))
    alike = np.ones(contrast.size)
    assert pixel_fit._sound(found, alike, alike).tolist() == [*[True] * _MANY, sound]

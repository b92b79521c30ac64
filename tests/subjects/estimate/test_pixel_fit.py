"""Which pixels of a map follow the wheel as the others do: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import pixel_fit
from irtiming.physics import wheel_harmonics
from irtiming.physics.light.pixel import PixelNumbers
from irtiming.physics.wheel import wheel_model

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


def test_what_pixels_share_is_each_edge_at_its_own_time_and_what_the_camera_keeps_of_it(monkeypatch):
    """Oracle: the edges one by one, the second blade's dimmer, each later by its own time, and a series of older frames."""
    wheel = wheel_model((0.1, 1.6, 3.2, 4.8), 0.27, opening_angle_rad=1.3, centre_angle_rad=-np.pi / 2)
    omega, step, memory, blade = 20.0, 0.6, 0.1, 0.05
    read_s = 1e-3 * np.array([4.0, 4.3, 3.8, 4.1])
    track = SimpleNamespace(angular_frequency_rad_per_s=omega)
    recording = SimpleNamespace(camera_type="microbolometer", readout_mode="rolling", track=track)
    monkeypatch.setattr(pixel_fit.frame_steps, "step_rad", lambda _: step)
    reference = pixel_fit.Reference(read_s=read_s, row_delay_s=0.0, response_s=8e-3, memory=memory, blade=blade)
    found = pixel_fit._shared(recording, wheel, reference)
    order = np.arange(found.size)
    edges = wheel_harmonics.open_harmonics(wheel, found.size - 1)
    size = (1.0, 1.0, 1 - blade, 1 - blade)
    expected = sum(size[k] * edges[k] * np.exp(1j * order * omega * read_s[k]) for k in range(4))
    expected = expected * sum((1 - memory) * memory**n * np.exp(-1j * order * step * n) for n in range(30))
    np.testing.assert_allclose(found, expected, atol=1e-12)

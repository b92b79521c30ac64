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


@pytest.mark.parametrize("n_free", [2, 3])
def test_a_step_of_each_pixel_is_its_own_least_squares(n_free):
    """Oracle: NumPy's least squares, pixel by pixel, of residuals that are linear in contrast, delay and time constant."""
    random, n_pixels = np.random.default_rng(3), 4
    jacobian = random.normal(size=(n_free, 6, n_pixels)) * np.array([1.0, 3e3, 2e3])[:n_free, None, None]
    left = random.normal(size=(6, n_pixels))
    at = PixelNumbers(contrast_dn=np.full(4, 300.0), delay_s=np.full(4, 1e-3), response_s=np.full(4, 8e-3))
    found = pixel_fit._stepped(at, jacobian, left)
    numbers = np.array([found.contrast_dn, found.delay_s, found.response_s])
    expected = np.tile([[300.0], [1e-3], [8e-3]], 4)
    for k in range(n_pixels):
        expected[:n_free, k] += np.linalg.lstsq(jacobian[:, :, k].T, left[:, k], rcond=None)[0]
    np.testing.assert_allclose(numbers, expected, rtol=1e-9)


def test_no_step_makes_a_time_constant_less_than_half_of_what_it_was():
    """Oracle: by hand; each residual is one number alone, and wants it by 1 less."""
    at = PixelNumbers(contrast_dn=np.array([3.0]), delay_s=np.array([2.0]), response_s=np.array([8e-3]))
    found = pixel_fit._stepped(at, np.eye(3)[:, :, None], -np.ones((3, 1)))
    assert (found.contrast_dn[0], found.delay_s[0]) == (pytest.approx(2.0), pytest.approx(1.0))
    assert found.response_s[0] == pytest.approx(4e-3)

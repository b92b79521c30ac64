"""Which pixels of a map follow the wheel as the others do: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import pixel_fit
from irtiming.physics import wheel_harmonics
from irtiming.physics.light.pixel import PixelLight, PixelNumbers, linearised
from irtiming.physics.response import first_order_lag, integration_window
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


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("response", "n_free"), [(first_order_lag, 3), (integration_window, 2)])
def test_pixels_are_found_whatever_their_contrast_delay_and_constant(sign, response, n_free):
    """Oracle: the numbers whose harmonics are given; before a colder blackbody all contrasts are negative.

    Some of the light leaks into the harmonics, in proportion to what a pixel has of it, and by its own angle and delay.
    """
    orders, random = np.array([2, 6, 10]), np.random.default_rng(4)
    wheel = np.array([0.6, -0.2, 0.05]) * np.exp(1j * orders * 0.02)
    light = np.exp(-1j * np.multiply.outer(orders, [-0.5, 0.0, 0.4])) * np.array([0.9, 1.0, 0.7])
    pixels = PixelLight(orders=orders, light=light, wheel=wheel, angular_frequency_rad_per_s=20.0, response=response)
    true = PixelNumbers(
        contrast_dn=sign * np.array([300.0, 330.0, 250.0]), delay_s=np.array([1e-4, -2e-4, 3e-5]),
        response_s=np.array([8e-3, 8.3e-3, 7.6e-3]) if n_free == 3 else np.full(3, 8e-3),
    )  # fmt: skip
    shown = pixel_fit._packed(linearised(pixels, true)[0])
    unlike = np.diag(random.uniform(0.5, 2.0, 6))
    seen = SimpleNamespace(
        angle_rad=np.array([0.5, 0.0, -0.4]), share=np.array([1.0, 0.6, 0.3]), reach_rad=np.array([0.1, 0.2, 0.3])
    )

    def leaking(angle, reach):
        return 1e-7 * np.cos(np.arange(6)[:, None] + 3 * angle) * (1 + reach)

    leaked = true.contrast_dn * seen.share * leaking(seen.angle_rad - 20.0 * true.delay_s, seen.reach_rad)
    sums = SimpleNamespace(
        signal=np.zeros((6, 3)), root=unlike, harmonics=lambda leak: shown + leaked - leak,
        noise=lambda leak: np.abs(leak[0] / leaked[0]), leak=SimpleNamespace(of=leaking),
    )  # fmt: skip
    reference = pixel_fit.Reference(read_s=np.zeros(4), row_delay_s=0.0, response_s=8e-3, memory=0.0, blade=0.0)
    begun = pixel_fit._first(sums, pixels, response_s=8e-3)
    assert np.sign(begun.contrast_dn).tolist() == [sign] * 3
    np.testing.assert_allclose(begun.contrast_dn, true.contrast_dn, rtol=0.05)
    np.testing.assert_allclose(begun.delay_s, true.delay_s, atol=5e-4)  # their constants are not those of the reference
    found, noise, _, left = pixel_fit._iterated(sums, pixels, seen, reference=reference, n_free=n_free)
    np.testing.assert_allclose(found.contrast_dn, true.contrast_dn, rtol=1e-9)
    np.testing.assert_allclose(found.delay_s, true.delay_s, atol=1e-12)
    np.testing.assert_allclose(found.response_s, true.response_s, rtol=1e-9)
    np.testing.assert_allclose(left, 0.0, atol=1e-6)
    np.testing.assert_allclose(noise, 1.0, rtol=1e-7)  # of the leak that there is

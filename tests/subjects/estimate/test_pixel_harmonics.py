"""Harmonics and noise of pixels from sums with waves: noise that was drawn, over frames that leave some angles out."""

import numpy as np
import pytest

from irtiming.estimate.pixel_harmonics import Leak, sums_with_waves
from irtiming.physics import wheel_waves
from irtiming.records.pixel_waves import PixelWaves

TURN = 2 * np.pi
_SIGNAL, _QUIET = np.array([2, 6]), np.arange(21, 41)


@pytest.mark.parametrize("sway", [0.0, 0.1])
def test_harmonics_and_noise_are_those_of_the_pixels(sway):
    """Oracle: what was put into the frames: two orders, noise of 3 and 12 DN, and order 10, which leaks into the sums.

    So do all orders where the gain sways.
    """
    rng = np.random.default_rng(4)
    angle = np.sort(rng.uniform(0, TURN, 500))
    segment = np.zeros(500, np.int64)
    weight = wheel_waves.waves(angle, np.concatenate([_SIGNAL, _QUIET]), segment=segment)
    noise = np.repeat([3.0, 12.0], 200)
    true = {2: 400 * np.exp(0.3j), 6: 60 * np.exp(-1.1j), 10: 25.0 + 0j}
    light = sum((size * np.exp(1j * order * angle)).real for order, size in true.items())
    gain = 1 + sway * np.sin(3 * rng.uniform(0, TURN, 500))
    gain /= gain.mean()
    frames = (gain * light)[:, None] + noise * rng.standard_normal((500, 400))
    waves = PixelWaves(
        signal_orders=_SIGNAL, quiet_orders=_QUIET, wheel_angle_rad=angle, segment=segment, row_px=np.arange(400),
        column_px=np.zeros(400, int), sums_dn=weight @ frames,
    )  # fmt: skip
    point = np.zeros(41, complex)
    point[list(true)] = list(true.values())
    made = sums_with_waves(waves, angle, relative_gain=gain, point=point, name="a")
    leak = made.leak.of(np.zeros(400), np.zeros(400))
    found = made.harmonics(leak)
    np.testing.assert_allclose(
        found.mean(axis=1),
        [true[2].real, true[6].real, -true[2].imag, -true[6].imag],
        atol=5 * 12 / np.sqrt(500 * 400 / 2),
    )
    spread = made.noise(leak)
    assert np.sqrt(np.mean(spread[:200] ** 2)) == pytest.approx(3.0, rel=0.03)
    assert np.sqrt(np.mean(spread[200:] ** 2)) == pytest.approx(12.0, rel=0.03)


def test_the_leak_of_a_pixel_anywhere_is_the_sum_of_its_orders():
    """Oracle: sum of a_m exp(-i m phi) exp(-m^2 s^2 / 2), term by term; angles between those of a table, and three reaches."""
    rng = np.random.default_rng(6)
    spectrum = (rng.standard_normal((3, 30)) + 1j * rng.standard_normal((3, 30))) / (1 + np.arange(30)) ** 2
    angle, reach = rng.uniform(-TURN, 2 * TURN, 90), np.repeat([0.01, 0.05, 0.2], 30)
    order = np.arange(30)[:, None]
    shown = np.exp(-1j * order * angle) * np.exp(-0.5 * (order * reach) ** 2)
    np.testing.assert_allclose(Leak(spectrum=spectrum).of(angle, reach), (spectrum @ shown).real, atol=3e-6)

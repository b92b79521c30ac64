"""Schatz 2023, section 3.1: the cooled camera, table 1, the two absolute delays and a candidate for their difference."""

import numpy as np
import pytest

from irtiming.estimate.published import slope_delays, slopes
from irtiming.physics.wheel import wheel_model
from irtiming.records.exposed import ExposedFraction
from irtiming.reduce.published import plateaus

TURN = 2 * np.pi
NOMINAL_S = np.array([0.0, 0.025, 0.05, 0.075, 0.1])
TABLE_1_US = np.array([-1.745, -0.652, 3.000, -2.021])
FALLING_US, RISING_US = 567.74, 488.91
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA, GATE, CENTRE = 5 / 12 * np.pi, 0.2682, -np.pi / 2
MODEL = wheel_model(EDGES, GATE, opening_angle_rad=GAMMA, centre_angle_rad=CENTRE)


def _averaged(angle, fraction, set_delay_s, *, rate_hz=3.0):
    return ExposedFraction(
        trigger_delay_time_set_s=set_delay_s,
        rotation_speed_hz=rate_hz,
        angular_frequency_rad_per_s=TURN * rate_hz,
        names=(f"{1e3 * set_delay_s:.0f} ms",),
        files=(f"{1e3 * set_delay_s:.0f}.nxs",),
        wheel_angle_rad=angle,
        fraction=fraction,
        u_wheel_angle_rad=None,
        u_fraction=None,
        plateaus=plateaus.find(angle, fraction, name="paper"),
    )


def _counted(threshold, *, window_s=250e-6, delay_s=4e-4, rate_hz=3.0, n_pixels=4000):
    """Share of the opening's pixels that are counted, one sharp pixel after the other.

    The pixel at polar angle phi sees the blackbody while its wheel coordinate is in a cutout; it is counted when that
    is so for more than ``threshold`` of its window. No blur: each pixel is a point. The grid of points lies elsewhere in
    each frame, so that whole counts do not beat with the angles.
    """
    omega = TURN * rate_hz
    angle = TURN * (np.arange(1000) + 0.21) / 1000
    offset = np.mod(np.arange(angle.size) * (np.sqrt(5) - 1) / 2, 1)  # even over any stretch of frames
    sweep = omega * window_s

    def share(frame):
        phi = CENTRE + GAMMA * ((np.arange(n_pixels) + offset[frame]) / n_pixels - 0.5)
        start = np.mod(np.pi / 2 + GATE + angle[frame] + omega * delay_s - phi, TURN)
        seen = np.zeros_like(start)
        for a, b in ((EDGES[1], EDGES[2]), (EDGES[3], TURN), (EDGES[1] + TURN, EDGES[2] + TURN)):
            seen += np.maximum(np.minimum(start + sweep, b) - np.maximum(start, a), 0)
        return np.mean(seen / sweep > threshold)

    return angle, np.array([share(frame) for frame in range(angle.size)])


def _delays_us(threshold, *, window_s=250e-6, rate_hz=3.0):
    angle, fraction = _counted(threshold, window_s=window_s, rate_hz=rate_hz)
    fit = slopes.fit(
        _averaged(angle, fraction, 0.0, rate_hz=rate_hz),
        MODEL,
        angular_frequency_rad_per_s=TURN * rate_hz,
        limits=(0.05, 0.95),
    )
    found = slope_delays.estimate([fit], MODEL, integration_time_s=window_s).estimate
    return {n: 1e6 * v for n, v in zip(found.names, found.values, strict=True)}


def test_deviations_of_table_1_have_an_rms_of_2_us():
    """Oracle: table 1; pixels counted at its measured delays come back with its deviations, rms 2.034 us."""
    fits = []
    for nominal, deviation in zip(NOMINAL_S, [0, *TABLE_1_US], strict=True):
        angle, fraction = _counted(0.5, delay_s=nominal + 5e-4 + 1e-6 * deviation, n_pixels=8009)
        fits.append(
            slopes.fit(
                _averaged(angle, fraction, float(nominal)),
                MODEL,
                angular_frequency_rad_per_s=TURN * 3,
                limits=(0.05, 0.95),
            )
        )
    relative = slope_delays.relative_delays(fits)
    deviations = np.array([1e6 * (r.value_s - r.nominal_s) for r in relative[1:]])
    np.testing.assert_allclose(deviations, TABLE_1_US, atol=0.1)
    assert np.sqrt(np.mean(deviations**2)) == pytest.approx(2.034, abs=0.05)


def test_threshold_off_the_middle_splits_the_two_absolute_delays():
    """Oracle: one pixel; a falling edge is read q T after the start, a rising one (1 - q) T: the paper's split at 0.658."""
    split = FALLING_US - RISING_US
    assert split == pytest.approx(78.83, abs=0.01)
    found = _delays_us(0.658)
    assert found["trigger_delay_falling"] - found["trigger_delay_rising"] == pytest.approx(split, abs=1)
    # the start of the window is at 400 us; half of it was taken off already
    assert found["trigger_delay_falling"] == pytest.approx(400 + (0.658 - 0.5) * 250, abs=1)
    assert found["trigger_delay_rising"] == pytest.approx(400 - (0.658 - 0.5) * 250, abs=1)
    assert found["exposure_midpoint_delay"] == pytest.approx(525, abs=1)


@pytest.mark.parametrize("threshold", [0.2, 0.5, 0.8])
def test_split_is_twice_the_distance_from_half_level_times_the_window(threshold):
    """Oracle: (2 q - 1) T; nothing at half level."""
    found = _delays_us(threshold)
    split = found["trigger_delay_falling"] - found["trigger_delay_rising"]
    assert split == pytest.approx((2 * threshold - 1) * 250, abs=1)


@pytest.mark.parametrize(("window_s", "rate_hz"), [(500e-6, 3.0), (250e-6, 9.0), (1e-3, 1.0)])
def test_split_grows_with_the_window_not_with_the_wheel(window_s, rate_hz):
    """Oracle: (2 q - 1) T at any rate; one wheel rate could not tell it from an angle error, several can."""
    found = _delays_us(0.7, window_s=window_s, rate_hz=rate_hz)
    split = found["trigger_delay_falling"] - found["trigger_delay_rising"]
    assert split == pytest.approx(0.4e6 * window_s, abs=3 / rate_hz)

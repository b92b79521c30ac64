"""The twin's detector: whole numbers, noise, fixed pattern."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import PlanError
from irtiming.twin.frames import nonuniformity_reference
from irtiming.twin.noise import digitise, fixed_pattern, generator
from irtiming.twin.response_curve import ResponseCurve
from irtiming.twin.scene import Detector, Radiance

_FLAT = Detector(rows=40, columns=50, gain_spread=0.0, offset_spread_dn=0.0, noise_dn=0.0)


def _read_out(detector: Detector, level_dn: float, *, seed: int = 0) -> np.ndarray:
    out = np.empty((detector.rows, detector.columns), np.uint16)
    signal = np.full(out.shape, level_dn, np.float32)
    digitise(signal, fixed_pattern(detector), random=generator(seed, "frame", index=7), out=out)
    return out


@pytest.mark.parametrize(
    ("level", "expected"), [(100.4, 100), (100.6, 101), (-5.0, 0), (20_000.0, 16_383), (16_383.4, 16_383)]
)
def test_values_are_rounded_and_clipped(level: float, expected: int) -> None:
    """Oracle: 14 bits by hand."""
    assert set(_read_out(_FLAT, level).ravel()) == {expected}


def test_saturation_below_the_highest_number() -> None:
    """Oracle: a well that is full at 9000 DN."""
    assert _read_out(replace(_FLAT, saturation_dn=9000.0), 12_000).max() == 9000


def test_noise_has_the_stated_spread_and_no_bias() -> None:
    """Oracle: variance of Gaussian noise plus 1/12 for rounding; 2000 values."""
    values = _read_out(replace(_FLAT, noise_dn=20.0), 5000.3).astype(float)
    assert values.std() == pytest.approx(np.sqrt(20**2 + 1 / 12), rel=0.06)
    assert values.mean() == pytest.approx(5000.3, abs=3 * 20 / np.sqrt(values.size))


def test_noise_hangs_on_seed_and_frame_alone() -> None:
    """Oracle: equality."""
    noisy = replace(_FLAT, noise_dn=20.0)
    assert np.array_equal(_read_out(noisy, 5000, seed=1), _read_out(noisy, 5000, seed=1))
    assert not np.array_equal(_read_out(noisy, 5000, seed=1), _read_out(noisy, 5000, seed=2))
    assert generator(1, "frame", index=2).random() != generator(1, "frame", index=3).random()
    assert generator(1, "frame", index=2).random() != generator(1, "edges", index=2).random()


def test_fixed_pattern_is_affine_and_the_same_for_each_frame() -> None:
    """Oracle: two-point correction by hand restores a third level within rounding."""
    detector = replace(_FLAT, gain_spread=0.02, offset_spread_dn=60.0, pattern_seed=5)
    low, high, third = (_read_out(detector, level).astype(float) for level in (1000.0, 9000.0, 5000.0))
    assert low.std() > 40
    assert (third - low) / (high - low) == pytest.approx(0.5, abs=2e-4)


def test_dead_pixels_see_nothing() -> None:
    """Oracle: counting pixels that do not move between two levels."""
    detector = replace(_FLAT, noise_dn=5.0, dead_pixels=12)
    still = _read_out(detector, 2000.0) == _read_out(detector, 8000.0)
    assert still.sum() == 12
    assert set(_read_out(detector, 2000.0)[still]) <= {0, 16_383}


def test_reference_is_the_mean_of_its_frames() -> None:
    """Oracle: NumPy mean and standard deviation over the raw stack; scatter of a mean is noise / sqrt n."""
    detector = replace(_FLAT, noise_dn=20.0)
    radiance = replace(Radiance(), reference_frames=25)
    reference = nonuniformity_reference(radiance, fixed_pattern(detector), seed=3)
    assert reference.low_frames is not None
    assert reference.high_frames is not None
    raw = reference.low_frames.pick(list(range(25))).astype(float)
    assert reference.low_dn == pytest.approx(raw.mean(axis=0))
    assert reference.low_noise_dn == pytest.approx(raw.std(axis=0, ddof=1))
    assert (reference.low_dn - 1000.0).std() == pytest.approx(20 / 5, rel=0.1)
    assert reference.high_dn.mean() == pytest.approx(1000 + 15 * 530, abs=1)
    assert not np.array_equal(raw[0] - raw.mean(), reference.high_frames.pick([0])[0] - reference.high_dn)


@pytest.mark.parametrize(
    ("level", "expected"), [(1000.0, 1000), (2000.0, 2000), (1250.0, 1500), (900.0, 1000), (3000.0, 2414)]
)
def test_a_curve_bends_the_signal_before_noise_and_rounding(level: float, expected: int) -> None:
    """Oracle: by hand; the square root between 1000 and 2000 DN, on beyond it, and nothing below."""
    assert set(
        _read_out(replace(_FLAT, curve=ResponseCurve(exponent=0.5, low_dn=1000, high_dn=2000)), level).ravel()
    ) == {expected}


def test_a_curve_that_no_camera_has_is_refused() -> None:
    """Oracle: the exponent and the levels that were asked for."""
    with pytest.raises(PlanError, match=r"exponent 3 between 0 and 1 DN .* between 0\.5 and 2"):
        ResponseCurve(exponent=3.0)

"""Row sums of a camera whose gain sways, against the sway that was put in."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import row_sway

TICKS = 1_000_000 * np.arange(500)


def _fit(gain, *, noise=2e-3, seed=1, kept=None):
    random = np.random.default_rng(seed)
    model = np.clip(0.5 + np.sin(0.622 * np.arange(500)[:, None] + np.linspace(0, 0.3, 8)), 0, 1)
    kept = np.ones(500, bool) if kept is None else kept
    return SimpleNamespace(
        kept=kept, model=model[kept], noise=np.full(8, noise), relative_gain=None,
        fraction=(gain[:, None] * model + noise * random.normal(size=model.shape))[kept],
    )  # fmt: skip


def _sway(size):
    time = np.arange(500) / 500
    sway = size * (np.sin(2 * np.pi * 1.3 * time) + 0.4 * np.cos(2 * np.pi * 3.1 * time))
    return 1 + sway - sway.mean()


def test_a_sway_is_found_to_the_noise():
    """Oracle: the gain that made the sums; eight rows of 500 frames know it to a twentieth."""
    kept = np.random.default_rng(3).random(500) > 0.1
    found = row_sway.relative_gain(_fit(_sway(0.02), kept=kept), trigger_ticks=TICKS, segment=np.zeros(500, int))
    assert np.sqrt(np.mean((found - _sway(0.02)) ** 2)) < 1e-3


def test_each_stretch_between_shutter_events_has_its_own():
    """Oracle: as above; the mean gain of a stretch is the fit's affair, and a stretch of few frames is left alone."""
    segment = np.repeat([0, 1, 2], [230, 220, 50])
    gain = _sway(0.02)
    for number in (0, 1, 2):
        gain[segment == number] /= gain[segment == number].mean()
    found = row_sway.relative_gain(_fit(gain), trigger_ticks=TICKS, segment=segment)
    assert np.sqrt(np.mean((found - gain)[segment < 2] ** 2)) < 1e-3
    assert np.all(found[segment == 2] == 1)


def test_a_steady_gain_stays_and_one_that_was_found_is_kept():
    """Oracle: by hand."""
    steady = _fit(np.ones(500))
    assert np.all(row_sway.relative_gain(steady, trigger_ticks=TICKS, segment=np.zeros(500, int)) == 1)
    steady.relative_gain = _sway(0.1)
    assert row_sway.relative_gain(steady, trigger_ticks=TICKS, segment=np.zeros(500, int)) is steady.relative_gain


@pytest.mark.parametrize("contrast", [-700.0, 700.0])
def test_steadied_row_sums_are_those_of_a_steady_gain(contrast):
    """Oracle: the sums that a steady gain would have made; levels and gains are the rows' own, in each stretch others."""
    fit = _fit(np.ones(500))
    stretches = [np.arange(500) < 230, np.arange(500) >= 230]
    step = np.where(stretches[0], 1.0, 1.3)[:, None]
    own, level = contrast * np.linspace(1, 2, 8) * step, (9e4 + 100 * np.arange(8)) * step
    gain = _sway(0.03)
    sums = level + own * gain[:, None] * fit.model
    found = row_sway.steadied(sums, fit.model, gain=gain, stretches=stretches)
    np.testing.assert_allclose(found, level + own * fit.model, atol=1e-6 * abs(contrast))
    assert np.max(np.abs(sums - found)) > 0.03 * abs(contrast)  # something was taken out


def test_a_stretch_of_a_single_frame_stays():
    """Oracle: by hand; one frame shows neither gain nor level."""
    sums, fit = np.full((500, 8), 9e4), _fit(np.ones(500))
    gain = np.ones(500)
    found = row_sway.steadied(sums, fit.model, gain=gain, stretches=[np.arange(500) < 499, np.arange(500) == 499])
    assert np.array_equal(found, sums)

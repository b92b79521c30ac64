"""Two-point correction folded into one raw threshold per pixel, against correcting and comparing in the open."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from irtiming.errors import ReductionError
from irtiming.reduce.nonuniformity import Correction, corrected, correction, fingerprint, raw_thresholds, u_gain

_FINITE = st.floats(-1e5, 1e5)


def _correction(gain, offset, bad=None):
    gain, offset = np.atleast_2d(gain).astype(float), np.atleast_2d(offset).astype(float)
    return Correction(gain=gain, offset_dn=offset, bad=np.zeros(gain.shape, bool) if bad is None else bad)


def _open_comparison(raw, threshold, correct):
    """Correct every pixel in double precision, then compare."""
    return correct.offset_dn + correct.gain * raw > threshold


@pytest.fixture
def references(flat_reference):
    """Detector of 20 x 30 pixels with known gain and offset errors."""
    rng = np.random.default_rng(0)
    return flat_reference(rng.normal(1, 0.1, (20, 30)), rng.normal(0, 200, (20, 30)))


def test_thresholds_agree_with_correct_then_compare_on_random_frames():
    """Oracle: the correction carried out on every pixel; 3 million comparisons."""
    rng = np.random.default_rng(1)
    correct = _correction(rng.uniform(0.3, 3, (100, 100)), rng.normal(0, 500, (100, 100)))
    limits = raw_thresholds(5234.56789, correct)
    frames = rng.integers(1, 16384, (300, 100, 100), dtype=np.uint16)
    expected = _open_comparison(frames, 5234.56789, correct)
    assert 0.1 < expected.mean() < 0.9
    assert np.array_equal(frames > limits, expected)


@given(st.floats(0.05, 20), _FINITE, st.integers(1, 65534), st.integers(-2, 2))
def test_thresholds_agree_at_the_very_boundary(gain, offset, raw, ulps):
    """Oracle: correct, then compare; the threshold is the corrected value itself, or a rounding error beside it."""
    correct = _correction(gain, offset)
    threshold = float(correct.offset_dn[0, 0] + correct.gain[0, 0] * raw)
    threshold += ulps * np.spacing(threshold)
    limit = raw_thresholds(threshold, correct)
    for value in (max(raw - 1, 1), raw, raw + 1):
        value = np.uint16(value)
        assert bool(value > limit[0, 0]) is bool(_open_comparison(float(value), threshold, correct)[0, 0])


@given(st.floats(0.05, 20), _FINITE, _FINITE, st.integers(1, 65535))
def test_thresholds_agree_anywhere(gain, offset, threshold, raw):
    """Oracle: correct, then compare; thresholds far outside the range of the raw values among them."""
    correct = _correction(gain, offset)
    limit = raw_thresholds(threshold, correct)
    assert bool(np.uint16(raw) > limit[0, 0]) is bool(_open_comparison(float(raw), threshold, correct)[0, 0])


def test_hand_computed_thresholds():
    """Oracle: by hand; 2 raw + 10 > 100 from raw 46 on, > 101 also from 46 on, 0.5 raw > 100 from 201 on."""
    assert raw_thresholds(100, _correction(2, 10)).tolist() == [[45]]
    assert raw_thresholds(101, _correction(2, 10)).tolist() == [[45]]
    assert raw_thresholds(102, _correction(2, 10)).tolist() == [[46]]
    assert raw_thresholds(100, _correction(0.5, 0)).tolist() == [[200]]


def test_bad_pixels_never_count():
    """Oracle: the docstring; the largest raw value does not exceed the largest value."""
    bad = np.array([[False, True]])
    limits = raw_thresholds(100, _correction([[1, 0]], [[0, 5000]], bad))
    assert (np.array([[65535, 65535]], np.uint16) > limits).tolist() == [[True, False]]
    assert limits.dtype == np.uint16


def test_correction_makes_the_references_flat(paper_wheel, recorded, references):
    """Oracle: the definition; each reference becomes its own mean over the detector."""
    recording = recorded(paper_wheel(duration_s=5.0), frames=np.zeros((2, 20, 30)), nonuniformity=references)
    correct = correction(recording)
    for level in (references.low_dn, references.high_dn):
        np.testing.assert_allclose(correct.offset_dn + correct.gain * level, level.mean(), rtol=1e-12)
    assert not correct.bad.any()


def test_corrected_frames_follow_the_formula(paper_wheel, recorded, references):
    """Oracle: L + (raw - low) (H - L) / (high - low) in double precision."""
    recording = recorded(paper_wheel(duration_s=5.0), frames=np.zeros((2, 20, 30)), nonuniformity=references)
    raw = np.random.default_rng(3).integers(0, 16384, (20, 30), dtype=np.uint16)
    low, high = references.low_dn, references.high_dn
    expected = low.mean() + (raw - low) * (high.mean() - low.mean()) / (high - low)
    np.testing.assert_allclose(corrected(raw, correction(recording)), expected, rtol=1e-6, atol=0.01)


def test_without_reference_nothing_is_corrected(paper_wheel, recorded):
    """Oracle: the docstring; gain 1, offset 0, no bad pixel."""
    correct = correction(recorded(paper_wheel(duration_s=5.0), frames=np.zeros((2, 4, 5))))
    assert np.all(correct.gain == 1)
    assert np.all(correct.offset_dn == 0)
    assert not correct.bad.any()


def test_dead_hot_and_blinking_pixels_are_found(paper_wheel, recorded, references):
    """Oracle: the pixels that were made dead, twentyfold and noisy; they do not enter the detector's mean."""
    low, high, noise = references.low_dn.copy(), references.high_dn.copy(), references.low_noise_dn.copy()
    high[3, 4] = low[3, 4]
    high[5, 6] = low[5, 6] + 20_000
    noise[7, 8] = 30
    changed = replace(references, low_dn=low, high_dn=high, low_noise_dn=noise)
    correct = correction(recorded(paper_wheel(duration_s=5.0), frames=np.zeros((2, 20, 30)), nonuniformity=changed))
    assert np.argwhere(correct.bad).tolist() == [[3, 4], [5, 6], [7, 8]]
    assert np.all(correct.gain[correct.bad] == 0)
    good = ~correct.bad
    np.testing.assert_allclose((correct.offset_dn + correct.gain * high)[good], high[good].mean())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: replace(r, high_dn=r.low_dn + 0.1), "differ by 0.1 DN .median., which is no more than their noise"),
        (
            lambda r: replace(r, low_dn=r.high_dn, high_dn=r.low_dn),
            "are exchanged: high is [0-9.]+ DN .median. darker than low, and must be the brighter one, .*; exchange the two",
        ),
        (
            lambda r: replace(r, low_dn=r.low_dn[:5], high_dn=r.high_dn[:5]),
            "measure .5, 30. pixels, the frames .20, 30.",
        ),
        (
            lambda r: replace(r, high_dn=np.where(np.arange(30) < 3, r.low_dn, r.high_dn)),
            "60 of 600 pixels do not answer to the reference step or blink, at most 5% can be replaced",
        ),
    ],
)
def test_references_that_cannot_correct_are_refused(paper_wheel, recorded, references, change, message):
    """Oracle: by hand; no step, exchanged references, another window, a tenth of the pixels dead."""
    recording = recorded(paper_wheel(duration_s=5.0), frames=np.zeros((2, 20, 30)), nonuniformity=change(references))
    with pytest.raises(ReductionError, match=message):
        correction(recording)


def test_gains_are_known_to_the_noise_of_the_reference_frames(references):
    """Oracle: the spread of gains from 400 draws of references with that noise; one frame is as noisy as it is.

    Without references no gain errs.
    """
    rng = np.random.default_rng(2)
    noise = references.low_noise_dn / np.sqrt(references.n_frames)
    step = references.high_dn - references.low_dn
    drawn = [step + noise * (rng.standard_normal(step.shape) - rng.standard_normal(step.shape)) for _ in range(400)]
    recording = SimpleNamespace(nonuniformity=references, frames=np.zeros((3, *step.shape)), name="made up")
    found = u_gain(recording, correction(recording))
    np.testing.assert_allclose(found, np.std(drawn, axis=0) / step, rtol=0.2)
    single = SimpleNamespace(**vars(recording) | {"nonuniformity": replace(references, n_frames=1)})
    np.testing.assert_allclose(u_gain(single, correction(single)), found * np.sqrt(references.n_frames))
    other = replace(references, high_dn=references.high_dn + 1)
    assert fingerprint(recording) == fingerprint(recording) != fingerprint(SimpleNamespace(nonuniformity=other))
    bare = SimpleNamespace(nonuniformity=None, frames=np.zeros((3, 4, 5)))
    assert not u_gain(bare, _correction(np.ones((4, 5)), np.zeros((4, 5)))).any()
    assert fingerprint(bare) == ""


def test_a_region_has_the_correction_of_its_pixels():
    """Oracle: by hand; rows 1 and 2, columns 2 to 4 of numbers that say their place."""
    place = np.arange(24.0).reshape(4, 6)
    within = _correction(place, -place, bad=place == 9).within((1, 3, 2, 5))
    assert within.gain.tolist() == [[8, 9, 10], [14, 15, 16]]
    assert within.offset_dn.tolist() == [[-8, -9, -10], [-14, -15, -16]]
    assert within.bad.tolist() == [[False, True, False], [False, False, False]]


def test_a_few_pixels_far_too_lively_spoil_no_others(flat_reference):
    """Oracle: by hand; 24 of 600 pixels answer a hundred times as much, which makes the mean five times as large."""
    gain = np.ones((20, 30))
    gain[5, :24] = 100.0
    references = flat_reference(gain, np.zeros((20, 30)))
    recording = SimpleNamespace(nonuniformity=references, frames=np.zeros((2, 20, 30)), name="made up")
    assert np.array_equal(correction(recording).bad, gain > 1)


@pytest.mark.parametrize("usual", [1.0, 20.0])
def test_a_pixel_is_noisy_against_the_others(flat_reference, usual):
    """Oracle: by hand; seven times the noise of the others is too much, five times is not, whatever that is in DN."""
    noise = np.full((20, 30), usual)
    noise[4, 5], noise[6, 7] = 7 * usual, 5 * usual
    references = flat_reference(np.ones((20, 30)), np.zeros((20, 30)), noise=noise)
    recording = SimpleNamespace(nonuniformity=references, frames=np.zeros((2, 20, 30)), name="made up")
    assert np.argwhere(correction(recording).bad).tolist() == [[4, 5]]


@pytest.mark.parametrize(
    ("step", "says"), [(-4, "are exchanged"), (-2, "no more than"), (2, "no more than"), (4, None)]
)
def test_references_differ_where_they_do_so_by_three_of_their_own_noise(flat_reference, step, says):
    """Oracle: by hand; a mean of 50 frames of 3 DN of noise has 3 / sqrt(50) DN: references differ by two or four of that."""
    nothing = np.zeros((20, 30))
    references = flat_reference(nothing + 1, nothing, levels=(5000.0, 5000.0 + step * 3 / np.sqrt(50)))
    recording = SimpleNamespace(nonuniformity=references, frames=np.zeros((2, 20, 30)), name="made up")
    with pytest.raises(ReductionError, match=says) if says else nullcontext():
        assert not correction(recording).bad.any()

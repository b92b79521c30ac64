"""What rig.toml says of the share of the frame before, against what the frames do."""

from dataclasses import dataclass

import numpy as np
import pytest

from irtiming.estimate import frame_memory, shared_numbers
from irtiming.records.estimate import Estimate
from irtiming.records.rig import Measured


@dataclass
class _Fit:
    estimate: Estimate


@dataclass
class _Residuals:
    residual: np.ndarray
    noise: float = 1.0


def _fit(name, share, u):
    return _Fit(Estimate(names=(name,), units=("1",), values=np.array([share]), covariance=np.array([[u**2]])))


@pytest.mark.parametrize("name", ["recursive_filter", "pixel_memory"])
@pytest.mark.parametrize(
    ("stated", "contradicts"),
    [(Measured(0.0, 1e-3), False), (Measured(0.0, 1e-4), True), (Measured(0.004, 1e-4), False)],
)
def test_frames_that_contradict_the_statement_put_the_result_in_doubt(name, stated, contradicts):
    """Oracle: by hand; two recordings of 0.4 %, u = 0.03 %, know it to 0.021 %: 3.9 u from 0 with u = 0.1 %, 17 u with 0.01 %."""
    found = frame_memory.of_stated([_fit(name, 0.004, 3e-4)] * 2, stated)
    assert [one.code for one in found] == (["frame-memory-contradicted"] if contradicts else [])
    assert all(one.severity == "doubt" for one in found)


def test_nothing_stated_or_nothing_free_is_no_contradiction():
    """Oracle: by hand."""
    assert frame_memory.of_stated([_fit("pixel_memory", 0.5, 1e-3)], None) == ()
    assert frame_memory.of_stated([_fit("time_constant", 0.5, 1e-3)], Measured(0.0)) == ()


@pytest.mark.parametrize(("u", "counted"), [(2e-4, 2e-4), (0.0, 1e-7)])
def test_a_stated_share_is_a_prior_of_the_number_that_has_it(u, counted):
    """Oracle: by hand; every other number stays, and a share stated without uncertainty is as good as exact."""
    own = [
        shared_numbers.same("pixel_memory", [None], start=0.01, unit="1"),
        shared_numbers.same("opening_angle", [None], start=1.3),
    ]
    memory, other = shared_numbers.with_stated_memory(own, Measured(0.002, u))
    assert (memory.known, memory.u, memory.start, memory.kind) == (0.002, counted, 0.01, "B")
    assert memory.measured == (u, "1")
    assert other is own[1]
    assert shared_numbers.with_stated_memory(own, None) == own


@pytest.mark.parametrize(("name", "u"), [("pixel_memory", 0.05), ("recursive_filter", 0.5)])
def test_pixels_remember_little_and_a_filter_is_as_somebody_has_set_it(name, u):
    """Oracle: by hand; five times what photon detectors keep at most, and what filters take; about none."""
    number = shared_numbers.memory(name, [None, None], start=0.2)
    assert (number.start, number.known, number.u, number.unit) == (0.2, 0.0, u, "1")
    assert number.effects == [{name: 1.0}] * 2


@pytest.mark.parametrize("name", ["pixel_memory", "recursive_filter"])
@pytest.mark.parametrize(("share", "is_mostly"), [(0.49, False), (0.51, True)])
def test_frames_that_are_mostly_those_before_are_a_doubt(name, share, is_mostly):
    """Oracle: by hand; from a half on the frames before have the greater part."""
    (found,) = frame_memory.of_result(_fit(name, share, 1e-3).estimate)
    assert (found.code == "frames-mostly-older") == is_mostly
    assert (found.severity == "doubt") == is_mostly


@pytest.mark.parametrize(
    ("share", "u", "codes"),
    [
        (0.339, 0.106, []),  # 0.513 frames old, u = 0.243
        (0.6, 0.15, []),  # 1.5 frames, u = 0.94
        (0.339, 0.05, ["camera-filters-frames"]),  # u = 0.114
        (0.6, 0.05, ["frames-mostly-older"]),  # u = 0.31
        (0.002, 6e-4, ["camera-filters-frames"]),  # a share so small is its age
        (-0.43, 0.61, []),  # -0.30, u = 0.30
        (-0.43, 0.12, ["frame-memory-negative"]),  # u = 0.059
        (1.2, 30.0, []),
    ],
)
def test_a_filter_is_distinguished_from_none_by_the_age_of_what_a_frame_shows(share, u, codes):
    """Oracle: k / (1 - k) and u / (1 - k)^2 by hand; the first is of a camera without a filter at half a turn per frame."""
    assert [one.code for one in frame_memory.of_result(_fit("recursive_filter", share, u).estimate)] == codes


@pytest.mark.parametrize(("share", "u", "contradicts"), [(0.45, 0.083, False), (0.45, 0.05, True)])
def test_a_statement_is_contradicted_by_the_age_too(share, u, contradicts):
    """Oracle: by hand; 0.82 frames old, u = 0.27 or 0.165, where none is stated."""
    assert bool(frame_memory.of_stated([_fit("recursive_filter", share, u)], Measured(0.0, 1e-4))) == contradicts


@pytest.mark.parametrize(
    ("share", "kept", "codes"),
    [
        (0.26, 0.6, ["filter-of-another-kind"]),
        (0.26, 0.0, []),
        (0.0, 0.6, ["residuals-not-white-in-time"]),
        (0.26, 0.25, ["residuals-not-white-in-time"]),
    ],
)
def test_a_filter_that_leaves_successive_frames_correlated_is_of_another_kind(share, kept, codes):
    """Oracle: first-order autoregression, whose correlation is what it keeps, known to 0.02 from 2000 frames of 40 rows."""
    rng = np.random.default_rng(7)
    common = np.zeros(2000)
    for k, new in enumerate(rng.standard_normal(2000)):
        common[k] = kept * common[k - 1] + new
    fit = _Residuals(common[:, None] + 0.1 * rng.standard_normal((2000, 40)))
    estimate = _fit("recursive_filter", share, 0.02).estimate
    found = frame_memory.of_row_fits([fit], estimate)
    assert [one.code for one in found] == codes
    with_white = frame_memory.of_row_fits([fit, _Residuals(rng.standard_normal((2000, 40)))], estimate)
    assert [one.code for one in with_white] == (
        ["residuals-not-white-in-time"] if kept else []
    )  # a level that swayed in one
    assert all((one.severity == "doubt") == (one.code == "filter-of-another-kind") for one in found)

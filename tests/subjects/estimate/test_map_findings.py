"""What is said of maps of pixels."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import map_findings
from irtiming.estimate.map_patterns import RowClock
from irtiming.records.pixel_maps import ReadoutPattern


@pytest.mark.parametrize(
    ("rows", "named"),
    [
        ([0, 1, 2, 7, 8], "image rows 0 to 2 and 7 to 8 hold"),
        ([3, 5], "image rows 3 and 5 hold"),
        ([0, 1, 3, 4], "image rows 0 to 1 and 3 to 4 hold"),
    ],
)
def test_rows_without_a_pixel_are_named_in_runs(rows, named):
    """Oracle: by hand; a single row with pixels parts two runs."""
    maps = SimpleNamespace(unseen_row_px=np.array(rows), fitted_row_delay_s=30e-6)
    (finding,) = map_findings._unseen(maps)
    assert finding.sentence().startswith(named)
    assert map_findings._unseen(SimpleNamespace(unseen_row_px=np.array(rows), fitted_row_delay_s=0.0)) == []


@pytest.mark.parametrize(("n", "ends"), [(8, "(14, 9),"), (11, "(14, 9) and 3 more,")])
def test_the_first_eight_pixels_are_named(n, ends):
    """Oracle: by hand; a column of the map that begins at row 7 and column 9."""
    these = np.zeros((11, 3), bool)
    these[:n, 0] = True
    named = map_findings._named(these, SimpleNamespace(roi=(7, 18, 9, 12)))
    assert named.startswith(f"{n} pixels, in (row, column) (7, 9), (8, 9)")
    assert named.endswith(ends)


def _deviating(*, left_s=0.0, noise_dn=1.0, lag_pull=None, scatter=1.0):
    """Whether one of a hundred pixels strays, of which the others are off by nothing and have a u of 1 us and a noise of 1 DN."""
    n = 100
    left, noise = np.zeros(n), np.ones(n)
    left[3], noise[3] = left_s, noise_dn
    pulls = None
    if lag_pull is not None:
        pulls = np.tile([-1.0, 1.0], n // 2)  # of which half lie beyond 1 on either side: a spread of 1.48
        pulls[3] = lag_pull
    clock = RowClock(row_delay_s=0.0, u_row_delay_s=0.0, left_s=left, scatter=scatter)
    found = map_findings.deviating(SimpleNamespace(u_s=np.full(n, 1e-6)), clock, lag_pulls=pulls, noise_dn=noise)
    assert not np.delete(found, 3).any()
    return bool(found[3])


@pytest.mark.parametrize(
    ("left_s", "scatter", "strays"), [(5.9e-6, 1, False), (-6.1e-6, 1, True), (11e-6, 2, False), (13e-6, 2, True)]
)
def test_a_delay_strays_beyond_six_of_its_uncertainties_as_widely_as_they_scatter(left_s, scatter, strays):
    """Oracle: by hand; u is 1 us."""
    assert _deviating(left_s=left_s, scatter=scatter) is strays


@pytest.mark.parametrize(("noise_dn", "strays"), [(2.9, False), (3.1, True), (np.nan, False)])
def test_a_pixel_strays_that_is_three_times_as_noisy_as_the_median(noise_dn, strays):
    """Oracle: by hand; where noise is not known it is none."""
    assert _deviating(noise_dn=noise_dn) is strays


@pytest.mark.parametrize(("lag_pull", "strays"), [(8.8, False), (9.0, True), (-9.0, True)])
def test_a_time_constant_strays_beyond_six_of_its_uncertainties_as_widely_as_they_scatter(lag_pull, strays):
    """Oracle: by hand; the others are one u off to either side, a spread of 1.483."""
    assert _deviating(lag_pull=lag_pull) is strays


def _pattern(name, *, later_s):
    return ReadoutPattern(name=name, later_s=later_s, u_later_s=1e-7)


@pytest.mark.parametrize(
    ("later_s", "words"), [(6.1e-7, "0.61 µs later"), (-6.1e-7, "0.61 µs earlier"), (5.9e-7, None)]
)
def test_taps_are_told_beyond_six_of_their_uncertainties_to_either_side(later_s, words):
    """Oracle: by hand; u is 0.1 us. Rows that are read later are no taps."""
    maps = SimpleNamespace(patterns=(_pattern("odd columns", later_s=later_s), _pattern("odd rows", later_s=1e-5)))
    found = map_findings._taps(maps)
    assert len(found) == (words is not None)
    assert all(f"columns 1, 3, 5 ... are read {words} (u = 0.10 µs) than columns 0" in one.what for one in found)


@pytest.mark.parametrize("later_s", [6.1e-7, -6.1e-7])
def test_rows_are_told_beyond_six_of_their_uncertainties_to_either_side(later_s):
    """Oracle: by hand; u is 0.1 us. Columns that are read later are no rows."""
    maps = SimpleNamespace(patterns=(_pattern("lower half", later_s=later_s), _pattern("right half", later_s=1e-5)))
    (found,) = map_findings._row_clock(maps, None, None)
    assert "the lower half of the image is read 0.61 µs" in found.what
    assert "right" not in found.what


@pytest.mark.parametrize(("chi_square", "n"), [(1.49, 0), (1.51, 1)])
def test_pixels_that_are_off_by_half_as_much_variance_again_are_told(chi_square, n):
    """Oracle: by hand."""
    assert len(map_findings._unexplained(SimpleNamespace(reduced_chi_square=chi_square))) == n

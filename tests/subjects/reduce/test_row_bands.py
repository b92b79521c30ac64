"""Bands of rows: by hand."""

import pytest

from irtiming.reduce import row_bands


@pytest.mark.parametrize(
    ("n_rows", "starts"),
    [
        (3, [0, 1, 2]),
        (16, list(range(16))),
        (32, list(range(0, 32, 2))),
        (20, [0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13, 15, 16, 17, 18]),
    ],
)
def test_there_are_sixteen_bands_or_as_many_as_rows(n_rows, starts):
    """Oracle: by hand; the k-th of 16 begins at k / 16 of the rows."""
    assert row_bands.starts(n_rows).tolist() == starts

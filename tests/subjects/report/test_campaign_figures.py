"""Figures of a campaign's page."""

import pytest

from irtiming.report.sections import campaign


@pytest.mark.parametrize("most", [1, 3, 40])
def test_findings_are_counted_in_whole_numbers(most):
    """Oracle: by hand; bars as long as there are results, the most frequent on top, and no tick at half a result."""
    drawn = campaign.draw_frequencies({"blades-differ": most, "short-stretch": 1})
    (axes,) = drawn.axes
    assert [bar.get_width() for bar in axes.patches] == [1, most]
    drawn.draw_without_rendering()
    assert [label.get_text() for label in axes.get_yticklabels()] == ["short-stretch", "blades-differ"]
    ticks = axes.get_xticks()
    assert all(tick == round(tick) for tick in ticks)
    assert len(ticks) >= 2

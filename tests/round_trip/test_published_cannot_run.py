"""The published procedure may fail where the default method does not; then it must not take it along."""

import json

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.measurement import analyse, estimate
from irtiming.records.analysis import Analysis
from irtiming.records.choices import Choices
from irtiming.report import certificate
from irtiming.twin import rig as twin
from irtiming.twin.scene import paper_scene, with_wheel_speed

SCENE = with_wheel_speed(paper_scene(60, 80), 3.0, samples=300)
NARROW = (0.5, 0.502)  # too few points of a slope for a line


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    rig = twin.draw(SCENE, seed=3)
    found = analyse(
        twin.series(rig.scene, [0.0, 0.025], repeats=1, seed=3),
        rig.measured,
        choices=Choices(slope_limits=NARROW),
        extras=("published",),
    )
    assert isinstance(found, Analysis)
    return found


def test_the_default_method_goes_on_and_says_so(analysis):
    """Oracle: limits that leave no points on the slopes; the default method does not use them."""
    assert analysis.published.fits == ()
    assert np.isfinite(analysis.best.estimate.values).all()
    assert any(
        "published procedure could not be run" in text and "points between 0.5" in text
        for text in (one.sentence() for one in analysis.findings)
    )


def test_who_asks_for_the_published_method_gets_its_error(analysis):
    """Oracle: the same limits; without a fallback there is no result to give."""
    choices = Choices(slope_limits=NARROW, method="published")
    with pytest.raises(EstimationError, match="points between 0.5"):
        estimate(analysis.recordings[:1], analysis.rig, choices=choices)


def test_page_and_result_stand_without_it(analysis):
    """Oracle: JSON has no NaN, and a page with one method's figures less is still a page."""
    made = certificate.report(analysis)
    assert json.loads(json.dumps(made.result, allow_nan=False))["other_method"]["parameters"] == {}
    assert made.page.rstrip().endswith("</html>")
    assert "published procedure could not be run" in made.page

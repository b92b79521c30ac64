"""The parts of the page Record that change while frames arrive."""

from types import SimpleNamespace

import pytest

from irtiming.session.live_estimate import LiveEstimate
from irtiming.web import live_parts


@pytest.mark.parametrize(
    ("left_out", "note"),
    [
        ((), "from 125 frames; standard uncertainty, k = 1</p>"),
        (("latency of the gates",), "from 125 frames; standard uncertainty, k = 1; not in u: latency of the gates</p>"),
    ],
)
def test_an_estimate_so_far_names_what_its_uncertainty_does_not_hold(left_out, note):
    """Oracle: the words by hand; nothing stands there where all is held."""
    found = LiveEstimate(
        frames=125, values={"row_delay": 1e-5}, uncertainties={"row_delay": 1e-6}, not_in_uncertainty=left_out
    )
    html = live_parts.estimates_html(SimpleNamespace(facts={"estimates": [found.as_json()]}))
    assert "row delay 10.0 ± 1.0 µs" in html
    assert note in html

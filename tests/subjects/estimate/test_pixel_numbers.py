"""Where the search for the mask's misaligned edges begins: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import opening_in_image, pixel_numbers


@pytest.mark.parametrize(
    ("image", "start"),
    [((-4e-3, 3e-3), (-4e-3, 3e-3)), ((1e-5, -2e-5), (1e-4, -1e-4))],
    ids=["as the image has them", "a tenth of u beside zero"],
)
def test_misaligned_edges_are_searched_from_where_the_image_has_them(monkeypatch, image, start):
    """Oracle: by hand; u is 1 mrad, and sums are even in a misalignment, so that a search from zero would stay there."""
    monkeypatch.setattr(opening_in_image, "edge_misalignments", lambda *_, **__: (np.array(image), 1e-3))
    monkeypatch.setattr(opening_in_image, "lost", lambda _: None)
    geometry = SimpleNamespace(rotation="clockwise", model=SimpleNamespace(opening_angle_rad=1.3))
    fit = SimpleNamespace(angular_frequency_rad_per_s=20.0, estimate=SimpleNamespace(value=lambda _: 0.01))
    recording = SimpleNamespace(samples_per_turn=1000)
    own = pixel_numbers.opening_and_window([recording], [fit], geometry=geometry)
    found = {one.name: one for one in own}
    assert (found["lean_low"].start, found["lean_high"].start) == pytest.approx(start)
    assert (found["lean_low"].known, found["lean_high"].known) == pytest.approx(image)
    assert found["lean_low"].u == found["lean_high"].u == 1e-3

"""Where the search for the mask's misaligned edges begins: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import opening_in_image, pixel_numbers


def _recording(rad_per_s, *, integration_time_s=250e-6):
    track = SimpleNamespace(angular_frequency_rad_per_s=rad_per_s)
    return SimpleNamespace(samples_per_turn=1000, track=track, integration_time_s=integration_time_s)


def _numbers(*recordings, geometry):
    fits = [SimpleNamespace(estimate=SimpleNamespace(value=lambda _: 0.01))] * len(recordings)
    return {one.name: one for one in pixel_numbers.opening_and_window(recordings, fits, geometry=geometry)}


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
    found = _numbers(_recording(20.0), geometry=geometry)
    assert (found["lean_low"].start, found["lean_high"].start) == pytest.approx(start)
    assert (found["lean_low"].known, found["lean_high"].known) == pytest.approx(image)
    assert found["lean_low"].u == found["lean_high"].u == 1e-3


@pytest.mark.parametrize(("stated_s", "again_s"), [(5e-3, 5e-3), (None, 1.3 / 2 / 20)], ids=["stated", "not stated"])
def test_a_window_is_searched_from_one_sample_and_from_a_long_one(monkeypatch, stated_s, again_s):
    """Oracle: by hand; 1000 samples a turn at 40 rad/s; again what is stated, else half of 1.3 rad at 20 rad/s."""
    monkeypatch.setattr(opening_in_image, "edge_misalignments", lambda *_, **__: (np.zeros(2), 1e-3))
    monkeypatch.setattr(opening_in_image, "lost", lambda _: None)
    geometry = SimpleNamespace(rotation="clockwise", model=SimpleNamespace(opening_angle_rad=1.3))
    recordings = [_recording(speed, integration_time_s=stated_s) for speed in (20.0, 40.0)]
    window = _numbers(*recordings, geometry=geometry)["integration_time"]
    assert window.start == window.known == pytest.approx(2 * np.pi / 1000 / 40)
    assert window.other_starts == pytest.approx((again_s,))

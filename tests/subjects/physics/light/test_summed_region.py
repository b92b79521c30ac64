"""What a region sees of the wheel: against sectors, and derivatives against differences."""

import numpy as np
import pytest

from irtiming.physics.light import summed_region
from irtiming.physics.light.summed_region import SummedRegion
from irtiming.physics.wheel import TURN, exposed_fraction, wheel_model

EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA, SWEEP = 1.3, 0.02
WHEEL = wheel_model(EDGES, 0.2682, opening_angle_rad=GAMMA, centre_angle_rad=-np.pi / 2)
ANGLES = np.random.default_rng(1).uniform(0, TURN, 300)


def _seen(region, *, edges=EDGES, sweep_rad=SWEEP, middle=ANGLES):
    centre = np.mod(WHEEL.opening_coordinate_rad + middle - sweep_rad / 2, TURN)
    return summed_region.seen(region, centre, edges=edges, sweep_rad=sweep_rad)


def test_a_sector_in_parts_is_the_sector():
    """Oracle: the exposed fraction of the opening, which knows of no parts."""
    whole = summed_region.sector(GAMMA, 0.0)
    parts = SummedRegion(ends_rad=np.linspace(-GAMMA / 2, GAMMA / 2, 8), share=np.full(7, 1 / 7))
    expected = exposed_fraction(ANGLES - SWEEP / 2, WHEEL, sweep_rad=SWEEP)
    for region in (whole, parts):
        assert region.total == pytest.approx(1)
        np.testing.assert_allclose(_seen(region).exposed, expected, atol=1e-11)


def test_parts_add_with_their_shares_and_signs():
    """Oracle: two sectors side by side, each by the exposed fraction of its own opening; a darker one counts negative."""
    region = SummedRegion(ends_rad=np.array([-0.4, 0.0, 0.6]), share=np.array([0.7, -0.3]))
    expected = 0.0
    for centre, width, share in ((-0.2, 0.4, 0.7), (0.3, 0.6, -0.3)):
        one = wheel_model(EDGES, 0.2682, opening_angle_rad=width, centre_angle_rad=-np.pi / 2 - centre)
        expected = expected + share * exposed_fraction(ANGLES - SWEEP / 2, one, sweep_rad=SWEEP)
    np.testing.assert_allclose(_seen(region).exposed, expected, atol=1e-11)


def test_regions_together_show_what_each_does():
    """Oracle: the sum of both, exposed one by one; with none there is none."""
    one = SummedRegion(ends_rad=np.array([-0.4, 0.0, 0.6]), share=np.array([0.7, -0.3]))
    other = SummedRegion(ends_rad=np.array([-0.7, -0.1, 0.2]), share=np.array([-0.1, 0.2]))
    whole = summed_region.together(one, None, other)
    expected = sum(_seen(each).exposed for each in (one, other))
    np.testing.assert_allclose(_seen(whole).exposed, expected, atol=1e-11)
    assert summed_region.together(None, None) is None


def test_derivatives_are_those_of_differences():
    """Oracle: central differences to each edge and to the sweep; the opening has no part in the region."""
    region, step = SummedRegion(ends_rad=np.array([-0.4, 0.0, 0.6]), share=np.array([0.7, 0.3])), 1e-6
    found = summed_region.slopes(_seen(region))
    for k in range(4):
        moved = [tuple(e - sign * step * (j == k) for j, e in enumerate(EDGES)) for sign in (1, -1)]
        plus, minus = (_seen(region, edges=edges).exposed for edges in moved)
        np.testing.assert_allclose(found[k], (plus - minus) / (2 * step), atol=1e-4)
    plus, minus = (_seen(region, sweep_rad=SWEEP + sign * step).exposed for sign in (1, -1))
    np.testing.assert_allclose(found[5], (plus - minus) / (2 * step), atol=1e-4)
    assert not np.any(found[4])


def test_blades_are_counted_point_by_point():
    """Oracle: points spread over the parts and instants over the window, each before one blade, the other, or a cutout."""
    edges, region = (
        (0.0, 1.62, 3.2, 4.65),
        SummedRegion(ends_rad=np.array([-0.4, 0.0, 0.6]), share=np.array([0.7, 0.3])),
    )
    place = np.concatenate(
        [low + (high - low) * (np.arange(400) + 0.5) / 400 for low, high in ((-0.4, 0.0), (0.0, 0.6))]
    )
    instant = SWEEP * ((np.arange(40) + 0.5) / 40 - 0.5)
    centre = WHEEL.opening_coordinate_rad + ANGLES[:, None, None] + place[:, None] + instant
    cover = [
        (np.mod(centre, TURN) >= low) & (np.mod(centre, TURN) < high)
        for low, high in zip(edges[::2], edges[1::2], strict=True)
    ]
    first, second = (np.mean(one, axis=2) @ np.repeat([0.7, 0.3], 400) / 400 for one in cover)
    seen = _seen(region, edges=edges)
    np.testing.assert_allclose(summed_region.blades(seen), (second - first) / 2, atol=1e-3)
    np.testing.assert_allclose(seen.exposed, 1 - first - second, atol=1e-3)


def test_derivatives_of_blades_are_those_of_differences():
    """Oracle: central differences to each edge and to the sweep; the opening has no part in the region."""
    region, step = SummedRegion(ends_rad=np.array([-0.4, 0.0, 0.6]), share=np.array([0.7, 0.3])), 1e-6
    found = summed_region.blades_slopes(_seen(region))
    for k in range(4):
        moved = [tuple(e - sign * step * (j == k) for j, e in enumerate(EDGES)) for sign in (1, -1)]
        plus, minus = (summed_region.blades(_seen(region, edges=edges)) for edges in moved)
        np.testing.assert_allclose(found[k], (plus - minus) / (2 * step), atol=1e-4)
    plus, minus = (summed_region.blades(_seen(region, sweep_rad=SWEEP + sign * step)) for sign in (1, -1))
    np.testing.assert_allclose(found[5], (plus - minus) / (2 * step), atol=1e-4)
    assert not np.any(found[4])

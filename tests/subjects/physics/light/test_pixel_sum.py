"""The sum over the opening against rays that are counted one by one, and its derivatives against differences."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics.light import pixel_sum
from irtiming.physics.light.bright_ends import bright_ends
from irtiming.physics.light.pixel_sum import Passing, Radii
from irtiming.physics.light.summed_region import SummedRegion
from irtiming.physics.wheel import wheel_model

TURN = 2 * np.pi
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA = float(np.radians(74.3))
WHEEL = wheel_model(EDGES, 0.2682, opening_angle_rad=float(np.radians(75)), centre_angle_rad=-np.pi / 2)
INNER, OUTER = 15.0, 39.5
ANGLES = np.random.default_rng(1).uniform(0, TURN, 400)


def _passing(**change):
    values = {
        "wheel": WHEEL,
        "middle_rad": ANGLES,
        "edges_early_rad": np.array([3e-4, -2e-4, 5e-4, 1e-4]),
        "opening_angle_rad": GAMMA,
        "swept_rad": 4.7e-3,
        "lean_low_rad": 8e-3,
        "lean_high_rad": -5e-3,
        "radii": pixel_sum.radii(INNER, OUTER),
    }
    return Passing(**(values | change))


def test_radii_weigh_by_their_area():
    """Oracle: integrals over the annulus by hand: mean of r is 2 (R^3 - r^3) / 3 (R^2 - r^2), of 1 / r is 2 / (R + r)."""
    found = pixel_sum.radii(INNER, OUTER)
    assert found.share.sum() == pytest.approx(1)
    assert found.share @ found.place == pytest.approx(0, abs=1e-12)
    middle = (INNER + OUTER) / 2
    # places are r_0 / r less its mean, which is 1 over the area: r_0 2 / (R + r)
    radius = middle / (found.place + 1)
    assert found.share @ radius == pytest.approx(2 * (OUTER**3 - INNER**3) / (3 * (OUTER**2 - INNER**2)), rel=1e-9)
    assert found.share @ (1 / radius) == pytest.approx(2 / (OUTER + INNER), rel=1e-6)


@pytest.mark.parametrize("swept", [0.0, 4.7e-3, 0.1])
def test_fraction_is_the_share_of_rays_in_a_cutout(swept):
    """Oracle: rays at 400 places of the opening, 60 radii and 40 instants, each asked for its own wheel coordinate."""
    passing = _passing(swept_rad=swept, middle_rad=ANGLES[:40])
    edges = np.array(EDGES) - passing.edges_early_rad
    node, weight = np.polynomial.legendre.leggauss(60)
    radius = (OUTER + INNER) / 2 + (OUTER - INNER) / 2 * node
    share = weight * radius / np.sum(weight * radius)
    instants = swept * ((np.arange(40) + 0.5) / 40 - 0.5)
    place = (INNER + OUTER) / 2 / radius - 1
    low, high = -GAMMA / 2 + passing.lean_low_rad * place, GAMMA / 2 + passing.lean_high_rad * place
    centre = WHEEL.opening_coordinate_rad + passing.middle_rad
    counted, blades = np.zeros((2, centre.size))
    for one, a, b in zip(share, low, high, strict=True):
        along = a + (b - a) * (np.arange(400) + 0.5) / 400
        alpha = np.mod(centre[:, None, None] + instants[:, None] + along, TURN)
        opened = ((alpha >= edges[1]) & (alpha < edges[2])) | (alpha >= edges[3] % TURN) | (alpha < edges[0])
        counted += one * (b - a) / GAMMA * opened.mean(axis=(1, 2))
        second = ((alpha >= edges[2]) & (alpha < edges[3])) * 0.5
        blades += one * (b - a) / GAMMA * np.mean(second - 0.5 * (~opened & (second == 0)), axis=(1, 2))
    np.testing.assert_allclose(pixel_sum.shapes(passing).blades, blades, atol=1.5e-3)
    np.testing.assert_allclose(pixel_sum.shapes(passing).fraction, counted, atol=1.5e-3)
    assert np.mean(np.abs(pixel_sum.shapes(passing).fraction - counted)) < 3e-4


def test_plate_skew_and_bow_are_a_wider_and_an_uneven_opening():
    """Oracle: the fraction of an opening wider by two borders, and those of its bright ends; no leans in either."""
    passing = _passing(border_rad=0.07)
    even = replace(passing, lean_low_rad=0.0, lean_high_rad=0.0, radii=Radii())
    wide = replace(even, opening_angle_rad=GAMMA + 0.14)
    found = pixel_sum.shapes(passing)
    np.testing.assert_allclose(
        found.plate, pixel_sum.shapes(wide).fraction - pixel_sum.shapes(even).fraction, atol=1e-12
    )
    np.testing.assert_allclose(found.beside, pixel_sum.shapes(wide).blades - pixel_sum.shapes(even).blades, atol=1e-12)
    expected = bright_ends(passing.start_rad, passing.actual, sweep_rad=passing.sweep_rad)
    np.testing.assert_allclose(found.skew, expected.skew, atol=1e-12)
    np.testing.assert_allclose(found.bow, expected.bow, atol=1e-12)
    assert np.ptp(found.plate) > 0.05


def _seen_by_rays(passing, region):
    """What rays of the region see of the open wheel, each with its part of the region's share."""
    edges = np.array(EDGES) - passing.edges_early_rad
    place = np.linspace(*region.ends_rad[[0, -1]], 24001)
    place = (place[1:] + place[:-1]) / 2
    instants = passing.swept_rad * ((np.arange(10) + 0.5) / 10 - 0.5)
    alpha = np.mod((WHEEL.opening_coordinate_rad + passing.middle_rad)[:, None, None] + instants[:, None] + place, TURN)
    opened = ((alpha >= edges[1]) & (alpha < edges[2])) | ((alpha >= edges[3]) & (alpha < edges[0] + TURN))
    return opened.mean(axis=1) @ np.repeat(region.share, 24000 // region.share.size) / (24000 // region.share.size)


LOST = SummedRegion(
    ends_rad=np.linspace(-GAMMA / 2, GAMMA / 2, 7), share=np.array([0.06, 0.03, 0.02, 0.02, 0.04, 0.05])
)


def test_glare_takes_the_light_of_the_ends_out_of_the_sum():
    """Oracle: 24 000 rays along the opening at 10 instants, each with what its part of it keeps; an open sum counts as 1."""
    glare, passing = 0.03, _passing(lean_low_rad=0.0, lean_high_rad=0.0, middle_rad=ANGLES[:30])
    kept = replace(LOST, share=1 / 6 - glare * LOST.share)
    expected = _seen_by_rays(passing, kept) / kept.total
    found = pixel_sum.shapes(replace(passing, glare=glare, lost=LOST)).fraction
    np.testing.assert_allclose(found, expected, atol=1e-4)
    assert np.max(np.abs(found - pixel_sum.shapes(passing).fraction)) > 5e-4


BESIDE = np.linspace(-GAMMA / 2 - 0.1, GAMMA / 2 + 0.1, 5)
UNEVEN = SummedRegion(ends_rad=BESIDE, share=np.array([0.02, -0.01, 0.005, 0.03]))
PLATE = SummedRegion(ends_rad=BESIDE, share=np.array([0.3, 0.4, 0.35, 0.3]))


def test_an_uneven_wheel_and_the_plate_show_where_the_image_has_them():
    """Oracle: 24 000 rays at 10 instants; a sum that is open counts as 1 with the uneven wheel and without, as with the plate."""
    passing = _passing(lean_low_rad=0.0, lean_high_rad=0.0, middle_rad=ANGLES[:30])
    bare = pixel_sum.shapes(passing).fraction
    found = pixel_sum.shapes(replace(passing, uneven=UNEVEN, plate=PLATE))
    expected = bare + _seen_by_rays(passing, UNEVEN) - 0.045 * bare
    np.testing.assert_allclose(found.fraction, expected, atol=1e-5)
    np.testing.assert_allclose(found.plate, _seen_by_rays(passing, PLATE) - 1.35 * bare, atol=1e-4)
    assert np.max(np.abs(found.fraction - bare)) > 5e-3


TAILS = ((0.004, 2e-3), (0.006, 0.015))


def test_what_comes_after_the_window_is_seen_later_with_the_centre_kept():
    """Oracle: instants of equal weight, 99 % of them in the window, the rest fading from its end."""
    swept, n = 0.02, 200_000
    tails = [-fades * np.log((np.arange(round(share * n)) + 0.5) / round(share * n)) for share, fades in TAILS]
    inside = swept * (
        (np.arange(n - sum(one.size for one in tails)) + 0.5) / (n - sum(one.size for one in tails)) - 0.5
    )
    instants = np.concatenate([inside, *(swept / 2 + one for one in tails)])
    plain = _passing(swept_rad=0.0, middle_rad=ANGLES[:60], lean_low_rad=0.0, lean_high_rad=0.0)
    some = np.sort(instants)[10::20]
    angles = plain.middle_rad[:, None] + some - some.mean()
    expected = pixel_sum.shapes(replace(plain, middle_rad=angles.ravel())).fraction.reshape(angles.shape).mean(axis=1)
    found, without = (pixel_sum.shapes(replace(plain, swept_rad=swept, tails=tails)).fraction for tails in (TAILS, ()))
    assert np.max(np.abs(expected - without)) > 3e-5
    np.testing.assert_allclose(found, expected, atol=2e-6)


@pytest.mark.parametrize("k", [0, 1])
def test_a_tail_is_proportional_to_its_share(k):
    """Oracle: central difference, exact for what is linear."""
    passing = _passing(tails=TAILS, swept_rad=0.02)

    def moved(step):
        return replace(passing, tails=tuple((s + step * (j == k), b) for j, (s, b) in enumerate(TAILS)))

    numeric = (pixel_sum.shapes(moved(0.01)).fraction - pixel_sum.shapes(moved(-0.01)).fraction) / 0.02
    assert np.max(np.abs(numeric)) > 1e-4
    np.testing.assert_allclose(pixel_sum.slopes(passing)[f"tail_{k}"], numeric, atol=1e-9)


def _sum(passing, uneven, plate, blades=0.0):
    return _sum_of(pixel_sum.shapes(passing), uneven, plate, blades)


def _sum_of(made, uneven, plate, blades):
    return made.fraction + made.small @ np.array([uneven, plate, blades, -blades / 2])


@pytest.mark.parametrize(
    ("uneven", "plate", "blades"),
    [(0.0, 0.0, 0.0), (5e-3, 0.0, 0.0), (0.0, 0.2, 0.0), (5e-3, -0.2, 0.0), (0.0, 0.0, 0.4), (0.0, -0.2, 0.4)],
)
@pytest.mark.parametrize(
    "name",
    [
        "edge_0",
        "edge_1",
        "edge_2",
        "edge_3",
        "opening_angle",
        "swept",
        "lean_low",
        "lean_high",
        "corner_variance",
        "glare",
        "bow",
    ],
)
def test_derivatives_are_those_of_differences(name, uneven, plate, blades):
    """Oracle: central differences; a skew of five thousandths and twice the bow move those to the edges by little more."""
    passing, step = _passing(glare=0.03, lost=LOST, uneven=UNEVEN, bow=-2 * uneven), 1e-6
    passing = replace(passing, plate=PLATE) if plate < 0 else passing
    if name.startswith("edge"):
        unit = np.eye(4)[int(name[-1])]
        moved = [replace(passing, edges_early_rad=passing.edges_early_rad + sign * step * unit) for sign in (1, -1)]
    else:
        field = {"corner_variance": "corner_variance_rad2", "glare": "glare", "bow": "bow"}.get(name, f"{name}_rad")
        step = 1e-9 if name == "corner_variance" else step
        moved = [replace(passing, **{field: getattr(passing, field) + sign * step}) for sign in (1, -1)]
    numeric = (_sum(moved[0], uneven, plate, blades) - _sum(moved[1], uneven, plate, blades)) / (2 * step)
    found = pixel_sum.slopes(passing, skew=uneven, plate=plate, blades=blades, beside=-blades / 2)[name]
    assert np.max(np.abs(numeric)) > 1e-3
    beside = np.abs(found - numeric)
    if uneven and name.startswith("edge"):
        assert np.mean(beside) < 1.5e-2 * np.mean(np.abs(numeric))
    else:
        assert np.quantile(beside, 0.99) < 1e-3 * np.max(np.abs(numeric))


def test_edges_together_are_the_wheel():
    """Oracle: central differences to the wheel angle: all four edges earlier by as much."""
    passing, step = _passing(), 1e-6
    ahead, behind = (replace(passing, middle_rad=ANGLES + sign * step) for sign in (1, -1))
    numeric = (_sum(ahead, 0, 0.1) - _sum(behind, 0, 0.1)) / (2 * step)
    found = pixel_sum.slopes(passing, plate=0.1)
    np.testing.assert_allclose(sum(found[f"edge_{k}"] for k in range(4)), numeric, atol=1e-3)


def test_a_window_of_either_sign_is_the_same_and_has_no_corner_at_zero():
    """Oracle: the model is even in the angle swept; its slope there is 0."""
    plus, minus = (pixel_sum.shapes(_passing(swept_rad=sign * 3e-3)).fraction for sign in (1, -1))
    np.testing.assert_array_equal(plus, minus)
    assert np.max(np.abs(pixel_sum.slopes(_passing(swept_rad=0.0))["swept"])) == 0

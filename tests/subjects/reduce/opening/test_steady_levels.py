"""Levels that drift, jump and differ between blades, found in the brightness of a wheel that is counted point by point."""

import re

import numpy as np
import pytest

from irtiming.reduce.opening import never_open, steady_levels

TURN = 2 * np.pi
N = 240
PLACE = (np.arange(N) + np.random.default_rng(5).random(N)) / N
ANGLE = TURN * np.mod(99 * np.rint(PLACE * 1000), 1000) / 1000
WAVE = np.sin(TURN * 1.3 * PLACE)
EDGES = (0.0, 1.5718, 3.1421, 4.7125)


def _seen(opening_deg=75.0, points=2000, angle=ANGLE):
    """Open share, and share behind the second blade: points of the opening, each asked where it is on the wheel."""
    along = np.radians(opening_deg) * ((np.arange(points) + 0.5) / points - 0.5)
    alpha = np.mod(0.7 + angle[:, None] + along, TURN)
    opened = ((alpha >= EDGES[1]) & (alpha < EDGES[2])) | (alpha >= EDGES[3])
    return opened.mean(axis=1), ((alpha >= EDGES[2]) & (alpha < EDGES[3])).mean(axis=1)


@pytest.mark.parametrize("step", [5000.0, -800.0])
@pytest.mark.parametrize("sway", [0.0, 0.03])
@pytest.mark.parametrize("blade", [0.0, 0.012])
def test_what_the_levels_do_is_taken_off(step, sway, blade):
    """Oracle: the shares that were counted; a step up and down, levels that sway and a blade that is warmer."""
    fraction, second = _seen()
    noise = np.random.default_rng(1).normal(0, 3e-4, N)
    values = 4000 + step * (sway * WAVE + (1 - 0.5 * sway * WAVE) * (fraction + blade * second) + noise)
    found = steady_levels.find(values, ANGLE, place=PLACE, is_colder=step < 0)
    assert abs(found.blades) == pytest.approx(blade, abs=3e-4)
    assert found.is_disturbed == bool(sway or blade)
    assert np.degrees(found.opening_angle_rad) == pytest.approx(75, abs=0.2)
    assert np.degrees(found.narrowest_rad) == pytest.approx(np.degrees(EDGES[2] - EDGES[1]), abs=0.3)
    steadied = (found.steadied(values) - 4000) / step
    line = np.polynomial.Polynomial.fit(fraction, steadied, 1)
    assert np.abs(steadied - line(fraction)).max() < 3e-3
    plateaus = [np.sum(np.abs(steadied - level) < 2e-3) for level in (steadied.min() + 1e-3, steadied.max() - 1e-3)]
    assert min(plateaus) > 10


def test_sums_that_hold_the_plate_sway_by_more_than_the_opening():
    """Oracle: the shares that were counted; a sum of which the opening is a third, and of which all pixels jump alike."""
    fraction, _ = _seen()
    jump = 0.1 * (PLACE > 0.4)
    noise = np.random.default_rng(6).normal(0, 3e-4, (2, N))
    levels = steady_levels.find(fraction + jump + noise[0], ANGLE, place=PLACE, is_colder=False)
    sums = 7000 + 500 * (fraction + 3 * jump + noise[1])
    sums[30] += 50
    angle = np.where(np.arange(N) == 20, np.nan, ANGLE)
    found = levels.of_sums(sums, angle)
    off = np.interp(np.arange(N) / N, PLACE, jump) != jump
    assert np.flatnonzero(np.isnan(found.strays)).tolist() == [20]
    assert found.strays[30] == pytest.approx(0.1, abs=3e-3)
    beside = np.delete(found.steady - 7000 - 500 * fraction, [30, *np.flatnonzero(off)])
    assert np.ptp(beside) < 3


def test_a_wheel_that_passes_once_in_a_run_is_not_told_from_levels():
    """Oracle: by hand; by a turn, or half a turn, over the whole run beside whole ones."""
    for turns in (1.0, 0.5):
        angle = TURN * turns * PLACE
        assert steady_levels.find(_seen(angle=angle)[0], angle, place=PLACE, is_colder=False) is None
    text = never_open.diagnosis(None, TURN * PLACE, glare=0.0)
    assert "visit the wheel's angles so slowly that nothing distinguishes the causes" in text


def test_values_that_do_not_follow_the_wheel_tell_nothing():
    """Oracle: by hand; noise, and frames of another wheel."""
    noise = np.random.default_rng(2).normal(0, 1, N)
    assert steady_levels.find(noise, ANGLE, place=PLACE, is_colder=False) is None
    assert steady_levels.find(_seen()[0], np.full(N, np.nan), place=PLACE, is_colder=False) is None
    other = _seen()[0][np.random.default_rng(3).permutation(N)]
    assert steady_levels.find(other, ANGLE, place=PLACE, is_colder=False) is None
    text = never_open.diagnosis(None, ANGLE, glare=0.0)
    assert "does not follow a wheel with two cutouts" in text


@pytest.mark.parametrize(
    ("opening", "sway", "blade", "noise", "glare", "first"),
    [
        (89.0, 0.0, 0.0, 3e-4, 0.0, "geometry: the frames show an opening of 89.* deg"),
        (89.0, 0.05, 0.0, 3e-4, 0.0, "geometry: .*; drift: levels sway by"),
        (75.0, 0.05, 0.0, 3e-4, 0.0, "drift: levels sway by 20.0% of the contrast"),
        (75.0, 0.0, 0.06, 3e-4, 0.0, "blades: one blade looks 6.*% of the contrast warmer"),
        (75.0, 0.0, 0.0, 0.03, 0.0, "noise: frames scatter by [23].*%"),
        (75.0, 0.0, 0.0, 3e-4, 0.05, "glare: pixels far from the opening follow it by 5.0%"),
        (75.0, 0.0, 0.0, 3e-4, 0.0, "no cause is found"),
    ],
)
def test_the_cause_is_named_by_what_the_frames_show(opening, sway, blade, noise, glare, first):
    """Oracle: what was put into the values."""
    fraction, second = _seen(opening)
    scatter = np.random.default_rng(1).normal(0, noise, N)
    values = 4000 + 5000 * (2 * sway * WAVE + fraction + blade * second + scatter)
    found = steady_levels.find(values, ANGLE, place=PLACE, is_colder=False)
    assert found is not None
    assert re.match(first, never_open.diagnosis(found, ANGLE, glare=glare))


def test_angles_that_were_never_recorded_are_named():
    """Oracle: by hand; frames of three quarters of a turn."""
    part = np.mod(ANGLE, TURN) < 0.75 * TURN
    text = never_open.diagnosis(None, np.where(part, ANGLE, np.nan), glare=0.0)
    assert text.startswith("no frame shows the wheel between 2")
    assert "record whole turns" in text


def test_derivatives_are_those_of_differences():
    """Oracle: central differences of the residuals; a blade that shows three tenths of the step, and nothing left over."""
    numbers = dict(zip(steady_levels._EDGES, (0.71, 0.69, 0.70, 0.72), strict=True)) | {steady_levels._OPENING: 1.3}
    empty = steady_levels._Given(values=np.zeros(N), angle=ANGLE, place=PLACE)
    made = empty.shapes(numbers)
    given = steady_levels._Given(values=0.2 + made.fraction + 0.3 * made.blades, angle=ANGLE, place=PLACE)
    at = given.model(None)
    assert np.abs(at(numbers).residual).max() < 1e-9
    for k, name in enumerate(numbers):
        ahead, behind = (at({**numbers, name: numbers[name] + step}).residual for step in (1e-5, -1e-5))
        np.testing.assert_allclose(at(numbers).jacobian[:, k], (ahead - behind) / 2e-5, atol=2e-3)


@pytest.mark.parametrize(("gain", "sway"), [((1.0, 1.0), 0.1), ((1.0, 0.9), 0.1), ((1.0, 1.1), 0.2)])
def test_levels_sway_by_the_range_of_the_covered_or_of_the_open_wheel(gain, sway):
    """Oracle: by hand; the covered level rises by a tenth of the step, the open one by as much, not at all, or by twice that."""
    none = np.zeros(2)
    levels = steady_levels.SteadyLevels(
        place=none, offset=np.array([0.0, 0.1]), gain=np.array(gain), second_blade=none, blades=0.0, scatter=0.0, step=1.0,
        opening_angle_rad=1.3, narrowest_rad=1.5, jumps=none[:0], edges_early_rad=np.zeros(4), is_odd=none > 0,
    )  # fmt: skip
    assert levels.sway == pytest.approx(sway)

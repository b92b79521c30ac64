"""The search for the numbers of the contrast image, on a curve of which the answer is known."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pytest
from scipy.optimize import OptimizeResult

from irtiming.estimate import sector_search
from irtiming.estimate.sector_image import Sharp
from irtiming.estimate.sector_search import BETWEEN, FIRST, LAST, Misfit, Numbers, Place, Slopes, searched
from irtiming.records.arrays import Array

FREE = ("axle_row_px", "axle_column_px", "inner_radius_px")
TRUE = {"axle_row_px": 3.0, "axle_column_px": -2.0, "inner_radius_px": 5.0}
PLACE = np.linspace(0.0, 1.0, 40)


class _Curve:
    """A bent curve with three numbers, that counts how often it is asked for; ``off`` is what it misses by."""

    def __init__(self, off: float = 0.0) -> None:
        self.asked, self.off = 0, off

    def misfit(self) -> Misfit:
        def sharp(numbers: Mapping[str, float]) -> Sequence[Sharp]:
            self.asked += 1
            return ()

        return Misfit(at=self._at, sharp=sharp)

    def _at(self, here: Mapping[str, float], sharp: Sequence[Sharp]) -> Place:
        residual = self._residuals(here, sharp)
        return Place(residual=residual, change=lambda there, _: self._residuals(there, ()) - residual)

    def _residuals(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> Array:
        a, b, c = (numbers[name] - TRUE[name] for name in FREE)
        return np.asarray(
            a + b * PLACE + c * np.sin(3 * PLACE) + 0.05 * a * b * PLACE**2 + self.off * np.cos(40 * PLACE)
        )


def test_slopes_that_were_kept_lead_to_the_same_place_with_fewer_images() -> None:
    """Oracle: the numbers that the curve was made with, and one image a step, against one more for each number's slope."""
    kept, first, again, alone = Slopes(), _Curve(), _Curve(), _Curve()
    near = {name: value + 0.02 for name, value in TRUE.items()}
    searched(first.misfit(), {name: value + 0.5 for name, value in TRUE.items()}, free=FREE, gain=BETWEEN, slopes=kept)
    with_kept = searched(again.misfit(), near, free=FREE, gain=BETWEEN, slopes=kept)
    without = searched(alone.misfit(), near, free=FREE, gain=BETWEEN)
    assert with_kept.x == pytest.approx([TRUE[name] for name in FREE], abs=2e-3)
    assert without.x == pytest.approx(with_kept.x, abs=2e-3)
    assert again.asked == with_kept.nfev
    assert alone.asked == without.nfev + len(FREE)


def test_slopes_of_a_number_that_was_held_before_are_added() -> None:
    """Oracle: the numbers that the curve was made with, and one image a step and one for the number that is new."""
    kept, both = Slopes(), _Curve()
    first = searched(_Curve().misfit(), TRUE, free=(FREE[0], FREE[2]), gain=BETWEEN, slopes=kept)
    near = {name: value + 0.02 for name, value in TRUE.items()}
    found = searched(both.misfit(), near, free=FREE, gain=BETWEEN, slopes=kept)
    assert first.x == pytest.approx([TRUE[FREE[0]], TRUE[FREE[2]]], abs=1e-6)
    assert found.x == pytest.approx([TRUE[name] for name in FREE], abs=2e-3)
    assert both.asked == found.nfev + 1


def test_slopes_of_another_curve_are_taken_anew() -> None:
    """Oracle: the numbers that the curve was made with, though the slopes that it begins with have the wrong sign."""
    wrong = Slopes(matrix=-np.stack([np.ones(40), PLACE, np.sin(3 * PLACE)], axis=1), names=FREE)
    with_wrong = searched(
        _Curve(0.01).misfit(),
        {name: value + 0.5 for name, value in TRUE.items()},
        free=FREE,
        gain=BETWEEN,
        slopes=wrong,
    )
    other_length = searched(
        _Curve(0.01).misfit(), {name: value + 0.5 for name, value in TRUE.items()}, free=FREE, gain=BETWEEN,
        slopes=Slopes(matrix=np.ones((7, 3)), names=FREE),
    )  # fmt: skip
    assert other_length.x == pytest.approx([TRUE[name] for name in FREE], abs=0.01)
    assert with_wrong.x == pytest.approx([TRUE[name] for name in FREE], abs=0.01)


class _One:
    """Residuals of a single number besides ones; it counts the places of a search, and remembers all that was asked for."""

    def __init__(self, name: str, residual: Callable[[float], float], *, n_ones: int = 1) -> None:
        self.name, self.residual, self.ones = name, residual, np.ones(n_ones)
        self.places, self.asked = 0, list[float]()

    def searched(self, begin: float, *, gain: float = LAST, slopes: Slopes | None = None) -> OptimizeResult:
        misfit = Misfit(at=self._at, sharp=lambda _: ())
        return searched(misfit, {self.name: begin}, free=(self.name,), gain=gain, slopes=slopes)

    def _at(self, here: Numbers, sharp: Sequence[Sharp]) -> Place:
        self.places += 1
        residual = self._residuals(here)
        return Place(residual=residual, change=lambda there, _: self._residuals(there) - residual)

    def _residuals(self, numbers: Numbers) -> Array:
        self.asked.append(numbers[self.name])
        return np.append(self.ones, self.residual(numbers[self.name]))


def test_a_search_that_kept_slopes_did_not_lead_astray_is_not_made_twice() -> None:
    """Oracle: by hand: of a ninth power each step leaves 8/9, so 30 from 60 on do not end it, and those are all it is given."""
    power = _One(FREE[0], lambda row: (row - 3.0) ** 9)
    of_another_length = Slopes(matrix=np.ones((7, 1)), names=FREE[:1])
    found = power.searched(63.0, gain=BETWEEN, slopes=of_another_length)
    assert found.status == 0
    assert power.places == found.nfev == 30


def test_a_search_ends_where_a_step_gains_a_standard_uncertainty_and_the_last_one_a_tenth() -> None:
    """Oracle: by hand: a cube ends slowly, each step leaves (2/3)^6 = 0.09 of its square, Broyden's more."""
    cube = _One(FREE[0], lambda row: (row - 3.0) ** 3, n_ones=3999)
    left = [float((cube.searched(9.0, gain=gain).x[0] - 3.0) ** 6) for gain in (FIRST, BETWEEN, LAST)]
    assert 0.6 < left[0] < 12
    assert 0.006 < left[1] < 0.12
    assert 0.0006 < left[2] < 0.012


@pytest.mark.parametrize("begin", [-0.2, 0.0, 1.0, 1.3])
def test_a_search_may_begin_at_a_limit_or_beyond_it(begin: float) -> None:
    """Oracle: the share that the line was made with; a plate mirrors from nothing to all of the light."""
    line = _One("plate_reflection", lambda share: 1e3 * (share - 0.4))
    assert line.searched(begin).x[0] == pytest.approx(0.4, abs=1e-3)


def test_a_search_asks_for_nothing_beyond_a_limit() -> None:
    """Oracle: by hand; a square that is least at the limit, where each step leaves half of the way and takes slopes anew."""
    square = _One("plate_reflection", lambda share: 1e10 * (1 - share) ** 2)
    assert square.searched(0.9).x[0] == pytest.approx(1.0, abs=3e-5)
    assert max(square.asked) <= 1.0


@pytest.mark.parametrize(
    ("foretold", "is_kept"), [(80.0, True), (71.0, True), (69.0, False), (131.0, False), (129.0, True)]
)
@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_slopes_are_kept_that_miss_less_than_three_tenths_of_a_change(
    foretold: float, is_kept: bool, size: float
) -> None:
    """Oracle: by hand; a step of 1 changes the residual by 100, whatever that is measured in; kept slopes foretell it then."""
    course = sector_search._Course(
        misfit=Misfit(at=lambda *_: Place(residual=np.zeros(1), change=lambda *_: np.zeros(1)), sharp=lambda _: ()),
        start={}, free=FREE[:1], step=np.array([1e-4]), high=np.array([np.inf]), kept=Slopes(),
        gain=1e-9, before=(np.zeros(1), np.zeros(1)),
    )  # fmt: skip
    course.place = Place(residual=np.array([100.0 * size]), change=lambda *_: np.zeros(1))
    found = course._updated(np.array([[foretold * size]]), np.ones(1))
    assert found == (pytest.approx(np.array([[100.0 * size]])) if is_kept else None)


@pytest.mark.parametrize(("missed", "is_kept"), [(5.4, True), (5.5, False)])
def test_slopes_stay_as_they_are_after_a_step_that_matters_less_than_the_end(missed: float, is_kept: bool) -> None:
    """Oracle: by hand; three tenths of a gain of 100 squares are 5.48 of one residual, where a step of 1e-3 changed it by 6."""
    course = sector_search._Course(
        misfit=Misfit(at=lambda *_: Place(residual=np.zeros(1), change=lambda *_: np.zeros(1)), sharp=lambda _: ()),
        start={}, free=FREE[:1], step=np.array([1e-4]), high=np.array([np.inf]), kept=Slopes(), gain=100.0,
        before=(np.zeros(1), np.zeros(1)),
    )  # fmt: skip
    course.place = Place(residual=np.array([6.0]), change=lambda *_: np.zeros(1))
    slopes = np.array([[(6.0 - missed) / 1e-3]])
    found = course._updated(slopes, np.array([1e-3]))
    assert found is (slopes if is_kept else None)


def test_what_a_search_gained_is_what_it_began_with_less_what_it_ended_with() -> None:
    """Oracle: by hand; a line of slope 5 from 4 beside where it is nothing, squared."""
    assert _One(FREE[0], lambda row: 5 * (row - 3.0)).searched(7.0).gained == pytest.approx(400.0)

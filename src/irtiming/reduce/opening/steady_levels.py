"""The brightness of the opening without what its levels do: drift, jumps, blades that are not equally warm.

How open the wheel is at each angle follows from four edges near 0, 90, 180 and 270 deg and one opening angle, all of which are
fitted here: roughly, to look at plateaus, and with nothing known of the rig. What is left over tells what the levels do.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.inference import drifting_levels, optimiser, variable_projection
from irtiming.inference.drifting_levels import Levels
from irtiming.inference.optimiser import Linearised
from irtiming.physics import robust
from irtiming.physics.light import pixel_sum
from irtiming.physics.light.pixel_sum import Passing, Shapes
from irtiming.physics.wheel import TURN, steps_around, wheel_model
from irtiming.records.arrays import Array, Mask
from irtiming.reduce import passing_wave

ODD, _SCATTERS = 0.05, 8.0
"""Of the step, and of the scatter: a frame that strays further shows something else."""

_WHEEL = wheel_model((0.0, TURN / 4, TURN / 2, 3 * TURN / 4), 0.0, opening_angle_rad=1.0, centre_angle_rad=0.0)
_SCAN = 90  # wheel angles over half a turn, after which the wheel is nearly the same
_OPENINGS_RAD = (0.6, 0.9, 1.2, 1.5)
_EDGES = ("edge_0", "edge_1", "edge_2", "edge_3")
_OPENING = "opening_angle"
_ROUNDS = 2
_PARTS, _ORDERS = 4, (1, 2, 4)  # of the run, of which each must tell the wheel from its levels
_SHORTEST = 20  # frames per bend of a level
_FEWEST = 60
_TRIMMED, _MOST_ALIKE = 4, 0.8
_FOLLOWS = 0.05  # of the step: frames that scatter more about the wheel do not follow it
_DISTURBED = 0.005  # of the step; a frame within 0.02 counts as on the plateau
_NARROWEST_RAD, _WIDEST_RAD = 0.05, 3.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyLevels:
    """What the levels of some frames do.

    Parameters
    ----------
    place, offset, gain
        Shape (n,); part of the recording's frames before this one, by how much the covered level lies over its mean, in steps,
        and the step over its mean.
    second_blade
        Shape (n,); by how much the second blade, less the first, is in the values, in steps.
    blades
        Covered level of the second blade less that of the first, in steps; which is which is not known here.
    scatter
        Standard deviation of the frames about the wheel, in steps.
    step, opening_angle_rad, narrowest_rad
        The step in units of the values; the opening angle, and the narrowest cutout or blade, as they appear.
    jumps
        Places of the frames after a jump.
    edges_early_rad
        Shape (4,); by how much edges 0..3 of a wheel of four equal parts would have to come earlier.
    is_odd
        Shape (n,); frames that show something else than wheel and blackbody: a closed shutter.
    """

    place: Array
    offset: Array
    gain: Array
    second_blade: Array
    blades: float
    scatter: float
    step: float
    opening_angle_rad: float
    narrowest_rad: float
    jumps: Array
    edges_early_rad: Array
    is_odd: Mask

    @property
    def sway(self) -> float:
        """Range of what drift and jumps do to a frame of the open or of the covered wheel, in steps."""
        return float(max(np.ptp(self.offset), np.ptp(self.offset + self.gain)))

    @property
    def is_disturbed(self) -> bool:
        """Whether levels or blades differ by more than a plateau may be uneven."""
        return max(self.sway, abs(self.blades)) > _DISTURBED

    def steadied(self, values: Array) -> Array:
        """The values, shape (n,), as they would be with steady levels and equal blades."""
        covered = float(np.min(values)) if self.step > 0 else float(np.max(values))
        rest = values - covered - self.step * self.offset
        return np.asarray(covered + rest / self.gain - self.step * self.second_blade)

    def of_sums(self, values: Array, wheel_angle_rad: Array) -> "SteadySums":
        """The same in other values of all frames, in which the plate beside the opening may sway along.

        Parameters
        ----------
        values, wheel_angle_rad
            Shape (n_frame,); angles nan where a frame has no say.
        """
        place, known = np.arange(values.size) / values.size, np.isfinite(wheel_angle_rad)
        offset, gain = (np.interp(place, self.place, one) for one in (self.offset, self.gain))
        made = pixel_sum.shapes(_passing(wheel_angle_rad[known], self.edges_early_rad, self.opening_angle_rad))
        moving = gain[known] * (made.fraction + self.blades * made.blades)
        columns = np.stack([np.ones(moving.size), offset[known], moving], axis=1)
        amounts: Array = np.zeros(3)
        near = np.ones(moving.size, bool)
        for _ in range(_TRIMMED):
            amounts = np.asarray(np.linalg.lstsq(columns[near], values[known][near], rcond=1e-12)[0])
            beside = np.abs(values[known] - columns @ amounts)
            near = beside <= np.quantile(beside, _MOST_ALIKE)
        covered, sway, step = (float(one) for one in amounts)
        strays = np.full(values.size, np.nan)
        strays[known] = (values[known] - columns @ amounts) / step
        return SteadySums(steady=covered + (values - covered - sway * offset) / gain, strays=strays)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SteadySums:
    """Values of all frames without drift and jumps, shape (n_frame,), and by how much they stray from wheel and levels.

    ``strays`` in steps, nan where no angle is known.
    """

    steady: Array
    strays: Array


def find(values: Array, wheel_angle_rad: Array, *, place: Array, is_colder: bool) -> SteadyLevels | None:
    """What the levels do; None where the values do not follow a wheel with two cutouts, or its turns take a part of the run.

    Parameters
    ----------
    values, wheel_angle_rad
        Shape (n,); mean brightness of the opening in each frame, and angle of the wheel, nan where unknown.
    place
        Shape (n,); part of the recording's frames before each, ascending.
    is_colder
        Whether the opening gets darker as it is uncovered.
    """
    known = np.isfinite(wheel_angle_rad)
    swing = float(np.ptp(values[known])) if known.any() else 0.0
    if known.sum() < _FEWEST or swing <= 0:
        return None
    if not are_told(wheel_angle_rad):
        return None
    given = _Given(values=values[known] / swing, angle=wheel_angle_rad[known], place=place[known])
    numbers = given.scanned(-1.0 if is_colder else 1.0)
    levels: Levels | None = None
    for _ in range(_ROUNDS):
        numbers = optimiser.minimise(given.model(levels), start=numbers).values
        if not _NARROWEST_RAD < numbers[_OPENING] < _WIDEST_RAD:
            return None
        made = given.shapes(numbers)
        levels = drifting_levels.choose(
            given.values, made.fraction, shapes=made.blades[:, None], place=given.place, shortest=_SHORTEST
        )
    return None if levels is None else given.result(numbers, levels, swing=swing, known=known)


def are_told(wheel_angle_rad: Array) -> bool:
    """Whether levels that sway are told from the wheel: not where it passes so slowly that they could do what it does.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n,), nan where unknown.
    """
    parts = np.array_split(np.flatnonzero(np.isfinite(wheel_angle_rad)), _PARTS)
    return passing_wave.is_told(wheel_angle_rad, parts, orders=_ORDERS)


def _passing(angle: Array, edges_early_rad: Array, opening_angle_rad: float) -> Passing:
    return Passing(
        wheel=_WHEEL, middle_rad=angle, edges_early_rad=edges_early_rad, opening_angle_rad=opening_angle_rad,
        swept_rad=0.0,
    )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Given:
    values: Array
    angle: Array
    place: Array

    def passing(self, numbers: Mapping[str, float]) -> Passing:
        return _passing(self.angle, np.array([numbers[name] for name in _EDGES]), numbers[_OPENING])

    def shapes(self, numbers: Mapping[str, float]) -> Shapes:
        return pixel_sum.shapes(self.passing(numbers))

    def scanned(self, sign: float) -> dict[str, float]:
        """The best of a grid of wheel angles and openings, by its correlation with the values."""
        beside = self.values - self.values.mean()
        best, numbers = -np.inf, dict.fromkeys(_EDGES, 0.0) | {_OPENING: _OPENINGS_RAD[0]}
        for opening in _OPENINGS_RAD:
            for shift in TURN / 2 * np.arange(_SCAN) / _SCAN:
                trial = dict.fromkeys(_EDGES, float(shift)) | {_OPENING: opening}
                fraction = self.passing(trial).opening.fraction
                match = sign * float(beside @ (fraction - fraction.mean())) / max(float(fraction.std()), 1e-9)
                best, numbers = (match, trial) if match > best else (best, numbers)
        return numbers

    def model(self, levels: Levels | None) -> optimiser.Model:
        """Residuals with all levels at their best."""
        n = self.values.size
        root = np.ones(n) if levels is None else np.sqrt(levels.weight)
        drift = np.zeros((n, 0)) if levels is None else levels.drift
        gain = np.zeros((n, 0)) if levels is None else levels.gain

        def at(numbers: Mapping[str, float]) -> Linearised:
            passing = self.passing(numbers)
            made = pixel_sum.shapes(passing)
            moving = made.fraction[:, None]
            columns = np.concatenate([np.ones((n, 1)), moving, made.blades[:, None], gain * moving, drift], axis=1)

            def slopes_of(amounts: Array) -> Array:
                found = pixel_sum.slopes(passing, blades=float(amounts[2] / amounts[1]))
                step = amounts[1] + gain @ amounts[3 : 3 + gain.shape[1]]
                return np.stack([root * step * found[name] for name in numbers], axis=1)

            weighted = columns * root[:, None]
            return variable_projection.project(self.values * root, weighted, slopes_of=slopes_of).at

        return at

    def result(self, numbers: dict[str, float], levels: Levels, *, swing: float, known: Mask) -> SteadyLevels | None:
        """In steps, over all frames: those of unknown angle lie between their neighbours."""
        made = self.shapes(numbers)
        moving = made.fraction[:, None]
        columns = np.concatenate(
            [np.ones_like(moving), moving, made.blades[:, None], levels.gain * moving, levels.drift], axis=1
        )
        root = np.sqrt(levels.weight)[:, None]
        amounts = np.linalg.lstsq(columns * root, self.values * root[:, 0], rcond=1e-12)[0]
        step = float(amounts[1])
        strays = np.abs(self.values - columns @ amounts) / abs(step)
        scatter = robust.spread(strays)
        is_odd = np.zeros(known.size, bool)
        is_odd[known] = strays > max(ODD, _SCATTERS * scatter)
        if not scatter < _FOLLOWS:
            return None
        at = np.arange(known.size)
        place, offset, gain, second = (
            np.interp(at, at[known], one)
            for one in (self.place, levels.offset_change / step, levels.relative_gain, amounts[2] / step * made.blades)
        )
        early = np.array([numbers[name] for name in _EDGES])
        edges = np.array(_WHEEL.cutout_edges_rad) - early
        return SteadyLevels(
            place=place, offset=offset, gain=gain, second_blade=second, blades=float(amounts[2] / step), scatter=scatter,
            step=step * swing, opening_angle_rad=numbers[_OPENING], jumps=self.place[list(levels.jumps)],
            narrowest_rad=float(steps_around(edges).min()), edges_early_rad=early, is_odd=is_odd,
        )  # fmt: skip

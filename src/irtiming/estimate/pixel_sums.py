r"""The pixel sums of one recording: what they say of the numbers that they follow from, and the fit of one recording alone.

Frame n, whose exposure has its middle at the wheel angle theta_n, has the sum (`physics.light.pixel_sum`)

.. math:: \mathrm{covered}(t_n) + \mathrm{step}(t_n)\,(F(\theta_n) + \mathrm{skew}\,S(\theta_n) + \mathrm{plate}\,P(\theta_n) +
\mathrm{blades}\,B(\theta_n) + \mathrm{beside}\,B'(\theta_n))

Its local numbers, by name, are one delay per wheel edge (the middle of the window after the trigger and the delay set, as the
passing of that edge shows it), the opening angle, the length of the window, by how much the mask's radial edges miss the axle,
by how much the opening is brighter at both its ends than in its middle (bow), and the share s of the frame before that a pixel
keeps: of all shapes the frame holds 1 - s as they are and s as they were one trigger earlier
(`physics.response.pixel_memory`). All the others are the recording's own; they enter linearly and are projected
out. Covered level and step drift as smooth curves and jump where a camera corrects itself, with as many numbers as the recording
asks for (`inference.drifting_levels`).

The wheel angle is taken at the moment of exposure, not at the trigger: an irregular slot or a change of speed between the two
does no harm. The fit of one recording alone, without any threshold, says where the joint fit of all (`estimate.joint`)
begins, how large the noise is, and which frames are wild.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import integration_time, opening_in_image, wild_frames
from irtiming.estimate.shared_residual import Trace
from irtiming.inference import correlated_noise, drifting_levels, optimiser, orthonormal, variable_projection
from irtiming.inference.optimiser import Linearised
from irtiming.inference.variable_projection import Projected
from irtiming.physics.light import pixel_sum, summed_region
from irtiming.physics.light.pixel_sum import Passing, Radii, Shapes
from irtiming.physics.light.summed_region import SummedRegion
from irtiming.physics.response import pixel_memory
from irtiming.physics.wheel import TURN, exposed_fraction
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.estimate import EDGE_DELAYS, DriftingLevels, EdgeDelayFit, Estimate
from irtiming.records.recording import FEWEST_FRAMES
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

MEMORY = pixel_memory.PARAMETER
"""Share s of the frame before that each frame holds."""

GLARE = "glare"
"""Share of the light that goes astray, out of the summed pixels where it comes from the opening's ends."""

BOW = "bow"
"""By how much the opening is brighter at both its ends than in its middle."""

SHAPE = ("opening_angle", "integration_time", "lean_low", "lean_high", GLARE, MEMORY, BOW)
"""Local numbers beside the edges' delays: rad, s, rad, rad, 1, 1, 1."""

_OWN_SHAPE = ("opening_angle", MEMORY, BOW)  # that one recording alone tells, and all share

CORNERS = "corner_variance"
"""Local number that may stand beside them: what else rounds the corners, rad^2."""

_SMALL = slice(2, 2 + len(pixel_sum.SMALL))  # of the recording's own numbers
_BLADES = pixel_sum.SMALL.index("blades")
_MOST_MEMORY = 0.5  # a frame that shows more of the one before is that of the trigger before
_SCAN = 240  # trial delays over a quarter turn to either side
_GAP_SEARCH = 81  # delays over the scan: closer together than the shortest gap in the slots is long


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelSums:
    """One recording before its model.

    ``kept`` (n_frame,) are the frames that count, ``levels`` how those drift.
    ``unit_dn`` is a first guess of the step, by which residuals are divided: a fitted one would let them vanish by growing.
    ``noise`` is the standard deviation of a residual in that unit. ``tails_s`` are the time constants of what comes after the
    window, by the names of the local numbers that say how much it is; none by default.
    """

    reduced: ReducedRecording
    wheel: WheelModel
    kept: Mask
    levels: DriftingLevels
    unit_dn: float
    border_rad: float
    noise: float = 1.0
    radii: Radii = field(default_factory=Radii)
    plate: SummedRegion | None = None
    uneven: SummedRegion | None = None
    lost: SummedRegion | None = None
    tails_s: Mapping[str, float] = field(default_factory=dict)

    @property
    def angular_frequency_rad_per_s(self) -> float:
        """Of the wheel."""
        return self.reduced.track.angular_frequency_rad_per_s

    @property
    def sums(self) -> Array:
        """Pixel sums of the kept frames in the unit of the guessed step, shape (n_kept,)."""
        return np.asarray(self.reduced.pixel_sums.pixel_sum[self.kept] / self.unit_dn)

    def angle(self, delay_s: float, *, is_before: bool = False) -> Array:
        """Wheel angle of the kept frames this long after the trigger and the delay set, rad, shape (n_kept,).

        Or at the frame before, one trigger earlier; before the wheel was recorded it has turned evenly.
        """
        ticks, set_s = self.reduced.trigger_ticks, self.reduced.trigger_delay_time_set_s
        now = wheel_angle_rad(delay_s, self.reduced.track, at_ticks=ticks[self.kept], set_s=set_s)
        if not is_before:
            return now
        then = wheel_angle_rad(
            delay_s,
            self.reduced.track,
            at_ticks=np.asarray(ticks[self.kept] - self.reduced.trigger_period_ticks, float),
            set_s=set_s,
        )
        step = self.angular_frequency_rad_per_s * self.reduced.trigger_period_s
        return np.where(np.isfinite(then), then, now - step)

    def shapes(self, numbers: Mapping[str, float]) -> Shapes:
        """F, S, U, P, B and B' of the kept frames, with what they hold of the frame before; shapes (n_kept,)."""
        now = pixel_sum.shapes(self.passing(numbers))
        if MEMORY not in numbers:
            return now
        return pixel_sum.remembered(now, pixel_sum.shapes(self.passing(numbers, is_before=True)), share=numbers[MEMORY])

    def passing(self, numbers: Mapping[str, float], *, is_before: bool = False) -> Passing:
        """Wheel, window and opening at the local numbers, or at the frame before."""
        delays, omega = np.array([numbers[name] for name in EDGE_DELAYS]), self.angular_frequency_rad_per_s
        middle = float(delays.mean())
        return Passing(
            wheel=self.wheel,
            middle_rad=self.angle(middle, is_before=is_before),
            edges_early_rad=omega * (delays - middle),
            opening_angle_rad=numbers["opening_angle"],
            swept_rad=omega * numbers["integration_time"],
            lean_low_rad=numbers["lean_low"],
            lean_high_rad=numbers["lean_high"],
            border_rad=self.border_rad,
            radii=self.radii,
            plate=self.plate,
            uneven=self.uneven,
            glare=numbers.get(GLARE, 0.0),
            bow=numbers.get(BOW, 0.0),
            lost=self.lost,
            tails=tuple((numbers.get(name, 0.0), omega * time_s) for name, time_s in self.tails_s.items()),
            corner_variance_rad2=numbers.get(CORNERS, 0.0),
        )

    def projected(self, numbers: Mapping[str, float]) -> Projected:
        """Residuals with the recording's own numbers at their best: covered, step, those of SMALL, then drifts.

        Columns of the derivatives as ``numbers`` stand: the edges' delays, then SHAPE.
        """
        omega, share = self.angular_frequency_rad_per_s, numbers.get(MEMORY, 0.0)
        passings = [self.passing(numbers, is_before=one) for one in (False, True)]
        angles, place = np.unique([one.middle_rad for one in passings], return_inverse=True)  # most are in both
        passing, (now, before) = replace(passings[0], middle_rad=angles), place.reshape(2, -1)
        every = pixel_sum.shapes(passing)
        made = every.at(now), every.at(before)
        columns = self.columns(pixel_sum.remembered(*made, share=share))
        gain = self.levels.gain[self.kept]
        per_unit = (
            {"integration_time": ("swept", omega)}
            | {name: (f"edge_{k}", omega) for k, name in enumerate(EDGE_DELAYS)}
            | {name: (f"tail_{k}", 1.0) for k, name in enumerate(self.tails_s)}
        )

        def slopes_of(levels: Array) -> Array:
            amounts = levels[_SMALL] / levels[1]
            step = levels[1] + gain @ levels[_SMALL.stop : _SMALL.stop + gain.shape[1]]
            named = dict(zip(pixel_sum.SMALL, amounts.tolist(), strict=True))
            slopes = pixel_sum.slopes(passing, **named)
            found = {name: (1 - share) * one[now] + share * one[before] for name, one in slopes.items()}
            later = [one.fraction + one.small @ amounts for one in made]
            found[MEMORY] = later[1] - later[0]
            taken = [per_unit.get(name, (name, 1.0)) for name in numbers]
            return np.stack([unit * step * found[name] for name, unit in taken], axis=1) / self.noise

        return variable_projection.project(self.sums / self.noise, columns / self.noise, slopes_of=slopes_of)

    def columns(self, made: Shapes) -> Array:
        """What the recording's own numbers multiply, shape (n_kept, k)."""
        own, moving = self.levels, made.fraction[:, None]
        small = own.relative_gain[self.kept, None] * made.small
        gain, drift = own.gain[self.kept] * moving, own.drift[self.kept]
        return np.concatenate([np.ones_like(moving), moving, small, gain, drift], axis=1)

    def at(self, numbers: Mapping[str, float]) -> Linearised:
        """Residuals over the noise, and derivatives; the model of the search, which steps back from windows of a whole turn."""
        if abs(self.angular_frequency_rad_per_s * numbers["integration_time"]) < TURN:
            return self.projected(numbers).at
        nowhere = np.full((self.kept.sum(), len(numbers)), np.nan)
        return Linearised(residual=nowhere[:, 0], jacobian=nowhere)

    def trace(self, numbers: Mapping[str, float]) -> Trace:
        """Residuals over the noise along the wheel angle, and all that the recording's own fit can take from them."""
        there = self.projected(numbers)
        return Trace(
            angle_rad=np.mod(self.passing(numbers).middle_rad, TURN),
            residual=there.at.residual,
            taken=orthonormal.of(np.hstack([there.basis, there.at.jacobian])).columns,
        )


def pixel_sums(reduced: ReducedRecording, wheel: WheelModel) -> PixelSums:
    """The recording with all its frames.

    Parameters
    ----------
    reduced
        Of a snapshot photon camera.
    wheel
        As drawn by rig.toml.
    """
    low, high = (float(v) for v in np.quantile(reduced.pixel_sums.pixel_sum, [0.03, 0.97]))
    unit_dn = low - high if reduced.opening.blackbody_is_colder else high - low
    ticks, distance = reduced.trigger_ticks, summed_region.radii_px(reduced.opening, reduced.axle)
    extent = None if distance is None else opening_in_image.extent_px(reduced, distance)
    return PixelSums(
        reduced=reduced,
        wheel=wheel,
        kept=np.ones(ticks.size, bool),
        levels=_straight(ticks, step_dn=unit_dn),
        unit_dn=unit_dn,
        border_rad=summed_region.border_rad(reduced.opening.border_px, radii_px=distance),
        radii=Radii() if extent is None else pixel_sum.radii(*extent),
        plate=opening_in_image.plate(reduced),
        uneven=opening_in_image.uneven(reduced),
        lost=opening_in_image.lost(reduced),
    )


def fit(reduced: ReducedRecording, wheel: WheelModel) -> EdgeDelayFit:
    """Delay of the window's middle by each of the four wheel edges, from one recording alone.

    Parameters
    ----------
    reduced
        One recording.
    wheel
        Wheel and opening; its edge angles are where a zero delay would be.

    Returns
    -------
    The window's length is held at what the recording states, and searched where it states none; the mask's edges are taken to
    point to the axle.

    Raises
    ------
    EstimationError
        If the sums do not follow the model, or too many frames are outliers.
    """
    given = _inside_track(replace(pixel_sums(reduced, wheel), radii=Radii()))
    starts = _starts(given, _scan(given))
    given, first = _levelled(given, _solved(given, *starts))
    kept = given.kept.copy()
    wild = wild_frames.of(given.at(first).residual, given.angle(0.0), name=reduced.name)
    kept[np.flatnonzero(kept)[wild]] = False
    given, first = _levelled(replace(given, kept=kept), first)
    middle = float(np.mean([first[name] for name in EDGE_DELAYS]))
    return _result(given, _solved(given, first | dict.fromkeys(EDGE_DELAYS, middle)), start=starts[0])


def _straight(ticks: Ticks, *, step_dn: float) -> DriftingLevels:
    """A covered level that drifts along a straight line, and a step that stays."""
    time = (ticks - ticks.mean()) / max(1.0, float(np.ptp(ticks)))
    return DriftingLevels(
        drift=time[:, None], gain=np.zeros((ticks.size, 0)), relative_gain=np.ones(ticks.size),
        relative_offset=np.zeros(ticks.size), covariance=np.zeros((1, 1)), step_dn=step_dn,
    )  # fmt: skip


def _levelled(given: PixelSums, numbers: dict[str, float]) -> tuple[PixelSums, dict[str, float]]:
    """With levels that drift as the frames want it, and the numbers with those; the same where they want a straight line."""
    made, n_frames = given.shapes(numbers), given.kept.size
    ticks = given.reduced.trigger_ticks[given.kept]
    found = drifting_levels.choose(
        given.sums,
        made.fraction,
        shapes=made.small,
        place=(ticks - ticks[0]) / max(1, int(np.ptp(ticks))),
        beside=True,
    )
    is_straight = found.n_numbers == 1 and given.levels.n_numbers == 1
    drift, gain = np.zeros((n_frames, found.drift.shape[1])), np.zeros((n_frames, found.gain.shape[1]))
    relative, offset = np.ones(n_frames), np.zeros(n_frames)
    drift[given.kept], gain[given.kept], relative[given.kept] = found.drift, found.gain, found.relative_gain
    offset[given.kept] = change = found.offset_change / found.contrast
    ends = (change, change + found.relative_gain)
    given = replace(given, levels=DriftingLevels(
        drift=drift,
        gain=gain,
        relative_gain=relative,
        relative_offset=offset,
        covariance=found.covariance,
        step_dn=found.contrast * given.unit_dn,
        sway=0.0 if is_straight else float(max(np.ptp(one) for one in ends)),
        jumps=tuple(int(k) for k in np.flatnonzero(given.kept)[list(found.jumps)]),
    ))  # fmt: skip
    return given, numbers if is_straight else _solved(given, numbers)


def _starts(given: PixelSums, delay_s: float) -> list[dict[str, float]]:
    axle, stated_s = given.reduced.axle, given.reduced.integration_time_s
    glare = 0.0 if axle is None else axle.glare
    windows_s = integration_time.starts_s(given.reduced, given.wheel) if stated_s is None else (stated_s,)
    shapes = [(given.wheel.opening_angle_rad, window_s, 0.0, 0.0, glare, 0.0, 0.0) for window_s in windows_s]
    return [dict.fromkeys(EDGE_DELAYS, delay_s) | dict(zip(SHAPE, shape, strict=True)) for shape in shapes]


def _solved(given: PixelSums, *starts: Mapping[str, float]) -> dict[str, float]:
    """Edge delays, opening angle, memory and bow at their best, and the window's length where it is not stated.

    A wide opening behind a window that sweeps little looks like a narrow one behind a window that sweeps much: of several starts,
    those that end in another opening than rig.toml's do not count.
    """
    found = [_solved_from(given, start) for start in starts]
    stated_rad = given.wheel.opening_angle_rad
    possible = [one for one in found if 0.2 < one["opening_angle"] / stated_rad < 5]
    if not possible:
        raise EstimationError(
            f"{given.reduced.name}: the pixel sums do not follow the wheel: fitted opening angle "
            f"{np.degrees(found[0]['opening_angle']):.2f} deg, rig.toml says {np.degrees(stated_rad):.2f} deg; check rig.toml "
            "and that the timestamps belong to these frames"
        )
    return min(possible, key=lambda one: given.at(one).deviance)


def _solved_from(given: PixelSums, start: Mapping[str, float]) -> dict[str, float]:
    free = _OWN_SHAPE if given.reduced.integration_time_s is not None else (*_OWN_SHAPE, "integration_time")
    held = [name for name in SHAPE if name not in free]
    found = optimiser.minimise(given.at, start=start, held=held).values
    if _MOST_MEMORY < found[MEMORY] < 1:
        found = optimiser.minimise(given.at, start=_of_own_trigger(given, found), held=held).values
    while untold := [name for name in (MEMORY, BOW) if name not in held and not abs(found[name]) < 1]:
        held = [*held, *untold]  # no shares: frames that hardly tell them do not tell them here
        found = optimiser.minimise(given.at, start={**start, **dict.fromkeys(untold, 0.0)}, held=held).values
    return found


def _of_own_trigger(given: PixelSums, found: Mapping[str, float]) -> dict[str, float]:
    """With a share of the frame before that is as far below a half as it is above: the light comes as late, and as long."""
    share = found[MEMORY]
    earlier_s = (2 * share - 1) * given.reduced.trigger_period_s
    return {**found, MEMORY: 1 - share} | {name: found[name] - earlier_s for name in EDGE_DELAYS}


def _inside_track(given: PixelSums) -> PixelSums:
    """Leave out frames whose exposure, for any delay of the scan, may fall outside the recorded wheel or into a gap."""
    quarter_s = TURN / 4 / given.angular_frequency_rad_per_s
    trials = np.linspace(-quarter_s, quarter_s, _GAP_SEARCH)
    inside = np.all([np.isfinite(given.angle(float(trial))) for trial in trials], axis=0)
    if inside.sum() < FEWEST_FRAMES:
        raise EstimationError(
            f"{given.reduced.name}: {inside.sum()} frames lie a quarter turn inside the recorded wheel, at least "
            f"{FEWEST_FRAMES} must; record the wheel's edges from before the first to after the last frame"
        )
    return replace(given, kept=inside)


def _scan(given: PixelSums) -> float:
    """Best of a grid of delays over a quarter turn to either side: the fit needs no start value from the user."""
    quarter_s = TURN / 4 / given.angular_frequency_rad_per_s
    sums = given.sums - given.sums.mean()
    trials = np.linspace(-quarter_s, quarter_s, _SCAN, endpoint=False)
    fits = [exposed_fraction(given.angle(float(t)), given.wheel) for t in trials]
    match = [float(sums @ (f - f.mean())) / float(np.std(f)) for f in fits]
    return float(trials[int(np.argmax(match))])


def _result(given: PixelSums, numbers: dict[str, float], *, start: Mapping[str, float]) -> EdgeDelayFit:
    names, half_s = (*EDGE_DELAYS, *_OWN_SHAPE), (given.reduced.integration_time_s or 0.0) / 2
    best = given.projected(numbers)
    step = float(best.levels[1])
    free = best.at.residual.size - len(names) - best.levels.size
    delays = np.array([numbers[name] for name in EDGE_DELAYS])
    angle = np.mod(given.angle(float(delays.mean()) - half_s), TURN)
    order = np.argsort(angle)
    residual = best.at.residual / step
    inflation = correlated_noise.variance_inflation(residual[order])
    jacobian = best.at.jacobian[:, [list(numbers).index(name) for name in names]]
    scale = np.linalg.norm(jacobian, axis=0)
    white = np.linalg.inv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    made = given.shapes(numbers)
    amounts, opening = best.levels[_SMALL] / step, given.reduced.opening
    per_pixel = float(opening.mask.sum() / opening.weight.sum())  # blades differ in the border as well
    u_sum = float(np.sqrt(best.at.deviance / free * inflation)) / abs(step)
    expected = made.fraction + made.small @ amounts
    return EdgeDelayFit(
        name=given.reduced.name,
        trigger_delay_time_set_s=given.reduced.trigger_delay_time_set_s,
        angular_frequency_rad_per_s=given.angular_frequency_rad_per_s,
        estimate=Estimate(
            names=names,
            units=("s",) * 4 + ("rad", "1", "1"),
            values=np.array([numbers[name] for name in names]),
            covariance=white * best.at.deviance / free * inflation,
        ),
        edge_delay_s=delays - half_s,
        start_delay_s=start[EDGE_DELAYS[0]] - half_s,
        wheel_angle_rad=angle[order],
        fraction=(residual + expected)[order],
        residual=residual[order],
        degrees_of_freedom=free,
        noise=float(np.sqrt(residual @ residual / free)),
        step=step,
        variance_inflation=inflation,
        n_dropped=int(given.reduced.trigger_ticks.size - given.kept.sum()),
        kept=given.kept,
        levels=given.levels,
        blades=float(amounts[_BLADES]) * per_pixel,
        u_blades=_u_blades(given, made) * u_sum * per_pixel,
    )


def _u_blades(given: PixelSums, made: Shapes) -> float:
    """Standard uncertainty of the blades' difference per that of a sum, beside the other levels."""
    columns, at = given.columns(made), _SMALL.start + _BLADES
    own, others = columns[:, at], np.delete(columns, at, axis=1)
    return float(1 / np.linalg.norm(own - others @ np.linalg.lstsq(others, own, rcond=1e-12)[0]))

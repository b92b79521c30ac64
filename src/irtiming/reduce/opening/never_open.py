"""Why frames never show the opening wholly open or wholly covered: the causes that the frames themselves give evidence of."""

import numpy as np

from irtiming.physics.wheel import TURN, steps_around
from irtiming.records.arrays import Array
from irtiming.reduce.opening import steady_levels
from irtiming.reduce.opening.steady_levels import SteadyLevels

_LEAST_PLATEAU_RAD = 0.05
_GLARE = 0.02
_FELT = 0.02  # of the step: what levels and frames may differ by on a plateau

Causes = list[tuple[float, str]]


def diagnosis(steady: SteadyLevels | None, wheel_angle_rad: Array | None, *, glare: float) -> str:
    """The evidence, the likeliest cause first, and what to do about that.

    Parameters
    ----------
    steady
        What the levels of the frames do; None where the frames do not follow a wheel with two cutouts.
    wheel_angle_rad
        Shape (n,); nan where unknown. None where no angle is known.
    glare
        By how much pixels far from the opening follow it, as a share of what it does.
    """
    if wheel_angle_rad is None:
        return "the mask must be narrower than the cutouts, the recording must span whole turns"
    found: Causes = _of_angles(wheel_angle_rad)
    if steady is not None:
        found += _of_levels(steady, glare)
    if not found and steady is None and not steady_levels.are_told(wheel_angle_rad):
        return (
            "the frames visit the wheel's angles so slowly that nothing distinguishes the causes: record at another wheel speed "
            "or frame rate (irtiming plan)"
        )
    if not found and steady is None:
        return (
            "their brightness does not follow a wheel with two cutouts: check that triggers and slots are values of the same "
            "counter, that each frame has its own trigger, and that nothing else moves before the camera"
        )
    if not found:
        return "no cause is found in the frames: look at them, and at [wheel] control_slots"
    return "; ".join(text for _, text in sorted(found, key=lambda one: -one[0]))


def _of_angles(wheel_angle_rad: Array) -> Causes:
    known = np.sort(np.mod(wheel_angle_rad[np.isfinite(wheel_angle_rad)], TURN))
    if not known.size:
        return []
    gap = steps_around(known)
    at, widest = int(np.argmax(gap)), float(gap.max())
    if widest < TURN / 8:
        return []
    start = np.degrees(known[at])
    return [
        (
            widest / _LEAST_PLATEAU_RAD,
            f"no frame shows the wheel between {start:.0f} and {start + np.degrees(widest):.0f} deg: record whole turns",
        )
    ]


def _of_levels(steady: SteadyLevels, glare: float) -> Causes:
    found: Causes = []
    plateau = steady.narrowest_rad - steady.opening_angle_rad
    if plateau < _LEAST_PLATEAU_RAD:
        what = (
            f"geometry: the frames show an opening of {np.degrees(steady.opening_angle_rad):.1f} deg behind cutouts and blades "
            f"of {np.degrees(steady.narrowest_rad):.1f} deg at the narrowest: the mask must be narrower than the cutouts"
        )
        found.append((1e3, what))
    if steady.sway > _FELT:
        jumps = f", with {steady.jumps.size} jumps" if steady.jumps.size else ""
        what = (
            f"drift: levels sway by {steady.sway:.1%} of the contrast over the recording{jumps}: let camera and blackbody "
            "settle, switch the camera's own correction off"
        )
        found.append((steady.sway / _FELT, what))
    if abs(steady.blades) > _FELT:
        what = (
            f"blades: one blade looks {abs(steady.blades):.1%} of the contrast warmer than the other: shade the wheel from the "
            "blackbody, let it turn until it is evenly warm"
        )
        found.append((abs(steady.blades) / _FELT, what))
    if steady.scatter > _FELT / 4:
        what = (
            f"noise: frames scatter by {steady.scatter:.1%} of the contrast about the wheel: bring the blackbody further from "
            "room temperature, look for disturbances"
        )
        found.append((4 * steady.scatter / _FELT, what))
    if glare > _GLARE:
        what = f"glare: pixels far from the opening follow it by {glare:.1%}: clean the optics, shade stray light"
        found.append((glare / _GLARE, what))
    return found

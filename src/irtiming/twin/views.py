"""What pixels make of the turning wheel: a photon detector's window, counted; a bolometer's lag, stepped."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol, final

import numpy as np

from irtiming.errors import PlanError
from irtiming.records.arrays import Array
from irtiming.twin import lag, window
from irtiming.twin.node_picture import CUTOUTS, SECOND_BLADE, NodePicture, Response, node_picture, read_rows
from irtiming.twin.noise import Values
from irtiming.twin.pixels import Picture, expose, picture
from irtiming.twin.scene import BolometerTiming, CameraTiming, Detector, Scene, Timing
from irtiming.twin.wide_range import WidePicture, read_wide_rows, wide_picture, wide_pixel

_WINDOW = ("integration_time_s", "substeps", "rise_s", "fall_s", "tail_share", "tail_s")
"""What a window's response hangs on."""


class Turning(Protocol):
    """What tells the angle of a wheel: a whole `Motion`, or a wheel that still turns."""

    def angle_at(self, time_s: Array) -> Array:
        """Unwrapped wheel angle, rad, at these times, any shape."""
        ...


class View(Protocol):
    """What pixels would give if there were neither shutter nor noise."""

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of rows whose turn begins at these times, shape (row,), s."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WindowView:
    """The turning wheel as pixels see it that average over instants_s, shape (n_instant,), all rows at once."""

    shot: Picture
    motion: Turning
    instants_s: Array

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of windows that begin at the middle of these times, shape (row,), s."""
        expose(self.shot, self.motion.angle_at(np.median(row_time_s) + self.instants_s), out=out)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowsView:
    """The turning wheel as pixels see it that are looked up row by row; they look from ``looks_s`` to ``until_s``.

    Both are counted from the row's turn, s; the wheel's speed in between is what counts.
    """

    shot: NodePicture | WidePicture
    motion: Turning
    nominal_rad_per_s: float
    looks_s: float
    until_s: float = 0.0

    @property
    def span_s(self) -> float:
        """Time constant of the pixels, or their window."""
        return self.until_s - self.looks_s

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of rows whose turn comes at these times, shape (row,), s."""
        if isinstance(self.shot, WidePicture):
            read_wide_rows(self.shot, self.motion.angle_at(row_time_s), out=out)
            return
        middle = np.median(row_time_s) + np.array([self.until_s, self.looks_s])
        now, before = self.motion.angle_at(middle)
        speed = (now - before) / (self.span_s * self.nominal_rad_per_s) - 1
        read_rows(self.shot, self.motion.angle_at(row_time_s), speed=speed, out=out)


def view_of_wheel(scene: Scene, motion: Turning) -> View:
    """The wheel at its nominal speed as the pixels of this scene's camera see it.

    Rays of a photon camera's snapshot are counted for each frame; a row by itself wants more of them where an edge of the
    opening crosses it, as `irtiming.twin.nodes` has them.

    Parameters
    ----------
    scene
        The rig as it truly is.
    motion
        Of its wheel.
    """
    if isinstance(scene.timing, CameraTiming) and scene.timing.row_delay_s is None:
        return WindowView(shot=still_picture(scene), motion=motion, instants_s=window.instants_s(scene.timing))
    return rows_view(scene, motion, rad_per_s=2 * math.pi * scene.trigger.true_wheel_hz)


def rows_view(scene: Scene, motion: Turning, *, rad_per_s: float) -> RowsView:
    """Pixels that average over a window or follow with a lag, linear ones or those that radiate.

    Parameters
    ----------
    scene
        The rig as it truly is.
    motion
        Of its wheel.
    rad_per_s
        Its nominal speed.
    """
    timing = scene.timing
    if isinstance(timing, CameraTiming):
        alone: Timing = replace(CameraTiming(), **{name: getattr(timing, name) for name in _WINDOW})
        looks_s, until_s = 0.0, timing.integration_time_s
    else:
        alone = BolometerTiming(time_constant_s=timing.time_constant_s, radiative=timing.radiative)
        looks_s, until_s = -settling_s(scene), 0.0
    shot = _rows_picture(replace(_still(scene), timing=alone), rad_per_s)
    return RowsView(shot=shot, motion=motion, nominal_rad_per_s=rad_per_s, looks_s=looks_s, until_s=until_s)


def response_of(scene: Scene, rad_per_s: float, *, seen: Sequence[float] = CUTOUTS) -> Response:
    """What linear pixels make of the wheel that passes at this speed, or of what is ``seen`` after each of its edges."""
    timing = scene.timing
    if isinstance(timing, BolometerTiming):
        return lag.response(scene.wheel, rad_per_s * timing.time_constant_s, seen=seen)
    instants = window.instants_s(timing) / timing.integration_time_s
    if timing.is_rectangular:
        instants = (np.arange(timing.substeps) + 0.5) / timing.substeps
    return window.response(scene.wheel, rad_per_s * timing.integration_time_s, instants=instants, seen=seen)


def lag_of(scene: Scene) -> BolometerTiming:
    """Timing of a camera whose pixels lag.

    Raises
    ------
    PlanError
        If they do not.
    """
    if isinstance(scene.timing, CameraTiming):
        raise PlanError("pixels without lag in a photon camera; start from microbolometer_scene()")
    return scene.timing


def settling_s(scene: Scene) -> float:
    """Time constant with which lagging pixels leave the shutter, s; of pixels that radiate the shortest."""
    timing = lag_of(scene)
    return timing.time_constant_s if timing.radiative is None else wide_pixel(scene).shortest_lag_s


def settled_dn(scene: Scene, temperature_k: float) -> float:
    """What a mean pixel gives that has looked at nothing but this temperature for long, DN."""
    if isinstance(scene.timing, BolometerTiming) and scene.timing.radiative is not None:
        return float(wide_pixel(scene).settled_dn(np.array(temperature_k)))
    return scene.radiance.level_dn(temperature_k)


def still_picture(scene: Scene) -> Picture:
    """Rays of a scene, the same for every run of a rig, so kept from one run to the next."""
    return _picture(_still(scene))


@lru_cache(maxsize=2)
def _picture(scene: Scene) -> Picture:
    return picture(scene)


@lru_cache(maxsize=2)
def _rows_picture(scene: Scene, rad_per_s: float) -> NodePicture | WidePicture:
    """Light of each pixel at one speed; the scene's timing is the response alone."""
    timing = scene.timing
    if isinstance(timing, BolometerTiming) and timing.radiative is not None:
        if scene.radiance.blade_share:
            raise PlanError("blades of two temperatures with a scene time constant; take one or the other")
        return wide_picture(scene, rad_per_s)
    span_s = timing.integration_time_s if isinstance(timing, CameraTiming) else timing.time_constant_s
    blade = response_of(scene, rad_per_s, seen=SECOND_BLADE) if scene.radiance.blade_share else None
    return node_picture(scene, response_of(scene, rad_per_s), span_rad=rad_per_s * span_s, blade=blade)


def _still(scene: Scene) -> Scene:
    """The part of a scene that says what each point sees of the wheel."""
    return Scene(
        wheel=scene.wheel,
        beams=scene.beams,
        mask=scene.mask,
        optics=scene.optics,
        radiance=scene.radiance,
        detector=Detector(rows=scene.detector.rows, columns=scene.detector.columns),
    )

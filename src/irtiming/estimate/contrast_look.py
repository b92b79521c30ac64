"""Contrast images of one wheel speed, and what a point of light anywhere on the wheel would show in them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self, final

import numpy as np
from numba import njit

from irtiming.estimate import by_speed
from irtiming.physics import wheel_harmonics
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import EDGE_DELAYS, Timing
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.reduced import ContrastImage, ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

_TABLE = 16384
_SWAY_HARMONICS = 24  # of what a sway does to an image: it need not be known as sharply
_HARMONICS = 1024  # beyond, the wheel turns by less than a pixel that is as many pixels from the axle
_NARROWEST_RAD, _WIDEST_RAD, _N_WIDTHS = 1e-3, 1.0, 70  # of the Gaussians by which the table is smoothed
_WIDTH_STEP = math.log(_WIDEST_RAD / _NARROWEST_RAD) / (_N_WIDTHS - 1)
_WIDTHS = np.geomspace(_NARROWEST_RAD, _WIDEST_RAD, _N_WIDTHS)
_ORDERS = np.arange(-_HARMONICS, _HARMONICS + 1)  # of the table's spectrum: there are no others
_SHORTEST_WAVE = 2.0  # in gaps of a quadrature: what it resolves
_SHARPNESS = 8  # with which what is shorter ends
_POWERS = _ORDERS.astype(float) ** _SHARPNESS
_LIT = 0.97
"""Quantile of what pixels show: an opening is a thirtieth of its region at least, and a plate may be nearly all else."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Unsteady:
    """What a number that is not known of the camera's levels does to an image, per standard uncertainty and contrast.

    ``table`` (16384,) is what it does to the projection of a point of light, over its polar angle from the bisector, ``offset``
    what it does to every pixel.
    """

    table: ComplexArray
    offset: complex

    def at(self, light: Array, angle_rad: Array) -> ComplexArray:
        """What it does to pixels of so much light at these angles, of one shape."""
        return np.asarray(light * _between(self.table, angle_rad) + self.offset)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """Contrast images of one wheel speed, added up; those of a colder opening with the other sign.

    ``table`` (16384,) is the projection of a point of light over its polar angle from the bisector, made with the weights of
    the recordings; ``omega`` the angular frequency, ``full_dn`` the projection of a pixel wholly in the light, roughly.
    ``turn`` is the name of the number by which the wheel is turned in this image: delay, lag and angle errors turn it at each
    speed by another angle. ``unsteady`` are the numbers that are not known of the levels, ``swayed`` is what they do to the image
    of a sector that is known, each of the region's shape; empty while none is.
    """

    projection: ComplexArray
    u_dn: float
    table: ComplexArray
    omega: float
    full_dn: float
    turn: str = "turn_rad"
    unsteady: tuple[Unsteady, ...] = ()
    swayed: tuple[ComplexArray, ...] = ()

    def values(self, angle_rad: Array) -> ComplexArray:
        """What a point of light shows at any angle, by linear interpolation; same shape."""
        return _between(self.table, angle_rad)

    def at_nodes(self, angle_rad: Array, *, gap_rad: float) -> ComplexArray:
        """The same for a quadrature whose nodes are that far apart: without waves that it would take for longer ones.

        A blur leaves next to nothing of such waves, since the nodes are as close as it asks.
        """
        if gap_rad not in self._without_waves:
            highest = TURN / (_SHORTEST_WAVE * gap_rad)
            kept = np.exp(_POWERS / -(highest**_SHARPNESS))
            self._without_waves.clear()
            self._without_waves[gap_rad] = self._weakened(kept)
        return _between(self._without_waves[gap_rad], angle_rad)

    def smeared(self, angle_rad: Array, *, width_rad: Array) -> ComplexArray:
        """Mean of the table over a Gaussian about any angle, with its standard deviation; all of one shape.

        Frames are few, so that the table is rough: a handful of its values would not tell its mean.
        """
        angles, smooth = np.ascontiguousarray(angle_rad), self._smoothed(width_rad.min(), width_rad.max())
        return np.asarray(_means(smooth, angles.ravel(), width_rad.ravel()).reshape(angles.shape))

    def _smoothed(self, narrowest_rad: float, widest_rad: float) -> ComplexArray:
        """The table smoothed by Gaussians from the narrowest to the widest, shape (70, 16384); those between both are made."""
        table, is_made = self._smooth
        first, last = int(_place_of_width(narrowest_rad)), int(_place_of_width(widest_rad)) + 1
        for k in first + np.flatnonzero(~is_made[first : last + 1]):
            table[k] = self._weakened(np.exp(-0.5 * (_ORDERS * _WIDTHS[k]) ** 2))
            is_made[k] = True
        return table

    @cached_property
    def _smooth(self) -> tuple[ComplexArray, Mask]:
        """Room for the smoothed tables, and which of them are made: an image asks for a few neighbours."""
        return np.empty((_N_WIDTHS, _TABLE), complex), np.zeros(_N_WIDTHS, bool)

    @cached_property
    def _without_waves(self) -> dict[float, ComplexArray]:
        """The last table of `at_nodes` by its gap: most steps of a search keep the gap."""
        return {}

    def _weakened(self, part: Array) -> ComplexArray:
        """The table of which that part of each order is left, shape (16384,)."""
        spectrum = np.zeros(_TABLE, complex)
        spectrum[_ORDERS] = self._spectrum * part
        return np.asarray(np.fft.ifft(spectrum))

    @cached_property
    def _spectrum(self) -> ComplexArray:
        """Of each order."""
        return np.asarray(np.fft.fft(self.table)[_ORDERS])


def _between(table: ComplexArray, angle_rad: Array) -> ComplexArray:
    """Table at any angle, by linear interpolation; of the angles' shape."""
    angles = np.ascontiguousarray(angle_rad)
    return np.asarray(_interpolated(table, angles.ravel()).reshape(angles.shape))


@njit(cache=True, nogil=True)
def _interpolated(table: ComplexArray, angle: Array) -> Any:
    """Table over one turn at each angle, shape (n,)."""
    out = np.empty(angle.size, np.complex128)
    for k in range(angle.size):
        place = angle[k] % TURN * (_TABLE / TURN)
        below = int(place)
        part = place - below
        out[k] = (1 - part) * table[below % _TABLE] + part * table[(below + 1) % _TABLE]
    return out


@njit(cache=True, nogil=True)
def _place_of_width(width: float) -> float:
    """Where a width stands among those of the smoothed tables."""
    return min(max(math.log(width / _NARROWEST_RAD) / _WIDTH_STEP, 0.0), _N_WIDTHS - 1.001)


@njit(cache=True, nogil=True)
def _means(smooth: ComplexArray, angle: Array, width: Array) -> Any:
    """Smoothed tables (70, 16384) at each angle, between the two of the nearest widths, shape (n,)."""
    out = np.empty(angle.size, np.complex128)
    for k in range(angle.size):
        place = angle[k] % TURN * (_TABLE / TURN)
        below = int(place)
        part, above, below = place - below, (below + 1) % _TABLE, below % _TABLE
        wide = _place_of_width(width[k])
        narrower = int(wide)
        first = (1 - part) * smooth[narrower, below] + part * smooth[narrower, above]
        second = (1 - part) * smooth[narrower + 1, below] + part * smooth[narrower + 1, above]
        out[k] = first + (wide - narrower) * (second - first)
    return out


def looks(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, timing: Timing) -> list[Look]:
    """Contrast images added up by wheel speed.

    ``timing``, as known so far, matters where frames are missing, or where a multiple of the wheel's angle turns slowly from
    frame to frame: then harmonics of the wheel other than the second show in the image. What the fit of a recording's sums
    found of its edges is better.
    """
    found = list[Look]()
    for members in by_speed.groups([one.track.angular_frequency_rad_per_s for one in recordings]):
        group = [recordings[k] for k in members]
        projection = np.sum([_turned_over(one) for one in group], axis=0)
        size = np.abs(projection)
        table, unsteady = np.zeros(_TABLE, complex), list[Unsteady]()
        for one in group:  # a recording's waves are many, and go with it
            point = _Point.of(one, wheel, timing)
            table += point.table(point.image.model_weight)
            unsteady += point.unsteady()
        found.append(
            Look(
                projection=projection,
                u_dn=float(np.sqrt(sum(one.contrast_image.u_dn**2 for one in group))),
                table=table,
                omega=float(np.mean([one.track.angular_frequency_rad_per_s for one in group])),
                full_dn=float(np.median(size[is_bright(size)])),
                turn=f"turn_{len(found)}_rad" if found else "turn_rad",
                unsteady=tuple(unsteady),
            )
        )
    return found


def is_bright(size: Array) -> Mask:
    """Pixels that swing by more than half of what the opening does; of the shape of their contrasts ``size``."""
    return np.asarray(size > 0.5 * np.quantile(size, _LIT))


def _turned_over(recording: ReducedRecording) -> ComplexArray:
    """Its image as a warm opening would show it, shape (roi rows, roi columns)."""
    projection = recording.contrast_image.projection_dn
    return -projection if recording.opening.blackbody_is_colder else projection


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Point:
    """A point of light before the wheel in one recording.

    Harmonics of its passing over the wheel angle, ``passing`` (M,), from the first order on, waves of the kept frames, ``waves``
    (n, M), and the contrast image that says with which weights they are added up.
    """

    passing: ComplexArray
    waves: ComplexArray
    image: ContrastImage

    @classmethod
    def of(cls, one: ReducedRecording, wheel: WheelModel, timing: Timing) -> Self:
        """That of a recording."""
        omega, response = one.track.angular_frequency_rad_per_s, camera(one.camera_type, one.readout_mode).response
        in_sums = one.contrast_image.in_sums
        late_rad, blade = omega * np.array([timing[name] for name in EDGE_DELAYS]), 0.0
        if in_sums is not None:
            late_rad, blade = in_sums.edges_late_rad, in_sums.blade_share
        by_edge = wheel_harmonics.open_harmonics(wheel, _HARMONICS) * wheel_harmonics.later(
            late_rad, n_harmonics=_HARMONICS
        )
        shown = by_edge.sum(axis=0)
        shown[1::2] -= blade * by_edge[2:, 1::2].sum(axis=0)  # in even orders a blade is as good as a weaker contrast
        passing = shown * response.transfer(omega, timing[response.PARAMETER], n_harmonics=_HARMONICS)
        angle = wheel_angle_rad(0.0, one.track, at_ticks=one.trigger_ticks, set_s=one.trigger_delay_time_set_s)
        waves = wheel_harmonics.later(angle, n_harmonics=_HARMONICS)
        return cls(passing=passing[1:], waves=waves[:, 1:], image=one.contrast_image)

    def table(self, weight: ComplexArray, *, orders: int = _HARMONICS) -> ComplexArray:
        """Projection of the point, less its mean, over its polar angle from the bisector, made with these weights (n,)."""
        spectrum, order = np.zeros(_TABLE, complex), np.arange(1, orders + 1)
        passing, waves = self.passing[:orders], self.waves[:, :orders]
        spectrum[-order] = passing * (weight @ waves) / 2
        spectrum[order] = (passing * (weight.conj() @ waves)).conj() / 2
        return np.fft.ifft(spectrum) * _TABLE

    def unsteady(self) -> list[Unsteady]:
        """What each number that is not known of the recording's levels does to the image."""
        in_sums, weight = self.image.in_sums, self.image.frame_weight
        if in_sums is None:
            return []
        return [
            Unsteady(table=self.table(weight * gain, orders=_SWAY_HARMONICS), offset=complex(weight @ offset))
            for gain, offset in zip(in_sums.u_gain.T, in_sums.u_offset.T, strict=True)
        ]

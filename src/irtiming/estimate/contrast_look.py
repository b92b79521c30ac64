"""Contrast images of one wheel speed, added up, with what a point of light would show in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self, final

import numpy as np

from irtiming.estimate import by_speed, point_table
from irtiming.estimate.point_table import HARMONICS, PointTable
from irtiming.physics import wheel_harmonics
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import EDGE_DELAYS, Timing
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.reduced import ContrastImage, ReducedRecording
from irtiming.records.wheel_geometry import WheelModel

IMAGE_ORDER = 2
"""Of the wheel's angle, twice a turn as the cutouts pass: an image shows next to nothing of others."""
_SWAY_HARMONICS = 24  # of what a sway does to an image: it need not be known as sharply
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
        return np.asarray(light * point_table.between(self.table, angle_rad) + self.offset)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """Contrast images of one wheel speed, added up; those of a colder opening with the other sign.

    ``point`` is what a point of light shows, made with the weights of the recordings, and ``odd`` what a warmer blade before it
    adds in odd orders, over the contrast of the opening; ``omega`` the angular frequency, ``full_dn`` the projection of a pixel
    wholly in the light, roughly. ``turn`` is the name of the number by which the wheel is turned in this image: delay, lag and
    angle errors turn it at each speed by another angle. ``unsteady`` are the numbers that are not known of the levels,
    ``swayed`` is what they do to the image of a sector that is known, each of the region's shape;
    empty while none is.
    """

    projection: ComplexArray
    u_dn: float
    point: PointTable
    odd: PointTable
    omega: float
    full_dn: float
    turn: str = "turn_rad"
    unsteady: tuple[Unsteady, ...] = ()
    swayed: tuple[ComplexArray, ...] = ()


def as_stated(recording: ReducedRecording) -> Timing:
    """Timing of a camera of which nothing is known but the integration time that its recording states: no delay."""
    response = camera(recording.camera_type, recording.readout_mode).response
    return dict.fromkeys(EDGE_DELAYS, 0.0) | {response.PARAMETER: recording.integration_time_s or 0.0}


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
        (table, odd), unsteady = np.zeros((2, point_table.SIZE), complex), list[Unsteady]()
        for one in group:  # a recording's waves are many, and go with it
            point = _Point.of(one, wheel, timing)
            table += point.table(point.passing, weight=point.image.model_weight)
            if point.odd.any():
                odd += point.table(point.odd, weight=point.image.model_weight)
            unsteady += point.unsteady()
        found.append(
            Look(
                projection=projection,
                u_dn=float(np.sqrt(sum(one.contrast_image.u_dn**2 for one in group))),
                point=PointTable(table=table),
                odd=PointTable(table=odd),
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

    Harmonics of its passing over the wheel angle, ``passing`` (M,), from the first order on, and of a warmer blade, ``odd`` (M,);
    waves of the kept frames, ``waves`` (n, M), and the contrast image that says with which weights they are added up.
    """

    passing: ComplexArray
    odd: ComplexArray
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
        by_edge = wheel_harmonics.open_harmonics(wheel, HARMONICS) * wheel_harmonics.later(
            late_rad, n_harmonics=HARMONICS
        )
        warmer = -blade * by_edge[2:].sum(axis=0)
        warmer[::2] = 0.0  # in even orders a blade is as good as a weaker contrast
        transfer = response.transfer(omega, timing[response.PARAMETER], n_harmonics=HARMONICS)
        passing, odd = by_edge.sum(axis=0) * transfer, warmer * transfer
        angle = wheel_angle_rad(0.0, one.track, at_ticks=one.trigger_ticks, set_s=one.trigger_delay_time_set_s)
        waves = wheel_harmonics.later(angle, n_harmonics=HARMONICS)
        return cls(passing=passing[1:], odd=odd[1:], waves=waves[:, 1:], image=one.contrast_image)

    def table(self, passing: ComplexArray, *, weight: ComplexArray) -> ComplexArray:
        """Projection of harmonics (k,), less their mean, over the polar angle from the bisector, with these weights (n,)."""
        spectrum, order = np.zeros(point_table.SIZE, complex), np.arange(1, passing.size + 1)
        waves = self.waves[:, : passing.size]
        spectrum[-order] = passing * (weight @ waves) / 2
        spectrum[order] = (passing * (weight.conj() @ waves)).conj() / 2
        return np.fft.ifft(spectrum) * point_table.SIZE

    def unsteady(self) -> list[Unsteady]:
        """What each number that is not known of the recording's levels does to the image."""
        in_sums, weight = self.image.in_sums, self.image.frame_weight
        if in_sums is None:
            return []
        return [
            Unsteady(
                table=self.table(self.passing[:_SWAY_HARMONICS], weight=weight * gain), offset=complex(weight @ offset)
            )
            for gain, offset in zip(in_sums.u_gain.T, in_sums.u_offset.T, strict=True)
        ]

"""What the reduction hands to the estimation: sums of each frame over the wheel angle, and a contrast image."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypeAlias, final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.finding import Finding
from irtiming.records.frame_events import FrameEvents
from irtiming.records.pixel_waves import PixelWaves
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.records.short_repr import short_repr
from irtiming.records.wheel_track import WheelTrack

Region: TypeAlias = tuple[int, int, int, int]
"""Part of an image: first row, end row, first column, end column, ends excluded."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Histogram:
    """Values of the region of interest in frames of the open wheel, and the threshold that was put between its two peaks.

    Parameters
    ----------
    threshold_dn
        Corrected pixel value above which a pixel counts, DN.
    plate_dn, blackbody_dn
        Peaks: mask plate around the opening, blackbody inside it, DN.
    bin_edges_dn, count
        Bin edges (n + 1,), DN, and pixels per bin (n,).
    """

    __repr__ = short_repr

    threshold_dn: float
    plate_dn: float
    blackbody_dn: float
    bin_edges_dn: Array
    count: Ticks


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Opening:
    """The mask opening as the camera sees it, found in the frames.

    Parameters
    ----------
    roi
        First row, end row, first column, end column, ends excluded.
    open_frame_dn, covered_frame_dn
        Mean corrected frames, shape (row, column), DN: from the middle of the plateaus where there are any, else of the most
        open and the most covered frames, to look at.
    mask
        Pixels at more than half of the contrast, shape (row, column).
    summed
        Pixels that are summed: the mask with its whole blurred border, shape (row, column).
    weight
        Weight of each pixel in the sums: 1 for ``summed``, 0 for ``bad`` and others, more beside a bad one that it stands in
        for; shape (row, column).
    border_px
        By how much ``summed`` exceeds ``mask`` on all sides, px.
    bad
        Dead and blinking pixels, shape (row, column); neighbours stand in for them.
    blackbody_is_colder
        Whether the opening gets darker as it is uncovered: then fractions are reversed (Schatz 2023, 3.2.3).
    histogram
        Where pixels are counted above a threshold; None elsewhere.
    """

    __repr__ = short_repr

    roi: Region
    open_frame_dn: Array
    covered_frame_dn: Array
    mask: Mask
    summed: Mask
    weight: Array
    border_px: int
    bad: Mask
    blackbody_is_colder: bool
    histogram: Histogram | None = None

    def n_summed(self, row_px: Ticks) -> Array:
        """How many pixels are summed in these rows, shape (n_row,): of each bad one another stands in."""
        return self.summed[row_px].sum(axis=1).astype(float)

    @property
    def n_bad_pixels(self) -> int:
        """Bad pixels of the region of interest."""
        row0, row1, column0, column1 = self.roi
        return int(self.bad[row0:row1, column0:column1].sum())


@final
@dataclass(frozen=True, kw_only=True)
class AxleView:
    """Wheel centre and mask as they appear in the image.

    ``row_px``, ``column_px`` locate the axle, found from when each pixel is covered. ``bisector_rad`` is the direction of
    the bisector of the mask's two radial edges, ``mean_angle_rad`` the mean polar angle, about the axle, of the light
    that comes through it, without what the mask plate around it adds: they differ, with the standard uncertainty
    ``u_off_axle_rad``, when the mask's own centre lies beside the axle. Polar angles in the image.
    ``edge_miss_px`` is by how much the mask's radial edges, that of the smaller polar angle first, miss the axle: at the radius r
    an edge stands ``edge_miss_px`` / r beyond its direction. None where it was not looked at. ``distortion`` is that of the
    lens (`physics.lens`); angles and ``edge_miss_px`` are those of the undistorted plane. ``blur_px`` is the blur's standard
    deviation, ``radii_px`` the opening's inner and outer radius; None where they were not looked at. ``plate_share`` (k,) is
    what a mask plate of the opening's contrast would add to the summed pixels from between two of ``beside_ends_rad`` (k + 1,),
    angles from ``mean_angle_rad`` as wheel coordinates grow, ``uneven_share`` (k,) what the uneven wheel does add, both over the
    whole sum; empty where the image was not looked at. ``glare`` is the share of the light
    that goes astray, with ``u_glare``, and ``lost_share`` (k,) the part of the opening's light that it takes out of the summed
    pixels from between two of ``lost_ends_rad`` (k + 1,), were all light astray; empty where it was not looked at.
    ``pixels_share`` (k,) is what the sum holds more from between two of ``pixels_ends_rad`` (k + 1,) since pixels stand in for
    dead ones and answer unequally, over the whole sum; empty where none do.
    """

    row_px: float
    column_px: float
    u_centre_px: float
    bisector_rad: float
    u_bisector_rad: float
    mean_angle_rad: float
    u_off_axle_rad: float
    edge_miss_px: tuple[float, float] | None = None
    u_edge_miss_px: float = 0.0
    distortion: float = 0.0
    u_distortion: float = 0.0
    blur_px: float = 0.0
    radii_px: tuple[float, float] | None = None
    beside_ends_rad: tuple[float, ...] = ()
    plate_share: tuple[float, ...] = ()
    uneven_share: tuple[float, ...] = ()
    glare: float = 0.0
    u_glare: float = 0.0
    lost_ends_rad: tuple[float, ...] = ()
    lost_share: tuple[float, ...] = ()
    pixels_ends_rad: tuple[float, ...] = ()
    pixels_share: tuple[float, ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class ShutterEvent:
    """Frames ``first_frame`` to ``end_frame`` (excluded) that do not show the scene: the camera corrects itself.

    ``kind`` is "closed" where they show something else, "frozen" where a frame is repeated.
    """

    first_frame: int
    end_frame: int
    kind: Literal["closed", "frozen"]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ContrastPairs:
    """The contrast image of frames that followed the one before, and of those before in their places.

    Parameters
    ----------
    projection_dn, before_dn
        Shape (roi rows, roi columns), complex; sum of frame_weight times the value of the frame, or of the frame before it, drift
        removed, DN.
    frame_weight
        Shape (n,), complex; as of the contrast image, over these frames alone, 0 for the others.
    """

    __repr__ = short_repr

    projection_dn: ComplexArray
    before_dn: ComplexArray
    frame_weight: ComplexArray


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FoundInSums:
    """What a fit of a recording's sums found that its contrast image must know.

    Parameters
    ----------
    edges_late_rad
        Shape (4,); by how much later than it is drawn each edge of the wheel covers or uncovers a point.
    blade_share
        By how much the blade between the edges 2 and 3 is warmer, over the contrast between the other one and the opening.
    relative_gain
        Shape (n,); gain of the kept frames over its mean.
    u_gain, u_offset
        Shapes (n, k); how k independent numbers change the relative gain, and the offset as a share of the contrast, each by its
        standard uncertainty.
    """

    __repr__ = short_repr

    edges_late_rad: Array
    blade_share: float
    relative_gain: Array
    u_gain: Array
    u_offset: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ContrastImage:
    """How much, and when, each pixel takes part in the wheel's turning: its projection on the second harmonic.

    No settled frame is needed: a lag lowers the amplitude of all pixels alike. Pixel value times ``frame_weight``, summed
    over the kept frames; the model is summed with the same weights, so that missing frames do no harm.

    Parameters
    ----------
    projection_dn
        Shape (roi rows, roi columns), complex; sum over frames of frame_weight times value, drift removed, DN.
    frame_weight
        Shape (n,), complex; weight of each kept frame, 2 / n times exp(-2 i theta) less its mean in each segment, where
        theta is the wheel angle at the trigger plus trigger_delay_time_set.
    u_dn
        Standard uncertainty of the real and of the imaginary part of one pixel, DN.
    good
        Shape (roi rows, roi columns); False for dead pixels, beside the opening for those that are stuck.
    roi
        First row, end row, first column, end column, ends excluded.
    pairs
        The same of frames that followed each other; None where it was not made.
    in_sums
        What a fit of the recording's sums found that the image must know; None while there is none.
    """

    __repr__ = short_repr

    projection_dn: ComplexArray
    frame_weight: ComplexArray
    u_dn: float
    good: Mask
    roi: Region
    pairs: ContrastPairs | None = None
    in_sums: FoundInSums | None = None

    @property
    def model_weight(self) -> ComplexArray:
        """Weight of each kept frame's model, shape (n,): its own, times the gain that the frame has."""
        return self.frame_weight if self.in_sums is None else self.frame_weight * self.in_sums.relative_gain


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelSums:
    """One number per kept frame, all pixels being read at the same time.

    Parameters
    ----------
    pixel_sum
        Shape (n,); sum over ``opening.summed`` of corrected values, DN.
    pixel_count
        Shape (n,); pixels on the open side of the threshold.
    """

    __repr__ = short_repr

    pixel_sum: Array
    pixel_count: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowSums:
    """One number per kept frame and image row.

    Parameters
    ----------
    row_px
        Shape (n_row,); image rows that hold light of the opening, ascending.
    row_sum_dn
        Shape (n, n_row); sum over ``opening.summed`` in each row, drift removed, DN.
    mask_row_sum_dn
        Shape (n, n_row); sum over ``opening.mask`` in each row (0 where it has no pixel), a straight line over time taken
        off as published, DN.
    drift_dn
        Shape (n,); mean level of one pixel that was taken off each frame of ``row_sum_dn``, DN.
    edge_frame_dn, edge_frame
        A frame in which an edge crosses the middle of the opening, as recorded, shape (row, column), and its place among the
        kept frames: to look at.
    """

    __repr__ = short_repr

    row_px: Ticks
    row_sum_dn: Array
    mask_row_sum_dn: Array
    drift_dn: Array
    edge_frame_dn: Pixels
    edge_frame: int


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedRecording:
    """One recording as numbers per frame.

    Parameters
    ----------
    n_frames
        In the recording.
    trigger_ticks
        Shape (n,); nominal trigger of each kept frame, ticks.
    frame_index
        Shape (n,); index of each kept frame in the recording.
    segment
        Shape (n,); number of the stretch between two shutter events, from 0: its offsets are its own.
    samples_per_turn
        Nominal wheel angles per turn, T / gcd(T, C).
    track, equal_track
        Wheel angles with learned and with equal slots.
    pixels
        Of a camera whose pixels are all read at once and do not lag; None of others.
    rows
        Of every other camera.
    contrast
        How each pixel follows the wheel; None where it was not made.
    waves
        Sums that tell the timing of every pixel; None where none were asked for.
    pixel_maps
        What else is known of each pixel of the region of interest over the kept frames, by name: ``mean_dn``, corrected DN, with
        any drift; ``u_gain``, relative standard uncertainty of its gain from finitely many reference frames, 0 without
        references; shape (roi rows, roi columns).
    references
        Fingerprint of the non-uniformity references; empty without.
    axle
        Wheel centre and mask in the image; None where they were not, or are not yet, found.
    events
        What the frames' delays count from, where the camera runs free: ``trigger_ticks`` are then these events; None of triggers.
    integration_time_s, blackbody_temperature_k, frame_period_s, bit_depth, camera, start_time, is_simulated
        As the recording tells them; None, or empty, where it does not.
    """

    __repr__ = short_repr

    name: str
    source: str
    sha256: str
    camera_type: CameraType
    readout_mode: ReadoutMode
    n_frames: int
    trigger_ticks: Ticks
    frame_index: Ticks
    segment: Ticks
    samples_per_turn: int
    track: WheelTrack
    equal_track: WheelTrack
    opening: Opening
    pixels: PixelSums | None = None
    rows: RowSums | None = None
    contrast: ContrastImage | None = None
    waves: PixelWaves | None = None
    pixel_maps: Mapping[str, Array] = field(default_factory=dict)
    references: str = ""
    axle: AxleView | None = None
    shutter_events: tuple[ShutterEvent, ...] = ()
    integration_time_s: float | None = None
    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    blackbody_temperature_k: float | None = None
    frame_period_s: float | None = None
    bit_depth: int | None = None
    camera: CameraIdentity | None = None
    settings: CameraSettings = field(default_factory=CameraSettings)
    start_time: str = ""
    is_simulated: bool = False
    events: FrameEvents | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def file(self) -> str:
        """Where it was read, or its name."""
        return self.source or self.name

    @cached_property
    def trigger_period_ticks(self) -> float:
        """From trigger to trigger, the median; two or more must be there."""
        return float(np.median(np.diff(self.trigger_ticks)))

    @property
    def trigger_period_s(self) -> float:
        """The same, s."""
        return self.trigger_period_ticks / self.track.clock_frequency_hz

    @property
    def pixel_sums(self) -> PixelSums:
        """The sums over the whole opening.

        Raises
        ------
        ReductionError
            If there are none.
        """
        if self.pixels is None:
            raise self._lacks("sums over the whole opening")
        return self.pixels

    @property
    def row_sums(self) -> RowSums:
        """The sums over the rows.

        Raises
        ------
        ReductionError
            If there are none.
        """
        if self.rows is None:
            raise self._lacks("sums over rows")
        return self.rows

    @property
    def contrast_image(self) -> ContrastImage:
        """How each pixel follows the wheel.

        Raises
        ------
        ReductionError
            If it was not made.
        """
        if self.contrast is None:
            raise self._lacks("a contrast image")
        return self.contrast

    def _lacks(self, what: str) -> ReductionError:
        camera = f"{self.readout_mode} {self.camera_type} camera"
        return ReductionError(f"{self.name}: the reduction of this {camera} has not made {what}; reduce it for that")

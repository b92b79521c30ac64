"""What the reduction of a rolling microbolometer camera hands to the estimation: row sums and a contrast image."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
from irtiming.records.reduced import AxleView
from irtiming.records.wheel_track import WheelTrack


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
        Shape (roi rows, roi columns); False for dead pixels.
    roi
        First row, end row, first column, end column, ends excluded.
    """

    projection_dn: ComplexArray
    frame_weight: ComplexArray
    u_dn: float
    good: Mask
    roi: tuple[int, int, int, int]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingOpening:
    """The mask opening as a microbolometer camera sees it, found in the frames.

    Parameters
    ----------
    roi
        First row, end row, first column, end column, ends excluded.
    open_frame_dn, covered_frame_dn
        Mean of some of the most open and the most covered frames, shape (row, column), DN; to look at, not settled.
    mask
        Pixels at more than half of the contrast, shape (row, column).
    summed
        Pixels that are summed: the mask with its whole blurred border, shape (row, column).
    border_px
        By how much ``summed`` exceeds ``mask`` on all sides, px.
    bad
        Pixels that do not follow the wheel, shape (row, column); neighbours in their row stand in for them.
    blackbody_is_colder
        Whether the opening gets darker as it is uncovered: then fractions are reversed (Schatz 2023, 3.2.3).
    """

    roi: tuple[int, int, int, int]
    open_frame_dn: Array
    covered_frame_dn: Array
    mask: Mask
    summed: Mask
    border_px: int
    bad: Mask
    blackbody_is_colder: bool


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedRows:
    """One recording of a rolling camera as sums per frame and row.

    Parameters
    ----------
    trigger_ticks
        Shape (n,); nominal trigger of each kept frame, ticks.
    frame_index
        Shape (n,); index of each kept frame in the recording.
    segment
        Shape (n,); number of the stretch between two shutter events, from 0: its offsets are its own.
    row_px
        Shape (n_row,); image rows that hold light of the opening, ascending.
    row_sum_dn
        Shape (n, n_row); sum over ``opening.summed`` in each row, drift removed, DN.
    mask_row_sum_dn
        Shape (n, n_row); sum over ``opening.mask`` in each row (0 where it has no pixel), a straight line over time taken
        off as published, DN.
    drift_dn
        Shape (n,); mean level of one pixel that was taken off each frame of ``row_sum_dn``, DN.
    samples_per_turn
        Nominal wheel angles per turn, T / gcd(T, C).
    track, equal_track
        Wheel angles with learned and with equal slots.
    edge_frame_dn, edge_frame
        A frame in which an edge crosses the middle of the opening, as recorded, shape (row, column), and its place among the
        kept frames: to look at.
    axle
        Wheel centre and mask in the image, once the contrast image has told; None before.
    blackbody_temperature_k
        As the recording tells it; None where it does not.
    """

    name: str
    source: str
    sha256: str
    n_frames: int
    trigger_ticks: Ticks
    frame_index: Ticks
    segment: Ticks
    row_px: Ticks
    row_sum_dn: Array
    mask_row_sum_dn: Array
    drift_dn: Array
    samples_per_turn: int
    track: WheelTrack
    equal_track: WheelTrack
    opening: RollingOpening
    contrast: ContrastImage
    shutter_events: tuple[ShutterEvent, ...]
    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    edge_frame_dn: Pixels
    edge_frame: int
    axle: AxleView | None = None
    warnings: tuple[str, ...] = ()
    blackbody_temperature_k: float | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExposedRows:
    """Opening fractions of whole opening and rows over the wheel angle at the trigger, averaged over runs (figure 6).

    Shapes: ``wheel_angle_rad`` (n,), sorted; ``fraction`` (n,) of the whole opening, ``row_fraction`` (n_row, n), all
    normalised by the averages of their upper and lower extrema and reversed for a cold blackbody, so that 1 is open;
    ``u_fraction`` (n,) and ``u_row_fraction`` (n_row, n) standard uncertainties of the means, None with a single run.
    ``row_px`` (n_row,). ``mask`` is the binary mask (row, column).
    """

    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    angular_frequency_rad_per_s: float
    names: tuple[str, ...]
    wheel_angle_rad: Array
    fraction: Array
    u_fraction: Array | None
    row_px: Ticks
    row_fraction: Array
    u_row_fraction: Array | None
    mask: Mask

"""What the exact model of a rolling microbolometer camera is made of, and what its fit gives for one recording."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.blur import Blur
from irtiming.records.estimate import Estimate
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True)
class LensTerms:
    """What a calibration says of a lens beyond its distortion k: OpenCV's further terms, in half diagonals of the image.

    ``quartic`` and ``sextic`` are k_2 and k_3, ``tangential_row`` and ``tangential_column`` p_1 and p_2, ``row_stretch`` is
    f_y / f_x: by how much larger the image is along its rows' order than along its columns'.
    """

    quartic: float = 0.0
    sextic: float = 0.0
    tangential_row: float = 0.0
    tangential_column: float = 0.0
    row_stretch: float = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class SectorShape:
    """Place and shape of the mask opening in the image: an annular sector, blurred.

    ``axle_row_px``, ``axle_column_px`` say where the wheel's axle appears; polar angles are taken about it. The mask's own
    arcs have their centre ``offset_row_px``, ``offset_column_px`` beside it, and radii about that centre. ``bisector_rad`` is
    the direction of the mask's bisector, ``opening_angle_rad`` gamma. Light is smeared by a Gaussian of the standard
    deviations ``blur_px`` (1 - ``blur_ellipticity``) over rows and ``blur_px`` (1 + ``blur_ellipticity``) over columns of the
    image, with the correlation ``blur_correlation`` of both, in the middle of the image; half a diagonal from there its
    variance is larger by the share ``blur_growth``, elsewhere as the square of the distance; but for the share ``glare`` of
    it, which a further round Gaussian, of the standard deviation ``glare_px``, spreads on top of that. ``distortion`` is that
    of the lens (`physics.lens`), in an image of ``image_rows`` by ``image_columns`` pixels, ``lens_row_px`` and
    ``lens_column_px`` say how far beside the middle of the image its centre lies, ``lens_terms`` what else is known of it.
    ``keystone_row`` and ``keystone_column`` are the shares by which a length of the wheel's plane appears shorter half a
    diagonal of the image further down, and further right; they come from a tilted camera (`physics.projection`), whose focal
    length is exp ``log_focal_length`` half diagonals. The ``warp_..._px`` are what moves places in the plane beside that
    (`physics.warp`): errors of lens and tilt together. Offsets, radii and angles are those of the wheel's plane, a px of it
    being as large as one of the image at the axle. ``mirrored`` is true for a counterclockwise wheel: then columns are counted
    leftwards from the axle, and polar angles, bisector and column offset with them.
    """

    axle_row_px: float
    axle_column_px: float
    offset_row_px: float
    offset_column_px: float
    inner_radius_px: float
    outer_radius_px: float
    bisector_rad: float
    opening_angle_rad: float
    blur_px: float
    distortion: float = 0.0
    blur_ellipticity: float = 0.0
    blur_correlation: float = 0.0
    blur_growth: float = 0.0
    glare: float = 0.0
    glare_px: float = 6.0
    keystone_row: float = 0.0
    keystone_column: float = 0.0
    log_focal_length: float = 0.0
    lens_row_px: float = 0.0
    lens_column_px: float = 0.0
    warp_aspect_px: float = 0.0
    warp_shear_px: float = 0.0
    warp_down_by_down_px: float = 0.0
    warp_down_by_both_px: float = 0.0
    warp_down_by_right_px: float = 0.0
    warp_right_by_down_px: float = 0.0
    warp_right_by_both_px: float = 0.0
    warp_right_by_right_px: float = 0.0
    warp_radial_px: float = 0.0
    lens_terms: LensTerms = field(default_factory=LensTerms)
    mirrored: bool = False
    image_rows: int = 0
    image_columns: int = 0

    @property
    def blur(self) -> Blur:
        """What smears light in the middle of the image, glare apart."""
        return Blur(
            rows_px=self.blur_px * (1 - self.blur_ellipticity),
            columns_px=self.blur_px * (1 + self.blur_ellipticity),
            correlation=self.blur_correlation,
        )

    @property
    def sense(self) -> float:
        """In which columns are counted from the axle, that polar angles go the wheel's way: 1 rightwards, -1 leftwards."""
        return -1.0 if self.mirrored else 1.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SectorFit:
    """The sector fitted to the contrast image.

    Parameters
    ----------
    shape, names, covariance
        The sector; names (n,) of its numbers that may be off and their covariance (n, n).
    contrast
        Shape (roi rows, roi columns); how much each pixel takes part, as measured: about 1 for a pixel wholly in the light.
    model_contrast
        The same by the sector alone.
    plate
        Contrast of the mask plate beside the opening, as a share of the opening's: it shows where the wheel is cut out, and
        need not be as warm as the wheel.
    ring, ring_angle_rad
        What the ring that the cutouts sweep adds everywhere, and the polar angle from the bisector at which it acts: the plate's
        contrast, and a smooth field, since the solid wheel reflects the camera unevenly; shape (roi rows, roi columns). The
        sector's light is then only what the opening shows beyond the plate.
    swept
        Part of each pixel over which the cutouts sweep, same shape: there the wheel itself shows, blade after blade.
    unevenness
        Standard deviation of that field over the ring, as a share of the contrast.
    field_height
        What the basis functions of such a field may be high, root mean square, by what the images say; a share of the contrast.
    borrowed, borrowed_angle_rad
        What dead pixels do not show of all that, and what their neighbours in the row show in their place; same shape.
    excess, excess_angle_rad
        What is left beyond that and beyond noise, pixel gains that differ and burrs of the mask; same shape.
    gain_scatter, border_scatter
        Standard deviation of a pixel's contrast beyond noise, well inside and on the border of the opening.
    odd
        Pixels whose contrast strays ten standard deviations from the model: a screw beside the opening, a gain that is not
        what it was; shape (roi rows, roi columns).
    summed
        Pixels that the row sums add up, same shape: what glare carries beyond them is lost.
    turn_rad
        By how much further the wheel has turned than the timing explains.
    ring_radii_px
        Between which radii the wheel's cutouts show the mask plate.
    plate_reflection
        How much of what the solid wheel reflects the mask plate reflects too, 0 to 1.
    row_delay_s, u_row_delay_s
        Row delay as the phases of the contrast image give it: a check on the row sums.
    reduced_chi_square
        Of the image; above 1 where the opening is no perfect sector.
    roi
        First row, end row, first column, end column, ends excluded.
    n_rounds
        How often it was fitted, each time with the timing of the last.
    gained
        By how much the last search lessened the sum of squares that it began with, for each image: where little, rows hardly
        move either.
    camera
        Lens and tilt as image and prior knowledge have them together; None where they were not settled. They need not be those of
        ``shape``, which the warp takes to the same place.
    """

    __repr__ = short_repr

    shape: SectorShape
    names: tuple[str, ...]
    covariance: Array
    contrast: Array
    model_contrast: Array
    plate: float
    ring: Array
    ring_angle_rad: Array
    swept: Array
    unevenness: float
    field_height: float
    borrowed: Array
    borrowed_angle_rad: Array
    excess: Array
    excess_angle_rad: Array
    gain_scatter: float
    border_scatter: float
    odd: Mask
    summed: Mask
    turn_rad: float
    ring_radii_px: tuple[float, float]
    plate_reflection: float
    row_delay_s: float
    u_row_delay_s: float
    reduced_chi_square: float
    roi: tuple[int, int, int, int]
    n_rounds: int
    gained: float
    camera: Estimate | None = None

    def value(self, name: str) -> float:
        """A number of the shape, or of lens and tilt as they are settled."""
        if self.camera is not None and name in self.camera:
            return self.camera.value(name)
        return float(getattr(self.shape, name))

    def u(self, name: str) -> float:
        """Standard uncertainty of that; 0 for one that is taken as exact."""
        if self.camera is not None and name in self.camera:
            return self.camera.u(name)
        if name not in self.names:
            return 0.0
        k = self.names.index(name)
        return float(self.covariance[k, k]) ** 0.5


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sway:
    """How a camera's levels changed while the wheel turned: smooth curves that all rows share.

    Parameters
    ----------
    offsets, gains
        Shapes (n_kept, p) and (n_kept, q); curves over the recording's kept frames, each of mean zero within its stretch between
        two shutter events and zero beside it.
    offset_amounts, gain_amounts
        Shapes (p,) and (q,); of the former as a share of the contrast, of the latter of the gain.
    covariance
        Shape (p + q, p + q); of the amounts, those of the offset first.
    n_looks
        How often curves were chosen.
    step, damping
        By how much the amounts were off when they were last improved, shape (p + q,) or none; share of it that they moved.
    """

    offsets: Array
    gains: Array
    offset_amounts: Array
    gain_amounts: Array
    covariance: Array
    n_looks: int = 0
    step: Array = field(default_factory=lambda: np.zeros(0))
    damping: float = 1.0

    @property
    def relative_gain(self) -> Array:
        """Gain of each frame over its mean, shape (n_kept,)."""
        return 1 + self.gains @ self.gain_amounts

    @property
    def offset_change(self) -> Array:
        """Offset of each frame less its mean, as a share of the contrast, shape (n_kept,)."""
        return self.offsets @ self.offset_amounts

    def of(self, frames: Mask) -> "Sway":
        """That of some of the frames, (n_kept,)."""
        return replace(self, offsets=self.offsets[frames], gains=self.gains[frames])


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Rival:
    """Another minimum of a recording: its numbers by name, and by how much higher its deviance is.

    Of a fit, over the inflation of its variances: correlated residuals tell minima apart less well than white ones.
    """

    timing: Mapping[str, float]
    higher: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowTimingFit:
    """The exact model fitted to the row sums of one recording.

    Parameters
    ----------
    estimate
        What was fitted, by name: ``edge_delay_0`` to ``edge_delay_3``, delay of row 0 as the passing of each wheel edge gives it,
        set delay taken off; ``time_constant`` of a lagging camera or ``integration_time`` of one with a window, whose middle the
        delays are then counted to; ``recursive_filter`` or ``pixel_memory``, the share of the frame before; ``row_delay`` of a
        rolling one. Covariance from the residuals.
    held
        Numbers that were not fitted: an integration time of which the frames say less than the recording does.
    step_rad
        Angle by which the wheel turns from trigger to trigger.
    undone
        Share of a recursive filter that frames were rid of before they were fitted; 0 where none was found.
    blades_apart
        Whether a warmer blade has one number for the opening and another for what shows of it beside.
    is_bent, bends
        Whether the two numbers of a response that is not a straight line were fitted, ``quadratic_nonlinearity`` and
        ``cubic_nonlinearity``, over the contrast; and those numbers, which one step of the fit tells where they were not; None
        before they were looked for.
    sway
        How gain and offset of the recording's kept frames changed, which row sums were rid of before they were fitted; None
        before it was looked for.
    kept
        Shape (n_kept,); which of the recording's kept frames were fitted: all, or those whose predecessor is known as well.
    start
        Where the search began, by name.
    n_steps
        Steps from there.
    shape_effect
        Change of each fitted number, in the order of ``estimate.names``, per unit of each number of the sector, in the order of
        its ``names``; shape (k, n_shape).
    row_px
        Shape (n_row,); rows that were fitted.
    wheel_angle_rad
        Shape (n,), at the trigger plus the set delay, in [0, 2 pi); frames in the order of the recording.
    fraction, model, residual
        Shape (n, n_row); row sums over each row's gain and offset, opening fraction; the model; their difference.
    noise
        Shape (n_row,); standard deviation of the residuals.
    harmonics
        Shape (n_row, M + 1); the model, harmonics over ``wheel_angle_rad``.
    gain_dn
        Shape (n_row,); row sum from covered to open, DN; negative for a cold blackbody.
    contrast_dn
        Shape (n_segment,); the same of a pixel, mean over the rows, in each stretch of fitted frames between shutter events.
    variance_inflation
        Factor on the variances because the residuals are correlated; 1 when they are white.
    blackbody_temperature_k
        As the recording tells it; None where it does not.
    rival
        The next higher minimum that searches have found; None where there is none.
    """

    __repr__ = short_repr

    name: str
    trigger_delay_time_set_s: float
    angular_frequency_rad_per_s: float
    estimate: Estimate
    held: Mapping[str, float]
    step_rad: float
    undone: float
    blades_apart: bool
    kept: Mask
    start: Mapping[str, float]
    n_steps: int
    shape_effect: Array
    row_px: Ticks
    wheel_angle_rad: Array
    fraction: Array
    model: Array
    residual: Array
    noise: Array
    harmonics: ComplexArray
    gain_dn: Array
    contrast_dn: Array
    variance_inflation: float
    blackbody_temperature_k: float | None = None
    sway: Sway | None = None
    is_bent: bool = False
    bends: Estimate | None = None
    rival: Rival | None = None

    @property
    def timing(self) -> dict[str, float]:
        """All numbers of the model by name, fitted or held, s."""
        return dict(zip(self.estimate.names, map(float, self.estimate.values), strict=True)) | dict(self.held)

    def holding(self, *names: str) -> "RowTimingFit":
        """The same with numbers, such as those that are this recording's own, held where they were found."""
        kept = [name for name in self.estimate.names if name not in names]
        at = [self.estimate.names.index(name) for name in kept]
        held = {name: self.timing[name] for name in names if name in self.estimate}
        return replace(
            self,
            estimate=self.estimate.pick(*kept),
            shape_effect=self.shape_effect[at],
            held={**self.held, **held},
        )

    @property
    def edge_delay_s(self) -> Array:
        """Delays by each wheel edge, to the reading of row 0 or the middle of its window, shape (4,), s."""
        return np.array([self.timing[f"edge_delay_{edge}"] for edge in range(4)])

    @property
    def row_delay_s(self) -> float:
        """Row delay; 0 of a snapshot, s."""
        return self.timing.get("row_delay", 0.0)

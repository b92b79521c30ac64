"""A camera's optics as they truly are: where the axle appears, lens, tilt, blur and glare."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.errors import PlanError

GlareShape = Literal["gaussian", "exponential"]
_MOST_GLARE = 0.5
_LEAST_GROWTH, _MOST_GROWTH = -0.9, 20.0


@final
@dataclass(frozen=True, kw_only=True)
class Optics:
    """From the rig plane to pixels.

    ``wheel_centre_*_px`` is where the axle appears in the image. A point at undistorted distance r_u from
    the lens's axis appears at r_d = r_u (1 + ``distortion`` r_u^2), both in half diagonals of the image. The lens's axis
    lies ``lens_centre_*_px`` from the middle of the image, downwards and to the right.
    ``blur_px`` is the standard deviation of the Gaussian that smears light along a row and along a column;
    ``blur_rows_px`` is that from row to row and ``blur_columns_px`` that from column to column, where they differ;
    ``blur_turn_rad`` turns both axes of it, from right to down. In the corners of the image its variance is larger by the share
    ``blur_growth`` than in the middle, elsewhere as the square of the distance.
    ``roll_rad`` turns the camera so that phi_image = phi_rig + roll.

    A tilted camera sees the plane of the wheel turned about the axle: by ``tilt_about_row_rad`` about a line that runs
    along a row, so that what is below recedes, and by ``tilt_about_column_rad`` about one along a column, so that what is on
    the right comes nearer. It sees it from a distance of ``focal_length_px`` pixel pitches.

    Of all light, ``glare_share`` goes astray into a tail whose standard deviation along each axis is ``glare_px``.
    """

    pixel_pitch_m: float = 0.2e-3
    wheel_centre_row_px: float = 255.5
    wheel_centre_column_px: float = 319.5
    roll_rad: float = 0.0
    blur_px: float = 0.7
    distortion: float = 0.0
    rays_along_pixel: int = 0
    """Its square are the rays of a pixel away from the edge of the opening; 0 takes as many as keep tens of megabytes."""

    lens_centre_row_px: float = 0.0
    lens_centre_column_px: float = 0.0
    tilt_about_row_rad: float = 0.0
    tilt_about_column_rad: float = 0.0
    focal_length_px: float = 1000.0
    blur_rows_px: float | None = None
    blur_columns_px: float | None = None
    blur_turn_rad: float = 0.0
    blur_growth: float = 0.0
    glare_share: float = 0.0
    glare_px: float = 6.0
    glare_shape: GlareShape = "exponential"

    def __post_init__(self) -> None:
        """Refuse what no lens does."""
        if not _LEAST_GROWTH <= self.blur_growth <= _MOST_GROWTH:
            raise PlanError(
                f"a blur whose variance grows by {self.blur_growth:g} to the corners; it must grow by {_LEAST_GROWTH:g} to "
                f"{_MOST_GROWTH:g}"
            )
        if not 0 <= self.glare_share <= _MOST_GLARE or not 0 < self.glare_px <= 100 or self.focal_length_px <= 0:
            raise PlanError(
                f"glare of {self.glare_share} over {self.glare_px} px with a focal length of {self.focal_length_px} px; "
                f"they must lie within 0 to {_MOST_GLARE}, 0 to 100 px, and above 0"
            )

    @property
    def blur_rows_columns_px(self) -> tuple[float, float]:
        """Standard deviation of the blur from row to row and from column to column, before its axes are turned."""
        rows = self.blur_px if self.blur_rows_px is None else self.blur_rows_px
        columns = self.blur_px if self.blur_columns_px is None else self.blur_columns_px
        return rows, columns

    @property
    def is_tilted(self) -> bool:
        """Whether the camera's axis is not normal to the wheel."""
        return self.tilt_about_row_rad != 0 or self.tilt_about_column_rad != 0

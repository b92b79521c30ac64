"""What a contrast image leaves over along the border of the opening, against blurs whose variance is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import special

from irtiming.estimate import image_doubts
from irtiming.physics import blurred_sector, sector_points
from irtiming.records.blur import Blur
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.rig import CameraOptics, Measured


@pytest.fixture(scope="module")
def sector(brute_bolometer, sector_of):
    """The camera's sector, perfectly fitted."""
    return sector_of(brute_bolometer(rows=40, columns=70, axle=(36.2, 34.3)))


def _light(shape, *blur_px):
    points = sector_points.light_points(replace(shape, blur_px=0.5))
    return blurred_sector.image(
        points, np.ones(points.row_px.size, complex), blur=Blur(blur_px[0], blur_px[-1]), roi=(0, 40, 0, 70)
    ).real


def _burrs(seed):
    """Light of patches of 3 x 3 pixels that is off by 1 % either way."""
    patches = np.random.default_rng(seed).normal(0, 0.01, (14, 24))
    return np.kron(patches, np.ones((3, 3)))[:40, :70]


@pytest.mark.parametrize("blur", [0.7, 1.1])
def test_variance_left_over_is_that_of_the_blur(sector, blur):
    """Oracle: differences of the squares of the standard deviations, on all four sides; corners cost a tenth."""
    excess = _light(sector.shape, blur) - _light(sector.shape, 0.8)
    found = image_doubts.left_over(replace(sector, excess=excess))
    np.testing.assert_allclose(found.variance_px2, blur**2 - 0.8**2, rtol=0.2)


def test_blur_of_another_kind_is_a_doubt(sector):
    """Oracle: the image of a blur of 0.8 px over rows and 1.4 px over columns, where the fit has a round one."""
    excess = _light(sector.shape, 0.8, 1.4) - _light(sector.shape, 0.8) + 0.3 * _burrs(1)
    (finding,) = image_doubts.of_image(replace(sector, excess=excess))
    assert (finding.code, finding.severity) == ("image-not-explained", "doubt")
    assert "radial edge" in finding.what


def test_what_the_model_is_uncertain_by_is_no_doubt(sector):
    """Oracle: by hand; all sides 0.01 px^2 off, a u of 0.001 each, and 0.01 in common: a chi squared of 1 with 4 degrees."""
    found = image_doubts.LeftOver(variance_px2=np.full(4, 0.01), u_px2=np.full(4, 0.001), u_model_px2=0.01)
    assert found.p_value == pytest.approx(special.chdtrc(4, 4 * 0.01**2 / (0.001**2 + 4 * 0.01**2)), rel=1e-9)
    assert np.abs(found.pulls) == pytest.approx(1, rel=0.01)
    apart = replace(found, variance_px2=np.array([0.01, -0.01, 0.01, -0.01]))
    assert apart.p_value == pytest.approx(special.chdtrc(4, 4 * 10**2), rel=1e-9)


@pytest.mark.parametrize(
    ("centre", "first_row", "codes"),
    [
        ((1.5, -2.0), None, ["lens-centre-far"]),
        ((81.0, 57.5), None, []),
        ((79.5, 27.6), None, []),
        ((79.5, 27.4), None, ["lens-centre-far"]),
        ((1.5, -2.0), 8, []),
    ],
)
def test_a_lens_centre_that_was_counted_from_the_middle_is_a_doubt(centre, first_row, codes):
    """Oracle: by hand; a fifth of 160 columns from (79.5, 59.5) is 32 px; of a region of interest it may lie anywhere."""
    first = SimpleNamespace(
        settings=CameraSettings(region_first_row=first_row), opening=SimpleNamespace(mask=np.zeros((120, 160), bool))
    )
    camera = CameraOptics(lens_centre_px=(Measured(centre[0]), Measured(centre[1])))
    assert [one.code for one in image_doubts.of_lens(camera, first)] == codes


def test_burrs_are_no_doubt(sector):
    """Oracle: 200 masks whose borders are off by 1 % of a pixel's light at random; chances spread over all values."""
    assert image_doubts.of_image(sector) == ()
    seen = [image_doubts.left_over(replace(sector, excess=_burrs(seed))).p_value for seed in range(200)]
    assert min(seen) > 1e-4
    assert 0.3 < np.mean(seen) < 0.7


def test_phases_that_scatter_more_than_noise_are_a_doubt(sector):
    """Oracle: a variance twice that of the noise; one as large as the noise is none."""
    (finding,) = image_doubts.of_image(replace(sector, reduced_chi_square=2.0))
    assert "2.00 times the variance" in finding.what
    assert image_doubts.of_image(replace(sector, reduced_chi_square=1.1)) == ()


def test_pixels_that_stray_do_not_count(sector):
    """Oracle: a screw at the border, told as odd."""
    excess, odd = _burrs(3), np.zeros((40, 70), bool)
    bright = excess.copy()
    bright[7:10, 30:33], odd[7:10, 30:33] = 1.0, True
    one, two = (
        image_doubts.left_over(replace(sector, excess=excess * ~odd, odd=odd)),
        image_doubts.left_over(replace(sector, excess=bright, odd=odd)),
    )
    np.testing.assert_allclose(one.variance_px2, two.variance_px2)


@pytest.mark.parametrize(("row_delay_us", "is_told"), [(1.15, False), (1.25, True), (-1.25, True)])
def test_rows_that_are_read_one_after_the_other_are_a_doubt(sector, row_delay_us, is_told):
    """Oracle: by hand; 0.2 us times the limit of six is 1.2 us, either way; a photon camera has no time constant."""
    found = image_doubts.of_rows(replace(sector, row_delay_s=1e-6 * row_delay_us, u_row_delay_s=0.2e-6))
    assert [(one.code, one.severity) for one in found] == [("rows-not-at-once", "doubt")] * is_told
    assert all("the timing found is that of no row" in one.what and "time constant" not in one.what for one in found)


@pytest.mark.parametrize(
    ("beside_deg", "u_stated_deg", "u_seen_deg", "is_doubt"),
    [(0.49, 0.0, 0.0, False), (-0.51, 0.0, 0.0, True), (1.2, 0.3, 0.0, False), (-1.31, 0.3, 0.0, True),
     (2.0, 0.3, 0.4, False), (-2.1, 0.3, 0.4, True)],
)  # fmt: skip
def test_an_opening_that_is_not_as_wide_as_its_mask_is_a_doubt(sector, beside_deg, u_stated_deg, u_seen_deg, is_doubt):
    """Oracle: by hand; half a degree, four of 0.3 degrees with it are 1.3, four of a 3-4-5 triangle with it 2.06."""
    covariance = np.zeros((len(sector.names), len(sector.names)))
    k = sector.names.index("opening_angle_rad")
    covariance[k, k] = np.radians(u_seen_deg) ** 2
    stated = Measured(sector.shape.opening_angle_rad - np.radians(beside_deg), np.radians(u_stated_deg))
    found = image_doubts.of_opening(replace(sector, covariance=covariance), stated)
    assert [(one.code, one.severity) for one in found] == [("opening-not-as-wide", "doubt")] * is_doubt


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("distortion", -0.19, None),
        ("distortion", -0.21, "its distortion would be 4 u off"),
        ("lens_column_px", -0.11 * 64, "its centre, from column to column, would be 6 u off"),
        ("keystone_row", np.radians(6.0) / 5.0, "the camera's tilt along rows would be 5 u off"),
    ],
)
def test_a_lens_that_hardly_is_there_is_a_doubt(sector, name, value, says):
    """Oracle: by hand; 0.05 of distortion, 2 % of 64 columns, and 1.2 deg of a focal length of 5 half diagonals are one u."""
    usual = {"distortion": 0.0, "log_focal_length": np.log(5.0), "lens_row_px": 0.0, "lens_column_px": 0.0,
             "keystone_row": 0.0, "keystone_column": 0.0}  # fmt: skip
    shape = replace(sector.shape, image_columns=64, **(usual | {name: value}))
    found = image_doubts.of_lens_found(replace(sector, shape=shape), CameraOptics())
    assert [one.severity for one in found] == ([] if says is None else ["doubt"])
    assert says is None or says in found[0].what

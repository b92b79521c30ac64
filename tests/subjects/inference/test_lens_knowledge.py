"""What rig.toml says of a lens, in the sector's units: by hand, half a diagonal of 300 x 400 pixels being 250."""

import math

import pytest

from irtiming.errors import GeometryError
from irtiming.inference import lens_knowledge
from irtiming.records.rig import CameraOptics, LensCalibration, Measured

_IMAGE = (300, 400)


def test_a_stated_lens_is_counted_in_half_diagonals_from_the_middle():
    """Oracle: by hand; 500 px are two half diagonals, the middle is at 199.5 and 149.5, and k grows by (250 / 200)^2."""
    camera = CameraOptics(
        focal_length_px=Measured(500.0, 10.0),
        lens_centre_px=(Measured(202.5, 1.0), Measured(147.5, 2.0)),
        distortion=Measured(-0.08, 0.01),
    )
    found = lens_knowledge.knowledge(camera, image=_IMAGE)
    assert found.known["log_focal_length"].value == pytest.approx(math.log(2))
    assert found.known["log_focal_length"].standard_uncertainty == pytest.approx(0.02)
    assert found.known["lens_column_px"] == Measured(3.0, 1.0)
    assert found.known["lens_row_px"] == Measured(-2.0, 2.0)
    assert found.known["distortion"].value == pytest.approx(-0.08 * 1.25**2)
    assert found.known["distortion"].standard_uncertainty == pytest.approx(0.01 * 1.25**2)


def test_a_calibration_counts_lengths_over_its_focal_length():
    """Oracle: by hand; at half a diagonal, 250 px, a ray is at half the focal length, 500 px: r^2 is 1/4 there."""
    calibration = LensCalibration(
        focal_length_px=(Measured(500.0, 5.0), Measured(510.0, 5.0)),
        centre_px=(Measured(199.5), Measured(149.5)),
        coefficients=(Measured(-0.2, 0.04), 0.08, 0.002, -0.004, 0.64),
    )
    found = lens_knowledge.knowledge(CameraOptics(calibration=calibration), image=_IMAGE)
    assert found.known["distortion"].value == pytest.approx(-0.2 / 4)
    assert found.known["distortion"].standard_uncertainty == pytest.approx(0.04 / 4)
    assert (found.terms.quartic, found.terms.sextic) == (pytest.approx(0.08 / 16), pytest.approx(0.64 / 64))
    assert (found.terms.tangential_row, found.terms.tangential_column) == (pytest.approx(0.001), pytest.approx(-0.002))
    assert found.terms.row_stretch == pytest.approx(1.02)
    assert found.known["lens_row_px"] == Measured(0.0, 0.0)


@pytest.mark.parametrize(("first", "refused"), [(-0.55, False), (-0.57, True), (1.99, False), (2.01, True)])
def test_a_calibration_of_no_lens_is_refused_with_what_k1_must_be(first, refused):
    """Oracle: by hand; a barrel's corners have no place below k = -4/27; refused below -0.14, which is k1 = -0.56 here."""
    calibration = LensCalibration(
        focal_length_px=(Measured(500.0), Measured(500.0)),
        centre_px=(Measured(199.5), Measured(149.5)),
        coefficients=(Measured(first, 0.04), 0.0, 0.0, 0.0, 0.0),
    )
    if not refused:
        assert (
            lens_knowledge.knowledge(CameraOptics(calibration=calibration), image=_IMAGE).start["distortion"]
            == first / 4
        )
        return
    with pytest.raises(GeometryError, match=rf"begin with {first}, .* from -0\.560 to 2\.000.*region_origin_px"):
        lens_knowledge.knowledge(CameraOptics(calibration=calibration), image=_IMAGE)


def test_what_is_not_stated_is_as_wide_as_lenses_are():
    """Oracle: the page of lens and tilt in words: a centre within 2 % of the image's width, fields of 9 to 53 degrees."""
    found = lens_knowledge.knowledge(CameraOptics(), image=_IMAGE)
    assert found.known["lens_row_px"] == found.known["lens_column_px"] == Measured(0.0, 8.0)
    focal_length = found.known["log_focal_length"]
    fields = [
        2 * math.atan(math.exp(-focal_length.value + side * focal_length.standard_uncertainty)) for side in (-1, 1)
    ]
    assert [math.degrees(one) for one in fields] == pytest.approx([9.1, 53.1], abs=0.1)

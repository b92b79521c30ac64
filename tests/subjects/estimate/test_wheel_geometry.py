"""The rig's angles and their uncertainties, from numbers that can be followed by hand."""

from dataclasses import replace
from math import atan, radians

import numpy as np
import pytest

from irtiming.estimate.wheel_geometry import geometry
from irtiming.records.reduced import AxleView
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel

D, DH, H = 12e-3, 7e-3, 16e-3  # gates at atan(3/4) and atan(4/3): 90 deg apart
BETA_1 = atan(0.75)
EDGES = (Measured(0.0), Measured(1.57), Measured(3.14), Measured(4.71))


@pytest.fixture
def rig():
    """Rig whose gates lie 90 deg apart, with an uncertainty on each number."""
    return Rig(
        wheel=Wheel(),
        light_gates=LightGates(
            half_separation_m=Measured(D, 5e-5), height_difference_m=Measured(DH, 2e-5), whole_slots_between=25
        ),
        mask_opening=MaskOpening(
            opening_angle_rad=Measured(radians(75)), centre_angle_rad=Measured(radians(-90), 5e-4)
        ),
    )


@pytest.fixture
def recording(track_of, reduced_recording):
    """Recording whose gates are found 90 deg apart; ``recording(axle=..., **fields of the track)``."""

    def make(*, axle=None, equal=np.pi / 2, **fields):
        track = track_of(duration_s=1.0, **({"gate_separation_rad": np.pi / 2} | fields))
        equal_track = replace(track, gate_separation_rad=equal)
        return reduced_recording(track, [], [], axle=axle, equal_track=equal_track)

    return make


def _axle(shift_rad, u_rad=2e-4):
    return AxleView(
        row_px=50.0,
        column_px=40.0,
        u_centre_px=0.01,
        bisector_rad=-1.5,
        u_bisector_rad=2 * u_rad,
        u_off_axle_rad=u_rad,
        mean_angle_rad=-1.5 + shift_rad,
    )


def test_gate_angle_follows_from_the_separation(rig, recording):
    """Oracle: two 3-4-5 triangles; d = 12, gates 16 and 9 mm below the axle."""
    found = geometry([recording()], rig, slots="learned", off_axle_mask=True)
    assert found.gates.height_m == pytest.approx(H)
    assert found.model.gate_angle_rad == pytest.approx(np.pi / 2 + BETA_1)
    assert found.model.centre_angle_rad == pytest.approx(radians(-90))
    assert found.model.opening_angle_rad == pytest.approx(radians(75))


def test_separations_of_all_recordings_are_averaged(rig, recording):
    """Oracle: by hand; 90 deg -+ 1 mrad, and the equal-slot track where it is asked for."""
    both = [recording(gate_separation_rad=np.pi / 2 + s, equal=1.5) for s in (-1e-3, 1e-3)]
    learned = geometry(both, rig, slots="learned", off_axle_mask=False)
    assert learned.gates.application_rad == pytest.approx(BETA_1, abs=1e-9)
    equal = geometry(both, rig, slots="equal", off_axle_mask=False)
    assert equal.gates.application_rad + equal.gates.control_rad == pytest.approx(1.5)


def test_edges_come_from_the_rig_file_first(rig, recording):
    """Oracle: by hand; stated edges win over timestamps, and their common uncertainty is the root mean square."""
    edges = tuple(Measured(v, u) for v, u in ((0.0, 0.0), (1.57, 3e-4), (3.15, 4e-4), (4.71, 5e-4)))
    stated = replace(rig, wheel=Wheel(cutout_edges_rad=edges))
    found = geometry(
        [recording(application_edges_rad=(0, 1.6, 3.2, 4.7))], stated, slots="learned", off_axle_mask=False
    )
    assert found.model.cutout_edges_rad == (0.0, 1.57, 3.15, 4.71)
    assert found.edges_from == "rig.toml"
    assert found.u_edge_rad == pytest.approx(np.sqrt((9 + 16 + 25) / 4) * 1e-4)
    assert found.findings == ()


def test_edges_without_uncertainty_state_none(rig, recording):
    """Oracle: the docstring; nobody stated one, so the scatter of the edges will be asked."""
    stated = replace(rig, wheel=Wheel(cutout_edges_rad=tuple(map(Measured, (0.0, 1.57, 3.15, 4.71)))))
    assert geometry([recording()], stated, slots="learned", off_axle_mask=False).u_edge_rad is None


def test_edges_come_from_the_timestamps_next(rig, recording):
    """Oracle: the track's own edges."""
    edges = (0.0, 1.571, 3.143, 4.711)
    found = geometry([recording(application_edges_rad=edges)], rig, slots="learned", off_axle_mask=False)
    assert found.model.cutout_edges_rad == edges
    assert found.edges_from.startswith("application_edges")


def test_edges_of_all_recordings_are_averaged(rig, recording):
    """Oracle: by hand; a recording without all four edges does not count."""
    seen = [recording(application_edges_rad=e) for e in ((0.0, 1.57, 3.14, 4.71), None, (0.0, 1.58, 3.15, 4.72))]
    found = geometry(seen, rig, slots="learned", off_axle_mask=False)
    np.testing.assert_allclose(found.model.cutout_edges_rad, (0.0, 1.575, 3.145, 4.715))


def test_camera_roll_is_the_turn_of_the_mask_in_the_image(rig, recording):
    """Oracle: by hand; bisector at -1.5 rad in the image, phi_M = -90 deg: rolled by 0.0708 rad; unknown without image."""
    found = geometry([recording(axle=_axle(3e-3)), recording()], rig, slots="learned", off_axle_mask=True)
    assert found.camera_roll_rad == pytest.approx(np.pi / 2 - 1.5)
    assert geometry([recording()], rig, slots="learned", off_axle_mask=True).camera_roll_rad is None


def test_ideal_edges_are_told(rig, recording):
    """Oracle: by hand; quarter turns, with a warning."""
    found = geometry([recording()], rig, slots="learned", off_axle_mask=False)
    np.testing.assert_allclose(found.model.cutout_edges_rad, np.arange(4) * np.pi / 2)
    assert found.edges_from == "ideal"
    assert "cutout edges taken as ideal" in found.findings[0].what


@pytest.mark.parametrize("rotation", ["clockwise", "counterclockwise"])
def test_mask_beside_the_axle_moves_the_opening(rig, recording, rotation):
    """Oracle: by hand; 3 mrad in the image are 3 mrad of phi_M, mirrored (180 deg - phi) for the other rotation."""
    turned = replace(rig, wheel=Wheel(rotation=rotation))
    axles = [_axle(2e-3), _axle(4e-3)]
    found = geometry([recording(axle=a) for a in axles], turned, slots="learned", off_axle_mask=True)
    centre = radians(-90) + 3e-3
    expected = centre if rotation == "clockwise" else np.pi - centre
    assert found.model.centre_angle_rad == pytest.approx(expected, abs=1e-12)
    without = geometry([recording(axle=a) for a in axles], turned, slots="learned", off_axle_mask=False)
    assert abs(without.model.centre_angle_rad - found.model.centre_angle_rad) == pytest.approx(3e-3)


def test_better_images_weigh_more(rig, recording):
    """Oracle: by hand; weights 1/u^2: (2 * 4 + 5 * 1) / 5 mrad for uncertainties of 0.2 and 0.4 mrad."""
    views = [recording(axle=_axle(2e-3, 2e-4)), recording(axle=_axle(5e-3, 4e-4)), recording(axle=None)]
    found = geometry(views, rig, slots="learned", off_axle_mask=True)
    assert found.model.centre_angle_rad - radians(-90) == pytest.approx(13e-3 / 5)


def test_budget_by_hand(rig, recording):
    """Oracle: central differences of atan(d / h(d, dh, dbeta)), times each uncertainty."""
    found = geometry([recording(axle=_axle(0.0), u_gate_separation_rad=2e-4)], rig, slots="learned", off_axle_mask=True)

    def beta(d, dh, separation):
        moved = LightGates(half_separation_m=Measured(d), height_difference_m=Measured(dh), whole_slots_between=25)
        other = recording(gate_separation_rad=separation)
        return geometry(
            [other], replace(rig, light_gates=moved), slots="learned", off_axle_mask=False
        ).gates.application_rad

    at = (D, DH, np.pi / 2)
    expected = [5e-4]
    for k, (size, u) in enumerate(((1e-6, 5e-5), (1e-6, 2e-5), (1e-5, 2e-4))):
        ahead, behind = (beta(*(v + s * size * (i == k) for i, v in enumerate(at))) for s in (1, -1))
        expected.append(abs(ahead - behind) / (2 * size) * u)
    expected.append(2e-4)
    assert [u for _, _, u in found.angle_budget] == pytest.approx(expected, rel=1e-4)
    assert [kind for _, kind, _ in found.angle_budget] == ["B", "B", "B", "A", "A"]


def test_the_register_is_that_of_the_worst_recording(rig, recording):
    """Oracle: by hand; the register is common to all, so that it does not average out: 3e-4 of 1e-4, 3e-4 and 2e-4."""
    views = [recording(u_gate_separation_rad=u) for u in (1e-4, 3e-4, 2e-4)]
    alone = [recording(u_gate_separation_rad=3e-4)]
    budgets = [geometry(some, rig, slots="learned", off_axle_mask=False).angle_budget for some in (views, alone)]
    assert [u for _, _, u in budgets[0]] == pytest.approx([u for _, _, u in budgets[1]])


def test_the_mask_beside_the_axle_is_as_uncertain_as_its_images(rig, recording):
    """Oracle: by hand; they look through one lens at one mask, so that the mean of 2e-4 and 4e-4 stands there."""
    views = [recording(axle=_axle(2e-3, u)) for u in (2e-4, 4e-4)]
    budget = geometry(views, rig, slots="learned", off_axle_mask=True).angle_budget
    assert budget[-1] == ("mask beside the axle (image)", "A", pytest.approx(3e-4))


def test_mask_without_stated_uncertainty_is_told(rig, recording):
    """Oracle: conventions.md; an error of phi_M is an error of absolute angle, so silence about it is a risk."""
    exact = replace(rig, mask_opening=replace(rig.mask_opening, centre_angle_rad=Measured(radians(-90))))
    found = geometry([recording()], exact, slots="learned", off_axle_mask=False)
    assert any("phi_M is taken as exact" in one.sentence() for one in found.findings)


def test_the_lateral_offset_is_a_line_of_the_budget(rig, recording):
    """Oracle: central differences of beta_1 to x, times its uncertainty; the published procedure knows nothing of it."""

    def at(x, slots="learned"):
        beams = replace(rig.light_gates, lateral_offset_m=Measured(x, 6e-5))
        return geometry([recording()], replace(rig, light_gates=beams), slots=slots, off_axle_mask=False)

    u = {source: u for source, _, u in at(1e-4).angle_budget}["lateral offset of the beams"]
    ahead, behind = (at(1e-4 + s).gates.application_rad for s in (1e-6, -1e-6))
    assert u == pytest.approx(abs(ahead - behind) / 2e-6 * 6e-5, rel=1e-5)
    assert at(1e-4).measured["lateral offset of the beams"] == (6e-5, "m")
    assert at(1e-3, slots="equal").gates.application_rad == pytest.approx(BETA_1)


@pytest.mark.parametrize(
    ("off_deg", "codes"), [(4.9, []), (-4.9, []), (5.1, ["mask-not-where-stated"]), (-90, ["mask-not-where-stated"])]
)
def test_a_mask_that_no_upright_camera_sees_there_is_a_doubt(rig, recording, off_deg, codes):
    """Oracle: by hand; the image has it at -1.5 rad, and 5 degrees are the most that a camera is rolled."""
    stated = Measured(-1.5 - radians(off_deg), 5e-4)
    known = replace(
        rig, mask_opening=replace(rig.mask_opening, centre_angle_rad=stated), wheel=Wheel(cutout_edges_rad=EDGES)
    )
    for off_axle_mask in (True, False):
        found = geometry([recording(axle=_axle(0.0))], known, slots="learned", off_axle_mask=off_axle_mask).findings
        assert [one.code for one in found if one.severity == "doubt"] == codes


@pytest.mark.parametrize(
    ("roll", "off_deg", "codes"),
    [
        (Measured(radians(12), radians(0.3)), 12 + 1.9, []),
        (Measured(radians(12), radians(0.3)), 12 - 1.9, []),
        (Measured(radians(12), radians(0.3)), 12 + 2.1, ["mask-not-where-stated"]),
        (Measured(radians(12), radians(0.3)), 0.0, ["mask-not-where-stated"]),
        (Measured(radians(12)), 12 + 4.9, []),
        (Measured(radians(12)), 12 - 5.1, ["mask-not-where-stated"]),
        (Measured(radians(-179), radians(0.3)), 180.0, []),
        (Measured(radians(0), radians(0.3)), 2.1, ["mask-not-where-stated"]),
    ],
)
def test_the_mask_is_sought_where_a_rolled_camera_sees_it(rig, recording, roll, off_deg, codes):
    """Oracle: by hand; the image has it at -1.5 rad, and four of hypot(0.3, 0.4) = 0.5 degrees are 2, of a roll by eye 5."""
    stated = Measured(-1.5 - radians(off_deg), radians(0.4))
    known = replace(
        rig,
        camera=replace(rig.camera, roll_rad=roll),
        mask_opening=replace(rig.mask_opening, centre_angle_rad=stated),
        wheel=Wheel(cutout_edges_rad=EDGES),
    )
    found = geometry([recording(axle=_axle(0.0))], known, slots="learned", off_axle_mask=True)
    assert [one.code for one in found.findings if one.severity == "doubt"] == codes
    assert np.exp(1j * found.camera_roll_rad) == pytest.approx(np.exp(1j * radians(off_deg)))


@pytest.mark.parametrize(("ruler_m", "codes"), [(H, []), (H + 1.9e-3, []), (H - 2.1e-3, ["height-contradicts-ruler"])])
def test_a_ruler_that_says_otherwise_is_a_doubt(rig, recording, ruler_m, codes):
    """Oracle: two 3-4-5 triangles give 16 mm, and slots of 45 degrees leave no other number."""
    stated = replace(
        rig,
        light_gates=replace(rig.light_gates, height_m=ruler_m),
        wheel=Wheel(control_slots=8, cutout_edges_rad=EDGES),
    )
    stated = replace(stated, light_gates=replace(stated.light_gates, whole_slots_between=2))
    found = geometry([recording()], stated, slots="learned", off_axle_mask=False).findings
    assert [one.code for one in found] == codes

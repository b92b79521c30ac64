"""Schatz 2023, sections 2.4 and 2.5: the model of the wheel and its numbers."""

from math import pi, radians
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.physics.wheel import corner_angles_rad, exposed_fraction, slope_centres_rad, wheel_model
from irtiming.records.recording import Recording
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig, Wheel
from irtiming.reduce.wheel.wheel_angles import track
from irtiming.twin.scene import paper_scene

TURN = 2 * pi
GAMMA = 5 / 12 * pi
EDGES = (0.0, 1.5718, 3.1421, 4.7125)


@pytest.fixture(scope="module")
def model():
    """Return the wheel of figure 4 with its mask at the top of the image."""
    return wheel_model(EDGES, 0.27, opening_angle_rad=GAMMA, centre_angle_rad=radians(-90))


def test_mask_cutout_angle_is_five_twelfths_of_pi():
    """Oracle: sections 2.1 and 2.5; a 75 deg section, gamma = 5/12 pi, is the share of the turn that each edge takes to pass."""
    corners = corner_angles_rad(wheel_model(EDGES, 0.27, opening_angle_rad=radians(75), centre_angle_rad=radians(-90)))
    np.testing.assert_allclose(corners[:, 1] - corners[:, 0], 5 / 12 * pi, rtol=1e-12)
    assert paper_scene().mask.opening_angle_rad == pytest.approx(5 / 12 * pi, rel=1e-15)


def test_figure_4b_has_four_slopes_of_75_deg_and_four_plateaus_of_15(model):
    """Oracle: section 3.1.3; 75 of 90 deg leave 15 deg wholly open or covered, twice each."""
    ideal = wheel_model(tuple(np.arange(4) * pi / 2), 0.27, opening_angle_rad=GAMMA, centre_angle_rad=-pi / 2)
    corners = np.degrees(np.sort(corner_angles_rad(ideal), axis=0))
    np.testing.assert_allclose(corners[:, 1] - corners[:, 0], 75)
    np.testing.assert_allclose(np.diff(np.append(corners[:, 0], corners[0, 0] + 360)) - 75, 15)
    theta = np.radians(np.arange(0, 360, 0.1) + 0.05)
    fraction = exposed_fraction(theta, ideal)
    assert np.mean(fraction > 1 - 1e-9) == pytest.approx(30 / 360, abs=1e-3)
    assert np.mean(fraction < 1e-9) == pytest.approx(30 / 360, abs=1e-3)


def test_slopes_are_linear_with_inclination_one_over_gamma(model):
    """Oracle: section 3.1.4; the slopes are linear due to the design of the cutout, 1/2 + m (x - c), m = +-1/gamma."""
    for i, centre in enumerate(slope_centres_rad(model)):
        x = centre + np.linspace(-0.45, 0.45, 50) * GAMMA
        m = (-1 if i % 2 == 0 else 1) / GAMMA
        np.testing.assert_allclose(exposed_fraction(x, model), 0.5 + m * (x - centre), atol=1e-12)


def _recorded(*, edge_angles_rad, separation_rad):
    """Ticks of the paper's clock (49.152 MHz) and wheel (3 Hz): 100 even slots and four edges, edge 0 first, ten turns."""
    turn = 16_384_000
    control = np.rint(turn * (np.arange(1200) / 100 - 1 - separation_rad / TURN)).astype(np.int64)
    edges = np.rint(turn * (np.arange(10)[:, None] + np.array(edge_angles_rad) / TURN)).astype(np.int64)
    return Recording(
        name="paper",
        camera_type="photon",
        readout_mode="snapshot",
        frames=SimpleNamespace(shape=(0, 1, 1)),
        frame_number=np.zeros(0, np.int64),
        clock_frequency_hz=49_152_000.0,
        camera_trigger_ticks=np.zeros(0, np.int64),
        control_slot_ticks=control,
        application_slot_ticks=edges[:, [0, 2]].ravel(),
        application_edge_ticks=edges.ravel(),
        rotation_speed_hz=3.0,
    )


RIG = Rig(
    wheel=Wheel(),
    light_gates=LightGates(
        half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9
    ),
    mask_opening=MaskOpening(opening_angle_rad=Measured(GAMMA), centre_angle_rad=Measured(-pi / 2)),
)


def test_delay_of_the_next_control_slot_resolves_the_gates():
    """Oracle: section 2.5 with the order of the gates taken from the geometry (conventions.md).

    With the control gate first on an edge's way, slot j passes it at theta = j pi/50 - dbeta, so the next one after
    the reference edge comes (floor(dbeta 50/pi) + 1) pi/50 - dbeta later, not dbeta - floor(...) pi/50.
    """
    dbeta = 0.5697
    recording = _recorded(edge_angles_rad=EDGES, separation_rad=dbeta)
    reference = recording.application_slot_ticks[0]
    after = recording.control_slot_ticks[recording.control_slot_ticks > reference][0] - reference
    assert after / 16_384_000 * TURN == pytest.approx(10 * pi / 50 - dbeta, abs=1e-6)
    assert track(recording, RIG).gate_separation_rad == pytest.approx(dbeta, abs=1e-6)


@pytest.mark.parametrize("late_edge", [0, 2])
def test_irregularity_on_the_oscilloscope_tells_the_reference_edge(late_edge):
    """Oracle: section 4; half turns that differ by 26 us at 3 Hz: alpha_2 lies 0.245 mrad, half of that, beyond pi."""
    irregular = 26e-6 * TURN * 3 / 2
    edges = (0.0, pi / 2, pi + (irregular if late_edge == 2 else -irregular), 3 * pi / 2)
    recording = _recorded(edge_angles_rad=edges, separation_rad=0.5697)
    half_turns = np.diff(recording.application_slot_ticks) / 49.152
    assert abs(half_turns[0] - half_turns[1]) == pytest.approx(26, abs=0.05)
    found = track(recording, RIG)
    assert found.application_edges_rad[2] - pi == pytest.approx(irregular, abs=1e-6)
    assert irregular == pytest.approx(0.245e-3, rel=0.01)
    # zero is where the longer half turn begins
    at_zero = np.interp(TURN * np.arange(2, 6), found.edge_angle_rad, found.edge_ticks)
    longer = recording.application_slot_ticks[(0 if late_edge == 2 else 1) :: 2]
    assert np.abs(at_zero[:, None] - longer).min(axis=1).max() < 3

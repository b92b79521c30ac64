"""The wheel's own drawing."""

import re
from math import atan2, degrees, hypot, radians
from xml.etree import ElementTree

import pytest

from irtiming.physics.light_gates import gate_angles
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_drawing import drawing
from irtiming.records.rig import LightGates, Measured

SVG = "{http://www.w3.org/2000/svg}"
GATES = gate_angles(
    0.5697, LightGates(half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9)
)
EDGES = (0.0, radians(90.5), radians(180.2), radians(270.1))
SIDE = {"clockwise": 1, "counterclockwise": -1}


@pytest.fixture(params=["clockwise", "counterclockwise"])
def rotation(request):
    return request.param


def _drawn(rotation, wheel_angle_rad=0.8, gates=GATES):
    model = wheel_model(
        EDGES, gates.application_rad, opening_angle_rad=radians(75), centre_angle_rad=radians(-90), rotation=rotation
    )
    return ElementTree.fromstring(drawing(model, gates, rotation=rotation, wheel_angle_rad=wheel_angle_rad))


def _dots(root):
    return [(float(c.get("cx")), float(c.get("cy"))) for c in root.iter(f"{SVG}circle")]


def _labels(root):
    return {"".join(t.itertext()): (float(t.get("x")), float(t.get("y"))) for t in root.iter(f"{SVG}text")}


def test_every_symbol_of_the_definitions_is_there(rotation):
    """Oracle: the list of symbols of figure 4(a)."""
    labels = _labels(_drawn(rotation))
    for symbol in ("α0", "α1", "α2", "α3", "β1", "β2", "γ", "φM", "θ", "d", "h", "Δh", "h − Δh", "rotation",
                   "application beam", "control beam"):  # fmt: skip
        assert symbol in labels, symbol


def test_the_beams_lie_where_the_caliper_puts_them(rotation):
    """Oracle: application beam at (-d, h), control beam at (d, h - dh) from the axle, to scale; mirrored the other way."""
    application, control, axle = _dots(_drawn(rotation))
    side = SIDE[rotation]
    left, right = application[0] - axle[0], control[0] - axle[0]
    assert left * side < 0
    assert left == pytest.approx(-right, abs=0.02)
    low, high = application[1] - axle[1], control[1] - axle[1]
    assert (low - high) / abs(left) == pytest.approx(5.5 / 13, abs=1e-3)
    assert low / abs(left) == pytest.approx(GATES.height_m / 13e-3, abs=1e-3)


def test_beams_to_one_side_lie_there(rotation):
    """Oracle: application beam at (-(d - x), h), control beam at (d + x, h - dh), x = 1 mm to scale; the key has d and dh."""
    beside = LightGates(
        half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9,
        lateral_offset_m=Measured(1e-3),
    )  # fmt: skip
    root = _drawn(rotation, gates=gate_angles(0.5697, beside))
    application, control, axle = _dots(root)
    left, right = abs(application[0] - axle[0]), abs(control[0] - axle[0])
    assert right / left == pytest.approx(14 / 12, abs=1e-3)
    assert (application[1] - control[1]) / left == pytest.approx(5.5 / 12, abs=1e-3)
    assert {"13.00 mm", "5.50 mm"} <= set(_labels(root))


@pytest.mark.parametrize("wheel_angle_rad", [0.0, 0.8, 4.0])
def test_edges_stand_at_their_polar_angles(rotation, wheel_angle_rad):
    """Oracle: conventions: edge i at phi_A + theta - alpha_i, clockwise from 3 o'clock, seen at its thick line's end."""
    root = _drawn(rotation, wheel_angle_rad)
    x0, y0 = _dots(root)[-1]
    lines = [p.get("d") for p in root.iter(f"{SVG}path") if p.get("stroke-width") == "2.4"]
    assert len(lines) == 4
    for line, alpha in zip(lines, EDGES, strict=True):
        x, y = (float(n) for n in re.findall(r"[-\d.]+", line)[2:])
        polar = atan2(y - y0, SIDE[rotation] * (x - x0))
        expected = radians(90) + GATES.application_rad + wheel_angle_rad - alpha
        assert degrees(polar - expected) % 360 == pytest.approx(0, abs=0.05) or degrees(polar - expected) % 360 > 359.95


def test_nothing_is_cut_off(rotation):
    """Oracle: labels and dots lie inside the picture with room for a letter, at any wheel angle."""
    for wheel_angle_rad in (0.0, 0.8, 2.0, 3.3, 5.5):
        root = _drawn(rotation, wheel_angle_rad)
        _, _, width, height = (float(n) for n in root.get("viewBox").split())
        for x, y in [*_labels(root).values(), *_dots(root)]:
            assert 12 <= x <= width - 12
            assert 12 <= y <= height - 4


def test_the_drawing_is_self_contained(rotation):
    """Oracle: no address but the namespace; a title for those who do not see it."""
    model = wheel_model(EDGES, GATES.application_rad, opening_angle_rad=1.3, centre_angle_rad=-1.5, rotation=rotation)
    text = drawing(model, GATES, rotation=rotation)
    assert text.count("http") == 1
    assert "<title>Chopper wheel" in text
    assert hypot(*_dots(ElementTree.fromstring(text))[0]) > 0

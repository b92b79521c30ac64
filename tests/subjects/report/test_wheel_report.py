"""The wheel in tables, result and picture: what is separable and what is not."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration
from irtiming.report import certificate, result_of_wheel
from irtiming.report.sections import wheel as section

PLACE = 2 * np.pi * np.arange(100) / 100


def _calibration(*, ripple: bool) -> WheelCalibration:
    """Eccentricity of 400 urad, order 7 of 50 urad; u of each slot 10 urad; ripple of 30 urad in order 1."""
    variance = np.concatenate([[0.0], np.full(50, 1e-10)])
    slots = 4e-4 * np.cos(PLACE + 0.5) + 5e-5 * np.cos(7 * PLACE)
    chance = np.ones(51)
    chance[1] = 1e-20
    found = SpeedRipple(
        reference_speed_hz=3.0, deviation_rad=3e-5 * np.cos(PLACE), order_variance_rad2=variance, order_chance=chance, chance=1e-9
    )  # fmt: skip
    speeds = [
        SlotsAtSpeed(rotation_speed_hz=hz, n_turns=100, deviation_rad=slots, order_variance_rad2=variance)
        for hz in ((3.0, 6.0) if ripple else (3.0,))
    ]
    return WheelCalibration(
        slot_deviation_rad=slots, order_variance_rad2=variance, ripple=found if ripple else None, speeds=tuple(speeds),
        gate_separation_rad=0.57, u_gate_separation_rad=4e-5, application_edges_rad=(0.0, 1.571, 3.142, 4.713),
        u_application_edges_rad=(0.0, 2e-6, 2e-6, 2e-6), names=("a", "b"), sha256=("1", "2"),
    )  # fmt: skip


def test_angles_have_two_digits_of_their_uncertainties():
    """Oracle: by hand; 0.57 rad with u of 40 urad, edges with 2 urad, and edge 0 by definition."""
    rows = {row[0]: row[1:] for row in section.summary(_calibration(ripple=True)).rows}
    assert rows["gate separation Δβ"] == ("570.000 mrad", "± 0.040 mrad")
    assert rows["application edge α₁"] == ("1571.0000 mrad", "± 0.0020 mrad")
    assert rows["application edge α₀"] == ("0.0000 mrad", "by definition")


def test_orders_are_told_with_their_ripple():
    """Oracle: by hand; amplitudes of 400 and 50 urad, u of an amplitude 10 urad times the root of 2/100."""
    rows = {row[0]: row[1:] for row in section.orders(_calibration(ripple=True)).rows}
    assert rows["1"] == ("400.0 ± 1.4", "29°", "30.0 ± 1.4")
    assert rows["7"][0] == "50.0 ± 1.4"
    assert rows["7"][2].endswith("(by itself may be chance)")


@pytest.mark.parametrize(
    ("chance", "stands_out", "verdict"),
    [
        (6e-4, True, "0.0006: there is a ripple, and orders that are not marked are part of it."),
        (6e-4, False, "0.0006: there is a ripple, although no order by itself stands out of the noise."),
        (0.3, True, "0.3: single orders stand out of the noise only."),
        (0.3, False, "0.3: no ripple is found."),
    ],
)
def test_a_p_value_is_no_probability_of_the_ripple(chance, stands_out, verdict):
    """Oracle: a p-value is how probable as much is where there is none; sentence and marks of the table say the same."""
    wheel = _calibration(ripple=True)
    each = wheel.ripple.order_chance if stands_out else np.ones(51)
    wheel = replace(wheel, ripple=replace(wheel.ripple, chance=chance, order_chance=each))
    said = f"Noise alone would make all orders together as large with a probability of {verdict}"
    assert section.orders(wheel).note.endswith(said)
    assert section.slots_caption(wheel).endswith(said)
    is_marked = [row[3].endswith("(by itself may be chance)") for row in section.orders(wheel).rows]
    assert all(is_marked) == (not stands_out)


def test_one_speed_separates_nothing():
    """Oracle: by hand; every order says so, the note says why, and the result too."""
    wheel = _calibration(ripple=False)
    assert {row[3] for row in section.orders(wheel).rows} == {"not separable"}
    assert "cannot be separated from the slots" in section.speeds(wheel).note
    assert section.speeds(_calibration(ripple=True)).note == ""
    found = result_of_wheel.calibration(wheel)
    assert found["ripple"] == "not separable at one speed"
    assert [entry["separable_from_ripple"] for entry in found["orders"]] == [False] * 50
    assert "no order can be separated from such a ripple" in section.slots_caption(wheel)


def test_result_holds_amplitudes_in_radians():
    """Oracle: the calibration itself."""
    found = result_of_wheel.calibration(_calibration(ripple=True))
    assert found["slots_from"] == ["a", "b"]
    assert found["orders"][0]["amplitude"] == pytest.approx(4e-4)
    assert found["orders"][6]["amplitude"] == pytest.approx(5e-5)
    assert found["standard_uncertainty"] == pytest.approx(1e-5 * np.sqrt(0.99))
    assert found["ripple"]["amplitude_by_order"][0] == pytest.approx(3e-5)
    assert found["application_edges"]["value"] == [0.0, 1.571, 3.142, 4.713]
    assert result_of_wheel.calibration(None) is None


@pytest.mark.parametrize("ripple", [True, False])
def test_picture_shows_slots_with_bars_and_orders(ripple):
    """Oracle: the axes themselves: deviation in mrad and us, amplitude by order, the ripple only where it is told."""
    drawn = section.calibration(_calibration(ripple=ripple))
    slots, orders, times = drawn.axes
    assert (slots.get_ylabel(), times.get_ylabel()) == ("deviation (mrad)", "at 3 Hz (µs)")
    assert (orders.get_xlabel(), orders.get_ylabel()) == ("order: waves to a turn (1)", "amplitude (mrad)")
    points = orders.lines[0]
    np.testing.assert_allclose(points.get_ydata()[[0, 6]], [0.4, 0.05])
    labels = [text.get_text() for text in orders.get_legend().get_texts()]
    assert ("ripple" in labels) is ripple
    low, high = slots.get_ylim()
    assert times.get_ylim() == pytest.approx((1e3 * low / (6 * np.pi), 1e3 * high / (6 * np.pi)))


@pytest.mark.usefixtures("sketched")
def test_certificate_tells_of_the_wheel(analysis):
    """Oracle: the page and the result of an analysis with a calibrated wheel, and of one without."""
    found = certificate.report(replace(analysis, wheel=_calibration(ripple=True)))
    assert "Deviations by order" in found.page
    assert "separated from the slots by its fall with the square of the speed" in found.page
    assert found.result["wheel"]["gate_separation"]["value"] == 0.57
    without = certificate.report(analysis)
    assert "Deviations by order" not in without.page
    assert without.result["wheel"] is None

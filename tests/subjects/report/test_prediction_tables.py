"""Prediction beside outcome, from numbers made by hand."""

from dataclasses import replace

import pytest

from irtiming.records.prediction import PredictedPart, PredictedRelativeDelay, PredictedUncertainty, Prediction
from irtiming.report import result
from irtiming.report.sections import uncertainty


@pytest.fixture
def foretold(analysis):
    """The analysis with u = 30 us and 0.27 us; predicted are 20 us, all of it phi_M, and 0.27 us for one set delay."""
    part = PredictedPart(source="mask centre angle phi_M", standard_uncertainty_s=20e-6)
    return replace(
        analysis,
        prediction=Prediction(
            noise_to_contrast=0.004,
            opening_pixels=1200.0,
            uncertainties=(
                PredictedUncertainty(name="trigger_delay", standard_uncertainty_s=20e-6, parts=(part,)),
                PredictedUncertainty(name="integration_time", standard_uncertainty_s=1e-6, parts=(part,)),
            ),
            relative_delays=(
                PredictedRelativeDelay(nominal_s=0.05, rotation_speed_hz=3.0, standard_uncertainty_s=0.3e-6),
            ),
        ),
    )


def test_the_table_divides_what_is_stated_by_what_was_predicted(foretold):
    """Oracle: 30 us over 20 us; a run's 0.3 us over the root of 2 runs, and as much again of the reference, over 0.3 us."""
    table = uncertainty.compared(foretold)
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["trigger_delay"] == ("20 µs", "30 µs", "1.50", "mask centre angle phi_M")
    assert rows["integration_time"][1:3] == ("–", "–")
    assert rows["relative delay of 50 ms"][2] == "1.00"


def test_the_result_holds_the_same_numbers(foretold):
    """Oracle: the table."""
    found = result.result(foretold)["prediction"]
    assert found["camera"] == {
        "camera": "photon", "readout_mode": "snapshot", "noise_to_contrast": 0.004, "opening_pixels": 1200.0,
        "integration_time": 250e-6, "unit": "s",
    }  # fmt: skip
    assert found["parameters"]["trigger_delay"]["ratio"] == pytest.approx(1.5)
    assert found["parameters"]["integration_time"]["ratio"] is None
    assert found["relative_delays"][0]["predicted_standard_uncertainty"] == 0.3e-6


def test_nothing_is_shown_where_nothing_was_predicted(analysis):
    """Oracle: the analysis without a prediction."""
    assert "Prediction and outcome" not in [block.title for block in uncertainty.section(analysis).blocks]
    assert result.result(analysis)["prediction"] is None

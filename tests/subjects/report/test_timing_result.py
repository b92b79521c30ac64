"""The result as Python code has it: values, expanded uncertainties, correlations that other libraries keep."""

from dataclasses import replace
from pathlib import Path

import GTC
import numpy as np
import pytest
from matplotlib.figure import Figure

import irtiming
from irtiming.archive.result_file import checked_result
from irtiming.errors import EstimationError, UnitError
from irtiming.interface.timing_result import TimingResult
from irtiming.records.analysis import Analysis
from irtiming.report.result import result


@pytest.fixture(scope="module")
def found(analysis: Analysis) -> TimingResult:
    """Trigger delay 400 us with u 30 us, the middle of integration 125 us later with the same error."""
    return TimingResult(checked_result(result(analysis)), analysis=analysis)


def test_values_and_expanded_uncertainties(found: TimingResult) -> None:
    """Oracle: the hand-made numbers; k = 1.960 and 2.576 of the normal distribution for 95 % and 99 %."""
    delay = replace(found["trigger_delay"], degrees_of_freedom=float("inf"))
    assert (delay.value, delay.unit) == (400e-6, "s")
    assert delay.u == pytest.approx(30e-6)
    assert delay.expanded(0.95) == pytest.approx(1.959964 * 30e-6, rel=1e-5)
    assert delay.expanded(0.99) == pytest.approx(2.575829 * 30e-6, rel=1e-5)
    assert replace(delay, degrees_of_freedom=4.0).coverage_factor(0.95) == pytest.approx(2.776445, rel=1e-5)
    assert str(delay) == "400 ± 30 µs"
    with pytest.raises(UnitError, match="probability is 95"):
        delay.expanded(95)
    with pytest.raises(KeyError, match="'tau' is not among trigger_delay"):
        _ = found["tau"]


def test_correlations_are_kept(found: TimingResult) -> None:
    """Oracle: the fixture's covariance, common to both delays, so that u of their difference is 0 by hand."""
    names = found.correlated_names
    assert names[:2] == ("trigger_delay", "exposure_midpoint_delay")
    assert found.covariance[:2, :2] == pytest.approx(np.full((2, 2), 30e-6**2))
    numbers = found.to_gtc()
    both = [numbers[name] for name in names[:2]]
    assert GTC.uncertainty(both[0] + both[1]) == pytest.approx(60e-6)
    assert GTC.uncertainty(both[1] - both[0]) == pytest.approx(0, abs=1e-12)
    halves = numbers["trigger_delay_falling"] - numbers["trigger_delay_rising"]
    assert GTC.uncertainty(halves) == pytest.approx(5e-6)  # 4 and 3 us of their own


def test_uncertainties_and_pandas_have_the_same_numbers(found: TimingResult) -> None:
    """Oracle: the libraries' own sums of the hand-made numbers."""
    pytest.importorskip("uncertainties")
    frame = pytest.importorskip("pandas") and found.to_pandas()
    numbers = found.to_uncertainties()
    assert (numbers["trigger_delay_falling"] - numbers["trigger_delay_rising"]).std_dev == pytest.approx(5e-6)
    assert frame.loc["trigger_delay", "u"] == pytest.approx(30e-6)
    assert list(frame.index) == list(found)


def test_a_result_draws_and_shows_itself(found: TimingResult) -> None:
    """Oracle: the two sources of the fixture; names that are markup elsewhere are text in the table."""
    axes = found.plot("trigger_delay")
    assert isinstance(axes.figure, Figure)
    assert [text.get_text() for text in axes.get_yticklabels()] == ["noise of the frames", "mask centre angle phi_M"]
    own = Figure().add_subplot()
    assert found.plot(axes=own) is own
    shown = found._repr_html_()
    assert "<td>400 ± 30 µs</td>" in shown
    assert "&lt;b&gt;not markup&lt;/b&gt;" in shown
    assert repr(found).startswith("<TimingResult of a photon camera: trigger_delay 400 ± 30 µs")
    assert "made-by-hand" in {finding.code for finding in found.findings}


def test_a_result_is_written_and_read_back(found: TimingResult, tmp_path: Path) -> None:
    """Oracle: what was written; a file holds no curves, so that no report can be made of it."""
    found.write(tmp_path / "result.json")
    again = irtiming.read_result(tmp_path / "result.json")
    assert dict(again) == dict(found)
    assert again.content == found.content
    assert [one.value for one in again.relative_delays][:3] == [one.value for one in found.relative_delays][:3]
    with pytest.raises(EstimationError, match="no curves for a report"):
        again.write_report(tmp_path / "report.html")

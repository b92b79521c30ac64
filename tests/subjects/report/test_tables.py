"""Tables of the report."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.choices import Choices
from irtiming.records.estimate import Estimate
from irtiming.report.blocks import Table
from irtiming.report.combination import PAPER_TABLE_1, combined
from irtiming.report.sections import inputs, joint_fit, parameters, relative_delays, uncertainty
from irtiming.report.verdict import verdict


def test_each_delay_stands_with_its_event_and_expanded_uncertainty(analysis):
    """Oracle: the hand-made analysis: 400 us, u 30 us, so U = 60 us; sign and method said in the note."""
    table = parameters.parameters(analysis)
    assert table.rows[0] == ("trigger_delay", "400 ± 30 µs", "60 µs", "2.00", "start of integration")
    assert table.rows[1][4] == "middle of integration"
    assert "positive: after the trigger edge" in table.note
    assert "pixel sums" in table.note


def test_the_split_of_falling_and_rising_uses_their_covariance(analysis):
    """Oracle: the common 30 us cancel; 4 and 3 us remain and add to 5 us."""
    assert parameters.parameters(analysis).rows[-1][:3] == ("falling − rising", "2.0 ± 5.0 µs", "10 µs")


def test_several_speeds_tell_a_time_from_an_angle(analysis):
    """Oracle: by hand; 3 us beside 1.4 mrad, and one speed says that it cannot tell."""
    split = Estimate(
        names=("falling_rising_time", "falling_rising_angle"), units=("s", "rad"), values=np.array([3e-6, 1.4e-3]),
        covariance=np.diag([0.5e-6, 2e-5]) ** 2,
    )  # fmt: skip
    best = replace(analysis.best, falling_rising=split)
    rows = parameters.parameters(replace(analysis, best=best)).rows
    assert [row[1] for row in rows[-2:]] == ["3.00 ± 0.50 µs", "1400 ± 20 µrad"]
    assert rows[-3][4] == "0 expected"
    assert "one wheel speed" in parameters.parameters(analysis).rows[-1][4]


def test_table_1_stands_beside_the_papers_numbers(analysis):
    """Oracle: Table 1 as printed; ours by hand: noise 0.3 us a run, two against two: sqrt(0.3^2 / 2 + 0.3^2 / 2)."""
    table = relative_delays.combined_delays(analysis)
    assert table.rows[0] == ("25", "2", "25.00100", "0.30", "+1.00", "0.14", "24.998", "1.123", "−1.745")
    assert table.rows[2][6:] == ("75.003", "1.083", "3.000")
    assert [row[0] for row in table.rows] == ["25", "50", "75", "100"]


def test_a_nominal_delay_of_the_paper_that_was_not_measured_has_dashes(analysis):
    """Oracle: only the paper's own cells are filled."""
    part = replace(
        analysis,
        recordings=analysis.recordings[:4],
        fits=analysis.fits[:4],
        best=replace(analysis.best, relative_delays=analysis.best.relative_delays[:4]),
    )
    row = relative_delays.combined_delays(part).rows[1]
    assert row == ("50", "–", "–", "–", "–", "–", "49.999", "1.277", "−0.652")


def test_noise_averages_over_runs_and_a_common_angle_error_does_not(analysis):
    """Oracle: with a common 4 us beside the noise, u of the mean of two is sqrt(4^2 + 0.3^2), by hand."""
    run = np.sqrt(1.5 * 0.3e-6**2 + 4e-6**2)
    delays = tuple(
        replace(delay, standard_uncertainty_s=float(run) if delay.nominal_s else 0.0)
        for delay in analysis.best.relative_delays
    )
    row = combined(analysis, replace(analysis.best, relative_delays=delays))[0]
    assert row.standard_uncertainty_s == pytest.approx(np.hypot(4e-6, 0.3e-6))
    assert row.scatter_s == pytest.approx(0.2e-6 / np.sqrt(2))


def test_a_single_run_keeps_its_uncertainty(analysis):
    """Oracle: nothing to average; also where the fit's noise is larger than what the relative delay states."""
    indices = [0, 2]
    for u in (0.2e-6, 0.5e-6, 5e-6):
        delays = tuple(
            replace(analysis.best.relative_delays[k], standard_uncertainty_s=u if k else 0.0) for k in indices
        )
        part = replace(
            analysis,
            recordings=tuple(analysis.recordings[k] for k in indices),
            fits=tuple(analysis.fits[k] for k in indices),
        )
        row = combined(part, replace(analysis.best, relative_delays=delays))[0]
        assert row.standard_uncertainty_s == pytest.approx(u)
        assert row.scatter_s is None


def test_published_values_are_already_means_over_runs(analysis):
    """Oracle: the stated 1 us stays, however many runs share it."""
    row = combined(analysis, analysis.published.result)[0]
    assert (row.n_runs, row.standard_uncertainty_s) == (2, 1e-6)


def test_the_papers_deviations_are_its_measured_minus_nominal():
    """Oracle: Table 1 itself: the two columns agree to the last printed digit, 1 us."""
    for nominal, measured, _, deviation in PAPER_TABLE_1:
        assert measured - nominal == pytest.approx(deviation, abs=1e-6)


def test_the_budget_adds_in_quadrature(analysis):
    """Oracle: 24 and 18 us make 30 us; shares 64 and 36 %; Welch and Satterthwaite: 30^4 / (18^4 / 400)."""
    rows = uncertainty.budget(analysis).rows
    assert rows[0][1:4] == ("B", "∞", "24 (64%)")
    assert rows[1][1:4] == ("A", "400", "18 (36%)")
    assert pytest.approx(3086, abs=1) == 30**4 / (18**4 / 400)  # beyond 1000 the number says nothing
    assert (rows[2][3], rows[3][3]) == ("30", "> 1000")


def test_the_budget_shows_what_was_measured_and_its_sensitivity(analysis):
    """Oracle: by hand; 24 us of the mask's angle from 0.5 mrad are 48 us/mrad; noise has no such number."""
    best = analysis.best
    mask, *others = sorted(best.budget, key=lambda part: -part.standard_uncertainty["trigger_delay"])
    told = replace(best, budget=(replace(mask, measured=(5e-4, "rad")), *others))
    rows = uncertainty.budget(replace(analysis, best=told)).rows
    assert rows[0][4:] == ("0.50 mrad", "48 µs/mrad")
    assert rows[1][4:] == ("–", "–")


@pytest.mark.parametrize(
    ("u", "shown"), [(0.023, ("2.3 %", "10 µs/%")), (0.001, ("0.10 %", "240 µs/%")), (2e-6, ("2.0 ppm", "12 µs/ppm"))]
)
def test_a_share_is_stated_in_per_cent_and_a_rate_in_ppm(analysis, u, shown):
    """Oracle: by hand; 24 us over the uncertainty, a share of 2.3 % being no 23000 ppm."""
    best = analysis.best
    largest, *others = sorted(best.budget, key=lambda part: -part.standard_uncertainty["trigger_delay"])
    told = replace(best, budget=(replace(largest, measured=(u, "1")), *others))
    row = uncertainty.budget(replace(analysis, best=told)).rows[0]
    assert tuple(text.replace("\u202f", " ").replace("\xa0", " ") for text in row[4:]) == shown


def test_what_no_uncertainty_holds_is_said_beside_the_number(analysis):
    """Oracle: the rule: without [latency] no absolute delay without that word."""
    plain = verdict(analysis)
    told = verdict(replace(analysis, best=replace(analysis.best, not_in_uncertainty=("latency of the trigger path",))))
    assert (plain.outside, told.number) == ("", plain.number)
    assert told.outside == "not in u: latency of the trigger path"
    assert told.sentence == f"{plain.sentence} Not in this uncertainty: latency of the trigger path."


def test_choices_say_who_made_them(analysis):
    """Oracle: a person took the region, the rest is automatic."""
    mine = replace(analysis, choices=Choices(roi=(2, 40, 5, 75)))
    made = {row[0]: row for row in inputs.choices(mine).rows}
    assert made["region of interest"] == ("region of interest", "rows 2–39, columns 5–74", "by you")
    assert made["threshold"][2] == "automatic"
    assert joint_fit.searches(mine).rows[0][:2] == ("pixel sums, camera-0ms-r0", "0 µs → 400 µs")


def test_inputs_carry_whole_checksums(analysis):
    """Oracle: SHA-256 has 64 hexadecimal digits; one line per recording and one for rig.toml."""
    rows = inputs.inputs(analysis).rows
    assert len(rows) == 11
    assert all(len(row[-1]) == 64 for row in rows)
    assert rows[-1][0] == "rig.toml"


def test_software_names_this_package():
    """Oracle: the installed metadata."""
    assert "irtiming" in inputs.versions()


def test_a_table_with_a_short_row_is_refused():
    """Oracle: every row needs a cell per column."""
    with pytest.raises(ValueError, match="as many as its head"):
        Table(title="t", columns=("a", "b"), align="ll", rows=(("1",),))

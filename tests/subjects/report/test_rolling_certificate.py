"""The page, the result and the tables of a rolling microbolometer camera."""

import json
from dataclasses import replace

import balanced_tags
import numpy as np
import pytest

from irtiming.records.choices import Choices
from irtiming.records.estimate import Estimate
from irtiming.records.result import Bound
from irtiming.report import certificate
from irtiming.report import result as result_of
from irtiming.report.sections import joint_fit, lag, level, own_fits, parameters, relative_delays, uncertainty
from irtiming.report.verdict import verdict as verdict_of


@pytest.fixture(scope="module")
def page(rolling):
    return certificate.page(rolling)


@pytest.fixture(scope="module")
def upward(rolling):
    """The same camera, read from the bottom up: 40 us per row less, the first row last, 59 rows on."""
    flipped = replace(rolling.best.estimate, values=rolling.best.estimate.values * [1, 1, -1])
    return replace(rolling, best=replace(rolling.best, estimate=flipped))


@pytest.fixture(scope="module")
def undetermined(rolling):
    """Only the row delay is a number."""
    row = Estimate(
        names=("row_delay",),
        units=("s",),
        values=np.array([40e-6]),
        covariance=np.array([[0.04e-12]]),
    )
    bounds = (
        Bound(name="time_constant", lower=0.0, upper=3e-3),
        Bound(name="trigger_delay", lower=None, upper=5e-3),
    )
    return replace(rolling, best=replace(rolling.best, estimate=row, bounds=bounds))


def test_the_page_is_well_formed_and_needs_nothing_from_outside(page):
    """Oracle: every tag that opens is closed; but for the names of SVG's own namespaces no address is in it."""
    assert balanced_tags.out_of_balance(page) == ([], [])
    bare = page.replace('="http://www.w3.org/2000/svg"', "").replace('="http://www.w3.org/1999/xlink"', "")
    for word in ("http://", "https://", "<script", "@import", "url(http", "<link", 'src="'):
        assert word not in bare, word
    assert "<i>no markup</i>" not in page


def test_three_numbers_and_warnings_come_before_every_table(page):
    """Oracle: order on the page; the hand-made numbers rounded by hand."""
    places = [
        page.index(text)
        for text in (
            "trigger delay = 4.000 ± 0.030 ms</p>", "time constant = 5.0000 ± 0.0040 ms</p>",
            "row delay = 40.00 ± 0.20 µs</p>", "2 warnings", "<table",
        )
    ]  # fmt: skip
    assert places == sorted(places)


def test_the_verdict_says_event_sign_method_and_what_limits_each(rolling):
    """Oracle: the sentences by hand; last of 60 rows at 4 ms + 59 x 40 us, its u from 30 us and 59 x 0.2 us."""
    verdict = verdict_of(rolling)
    assert verdict.sentence == (
        "Image row 0 is read 4.000 ± 0.030 ms after the trigger edge that the camera accepts, each row below it later by 40.00 ± "
        "0.20 µs; a pixel needs 5.0000 ± 0.0040 ms for 63 % of its response to a step of the scene, by row sums from 2 "
        "recordings (standard uncertainties, k = 1)."
    )
    assert verdict.remarks[:4] == (
        "Trigger delay: U = 60 µs (k = 2.00); the largest part of u is mask centre angle phi_M, 24 µs (type B).",
        "Time constant: U = 8.0 µs (k = 2.00); the largest part of u is noise of the frames, 4.0 µs (type A).",
        "Row delay: U = 0.40 µs (k = 2.00); the largest part of u is noise of the frames, 0.20 µs (type A).",
        "The last row (y = 59) is read 6.360 ± 0.032 ms after the trigger edge; the whole readout takes 2.360 ms.",
    )


def test_a_readout_from_the_bottom_up_is_said_to_be_one(upward):
    """Oracle: row 59 is read at 4 ms - 2.36 ms, before row 0."""
    verdict = verdict_of(upward)
    assert "each row below it earlier by 40.00 ± 0.20 µs" in verdict.sentence
    assert verdict.remarks[3].startswith("Rows are read from the bottom up: row 59 first, 1.640 ± 0.032 ms after the")
    assert verdict.further[1] == "row delay = −40.00 ± 0.20 µs"


@pytest.mark.usefixtures("sketched")
def test_an_undetermined_parameter_is_a_bound_and_no_number(undetermined):
    """Oracle: the bounds put in; absent from the parameters of the result, and the page is still made."""
    verdict = verdict_of(undetermined)
    assert verdict.number == "trigger delay: below 5 ms"
    assert verdict.further == ("time constant: 0 µs … 3 ms", "row delay = 40.00 ± 0.20 µs")
    found = certificate.report(undetermined)
    assert list(found.result["parameters"]) == ["row_delay"]
    assert found.result["bounds"]["trigger_delay"] == {"lower": None, "upper": 5e-3, "unit": "s"}
    assert found.result["bounds"]["time_constant"] == {"lower": 0.0, "upper": 3e-3, "unit": "s"}
    assert found.result["last_row_read"] is None
    assert "time constant is not determined" in found.page


def test_the_result_has_the_form_that_others_read(rolling):
    """Oracle: recording-format.md, "The result"."""
    result = json.loads(json.dumps(result_of.result(rolling), allow_nan=False))
    assert (result["method"], result["camera"]) == ("row-sum", "microbolometer")
    assert result["warnings"] == [one.sentence() for one in rolling.findings]
    parameters = result["parameters"]
    assert list(parameters) == result["correlation"]["names"] == ["trigger_delay", "time_constant", "row_delay"]
    assert parameters["trigger_delay"]["value"] == pytest.approx(4e-3)
    assert parameters["time_constant"]["standard_uncertainty"] == pytest.approx(4e-6)
    assert {entry["unit"] for entry in parameters.values()} == {"s"}
    assert "image row 0" in parameters["trigger_delay"]["reference_event"]
    assert "after the trigger edge" in parameters["trigger_delay"]["sign"]
    assert "bottom up" in parameters["row_delay"]["sign"]
    assert "63 %" in parameters["time_constant"]["reference_event"]
    assert np.allclose(np.diag(result["correlation"]["matrix"]), 1)
    assert [set(entry) for entry in result["relative_delays"]] == [
        {
            "file",
            "nominal",
            "value",
            "standard_uncertainty",
            "deviation",
            "deviation_standard_uncertainty",
            "unit",
            "reference_event",
            "sign",
        }
    ] * 2
    assert result["relative_delays"][1]["file"] == "runs/bolo-10ms.nxs"
    assert result["bounds"] == {}
    assert result["edge_delays"]["value"][0] == pytest.approx(4.001e-3)
    assert result["other_method"]["edge_delays"] is None
    assert result["last_row_read"]["value"] == pytest.approx(6.36e-3)
    assert all(len(entry["sha256"]) == 64 for entry in result["inputs"])


def test_noise_correlates_delay_and_lag_and_tells_their_difference(rolling):
    """Oracle: by hand, per recording: variances 24 + 4 / 4 and 24 + 1, both 25 us^2, common 24; two recordings halve them."""
    noise = result_of.result(rolling)["noise_correlation"]
    assert noise["matrix"][0][1] == pytest.approx(24 / 25)
    assert noise["standard_uncertainty"][0] == pytest.approx(5e-6 / np.sqrt(2))
    difference = noise["trigger_delay_minus_time_constant"]["standard_uncertainty"]
    assert difference == pytest.approx(np.sqrt((25 + 25 - 48) / 2) * 1e-6)
    total = noise["trigger_delay_plus_time_constant"]["standard_uncertainty"]
    assert total == pytest.approx(np.sqrt((25 + 25 + 48) / 2) * 1e-6)
    assert "So their difference is known to 1.0 µs" in lag.noise_sentence(rolling)


def test_the_result_follows_the_chosen_method(rolling):
    """Oracle: the other method stands beside it; a budget of one part has no largest."""
    chosen = replace(rolling, choices=Choices(method="published"))
    result = result_of.result(chosen)
    assert (result["method"], result["other_method"]["method"]) == ("published", "row-sum")
    assert result["parameters"]["time_constant"]["value"] == pytest.approx(5.1e-3)
    assert "a single part of uncertainty is known" in verdict_of(chosen).remarks[0]


def test_both_methods_stand_side_by_side(rolling):
    """Oracle: the hand-made results: 100 us, 100 us and 1 us apart, rounded to their joint uncertainty."""
    rows = parameters.both_methods(rolling).rows
    assert rows[0] == ("trigger_delay", "4.000 ± 0.030 ms", "4.100 ± 0.040 ms", "+100 µs")
    assert rows[1][3] == "+100.0 µs"
    assert rows[2][3] == "+1.0 µs"


def test_the_budget_has_a_column_for_each_parameter(rolling):
    """Oracle: 24 and 18 us make 30 us, shares 64 and 36 %; the rig's angle does not touch the others; nothing is known by few."""
    rows = uncertainty.budget(rolling).rows
    assert rows[0] == ("mask centre angle phi_M", "B", "∞", "24 (64%)", "0", "0", "–", "–")
    assert rows[1] == ("noise of the frames", "A", "∞", "18 (36%)", "4.0 (100%)", "0.20 (100%)", "–", "–")
    assert rows[2][3:] == ("30", "4.0", "0.20", "", "")
    assert rows[3][3:] == ("∞", "∞", "∞", "", "")


@pytest.mark.usefixtures("sketched")
def test_a_single_set_delay_has_no_table_of_relative_delays(rolling):
    """Oracle: nothing to compare."""
    one = replace(
        rolling,
        recordings=rolling.recordings[:1],
        fits=rolling.fits[:1],
        joint=replace(rolling.joint, whiteness=rolling.joint.whiteness[:1]),
        best=replace(rolling.best, relative_delays=rolling.best.relative_delays[:1], findings=()),
        published=None,
    )
    assert relative_delays.by_file(one).rows == ()
    page = certificate.page(one)
    assert "No warnings." in page
    assert "no relative delay to check" in page
    assert relative_delays.by_file(rolling).rows[1][:4] == ("bolo-10ms", "10", "+1.0", "2.0")


def test_fits_tell_where_they_began_and_how_well_they_ended(rolling):
    """Oracle: the hand-made fits: noise 1e-3, widened variance 2.25, start 3 ms, end 5 ms."""
    fit = own_fits.table(rolling).rows[1]
    assert fit[:3] == ("bolo-10ms", "380 of 400", "26 (7 … 32)")
    assert float(fit[4]) == pytest.approx(1.0, rel=0.05)
    assert fit[5] == "1.50"
    search = joint_fit.searches(rolling).rows
    assert search[0][2] == "3 ms → 5 ms"
    assert search[2][4] == "4 evaluations"  # one likelihood
    assert search[3][4] == "92 simulations"


def test_the_likelihood_of_all_recordings_is_told(rolling, page):
    """Oracle: the fixture; parabolas reach 1 at one standard uncertainty, and each profile says what it is counted from."""
    found = result_of.result(rolling)["likelihood"]
    assert found["steps"] == 4
    assert found["profiles"]["time_constant"]["lower"] == pytest.approx(5e-3 - 4e-6, rel=1e-6)
    assert "row" in found["profiles"]["row_delay"]["reference_event"]
    assert [one["probability"] for one in found["whiteness"]] == [0.4, 0.02]
    assert "Profile likelihoods" in page
    assert "Are the residuals white?" in page


def test_shutter_events_are_told_with_their_time(rolling):
    """Oracle: frames 100 to 119 at 30.303 Hz: 3.3 s after the first, for 0.66 s."""
    assert level.shutter_events(rolling).rows[0] == (
        "bolo-0ms", "shutter closed", "100 … 119", "3.30", "0.66",
    )  # fmt: skip


def test_the_truth_of_a_simulation_stands_beside_both_methods(rolling):
    """Oracle: by hand: true delay 4.06 ms is 2 u of 30 us above the estimate, and 1 u of 40 us below the published one."""
    truth = {"trigger_delay": 4.06e-3, "time_constant": 5e-3, "row_delay": 40e-6}
    row = parameters.beside_the_truth(rolling, truth).rows[0]
    assert row == ("t_delay", "4.06 ms", "4.000 ± 0.030 ms", "−2.0", "4.100 ± 0.040 ms", "+1.0")


@pytest.mark.usefixtures("sketched")
def test_the_page_stands_without_the_published_procedure(rolling):
    """Oracle: the row sums do not need it; its numbers are dashes and the reason is told."""
    alone = replace(
        rolling,
        published=replace(
            rolling.published,
            fits=(),
            result=replace(
                rolling.published.result,
                estimate=Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0))),
                relative_delays=(),
                budget=(),
            ),
        ),
    )
    found = certificate.report(alone)
    assert found.result["parameters"] == certificate.report(rolling).result["parameters"]
    assert found.result["other_method"]["parameters"] == {}
    assert found.result["published_fits"] == []
    assert "The published procedure could not be run." in found.page

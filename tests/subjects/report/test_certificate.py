"""The page and the result."""

import json
import math
import re
from dataclasses import replace
from datetime import UTC, datetime

import balanced_tags
import numpy as np
import pytest

from irtiming.records.choices import Choices
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.report import certificate
from irtiming.report import result as result_of
from irtiming.report.language import writing_in
from irtiming.report.verdict import verdict as verdict_of


@pytest.fixture(scope="module")
def page(analysis):
    return certificate.page(analysis, created=datetime(2026, 1, 2, 3, 4, tzinfo=UTC))


def test_the_page_is_well_formed(page):
    """Oracle: every tag that opens is closed, in order."""
    assert balanced_tags.out_of_balance(page) == ([], [])


def test_the_page_needs_nothing_from_outside(page):
    """Oracle: but for the names of SVG's own namespaces there is no address, script or import in it."""
    for known in ('="http://www.w3.org/2000/svg"', '="http://www.w3.org/1999/xlink"'):
        page = page.replace(known, "")
    for word in ("http://", "https://", "<script", "@import", "url(http", "<link", 'src="'):
        assert word not in page, word


def test_verdict_and_warnings_come_before_every_table(page):
    """Oracle: order on the page."""
    verdict, warnings, table = (
        page.index("trigger delay = 400 ± 30 µs</p>"),
        page.index("2 warnings"),
        page.index("<table"),
    )
    assert verdict < warnings < table
    assert page.index("3 frames lost") < table


_DOUBT = Finding(code="edges-disagree", severity="doubt", what="the edges disagree", cure="look at the wheel")


@pytest.mark.parametrize(
    ("written_in", "heading", "under", "after"),
    [
        (
            "en",
            "1 doubt: a number may be wrong by more than its",
            "in doubt: may be wrong by more than its",
            "1 doubt, see below.",
        ),
        (
            "de",
            "1 Zweifel: eine Zahl kann um mehr falsch sein",
            "zweifelhaft: kann um mehr",
            "1 Zweifel, siehe unten.",
        ),
    ],
)
def test_a_doubt_is_told_from_a_warning(analysis, page, written_in, heading, under, after):
    """Oracle: by hand; it stands first, is counted apart, and the number in large type and the headline are qualified by it."""
    doubted = replace(analysis, best=replace(analysis.best, findings=(*analysis.best.findings, _DOUBT)))
    report = certificate.report(doubted, written_in=written_in)
    warned = report.page.index("2 warnings" if written_in == "en" else "2 Warnungen")
    assert report.page.index(f'<small class="doubt">{under}') < report.page.index(f"<h2>{heading}") < warned
    assert report.page.index("the edges disagree") < warned
    with writing_in(written_in):
        assert verdict_of(doubted).sentence.endswith(after)
    assert report.result["headline"].endswith("1 doubt, see below.")
    assert report.result["warnings"][0].startswith("the edges disagree")
    assert '<small class="doubt">' not in page


def test_what_is_not_stated_is_counted_but_leaves_the_number_as_it_is(analysis):
    """Oracle: the rule; the line of what the uncertainty does not hold says it already."""
    unstated = replace(_DOUBT, code="latency-not-stated")
    found = verdict_of(replace(analysis, best=replace(analysis.best, findings=(*analysis.best.findings, unstated))))
    assert found.doubted == ""
    assert found.sentence.endswith("1 doubt, see below.")


def test_a_wide_table_scrolls_and_is_whole_on_paper(page):
    """Oracle: the page; each table stands in a region with its title that scrolls, also by keyboard, and is not cut in print."""
    regions = re.findall(r'<div class="scroll" tabindex="0" role="region" aria-label="([^"]*)">\s*<table>', page)
    titles = re.findall(r'<figcaption class="title">([^<]*)</figcaption>', page)
    assert len(titles) > 5
    assert regions == titles
    in_print = page[page.index("@media print") : page.index("</style>")]
    assert ".scroll { overflow: visible;" in in_print
    assert "td.r { white-space: normal; }" in in_print


def test_a_warning_cannot_smuggle_markup(page):
    """Oracle: HTML escapes."""
    assert "<b>not markup</b>" not in page
    assert "&lt;b&gt;not markup&lt;/b&gt; &amp; co" in page


def test_the_verdict_says_event_sign_method_and_k(analysis):
    """Oracle: the sentence by hand."""
    assert verdict_of(analysis).sentence == (
        "The start of integration comes 400 ± 30 µs after the trigger edge that the camera accepts (standard uncertainty, "
        "k = 1; expanded uncertainty U = 60 µs, k = 2.00), by pixel sums from 10 recordings."
    )


def test_a_negative_delay_comes_before_the_edge(analysis):
    """Oracle: the sign in words, once."""
    estimate = analysis.best.estimate
    early = Estimate(
        names=estimate.names,
        units=("s",) * len(estimate.names),
        values=-estimate.values,
        covariance=estimate.covariance,
    )
    verdict = verdict_of(replace(analysis, best=replace(analysis.best, estimate=early)))
    assert "comes 400 ± 30 µs before the trigger edge" in verdict.sentence
    assert verdict.number == "trigger delay = −400 ± 30 µs"


@pytest.mark.usefixtures("sketched")
def test_without_an_integration_time_the_verdict_tells_the_middle(analysis):
    """Oracle: the start cannot be told, and is not."""
    middle = Estimate(
        names=("exposure_midpoint_delay",),
        units=("s",),
        values=np.array([525e-6]),
        covariance=np.array([[30e-6**2]]),
    )
    part = replace(analysis, best=replace(analysis.best, estimate=middle))
    assert verdict_of(part).sentence.startswith("The middle of integration comes 525 ± 30 µs after")
    assert certificate.page(part)


def test_the_result_has_the_form_that_others_read(analysis):
    """Oracle: recording-format.md, "The result"."""
    result = json.loads(json.dumps(result_of.result(analysis), allow_nan=False))
    assert (result["method"], result["camera"]) == ("pixel-sum", "photon")
    assert result["warnings"] == [one.sentence() for one in analysis.findings]
    delay = result["parameters"]["trigger_delay"]
    assert math.isclose(delay["value"], 400e-6)
    assert math.isclose(delay["standard_uncertainty"], 30e-6)
    assert delay["unit"] == "s"
    assert delay["reference_event"] == "start of integration"
    assert "after the trigger edge" in delay["sign"]
    names, matrix = result["correlation"]["names"], result["correlation"]["matrix"]
    assert names == list(result["parameters"])
    assert np.shape(matrix) == (4, 4)
    assert np.allclose(np.diag(matrix), 1)
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
    ] * 10
    assert [entry["nominal"] for entry in result["relative_delays"][::2]] == [0, 0.025, 0.05, 0.075, 0.1]
    assert all(len(entry["sha256"]) == 64 for entry in result["inputs"])


def test_the_result_follows_the_chosen_method(analysis):
    """Oracle: the other method stands beside it."""
    result = result_of.result(replace(analysis, choices=Choices(method="published")))
    assert (result["method"], result["other_method"]["method"]) == ("published", "pixel-sum")


@pytest.mark.usefixtures("sketched")
def test_one_recording_alone_makes_a_page(analysis):
    """Oracle: no relative delay, and the verdict says so."""
    one = replace(
        analysis,
        recordings=analysis.recordings[:1],
        fits=analysis.fits[:1],
        joint=replace(analysis.joint, whiteness=analysis.joint.whiteness[:1]),
        best=replace(analysis.best, relative_delays=analysis.best.relative_delays[:1], findings=()),
        published=None,
    )
    page = certificate.page(one)
    assert "No warnings." in page
    assert "no relative delay to check" in page

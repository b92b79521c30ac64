"""The joint fit on the page and in the result."""

import json
from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.estimate import Estimate
from irtiming.report import certificate, result, result_of_fits
from irtiming.report.sections import joint_fit, own_fits


@pytest.fixture(scope="module")
def two_speeds(analysis):
    """The same, half of the recordings at 8 Hz."""
    fast = tuple(replace(one, rotation_speed_hz=8.0 if k % 2 else 3.0) for k, one in enumerate(analysis.recordings))
    return replace(analysis, recordings=fast)


def test_shared_numbers_stand_in_their_units(analysis):
    """Oracle: the hand-made fit: 0.4 mrad with u 0.1, prior 0.5 mrad; 75.01 degrees; 240 us."""
    rows = {row[0]: row[1:] for row in joint_fit.numbers(analysis).rows}
    assert len(rows) == 9
    assert rows["middle of the integration window after the trigger edge (µs)"] == ("465", "525", "30", "–", "–")
    assert rows["wheel edge 0: angle by which it comes earlier than rig.toml says (mrad)"] == (
        "0.00", "0.40", "0.10", "0.50", "0.80",
    )  # fmt: skip
    assert rows["opening angle of the mask (°)"][:3] == ("75.00000", "75.01000", "0.00057")
    assert rows["length of the integration window (µs)"][:3] == ("300", "240", "10")
    assert rows["mask edge at the higher wheel angle: angle by which it misses the axle, at the mean radius (mrad)"][:3] == (
        "−1.0", "−1.0", "2.0",
    )  # fmt: skip


def test_the_search_tells_how_far_it_went(analysis):
    """Oracle: 525 us - 465 us = 60 us are two of its 30 us; one of ten recordings is not white."""
    rows = {row[0]: row[1] for row in joint_fit.search(analysis).rows}
    assert rows["evaluations of the likelihood"] == "4"
    assert rows["distance of the delay from its start"] == "60.0 µs = 2.00 u"
    assert rows["reduced chi-square"] == "0.98"
    assert rows["Birge ratio of the recordings' delays"] == "1.23"
    assert rows["recordings below that"] == "1 of 10"


@pytest.mark.usefixtures("sketched")
def test_only_several_speeds_tell_of_rig_toml(analysis, two_speeds):
    """Oracle: at one speed an angle is a delay; the common angle by hand: 0.4 mrad, u 0.1, of 0.5 mrad allowed."""
    titles = [block.title for block in joint_fit.section(analysis).blocks]
    assert titles[:3] == ["What all recordings share", "How the fit went", "Fits, recording by recording"]
    assert "What the wheel speeds say of rig.toml" not in certificate.page(analysis)
    assert "What the wheel speeds say of rig.toml" in certificate.page(two_speeds)
    common, first, *_ = joint_fit.by_speeds(two_speeds).rows
    assert common[1:] == ("0.40 ± 0.10", "0.50", "0.80", "[mask] centre_angle_deg, [beams]")
    assert first[0] == "edge 0, beyond what all have in common"


def test_an_edge_alone_is_free_of_what_all_share(two_speeds):
    """Oracle: independent parts of 1e-6 rad: sqrt(3/4) of it is left after the mean of four is taken off."""
    alone = joint_fit.angles(two_speeds)[1]
    assert alone.value == pytest.approx(0, abs=1e-18)
    assert alone.standard_uncertainty == pytest.approx(np.sqrt(0.75) * 1e-6, rel=1e-6)


def test_the_result_gives_back_the_joint_fit(analysis):
    """Oracle: the record itself, after a way through JSON without not-a-number."""
    told = json.loads(json.dumps(result.result(analysis), allow_nan=False))["joint_fit"]
    joint = analysis.joint
    assert [one["value"] for one in told["shared"].values()] == joint.parameters.values.tolist()
    assert [one["start"] for one in told["shared"].values()] == list(joint.start.values())
    assert [one["standard_uncertainty"] for one in told["shared"].values()] == np.sqrt(
        np.diag(joint.parameters.covariance)
    ).tolist()
    assert told["shared"]["edge_angle_2"]["value_over_prior"] == pytest.approx(0.8, rel=1e-5)
    assert told["shared"]["opening_angle"]["prior_standard_uncertainty"] is None
    assert (told["steps"], told["birge"]) == (4, 1.23)
    assert [one["probability"] for one in told["whiteness"]] == joint.whiteness.tolist()
    assert told["whiteness"][0]["file"] == "runs/camera-0ms-r0.nxs"
    assert told["moved"]["over_standard_uncertainty"] == pytest.approx(2)
    assert told["angles"]["common_angle"]["value"] == pytest.approx(4e-4)
    assert told["angles_measured"] is False
    delay = told["profiles"]["trigger_delay"]
    assert delay["deviation"] == [4, 1, 0, 1, 4]
    assert (delay["lower"], delay["upper"]) == pytest.approx((370e-6, 430e-6))
    assert delay["reference_event"] == "start of integration"


def test_an_estimate_is_compared_with_what_was_known_of_it(analysis):
    """Oracle: by hand; 240 us found where 250 us with u 5 us were stated are 2 u short, in the result and the table."""
    joint = analysis.joint
    prior = Estimate(
        names=(*joint.prior.names, "integration_time"), units=(*joint.prior.units, "s"),
        values=np.append(joint.prior.values, 250e-6), covariance=np.diag([*np.diag(joint.prior.covariance), 25e-12]),
    )  # fmt: skip
    stated = replace(analysis, joint=replace(joint, prior=prior))
    assert result_of_fits.joint_fit(stated)["shared"]["window"]["value_over_prior"] == pytest.approx(-2)
    table = joint_fit.numbers(stated)
    assert table.columns[-1] == "(estimate − prior) / prior u"
    (row,) = [one for one in table.rows if one[0].startswith("length of the integration window")]
    assert row[-2:] == ("5.0", "−2.00")


def test_shares_of_light_and_contrast_are_no_times(analysis):
    """Oracle: by hand; 0.29e-3 ± 0.15e-3 of the mean, 0.015e-3 ± 0.030e-3 of the contrast, and what they are; a time is one."""
    u = np.array([0.15e-3, 0.03e-3, 1e-6])
    local = Estimate(
        names=("bow", "blade_share", "row_delay"), units=("1", "1", "s"), values=np.array([0.29e-3, 0.015e-3, 38e-6]),
        covariance=np.diag(u**2),
    )  # fmt: skip
    told = own_fits.table(replace(analysis, fits=tuple(replace(one, estimate=local) for one in analysis.fits)))
    assert told.columns[-3:] == ("bow (10⁻³)", "blade share (10⁻³)", "row delay (µs)")
    assert told.rows[0][-3:] == ("0.29 ± 0.15", "0.015 ± 0.030", "38.0 ± 1.0")
    assert "Bow: by how much of its mean the opening is brighter" in told.note
    assert "warmer than the other, over the contrast." in told.note
    assert "beside" not in told.note


def test_an_open_end_of_a_profile_is_null(analysis):
    """Oracle: a window cannot be shorter than nothing: the deviation never reaches 1 there."""
    open_below = replace(analysis.profiles[0], lower=None)
    told = result_of_fits.joint_fit(replace(analysis, profiles=(open_below,)))
    assert json.loads(json.dumps(told))["profiles"]["trigger_delay"]["lower"] is None
    joint_fit.draw_profiles((open_below,)).draw_without_rendering()


def test_profiles_are_drawn_over_their_parabola(analysis):
    """Oracle: points that are a parabola lie on the grey line, x squared; marks at -1 and +1."""
    drawn = joint_fit.draw_profiles(analysis.profiles)
    assert len(drawn.axes) == 2
    lines = drawn.axes[0].get_lines()
    expected, between, points = (line.get_xydata() for line in lines[:3])
    for curve in (expected, between, points):
        np.testing.assert_allclose(curve[:, 1], curve[:, 0] ** 2, atol=1e-9)
    marks = [float(line.get_xdata()[0]) for line in lines[4:]]
    assert marks == pytest.approx([-1, 1])


def test_recordings_that_are_not_white_are_red(analysis):
    """Oracle: nine probabilities above the limit, one of 1e-5 below."""
    lines = joint_fit.draw_whiteness(analysis.joint.whiteness).axes[0].get_lines()
    assert [len(line.get_xdata()) for line in lines[:3]] == [9, 1, 0]
    assert lines[3].get_ydata()[0] == 1e-4


@pytest.mark.usefixtures("sketched")
def test_the_section_stands_between_fit_and_uncertainty(analysis):
    """Oracle: the order of the argument; residuals stand under the fit before it."""
    page = certificate.page(analysis)
    places = [page.index(f"<h2>{title}</h2>") for title in ("Exposed fraction and fit", "Joint fit", "Uncertainty")]
    assert places == sorted(places)
    assert "Profile likelihoods" in page
    assert "Are the residuals white?" in page

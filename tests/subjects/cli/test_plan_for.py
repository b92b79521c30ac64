"""`irtiming plan --for`, as typed."""

import json

import pytest

from irtiming.errors import ArchiveError, IrTimingError, PlanError, UnitError


def test_the_plan_file_holds_what_is_predicted(run, tmp_path):
    """Oracle: the target, and the sum of the parts' squares."""
    out = tmp_path / "plan.json"
    result = run("--for", "trigger_delay=0.5us", "--for", "relative_delay=0.8 us", "--json", out, "--most", 2)
    assert result.exit_code == 0, result.output
    written = json.loads(out.read_text())
    assert len(written["proposals"]) == 2
    found = written["predicted_uncertainty"]
    assert found == written["proposals"][0]["predicted_uncertainty"]
    for name, wanted in (("trigger_delay", 0.5e-6), ("relative_delay", 0.8e-6)):
        assert written["targets"][name] == {"standard_uncertainty": pytest.approx(wanted), "unit": "s"}
        assert found[name]["standard_uncertainty"] <= wanted
        total = sum(part["standard_uncertainty"] ** 2 for part in found[name]["parts"])
        assert total == pytest.approx(found[name]["standard_uncertainty"] ** 2)
    assert {entry["trigger_delay_s"] for entry in written["plan"]["runs"]} == {0, 0.025}
    assert "mask centre angle phi_M" in result.output
    assert "One wheel speed alone reaches u(trigger_delay) = 1.9 µs at best" in result.output


def test_one_speed_is_told_what_limits_it(run):
    """Oracle: 0.03 degrees of the mask at 3 Hz are 28 us."""
    result = run("--for", "trigger_delay=0.5us", "--wheel-hz", "3")
    assert isinstance(result.exception, PlanError)
    assert "phi_M makes 28 µs" in str(result.exception)


def test_a_rig_and_a_camera_are_taken_from_their_files(run, tmp_path):
    """Oracle: noise doubled in the result doubles the uncertainty of a relative delay; the rig's own phi_M is in the parts."""
    rig = tmp_path / "rig.toml"
    rig.write_text(
        "[beams]\nhalf_separation_mm = 13\nheight_difference_mm = 5.5\nwhole_slots_between = 9\n"
        "[mask]\nopening_angle_deg = 75\ncentre_angle_deg = -90\ncentre_angle_u_deg = 0.3\n"
    )
    found = []
    for noise in (0.004, 0.008):
        result, out = tmp_path / "result.json", tmp_path / "plan.json"
        camera = {"camera": "photon", "noise_to_contrast": noise, "opening_pixels": 1200, "integration_time": 1e-4}
        result.write_text(json.dumps({"prediction": {"camera": camera}}))
        done = run("--for", "relative_delay=1ms", "--for", "trigger_delay=1ms", "--wheel-hz", 3, "--like", result,
                   "--rig", rig, "--json", out)  # fmt: skip
        assert done.exit_code == 0, done.output
        found.append(json.loads(out.read_text()))
    relative = [
        {
            part["source"]: part["standard_uncertainty"]
            for part in one["predicted_uncertainty"]["relative_delay"]["parts"]
        }
        for one in found
    ]
    assert relative[1]["noise of the frames"] == pytest.approx(2 * relative[0]["noise of the frames"], rel=1e-6)
    assert relative[1]["clock of the trigger generator"] == pytest.approx(0.025 * 50e-6 / 3**0.5)
    parts = found[0]["predicted_uncertainty"]["trigger_delay"]["parts"]
    (mask,) = [part["standard_uncertainty"] for part in parts if part["source"] == "mask centre angle phi_M"]
    assert mask == pytest.approx(278e-6, rel=0.01)
    assert found[0]["camera"]["integration_time"] == 1e-4


def test_noise_and_contrast_count_as_their_ratio(run, tmp_path):
    """Oracle: 20 DN of 4770 DN are 38 mK of 9 K."""
    found = []
    for words in (("--noise", 20, "--contrast", 4770), ("--noise", 20 / 530, "--contrast", 9), ("--noise", 20 / 530)):
        out = tmp_path / "plan.json"
        assert run("--for", "relative_delay=1us", *words, "--wheel-hz", 3, "--json", out).exit_code == 0
        found.append(json.loads(out.read_text())["camera"]["noise_to_contrast"])
    assert found == pytest.approx([20 / 4770] * 3)


@pytest.mark.parametrize("kind", ["photon", "microbolometer"])
@pytest.mark.parametrize("readout", ["snapshot", "rolling"])
def test_every_camera_can_be_planned_for(run, tmp_path, kind, readout):
    """Oracle: by hand; a rolling camera has a row delay to ask for, and a snapshot has none."""
    out, rows = tmp_path / "plan.json", ("--for", "row_delay=1us", "--row-delay", "30 us")
    words = (
        "--camera", kind, "--readout", readout, "--opening-pixels", 1200,
        "--for", "trigger_delay=1ms", "--wheel-hz", 5, "--json", out,
    )  # fmt: skip
    done = run(*words, *(rows if readout == "rolling" else ()))
    assert done.exit_code == 0, done.output
    written = json.loads(out.read_text())
    assert (written["camera"]["camera"], written["camera"]["readout_mode"]) == (kind, readout)
    assert written["camera"].get("row_delay") == (pytest.approx(30e-6) if readout == "rolling" else None)
    assert written["predicted_uncertainty"]["trigger_delay"]["standard_uncertainty"] < 1e-3
    if readout == "snapshot":
        assert all(isinstance(run(*words, *rows[k : k + 2]).exception, PlanError) for k in (0, 2))


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--wheel-hz", "3"], PlanError),
        (
            [
                "--camera",
                "photon",
                *["--clock-hz", "49152000", "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "1000"],
            ],
            PlanError,
        ),
        (["--for", "trigger_delay=0.5us", "--repeats", "3"], PlanError),
        (["--for", "trigger_delay"], PlanError),
        (["--for", "row_delay=1us"], PlanError),
        (["--for", "trigger_delay=1us", "--noise", "-1"], PlanError),
        (["--for", "trigger_delay=1us", "--contrast", "0"], PlanError),
        (["--for", "trigger_delay=1us", "--opening-pixels", "0"], PlanError),
        (["--for", "trigger_delay=1us", "--integration-time", "long"], UnitError),
        (["--for", "trigger_delay=1us", "--time-constant", "5 ms"], PlanError),
        (["--for", "row_delay=1us", "--camera", "microbolometer", "--integration-time", "1 ms"], PlanError),
        (["--for", "integration_time=1us", "--known-integration-time"], PlanError),
        (["--for", "trigger_delay=1us", "--like", "/nowhere.json"], ArchiveError),
        (["--for", "trigger_delay=1us", "--like", "README.md"], ArchiveError),
        (["--for", "trigger_delay=1us", "--rig", "/nowhere.toml"], ArchiveError),
    ],
)
def test_bad_input_raises_one_clear_line(run, words, error):
    """Oracle: an error of ours, which the program prints and exits with 2; never another exception."""
    result = run(*words)
    assert isinstance(result.exception, IrTimingError), (result.exception, result.output)
    assert isinstance(result.exception, error)
    assert "\n" not in str(result.exception)


def test_a_terminal_of_80_columns_breaks_no_number(narrow):
    """Oracle: the three wishes and their words by hand; nothing is cut short by an ellipsis."""
    wishes = ("trigger_delay=50us", "relative_delay=10us", "integration_time=1ms")
    result = narrow(*(word for wish in wishes for word in ("--for", wish)))
    assert result.exit_code == 0, result.output
    assert "…" not in result.output
    assert "trigger delay   relative delay   integration time" in result.output
    assert any(line.split()[-6:] == ["50", "µs", "10", "µs", "1", "ms"] for line in result.output.splitlines())


@pytest.mark.parametrize(
    ("words", "is_said"),
    [
        ([], True),
        (["--known-integration-time"], False),
        (["--readout", "rolling"], False),
        (["--camera", "microbolometer"], False),
    ],
)
def test_what_counts_of_the_integration_time_is_said(run, words, is_said):
    """Oracle: by hand; only a snapshot photon camera may have a window that is searched or known."""
    done = run("--for", "trigger_delay=1ms", "--wheel-hz", 3, *words)
    assert done.exit_code == 0, done.output
    assert ("integration time counts as unknown" in " ".join(done.output.split())) == is_said

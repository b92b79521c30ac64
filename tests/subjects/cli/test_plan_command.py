"""`irtiming plan`, as typed."""

import json
from xml.etree import ElementTree

import pytest

from irtiming.errors import ArchiveError, IrTimingError, PlanError, UnitError

PAPER = ["--clock-hz", "49152000", "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "1000"]
TOY = ["--clock-hz", "3000", "--wheel-hz", "3", "--frame-hz", "10", "--samples", "10"]


def test_the_papers_scheme_is_the_first_in_the_file(run, tmp_path):
    """Oracle: Schatz 2023, section 2.3."""
    out = tmp_path / "plan.json"
    result = run(*PAPER, "--json", out)
    assert result.exit_code == 0, result.output
    written = json.loads(out.read_text())
    first = written["schemes"][0]
    assert (first["turn_period_ticks"], first["camera_period_ticks"]) == (16_384_000, 1_622_016)
    assert (first["sampling_interval_ticks"], first["control_slot_period_ticks"]) == (16_384, 163_840)
    assert (first["samples_per_turn"], first["samples_per_frame"]) == (1000, 99)
    assert (first["wheel_rate_hz_exact"], first["frame_rate_hz_exact"]) == ("3", "1000/33")
    assert first["run_duration_s"] == 33
    assert len(written["schemes"]) == written["n_options"] > 1
    assert sorted(written["plan"]["sampling_orders"][0]) == list(range(1000))
    for word in ("16384000", "163840", "1622016", "16384", "1000/33", "33 s", "turn 0", "899 triggers later"):
        assert word in result.output, word


def test_most_shortens_the_table_but_not_the_file(run, tmp_path):
    """Oracle: the count of the whole search."""
    out = tmp_path / "plan.json"
    result = run(*PAPER, "--most", "2", "--json", out)
    assert "486 admissible schemes; 2 shown" in result.output
    assert len(json.loads(out.read_text())["schemes"]) == 486


def test_an_exact_frame_rate_finds_a_prime_number_of_samples(run):
    """Oracle: Schatz 2023, section 2.3, last paragraph."""
    result = run(*PAPER[:4], "--frame-hz", "30", "--frame-hz-exact", "--samples", "1000")
    assert result.exit_code == 0, result.output
    assert "prime 1279" in result.output


def test_several_wheel_speeds_are_one_plan_with_its_runs(run, tmp_path):
    """Oracle: by hand; 2 speeds, 2 delays, 3 repeats of about 33 s in 2 minutes: one run per correction."""
    out = tmp_path / "plan.json"
    result = run(
        *PAPER, "--wheel-hz", "2", "--delay", "0", "--delay", "25 ms", "--repeats", 3,
        "--between-corrections", "2 min", "--json", out,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    written = json.loads(out.read_text())
    assert written["shares_camera_period"]
    first, second = written["schemes"][:2]
    assert first["rank"] == second["rank"] == 1
    assert first["camera_period_ticks"] == second["camera_period_ticks"]
    assert first["wheel_rate_hz"] == pytest.approx(3, rel=0.01)
    assert second["wheel_rate_hz"] == pytest.approx(2, rel=0.01)
    runs = written["plan"]["runs"]
    assert [entry["trigger_delay_s"] for entry in runs] == [0, 0.025, 0, 0.025]
    assert all(entry["is_after_correction"] and entry["repeats"] == 3 for entry in runs)
    assert "4 corrections" in result.output


def test_the_sampling_order_is_drawn_as_text_and_picture(run, tmp_path):
    """Oracle: the toy of figure 3 by hand: 10 samples in 3 turns, the neighbour 7 triggers later."""
    out = tmp_path / "toy.svg"
    result = run(*TOY, "--picture", out)
    assert result.exit_code == 0, result.output
    assert "turn 0  0..1..2..3\nturn 1  ..4..5..6.\nturn 2  .7..8..9..\n" in result.output
    picture = ElementTree.parse(out).getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert picture.tag == f"{space}svg"
    circles = picture.findall(f"{space}circle")
    assert len(circles) == 10
    across = [float(circle.get("cx")) for circle in circles]
    assert sorted(range(10), key=lambda number: across[number]) == [0, 7, 4, 1, 8, 5, 2, 9, 6, 3]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--clock-hz", "0"], PlanError),
        (["--clock-hz", "fast"], UnitError),
        (["--clock-hz", "49152000.5"], UnitError),
        (["--wheel-hz", "-3"], PlanError),
        (["--frame-hz", "nan"], UnitError),
        (["--frame-hz", "0"], PlanError),
        (["--frame-hz-min", "40"], PlanError),
        (["--samples", "1.5"], PlanError),
        (["--samples", "-1"], PlanError),
        (["--samples", "5"], PlanError),
        (["--control-slots", "0"], PlanError),
        (["--tolerance", "200%"], PlanError),
        (["--tolerance", "much"], UnitError),
        (["--wheel-tolerance", "x"], UnitError),
        (["--between-corrections", "soon"], UnitError),
        (["--between-corrections", "0 s"], PlanError),
        (["--between-corrections", ""], UnitError),
        (["--delay", "-1 ms"], PlanError),
        (["--repeats", "0"], PlanError),
        (["--json", "/nowhere/at/all.json"], ArchiveError),
    ],
)
def test_bad_input_raises_one_clear_line(run, words, error):
    """Oracle: an error of ours, which the program prints and exits with 2; never another exception."""
    result = run(*PAPER, *words)
    assert isinstance(result.exception, IrTimingError), (result.exception, result.output)
    assert isinstance(result.exception, error)
    assert "\n" not in str(result.exception)


def test_a_delay_between_two_ticks_is_said_to_be_rounded(run):
    """Oracle: 0.1 ms is 0.3 ticks of 3000 Hz."""
    result = run(*TOY, "--delay", "0.1 ms")
    assert "not a whole number of ticks" in result.output


def test_a_terminal_of_80_columns_breaks_no_rate(narrow):
    """Oracle: 49152000 / 1622115 and 49152000 / 16385000 in their lowest terms, by hand."""
    result = narrow(*PAPER, "--most", "2")
    assert result.exit_code == 0, result.output
    assert max(map(len, result.output.partition("486 admissible")[0].splitlines())) <= 80
    assert ["163850", "16385", "99", "49152/16385", "3276800/108141", "0.0120"] in map(
        str.split, result.output.splitlines()
    )

"""What a plan runs, as the page of the recording shows it before it does."""

from pathlib import Path

import pytest

from irtiming.web.tasks import recording

PLAN = (Path(__file__).parents[3] / "examples" / "cooled.plan.toml").read_text()


@pytest.mark.parametrize(
    ("written", "runs"),
    [
        ("", ""),
        ('command = "/opt/arm"', "/opt/arm"),
        ('"command" = "/opt/arm"', "/opt/arm"),
        ('"comm\\u0061nd" = """\n/opt/arm"""', "/opt/arm"),
    ],
)
def test_the_program_is_that_which_the_plan_runs(tmp_path, written, runs):
    """Oracle: by hand; ways in which TOML may write one key."""
    path = tmp_path / "plan.toml"
    path.write_text(PLAN.replace('when = "both"', f'when = "both"\n{written}'), encoding="utf-8")
    assert recording.command_of(None, path) == runs


def test_a_program_in_a_line_of_its_own_table_is_shown_too(tmp_path):
    """Oracle: by hand; the section written as an inline table."""
    head, _, rest = PLAN.partition("[references]")
    table = 'references = {low = "25 C", high = "60 C", frames = 50, when = "both", command = "/opt/arm"}\n'
    path = tmp_path / "plan.toml"
    path.write_text(f"{table}{head}{rest[rest.index('[stop]') :]}", encoding="utf-8")
    assert recording.command_of(None, path) == "/opt/arm"

"""Wheel speeds for a camera that runs free."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app
from irtiming.plan.free_running import even_speed, largest_gap


def test_the_largest_gap_is_that_of_the_angles_one_by_one():
    """Oracle: brute force over pairs of neighbours; a wheel in step with the camera, by hand; the golden section."""
    period, golden = 1 / 30, (np.sqrt(5) - 1) / 2
    assert largest_gap(3.0, period_s=period, frames=600) == pytest.approx(
        60.0, rel=1e-6
    )  # ten angles, 60 frames at each
    angles = sorted((n * 3.1 * period) % 1.0 for n in range(200))
    gaps = [b - a for a, b in zip(angles, [*angles[1:], angles[0] + 1], strict=True)]
    assert largest_gap(3.1, period_s=period, frames=200) == pytest.approx(200 * max(gaps))
    assert largest_gap(golden / period, period_s=period, frames=987) < 2.2
    worst = max(largest_gap(3.1 * (1 + off), period_s=period, frames=200) for off in np.linspace(-1e-4, 1e-4, 15))
    assert largest_gap(3.1, period_s=period, frames=200, tolerance=1e-4) == pytest.approx(worst)


def test_a_speed_in_step_with_the_camera_is_left_for_an_even_one():
    """Oracle: the gap of the speed that was asked for, and the limits."""
    found = even_speed((2.9, 3.1), period_s=1 / 30, frames=500, tolerance=1e-4)
    assert found.is_even
    assert 2.9 <= found.wheel_rate_hz <= 3.1
    assert found.largest_gap < 4 < largest_gap(3.0, period_s=1 / 30, frames=500)


def test_the_command_tells_speeds_and_what_a_run_should_tell(tmp_path):
    """Oracle: a run of twice the frames has less noise; what has no use without triggers is refused by name."""
    run, out = CliRunner().invoke, tmp_path / "plan.json"
    words = ["plan", "--free-running", "33.333 ms", "--wheel-hz", "4", "--json", str(out), "--samples"]
    noise = []
    for frames in ("500", "1000"):
        told = run(app, [*words, frames])
        assert told.exit_code == 0, told.output
        found = json.loads(out.read_text())["speeds"][0]
        parts = found["predicted_uncertainty"]["trigger_delay"]["parts"]
        noise.append(next(part["standard_uncertainty"] for part in parts if part["source"] == "noise of the frames"))
        assert found["is_even"]
    assert noise[1] == pytest.approx(noise[0] / np.sqrt(2), rel=0.2)  # the two speeds are not quite one
    wrong = run(app, [*words, "500", "--picture", "x.svg"])
    assert isinstance(wrong.exception, Exception)
    assert "no triggers to plan" in str(wrong.exception)

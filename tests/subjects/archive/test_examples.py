"""The examples that a laboratory begins with."""

from pathlib import Path

import pytest

from irtiming.archive.rig_file import read_rig
from irtiming.archive.series_file import read_series
from irtiming.session.triggers import triggers_of

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize(
    ("name", "camera", "n_runs"), [("cooled", "photon", 10), ("microbolometer", "microbolometer", 4)]
)
def test_the_plan_of_an_example_is_read_and_can_be_made(name, camera, n_runs):
    """Oracle: the reader of plans, and speeds times delays counted by hand; the wheel follows to 1 %, as asked."""
    plan = read_series(EXAMPLES / f"{name}.plan.toml")
    assert plan.camera.camera_type == camera
    triggers = triggers_of(plan, clock_frequency_hz=48_000_000)
    assert len(triggers.runs) == n_runs
    wished = [float(text) for text in plan.triggers.wheel_hz]
    rates = sorted({48_000_000 / scheme.turn_period_ticks for scheme in triggers.schemes})
    assert rates == pytest.approx(wished, rel=0.01)


@pytest.mark.parametrize("name", ["cooled", "microbolometer"])
def test_the_rig_of_an_example_is_read(name):
    """Oracle: the paper's wheel of 100 control slots before an opening of 75 degrees."""
    rig = read_rig(EXAMPLES / f"{name}.rig.toml")
    assert rig.wheel.control_slots == 100
    assert rig.mask_opening.opening_angle_rad.value == pytest.approx(1.308996938995747)


def test_every_example_is_tested():
    """Oracle: the folder; the certificate's is tested by its command, the ROS node with the hand-over."""
    names = {f"{name}.{kind}.toml" for name in ("cooled", "microbolometer") for kind in ("plan", "rig")}
    elsewhere = {"certificate.toml", "ros2_effective_stamps.py"}
    assert {path.name for path in EXAMPLES.iterdir() if path.is_file()} == names | elsewhere

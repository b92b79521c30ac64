"""The program on the page about the driver, run as it stands there but for the port."""

import json
import re
import subprocess
import sys
from pathlib import Path

from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme
from irtiming.session.plan_json import plan_as_json
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.scene import paper_scene

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "use-the-trigger-generator.md"


def test_the_program_of_the_page_records_a_run(tmp_path):
    """Oracle: the plan in the file that the program reads: N triggers, and nothing lost."""
    scheme = TriggerScheme(turn_period_ticks=4_000_000, camera_period_ticks=1_560_000)
    run = PlannedRun(scheme=scheme, trigger_delay_ticks=0, repeats=1, is_after_correction=False)
    plan = TriggerPlan(clock_frequency_hz=48_000_000, schemes=(scheme,), runs=(run,))
    (tmp_path / "plan.json").write_text(json.dumps({"clock_frequency_hz": 48_000_000, "plan": plan_as_json(plan)}))
    (program,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), flags=re.MULTILINE | re.DOTALL)
    wheel = DrivenWheel(paper_scene(16, 20), clock_frequency_hz=48_000_000, seed=1)
    with PseudoTerminal(ModelDevice(wheel), speed=10) as terminal:
        program = program.replace("/dev/ttyUSB1", terminal.path)
        done = subprocess.run(
            [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
        )
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"True {scheme.samples_per_turn} triggers\n"

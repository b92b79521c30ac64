"""What a person writes, and what the program keeps between two calls: rig.toml, plans, limits, lists, journals and states."""

from pathlib import Path

from target import OF_JSON, OF_TEXT, Target, in_file

from irtiming.acquire.journal import Journal
from irtiming.archive import rig_update
from irtiming.archive.campaign_table import read_list
from irtiming.archive.limits_file import read_limits
from irtiming.archive.plan_file import read_plan
from irtiming.archive.rig_file import read_rig
from irtiming.archive.series_file import read_series
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.distribute.state import REFUSED, RESULTS, State

EXAMPLES = Path(__file__).parents[2] / "examples"
_LIMITS = """[decision]
rule = "guard band"

[[limit]]
parameter = "trigger_delay"
upper = "1 ms"

[[limit]]
parameter = "time_constant"
serial_number = "7"
lower = "4 ms"
upper = "6 ms"
"""
_LIST = """# of one day
file,serial_number,operator,run
a.nxs,7,Anna,1
"b, c.nxs",8,,2
"""


def _document(name: str) -> list[bytes]:
    from documents import documents

    return [documents()[name]]


def _updated(path: Path) -> None:
    """The example with a section that somebody wrote, into which numbers are put."""
    rig_update.update(path, "latency", numbers={"trigger_us": "1.5", "trigger_u_us": "0.1"})
    read_rig(path)


def _gone_on(path: Path) -> None:
    """A series goes on from its journal."""
    for digest in ("d", ""):
        journal = Journal.opened(path.parent, digest=digest, n_runs=2)
        for number in range(2):
            journal.file_of(number)
        journal.note(journal.uid)
        journal.as_json()


def _resumed(path: Path) -> None:
    """A campaign goes on from what is in its folder."""
    state = State(path.parent)
    for folder in (RESULTS, REFUSED):
        (path.parent / folder / "k.json").write_bytes(path.read_bytes())
    state.result("k")
    state.refusal("k")


TARGETS = {
    "rig.toml": Target(
        seeds=lambda: [path.read_bytes() for path in sorted(EXAMPLES.glob("*.rig.toml"))],
        take=in_file("rig.toml", read_rig, _updated), changes=OF_TEXT,
    ),
    "plan.toml": Target(
        seeds=lambda: [path.read_bytes() for path in sorted(EXAMPLES.glob("*.plan.toml"))],
        take=in_file("plan.toml", read_series), changes=OF_TEXT,
    ),
    "limits.toml": Target(seeds=lambda: [_LIMITS.encode()], take=in_file("limits.toml", read_limits), changes=OF_TEXT),
    "list of recordings": Target(seeds=lambda: [_LIST.encode()], take=in_file("list.csv", read_list), changes=OF_TEXT),
    "wheel.json": Target(
        seeds=lambda: _document("wheel"), take=in_file("wheel.json", read_wheel_calibration), changes=OF_JSON
    ),
    "plan.json": Target(seeds=lambda: _document("plan"), take=in_file("p.json", read_plan), changes=OF_JSON),
    "journal": Target(seeds=lambda: _document("journal"), take=in_file("series.json", _gone_on), changes=OF_JSON),
    "state of a campaign": Target(
        seeds=lambda: [b'{"what": "no opening found"}', *_document("result")], take=in_file("k.json", _resumed), changes=OF_JSON
    ),
}  # fmt: skip

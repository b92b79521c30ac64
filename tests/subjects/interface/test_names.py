"""The names that ``import irtiming`` gives: there at once, loaded when asked for, and refusing what they do not know."""

import subprocess
import sys
from pathlib import Path

import pytest

import irtiming
from irtiming.errors import PlanError, UnitError
from irtiming.records.recording import Recording

HEAVY = ("numpy", "scipy", "numba", "matplotlib", "pandas", "GTC", "h5py", "rich", "typer")


def test_importing_loads_no_library() -> None:
    """Oracle: the modules of a fresh interpreter after the import."""
    code = "import irtiming, sys; print([name for name in sys.argv[1:] if name in sys.modules], dir(irtiming))"
    done = subprocess.run([sys.executable, "-c", code, *HEAVY], capture_output=True, text=True, check=True)
    assert done.stdout == f"[] {irtiming.__all__}\n"


def test_the_folder_of_planning_can_be_called() -> None:
    """Oracle: section 2.3 of the paper: 49.152 MHz, 3 Hz and 30.303 Hz make 1000 samples with T = 16384000, C = 1622016."""
    from irtiming.plan import search

    assert search.search
    scheme = irtiming.plan(clock_hz=49_152_000, wheel_hz=3, frame_hz=30.303, samples=1000).best.schemes[0]
    assert (scheme.turn_period_ticks, scheme.camera_period_ticks) == (16_384_000, 1_622_016)


def test_a_wish_that_nobody_knows_is_refused(tmp_path: Path) -> None:
    """Oracle: names and words that are none, some by one letter; the nearest is said, and nothing is written."""
    with pytest.raises(PlanError, match="'framse' is no wish; did you mean frames"):
        irtiming.simulate(tmp_path / "made", framse=100)
    with pytest.raises(PlanError, match="did you mean wheel_hz"):
        irtiming.plan(whel_hz=3)
    with pytest.raises(PlanError, match="camera is 'banana', must be photon or microbolometer"):
        irtiming.simulate(tmp_path / "made", camera="banana")
    with pytest.raises(UnitError, match="extras is 'map', must be .* or maps; did you mean 'maps'"):
        irtiming.analyse([], Path("rig.toml"), extras=["map"])  # type: ignore[list-item]
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(AttributeError, match="no attribute 'analyze'"):
        _ = irtiming.analyze


def test_a_recording_shows_itself_in_one_line(hand_made) -> None:
    """Oracle: shapes of the file by hand; no pixel value and no tick is among it."""
    found = irtiming.open_recording(hand_made())
    assert isinstance(found, Recording)
    assert "frames=<20×4×6>" in repr(found)
    assert len(repr(found)) < 400
    assert "array(" not in repr(found)


def test_an_analysis_starts_without_the_distributions_of_scipy() -> None:
    """Oracle: the modules of a fresh interpreter; scipy.stats takes as long as all else that an analysis imports."""
    code = "import irtiming.measurement, irtiming.cli.main, sys; print([name in sys.modules for name in sys.argv[1:]])"
    done = subprocess.run(
        [sys.executable, "-c", code, "scipy.special", "scipy.stats"], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[True, False]\n"


@pytest.mark.parametrize(
    ("wishes", "said"),
    [
        ({"delay_s": "25 ms"}, "delay_s is '25 ms'; it must be a number, in s"),
        ({"wheel_hz": ("3 Hz", 6.0)}, "must be a number, in Hz"),
    ],
)
def test_text_in_place_of_a_number_is_refused(tmp_path, wishes, said):
    """Oracle: by hand; the command line takes units, Python numbers in SI units."""
    with pytest.raises(irtiming.IrTimingError, match=said):
        irtiming.simulate(tmp_path / "made", **wishes)


def test_one_wheel_rate_may_stand_alone(tmp_path):
    """Oracle: the recording's own rate; 4 Hz as a number and not as one of several."""
    made = irtiming.simulate(tmp_path / "made", wheel_hz=4, rows=24, columns=32, frames=120)
    assert irtiming.open_recording(made.recordings[0]).rotation_speed_hz == pytest.approx(4.0, rel=1e-3)

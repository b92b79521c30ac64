"""The program in the how-to page, run as it stands there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from irtiming.archive import reader
from irtiming.archive.verify import verify

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "write-recordings-from-your-own-software.md"


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """The recording that the page's program writes."""
    (program,) = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), flags=re.MULTILINE | re.DOTALL)
    folder = tmp_path_factory.mktemp("how-to")
    subprocess.run([sys.executable, "-W", "error", "-c", program], cwd=folder, check=True, timeout=60)
    return folder / "my-recording.nxs"


def test_the_program_of_the_page_writes_a_sound_recording(made):
    """Oracle: irtiming verify, which has nothing to complain about, and says what the page prints."""
    (finding,) = verify(made)
    assert finding.severity == "ok"
    assert finding.sentence() in PAGE.read_text()


def test_the_recording_of_the_page_holds_what_the_program_put_in(made):
    """Oracle: the numbers in the page's program."""
    recording = reader.read(made)
    assert recording.frames.shape == (120, 60, 80)
    assert recording.integration_time_s == 250e-6
    assert recording.rotation_speed_hz == 3.0
    assert recording.nonuniformity is not None
    assert recording.nonuniformity.low_temperature_k == 288.15
    assert recording.findings == ()

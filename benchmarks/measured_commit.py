"""Which program printed a figure."""

import subprocess
from pathlib import Path


def commit() -> str:
    """Of the program that is run, with a plus where files were changed."""
    given = ["git", "describe", "--always", "--dirty=+", "--exclude=*"]
    return subprocess.run(given, cwd=Path(__file__).parent, capture_output=True, text=True, check=False).stdout.strip()

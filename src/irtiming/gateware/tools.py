"""Programs that pip installs beside Python."""

import shutil
import sys
from pathlib import Path

from irtiming.errors import GatewareError


def program(name: str) -> str:
    """Path of a program of the extra.

    Parameters
    ----------
    name
        As one would type it.

    Returns
    -------
    The one beside this Python, else the one that the shell would find.

    Raises
    ------
    GatewareError
        If there is none.
    """
    beside = Path(sys.executable).with_name(name)
    found = str(beside) if beside.exists() else shutil.which(name)
    if found is None:
        raise GatewareError(f"{name} is not there, but needed: pip install 'irtiming[gateware]'")
    return found

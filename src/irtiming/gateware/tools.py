"""Packages and programs of the extra: there, or an error that says how they get there."""

import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

from irtiming.errors import GatewareError


def require(*packages: str, needed_by: str) -> None:
    """Nothing, if all these packages are installed.

    Parameters
    ----------
    packages
        Names under which they are imported.
    needed_by
        For the message, such as ``"the build"``.

    Raises
    ------
    GatewareError
        If one is not.
    """
    for package in packages:
        if find_spec(package) is None:
            raise GatewareError(f"{package} is not installed, {needed_by} needs it: pip install 'irtiming[gateware]'")


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

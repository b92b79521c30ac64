"""A first look at an HDF5 file by a child process: a file that makes HDF5 crash, or turn in a circle, ends the child alone.

What HDF5 itself does to a process cannot be caught in it. The child is a fork, so a look takes some hundredths of a second; each
file is looked at once. Where there is no fork, none is.
"""

import os
import signal
import time
import warnings
from contextlib import suppress
from pathlib import Path

import h5py

from irtiming.archive import layout
from irtiming.archive.finding import refuse
from irtiming.archive.hdf5_bounds import H5_ERRORS, require_bounded, stack_in

LONGEST_CPU_S = 5
_LONGEST_WAIT_S = 30.0
_POLL_S = 1e-3
_FATAL = (signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT, signal.SIGFPE, signal.SIGILL, signal.SIGXCPU, signal.SIGKILL)

_survived: set[tuple[str, int, int]] = set()


def require_survivable(path: Path) -> None:
    """Refuse a file that kills whoever reads what it says, its frames apart.

    Raises
    ------
    Complaint
        If it does.
    """
    if not hasattr(os, "fork") or not path.is_file():
        return
    state = path.stat()
    known = (str(path.resolve()), state.st_mtime_ns, state.st_size)
    if known in _survived:
        return
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # h5py holds its own lock at a fork, and the child takes no other
        child = os.fork()
    if child == 0:
        _look_and_leave(path)
    if _signal_of(child) in _FATAL:
        raise refuse(
            "",
            "makes the HDF5 library crash, or turn in a circle",
            code="kills-hdf5",
            cure="the file is damaged, or made to do harm; copy or record it again",
        )
    _survived.add(known)


def _look_and_leave(path: Path) -> None:
    """In the child: read all that is read later, and end without a word."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (LONGEST_CPU_S, LONGEST_CPU_S))
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        with h5py.File(path, "r") as file:
            require_bounded(file)
            with suppress(*H5_ERRORS):
                stack_in(file)
            for one in layout.FIELDS:
                with suppress(*H5_ERRORS):
                    dataset = file[one.path]
                    _ = dict(dataset.attrs)
                    _ = dataset.chunks if one.kind == "frames" else dataset[()]
    finally:
        os._exit(0)


def _signal_of(child: int) -> int:
    """The signal that ended a child; 0 for none, and for one that waits for something else than HDF5."""
    until_s = time.monotonic() + _LONGEST_WAIT_S
    while time.monotonic() < until_s:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        time.sleep(_POLL_S)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return 0

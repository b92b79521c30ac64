"""What a worker of this computer loads first: Ctrl-C, which a terminal gives to all processes of a command, is not for it.

It is for the process that asked for the work, which ends its workers.
"""

import signal


def dask_setup(_: object) -> None:
    """Called by Dask in the worker's own process.

    Parameters
    ----------
    _
        The worker.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)

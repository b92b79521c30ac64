"""Pieces of work on many processors: Dask workers of this computer or of a running scheduler, or this process alone.

A worker that dies takes nothing along: its piece is done again by another, and given up when it has cost several workers. What
fails in one piece stays in that piece.
"""

import logging
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, final

from irtiming.archive.held_signals import held_signals
from irtiming.errors import ArchiveError, EstimationError, GeometryError, IrTimingError, ReductionError

_Piece = TypeVar("_Piece")
_Found = TypeVar("_Found")
HERE = "here"
"""In place of a scheduler's address: no other process at all."""

_OF_THE_DATA = (ReductionError, EstimationError, GeometryError)
_ALLOWED_DEATHS = 3
_SETTINGS = {
    "distributed.scheduler.allowed-failures": _ALLOWED_DEATHS,
    "distributed.logging.distributed": "critical",
    "distributed.worker.profile.enabled": False,
    "distributed.worker.preload": ["irtiming.distribute.deaf"],
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1
    ),
}
"""Dask's own environ has MALLOC_TRIM_THRESHOLD_ too, by which every array goes back to the system: twice the time."""


@final
@dataclass(frozen=True, kw_only=True)
class Failed:
    """Why a piece of work came to nothing; ``is_lasting`` where the same would come of it again."""

    what: str
    is_lasting: bool


class Workers(Protocol):
    """Whoever does the work."""

    def each(
        self, work: Callable[[_Piece], _Found], pieces: Mapping[str, _Piece]
    ) -> Iterator[tuple[str, _Found | Failed]]:
        """Name and outcome of each piece, as they come."""
        ...


@final
class _Here:
    """The process that asks."""

    def each(
        self, work: Callable[[_Piece], _Found], pieces: Mapping[str, _Piece]
    ) -> Iterator[tuple[str, _Found | Failed]]:
        for name, piece in pieces.items():
            try:
                yield name, work(piece)
            except Exception as error:
                yield name, failure(error)


@final
class _Dask:
    """Workers of a Dask scheduler."""

    def __init__(self, client: Any) -> None:
        self._client = client

    def each(
        self, work: Callable[[_Piece], _Found], pieces: Mapping[str, _Piece]
    ) -> Iterator[tuple[str, _Found | Failed]]:
        from distributed import as_completed

        futures = {self._client.submit(work, piece, pure=False): name for name, piece in pieces.items()}
        waiting = as_completed(futures)
        for future in waiting:
            try:
                outcome: _Found | Failed = future.result()
            except Exception as error:
                outcome = failure(error)
            yield futures.pop(future), outcome


def failure(error: Exception) -> Failed:
    """What an error of a piece of work says; one of what the data say would come again, a file may be read the next time."""
    if isinstance(error, IrTimingError):
        notes = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
        return Failed(what=f"{error}{notes}", is_lasting=isinstance(error, _OF_THE_DATA))
    if type(error).__name__ == "KilledWorker":
        return Failed(
            what=f"{_ALLOWED_DEATHS + 1} workers died while they worked on it; give them more memory, or analyse it alone",
            is_lasting=False,
        )
    return Failed(what=f"{type(error).__name__}: {error}; this should not happen, please report it", is_lasting=False)


@contextmanager
def workers(*, scheduler: str | None = None, n_workers: int | None = None) -> Iterator[Workers]:
    """Workers, for the time of a block.

    Parameters
    ----------
    scheduler
        Address of a running Dask scheduler, such as ``"tcp://10.0.0.7:8786"``; ``HERE`` for this process alone; None: workers of
        this computer, which end with the block.
    n_workers
        Processes on this computer; one per processor where none is named.

    Raises
    ------
    ArchiveError
        If Dask is not installed, or no scheduler answers.
    """
    if scheduler == HERE:
        yield _Here()
        return
    try:
        import dask
        from distributed import Client, LocalCluster
    except ModuleNotFoundError as error:
        raise ArchiveError(
            f"many workers need {error.name}; install it with pip install 'irtiming[campaign]', or give --scheduler {HERE}"
        ) from error
    with dask.config.set(_SETTINGS):
        if scheduler is None:
            count = n_workers or len(os.sched_getaffinity(0))
            with ExitStack() as ended:
                with held_signals() as held:  # a cluster that is half started cannot be ended without a traceback
                    cluster = LocalCluster(
                        n_workers=count,
                        threads_per_worker=1,
                        dashboard_address="127.0.0.1:0",
                        silence_logs=logging.CRITICAL,
                    )
                    client = ended.enter_context(Client(ended.enter_context(cluster)))
                held.tell()
                client.wait_for_workers(count)
                yield _Dask(client)
            return
        try:
            client = Client(scheduler, timeout="15s")
        except (OSError, ValueError, TimeoutError) as error:
            raise ArchiveError(
                f"no Dask scheduler answers at {scheduler} ({type(error).__name__}); start one with dask scheduler, or leave "
                "--scheduler out for workers of this computer"
            ) from error
        with client:
            yield _Dask(client)

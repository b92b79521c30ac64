"""Workers of this computer: what stops the command waits until they can be ended."""

import signal

import distributed
import pytest

from irtiming.archive.held_signals import held_signals
from irtiming.distribute.workers import workers


class _Ended:
    """Stands for a cluster or a client: writes down that it was ended."""

    def __init__(self, ended):
        self._ended = ended

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._ended.append(type(self).__name__)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_cluster_that_is_being_started_is_ended_and_not_left_half(monkeypatch, signals_as_before, number):
    """Oracle: by hand; a signal that comes while the cluster starts reaches its handler when cluster and client are there."""
    ended, heard = [], []

    class Cluster(_Ended):
        def __init__(self, **_):
            super().__init__(ended)
            signal.raise_signal(number)
            assert heard == []

    class Client(_Ended):
        def __init__(self, _):
            super().__init__(ended)

    monkeypatch.setattr(distributed, "LocalCluster", Cluster)
    monkeypatch.setattr(distributed, "Client", Client)
    signal.signal(number, lambda which, _: heard.append(which))
    with pytest.raises(KeyboardInterrupt), workers(n_workers=1):
        raise AssertionError("no work may begin")
    assert (heard, ended) == ([number], ["Client", "Cluster"])


def test_ctrl_c_does_not_reach_the_workers():
    """Oracle: the system; a terminal gives it to each process of a command, and both pieces of work come to their end."""
    with workers(n_workers=1) as pool:
        found = dict(pool.each(signal.raise_signal, {"first": signal.SIGINT, "second": signal.SIGINT}))
    assert found == {"first": None, "second": None}


def test_signals_that_nobody_hears_are_not_held(signals_as_before):
    """Oracle: by hand; a shell's job in the background ignores Ctrl-C, and goes on ignoring it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with held_signals() as held:
        signal.raise_signal(signal.SIGINT)
    held.tell()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN

"""Pieces that run at a time."""

import threading

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from irtiming.inference import in_threads


def test_one_after_the_other_where_there_is_one_thread(monkeypatch):
    """Oracle: the thread that asks, and the order of the items."""
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert in_threads.mapped(lambda item: (item, threading.get_ident()), range(3)) == [
        (item, threading.get_ident()) for item in range(3)
    ]


def test_as_many_at_a_time_as_there_are_threads(monkeypatch):
    """Oracle: pieces that wait for each other, two by two, would wait for ever one by one."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    both = threading.Barrier(2)

    def waiting(item):
        both.wait(timeout=10)
        return item

    assert in_threads.mapped(waiting, range(4)) == [0, 1, 2, 3]


def test_linear_algebra_in_each_takes_one_thread_and_as_many_as_before_afterwards(monkeypatch):
    """Oracle: what the libraries themselves say; they are allowed two."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")

    def allowed(_):
        return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}

    with threadpool_limits(2, user_api="blas"):
        assert in_threads.mapped(allowed, range(2)) == [{1}, {1}]
        assert allowed(None) == {2}


@pytest.mark.parametrize("said", ["", "0", "many"])
def test_what_is_no_number_of_threads_leaves_all_processors(monkeypatch, said):
    """Oracle: by hand; of one processor there is one thread, the one that asks."""
    monkeypatch.setenv("OMP_NUM_THREADS", said)
    monkeypatch.setattr(in_threads.os, "cpu_count", lambda: 1)
    assert in_threads.mapped(lambda item: threading.get_ident(), [0]) == [threading.get_ident()]

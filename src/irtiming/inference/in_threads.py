"""Pieces of work that do not depend on each other, on all processors that the program may use: linear algebra in one of each."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from irtiming.inference.one_thread import one_thread

One = TypeVar("One")
Made = TypeVar("Made")


def mapped(function: Callable[[One], Made], items: Iterable[One]) -> list[Made]:
    """What a function makes of each item, in their order.

    Parameters
    ----------
    function
        Compiled loops and array functions in it let other threads run.
    items
        Any number. OMP_NUM_THREADS, which a cluster's worker has, says of how many there are at a time; else the processors do.
    """
    said = os.environ.get("OMP_NUM_THREADS", "")
    threads = int(said) if said.isdecimal() and int(said) else os.cpu_count() or 1
    if threads == 1:
        return list(map(function, items))
    with one_thread(), ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, items))

"""Small matrices in one thread: several would spend their time waiting for each other, most of all on a busy machine."""

from contextlib import AbstractContextManager
from functools import cache
from importlib import import_module
from typing import Any

from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[Any]:
    """Context in which linear algebra runs in one thread."""
    limit: AbstractContextManager[Any] = _controller().limit(limits=1, user_api="blas")
    return limit


@cache
def _controller() -> ThreadpoolController:
    """Looking for the libraries takes milliseconds; those that compiled loops call, which are SciPy's, must be there by then."""
    import_module("scipy.linalg.cython_blas")
    return ThreadpoolController()

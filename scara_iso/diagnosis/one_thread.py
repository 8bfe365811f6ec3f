"""Linear algebra on one thread, where matrices are small.

A second thread gains nothing on thirty readings and costs three times: it waits in a loop. The
program says so in its environment before numpy is there; in a notebook numpy may be there already.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import wraps
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Answer = TypeVar("Answer")


def on_one_thread(work: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """Return the function with one thread for its linear algebra; after it, as many as before."""

    @wraps(work)
    def alone(*args: Given.args, **options: Given.kwargs) -> Answer:
        with _one_thread():
            return work(*args, **options)

    return alone


def _one_thread() -> AbstractContextManager[object]:
    if os.environ.get("OPENBLAS_NUM_THREADS") == "1":
        return nullcontext()
    try:
        from threadpoolctl import threadpool_limits  # noqa: PLC0415 - not for the program
    except ImportError:  # slower without it, and no less right
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits

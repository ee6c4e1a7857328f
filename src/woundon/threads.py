"""One BLAS thread: the matrices here are so small that a second one slows them.

With two threads a nip takes twice as long on a quiet machine, five to twenty times on a busy one.
The command line and worker processes say so before NumPy loads (:func:`environment`); where woundon
is imported by others, who may want their threads, it is said for each solve (:func:`one_thread`);
OpenBLAS listens to the main thread only.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from threading import Lock
from typing import Any, TypeVar

__all__ = ["environment", "one_thread"]

Function = TypeVar("Function", bound=Callable[..., Any])
VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def environment() -> dict[str, str]:
    """Return the environment variables of a process that is to have one BLAS thread."""
    return dict.fromkeys(VARIABLES, "1")


def one_thread(solve: Function) -> Function:
    """Let a function have one BLAS thread as long as it runs; costs 10 us."""

    @wraps(solve)
    def limited(*args: Any, **options: Any) -> Any:
        if all(os.environ.get(name) == "1" for name in VARIABLES):
            return solve(*args, **options)
        with _LIMIT:
            return solve(*args, **options)

    return limited  # type: ignore[return-value]


class _Limit:
    """The limit of this process; the first to enter sets it, the last to leave takes it back."""

    def __init__(self) -> None:
        self._lock, self._inside = Lock(), 0
        self._controller: Any = None
        self._limiter: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if self._controller is None:  # finds the libraries: when they are loaded, and once
                from threadpoolctl import ThreadpoolController

                self._controller = ThreadpoolController()
            if self._inside == 0:
                # to set what is set already costs a small solve its twentieth part
                many = any(part.num_threads > 1 for part in self._controller.lib_controllers)
                self._limiter = self._controller.limit(limits=1, user_api="blas") if many else None
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and self._limiter is not None:
                self._limiter.restore_original_limits()


_LIMIT = _Limit()

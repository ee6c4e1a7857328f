"""Work done in processes of this machine, which end with the work, with Ctrl-C, or with us."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing.connection import wait
from typing import TypeVar

__all__ = ["in_processes"]

Item = TypeVar("Item")
Made = TypeVar("Made")


def in_processes(
    work: Callable[[Item], Made], items: Sequence[Item], workers: int
) -> Generator[Made]:
    """Yield what is made of each item as soon as it is, in any order.

    However this ends, no process is left behind: what is under way when an exception comes here,
    Ctrl-C too, is given up at once.

    Parameters
    ----------
    work : callable
        It and its results must pickle.
    items : sequence
        Begun in this order.
    workers : int
        Number of processes; with one, this process does the work.
    """
    workers = min(workers, len(items))
    if workers <= 1:
        yield from map(work, items)
        return
    # spawned workers load the program afresh: the same on every system
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=_start)
    try:
        for done in as_completed([pool.submit(work, item) for item in items]):
            yield done.result()
    except BaseException:
        for process in list((pool._processes or {}).values()):
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _start() -> None:
    """Leave Ctrl-C to the parent, and end when the parent is gone, even by kill -9."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            wait([parent.sentinel])
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()

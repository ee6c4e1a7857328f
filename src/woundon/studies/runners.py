"""Who solves the chunks: this process, a pool of processes, or a Dask cluster.

All three take chunks and yield blocks as they are done, in any order, and give the same numbers.
A worker that dies takes nothing with it: its chunks are solved by another.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import time
import types
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, Protocol

from ..errors import InvalidProblem
from .evaluate import Block, Chunk, solve_chunk
from .model import Model

__all__ = ["DaskRunner", "Here", "Pool", "Runner", "runner_for", "usable_cores"]

WORKER_SETTINGS = {
    # a second BLAS thread makes matrices of this size slower, and every core has its own worker
    "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
    # glibc keeps freed memory: to get each matrix of 129 nodes anew costs a tenth of a solve
    "MALLOC_MMAP_THRESHOLD_": "33554432", "MALLOC_TRIM_THRESHOLD_": "268435456",
    "MALLOC_TOP_PAD_": "67108864",
}  # fmt: skip
WORTH_A_POOL = 3.0  # seconds of work ahead; starting the workers costs about one
DIED = "the worker process died while it solved this chunk, twice"


class Runner(Protocol):
    """Solves chunks."""

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Iterator[Block]:
        """Yield every chunk's block as soon as it is done."""
        ...


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def runner_for(workers: int | None, scheduler: str | None) -> Runner:
    """Return who solves: ``scheduler``'s cluster, or ``workers`` processes (by default, cores).

    Raises
    ------
    InvalidProblem
        For a number of workers below one, or given together with a scheduler.
    """
    if scheduler is not None:
        if workers is not None:
            raise InvalidProblem([("workers", "has no meaning with a scheduler: it has its own")])
        return DaskRunner(scheduler)
    if workers is None:
        cores = usable_cores()
        return Here(then=Pool(cores)) if cores > 1 else Here()
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InvalidProblem([("workers", f"{workers!r} is out of range: must be >= 1")])
    return Pool(workers) if workers > 1 else Here()


class Here:
    """Solves in this process; hands over to a pool where enough work lies ahead to pay for it."""

    def __init__(self, then: Runner | None = None) -> None:
        self.then = then

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Iterator[Block]:
        """Yield every chunk's block as soon as it is done."""
        began = time.perf_counter()
        for done, chunk in enumerate(chunks):
            pace = (time.perf_counter() - began) / max(done, 1)
            if self.then is not None and pace * (len(chunks) - done) > WORTH_A_POOL:
                yield from self.then.solved(model, chunks[done:])
                return
            yield solve_chunk(model, chunk)


class Pool:
    """Solves in processes of this machine, one BLAS thread each."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Iterator[Block]:
        """Yield every chunk's block as soon as it is done."""
        todo = list(reversed(chunks))
        while todo:
            running: dict[Future[Block], Chunk] = {}
            try:
                with _processes(self.workers, model) as pool:
                    yield from _drained(pool, model, todo, running, 2 * self.workers)
            except BrokenProcessPool:
                yield from self._one_by_one(model, list(running.values()))

    def _one_by_one(self, model: Model, suspects: list[Chunk]) -> Iterator[Block]:
        """Solve what was under way when a worker died: the chunk that kills one now is to blame."""
        while suspects:
            try:
                with _processes(1, model) as pool:
                    while suspects:
                        block = pool.submit(solve_chunk, model, suspects[-1]).result()
                        suspects.pop()
                        yield block
            except BrokenProcessPool:
                yield Block.failed(suspects.pop(), len(model.outputs), DIED)


def _drained(
    pool: Any, model: Model, todo: list[Chunk], running: dict[Future[Block], Chunk], ahead: int
) -> Iterator[Block]:
    """Keep ``ahead`` chunks submitted until none is left; ``running`` are those not yet yielded."""
    while todo or running:
        while todo and len(running) < ahead:
            chunk = todo.pop()
            try:
                running[pool.submit(solve_chunk, model, chunk)] = chunk
            except BrokenProcessPool:
                todo.append(chunk)
                raise
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            block = future.result()
            del running[future]
            yield block


@contextmanager
def _processes(workers: int, model: Model) -> Iterator[ProcessPoolExecutor]:
    """Provide a pool of fresh processes; on leaving, running chunks end and queued ones do not."""
    import multiprocessing

    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=_start_worker)
    try:
        with _worker_settings(), _without_main(model):
            # all processes of a pool that spawns start with the first task
            first = pool.submit(usable_cores)
        try:
            first.result()
        except BrokenProcessPool as fault:
            raise RuntimeError("worker processes do not start here; use workers=1") from fault
        yield pool
    finally:
        _shut_down(pool)


def _shut_down(pool: ProcessPoolExecutor) -> None:
    processes = list((pool._processes or {}).values())
    try:
        pool.shutdown(wait=True, cancel_futures=True)
    except KeyboardInterrupt:
        # a second Ctrl-C: the chunks being solved are given up
        for process in processes:
            process.kill()
        raise


def _start_worker() -> None:
    """Leave Ctrl-C to the parent, and end when the parent is gone, even by kill -9."""
    import multiprocessing
    from multiprocessing.connection import wait as wait_for

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            wait_for([parent.sentinel])
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _worker_settings() -> Iterator[None]:
    """Start processes within under these settings, which must be there before NumPy loads."""
    kept = {name: os.environ.get(name) for name in WORKER_SETTINGS}
    os.environ.update(WORKER_SETTINGS)
    try:
        yield
    finally:
        for name, value in kept.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _without_main(model: Model) -> Iterator[None]:
    """Keep workers from running the user's script again, unless the model is defined in it.

    A spawned process imports the main script, so that a study in a script without the guard
    ``if __name__ == "__main__"`` would start itself over and over.
    """
    main = sys.modules["__main__"]
    if b"__main__" in pickle.dumps(model):
        yield
        return
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


class DaskRunner:
    """Solves on a Dask cluster by its scheduler's address; Dask replaces workers that die."""

    def __init__(self, address: str, timeout: float = 10.0) -> None:
        self.address, self.timeout = address, timeout

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Iterator[Block]:
        """Yield every chunk's block as soon as it is done."""
        try:
            from distributed import Client, KilledWorker
        except ImportError:
            raise InvalidProblem(
                [("scheduler", "needs Dask: pip install 'woundon[dask]'")]
            ) from None
        try:
            client = Client(self.address, timeout=self.timeout, set_as_default=False)
        except (OSError, ValueError) as fault:
            raise InvalidProblem(
                [("scheduler", f"{self.address!r} cannot be reached: {fault}")]
            ) from None
        with client, client.get_executor(pure=False) as pool:
            todo, running = list(reversed(chunks)), dict[Future[Block], Chunk]()
            while todo or running:
                ahead = 4 * max(1, sum(client.nthreads().values()))
                try:
                    yield from _checked(_drained(pool, model, todo, running, ahead))
                except KilledWorker:
                    # Dask gives a task up when several workers died over it
                    for future in [f for f in running if f.done() and f.exception() is not None]:
                        yield Block.failed(running.pop(future), len(model.outputs), DIED)


def _checked(blocks: Iterator[Block]) -> Iterator[Block]:
    """Refuse blocks of workers that run another version of the program."""
    from .. import __version__

    for block in blocks:
        if block.version != __version__:
            raise InvalidProblem(
                [("scheduler", f"workers run woundon {block.version}, not {__version__}")]
            )
        yield block

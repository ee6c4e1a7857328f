"""Runners, which solve chunks: in this process, in a pool of processes, or on a Dask cluster.

They yield blocks in order of completion, with the same numbers.  If a worker dies, another one
solves its chunk.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import closing
from functools import partial
from typing import Protocol

from ..errors import InvalidProblem
from ..parallel import in_processes, stoppable, usable_cores
from .evaluate import Block, Chunk, solve_chunk
from .model import Model

__all__ = ["DaskRunner", "Pool", "Runner", "SerialRunner", "number_of_workers", "runner_for"]

WORTH_A_POOL = 3.0  # seconds of remaining work; starting the workers takes about one
FINISHING = "finishing the chunks under way; press Ctrl-C again to stop at once"
DIED = "the worker process died while it solved this chunk, twice"


class Runner(Protocol):
    """Solves chunks."""

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Generator[Block, None, None]:
        """Yield every chunk's block as soon as it is done."""
        ...


def runner_for(workers: int | None, scheduler: str | None) -> Runner:
    """Return the runner: the cluster of a scheduler, or ``workers`` processes.

    Raises
    ------
    InvalidProblem
        For a number of workers below one, or given together with a scheduler.

    Examples
    --------
    >>> type(runner_for(1, None)).__name__
    'SerialRunner'
    """
    if scheduler is not None:
        if workers is not None:
            raise InvalidProblem.at(
                "workers", "cannot be combined with a scheduler, which has its own workers"
            )
        return DaskRunner(scheduler)
    count = number_of_workers(workers)
    if count == 1:
        return SerialRunner()
    return SerialRunner(then=Pool(count)) if workers is None else Pool(count)


def number_of_workers(workers: int | None) -> int:
    """Return the number of processes: ``workers``, or by default the number of usable cores.

    Raises
    ------
    InvalidProblem
        For a number below one.
    """
    if workers is None:
        return usable_cores()
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InvalidProblem.at("workers", f"{workers!r} is out of range: must be >= 1")
    return workers


class SerialRunner:
    """Solves in this process; continues with another runner if much work remains."""

    def __init__(self, then: Runner | None = None) -> None:
        self.then = then

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Generator[Block, None, None]:
        """Yield every chunk's block as soon as it is done."""
        began, done = time.perf_counter(), 0
        with stoppable(FINISHING) as stopped:
            while done < len(chunks) and not stopped():
                pace = (time.perf_counter() - began) / max(done, 1)
                if self.then is not None and pace * (len(chunks) - done) > WORTH_A_POOL:
                    break
                yield solve_chunk(model, chunks[done])
                done += 1
        if self.then is not None and done < len(chunks):
            yield from self.then.solved(model, chunks[done:])


class Pool:
    """Solves in processes of this machine, with one BLAS thread each."""

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Generator[Block, None, None]:
        """Yield every chunk's block as soon as it is done."""

        def died(chunk: Chunk) -> Block:
            return Block.failed(chunk, len(model.outputs), DIED)

        work = partial(solve_chunk, model)
        with closing(
            in_processes(work, chunks, self.workers, finishing=FINISHING, died=died)
        ) as results:
            for _, block in results:
                yield block


class DaskRunner:
    """Solves on the Dask cluster of a scheduler; Dask replaces workers that die."""

    def __init__(self, address: str, timeout: float = 10.0) -> None:
        self.address, self.timeout = address, timeout

    def solved(self, model: Model, chunks: Sequence[Chunk]) -> Generator[Block, None, None]:
        """Yield every chunk's block as soon as it is done."""
        try:
            from distributed import Client, KilledWorker
        except ImportError:
            raise InvalidProblem.at(
                "scheduler", "needs Dask: pip install 'woundon[dask]'"
            ) from None
        try:
            client = Client(self.address, timeout=self.timeout, set_as_default=False)
        except (OSError, ValueError) as fault:
            raise InvalidProblem.at(
                "scheduler", f"{self.address!r} cannot be reached: {fault}"
            ) from None
        todo, running = deque(chunks), dict[Future[Block], Chunk]()
        limit = 4 * max(1, sum(client.nthreads().values()))
        with stoppable(FINISHING) as stopped, client, client.get_executor(pure=False) as pool:
            while running or (todo and not stopped()):
                while todo and len(running) < limit and not stopped():
                    chunk = todo.popleft()
                    running[pool.submit(solve_chunk, model, chunk)] = chunk
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    chunk = running.pop(future)
                    try:
                        yield _check_version(future.result())
                    except KilledWorker:  # several workers died while they solved this chunk
                        yield Block.failed(chunk, len(model.outputs), DIED)


def _check_version(block: Block) -> Block:
    """Reject blocks of workers with another version of the program."""
    from .. import __version__

    if block.version != __version__:
        raise InvalidProblem.at(
            "scheduler", f"workers run woundon {block.version}, not {__version__}"
        )
    return block

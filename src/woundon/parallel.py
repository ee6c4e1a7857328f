"""BLAS threads, processes of this machine, progress and cancellation.

    one_thread(solve)                       a solver with one BLAS thread
    in_processes(work, items, workers)      yields (item, work(item)) as they are done
    Worker().submit(work, item)             a process that works at one item at a time
    progress(fraction)                      called by long work; raises Cancelled when that is asked
    terminations_as_interrupts()            SIGTERM and SIGHUP end a command as Ctrl-C does

A worker is a loky executor of joblib with a single process: it is known which item a process died
over, and one that is stopped does not affect the others.  Work that is defined in a script is
pickled by value; the script itself is not imported, so that it needs no main guard.

>>> progress(0.5)  # outside of a worker, or if its work was not cancelled
>>> usable_cores() >= 1
True
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import types
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from functools import cache, wraps
from typing import TYPE_CHECKING, Any, TypeVar, TypeVarTuple

# the command line imports this module before anything else: what takes time is imported where used
if TYPE_CHECKING:
    from concurrent.futures import Future

__all__ = [
    "Cancelled",
    "Worker",
    "WorkerDied",
    "environment",
    "in_processes",
    "one_thread",
    "progress",
    "stoppable",
    "terminations_as_interrupts",
    "usable_cores",
]

Function = TypeVar("Function", bound=Callable[..., Any])
Item = TypeVar("Item")
Answer = TypeVar("Answer")
Args = TypeVarTuple("Args")

# ---- BLAS threads -------------------------------------------------------------------------------

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
# NumPy's own settings, so that those of the user do not change an answer.  Underflow to zero is
# right: exp(-x) of far layers, short waves and long relaxation times is added to larger terms.
FLOATING_POINT_ERRORS = {"divide": "warn", "over": "warn", "invalid": "warn", "under": "ignore"}


def environment() -> dict[str, str]:
    """Return the environment variables of a process that is to have one BLAS thread."""
    return dict.fromkeys(VARIABLES, "1")


# glibc maps blocks above this size each time again.  Freeing a mapped block raises the limit to its
# size, at most 32 MB, and keeps twice as much freed memory in the process (mallopt(3)).
LARGEST_BLOCK = 30 << 20


@cache
def keep_freed_memory() -> None:
    """Let glibc reuse the memory of freed matrices: mapping them again doubles the time of a nip.

    The block is never written to, so that it takes no memory.
    """
    import numpy as np

    np.empty(LARGEST_BLOCK, dtype=np.uint8)


def one_thread(solve: Function) -> Function:
    """Let a function have one BLAS thread and NumPy's own settings of floating point errors.

    Freed memory is reused.  The call costs 10 us.

    The matrices are so small that a second thread slows them: by a factor of 2 on an idle machine,
    of 5 to 20 on a busy one.  The command line and the workers set this by :func:`environment`
    before NumPy loads; OpenBLAS obeys a limit in the main thread only.
    """

    @wraps(solve)
    def limited(*args: Any, **options: Any) -> Any:
        """Call the solver with these settings."""
        from numpy import errstate

        keep_freed_memory()
        limit: Any = _LIMIT
        if all(os.environ.get(name) == "1" for name in VARIABLES):
            limit = nullcontext()
        with limit, errstate(**FLOATING_POINT_ERRORS):  # type: ignore[arg-type]
            return solve(*args, **options)

    return limited  # type: ignore[return-value]


class _Limit:
    """One BLAS thread in this process: the first to enter sets it, the last to leave removes it."""

    def __init__(self) -> None:
        self._lock, self._inside = threading.Lock(), 0
        self._controller: Any = None
        self._limiter: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if self._controller is None:  # searches the loaded libraries, once
                from threadpoolctl import ThreadpoolController

                self._controller = ThreadpoolController()
            if self._inside == 0:
                # setting a limit that is already set would cost a small solve 5 % of its time
                many = any(part.num_threads > 1 for part in self._controller.lib_controllers)
                self._limiter = self._controller.limit(limits=1, user_api="blas") if many else None
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and self._limiter is not None:
                self._limiter.restore_original_limits()


_LIMIT = _Limit()

# ---- in a worker --------------------------------------------------------------------------------

_flag = ""  # the file whose existence cancels the work of this process; "" outside of workers


class Cancelled(BaseException):
    """The result of this work is not needed any more.

    Not an ``Exception``, so that no handler of a solver's errors catches it.
    """


def progress(fraction: float) -> None:
    """Report that a fraction of the work is done.

    Raises
    ------
    Cancelled
        If this process is a worker whose work was cancelled.
    """
    if _flag and os.path.exists(_flag):
        raise Cancelled


def _prepare(flag: str, parent: Any, prepare: Callable[[], Any] | None) -> None:
    """Prepare a worker: ignore the signals that its parent handles, and end with the parent.

    Parameters
    ----------
    flag : str
        Path of the file whose existence cancels the work.
    parent : multiprocessing.Connection
        End of a pipe whose other end only the parent has.
    prepare : callable or None
        Of the :class:`Worker`.
    """
    global _flag
    _flag = flag
    for number in INTERRUPTS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    if prepare is not None:
        prepare()


def _end_with(parent: Any) -> None:
    """End this process when its parent has ended, even by kill -9, which closes the pipe."""
    with suppress(EOFError, OSError):
        parent.recv()
    os._exit(1)


# ---- signals that end a command ----------------------------------------------------------------

# sent by "kill", by batch systems and service managers, and when a terminal closes; Windows has
# no SIGHUP
TERMINATIONS = {getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)}
INTERRUPTS = {signal.SIGINT, *TERMINATIONS}


@contextmanager
def terminations_as_interrupts() -> Iterator[list[int]]:
    """Let SIGTERM and SIGHUP do what Ctrl-C does; provide the list of those that arrive.

    A signal that is ignored, as SIGHUP under nohup, or that has a handler, is left alone.
    """
    arrived: list[int] = []

    def interrupt(number: int, frame: types.FrameType | None) -> None:
        """Call the present handler of Ctrl-C."""
        arrived.append(number)
        handler = signal.getsignal(signal.SIGINT)
        if not callable(handler):  # Ctrl-C is ignored, as in the background of a shell
            handler = signal.default_int_handler
        handler(number, frame)

    in_main_thread = threading.current_thread() is threading.main_thread()
    caught = [
        number
        for number in TERMINATIONS
        if in_main_thread and signal.getsignal(number) is signal.SIG_DFL
    ]
    for number in caught:
        signal.signal(number, interrupt)
    try:
        yield arrived
    finally:
        for number in caught:
            signal.signal(number, signal.SIG_DFL)


# ---- workers ------------------------------------------------------------------------------------


WRITER_ENDS = 10.0  # longest time in which a thread that writes to a killed process ends [s]


class WorkerDied(RuntimeError):
    """Two processes died during the same item."""


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Worker:
    """A process that works at one item at a time.

    It starts with its first item; if it has died or was killed, the next item starts another.

    Parameters
    ----------
    prepare : callable, optional
        Is called in the process before its first item.
    """

    def __init__(self, prepare: Callable[[], object] | None = None) -> None:
        from pathlib import Path
        from tempfile import gettempdir

        self.prepare = prepare
        self._flag = Path(gettempdir()) / f"woundon-{os.urandom(16).hex()}"
        self._executor: Any = None
        self._last: Future[Any] | None = None
        self._changing = threading.Lock()  # while a process is started or killed

    def submit(self, work: Callable[[*Args], Answer], *args: *Args) -> Future[Answer]:
        """Start ``work(*args)`` in the process, which must be idle.

        The future raises ``BrokenExecutor`` if the process dies, another ``RuntimeError`` if it is
        killed.
        """
        with _interrupts_deferred(), self._changing:
            self._flag.unlink(missing_ok=True)  # of a cancellation of the item before
            future = self._last = self._submit(work, *args)
        return future

    def _submit(self, work: Callable[..., Answer], *args: Any) -> Future[Answer]:
        """Submit work to the process; start a new one if there is none."""
        from concurrent.futures import BrokenExecutor

        if self._executor is not None:
            with suppress(BrokenExecutor):
                if not _has_died(self._executor):
                    return self._executor.submit(work, *args)
            _end(self._executor)  # its process died while it was idle
        from joblib.externals.loky import ProcessPoolExecutor

        # a process that has grown ends between two tasks, and the next task starts another one
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        self._executor = ProcessPoolExecutor(
            1,
            env=environment(),
            initializer=_prepare,
            initargs=(str(self._flag), _parent_pipe()[0], self.prepare),
        )
        return self._executor.submit(work, *args)

    def cancel(self) -> None:
        """Let the next call of :func:`progress` in a living process raise ``Cancelled``."""
        if self._executor is not None:  # nobody would remove the file of a worker that is killed
            self._flag.touch()

    def kill(self) -> None:
        """Kill the process and wait for its end; if it is being started, kill it afterwards."""
        with self._changing:
            executor, self._executor = self._executor, None
            if executor is not None:
                # loky's thread fails on an item that it has not taken from its queue yet
                while self._last is not None and not (self._last.running() or self._last.done()):
                    time.sleep(0.001)
                _end(executor)
            self._flag.unlink(missing_ok=True)


def _has_died(executor: Any) -> bool:
    """Return whether a process of an executor has ended, which its thread may not know yet."""
    from multiprocessing.connection import wait

    return bool(wait([process.sentinel for process in [*executor._processes.values()]], timeout=0))


def _end(executor: Any) -> None:
    """Kill the process of an executor and wait for the ends of its threads.

    Loky waits for one of them only.  The other, which writes to the process, removes semaphores
    when it ends; a command that ends meanwhile would complain about leaked ones.  A write to the
    killed process fails as soon as nobody can read it; this process holds the last reading end.
    """
    queue = executor._call_queue
    writer = queue._thread
    executor.shutdown(kill_workers=True)
    if writer is not None:
        queue.close()  # again, in case that the other thread has failed before it did so
        queue._reader.close()
        writer.join(WRITER_ENDS)  # a copy of this process (fork) could also read


@cache
def _parent_pipe() -> tuple[Any, Any]:
    """Return a pipe whose second end is open in this process only, as long as it lives."""
    from multiprocessing import Pipe

    return Pipe(duplex=False)


@contextmanager
def _interrupts_deferred() -> Iterator[None]:
    """Let Ctrl-C neither reach a process that is being started nor leave the pool half changed.

    A process that was not killed would keep this one from ending, which waits for its children.
    Processes inherit the mask of signals until they ignore Ctrl-C.  In this process the signal may
    arrive in another thread in spite of the mask: its handler is called at the end.  Windows has no
    masks: there Ctrl-C during the start ends a worker, as it ends the parent.
    """
    arrived: list[tuple[int, types.FrameType | None]] = []
    handler = signal.getsignal(signal.SIGINT)
    in_main_thread = threading.current_thread() is threading.main_thread()
    defers = in_main_thread and callable(handler)
    if defers:
        signal.signal(signal.SIGINT, lambda *arguments: arrived.append(arguments))
    try:
        with _interrupts_masked():
            yield
    finally:
        if defers:
            signal.signal(signal.SIGINT, handler)
        for arguments in arrived:
            handler = signal.getsignal(signal.SIGINT)  # the first call may have changed it
            if callable(handler):
                handler(*arguments)


@contextmanager
def _interrupts_masked() -> Iterator[None]:
    """Mask Ctrl-C, SIGTERM and SIGHUP in this thread and in the processes that it starts."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from joblib.externals.loky.backend import resource_tracker

    mask = signal.pthread_sigmask(signal.SIG_BLOCK, TERMINATIONS)
    try:
        # the tracker ignores Ctrl-C and SIGTERM, and inherits the mask of SIGHUP; its start would
        # lift the mask of Ctrl-C and SIGTERM
        resource_tracker.ensure_running()
        signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def in_processes(
    work: Callable[[Item], Answer],
    items: Sequence[Item],
    workers: int,
    *,
    finishing: str = "",
    died: Callable[[Item], Answer] | None = None,
) -> Generator[tuple[Item, Answer], None, None]:
    """Yield every item with ``work(item)`` as soon as it is done.

    All workers are stopped at the end, also after an exception.  When called within a worker, the
    items are computed by that worker itself.

    Parameters
    ----------
    work : callable
        It is pickled, as are items and answers.
    items : sequence
    workers : int
        Number of processes.
    finishing : str, optional
        Message at the first Ctrl-C, after which the work in progress is finished and yielded; the
        second one stops at once, as the first does without this.
    died : callable, optional
        Item -> answer for an item during which two processes died.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C.
    WorkerDied
        If two processes died during an item and ``died`` is not given.
    Exception
        An exception of ``work``, with the traceback of the worker as its cause.
    """
    from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, wait

    if _flag:
        yield from ((item, work(item)) for item in items)
        return
    todo = deque(range(len(items)))
    suspects = set[int]()  # items during which a process has died once
    crew = [Worker() for _ in range(min(workers, len(items)))]
    idle = list(crew)
    busy: dict[Future[Answer], tuple[int, Worker]] = {}
    with stoppable(finishing) as stopped:

        def hand_out() -> None:
            """Submit waiting items to idle workers."""
            while todo and idle and not stopped():
                number, worker = todo.popleft(), idle.pop()
                busy[worker.submit(work, items[number])] = number, worker

        try:
            hand_out()
            while busy:
                future = wait(busy, return_when=FIRST_COMPLETED).done.pop()
                number, worker = busy.pop(future)
                idle.append(worker)
                fault = future.exception()
                dead = isinstance(fault, BrokenExecutor)
                if retry := dead and number not in suspects:
                    suspects.add(number)
                    todo.appendleft(number)
                hand_out()  # before the answer is used: no worker waits for that
                if retry:
                    continue
                if not dead:
                    yield items[number], future.result()
                elif died is not None:
                    yield items[number], died(items[number])
                else:
                    raise WorkerDied("two worker processes died during this item") from fault
        finally:
            with _interrupts_deferred():
                for worker in crew:
                    worker.kill()


@contextmanager
def stoppable(finishing: str) -> Iterator[Callable[[], bool]]:
    """Provide a function that returns whether Ctrl-C was pressed, which prints ``finishing``.

    After Ctrl-C, KeyboardInterrupt is raised on leaving, or when it is pressed again.  Without
    ``finishing``, outside the main thread, or where another handler listens to Ctrl-C, nothing is
    changed.
    """
    pressed: list[int] = []

    def note(number: int, frame: types.FrameType | None) -> None:
        """Count Ctrl-C; the next one, or another signal, raises KeyboardInterrupt."""
        if number != signal.SIGINT:  # a termination passed on: it does not wait for the work
            signal.default_int_handler(number, frame)
        pressed.append(number)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with suppress(RuntimeError):  # pressed while this stream was being written to
            print(finishing, file=sys.stderr, flush=True)

    in_main_thread = threading.current_thread() is threading.main_thread()
    if not (
        finishing
        and in_main_thread
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if pressed:
        raise KeyboardInterrupt

"""Work on items by processes of this machine, whatever happens to them.

    in_processes(work, items, workers)          yields (item, work(item)) as they are done

Every process has a pipe of its own and one item at a time, so that it is known which item a process
died over.  A process that is spawned imports the main script, and a study in a script without
``if __name__ == "__main__"`` would start itself over and over: these do so only where something
they need is defined in it.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import types
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from multiprocessing import connection, resource_tracker
from multiprocessing.reduction import ForkingPickler
from traceback import format_exc
from typing import Any, TypeVar

from ..threads import environment

__all__ = ["WorkerDied", "in_processes", "started", "stoppable"]

Item = TypeVar("Item")
Answer = TypeVar("Answer")
WORKER_SETTINGS = {
    **environment(),
    # glibc keeps freed memory: to get each matrix of 129 nodes anew costs a tenth of a solve
    "MALLOC_MMAP_THRESHOLD_": "33554432", "MALLOC_TRIM_THRESHOLD_": "268435456",
    "MALLOC_TOP_PAD_": "67108864",
}  # fmt: skip
NO_START = "worker processes do not start here; use workers=1"
NO_GUARD = ", or write if __name__ == '__main__': before what the script does with its definitions"


class WorkerDied(RuntimeError):
    """Two processes died over an item."""


def in_processes(
    work: Callable[[Item], Answer], items: Sequence[Item], workers: int, *, finishing: str = "",
    died: Callable[[Item], Answer] | None = None,
) -> Generator[tuple[Item, Answer], None, None]:  # fmt: skip
    """Yield every item with ``work(item)`` as soon as it is done.

    However it ends, no process is left.  Within a worker of another pool that worker does it all.

    Parameters
    ----------
    work : callable
        Of a module, or a partial of one; like items and answers it goes through pickle.
    items : sequence
    workers : int
        Number of processes.
    finishing : str, optional
        What to say at the first Ctrl-C, after which what is under way is finished and yielded; the
        second one stops at once, as the first does without this.
    died : callable, optional
        Item -> answer where two processes died over it.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C.
    WorkerDied
        If two processes died over an item and there is no ``died``.
    RuntimeError
        If processes do not start.
    Exception
        What ``work`` raises, with the worker's traceback as a note.
    """
    this = multiprocessing.current_process()
    if getattr(this, "_inheriting", False):  # a worker that runs a script without a guard
        sys.exit(1)
    if this.daemon:
        yield from ((item, work(item)) for item in items)
        return
    todo, suspects = deque(range(len(items))), set[int]()
    script = b"__main__" in pickle.dumps((work, items))
    with stoppable(finishing) as stopped, closing(_Crew(work, script)) as crew:
        crew.hire(min(workers, len(items)))

        def hand_out() -> None:
            while todo and crew.idle and not stopped():
                number = todo.popleft()
                crew.give(number, items[number])

        hand_out()
        while crew.busy:
            number, fault, answer = crew.next_done()
            retry = isinstance(fault, WorkerDied) and number not in suspects
            if retry:
                suspects.add(number)
                todo.appendleft(number)
            hand_out()  # before the answer is looked at: nobody waits
            if retry:
                continue
            if isinstance(fault, WorkerDied) and died is not None:
                fault, answer = None, died(items[number])
            if fault is not None:
                raise fault
            yield items[number], answer


class _Crew:
    """Processes that wait at their pipes, and those with an item: pipe -> its number.

    ``script`` tells whether they need something that is defined in the main script.
    """

    def __init__(self, work: Callable[[Any], Any], script: bool) -> None:
        self.work, self.script, self.processes = work, script, list[Any]()
        self.idle, self.busy = list[Any](), dict[Any, int]()

    def hire(self, count: int) -> None:
        """Start processes, all at once."""
        for _, pipe in started(self.work, count, self.processes, self.script):
            self.idle.append(pipe)

    def give(self, number: int, item: Any) -> None:
        """Send an item to a process that waits."""
        pipe = self.idle.pop()
        self.busy[pipe] = number
        with suppress(OSError):  # it died while it waited: the pipe's end will tell
            pipe.send(item)

    def next_done(self) -> tuple[int, BaseException | None, Any]:
        """Wait; return number, fault and answer.  Who died is replaced."""
        pipe: Any = connection.wait(list(self.busy))[0]
        number = self.busy.pop(pipe)
        try:
            fault, answer = pipe.recv()
        except (EOFError, OSError):
            self.hire(1)
            return number, WorkerDied("two worker processes died over this item"), None
        self.idle.append(pipe)
        return number, fault, answer

    def close(self) -> None:
        """End all processes, whatever they do."""
        for process in self.processes:
            if process.pid is not None:
                process.kill()
                process.join()


def started(
    work: Callable[[Any], Any], count: int, known: list[Any], script: bool = False
) -> list[tuple[Any, Any]]:
    """Start processes, all at once; return each with its pipe: send an item, receive the answer.

    Parameters
    ----------
    work : callable
        As of :func:`in_processes`; what comes through the pipe is (fault or None, answer).
    count : int
    known : list
        Takes the processes up before they start: whoever holds it can end them.
    script : bool
        Whether they need something that is defined in the main script.

    Raises
    ------
    RuntimeError
        If they do not start.
    """
    spawn, made = multiprocessing.get_context("spawn"), list[tuple[Any, Any]]()
    with _shielded(script):
        for _ in range(count):
            ours, theirs = spawn.Pipe()
            # a daemon: ended with this process even where nobody ends it
            process = spawn.Process(target=_serve, args=(theirs, work), daemon=True)
            known.append(process)
            process.start()
            theirs.close()
            made.append((process, ours))
    for _, pipe in made:
        try:
            pipe.recv()
        except (EOFError, OSError):
            raise RuntimeError(NO_START + NO_GUARD * script) from None
    return made


def _serve(pipe: Any, work: Callable[[Any], Any]) -> None:
    """Answer what comes through the pipe, until nobody is at its other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        pipe.send("ready")
        while True:
            item = pipe.recv()
            try:
                message = ForkingPickler.dumps((None, work(item)))
            except Exception as fault:
                fault.add_note(f"In a worker process:\n{format_exc()}")
                message = ForkingPickler.dumps((fault, None))
            sys.stdout.flush()
            pipe.send_bytes(message)


def _end_with_parent() -> None:
    """End this process when its parent is gone, even by kill -9."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


@contextmanager
def stoppable(finishing: str) -> Iterator[Callable[[], bool]]:
    """Provide whether Ctrl-C was pressed, which says ``finishing``; the second one interrupts.

    On leaving the KeyboardInterrupt is raised.  Without ``finishing``, outside the main thread, or
    where somebody else listens to Ctrl-C, that is left as it is.
    """
    pressed: list[int] = []

    def note(number: int, frame: types.FrameType | None) -> None:
        pressed.append(number)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with suppress(RuntimeError):  # pressed while this stream was being written to
            print(finishing, file=sys.stderr, flush=True)

    here = threading.current_thread() is threading.main_thread()
    if not (finishing and here and signal.getsignal(signal.SIGINT) is signal.default_int_handler):
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if pressed:
        raise KeyboardInterrupt


@contextmanager
def _shielded(script: bool) -> Iterator[None]:
    """Start processes within: one BLAS thread each, without the script, deaf to Ctrl-C."""
    main, kept = sys.modules["__main__"], {k: os.environ.get(k) for k in WORKER_SETTINGS}
    mask = hasattr(signal, "pthread_sigmask")  # on Windows they turn deaf when they have started
    if mask:
        resource_tracker.ensure_running()  # to start it within would lift the mask
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        # NumPy and the C library read these when they are loaded
        os.environ.update(WORKER_SETTINGS)
        sys.modules["__main__"] = main if script else types.ModuleType("__main__")
        yield
    finally:
        sys.modules["__main__"] = main
        for name, value in kept.items():
            del os.environ[name]
            os.environ.update({} if value is None else {name: value})
        if mask:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

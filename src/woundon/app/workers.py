"""A bounded number of worker processes that answer requests; whatever happens to one, others go on.

    pool.run(call, *given, key=(session, what))     the answer, in the order of rank and arrival

Of one key the newest request wins: an older one that waits is dropped, one under way has a moment
to come to its end, for else a busy machine would never end any, and is then interrupted.  A worker
that does not heed that, or dies, is replaced.
"""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import count
from typing import Any

from ..studies.processes import started
from .refusals import Refusal, refusal_of

__all__ = ["Pool"]

MEMORY = 4 * 2**30  # of a worker's address space [bytes]
GRACE = 1.0  # seconds that work under way may go on when a newer request has come
HEED = 5.0  # seconds until a worker that is interrupted must have heeded
URGE = 0.1  # seconds from one signal to the next: one before the work has begun is not heard
DIED = "the process that worked at this died; it has been replaced, send the request again"
_STARTING = threading.Lock()
_ON_SIGNAL = hasattr(signal, "SIGUSR1")


# ---- in the worker ----------------------------------------------------------------------------


class _Interrupted(BaseException):
    """The parent wants no answer any more."""


_working = False
_stopped = False  # libraries make faults of their own of what interrupts their callbacks


def _interrupt(number: int, frame: Any) -> None:
    global _stopped
    if _working:
        _stopped = True
        raise _Interrupted


def _prepare(nice: int, warm_up: Callable[[], Any]) -> None:
    """Get a new worker ready: polite, bounded, with everything imported."""
    if _ON_SIGNAL:
        signal.signal(signal.SIGUSR1, _interrupt)
    if hasattr(os, "nice"):
        os.nice(nice)
    with suppress(ImportError, ValueError, OSError):  # not on every system
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    warm_up()


def _work(item: tuple[Callable[..., Any], tuple[Any, ...]]) -> tuple[str, Any]:
    """Return what became of a request: ("done", answer), ("refused", why), ..."""
    global _stopped, _working
    call, given = item
    _stopped = False
    try:
        try:
            _working = True
            return "done", call(*given)
        finally:
            _working = False
    except _Interrupted:
        _working = False  # it may have come before this was said
        return "interrupted", None
    except Exception as fault:
        if _stopped:
            return "interrupted", None
        refusal = refusal_of(fault)
        if refusal is None:
            traceback.print_exc(file=sys.stderr)
            return "failed", f"{type(fault).__name__} in the server"
        return "refused", refusal


# ---- in the server ----------------------------------------------------------------------------


@dataclass(eq=False)
class _Worker:
    process: Any
    pipe: Any
    session: Hashable = None
    stopping: bool = False

    def exchange(self, item: Any) -> tuple[str, Any]:
        """Send a request and wait for its answer; in a thread."""
        try:
            self.pipe.send(item)
            _, answer = self.pipe.recv()
        except (EOFError, OSError):
            return "died", None
        return answer


@dataclass(eq=False)
class _Request:
    call: Callable[..., Any]
    given: tuple[Any, ...]
    key: Hashable
    session: Hashable
    answer: asyncio.Future[Any]
    worker: _Worker | None = None


class Pool:
    """Worker processes and the requests that wait for them.

    Parameters
    ----------
    size : int
        Number of processes.
    warm_up : callable
        What a new process does first: imports.
    waiting : int
        How many requests may wait; beyond, one is refused.
    seconds : float
        How long one may be worked at.
    nice : int
        How much the processes stand back behind others of the machine.
    """

    def __init__(
        self, size: int, warm_up: Callable[[], Any], *, waiting: int = 64, seconds: float = 60.0,
        nice: int = 0,
    ) -> None:  # fmt: skip
        self.size, self.warm_up, self.most, self.seconds, self.nice = (
            size, warm_up, waiting, seconds, nice,
        )  # fmt: skip
        self._processes: list[Any] = []
        self._idle: list[_Worker] = []
        self._waiting: list[tuple[int, int, _Request]] = []
        self._newest: dict[Hashable, _Request] = {}
        self._under_way = set[Hashable]()
        self._number = count()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._closing = False
        # a thread for each pipe, and those in which processes are started
        self._threads = ThreadPoolExecutor(2 * size, "woundon-pipe")

    async def open(self) -> None:
        """Start the processes."""
        await self._hire(self.size)

    def close(self) -> None:
        """End the processes, whatever they do."""
        self._closing = True
        for process in self._processes:
            if process.pid is not None:
                process.kill()
        for task in self._tasks:
            task.cancel()
        self._threads.shutdown(wait=False)

    async def run(
        self, call: Callable[..., Any], *given: Any, key: Hashable = None, session: Hashable = None,
        rank: int = 0, seconds: float | None = None,
    ) -> Any:  # fmt: skip
        """Return ``call(*given)`` of a worker.

        Parameters
        ----------
        call : callable
            Of a module; like what is given and returned it goes through pickle.
        key : hashable, optional
            Of requests with the same key the newest wins.
        session : hashable, optional
            Goes to the worker that this session's last request went to, if that is idle.
        rank : int
            Lower ones first.
        seconds : float, optional
            In place of the pool's.

        Raises
        ------
        Refusal
            Whatever is wrong with the request, or became of it.
        """
        if key is not None and (older := self._newest.get(key)) is not None:
            self._overtake(older)
        if len(self._waiting) >= self.most:
            raise Refusal(503, "busy", "too many requests are waiting; try again")
        answer = asyncio.get_running_loop().create_future()
        request = _Request(call, given, key, session, answer)
        if key is not None:
            self._newest[key] = request
        heappush(self._waiting, (rank, next(self._number), request))
        self._hand_out()
        late = asyncio.get_running_loop().call_later(
            seconds or self.seconds, self._too_slow, request, seconds or self.seconds
        )
        try:
            return await request.answer
        finally:
            late.cancel()
            if self._newest.get(key) is request:
                del self._newest[key]
            if not request.answer.done() or request.answer.cancelled():
                self._interrupt(request)  # who asked is gone

    def _overtake(self, request: _Request) -> None:
        if request.worker is not None:
            asyncio.get_running_loop().call_later(GRACE, self._drop, request)
            return
        self._drop(request)
        self._waiting = [one for one in self._waiting if not one[2].answer.done()]
        heapify(self._waiting)

    def _drop(self, request: _Request) -> None:
        if not request.answer.done():
            text = "a newer request of the same session took its place"
            request.answer.set_exception(Refusal(409, "superseded", text))
        self._interrupt(request)

    def _interrupt(self, request: _Request) -> None:
        """Take a worker off a request, kindly at first."""
        worker = request.worker
        if worker is None or worker.stopping:
            return
        worker.stopping = True
        patience = HEED if _ON_SIGNAL else 0.0
        self._urge(worker, request, asyncio.get_running_loop().time() + patience)

    def _urge(self, worker: _Worker, request: _Request, until: float) -> None:
        if request.worker is not worker:
            return
        loop = asyncio.get_running_loop()
        if loop.time() >= until:
            worker.process.kill()
            return
        with suppress(ProcessLookupError, OSError):
            os.kill(worker.process.pid, signal.SIGUSR1)
        loop.call_later(URGE, self._urge, worker, request, until)

    def _hand_out(self) -> None:
        for dead in [w for w in self._idle if not w.process.is_alive()]:
            self._idle.remove(dead)
            self._start(self._replace(dead))
        held = list[tuple[int, int, _Request]]()
        while self._idle and self._waiting:
            rank, number, request = heappop(self._waiting)
            if request.answer.done():
                continue
            if request.key in self._under_way:  # nobody has two workers
                held.append((rank, number, request))
                continue
            own = (w for w in self._idle if request.session and w.session == request.session)
            worker = next(own, self._idle[0])
            self._idle.remove(worker)
            worker.session, request.worker = request.session, worker
            self._under_way |= {request.key} - {None}
            self._start(self._worked(worker, request))
        for one in held:
            heappush(self._waiting, one)

    def _start(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _worked(self, worker: _Worker, request: _Request) -> None:
        outcome, answer = await self._in_thread(worker.exchange, (request.call, request.given))
        request.worker, worker.stopping = None, False
        self._under_way.discard(request.key)
        if outcome == "died":
            self._start(self._replace(worker))
        else:
            self._idle.append(worker)
        if not request.answer.done():
            _settle(request.answer, outcome, answer)
        self._hand_out()

    def _too_slow(self, request: _Request, seconds: float) -> None:
        if not request.answer.done():
            text = f"it took longer than {seconds:g} s, which a request may take"
            request.answer.set_exception(Refusal(504, "too-slow", text))
        self._interrupt(request)

    async def _replace(self, dead: _Worker) -> None:
        self._processes.remove(dead.process)
        dead.pipe.close()
        dead.process.join(1)
        await self._hire(1)

    async def _hire(self, number: int) -> None:
        """Start processes; each joins those that are idle when it is ready."""
        if self._closing:
            return
        made = await self._in_thread(_started, number, self._processes)
        await asyncio.gather(*(self._welcome(_Worker(*parts)) for parts in made))

    async def _welcome(self, worker: _Worker) -> None:
        await self._in_thread(worker.exchange, (_prepare, (self.nice, self.warm_up)))
        self._idle.append(worker)
        self._hand_out()

    async def _in_thread(self, call: Callable[..., Any], *given: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._threads, call, *given)


def _started(number: int, known: list[Any]) -> list[tuple[Any, Any]]:
    with _STARTING:  # what is changed while they start is the whole process's
        return started(_work, number, known)


def _settle(future: asyncio.Future[Any], outcome: str, answer: Any) -> None:
    """Tell who asked what became of a request."""
    if outcome == "done":
        future.set_result(answer)
    elif outcome == "refused":
        future.set_exception(answer)
    elif outcome == "died":
        future.set_exception(Refusal(503, "worker-died", DIED))
    else:
        future.set_exception(Refusal(500, "failed", answer or "interrupted"))

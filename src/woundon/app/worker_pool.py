"""Requests in worker processes of :mod:`woundon.parallel`.

    answer = await pool.run(call, *args, key=(session, name))

Requests are served in the order of rank and arrival.  Of requests with one key the newest wins: an
older one that waits is dropped; one in progress may go on for :data:`GRACE`, since a busy machine
would finish none otherwise, and is then cancelled (:func:`woundon.parallel.progress`).  A worker
that does not end then, that dies, or that holds much memory after a request is replaced.
"""

from __future__ import annotations

import asyncio
import os
import sys
import traceback
from collections.abc import Callable, Hashable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from heapq import heapify, heappop, heappush
from itertools import count
from typing import Any, NamedTuple

import psutil

from ..parallel import Cancelled, Worker
from .request_errors import RequestError, request_error_of

__all__ = ["Pool"]

MEMORY = 4 * 2**30  # of a worker's address space [bytes]
# Resident memory after a request from which a worker is replaced [bytes]: it has 100 MB when it
# starts and at most 200 MB after requests with the default settings.
RELEASE = 300 * 2**20
GRACE = 1.0  # seconds that work in progress may go on when a newer request has come
PATIENCE = 3.0  # seconds until cancelled work must have ended; then its process is killed
DIED = "the worker process of this request died; it has been replaced, send the request again"


# ---- in the worker ----------------------------------------------------------------------------


def _prepare(nice: int, warm_up: Callable[[], Any]) -> None:
    """Prepare a new worker: low priority, bounded memory, everything imported.

    Windows has neither priorities of this kind nor a limit of the address space.
    """
    if hasattr(os, "nice"):
        os.nice(nice)
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    warm_up()


def _ready() -> None:
    """Return when the worker is prepared."""


class _Outcome(NamedTuple):
    status: str  # "done", "rejected", "failed", "cancelled", "died"
    answer: Any = None
    memory: int = 0  # resident memory of the process after the request [bytes]


def _work(call: Callable[..., Any], args: tuple[Any, ...]) -> _Outcome:
    """Return the outcome of a request."""
    status, answer = _answer(call, args)
    return _Outcome(status, answer, psutil.Process().memory_info().rss)


def _answer(call: Callable[..., Any], args: tuple[Any, ...]) -> tuple[str, Any]:
    """Compute the answer to a request in a worker."""
    try:
        return "done", call(*args)
    except Cancelled:
        return "cancelled", None
    except Exception as fault:
        error = request_error_of(fault)
        if error is None:
            traceback.print_exc(file=sys.stderr)
            return "failed", f"{type(fault).__name__} in the server"
        return "rejected", error


# ---- in the server ----------------------------------------------------------------------------


@dataclass(eq=False)
class _Slot:
    """A worker, and the session that it last worked for."""

    worker: Worker
    session: Hashable = None
    stopping: bool = False

    async def exchange(self, call: Callable[..., Any], *args: Any) -> _Outcome:
        """Send work and wait for its outcome; a process that died is replaced."""
        try:
            # a new process takes some 0.1 s to start
            future = await asyncio.to_thread(self.worker.submit, _work, call, args)
            if self.stopping:  # it was cancelled before the process had it
                self.worker.cancel()
            return await asyncio.wrap_future(future)
        except Exception:  # exceptions of the work itself are outcomes
            return _Outcome("died")


@dataclass(eq=False)
class _Request:
    call: Callable[..., Any]
    args: tuple[Any, ...]
    key: Hashable
    session: Hashable
    answer: asyncio.Future[Any]
    slot: _Slot | None = None


class Pool:
    """Worker processes and the requests that wait for them.

    Parameters
    ----------
    size : int
        Number of processes.
    warm_up : callable
        Is called in a new process before its first request.
    waiting : int
        Number of requests that may wait; more are rejected.
    seconds : float
        Time limit of a request.
    nice : int
        Increment of the processes' niceness.
    """

    def __init__(
        self,
        size: int,
        warm_up: Callable[[], Any],
        *,
        waiting: int = 64,
        seconds: float = 60.0,
        nice: int = 0,
    ) -> None:
        self.size, self.most, self.seconds = size, waiting, seconds
        self._slots = [_Slot(Worker(partial(_prepare, nice, warm_up))) for _ in range(size)]
        self._idle: list[_Slot] = []
        self._waiting: list[tuple[int, int, _Request]] = []
        self._newest: dict[Hashable, _Request] = {}
        self._active: dict[Hashable, _Request] = {}  # in progress and not cancelled, by key
        self._number = count()
        self._tasks: set[asyncio.Task[Any]] = set()

    async def open(self) -> None:
        """Start the processes."""
        await asyncio.gather(*map(self._start_worker, self._slots))

    def close(self) -> None:
        """End the processes."""
        for task in self._tasks:
            task.cancel()
        for slot in self._slots:
            slot.worker.kill()

    async def run(
        self,
        call: Callable[..., Any],
        *args: Any,
        key: Hashable = None,
        session: Hashable = None,
        rank: int = 0,
        seconds: float | None = None,
    ) -> Any:
        """Return ``call(*args)`` of a worker.

        Parameters
        ----------
        call : callable
            Is pickled, as are its arguments and its result.
        key : hashable, optional
            Of requests with the same key the newest wins.
        session : hashable, optional
            The worker of this session's last request is preferred if it is idle.
        rank : int
            Lower ones first.
        seconds : float, optional
            Time limit; by default the pool's.

        Raises
        ------
        RequestError
            If the request is invalid, superseded, too slow, or its worker died.
        """
        if key is not None and (older := self._newest.get(key)) is not None:
            self._supersede(older)
        if len(self._waiting) >= self.most:
            raise RequestError(503, "busy", "too many requests are waiting; try again")
        answer = asyncio.get_running_loop().create_future()
        request = _Request(call, args, key, session, answer)
        if key is not None:
            self._newest[key] = request
        heappush(self._waiting, (rank, next(self._number), request))
        self._assign()
        timeout = asyncio.get_running_loop().call_later(
            seconds or self.seconds, self._time_out, request, seconds or self.seconds
        )
        try:
            return await request.answer
        finally:
            timeout.cancel()
            if self._newest.get(key) is request:
                del self._newest[key]
            if not request.answer.done() or request.answer.cancelled():
                self._cancel(request)  # the client has disconnected

    def _supersede(self, request: _Request) -> None:
        """Cancel an older request with the same key."""
        if request.slot is not None:
            asyncio.get_running_loop().call_later(GRACE, self._drop, request)
            return
        self._drop(request)
        self._waiting = [entry for entry in self._waiting if not entry[2].answer.done()]
        heapify(self._waiting)

    def _drop(self, request: _Request) -> None:
        """Reject a request that a newer one replaces."""
        if not request.answer.done():
            text = "a newer request of the same session took its place"
            request.answer.set_exception(RequestError(409, "superseded", text))
        self._cancel(request)

    def _cancel(self, request: _Request) -> None:
        """Cancel the work at a request; kill its process if it does not end."""
        slot = request.slot
        if slot is None or slot.stopping:
            return
        slot.stopping = True
        self._deactivate(request)
        self._assign()  # the next request of its key need not wait for the end of the work
        asyncio.get_running_loop().call_later(PATIENCE, self._kill, request, slot)
        slot.worker.cancel()

    def _deactivate(self, request: _Request) -> None:
        if self._active.get(request.key) is request:
            del self._active[request.key]

    def _kill(self, request: _Request, slot: _Slot) -> None:
        if request.slot is slot:
            self._create_task(asyncio.to_thread(slot.worker.kill))

    def _assign(self) -> None:
        """Assign waiting requests to idle workers."""
        postponed = list[tuple[int, int, _Request]]()
        while self._idle and self._waiting:
            rank, number, request = heappop(self._waiting)
            if request.answer.done():
                continue
            if request.key in self._active:  # one at a time of each key
                postponed.append((rank, number, request))
                continue
            preferred = (s for s in self._idle if request.session and s.session == request.session)
            slot = next(preferred, self._idle[0])
            self._idle.remove(slot)
            slot.session, request.slot = request.session, slot
            if request.key is not None:
                self._active[request.key] = request
            self._create_task(self._serve(slot, request))
        for entry in postponed:
            heappush(self._waiting, entry)

    def _create_task(self, work: Any) -> None:
        """Start a task and keep a reference to it, which asyncio does not."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _serve(self, slot: _Slot, request: _Request) -> None:
        """Run a request in a worker and set its result."""
        outcome = await slot.exchange(request.call, *request.args)
        request.slot, slot.stopping = None, False
        self._deactivate(request)
        if not request.answer.done():
            _settle(request.answer, outcome)
        if outcome.memory > RELEASE:  # the allocator and caches keep it as long as the process runs
            await asyncio.to_thread(slot.worker.kill)
        if outcome.status == "died" or outcome.memory > RELEASE:
            await self._start_worker(slot)
        else:
            self._idle.append(slot)
            self._assign()

    def _time_out(self, request: _Request, seconds: float) -> None:
        """Reject a request that takes too long."""
        if not request.answer.done():
            text = f"the request took longer than the limit of {seconds:g} s"
            request.answer.set_exception(RequestError(504, "too-slow", text))
        self._cancel(request)

    async def _start_worker(self, slot: _Slot) -> None:
        """Prepare a new process; it joins those that are idle when it is ready."""
        await slot.exchange(_ready)
        self._idle.append(slot)
        self._assign()


def _settle(future: asyncio.Future[Any], outcome: _Outcome) -> None:
    """Set the result of a request's future."""
    if outcome.status == "done":
        future.set_result(outcome.answer)
    elif outcome.status == "rejected":
        future.set_exception(outcome.answer)
    elif outcome.status == "died":
        future.set_exception(RequestError(503, "worker-died", DIED))
    else:
        future.set_exception(RequestError(500, "failed", outcome.answer or "cancelled"))

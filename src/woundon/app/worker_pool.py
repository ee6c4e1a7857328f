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
from bisect import insort
from collections.abc import Callable, Coroutine, Hashable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

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
SUPERSEDED = "a newer request of the same session took its place"


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
    """Do nothing: the answer to this first request shows that the worker is prepared."""


def _work(call: Callable[..., Any], args: tuple[Any, ...]) -> tuple[Any, int]:
    """Return the answer to a request, or its error, and this process's resident memory [bytes]."""
    try:
        answer = call(*args)
    except Cancelled:
        answer = RequestError(500, "failed", "cancelled")  # nobody waits for it
    except Exception as fault:
        answer = request_error_of(fault)
    return answer, psutil.Process().memory_info().rss


# ---- in the server ----------------------------------------------------------------------------


@dataclass(eq=False)
class _Request:
    """A request that waits, or that a worker works at."""

    call: Callable[..., Any]
    args: tuple[Any, ...]
    key: Hashable
    session: Hashable
    rank: int
    answer: asyncio.Future[Any]


@dataclass(eq=False)
class _Slot:
    """A worker, its request, and the session that it last worked for."""

    worker: Worker
    request: _Request | None = None
    session: Hashable = None
    is_stopping: bool = False

    async def exchange(self, call: Callable[..., Any], *args: Any) -> tuple[Any, int]:
        """Send work to the worker; return the answer or error, and the memory of the worker.

        The memory is in bytes, and 0 if the worker died.
        """
        try:
            # a new process takes some 0.1 s to start
            future = await asyncio.to_thread(self.worker.submit, _work, call, args)
            if self.is_stopping:  # it was cancelled before the process had it
                self.worker.cancel()
            answer: tuple[Any, int] = await asyncio.wrap_future(future)
            return answer
        except Exception:  # exceptions of the work itself are answers
            return RequestError(503, "worker-died", DIED), 0


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
        self._idle: list[_Slot] = []  # the longest idle first
        self._waiting: list[_Request] = []  # in the order of rank and arrival
        self._newest: dict[Hashable, _Request] = {}  # by key
        self._tasks: set[asyncio.Task[None]] = set()

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
    ) -> Any:
        """Return ``call(*args)`` of a worker.

        Parameters
        ----------
        call : callable
            Is pickled, as are its arguments and its result.
        key : hashable, optional
            Of requests with the same key the newest wins: an older one that waits is rejected, one
            in progress may go on for GRACE seconds, because a slow machine would otherwise finish
            none of a quick sequence.
        session : hashable, optional
            The worker of this session's last request is preferred if it is idle.
        rank : int
            Lower ones first.

        Raises
        ------
        RequestError
            If the request is invalid, superseded, too slow, or its worker died.
        """
        loop = asyncio.get_running_loop()
        if older := self._newest.get(key):  # requests without a key are not in it
            superseded = RequestError(409, "superseded", SUPERSEDED)
            if older in self._waiting:
                self._end(older, superseded)
            else:
                loop.call_later(GRACE, self._end, older, superseded)
        if len(self._waiting) >= self.most:
            raise RequestError(503, "busy", "too many requests are waiting; try again")
        request = _Request(call, args, key, session, rank, loop.create_future())
        if key is not None:
            self._newest[key] = request
        insort(self._waiting, request, key=lambda waiting: waiting.rank)
        self._assign()
        text = f"the request took longer than the limit of {self.seconds:g} s"
        too_slow = RequestError(504, "too-slow", text)
        timer = loop.call_later(self.seconds, self._end, request, too_slow)
        try:
            return await request.answer
        finally:
            timer.cancel()
            if self._newest.get(key) is request:
                del self._newest[key]
            # asyncio cancels this coroutine if the client disconnects: then nobody needs the answer
            self._end(request)

    def _assign(self) -> None:
        """Assign waiting requests to idle workers, in order, one at a time of each key.

        An idle worker that served the session of a request last is preferred, because its caches
        hold the results of this session; otherwise the one that has been idle longest is used.
        """
        active = {slot.request.key for slot in self._slots if slot.request and not slot.is_stopping}
        for request in tuple(self._waiting):
            if not self._idle:
                return
            if request.key is not None and request.key in active:
                continue
            of_session = (s for s in self._idle if request.session and s.session == request.session)
            slot = next(of_session, self._idle[0])
            self._idle.remove(slot)
            self._waiting.remove(request)
            slot.request, slot.session = request, request.session
            active.add(request.key)
            self._create_task(self._serve(slot, request))

    async def _serve(self, slot: _Slot, request: _Request) -> None:
        """Let a worker work at a request, and set its answer."""
        answer, memory = await slot.exchange(request.call, *request.args)  # 0 bytes if it died
        slot.request, slot.is_stopping = None, False
        if not request.answer.done():
            if isinstance(answer, RequestError):
                request.answer.set_exception(answer)
            else:
                request.answer.set_result(answer)
        if 0 < memory <= RELEASE:
            self._set_idle(slot)
        else:  # it died, or holds much memory, of caches and the allocator, until its process ends
            await asyncio.to_thread(slot.worker.kill)
            await self._start_worker(slot)

    async def _start_worker(self, slot: _Slot) -> None:
        """Prepare the process of a worker, which is then idle."""
        await slot.exchange(_ready)
        self._set_idle(slot)

    def _set_idle(self, slot: _Slot) -> None:
        """Let a worker serve the next request."""
        self._idle.append(slot)
        self._assign()

    def _end(self, request: _Request, error: RequestError | None = None) -> None:
        """Remove a request: stop the work at it, and reject it if there is an error.

        The worker is asked to stop, and killed if it still works after PATIENCE seconds.
        """
        if error is not None and not request.answer.done():
            request.answer.set_exception(error)
        if request in self._waiting:
            self._waiting.remove(request)
        for slot in self._slots:
            if slot.request is request and not slot.is_stopping:
                slot.is_stopping = True
                slot.worker.cancel()
                asyncio.get_running_loop().call_later(PATIENCE, self._kill, slot, request)
                self._assign()  # the next request of its key need not wait for the end of the work

    def _kill(self, slot: _Slot, request: _Request) -> None:
        """Kill the process of a worker that still works at a cancelled request."""
        if slot.request is request:
            self._create_task(asyncio.to_thread(slot.worker.kill))

    def _create_task(self, work: Coroutine[Any, Any, None]) -> None:
        """Start a task and keep a reference to it, which asyncio does not."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

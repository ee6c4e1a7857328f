"""A bounded number of worker processes that answer requests; whatever happens to one, others go on.

    pool.run(call, *given, key=(session, what))     the answer, in the order of rank and arrival

Of requests with one key the newest wins: an older one that waits is dropped, one in progress has a
moment to finish, for else a busy machine would never finish any, and is then cancelled
(:func:`woundon.parallel.progress`).  A worker that does not end then, or dies, is replaced.
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
from typing import Any

from ..parallel import Cancelled, Worker
from .refusals import Refusal, refusal_of

__all__ = ["Pool"]

MEMORY = 4 * 2**30  # of a worker's address space [bytes]
GRACE = 1.0  # seconds that work in progress may go on when a newer request has come
PATIENCE = 3.0  # seconds until cancelled work must have ended; then its process is killed
DIED = "the process that worked at this died; it has been replaced, send the request again"


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


def _work(call: Callable[..., Any], given: tuple[Any, ...]) -> tuple[str, Any]:
    """Return the outcome of a request: ("done", answer), ("refused", why), ..."""
    try:
        return "done", call(*given)
    except Cancelled:
        return "cancelled", None
    except Exception as fault:
        refusal = refusal_of(fault)
        if refusal is None:
            traceback.print_exc(file=sys.stderr)
            return "failed", f"{type(fault).__name__} in the server"
        return "refused", refusal


# ---- in the server ----------------------------------------------------------------------------


@dataclass(eq=False)
class _Seat:
    """A worker, and the session that it last worked for."""

    worker: Worker
    session: Hashable = None
    stopping: bool = False

    async def exchange(self, call: Callable[..., Any], *given: Any) -> tuple[str, Any]:
        """Send work and wait for its outcome; a process that died is replaced."""
        try:
            # a new process takes some 0.1 s to start
            future = await asyncio.to_thread(self.worker.submit, _work, call, given)
            if self.stopping:  # it was cancelled before the process had it
                self.worker.cancel()
            return await asyncio.wrap_future(future)
        except Exception:  # all exceptions of the work itself are outcomes
            return "died", None


@dataclass(eq=False)
class _Request:
    call: Callable[..., Any]
    given: tuple[Any, ...]
    key: Hashable
    session: Hashable
    answer: asyncio.Future[Any]
    seat: _Seat | None = None


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
        self.size, self.most, self.seconds = size, waiting, seconds
        self._seats = [_Seat(Worker(partial(_prepare, nice, warm_up))) for _ in range(size)]
        self._idle: list[_Seat] = []
        self._waiting: list[tuple[int, int, _Request]] = []
        self._newest: dict[Hashable, _Request] = {}
        self._under_way = set[Hashable]()
        self._number = count()
        self._tasks: set[asyncio.Task[Any]] = set()

    async def open(self) -> None:
        """Start the processes."""
        await asyncio.gather(*map(self._welcome, self._seats))

    def close(self) -> None:
        """End the processes, whatever they do."""
        for task in self._tasks:
            task.cancel()
        for seat in self._seats:
            seat.worker.kill()

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
                self._cancel(request)  # the client has disconnected

    def _overtake(self, request: _Request) -> None:
        if request.seat is not None:
            asyncio.get_running_loop().call_later(GRACE, self._drop, request)
            return
        self._drop(request)
        self._waiting = [one for one in self._waiting if not one[2].answer.done()]
        heapify(self._waiting)

    def _drop(self, request: _Request) -> None:
        if not request.answer.done():
            text = "a newer request of the same session took its place"
            request.answer.set_exception(Refusal(409, "superseded", text))
        self._cancel(request)

    def _cancel(self, request: _Request) -> None:
        """Cancel the work at a request; kill its process if it does not end."""
        seat = request.seat
        if seat is None or seat.stopping:
            return
        seat.stopping = True
        asyncio.get_running_loop().call_later(PATIENCE, self._kill, request, seat)
        seat.worker.cancel()

    def _kill(self, request: _Request, seat: _Seat) -> None:
        if request.seat is seat:
            self._start(asyncio.to_thread(seat.worker.kill))

    def _hand_out(self) -> None:
        held = list[tuple[int, int, _Request]]()
        while self._idle and self._waiting:
            rank, number, request = heappop(self._waiting)
            if request.answer.done():
                continue
            if request.key in self._under_way:  # nobody has two workers
                held.append((rank, number, request))
                continue
            own = (s for s in self._idle if request.session and s.session == request.session)
            seat = next(own, self._idle[0])
            self._idle.remove(seat)
            seat.session, request.seat = request.session, seat
            self._under_way |= {request.key} - {None}
            self._start(self._worked(seat, request))
        for one in held:
            heappush(self._waiting, one)

    def _start(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _worked(self, seat: _Seat, request: _Request) -> None:
        outcome, answer = await seat.exchange(request.call, *request.given)
        request.seat, seat.stopping = None, False
        self._under_way.discard(request.key)
        if not request.answer.done():
            _settle(request.answer, outcome, answer)
        if outcome == "died":
            await self._welcome(seat)
        else:
            self._idle.append(seat)
            self._hand_out()

    def _too_slow(self, request: _Request, seconds: float) -> None:
        if not request.answer.done():
            text = f"it took longer than {seconds:g} s, which a request may take"
            request.answer.set_exception(Refusal(504, "too-slow", text))
        self._cancel(request)

    async def _welcome(self, seat: _Seat) -> None:
        """Prepare a new process; it joins those that are idle when it is ready."""
        await seat.exchange(_ready)
        self._idle.append(seat)
        self._hand_out()


def _settle(future: asyncio.Future[Any], outcome: str, answer: Any) -> None:
    """Tell who asked what became of a request."""
    if outcome == "done":
        future.set_result(answer)
    elif outcome == "refused":
        future.set_exception(answer)
    elif outcome == "died":
        future.set_exception(Refusal(503, "worker-died", DIED))
    else:
        future.set_exception(Refusal(500, "failed", answer or "cancelled"))

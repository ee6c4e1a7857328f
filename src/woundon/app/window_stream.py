"""Operating windows of the page, computed in a thread; events are sent as a stream.

The windings are solved in processes of :mod:`woundon.parallel`; the thread waits for them.  It ends
when the window is cancelled or its client disconnects.
"""

from __future__ import annotations

import asyncio
import threading
import traceback
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from typing import Any

from ..errors import unwarned
from ..parallel import Cancelled, usable_cores
from ..studies.window import operating_window
from ..studies.window_result import OperatingPoint, OperatingWindow
from .computations import problem_of
from .json_texts import to_json
from .request_errors import RequestError, request_error_of

__all__ = ["events"]

POLL_SECONDS = 0.5  # between two checks whether the client is still connected
MOST_WORKERS = 4


async def events(
    request: Mapping[str, Any], is_disconnected: Callable[[], Awaitable[bool]]
) -> AsyncIterator[bytes]:
    """Yield the events of an operating window as they occur, one line of JSON each.

    Parameters
    ----------
    request : mapping
        As :class:`.request_models.WindowRequest`.
    is_disconnected : callable
        Whether the client has disconnected.
    """
    loop, queue, stopped = asyncio.get_running_loop(), asyncio.Queue[Any](), threading.Event()

    def send(event: Mapping[str, Any]) -> None:
        """Queue an event; stop the computation if the client has disconnected."""
        if stopped.is_set():
            raise Cancelled
        loop.call_soon_threadsafe(queue.put_nowait, event)

    threading.Thread(target=_compute, args=(request, send), daemon=True).start()
    try:
        while True:
            try:
                event = await asyncio.wait_for(queue.get(), POLL_SECONDS)
            except TimeoutError:
                if await is_disconnected():
                    return
                continue
            yield to_json(event) + b"\n"
            if event["event"] in ("done", "failed"):
                return
    finally:
        stopped.set()


def _compute(request: Mapping[str, Any], send: Callable[[Mapping[str, Any]], None]) -> None:
    """Compute the window in this thread and send its events."""
    try:
        try:
            with unwarned():
                window = operating_window(
                    problem_of(request["case"]),
                    request["web_tension"],
                    request["nip_load"],
                    request["torque_split"],
                    uncertain=request["uncertain"],
                    # at least two: a single one would solve in the server itself
                    workers=max(2, min(usable_cores(), MOST_WORKERS)),
                    progress=lambda done, expected: send(
                        {"event": "progress", "done": done, "of": expected}
                    ),
                    preview=lambda coarse: send({"event": "window"} | _content(coarse)),
                )
            send({"event": "window"} | _content(window))
            send({"event": "done"})
        except Exception as fault:
            error = request_error_of(fault)
            if error is None:
                traceback.print_exc()
                error = RequestError(500, "failed", f"{type(fault).__name__} in the server")
            send({"event": "failed", "detail": error.detail})
    except Cancelled:
        pass


def _content(window: OperatingWindow) -> dict[str, Any]:
    """Return a window for JSON, SI units; the map by rows of equal web tension.

    With a torque split its levels are innermost.  ``binding`` and ``dominant`` are numbers of
    margins and inputs, -1 if there is none.
    """
    return {
        "names": list(window.names),
        "axes": [axis.tolist() for axis in window.axes],
        "probability": window.probability.ravel().tolist(),
        "binding": window.binding.ravel().tolist(),
        "margins": list(window.margins),
        "dominant": window.dominant.ravel().tolist(),
        "inputs": list(window.uncertain),
        "best": _point(window.best),
        "errors": dict(window.errors),
        "windings": window.windings,
        "failed": len(window.failures),
        "is_coarse": window.is_coarse,
    }


def _point(point: OperatingPoint) -> dict[str, Any]:
    """Return a point of the window for JSON."""
    return {
        "values": dict(point.values),
        "probability": point.probability,
        "binding": point.binding,
        "contributions": dict(point.contributions),
    }

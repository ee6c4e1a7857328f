"""The server itself: where it listens, how long it waits for whom."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import socket
import threading
import types
from collections.abc import Iterable, Iterator
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from ..errors import InvalidProblem
from .middleware import LOOPBACK
from .routes import application

__all__ = ["LOOPBACK", "interrupts_counted", "listening", "serve"]

HEAD_SECONDS = 10.0  # for the head of a request to arrive
MOST_CONNECTIONS = 200
LONGEST_HEAD = 32_768  # bytes


class _TimeoutProtocol(H11Protocol):
    """HTTP/1.1 with a timeout for the head of a request."""

    _head_timeout: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Start the timeout for the head of the first request."""
        super().connection_made(transport)
        self._start_timeout()

    def data_received(self, data: bytes) -> None:
        """Process received data; start the timeout if the head of a request is incomplete."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:  # the head is complete
            self._cancel_timeout()
        elif self.conn.trailing_data[0]:  # bytes of an incomplete head
            self._start_timeout()

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the timeout."""
        self._cancel_timeout()
        super().connection_lost(exc)

    def _start_timeout(self) -> None:
        """Close the connection if the head of a request is not complete in time."""
        if self._head_timeout is None:
            loop = asyncio.get_running_loop()
            self._head_timeout = loop.call_later(HEAD_SECONDS, self.transport.close)

    def _cancel_timeout(self) -> None:
        """Cancel the time limit for the head of a request."""
        if self._head_timeout is not None:
            self._head_timeout.cancel()
            self._head_timeout = None


def listening(host: str, port: int) -> socket.socket:
    """Return a listening socket.

    Raises
    ------
    InvalidProblem
        If the port is in use, or the host is empty, which would mean all addresses of the machine.
    """
    if not host.strip():
        text = f"{host!r} is not an address; must be one, as 127.0.0.1, or 0.0.0.0 for all"
        raise InvalidProblem.at("host", text)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # with IPPROTO_TCP asyncio disables Nagle's algorithm, which delays a body by 40 ms
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except (OSError, OverflowError) as fault:
        listener.close()
        reason = getattr(fault, "strerror", None) or str(fault)
        text = f"cannot listen at {host}: {reason}; take another port with --port"
        raise InvalidProblem.at(f"port {port}", text) from None
    return listener


@contextlib.contextmanager
def interrupts_counted() -> Iterator[list[int]]:
    """Provide a list to which each Ctrl-C appends an item instead of raising an exception.

    An exception may be lost, for instance in a finaliser, and the server would continue to run.
    """
    pressed: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield pressed
        return
    handler = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, handler)


class _Server(uvicorn.Server):
    """A server that also stops if Ctrl-C was pressed before its start: if ``pressed`` has items."""

    pressed: list[int]

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start the server; stop it at once if Ctrl-C was pressed before."""
        await super().startup(sockets)
        self.should_exit |= bool(self.pressed)

    def handle_exit(self, sig: int, frame: types.FrameType | None) -> None:
        """Stop without a report for every request that is cancelled."""
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
        super().handle_exit(sig, frame)


def serve(
    listener: socket.socket, names: Iterable[str] = (), token: str = "", *, pressed: list[int]
) -> None:
    """Serve until Ctrl-C; stop at once if it was ``pressed`` before.

    Parameters
    ----------
    listener : socket
        Of :func:`listening`.
    names, token
        As of :func:`~.middleware.middleware`.
    pressed : list of int
        Of :func:`interrupts_counted`.
    """
    config = uvicorn.Config(
        application(names, token),
        http=_TimeoutProtocol,
        log_level="warning",
        access_log=False,
        server_header=False,
        limit_concurrency=MOST_CONNECTIONS,
        timeout_keep_alive=30,
        h11_max_incomplete_event_size=LONGEST_HEAD,
        timeout_graceful_shutdown=2,
        proxy_headers=False,
        ws="none",
    )
    server = _Server(config)
    server.pressed = pressed
    server.run(sockets=[listener])

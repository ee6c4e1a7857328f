"""The server itself: where it listens, how long it waits for whom."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import socket
import threading
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


class _Impatient(H11Protocol):
    """HTTP/1.1 that does not wait for ever for the head of a request."""

    _patience: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Wait for the first head."""
        super().connection_made(transport)
        self._wait_for_head()

    def data_received(self, data: bytes) -> None:
        """Take what has come; if that is a part of a head, wait for its rest."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._wait_no_more()
        elif self.conn.trailing_data[0]:
            self._wait_for_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._wait_no_more()
        super().connection_lost(exc)

    def _wait_for_head(self) -> None:
        if self._patience is None:
            loop = asyncio.get_running_loop()
            self._patience = loop.call_later(HEAD_SECONDS, self.transport.close)

    def _wait_no_more(self) -> None:
        if self._patience is not None:
            self._patience.cancel()
            self._patience = None


def listening(host: str, port: int) -> socket.socket:
    """Return a socket that listens.

    Raises
    ------
    InvalidProblem
        If it cannot, e.g. for a port that is taken, or if the host is empty: the operating system
        would take that for all addresses of the machine.
    """
    if not host.strip():
        text = f"{host!r} is not an address; must be one, as 127.0.0.1, or 0.0.0.0 for all"
        raise InvalidProblem.at("host", text)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # asyncio lets an answer's body follow its head at once (no Nagle, who would wait 40 ms for an
    # acknowledgement) on sockets that call themselves TCP
    made = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((host, port))
        made.listen(128)
    except (OSError, OverflowError) as fault:
        made.close()
        why = getattr(fault, "strerror", None) or str(fault)
        text = f"cannot listen at {host}: {why}; take another port with --port"
        raise InvalidProblem.at(f"port {port}", text) from None
    return made


@contextlib.contextmanager
def interrupts_counted() -> Iterator[list[int]]:
    """Give a list that gets an item for each Ctrl-C, which does nothing else meanwhile.

    As an exception it would be lost where Python cannot raise it, as in a finaliser: the server
    would go on for ever.
    """
    pressed: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield pressed
        return
    before = signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)


class _Server(uvicorn.Server):
    """A server that ends too if Ctrl-C was pressed while it was made."""

    pressed: list[int]

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to serve, though it be to end at once."""
        await super().startup(sockets)
        self.should_exit |= bool(self.pressed)


def serve(
    at: socket.socket, names: Iterable[str] = (), token: str = "", *, pressed: list[int]
) -> None:
    """Serve until Ctrl-C, and no longer than a moment if it was ``pressed`` before."""
    config = uvicorn.Config(
        application(names, token),
        http=_Impatient,
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
    server.run(sockets=[at])

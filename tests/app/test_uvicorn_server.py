"""How answers travel."""

import asyncio
import socket

from coroutines import run

from woundon.app.uvicorn_server import listening


def test_the_body_of_an_answer_follows_its_head_at_once():
    """Nagle's algorithm would wait for an acknowledgement, which comes after 40 ms."""

    async def delays() -> int:
        """Return the option TCP_NODELAY of a connection as uvicorn makes it."""
        loop, accepted = asyncio.get_running_loop(), asyncio.Queue()

        class Protocol(asyncio.Protocol):
            def connection_made(self, transport: asyncio.BaseTransport) -> None:
                accepted.put_nowait(transport)

        listener = listening("127.0.0.1", 0)
        server = await loop.create_server(Protocol, sock=listener)
        client = socket.create_connection(listener.getsockname())
        transport = await accepted.get()
        option = transport.get_extra_info("socket").getsockopt(
            socket.IPPROTO_TCP, socket.TCP_NODELAY
        )
        transport.close()
        client.close()
        server.close()
        return option

    assert run(delays()) != 0

"""The command ``woundon app``: open the interactive page in the browser."""

from __future__ import annotations

import contextlib
import sys

import click

from ..errors import InvalidProblem
from . import options

__all__ = ["app"]

PORT = 8321
MISSING = 'needs FastAPI and uvicorn: pip install "woundon[app]"'


@options.command(
    """\
    Open the interactive page in the browser.

    By default the server listens on this machine only. To serve other machines, choose another
    --host, give its public --name, and send users the address with the access token that is
    printed. Traffic is encrypted only by a reverse proxy in front of the server (see 'Run the
    server' in the documentation).
    """
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=PORT,
    show_default=True,
    help="Port to listen on; 0 selects a free one.",
)
@click.option("--no-browser", is_flag=True, help="Do not open the browser.")
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to listen on; any other than the loopback requires a token.",
)
@click.option(
    "--name",
    "names",
    multiple=True,
    metavar="NAME",
    help="Public host name (e.g. behind a proxy); repeatable.",
)
@click.option(
    "--token",
    default="",
    metavar="TOKEN",
    help="Access token; generated if omitted when serving other hosts.",
)
def app(port: int, no_browser: bool, host: str, names: tuple[str, ...], token: str) -> None:
    """Open the interactive page in the browser."""
    import secrets
    import threading
    import webbrowser

    try:
        from ..app.uvicorn_server import LOOPBACK, interrupts_counted, listening, serve
    except ImportError as fault:
        # the packages of the extra "app"; any other failure of an import is an error of the code
        if fault.name not in ("fastapi", "h11", "psutil", "starlette", "uvicorn"):
            raise
        raise InvalidProblem.at("woundon app", MISSING) from None
    serves_others = host not in LOOPBACK or bool(names)
    token = token or (secrets.token_urlsafe(24) if serves_others else "")
    with interrupts_counted() as pressed, contextlib.closing(listening(host, port)) as socket:
        address = _address(host, names, socket.getsockname()[1], token)
        click.echo(f"woundon is at {address}\nPress Ctrl-C to stop.")
        if serves_others:
            click.echo(
                "Users on other machines need the token. Traffic is not encrypted: outside a\n"
                "private network put a reverse proxy with TLS in front."
            )
        sys.stdout.flush()
        if not no_browser:  # a moment later, when the server answers
            threading.Timer(0.3, webbrowser.open, [address]).start()
        serve(socket, (host, *names), token, pressed=pressed)
    click.echo("stopped; open pages keep their cases until the server is started again", err=True)


def _address(host: str, names: tuple[str, ...], port: int, token: str) -> str:
    """Return the address of the page, at the first public name if there are any."""
    name = next(iter(names), host)
    name = f"[{name}]" if ":" in name else name  # IPv6
    return f"http://{name}:{port}/{f'?token={token}' if token else ''}"

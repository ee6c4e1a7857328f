"""``woundon app`` and ``woundon report``."""

from __future__ import annotations

import contextlib
import secrets
import sys
import threading
import webbrowser
from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem

__all__ = ["app", "report"]

PORT = 8321
NEEDED = 'needs FastAPI and uvicorn: pip install "woundon[app]"'


@click.command(
    help="""\
    Open the nip and the roll in the browser: they are solved while sliders move.

    The server listens to this machine alone.  To serve others, let it listen at another address,
    name the host name by which they call it, and send them the address with the token that is
    printed; traffic is not encrypted but by a reverse proxy in front of it (see 'How to serve
    others' in the documentation).
    """,
    short_help="Open the nip and the roll in the browser.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=PORT, show_default=True,
              help="Where to listen; 0 takes any that is free.")  # fmt: skip
@click.option("--no-browser", is_flag=True, help="Do not open the browser.")
@click.option("--host", default="127.0.0.1", show_default=True,
              help="Address to listen at; any but the loopback's asks for a token.")  # fmt: skip
@click.option("--name", "names", multiple=True, metavar="NAME",
              help="Host name by which others call, as behind a proxy; repeatable.")  # fmt: skip
@click.option("--token", default="", metavar="TOKEN",
              help="What callers must know; a new one where others are served.")  # fmt: skip
def app(port: int, no_browser: bool, host: str, names: tuple[str, ...], token: str) -> None:
    """Open the nip and the roll in the browser: they are solved while sliders move."""
    try:
        from ..app.uvicorn_server import LOOPBACK, interrupts_counted, listening, serve
    except ImportError as fault:
        if fault.name not in ("fastapi", "h11", "psutil", "starlette", "uvicorn"):
            raise
        raise InvalidProblem.at("woundon app", NEEDED) from None
    others = host not in LOOPBACK or bool(names)
    token = token or (secrets.token_urlsafe(24) if others else "")
    with interrupts_counted() as pressed, contextlib.closing(listening(host, port)) as socket:
        place = _address(host, names, socket.getsockname()[1], token)
        click.echo(f"woundon is at {place}\nCtrl-C ends it.")
        if others:
            click.echo(
                "Others are served who know the token. What they send is not encrypted: put a\n"
                "reverse proxy with TLS in front where the network is not your own."
            )
        sys.stdout.flush()
        if not no_browser:
            threading.Timer(0.3, webbrowser.open, [place]).start()
        serve(socket, (host, *names), token, pressed=pressed)


def _address(host: str, names: tuple[str, ...], port: int, token: str) -> str:
    name = next(iter(names), host)
    name = f"[{name}]" if ":" in name else name
    return f"http://{name}:{port}/{f'?token={token}' if token else ''}"


@click.command(
    help="""\
    Write a report of solved CASES: inputs, results with errors and certificate, figures.

    One HTML file that needs no other, and prints to PDF from any browser.  Several cases are
    compared with each other.
    """,
    short_help="Write a report of solved cases: one HTML file that prints well.",
)
@click.argument("cases", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="HTML file; by default CASE.html.")
@click.option("--set", "settings", multiple=True, metavar="FIELD=VALUE",
              help="Change a field of every case; repeatable.")  # fmt: skip
@click.option("--unit", "chosen", multiple=True, metavar="NAME=UNIT",
              help="Show a field or output in another unit; repeatable.")  # fmt: skip
@click.option("--title", default="", help="Title of the report.")
@click.option("--remarks", default="", help="Text of the remarks; else their room is left empty.")
def report(
    cases: tuple[Path, ...], out: Path | None, settings: tuple[str, ...], chosen: tuple[str, ...],
    title: str, remarks: str,
) -> None:  # fmt: skip
    """Write a report of solved CASES: inputs, results with errors and certificate, figures."""
    from .. import kinds
    from ..errors import unwarned
    from ..io.case_files import load_case
    from ..io.chosen_units import units_of
    from ..io.files import check_writable, write_whole
    from ..report.html_report import report_file

    problems = [_of(path, load_case, settings) for path in cases]
    out = out or cases[0].with_suffix(".html")
    if out.suffix not in (".html", ".htm"):
        text = f"the ending {out.suffix!r} is not that of a report; must be .html"
        raise InvalidProblem.at(str(out), text)
    check_writable(out)
    with unwarned(), units_of(chosen):
        results = [kinds.solve(problem) for problem in problems]
        labels = [path.stem for path in cases]
        page = report_file(results, labels, title=title, remarks=remarks,
                           sources=[path.name for path in cases])  # fmt: skip
    write_whole(out, page.encode())
    click.echo(f"{out} is written")


def _of(path: Path, load: Any, settings: tuple[str, ...]) -> Any:
    try:
        return load(path, settings)
    except InvalidProblem as fault:
        named = any(field == str(path) for field, _ in fault.faults)
        raise fault if named else fault.under(str(path)) from None

"""Who may ask, how much and how slowly: what stands before every request.

The server listens to this machine alone unless it is told otherwise, but every page of the world
that runs in a browser of this machine can send to it.  So a request is refused whose Host is not
ours (DNS rebinding), whose Origin is another page's, or that a browser calls cross-site; bodies are
bounded in size and time; where others are served, a token is asked for.
"""

from __future__ import annotations

import asyncio
import hmac
import re
from collections.abc import Awaitable, Callable, Iterable, Mapping, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

from pydantic_core import from_json
from starlette.requests import ClientDisconnect

from .catalogue import LIMITS
from .refusals import MEDIA, Refusal

__all__ = ["LOOPBACK", "Guard", "json_of", "whole_body"]

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
SCHEMES = ("http", "https")
SECONDS = 10.0  # for a body to arrive
COOKIE = "woundon-token"
MOST_QUERY_FIELDS = 50
# a name, an IPv4 address or an IPv6 address in brackets, then perhaps a port: no user, no path
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:\d{0,5})?", re.ASCII)

_PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": _PAGE,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[Any], Awaitable[None]]


class Guard:
    """Refuses what is not ours before the application sees it, and puts headers to every answer.

    Parameters
    ----------
    app : ASGI application
    names : iterable of str
        Host names by which the server may be called, beside those of the loopback.
    token : str
        What a request must carry, in a cookie, as ``Authorization: Bearer`` or, once, as
        ``?token=``; '' for none.
    """

    def __init__(self, app: Any, names: Iterable[str] = (), token: str = "") -> None:
        self.app, self.token = app, token
        self.names = LOOPBACK | {name.lower() for name in names if name}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            await send({"type": "websocket.close", "code": 1008})
            return
        headers = _headers_of(scope)
        try:
            self._check(scope, headers)
            given = self._check_token(scope, headers)
        except Refusal as refusal:
            await _refuse(refusal, self._dressed(send))
            return
        await self.app(scope, receive, self._dressed(send, given))

    def _check(self, scope: Scope, headers: Mapping[str, list[str]]) -> None:
        hosts = headers.get("host", [])
        if len(hosts) != 1 or _name_of(hosts[0]) not in self.names:
            told = ", ".join(hosts) or "none"
            text = f"Host {told[:80]!r} is not served here; start with --name to add one"
            raise Refusal(403, "refused", text)
        for origin in headers.get("origin", []):
            if origin.lower() not in (f"{scheme}://{hosts[0].lower()}" for scheme in SCHEMES):
                raise Refusal(403, "refused", f"Origin {origin[:80]!r} is another site's")
        site = headers.get("sec-fetch-site", ["none"])[-1]
        to_the_page = scope["path"] == "/" and headers.get("sec-fetch-mode") == ["navigate"]
        if site not in ("none", "same-origin") and not to_the_page:
            raise Refusal(403, "refused", "the request comes from another site")

    def _check_token(self, scope: Scope, headers: Mapping[str, list[str]]) -> str:
        """Return the cookie to set where a token came in the address."""
        if not self.token:
            return ""
        by_address = _query_of(scope).get("token", [""])[0]
        told = [v.removeprefix("Bearer ") for v in headers.get("authorization", [])]
        told += [_cookie(value) for value in headers.get("cookie", [])]
        if not any(self._is_token(one) for one in [by_address, *told]):
            text = "a token is needed: open the address that 'woundon app' printed"
            raise Refusal(401, "refused", text)
        if not self._is_token(by_address):
            return ""
        return f"{COOKIE}={self.token}; Path=/; HttpOnly; SameSite=Strict"

    def _is_token(self, told: str) -> bool:
        return hmac.compare_digest(told.encode(), self.token.encode())

    def _dressed(self, send: Send, cookie: str = "") -> Send:
        async def dressed(message: Any) -> None:
            if message["type"] == "http.response.start":
                own = {name for name, _ in message.get("headers", ())}
                extra = [(n.encode(), v.encode()) for n, v in _HEADERS.items()
                         if n.encode() not in own]  # fmt: skip
                extra += [(b"set-cookie", cookie.encode())] if cookie else []
                message = {**message, "headers": [*message.get("headers", ()), *extra]}
            await send(message)

        return dressed


def _headers_of(scope: Scope) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        found.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return found


def _query_of(scope: Scope) -> dict[str, list[str]]:
    """Return the fields of a request's query string.

    Raises
    ------
    Refusal
        For more fields than any request needs.
    """
    try:
        return parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=MOST_QUERY_FIELDS)
    except ValueError:
        text = f"the query has too many fields; must be at most {MOST_QUERY_FIELDS}"
        raise Refusal(400, "invalid", text) from None


def _name_of(host: str) -> str:
    """Return the name of a Host header without its port; '' for an invalid header."""
    match = _HOST.fullmatch(host.lower())
    return match[1].strip("[]") if match else ""


def _cookie(header: str) -> str:
    try:
        found = SimpleCookie(header).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""


async def _refuse(refusal: Refusal, send: Send) -> None:
    headers = [(b"content-type", MEDIA.encode()), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": refusal.status, "headers": headers})
    await send({"type": "http.response.body", "body": refusal.body()})


# ---- bodies -----------------------------------------------------------------------------------


async def whole_body(request: Any) -> bytes:
    """Return a request's body.

    Raises
    ------
    Refusal
        If it is larger than any case, arrives too slowly or incompletely, or is not called JSON:
        such bodies a browser sends to other sites without asking them.
    """
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":
        raise Refusal(415, "refused", f"Content-Type must be application/json, got {kind[:80]!r}")
    most, body = LIMITS["body_bytes"], bytearray()
    length = request.headers.get("content-length", "")
    if length.isdecimal() and int(length[:20]) > most:
        raise Refusal(413, "too-large", f"the body is larger than {most} bytes")
    try:
        async with asyncio.timeout(SECONDS):
            async for part in request.stream():
                body += part
                if len(body) > most:
                    raise Refusal(413, "too-large", f"the body is larger than {most} bytes")
    except TimeoutError:
        text = f"the body did not arrive within {SECONDS:g} s"
        raise Refusal(408, "too-slow", text) from None
    except ClientDisconnect:  # nobody reads this answer; raised further, it would be a traceback
        raise Refusal(400, "incomplete", "the connection was closed within the body") from None
    return bytes(body)


def json_of(body: bytes) -> Any:
    """Return what a body of JSON says; nan, infinity and deep nesting are none.

    Raises
    ------
    Refusal
    """
    try:
        return from_json(body, allow_inf_nan=False)
    except ValueError as fault:
        raise Refusal(400, "invalid", f"the body is not JSON: {str(fault)[:200]}") from None

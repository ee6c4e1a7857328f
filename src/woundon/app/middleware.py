"""Checks of every request (host, origin, token, size), and headers of every answer.

Every page of the world that runs in a browser of this machine can send requests to a server of
this machine.  Starlette rejects a Host that is not served (DNS rebinding), missing tokens and large
bodies.  It has no middleware that rejects requests of other sites: CORSMiddleware only permits them
to be read.  Hence :class:`SameOrigin`, and :class:`SecurityHeaders` for the answers.
"""

from __future__ import annotations

import hmac
from collections.abc import Iterable

from starlette.authentication import (
    AuthCredentials,
    AuthenticationBackend,
    AuthenticationError,
    SimpleUser,
)
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.authentication import AuthenticationMiddleware
from starlette.middleware.body_limit import RequestBodyLimitMiddleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from .limits import LIMITS
from .request_errors import RequestError

__all__ = ["COOKIE", "LOOPBACK", "middleware"]

LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
COOKIE = "woundon-token"
HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        "font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}


def middleware(names: Iterable[str], token: str) -> list[Middleware]:
    """Return the middleware of the application, the outermost first.

    Parameters
    ----------
    names : iterable of str
        Host names by which the server may be called, in addition to those of the loopback.
    token : str
        Token that a request must contain, in a cookie, as ``Authorization: Bearer`` or as
        ``?token=``; "" for none.
    """
    hosts = {f"[{name}]" if ":" in name else name for name in {*LOOPBACK, *names} if name}
    layers = [
        Middleware(SecurityHeaders),
        Middleware(TrustedHostMiddleware, allowed_hosts=sorted(hosts), www_redirect=False),
        Middleware(SameOrigin),
    ]
    if token:
        layers.append(
            Middleware(AuthenticationMiddleware, backend=TokenBackend(token), on_error=_no_token)
        )
    limit = Middleware(RequestBodyLimitMiddleware, max_body_size=LIMITS["body_bytes"])
    return [*layers, limit]


class SecurityHeaders:
    """Adds headers that switch off browser features that the page does not need."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a request; add the headers to its answer."""

        async def with_headers(message: Message) -> None:
            """Add the missing security headers to the start of a response."""
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        await self.app(scope, receive, with_headers)


class SameOrigin:
    """Rejects requests that pages of other sites send; a link to the page may be followed."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Forward a request, or reject it with status 403."""
        if scope["type"] == "http" and (error := self._error(scope, Headers(scope=scope))):
            await RequestError(403, "rejected", error).response()(scope, receive, send)
            return
        await self.app(scope, receive, send)

    def _error(self, scope: Scope, headers: Headers) -> str:
        """Return the reason to reject a request from another site; '' if it is accepted."""
        host = headers.get("host", "").lower()
        origins = headers.getlist("origin")
        if any(origin.lower() not in (f"http://{host}", f"https://{host}") for origin in origins):
            return f"Origin {origins[0][:80]!r} is that of another site"
        site = headers.get("sec-fetch-site", "none")  # browsers send it, other clients do not
        follows_link = scope["path"] == "/" and headers.get("sec-fetch-mode") == "navigate"
        if site not in ("none", "same-origin") and not follows_link:
            return "the request comes from another site"
        return ""


class TokenBackend(AuthenticationBackend):
    """Accepts requests that carry the token."""

    def __init__(self, token: str) -> None:
        self.token = token

    async def authenticate(self, conn: HTTPConnection) -> tuple[AuthCredentials, SimpleUser]:
        """Return the credentials of a request with the token.

        Raises
        ------
        AuthenticationError
            Without the token.
        """
        tokens = (
            conn.query_params.get("token", ""),
            conn.headers.get("authorization", "").removeprefix("Bearer "),
            conn.cookies.get(COOKIE, ""),
        )
        if not any(hmac.compare_digest(token.encode(), self.token.encode()) for token in tokens):
            raise AuthenticationError("open the address that 'woundon app' printed")
        return AuthCredentials(["authenticated"]), SimpleUser("client")


def _no_token(request: HTTPConnection, fault: Exception) -> Response:
    detail = f"a token is needed: {fault}"
    return RequestError(401, "rejected", detail).response()

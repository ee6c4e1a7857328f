"""Errors of requests as problem details (RFC 9457), with field, message and permitted range."""

from __future__ import annotations

import re
import traceback
from http import HTTPStatus
from typing import Any

from starlette.responses import Response

from .. import kinds
from ..errors import (
    MOST_LINES,
    InvalidProblem,
    NoSolution,
    NoSteadyState,
    NotConverged,
    printable_line,
)
from ..problems.paths import find_places
from .input_forms import limits_of
from .json_texts import to_json

__all__ = ["MEDIA", "REJECTIONS", "RequestError", "request_error_of"]

MEDIA = "application/problem+json"
# Dotted names of fields; the path of an error may be any text of the request.
FIELD_PATH = re.compile(r"\w{1,64}(\.\w{1,64}){0,19}")
DESCRIPTIONS = {
    400: "the body is not JSON",
    401: "a token is needed",
    403: "a request of another site",
    408: "the body arrived too slowly",
    409: "a newer request of the session took its place",
    413: "larger than the limit",
    422: "the case is not admissible, or was not solved",
    503: "busy, or a worker died; send the request again",
    504: "it took longer than the limit",
}
# for the OpenAPI document of every route
REJECTIONS: dict[int | str, dict[str, Any]] = {
    status: {"description": description, "content": {MEDIA: {}}}
    for status, description in DESCRIPTIONS.items()
}


class RequestError(Exception):
    """A request that is rejected, or whose computation failed.

    Attributes
    ----------
    status : int
    kind : str
        The last part of the problem's type: "invalid", "busy", ...
    detail : str
    errors : tuple of dict
        Field and message of each error, with the permitted range and the unit where known.
    """

    def __init__(self, status: int, kind: str, detail: str, errors: tuple[Any, ...] = ()) -> None:
        super().__init__(status, kind, detail, errors)
        self.status, self.kind, self.detail, self.errors = status, kind, detail, errors

    def details(self) -> dict[str, Any]:
        """Return the problem details, for JSON."""
        return {
            "type": f"/problems/{self.kind}",
            "title": HTTPStatus(self.status).phrase,
            "status": self.status,
            "detail": self.detail,
            "errors": self.errors,
        }

    def response(self) -> Response:
        """Return the response, without reading the remaining body of the request."""
        headers = {"connection": "close"} if self.status in (408, 413, 415) else {}
        return Response(to_json(self.details()), self.status, headers, media_type=MEDIA)


def request_error_of(fault: Exception) -> RequestError:
    """Return the error of a request for an exception that its computation raised.

    An exception that no input should cause is an error of the server; its traceback is printed.
    """
    if isinstance(fault, RequestError):
        return fault
    if isinstance(fault, InvalidProblem):
        kind = {NoSteadyState: "no-steady-state", NoSolution: "no-solution"}
        errors = tuple(_error_at(*entry) for entry in fault.faults[:MOST_LINES])
        return RequestError(422, kind.get(type(fault), "invalid"), str(fault), errors)
    if isinstance(fault, NotConverged):
        return RequestError(422, "not-converged", f"not converged: {fault}")
    if isinstance(fault, MemoryError):
        text = "the computation needs more memory than a request may use; choose fewer nodes"
        return RequestError(413, "too-large", text)
    traceback.print_exception(fault)
    return RequestError(500, "failed", f"{type(fault).__name__} in the server")


def _error_at(path: str, message: str) -> dict[str, Any]:
    """Return an error of a field with the field's permitted range and unit.

    They are those of the first kind of problem that has a field of that name.
    """
    error: dict[str, Any] = {"field": path, "message": printable_line(message)}
    if not FIELD_PATH.fullmatch(path):
        return error
    places = (place for kind in kinds.every() for place in find_places(kind.problem, path))
    if place := next(places, None):
        if limits := limits_of(place.field):
            error["range"] = limits
        if place.quantity is not None:
            error["unit"] = place.quantity.unit
    return error

"""What goes wrong, in words of HTTP: problem+json (RFC 9457) with field, message and range."""

from __future__ import annotations

import re
from collections.abc import Iterator
from http import HTTPStatus
from typing import Any, NamedTuple

from pydantic_core import to_json

from .. import kinds
from ..errors import MOST_LINES, InvalidProblem, NoSteadyState, NotConverged
from ..problems.permitted import bounds
from ..quantities import find

__all__ = ["MEDIA", "Refusal", "body_of", "refusal_of"]

MEDIA = "application/problem+json"


class Refusal(Exception):
    """A request that is not answered as asked.

    Attributes
    ----------
    status : int
    kind : str
        The last part of the problem's type: "invalid", "busy", ...
    """

    def __init__(self, status: int, kind: str, detail: str, errors: tuple[Any, ...] = ()) -> None:
        super().__init__(status, kind, detail, errors)
        self.status, self.kind, self.detail, self.errors = status, kind, detail, errors

    def body(self) -> bytes:
        """Return the problem+json document."""
        return body_of(self.status, self.kind, self.detail, self.errors)


class _Fault(NamedTuple):
    field: str
    message: str


def body_of(status: int, kind: str, detail: str, errors: tuple[Any, ...] = ()) -> bytes:
    """Return a problem+json document."""
    return to_json({
        "type": f"/problems/{kind}" if kind else "about:blank",
        "title": HTTPStatus(status).phrase, "status": status, "detail": detail,
        "errors": list(errors),
    }, inf_nan_mode="null")  # fmt: skip


def refusal_of(fault: Exception) -> Refusal | None:
    """Return what the caller is told of a fault of the input; None for any other."""
    if isinstance(fault, Refusal):
        return fault
    if isinstance(fault, InvalidProblem):
        kind = "no-steady-state" if isinstance(fault, NoSteadyState) else "invalid"
        told = tuple(_told(_Fault(*one)) for one in fault.faults[:MOST_LINES])
        return Refusal(422, kind, str(fault), told)
    if isinstance(fault, NotConverged):
        return Refusal(422, "not-converged", f"not converged: {fault}")
    if isinstance(fault, MemoryError):
        return Refusal(413, "too-large", "it needs more memory than a request may take")
    return None


def _told(fault: _Fault) -> dict[str, Any]:
    line = str(InvalidProblem([("", fault.message)]))
    told: dict[str, Any] = {"field": fault.field, "message": line}
    for field, quantity in _places(fault.field):
        if limits := bounds(field):
            names = {">": "gt", ">=": "ge", "<": "lt", "<=": "le"}
            told["range"] = {names[sign]: end for sign, end in limits}
        if quantity is not None:
            told["unit"] = quantity.unit
        break
    return told


def _places(path: str) -> Iterator[tuple[Any, Any]]:
    """Yield where a dotted name stands, in whatever kind of problem has it."""
    if re.fullmatch(r"\w{1,64}(\.\w{1,64}){0,19}", path):
        for kind in kinds.every():
            yield from ((place.field, place.quantity) for place in find(kind.problem, path))

"""JSON of requests and answers, by pydantic."""

from __future__ import annotations

from math import isfinite
from typing import Any

from pydantic import ConfigDict, TypeAdapter

__all__ = ["from_json", "to_json"]

_ANY: TypeAdapter[Any] = TypeAdapter(Any, config=ConfigDict(ser_json_inf_nan="null"))


def to_json(value: Any) -> bytes:
    """Return JSON, with null for nan and infinity.

    >>> to_json({"a": (1.5, float("nan"))})
    b'{"a":[1.5,null]}'
    """
    return _ANY.dump_json(value)


def from_json(text: bytes) -> Any:
    """Return the value of strict JSON: no nan, no infinity, valid UTF-8, at most 200 levels.

    Raises
    ------
    ValueError
        For any other text.
    """
    value = _ANY.validate_json(text)
    if not _is_finite(value):
        raise ValueError("a number is not finite")
    return value


def _is_finite(value: Any) -> bool:
    """Return True if a value of JSON contains neither nan nor infinity."""
    if isinstance(value, float):
        return isfinite(value)
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return all(map(_is_finite, parts))

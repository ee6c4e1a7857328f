"""JSON of requests and answers, by pydantic."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ConfigDict, TypeAdapter

__all__ = ["from_json", "records", "to_json"]

_ANY: TypeAdapter[Any] = TypeAdapter(Any, config=ConfigDict(ser_json_inf_nan="null"))


def to_json(value: Any) -> bytes:
    """Return JSON, with null for nan and infinity; arrays become lists, mappings objects.

    >>> import numpy as np
    >>> to_json({"a": (1.5, float("nan")), "b": np.array([[1, 2]])})
    b'{"a":[1.5,null],"b":[[1,2]]}'
    """
    return _ANY.dump_json(value, fallback=_plain)


def _plain(value: Any) -> Any:
    """Return an array or a scalar of NumPy as lists and numbers; any mapping as a dict."""
    return dict(value) if isinstance(value, Mapping) else value.tolist()


def records(**columns: Iterable[Any]) -> list[dict[str, Any]]:
    """Return the rows of columns of equal length.

    >>> records(name=("a", "b"), value=(1.0, 2.0))
    [{'name': 'a', 'value': 1.0}, {'name': 'b', 'value': 2.0}]
    """
    rows = zip(*columns.values(), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def from_json(text: bytes) -> Any:
    """Return the value of strict JSON: no nan, no infinity, valid UTF-8, at most 200 levels.

    Raises
    ------
    ValueError
        For any other text.
    """
    value = _ANY.validate_json(text)
    json.dumps(value, allow_nan=False)  # rejects what is not finite, such as 1e999
    return value

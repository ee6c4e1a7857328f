"""Values as JSON: it has neither nan nor infinity, which become null."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from ..errors import InvalidProblem

__all__ = ["json_text", "plain"]


def json_text(value: object) -> str:
    """Return a value as indented JSON.

    >>> print(json_text({"low": np.float64("nan")}))
    {
     "low": null
    }
    """
    return json.dumps(plain(value), indent=1, allow_nan=False)


def plain(value: Any, name: str = "") -> Any:
    """Return a value as JSON types: arrays and tuples as lists, nan and infinity as None.

    >>> plain(np.array([1.0, np.nan]))
    [1.0, None]

    Raises
    ------
    InvalidProblem
        For a value that JSON cannot contain; ``name`` is that of the field that holds it.
    """
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist(), name)
    if isinstance(value, Mapping):
        return {key: plain(inner, name) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner, name) for inner in value]
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return value if isfinite(value) else None
    text = f"a {type(value).__name__} cannot be saved; give the field metadata={{'saved': False}}"
    raise InvalidProblem.at(name, text)

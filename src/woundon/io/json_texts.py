"""JSON texts of numbers: JSON has neither nan nor infinity, which become null."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

__all__ = ["json_text", "plain"]


def json_text(value: Any) -> str:
    """Return a value as indented JSON.

    >>> print(json_text({"low": np.float64("nan")}))
    {
     "low": null
    }
    """
    return json.dumps(plain(value), indent=1, allow_nan=False)


def plain(value: Any) -> Any:
    """Return arrays, numbers of NumPy and named tuples as JSON types; None for nan and infinity."""
    if isinstance(value, Mapping):
        return {name: plain(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float):
        return float(value) if isfinite(value) else None
    return value

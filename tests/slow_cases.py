"""Parameters of tests that ``./run test`` leaves to ``-m slow``."""

from __future__ import annotations

from typing import Any

import pytest

__all__ = ["slow_case"]


def slow_case(*values: Any, id: str | None = None) -> Any:
    """Return a row of parameters that is marked as slow."""
    return pytest.param(*values, marks=pytest.mark.slow, id=id)

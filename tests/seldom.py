"""Parameters of tests that ``./run test`` leaves to ``-m slow``: others tell the same."""

from __future__ import annotations

from typing import Any

import pytest

__all__ = ["seldom"]


def seldom(*values: Any, id: str | None = None) -> Any:
    """Return a row of parameters for the tests that take long."""
    return pytest.param(*values, marks=pytest.mark.slow, id=id)

"""Assertion on rejected input: an InvalidProblem of one line."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import woundon as wo

__all__ = ["assert_rejected"]


def assert_rejected(make: Callable[[], object], start: str) -> None:
    """Assert that an input is rejected by a message of one line that begins with ``start``."""
    with pytest.raises(wo.InvalidProblem) as report:
        make()
    assert str(report.value).startswith(start)
    assert "\n" not in str(report.value)

"""What every refusal must be: an InvalidProblem of one line."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import woundon as wo

__all__ = ["refused_in_one_line"]


def refused_in_one_line(make: Callable[[], object], told: str) -> None:
    """Assert that something is refused, in one line that begins as told."""
    with pytest.raises(wo.InvalidProblem) as report:
        make()
    assert str(report.value).startswith(told)
    assert "\n" not in str(report.value)

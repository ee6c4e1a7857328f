"""Parameters of tests that ``./run test`` leaves to ``-m slow`` or to ``-m campaign``."""

from __future__ import annotations

from typing import Any

import pytest

__all__ = ["campaign_case", "slow_case"]


def slow_case(*values: Any, id: str | None = None) -> Any:
    """Return a row of parameters that is marked as slow."""
    return pytest.param(*values, marks=pytest.mark.slow, id=id)


def campaign_case(*values: Any, id: str | None = None) -> Any:
    """Return a row of parameters that only a campaign takes."""
    return pytest.param(*values, marks=pytest.mark.campaign, id=id)

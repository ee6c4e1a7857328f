"""The operations that a solution takes: they decide its time, and time cannot be tested."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

import woundon as wo
from woundon.contact import newton
from woundon.elasticity.influence import InfluenceSurface
from woundon.nip.equations import NipEquations


def test_operations_of_the_readmes_nip(monkeypatch: pytest.MonkeyPatch) -> None:
    """Version 0.3.1 took 31 constructions of the roll's surface, and 14 factorisations.

    The drum is rigid.  Two surfaces are those of the load limit and of the initial guess; the four
    meshes have two or three each, because the response is interpolated in ln a.  Ten of the
    residuals are those of the column by ln a.
    """
    counts: Counter[str] = Counter()

    def count(owner: Any, method: str, name: str) -> None:
        original = getattr(owner, method)

        def counted(*args: Any, **options: Any) -> Any:
            counts[name] += 1
            return original(*args, **options)

        monkeypatch.setattr(owner, method, counted)

    count(InfluenceSurface, "__init__", "surfaces")
    count(newton._LinearSystem, "__init__", "factorisations")
    count(NipEquations, "state", "residuals")
    wo.solve(wo.NipProblem.example())
    assert counts["surfaces"] <= 12
    assert counts["factorisations"] <= 10
    assert counts["residuals"] <= 36

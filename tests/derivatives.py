"""Exact sensitivities of nips compared with central differences of solutions."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

import woundon as wo
from woundon.quantities import value_of


def check_sensitivity(
    result: wo.NipResult,
    names: Sequence[str],
    outputs: Sequence[str] = ("nip_induced_tension", "half_width", "drum_creepage"),
    *,
    step: float = 1e-3,
    rtol: float,
    atol: float = 0.0,
) -> None:
    """Compare the derivatives of outputs by fields with differences on the mesh of a result.

    ``step`` is the relative change of a field, ``rtol`` the tolerance of a derivative relative to
    itself, ``atol`` that of an elasticity.
    """
    exact = result.sensitivity(*names, outputs=tuple(outputs))
    for name, value in zip(exact.parameters, exact.fields.tolist(), strict=True):
        more, less = (
            wo.solve(
                result.problem.replace(**{name: value * (1 + side * step)}),
                nodes=result.nodes, start=result,
            )
            for side in (1, -1)
        )  # fmt: skip
        for output in outputs:
            size = abs(value_of(result, output))
            elasticity = exact.derivative(output, name) * value / size
            difference = (value_of(more, output) - value_of(less, output)) / (2 * step * size)
            assert elasticity == pytest.approx(difference, rel=rtol, abs=atol), (name, output)

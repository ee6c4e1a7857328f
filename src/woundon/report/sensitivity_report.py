"""Local sensitivities as a table of elasticities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import kinds, quantities
from ..problems.paths import find_places, quantity_of_field
from ..problems.problem import Problem
from .report_parts import Column, Line, Part, Table, TableRow

if TYPE_CHECKING:
    from ..sensitivity import Sensitivity

__all__ = ["sensitivity_parts"]

TITLE = "Elasticities: percent of output per percent of field"


def sensitivity_parts(sensitivity: Sensitivity) -> list[Part]:
    """Return the elasticities, the most influential field for the first output first."""
    ordered = sensitivity.sorted()
    known: dict[str, quantities.Quantity] = {}
    for kind in kinds.every():  # the same name means the same in all of them
        known = {**quantities.scalar_outputs(kind.result), **known}
    # the elasticities of the half width are those of the nip width; indices of the others
    outputs = [k for k, name in enumerate(ordered.outputs) if name != "half_width"]
    symbols = [Column(known[ordered.outputs[k]].symbol, "number") for k in outputs]
    elasticities = np.round(ordered.elasticities[outputs], 4) + 0.0  # without a minus zero
    problem = _problem_with(ordered.parameters)
    rows, undefined = [], []
    for name, field, values in zip(ordered.parameters, ordered.fields, elasticities.T, strict=True):
        quantity = quantity_of_field(problem, name)
        if field:
            numbers = (f"{value:+.4f}" for value in values)
            rows.append(TableRow((name, quantity.text(field, ".5g"), *numbers)))
        else:  # an elasticity is not defined; in its place the derivative of the first output
            main = known[ordered.outputs[0]].named(ordered.outputs[0])
            slope = ordered.derivative(ordered.outputs[0], name) / float(quantity.shown(1.0))
            change, unit = main.text(slope, "+.4g"), quantity.display or "unit"
            undefined.append(f"{name} is 0: {main.symbol} changes by {change} per {unit} of it")
    columns = (Column("", "name"), Column("value", "number"), *symbols)
    parts: list[Part] = [Table(TITLE, columns, tuple(rows), "; ".join(undefined))]
    if ordered.zone_change:
        text = f"warning: at a zone change ({ordered.zone_change}): one-sided derivatives differ"
        parts.append(Line(text, "warning"))
    return parts


def _problem_with(names: Sequence[str]) -> type[Problem]:
    """Return a class of problems with some fields: sensitivities do not state that of theirs."""
    classes = [kind.problem for kind in kinds.every()]
    return next(each for each in classes if all(find_places(each, name) for name in names))

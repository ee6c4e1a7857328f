"""Local sensitivities as a table of elasticities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.text import Text

from .. import kinds, quantities
from ..problems.nip import NipProblem
from .html import table_html
from .report_parts import quantity_of_field
from .terminal import print_columns

if TYPE_CHECKING:
    from ..sensitivity import Sensitivity


__all__ = ["print_sensitivity", "sensitivity_html"]


def print_sensitivity(sensitivity: Sensitivity, console: Console) -> None:
    """Print elasticities, the most influential input for the first output first."""
    ordered = sensitivity.sorted()
    known: dict[str, quantities.Quantity] = {}
    for kind in kinds.every():  # the same name means the same in all of them
        known = {**quantities.scalar_outputs(kind.result), **known}
    # the width's elasticities are the half width's
    columns = [k for k, name in enumerate(ordered.outputs) if name != "half_width"]
    head = ["", "value", *(known[ordered.outputs[k]].symbol for k in columns)]
    elasticities = np.round(ordered.elasticities, 4) + 0.0  # without a minus zero
    table = [
        [
            name,
            quantity_of_field(NipProblem, name).text(field, ".5g"),
            *(f"{value:+.4f}" for value in values),
        ]
        for name, field, values in zip(
            ordered.parameters, ordered.fields, elasticities[columns].T, strict=True
        )
        if field
    ]
    longest = max((len(row[1]) for row in table), default=0)
    widths = [max(32, *map(len, ordered.parameters)), longest, *(9 for _ in columns)]
    console.print(Text("\nElasticities: percent of output per percent of field", style="bold"))
    print_columns([head, *table], widths, "<" + ">" * len(head), console)
    for name, field in zip(ordered.parameters, ordered.fields, strict=True):
        if not field:  # an elasticity is not defined
            main, one = (
                known[ordered.outputs[0]].named(ordered.outputs[0]),
                quantity_of_field(NipProblem, name),
            )
            slope = ordered.derivative(ordered.outputs[0], name) / float(one.shown(1.0))
            change = main.text(slope, "+.4g")
            text = (
                f"{name} is 0: {main.symbol} changes by {change} per {one.display or 'unit'} of it"
            )
            console.print(Text(text))
    if ordered.zone_change:
        text = f"warning: at a zone change ({ordered.zone_change}): one-sided derivatives differ"
        console.print(Text(text, style="bold yellow"))


def sensitivity_html(sensitivity: Sensitivity) -> str:
    """Return the elasticities as HTML, the most influential input for the first output first."""
    head = "Elasticities: percent of output per percent of parameter"
    zone_change = sensitivity.zone_change
    remarks = [f"At a zone change: {zone_change}"] if zone_change else []
    frame = sensitivity.sorted().to_dataframe().rename(columns={"value": "value [SI]"})
    return table_html(head, frame, remarks)

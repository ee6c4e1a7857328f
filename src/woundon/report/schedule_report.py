"""Report and figure of a tension schedule for a target pressure (``woundon schedule``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..io.spreadsheets import in_csv_style
from ..problems.paths import quantity_of_field
from ..problems.roll import RollProblem
from ..quantities import header, length, share, stress
from ..roll.design import TensionDesign
from ..roll.result import RollResult
from .drawing import show_panels
from .panels import Axis, Curve
from .report_parts import (
    Column,
    Line,
    Part,
    Section,
    Table,
    TableRow,
    quantity_of,
    row_of,
)
from .roll_panels import over_radius, radii_between

__all__ = ["csv_text", "plot_schedule", "schedule_parts"]

ROWS = 13  # of the printed table
LAYER = length("d_o", "depth of the outer layer in which the target cannot be reached")
INSIDE = share("e_P", "largest deviation below the outer layer, relative to the largest pressure")
WOT = quantity_of_field(RollProblem, "wound_on_tension")
SURFACE = stress("dP", "largest deviation in the outer layer")


def csv_text(design: TensionDesign) -> str:
    """Return the tension over the radius as the columns of a profile, which a case can read."""
    columns = {
        "radius": (quantity_of(RollResult, "radius"), design.tension.radius),
        "value": (WOT, design.tension.value),
    }
    names = ",".join(header(name, quantity.display) for name, (quantity, _) in columns.items())
    shown = [quantity.shown(np.array(values)) for quantity, values in columns.values()]
    rows = (f"{r:.12g},{T:.12g}" for r, T in zip(*shown, strict=True))
    return in_csv_style("\n".join([names, *rows, ""]))


def interior_deviation(design: TensionDesign, roll: RollResult) -> float:
    """Return the largest deviation from the target below the outer layer.

    It is relative to the largest target pressure; 0 if the outer layer is the whole roll.
    """
    interior = design.radius < design.radius[-1] - design.outer_layer
    deviation = np.abs(roll.at_radius(design.radius)["pressure"] - design.target_pressure)[interior]
    return float(deviation.max(initial=0.0) / design.target_pressure.max())


def schedule_parts(design: TensionDesign, roll: RollResult) -> list[Part]:
    """Return a tension schedule and the pressure of the roll that is wound with it.

    Parameters
    ----------
    design : TensionDesign
    roll : RollResult
        The roll that is wound with the schedule.
    """
    tensions = {
        "at the core": design.tension.value[0],
        "maximum": max(design.tension.value),
        "at the surface": design.tension.value[-1],
    }
    deviations = {
        INSIDE: interior_deviation(design, roll),
        LAYER: design.outer_layer,
        SURFACE: design.surface_deviation,
    }
    schedule = [
        row_of(WOT, float(value), meaning=f"{WOT.meaning}, {place}")
        for place, value in tensions.items()
    ]
    pressure = [row_of(quantity, float(value)) for quantity, value in deviations.items()]
    return [
        Line(f"{len(design.tension.radius)} radii", "quiet"),
        Section("Tension schedule", tuple(schedule)),
        Section("Pressure", tuple(pressure)),
        _over_the_radius(design, roll),
    ]


def _over_the_radius(design: TensionDesign, roll: RollResult) -> Table:
    """Return tension, target and resulting pressure at evenly spaced radii."""
    even = np.linspace(design.radius[0], design.radius[-1], ROWS)
    nearest = np.unique([int(np.argmin(np.abs(design.radius - r))) for r in even])
    r, target = design.radius[nearest], design.target_pressure[nearest]
    T, P = design.tension.at(r), roll.at_radius(r)["pressure"]
    radius, stress = (quantity_of(RollResult, name) for name in ("radius", "pressure"))
    contents = (  # title, quantity, values [SI], significant digits of the largest value
        ("radius", radius, r, 5),
        ("tension", WOT, T, 5),
        ("target", stress, target, 6),
        ("result", stress, P, 6),
    )
    columns: list[Column] = []
    cells: list[list[str]] = []
    for title, quantity, values, digits in contents:
        shown = quantity.shown(values)
        decimals = max(digits - 1 - int(np.floor(np.log10(np.max(shown)))), 0)
        shown = np.round(shown, decimals) + 0.0  # without a minus zero
        columns += [Column(title, "number"), Column("", "unit")]
        cells += [[f"{value:.{decimals}f}" for value in shown], [quantity.display] * r.size]
    rows = tuple(map(TableRow, zip(*cells, strict=True)))
    return Table("Over the radius", tuple(columns), rows)


def plot_schedule(design: TensionDesign, roll: RollResult, path: str | Path) -> None:
    """Plot the target pressure, the pressure of the roll wound with the schedule, the tension."""
    r, P = radii_between(roll), quantity_of(roll, "pressure")
    pressures = [
        Curve("pressure", r, roll.at_radius(r)["pressure"], label="result"),
        Curve(
            "target",
            design.radius,
            design.target_pressure,
            label="target",
            colour="drum",
            line="dashed",
        ),
    ]
    tension = Curve("tension", r, design.tension.at(r))
    size: dict[str, Any] = {"width": 4.2, "height": 2.8, "legend": "inside"}
    panels = [
        over_radius(r, name, title, y, curves, column=name, **size)
        for name, title, y, curves in (
            ("pressure", "Pressure", Axis("Pressure $P$", P, from_zero=True), pressures),
            ("tension", "Tension", Axis("Wound-on tension", WOT, from_zero=True), [tension]),
        )
    ]
    show_panels([[panel] for panel in panels], path=path, lettered=False)

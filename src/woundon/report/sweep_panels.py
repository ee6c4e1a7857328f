"""The panels of a study table: curves of a grid, or points over every input."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..studies.cases import as_labels, is_numeric
from .drawing import show_panels
from .figures import named_value
from .panels import LINES, SERIES, Axis, Curve, Panel
from .study_panels import named_axis

if TYPE_CHECKING:
    from ..studies.run import Table

__all__ = ["plot_sweep"]

Array = np.ndarray
MOST_CURVES, MOST_PANELS = 7, 4
SPARSE = 30  # up to so many points of a curve are marked
COLUMNS = 3  # of the panels of points


def plot_sweep(table: Table, output: str, path: str | Path | None = None) -> Figure | Axes:
    """Plot one output of a study.

    Of a grid: curves over the longest axis, a curve for each value of the next, a panel for each
    of a third; further inputs at their middle values.  At most seven curves and four panels are
    shown, spread over the values; the title gives their numbers if there are more.  Of a
    table: the output over every input.

    Parameters
    ----------
    table : Table
    output : str
    path : path, optional
        Where to save; without it the figure is pyplot's.
    """
    title = ""
    if not np.isfinite(table.outputs[output]).any():
        panels = [_without_solution(table, output)]
    elif table.cases.axes:
        panels, title = _grid_panels(table, output)
    else:
        panels = _scatter_panels(table, output)
    cases = [[panel] for panel in panels]
    return show_panels(cases, path=path, lettered=False, title=title, same_y=True)


def _without_solution(table: Table, output: str) -> Panel:
    """Return the panel of a study of which no case was solved."""
    y = named_axis(output, table.quantities.get(output))
    note = f"none of the {len(table.cases)} cases was solved"
    return Panel(output, Axis(""), y, note=note, width=5.0)


def _grid_panels(table: Table, output: str) -> tuple[list[Panel], str]:
    """Return the panels of a grid and the title of its figure."""
    shape, axes = table.cases.shape, list(table.cases.axes.values())
    # numeric inputs first, then by the number of values; from the fourth on at the middle value
    inputs = sorted(range(len(shape)), key=lambda k: (not is_numeric(axes[k]), -shape[k]))
    drawn, fixed = inputs[:3], {k: shape[k] // 2 for k in inputs[3:]}
    # to the axes (positions along x, curves, panels); missing ones have the length 1
    values = table.outputs[output].reshape(shape)
    values = values[tuple(fixed.get(k, slice(None)) for k in range(len(shape)))]
    values = np.transpose(values, [sorted(drawn).index(k) for k in drawn])
    while values.ndim < 3:
        values = values[..., None]
    y = named_axis(output, table.quantities.get(output))
    panels = [
        Panel(
            output,
            _axis_of_input(table, drawn[0]),
            y,
            curves=tuple(_curves(table, output, drawn, values[:, :, place])),
            heading=_value_label(table, drawn[2], place) if len(drawn) > 2 else "",
            note="" if np.isfinite(values[:, :, place]).any() else "no case was solved",
            column=str(place),
            width=3.4 if len(drawn) > 1 else 5.0,
            legend="figure right" if len(drawn) > 1 else "above",
        )
        for place in _evenly_spaced(values.shape[2], MOST_PANELS)
    ]
    held_at = ", ".join(_value_label(table, k, place) for k, place in fixed.items())
    return panels, "; ".join(filter(None, [held_at, _omissions(values.shape)]))


def _axis_of_input(table: Table, k: int) -> Axis:
    """Return the axis of the ``k``-th input, with names of its values if they are not numbers."""
    name = table.cases.names[k]
    values = table.cases.axes[name]
    if not is_numeric(values):
        return Axis(name, names=tuple(str(label) for label in as_labels(values)))
    return named_axis(name, table.quantities.get(name), values)


def _curves(table: Table, output: str, drawn: list[int], values: Array) -> list[Curve]:
    """Return the curves of one panel.

    Parameters
    ----------
    table : Table
    output : str
    drawn : list of int
        Numbers of the inputs of the study: along x, of the curves (if any), of the panels (if any).
    values : (n, m) array
        Output at n positions along x on m curves [SI].
    """
    x = table.cases.axes[table.cases.names[drawn[0]]]
    positions = x if is_numeric(x) else np.arange(len(x), dtype=float)
    order = np.argsort(positions, kind="stable")
    marker = "circle"
    if is_numeric(x):
        marker = "point" if positions.size <= SPARSE else ""
    return [
        Curve(
            output,
            positions[order],
            values[order, k],
            label=_value_label(table, drawn[1], k) if len(drawn) > 1 else "",
            colour=SERIES[place],
            line=LINES[place % len(LINES)],
            marker=marker,
        )
        for place, k in enumerate(_evenly_spaced(values.shape[1], MOST_CURVES))
    ]


def _omissions(shape: tuple[int, ...]) -> str:
    """Return how many curves and panels are shown; '' if all are.

    ``shape`` has the numbers of positions along x, of curves and of panels.
    """
    limits = {"curves": (shape[1], MOST_CURVES), "panels": (shape[2], MOST_PANELS)}
    parts = [
        f"{limit} of {count} {name}" for name, (count, limit) in limits.items() if count > limit
    ]
    return f"{' and '.join(parts)} shown" if parts else ""


def _scatter_panels(table: Table, output: str) -> list[Panel]:
    """Return the panels of a design without a grid: the output over each input."""
    panels = []
    columns = {name: x for name, x in table.cases.columns.items() if is_numeric(x)}
    for k, (name, x) in enumerate(columns.items()):
        points = Curve(output, x, table.outputs[output], line="none", marker="point", opacity=0.6)
        panels.append(
            Panel(
                name,
                named_axis(name, table.quantities.get(name), x),
                named_axis(output, table.quantities.get(output)),
                curves=(points,),
                column=str(k % COLUMNS),
                width=2.9,
                height=2.6,
            )
        )
    return panels


def _evenly_spaced(count: int, limit: int) -> list[int]:
    """Return at most ``limit`` evenly spaced indices below ``count``, including both ends."""
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, limit))})


def _value_label(table: Table, axis: int, place: int) -> str:
    """Return a label such as "shear = 10 MPa": input ``axis`` at its value number ``place``."""
    name = table.cases.names[axis]
    value = as_labels(table.cases.axes[name])[place]
    return named_value(name, table.quantities.get(name), value)

"""How the thesis's figures are drawn: panels, line styles, legends with units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import plots
from .frame import Table
from .sweep import WINDING_FORCES

__all__ = [
    "Curve",
    "blank",
    "curves",
    "force_curves",
    "panel_letter",
    "plain",
    "shared_legend",
    "style",
]

Array = np.ndarray
style = plots.style

# the thesis's line styles in its order; the colours tell its two solid lines apart
_LINES = ("-", "--", "-.", ":", "-")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#444444")


class Curve:
    """One curve of a panel: which rows, what it is called, how it looks.

    Parameters
    ----------
    label : str
    line, colour : str, optional
        matplotlib's; by default the thesis's ``k``-th.
    **where
        Values of the table's columns that pick the curve's rows.
    """

    def __init__(
        self, k: int, label: str, *, line: str = "", colour: str = "", **where: float
    ) -> None:
        self.label, self.where = label, where
        self.line, self.colour = line or _LINES[k], colour or COLOURS[k]


def force_curves() -> list[Curve]:
    """Return the five winding forces of sec. 4.3 to 4.5."""
    return [Curve(k, f"$F = {F:.0f}$ N/m", winding_force=F) for k, F in enumerate(WINDING_FORCES)]


def blank(
    rows: int = 1,
    columns: int = 2,
    size: tuple[float, float] | None = None,
    *,
    letters: bool = True,
) -> Figure:
    """Return a figure of empty panels, lettered (a), (b), ... if there are several."""
    with plots.style():
        figure = Figure(figsize=size or (3.6 * columns, 3.3 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).flat
        if letters and rows * columns > 1:
            for letter, axes in zip("abcdefghi", panels, strict=False):
                panel_letter(axes, f"({letter})")
    return figure


def panel_letter(axes: Axes, text: str) -> None:
    """Put a panel's letter above its right corner."""
    axes.set_title(text, loc="right", fontsize=9)


def curves(
    axes: Axes,
    table: Table,
    lines: Sequence[Curve],
    x: tuple[str, str, float],
    y: tuple[str, str, float],
) -> None:
    """Draw curves of a table.

    Parameters
    ----------
    axes : Axes
    table : Table
    lines : sequence of Curve
    x, y : (column, label, factor)
        The column's values times the factor are drawn.
    """
    for line in lines:
        rows = table.where(**line.where)
        axes.plot(
            rows[x[0]] * x[2], rows[y[0]] * y[2], line.line, color=line.colour, label=line.label
        )
    axes.set_xlabel(x[1])
    axes.set_ylabel(y[1])


def plain(axes: Axes, x: Array, y: Array, k: int, label: str) -> None:
    """Draw one curve in the ``k``-th line style."""
    axes.plot(x, y, _LINES[k], color=COLOURS[k], label=label)


def shared_legend(figure: Figure, columns: int = 5) -> None:
    """Put one legend for all panels above them, where it covers no data."""
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    with plots.style():
        figure.legend(
            handles=list(handles.values()), labels=list(handles), loc="outside upper center",
            ncols=columns, handlelength=2.6, columnspacing=1.3,
        )  # fmt: skip

"""The figure of an inverse problem: the output over the field, the target and the solutions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from .figures import COLOURS, axis_label, wrapped_text
from .panels import Case, Panel, drawn

if TYPE_CHECKING:
    from ..studies.find import FindResult

__all__ = ["plot_find"]

DECADE = 10.0  # from this ratio of the ends the field has a logarithmic axis


def plot_find(found: FindResult, path: Any = None, ax: Axes | None = None) -> Any:
    """Draw the output over the field with the target and the solutions.

    Parameters
    ----------
    found : FindResult
    path, ax
        As of :func:`~woundon.show.panels.drawn`.
    """
    panels = {"scan": Panel(_draw_scan, "scan", 5.2, 3.4)}
    return drawn(panels, [Case(found)], path, ax, None, lettered=False)


def _draw_scan(axes: Axes, cases: Sequence[Case]) -> list[Any]:
    found = cases[0].result
    field, output = found.quantities[found.name], found.quantities[found.output]
    x, y = field.shown(found.values), output.shown(found.outputs)
    (curve,) = axes.plot(x, y, ".-", color=COLOURS[0], label="scan")
    handles = [curve]
    failed = ~np.isfinite(found.outputs)
    if failed.any():
        at = np.full(int(failed.sum()), 0.02)
        handles += axes.plot(
            x[failed], at, "x", color=COLOURS[6], transform=axes.get_xaxis_transform(),
            label="no solution of the problem",
        )  # fmt: skip
    target = axes.axhline(
        output.shown(found.target), color=COLOURS[1], linestyle="--", label="target"
    )
    values = [field.shown(value) for value, _ in found.solutions]
    handles.append(target)
    handles += axes.plot(
        values, [output.shown(found.target)] * len(values), "o", color=COLOURS[1],
        markerfacecolor="white", label="solution",
    )  # fmt: skip
    if found.values[0] > 0 and found.values[-1] / found.values[0] >= DECADE:
        axes.set_xscale("log")
    axes.set_xlabel(axis_label(wrapped_text(field.meaning, 60), field))
    axes.set_ylabel(axis_label(wrapped_text(output.meaning, 36), output))
    return handles

"""The figure of an operating window: probability, contours, binding margins, best point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..studies.window_result import LEVELS, OperatingWindow
from .figures import COLOURS, axis_label, wrapped_text
from .panels import Case, Panel, draw_panels

__all__ = ["plot_window"]

STYLES: Any = (":", "--", "-")
FAINT = 0.35  # opacity of the regions
WORDS = {"gauge_band": "gauge band"}
NONE = "#BBBBBB"


def plot_window(
    window: OperatingWindow,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot the contours of the probability over the regions of the binding margins.

    With a torque split, the level of the best point is drawn.

    Parameters
    ----------
    window : OperatingWindow
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`.
    """
    known = {"window": Panel(_draw_window, "window", 7.2, 4.2, legend="right")}
    return draw_panels(known, [Case(window)], path, ax, panels, lettered=False)


def _draw_window(axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the probability contours and the regions of the binding margins."""
    window = cases[0].result
    tension, load = (window.quantities[name] for name in window.names[:2])
    best = window.best
    level: tuple[Any, ...] = ()
    if len(window.names) == 3:
        split = best.values["torque_split"]
        level = (int(np.argmin(np.abs(window.axes[2] - split))),)
        axes.set_title(f"torque split {window.axes[2][level[0]]:.2g}", fontsize=9)
    x, y = tension.shown(window.axes[0]), load.shown(window.axes[1])
    probability = window.probability[(..., *level)]
    binding = window.binding[(..., *level)]
    handles: list[Any] = []
    for k, name in enumerate(window.margins):
        if (binding == k).any():
            region = np.where(binding == k, 1.0, np.nan)
            colour = COLOURS[k % 6]
            axes.pcolormesh(
                x,
                y,
                region.T,
                cmap=ListedColormap([colour]),
                alpha=FAINT,
                shading="nearest",
                rasterized=True,
                linewidth=0,
            )
            words = f"binding: {WORDS.get(name, name)}"
            handles.append(Patch(facecolor=colour, alpha=FAINT, label=words))
    if (binding < 0).any():
        region = np.where(binding < 0, 1.0, np.nan)
        axes.pcolormesh(
            x,
            y,
            region.T,
            cmap=ListedColormap([NONE]),
            shading="nearest",
            rasterized=True,
            linewidth=0,
        )
        handles.append(Patch(facecolor=NONE, label="no steady state, or not solved"))
    for value, line in zip(LEVELS, STYLES, strict=True):
        if not np.nanmin(probability) < value < np.nanmax(probability):
            continue
        contour = axes.contour(x, y, probability.T, [value], colors="black", linestyles=[line])
        if any(np.size(path.vertices) for path in contour.get_paths()):  # none next to a gap
            handles.append(Line2D([], [], color="black", linestyle=line, label=f"P = {value:g}"))
    handles += axes.plot(
        tension.shown(best.values["web_tension"]),
        load.shown(best.values["nip_load"]),
        "o",
        color="black",
        markerfacecolor="white",
        clip_on=False,
        zorder=5,
        linestyle="none",
        label=f"largest P = {best.probability:.2f}",
    )
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])
    axes.set_xlabel(axis_label(wrapped_text(f"{tension.meaning}, at the core", 60), tension))
    axes.set_ylabel(axis_label(wrapped_text(f"{load.meaning}, at the core", 36), load))
    return handles

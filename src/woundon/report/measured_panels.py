"""The panels of measured data: logs of a winder."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..roll.result import RollResult
from .panels import Axis, Curve, Panel
from .report_parts import quantity_of
from .study_panels import named_axis

if TYPE_CHECKING:
    from ..studies.winder_log import WinderLog

__all__ = ["log_panels"]

Array = np.ndarray
MOST_POINTS = 4000  # of the rows of a log, evenly spaced in its order


def log_panels(log: WinderLog) -> list[Panel]:
    """Return a panel of each quantity over the radius: rows, means of the bins, rows left out.

    Of many rows some are drawn, evenly spaced in the order of the log.
    """
    bins = log.bins
    panels = []
    for name, raw, mean, scatter in zip(bins.names, bins.raw, bins.mean, bins.scatter, strict=True):
        known = np.isfinite(raw) & np.isfinite(bins.raw_radius)
        points = [
            Curve(
                "",
                *_thinned(bins.raw_radius, raw, known & chosen),
                label=label,
                colour=colour,
                opacity=opacity,
                line="none",
                marker="point",
            )
            for chosen, label, colour, opacity in (
                (bins.is_used, "rows", "sky", 0.4),
                (~bins.is_used, "rows left out", "alarm", 1.0),
            )
            if (known & chosen).any()
        ]
        means = Curve(
            name,
            bins.radius,
            mean,
            label="mean of a bin, with the standard deviation of its rows",
            line="none",
            marker="circle",
            y_error=np.nan_to_num(scatter),
        )
        panels.append(
            Panel(
                name,
                Axis("radius", quantity_of(RollResult, "radius")),
                named_axis(name, log.quantities[name]),
                curves=(*points, means),
                column="log",
                height=2.4,
                legend="figure below",
            )
        )
    return panels


def _thinned(x: Array, y: Array, chosen: Array) -> tuple[Array, Array]:
    """Return the chosen points, at most ``MOST_POINTS`` of them."""
    rows = np.flatnonzero(chosen)
    rows = rows[:: 1 + rows.size // MOST_POINTS]
    return x[rows], y[rows]

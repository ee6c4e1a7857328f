"""The panels of measured data: logs of a winder, compression tests of a stack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..quantities import strain, stress
from ..roll.result import RollResult
from .panels import LINES, SERIES, Axis, Curve, Panel
from .report_parts import quantity_of
from .study_panels import named_axis

if TYPE_CHECKING:
    from ..studies.stack_fit import StackFit
    from ..studies.winder_log import WinderLog

__all__ = ["log_panels", "stack_panels"]

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


def stack_panels(fit: StackFit) -> list[Panel]:
    """Return the panels of a stack test: pressure over strain, and modulus over pressure.

    The rows of the test are points, those left out too; the laws are lines over the range of the
    rows that are used, the one with the smallest misfit first.
    """
    test = fit.test
    P, _ = test.used
    grid = np.linspace(P.min(), P.max(), 200)
    pressure = stress("P", "pressure on the stack")
    points = [
        Curve(
            "",
            *_thinned(test.strain, test.pressure, chosen),
            label=label,
            colour=colour,
            line="none",
            marker="point",
        )
        for chosen, label, colour in (
            (~test.is_used, "rows left out", "sky"),
            (test.is_used, "rows", "ink"),
        )
        if chosen.any()
    ]
    laws, moduli = [], []
    for k, each in enumerate(fit.laws):
        label = f"{each.name.replace('_', ' ')}, misfit {each.misfit:.1e}"
        colour, line = SERIES[k % len(SERIES)], LINES[k % len(LINES)]
        strains = each.origin + each.law.strain_at(grid)
        laws.append(Curve(each.name, strains, grid, label=label, colour=colour, line=line))
        modulus = each.law.modulus(grid)
        moduli.append(Curve(each.name, grid, modulus, colour=colour, line=line, in_legend=False))
    return [
        Panel(
            "strain",
            Axis("compressive strain", strain("eps", "strain")),
            Axis("pressure", pressure),
            curves=(*points, *laws),
            width=4.4,
            legend="stacked",
        ),
        Panel(
            "modulus",
            Axis("pressure", pressure),
            Axis("modulus $E_r$", stress("E_r", "radial modulus", "MPa")),
            curves=tuple(moduli),
            width=4.4,
        ),
    ]


def _thinned(x: Array, y: Array, chosen: Array) -> tuple[Array, Array]:
    """Return the chosen points, at most ``MOST_POINTS`` of them."""
    rows = np.flatnonzero(chosen)
    rows = rows[:: 1 + rows.size // MOST_POINTS]
    return x[rows], y[rows]

"""The panels of measured data: logs of a winder, compression tests of a stack."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..quantities import strain, stress
from ..roll.result import RollResult
from .panels import LINES, SERIES, Axis, Curve, Limits, Panel, with_margin
from .report_parts import quantity_of
from .study_panels import named_axis

if TYPE_CHECKING:
    from ..studies.stack_fit import StackFit
    from ..studies.winder_log import WinderLog

__all__ = ["log_panels", "stack_panels"]

Array = np.ndarray
MOST_POINTS = 4000  # of the rows of a log, evenly spaced in its order
# Rows left out may be anywhere, as their radius or value is wrong: those far away would leave no
# room for the others.  Shares of the range of the rows that are used.
BEYOND, MARGIN = 0.3, 0.05


def log_panels(log: WinderLog) -> list[Panel]:
    """Return a panel of each quantity over the radius: rows, means of the bins, rows left out.

    Of many rows some are drawn, evenly spaced in the order of the log; none that is left out and
    far from the others.
    """
    bins = log.bins
    r = bins.raw_radius
    radii = _ends(r, bins.is_used)
    panels = []
    for name, raw, mean, scatter in zip(bins.names, bins.raw, bins.mean, bins.scatter, strict=True):
        low, high = _ends(raw, bins.is_used)
        known = (raw >= low) & (raw <= high) & (r >= radii[0]) & (r <= radii[1])
        points = [
            *_points(r, raw, known & bins.is_used, "rows", "sky", 0.4),
            *_points(r, raw, known & ~bins.is_used, "rows left out", "alarm", 1.0),
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
                Axis("radius", quantity_of(RollResult, "radius"), limits=radii),
                replace(named_axis(name, log.quantities[name]), limits=(low, high)),
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
        *_points(test.strain, test.pressure, ~test.is_used, "rows left out", "sky", 0.5),
        *_points(test.strain, test.pressure, test.is_used, "rows", "soft", 0.5),
    ]
    laws, moduli = [], []
    for k, each in enumerate(fit.laws):
        label = f"{each.name.replace('_', ' ')}, misfit {each.misfit:.1e}"
        colour, line = SERIES[k % len(SERIES)], LINES[k % len(LINES)]
        strains = each.origin + each.law.strain_at(grid)
        laws.append(Curve(each.name, strains, grid, label=label, colour=colour, line=line))
        modulus = each.law.modulus(grid)
        moduli.append(Curve(each.name, grid, modulus, label=label, colour=colour, line=line))
    return [
        Panel(
            "strain",
            Axis("compressive strain", strain("eps", "strain")),
            Axis("pressure", pressure),
            curves=(*points, *laws),
            width=4.4,
            legend="figure right",
        ),
        Panel(
            "modulus",
            Axis("pressure", pressure),
            Axis("modulus $E_r$", stress("E_r", "radial modulus", "MPa")),
            curves=tuple(moduli),
            width=4.4,
            legend="figure right",
        ),
    ]


def _ends(values: Array, used: Array) -> Limits:
    """Return the ends of an axis on which all rows that are used are seen, and others near them.

    ``values`` are those of all rows, ``used`` is the mask of those that are used, (n,).
    """
    kept = values[used & np.isfinite(values)]
    room = BEYOND * (kept.max() - kept.min())
    near = (values >= kept.min() - room) & (values <= kept.max() + room)
    return with_margin(values[near], MARGIN)


def _points(
    x: Array, y: Array, chosen: Array, label: str, colour: str, opacity: float
) -> Iterator[Curve]:
    """Yield the chosen rows as points, at most ``MOST_POINTS`` of them; nothing without rows.

    All arrays are (n,); other arguments are fields of the curve.
    """
    rows = np.flatnonzero(chosen)
    rows = rows[:: 1 + rows.size // MOST_POINTS]
    if rows.size:
        points = Curve("", x[rows], y[rows], label=label, colour=colour, opacity=opacity)
        yield replace(points, line="none", marker="point")

"""Plots of the margins over the radius, and of the roll's cross section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..roll.result import RollResult
from ..winding.margins import Margin, Margins
from .figures import COLOURS, axis_label, quantity_of
from .panels import NEUTRAL, Case

__all__ = ["Bars", "Disc", "colour_scale", "draw_disc", "draw_margins"]

RADIUS = quantity_of(RollResult, "radius")
ALARM = "#B00020"
AROUND = 181  # spokes of a disc, its first and last the same
OUTWARD = 200
MOST, LEAST = 1.05, -0.15  # of the reserves that are drawn
WITHOUT_FRICTION = -1.0  # drawn in place of an infinite reserve
ROUNDING = 1e-9
BAR = 0.12  # of a reserve at the core alone, of the build-up


def draw_margins(axes: Axes, margins: Margins, colour: str | None = None) -> list[Any]:
    """Plot every margin over the radius, red below zero."""
    reserves = [m.reserve for m in margins if m.checked]
    deepest = min((r if isfinite(r) else WITHOUT_FRICTION for r in reserves), default=0.0)
    low = 1.2 * deepest if deepest < 0 else LEAST
    lines = [
        _draw_margin(axes, margin, margins, colour or default, low)
        for margin, default in zip(margins, COLOURS, strict=False)
        if margin.checked
    ]
    axes.axhspan(low, 0, color=ALARM, alpha=0.12, linewidth=0)
    axes.axhline(0, color=ALARM, linewidth=1.0)
    axes.annotate(
        "limit",
        (0.99, 0),
        (0, 2),
        ("axes fraction", "data"),
        "offset points",
        color=ALARM,
        ha="right",
        va="bottom",
    )
    axes.set_ylim(low, MOST)
    axes.set_ylabel("Reserve, share of the limit")
    return lines


def _draw_margin(axes: Axes, margin: Margin, margins: Margins, colour: str, low: float) -> Any:
    """Plot the reserve of a margin over the radius, at least ``low``, and its smallest value."""
    r, reserve = RADIUS.shown(margin.over_radius), margin.reserve_of(margin.values)
    if r.size == 1:  # of the core alone
        ends = [RADIUS.shown(m.over_radius[-1]) for m in margins if m.over_radius.size > 1]
        r, reserve = np.array([r[0], r[0] + BAR * (max(ends) - r[0])]), np.repeat(reserve, 2)
    (line,) = axes.plot(r, np.clip(reserve, low, 2 * MOST), color=colour, label=margin.name)
    axes.plot(
        RADIUS.shown(margin.radius),
        np.clip(margin.reserve, low, MOST),
        "o",
        markersize=4,
        clip_on=False,
        color=colour if margin.ok else ALARM,
        zorder=3,
    )
    return line


@dataclass(frozen=True)
class Disc:
    """An output over the cross section of a wound roll, as a coloured disc."""

    name: str
    words: str
    roll: str = ""  # of the result, the roll itself where empty

    def __call__(self, axes: Axes, cases: Sequence[Case]) -> list[Any]:
        """Plot the first case."""
        result = cases[0].result
        roll: RollResult = getattr(result, self.roll) if self.roll else result
        quantity = quantity_of(roll, self.name)
        mesh = draw_disc(axes, roll, self.name, (0.0, 0.0), colour_scale(roll, self.name))
        figure = axes.get_figure()
        assert figure is not None
        extend = "max" if self.name == "hoop_stress" else "neither"
        figure.colorbar(mesh, ax=axes, label=axis_label(self.words, quantity), extend=extend)
        axes.set_aspect("equal")
        axes.margins(0.03)
        axes.grid(False)
        axes.set_xlabel(axis_label("$x$", RADIUS))
        axes.set_ylabel(axis_label("$y$", RADIUS))
        return []


def colour_scale(roll: RollResult, name: str) -> tuple[float, float, str]:
    """Return limits of the colour scale of an output, in its unit for display, and colour map."""
    r = np.linspace(roll.radius[0], roll.radius[-1], OUTWARD)
    values = quantity_of(roll, name).shown(roll.at_radius(r)[name])
    if values.min() > -ROUNDING * values.max():
        return 0.0, float(values.max()), "viridis"
    # the stress at both ends is many times that inside, which would have almost no colour
    high = min(float(values.max()), -2 * float(values.min()))
    high = max(high, -float(values.min()))
    return -high, high, "RdBu"  # symmetric about zero


def draw_disc(
    axes: Axes,
    roll: RollResult,
    name: str,
    centre: tuple[float, float],
    levels: tuple[float, float, str],
) -> Any:
    """Plot the cross section of a roll coloured by an output; return its mesh.

    ``centre`` is in the unit in which radii are displayed.
    """
    r = np.linspace(roll.radius[0], roll.radius[-1], OUTWARD)
    values = quantity_of(roll, name).shown(roll.at_radius(r)[name])
    angle = np.linspace(0, 2 * np.pi, AROUND)
    (x0, y0), (low, high, colours) = centre, levels
    x, y = (RADIUS.shown(np.outer(r, way(angle))) for way in (np.cos, np.sin))
    mesh = axes.pcolormesh(
        x0 + x,
        y0 + y,
        np.repeat(values[:, None], AROUND, 1),
        cmap=colours,
        vmin=low,
        vmax=high,
        shading="gouraud",
        rasterized=True,
    )
    axes.fill(x0 + x[0], y0 + y[0], facecolor="#D9D9D9", edgecolor=NEUTRAL, linewidth=0.8)
    return mesh


@dataclass(frozen=True, eq=False)
class Bars:
    """Bar chart of the margins before and after the optimisation."""

    optimised: Any

    def __call__(self, axes: Axes, cases: Sequence[Case]) -> list[Any]:
        """Plot the reserves of both windings."""
        before, after = self.optimised.margins_before, self.optimised.margins_after
        names = [name for name in (m.name for m in after) if after[name].checked]
        positions = np.arange(len(names))
        for margins, case, shift in zip((before, after), cases, (-0.2, 0.2), strict=True):
            reserves = np.array([margins[name].reserve for name in names])
            axes.barh(positions + shift, 100 * np.clip(reserves, -1, 1), 0.38, color=case.colour)
        axes.axvline(0, color=ALARM, linewidth=1.2)
        axes.set_yticks(positions, names)
        axes.invert_yaxis()
        axes.set_xlabel("Reserve, share of the limit, at most 100 [%]")
        return []

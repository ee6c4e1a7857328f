"""The reserves of a roll over its radius, and the roll seen from its side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .. import kinds
from ..roll.result import WoundRollResult
from ..winding.margins import Margin, Margins
from .figures import COLOURS, axis_label, quantity_of
from .panels import NEUTRAL, Case, Panel, cases_of, drawn

__all__ = ["Bars", "Disc", "draw_reserves", "plot_schedule"]

ALARM = "#B00020"
AROUND = 361  # spokes of a disc, its first and last the same
OUTWARD = 300
MOST, LEAST = 1.05, -0.15  # of the reserves that are drawn
BAR = 0.12  # of a reserve at the core alone, of the build-up


def draw_reserves(axes: Axes, margins: Margins, colour: str | None = None) -> list[Any]:
    """Draw what is left of every limit over the radius, red below nothing."""
    lines, deepest = [], 0.0
    for margin, own in zip(margins, COLOURS, strict=False):
        if margin.checked:
            lines.append(_draw_reserve(axes, margin, margins, colour or own))
            deepest = min(deepest, margin.reserve)
    low = 1.2 * deepest if deepest else LEAST
    axes.axhspan(low, 0, color=ALARM, alpha=0.12, linewidth=0)
    axes.axhline(0, color=ALARM, linewidth=1.0)
    axes.annotate("limit", (1.01, 0), xycoords=("axes fraction", "data"), color=ALARM, va="center",
                  annotation_clip=False)  # fmt: skip
    axes.set_ylim(low, MOST)
    axes.set_ylabel("Reserve, share of the limit")
    return lines


def _draw_reserve(axes: Axes, margin: Margin, margins: Margins, colour: str) -> Any:
    r, reserve = 1e3 * margin.over_radius, margin.reserve_of(margin.values)
    if r.size == 1:  # of the core alone
        ends = [1e3 * other.over_radius[-1] for other in margins if other.over_radius.size > 1]
        r, reserve = np.array([r[0], r[0] + BAR * (max(ends) - r[0])]), np.repeat(reserve, 2)
    (line,) = axes.plot(r, np.minimum(reserve, 2 * MOST), color=colour, label=margin.name)
    axes.plot(1e3 * margin.radius, min(margin.reserve, MOST), "o", markersize=4, clip_on=False,
              color=colour if margin.ok else ALARM, zorder=3)  # fmt: skip
    return line


@dataclass(frozen=True)
class Disc:
    """What draws an output of a wound roll on its side, as a coloured disc."""

    name: str
    words: str
    roll: str = ""  # of the result, the roll itself where empty

    def __call__(self, axes: Axes, cases: Sequence[Case]) -> list[Any]:
        """Draw the first case."""
        result = cases[0].result
        roll: WoundRollResult = getattr(result, self.roll) if self.roll else result
        quantity = quantity_of(roll, self.name)
        r = np.linspace(roll.radius[0], roll.radius[-1], OUTWARD)
        values = quantity.shown(roll.at_radius(r)[self.name])
        angle = np.linspace(0, 2 * np.pi, AROUND)
        x, y = 1e3 * np.outer(r, np.cos(angle)), 1e3 * np.outer(r, np.sin(angle))
        # what is within a few laps of the surface, many times the rest, would pale all else
        inner = values[r <= r[0] + 0.9 * (r[-1] - r[0])]
        low, high = float(inner.min()), float(inner.max())
        if low < 0:  # as much colour to either sign
            high = max(-low, min(high, -2 * low))
            low, colours = -high, "RdBu"
        else:
            low, colours = 0.0, "viridis"
        mesh = axes.pcolormesh(
            x, y, np.repeat(values[:, None], AROUND, 1), cmap=colours, vmin=low, vmax=high,
            shading="gouraud", rasterized=True,
        )  # fmt: skip
        figure = axes.get_figure()
        assert figure is not None
        beyond = "max" if values.max() > high else "neither"
        figure.colorbar(mesh, ax=axes, label=axis_label(self.words, quantity), extend=beyond)
        core = 1e3 * float(r[0])
        axes.fill(core * np.cos(angle), core * np.sin(angle), color="#D9D9D9", edgecolor=NEUTRAL)
        axes.set_aspect("equal")
        axes.margins(0.03)
        axes.grid(False)
        axes.set_xlabel(axis_label("$x$", quantity_of(roll, "radius")))
        axes.set_ylabel(axis_label("$y$", quantity_of(roll, "radius")))
        return []


def plot_schedule(found: Any, path: Any = None, choice: Any = None) -> Any:
    """Draw a winding before and after its schedule was optimised."""
    cases = cases_of([found.before, found.after], ["before", "after"])
    panels = dict(kinds.of(found.after).plot(found.after))
    panels["reserves"] = Panel(Bars(found), "reserves", width=4.2, height=3.2)
    return drawn(panels, cases, path, choice=choice)


@dataclass(frozen=True, eq=False)
class Bars:
    """What draws the reserves before and after, bar beside bar."""

    found: Any

    def __call__(self, axes: Axes, cases: Sequence[Case]) -> list[Any]:
        """Draw them."""
        before, after = self.found.margins_before, self.found.margins_after
        kept = [name for name in (m.name for m in after) if after[name].checked]
        at = np.arange(len(kept))
        for margins, case, shift in zip((before, after), cases, (-0.2, 0.2), strict=True):
            reserves = np.array([margins[name].reserve for name in kept])
            axes.barh(at + shift, 100 * np.clip(reserves, -1, 1), 0.38, color=case.colour)
        axes.axvline(0, color=ALARM, linewidth=1.2)
        axes.set_yticks(at, kept)
        axes.invert_yaxis()
        axes.set_xlabel("Reserve, share of the limit [%]")
        return []

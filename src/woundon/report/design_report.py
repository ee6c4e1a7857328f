"""What a design of the tension says: found, wound forward, drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from rich.console import Console

from ..problems.roll import RollProblem
from ..quantities import Quantity, find, length, strain, stress
from ..roll.design import TensionDesign
from ..roll.result import RollResult
from .figures import COLOURS, Picture, axis_label, quantity_of, save_figure, style
from .parts import Line, Row, Section
from .terminal import print_columns, print_parts

__all__ = ["plot_design", "print_design"]

ROWS = 13  # of the printed table
LAYER = length("d_o", "depth of the outer layer, where what is wanted is missed")
INSIDE = strain("e_P", "largest miss inside, wound forward, of the largest pressure")
SURFACE = stress("dP", "largest miss, in the outer layer")


def _tension() -> Quantity:
    quantity = find(RollProblem, "wound_on_tension")[0].quantity
    assert quantity is not None
    return quantity


def missed_inside(found: TensionDesign, wound: RollResult) -> float:
    """Return by how much the wound roll misses what is wanted below the outer layer, relative."""
    inside = found.radius < found.radius[-1] - found.outer_layer
    off = np.abs(wound.at_radius(found.radius)["pressure"] - found.wanted)[inside]
    return float(off.max(initial=0.0) / found.wanted.max())


def print_design(found: TensionDesign, wound: RollResult, console: Console) -> None:
    """Print a design: the tension at a few radii, and how near the roll comes."""
    even = np.linspace(found.radius[0], found.radius[-1], ROWS)
    near = np.unique([int(np.argmin(np.abs(found.radius - r))) for r in even])
    WOT, r, wanted = _tension(), found.radius[near], found.wanted[near]
    T, reached = found.tension.at(r), wound.at_radius(r)["pressure"]
    extremes = [
        Row(f"{WOT.meaning}, {word}", WOT.symbol, float(WOT.shown(value)), WOT.display)
        for word, value in (("at the core", T[0]), ("largest", max(found.tension.value)),
                            ("at the surface", T[-1]))
    ]  # fmt: skip
    misses = [
        Row(quantity.meaning, quantity.symbol, float(quantity.shown(value)), quantity.display)
        for quantity, value in ((INSIDE, missed_inside(found, wound)), (LAYER, found.outer_layer),
                                (SURFACE, found.surface_miss))
    ]  # fmt: skip
    print_parts([
        Line(f"tension at {len(found.tension.radius)} radii", "quiet"),
        Section("Tension found", tuple(extremes)), Section("Pressure", tuple(misses)),
        Line("Over the radius"),
    ], console)  # fmt: skip
    header = ("radius", "mm", "tension", "N/m", "wanted", "kPa", "wound", "kPa")
    rows = [
        (f"{1e3 * a:.2f}", "mm", f"{b:.2f}", "N/m", f"{1e-3 * c:.3f}", "kPa",
         f"{round(1e-3 * d, 3) + 0.0:.3f}", "kPa")
        for a, b, c, d in zip(r, T, wanted, reached, strict=True)
    ]  # fmt: skip
    titles = tuple(word if k % 2 == 0 else " " * len(word) for k, word in enumerate(header))
    print_columns([titles, *rows], (8, 2, 8, 3, 8, 3, 8, 3), "><" * 4, console)


def plot_design(found: TensionDesign, wound: RollResult, path: str | Path) -> None:
    """Draw the pressure wanted and that of the roll wound forward, and the tension."""
    P, r_of = quantity_of(wound, "pressure"), quantity_of(wound, "radius")
    r = np.linspace(found.radius[0], found.radius[-1], 801)
    x = r_of.shown(r)
    with style():
        figure = Picture.new((8.4, 3.2), registered=False)
        left, right = figure.subplots(1, 2)
        left.plot(x, P.shown(wound.at_radius(r)["pressure"]), color=COLOURS[0], label="wound")
        left.plot(r_of.shown(found.radius), P.shown(found.wanted), "--", color=COLOURS[1],
                  label="wanted")  # fmt: skip
        left.set_ylabel(axis_label("Pressure $P$", P))
        left.legend()
        right.plot(x, _tension().shown(found.tension.at(r)), color=COLOURS[0])
        right.set_ylabel(axis_label("Wound-on tension", _tension()))
        for axes in (left, right):
            _along(axes, x, axis_label("Radius $r$", r_of))
        save_figure(figure, path)


def _along(axes: Axes, x: np.ndarray, label: str) -> None:
    axes.set_xlabel(label)
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(bottom=0)

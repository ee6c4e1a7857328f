"""Panels of the figures: curves of a dataset, and a nip along x, in the order of the thesis.

:mod:`woundon.report.drawing` draws them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from math import nan
from typing import Any

import numpy as np
import xarray as xr

import woundon as wo

from ..report.nip_panels import slips, tractions, zones
from ..report.panels import LINES, Axis, Curve, Panel
from .nips import Nip
from .procedure import ProcedureResult
from .zones import zone_lengths

__all__ = [
    "COLOURS",
    "LEGEND",
    "QUANTITIES",
    "axis",
    "curve_panels",
    "curves",
    "named",
    "nip_panels",
    "slips_and_increase",
    "with_one_legend",
]

# of variables and dimensions of the datasets, in the notation of the thesis
QUANTITIES: Mapping[str, wo.Quantity] = {
    "nip_load": wo.Quantity("P", "N/m", "Nip load"),
    "winding_force": wo.Quantity("F", "N/m", "Winding force"),
    "web_tension": wo.Quantity("T_in", "N/m", "Web tension upstream of the nip"),
    "roll_friction": wo.Quantity("mu+", "1", "Friction between layers"),
    "roll_radius": wo.Quantity("R1", "m", "Roll radius"),
    "drum_radius": wo.Quantity("R2", "m", "Drum radius"),
    "youngs_modulus": wo.Quantity("E2", "Pa", "Cover modulus", "MPa"),
    "poissons_ratio": wo.Quantity("nu2", "1", "Poisson's ratio of the cover"),
    "cover_thickness": wo.Quantity("h2", "m", "Cover thickness", "mm"),
    "radial": wo.Quantity("A_rr", "Pa", "Radial stiffness", "MPa"),
    "tangential": wo.Quantity("A_tt", "Pa", "Tangential stiffness", "GPa"),
    "cross": wo.Quantity("A_rt", "Pa", "Cross stiffness", "MPa"),
    "shear": wo.Quantity("G", "Pa", "Shear modulus", "MPa"),
    "x": wo.Quantity("x", "m", "Position along the nip", "mm"),
    "angle": wo.Quantity("theta", "rad", "Angle downstream of the trailing edge", "deg"),
    "nip_induced_tension": wo.Quantity("NIT", "N/m", "Nip-induced tension"),
    "tension_increase": wo.Quantity("T - T_in", "N/m", "Web tension"),
    "nip_width": wo.Quantity("2a", "m", "Nip width", "mm"),
    "leading_roll_slip": wo.Quantity("s_r1", "1", "Slip at the leading edge"),
    "trailing_roll_slip": wo.Quantity("s_r2", "1", "Slip at the trailing edge"),
    "dual_slip": wo.Quantity("s_d", "1", "Dual slip ratio"),
    "traction": wo.Quantity("q", "Pa", "Tangential traction", "MPa"),
    "roll_strain": wo.Quantity("eps_1", "1", "Strain of the roll's surface", "%"),
    "roll_rate": wo.Quantity("|d eps/d theta|", "1/rad", "Rate"),
}
LOGARITHMIC = ("youngs_modulus", "roll_rate")
COLOURS = ("roll", "drum", "green", "purple", "web")  # of curves; two solid ones differ by them
LEGEND = 1.6  # usual width of a legend to the right of a panel [inches]


def axis(name: str) -> Axis:
    """Return the axis of a variable or dimension."""
    quantity = QUANTITIES[name]
    return Axis(f"{quantity.meaning} ${quantity.symbol}$", quantity, log=name in LOGARITHMIC)


def named(name: str, value: float) -> str:
    """Return a value of a dimension as legends write it: ``$F$ = 100 N/m``."""
    quantity = QUANTITIES[name]
    return f"${quantity.symbol}$ = {quantity.text(value)}"


def curves(
    data: xr.Dataset, x: str, y: str, along: str, names: Sequence[str] = (), **look: Any
) -> tuple[Curve, ...]:
    """Return curves of a variable over another, or over a dimension: one for each value of a third.

    Parameters
    ----------
    data : Dataset
    x, y : str
        Variables or dimensions on the axes.
    along : str
        Dimension with a curve for each value.
    names : sequence of str
        In the legend in place of the values.
    look
        Further fields of the curves.
    """
    made = []
    for k, value in enumerate(data[along].values.tolist()):
        one = data.isel({along: k})
        name = names[k] if names else named(along, value)
        usual = {"label": name, "colour": COLOURS[k], "line": LINES[k % len(LINES)]}
        made.append(Curve(y, one[x].values, one[y].values, **{**usual, **look}))
    return tuple(made)


def curve_panels(
    data: xr.Dataset,
    shown: Sequence[str],
    x: str,
    along: str = "winding_force",
    *,
    panels: str = "",
    names: Sequence[str] = (),
    legend: float = LEGEND,
) -> list[Panel]:
    """Return panels of curves next to each other; the last one has the legend.

    Parameters
    ----------
    data : Dataset
    shown : sequence of str
        Variables, a panel each.
    x, along, names
        As of :func:`curves`.
    panels : str
        Dimension along which each value has a panel, of a single variable.
    legend : float
        Width of the legend [inches].
    """
    parts = [(y, data, "") for y in shown]  # variable, its data, heading
    if panels:
        values = data[panels].values.tolist()
        parts = [(shown[0], data.sel({panels: v}), named(panels, v)) for v in values]
    made = [
        Panel(
            y,
            axis(x),
            axis(y),
            curves=curves(part, x, y, along, names),
            heading=heading,
            column=str(k),
            width=3.6 if len(parts) > 1 else 4.8,
            height=3.3,
        )
        for k, (y, part, heading) in enumerate(parts)
    ]
    return with_one_legend(made, legend)


def with_one_legend(panels: Sequence[Panel], width: float = LEGEND) -> list[Panel]:
    """Return panels with the same curves, of which the last has the legend, to its right.

    ``width`` is that of the legend [inches].
    """
    *first, last = panels
    without = [
        replace(panel, curves=tuple(replace(curve, in_legend=False) for curve in panel.curves))
        for panel in first
    ]
    return [*without, replace(last, legend="right", width=last.width + width)]


# ---- one nip along x ----------------------------------------------------------------------------


def nip_panels(result: Nip) -> list[Panel]:
    """Return the panels of a nip (Fig. 15): tractions; slips and web tension; zones."""
    shown = _as_nip_result(result)
    return [tractions(shown), slips(shown), zones(shown)]


def slips_and_increase(result: Nip) -> Panel:
    """Return the panel of the slips of a nip with T_in = 0, whose tension is the nip's alone."""
    return replace(slips(_as_nip_result(result)), right=axis("tension_increase"))


def _as_nip_result(result: Nip) -> wo.NipResult:
    """Return a result of the procedure in the class that woundon draws.

    What the procedure does not compute is nan.
    """
    if isinstance(result, wo.NipResult):
        return result
    computed = {field.name: getattr(result, field.name) for field in fields(ProcedureResult)}
    del computed["nip_induced_tension"]  # NipResult integrates the tractions
    leading, trailing, dual = zone_lengths(result)
    return wo.NipResult(
        **computed,
        residuals=wo.Residuals(),
        roll_pressure=result.drum_pressure,
        roll_strain=np.full(result.nodes, nan),
        roll_wound_on_tension=nan,
        leading_roll=leading,
        trailing_roll=trailing,
        dual=dual,
    )

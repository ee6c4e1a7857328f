"""The panels of the slip index between the layers of the roll below a nip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..errors import unwarned
from ..nip.layer_slip import LayerSlip, friction_limit, interior_stress, wound_in_pressure
from ..nip.result import NipResult
from ..quantities import Quantity
from .figures import COLOURS, axis_label, quantity_of
from .panels import Case, Panel

__all__ = ["LAYER_SLIP"]

Array = np.ndarray
Cases = Sequence[Case]
Handles = list[Any]

DEPTHS, PLACES = 40, 301  # of the map
LEAST_EXCESS = 1.0  # [Pa], end of the colour scale where no layer slips
SHEAR, LIMIT, EXCESS = COLOURS[0], COLOURS[1], "#444444"


def _with_stresses(cases: Cases) -> list[tuple[Case, LayerSlip]]:
    """Return the cases with interior stresses and their layer-slip index."""
    with unwarned():
        indices = [(case, case.result.layer_slip) for case in cases]
    return [(case, slip) for case, slip in indices if slip is not None]


def draw_map(axes: Axes, cases: Cases) -> Handles:
    """Plot |tau| - mu (P0 + p) over x and depth; of several cases only the slip boundary."""
    known, names = _with_stresses(cases), ("x", "half_width", "drum_pressure")
    along, depth, stress = (quantity_of(cases[0].result, name) for name in names)
    handles: Handles = []
    for case, slip in known:
        x, z, excess = _map(case.result, slip)
        x, z, shown = along.shown(x), depth.shown(z), stress.shown(excess)
        if case.alone:
            top = float(stress.shown(max(excess.max(), LEAST_EXCESS)))
            levels = MaxNLocator(16, symmetric=True).tick_values(-top, top)
            filled = axes.contourf(x, z, shown, levels, cmap="RdBu_r", extend="min")
            label = axis_label(r"$|\tau| - \mu(P_0 + p)$", stress)
            axes.figure.colorbar(filled, ax=axes, label=label)
        axes.contour(x, z, shown, [0.0], colors=[case.colour_or("#000000")], linewidths=1.2)
        handles += axes.plot([], [], color=case.colour_or("#000000"), label="boundary of slip")[:1]
        a = along.shown(case.result.half_width)
        for edge in (-a, a):
            axes.axvline(edge, color=case.colour_or("#888888"), linewidth=0.8, linestyle=":")
    axes.set_xlabel(axis_label("Position along the nip $x$", along))
    _format_depth_axis(axes, known, depth)
    return handles[:1]


def _map(result: NipResult, slip: LayerSlip) -> tuple[Array, Array, Array]:
    """Return x (n,), z (m,) and the excess of the shear (m, n), around the slipping layers."""
    z = np.geomspace(slip.interface_depth[0], _deepest(slip), DEPTHS)
    reach = max(0.6 * slip.width, 2 * result.half_width)
    # the stresses vary most in the nip
    x = reach * np.sinh(np.linspace(-3, 3, PLACES)) / np.sinh(3)
    sections = interior_stress(result, z) or ()
    P0 = wound_in_pressure(result, z)
    excess = [
        np.interp(x, s.x, np.abs(s.shear) - friction_limit(result, P - s.normal))
        for s, P in zip(sections, P0, strict=True)
    ]
    return x, z, np.array(excess)


def _deepest(slip: LayerSlip) -> float:
    """Return the largest depth of the plot [m]."""
    deepest, preferred = float(slip.interface_depth[-1]), 1.5 * slip.depth
    return min(deepest, max(preferred, 8 * float(slip.interface_depth[0])))


def draw_shear(axes: Axes, cases: Cases) -> Handles:
    """Plot the largest shear, the friction limit and the largest excess over the depth."""
    known, result = _with_stresses(cases), cases[0].result
    stress, depth = quantity_of(result, "drum_pressure"), quantity_of(result, "half_width")
    handles: Handles = []
    for case, slip in known:
        z, lines = depth.shown(slip.interface_depth), []
        for values, line, colour, label in (
            (slip.largest_shear, "-", SHEAR, r"$\max|\tau|$"),
            (slip.friction_limit, "--", LIMIT, r"$\mu(P_0 + \max p)$"),
            (slip.excess, "-.", EXCESS, "largest excess"),
        ):
            lines += axes.plot(
                stress.shown(values), z, line, color=case.colour_or(colour), label=label
            )
        handles = handles or lines
    axes.axvline(0.0, color="#888888", linewidth=0.8)
    axes.set_xlabel(axis_label("Stress", stress))
    _format_depth_axis(axes, known, depth)
    return handles


def _format_depth_axis(
    axes: Axes, known: Sequence[tuple[Case, LayerSlip]], depth: Quantity
) -> None:
    """Set label, scale and limits of the axis of the depth."""
    axes.set_ylabel(axis_label("Depth $z$", depth))
    if not known:
        axes.text(
            0.5, 0.5, "no interior stresses of this roll", ha="center", transform=axes.transAxes
        )
        return
    axes.set_yscale("log")
    top = min(float(slip.interface_depth[0]) for _, slip in known)
    axes.set_ylim(depth.shown(max(_deepest(slip) for _, slip in known)), depth.shown(top))


LAYER_SLIP = {
    "layer_slip": Panel(draw_map, "layer_slip", width=6.6, height=3.6, by_default=False),
    "layer_shear": Panel(draw_shear, "layer_shear", width=4.6, height=3.6, by_default=False),
}

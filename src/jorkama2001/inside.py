"""What the reproduction takes from within woundon, for want of a public name.

All of it is here, but for the processes (``processes``).
"""

from __future__ import annotations

from math import pi

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from woundon.nip.roll_surface import roll_strain
from woundon.wrap.influence import Influence
from woundon.wrap.integrals import OpenGrid

import woundon as wo
from woundon.show.figures import figure_bytes, legend_above, save_figure, style
from woundon.show.nip_plots import nip_panels
from woundon.show.panels import Case, drawn

__all__ = [
    "draw_slips", "figure_bytes", "nip_figure", "roll_strain", "save_figure",
    "strain_under", "style",
]  # fmt: skip

Array = np.ndarray


def nip_figure(result: wo.NipResult) -> Figure:
    """Return the figure of a nip, not pyplot's, so that any number may be drawn."""
    figure: Figure = drawn(nip_panels(result), [Case(result)], registered=False)
    return figure


def draw_slips(axes: Axes, result: wo.NipResult) -> None:
    """Draw a nip's slips and its web tension, the legend above."""
    legend_above(axes, list(nip_panels(result)["slips"].draw(axes, [Case(result)])))


def strain_under(
    roll: wo.Cylinder, nodes: Array, points: Array, pressure: Array, traction: Array
) -> Array:
    """Return a roll's surface strain under loads given at nodes on half its circumference.

    Parameters
    ----------
    roll : Cylinder
    nodes, points : (n,), (k,) arrays
        Angles where the loads are given, and where the strain is asked for [rad].
    pressure, traction : (n,) arrays
        Piecewise linear between the nodes [Pa].

    Returns
    -------
    (k,) array
    """
    R = roll.radius
    kernels = roll.kernels()
    put = Influence(OpenGrid(nodes, points), None, R, kernels.length, 2 * pi * R, kernels.reach)
    strain: Array = put(kernels.strain_p) @ pressure + put(kernels.strain_q) @ traction
    return strain

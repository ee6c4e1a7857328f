"""What the reproduction takes from within woundon, for want of a public name; all of it is here."""

from __future__ import annotations

from contextlib import AbstractContextManager
from math import pi
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import woundon as wo
from woundon.nip import roll_surface
from woundon.show import plots
from woundon.studies.processes import in_processes
from woundon.wrap.grid import Influence, OpenGrid

__all__ = [
    "draw_slips", "in_processes", "roll_strain", "save_figure", "strain_in_nip", "strain_under", "style",
]  # fmt: skip

Array = np.ndarray


def style() -> AbstractContextManager[None]:
    """Return the context in which figures are made."""
    return plots.style()


def save_figure(figure: Figure, path: Path, dpi: int | None = None) -> None:
    """Save a figure so that the same figure gives the same bytes."""
    plots.save_figure(figure, path, dpi=dpi)


def draw_slips(axes: Axes, result: wo.NipResult) -> None:
    """Draw the slips and, on the right, the web tension: panel (b) of ``result.plot()``."""
    plots.draw_slips(axes, result)


def roll_strain(result: wo.NipResult, s: Array) -> Array:
    """Return the roll's surface strain under a solved nip at distances outside it [m], (k,)."""
    return roll_surface.roll_strain(result, s)


def strain_in_nip(result: wo.NipResult) -> tuple[Array, Array]:
    """Return the collocation points of a solved nip [m] and the roll's strain there, (M-1,)."""
    mesh, a = result.mesh, result.half_width
    *_, strain_p, strain_q = result.problem.roll.respond(mesh, a).gradients
    strain = strain_p @ result.pressure[1:-1] + strain_q @ result.roll_traction[1:-1]
    return a * mesh.middle, strain[:-1]


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
    put = Influence(
        OpenGrid(nodes, points), None, np.arange(0), slice(0), R, kernels.length, 2 * pi * R
    )
    strain: Array = put(kernels.strain_p) @ pressure + put(kernels.strain_q) @ traction
    return strain

"""Nodes and sources of the stages of a roll: dense where the pressure varies fast."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from .equations import CellSource
from .growth import Growth

__all__ = [
    "Tension",
    "cell_source",
    "evaluate_in_cells",
    "kinks_of",
    "nodes_between",
    "points_of_cells",
    "radii_of_nodes",
    "source_error",
]

Array = np.ndarray

# Additional cells on either side of a kink that changes the source by STRONG_KINK or more, relative
# to the number of cells of a stage
KINK_CELLS, STRONG_KINK = 0.1, 0.1
SAME = 1e-12  # of ln r: nodes closer together are one


class Tension(Protocol):
    """The wound-on stress of the layers over the radius."""

    kinks: Array  # radii between core and surface at which the slope jumps [m]
    bends: Array  # jumps of the slope at the kinks, r |dT'|/T [1]

    def at(self, r: Array) -> Array:
        """Return T [Pa]."""
        ...

    def slope(self, r: Array, side: int | Array) -> Array:
        """Return dT/dr [Pa/m]; at a kink, that of its inner (-1) or outer (1) side."""
        ...


def radii_of_nodes(x: Array, core: float, surface: float) -> Array:
    """Return r of nodes x = ln r [m]; both ends without the rounding error of exp(ln r)."""
    r = np.exp(x)
    r[0], r[-1] = core, surface
    return np.asarray(r)


def nodes_between(
    core: float,
    surface: float,
    cells: int,
    surface_layer: float,
    kinks: Array | None = None,
    changes: Array | None = None,
    core_layer: float = np.inf,
) -> Array:
    """Return ln r of nodes, dense at the core, at the surface and at kinks.

    Parameters
    ----------
    core, surface : float
        ln r of both ends.
    cells : int
        Approximate number of cells without kinks.
    surface_layer : float
        Depth of the layer below the surface, in ln r.
    kinks, changes : (K,) arrays, optional
        ln r of kinks, which become nodes, and the relative changes of the source there.
    core_layer : float
        Depth of the layer at the core, in ln r, if it is thinner than that below the surface.
    """
    length = surface - core
    surface_layer = min(surface_layer, length)
    core_layer = min(core_layer, surface_layer)
    # node density: 1/(distance + depth of the layer) from both ends, plus a constant with the mean
    # of their integrals; the nodes are at even steps of the integral of this density
    at_core, at_surface = np.log1p(length / core_layer), np.log1p(length / surface_layer)
    uniform = (at_core + at_surface) / 2
    # fine distances y from the core, at which the cumulative number of nodes is tabulated
    t = np.linspace(0, 1, 2 * cells)
    y = np.concatenate(
        [
            core_layer * np.expm1(at_core * t),
            length - surface_layer * np.expm1(at_surface * t),
            length * t,
        ]
    )
    y = np.clip(np.sort(y), 0, length)
    cumulative = (
        uniform * y / length + np.log1p(y / core_layer) - np.log1p((length - y) / surface_layer)
    )
    steps = np.linspace(-at_surface, uniform + at_core, cells + 1)
    nodes = core + np.interp(steps, cumulative, y)
    nodes[0], nodes[-1] = core, surface
    if kinks is None:
        return nodes
    inside = (kinks > core + SAME) & (kinks < surface - SAME)
    parts = [nodes, kinks[inside]]
    if changes is not None:
        strength = np.minimum(1.0, changes[inside] / STRONG_KINK)
        ends = np.concatenate([[core], kinks[inside], [surface]])
        parts += _kink_nodes(ends, np.round(cells * KINK_CELLS * strength), surface_layer)
    return np.unique(np.concatenate(parts))


def _kink_nodes(ends: Array, counts: Array, surface_layer: float) -> list[Array]:
    """Return graded nodes on either side of each kink, up to half the distance of the next one.

    Parameters
    ----------
    ends : (K + 2,) array
        Core, kinks and surface, in ln r.
    counts : (K,) array
        Number of nodes on each side.
    surface_layer : float
        Distance on which they are dense, in ln r.
    """
    # rows: kinks; t from 0 at the kink to 1 at half the distance, larger values are not used
    t = np.arange(1, int(counts.max(initial=0)) + 1) / (counts[:, None] + 1)
    used, kinks = t < 1, ends[1:-1, None]
    nodes = []
    for side, gap in ((-1, np.diff(ends)[:-1]), (1, np.diff(ends)[1:])):
        extent = gap[:, None] / 2
        depth = np.minimum(surface_layer, extent)
        nodes.append((kinks + side * depth * np.expm1(np.log1p(extent / depth) * t))[used])
    return nodes


def kinks_of(tension: Tension, growth: Growth, surface: float = np.inf) -> tuple[Array, Array]:
    """Return ln r of a tension's kinks, and the relative changes of the source there.

    Kinks from ln r = ``surface`` on are left out.  After the last stage, kappa of the last stage is
    used.  Kinks that are closer together than 1/(2 + kappa) approximate a smooth curve: they are
    weighted by their distance.
    """
    x = np.log(tension.kinks)
    x, bends = x[x < surface], tension.bends[x < surface]
    if not x.size:
        return x, x
    factor = 2 + growth(np.minimum(x, growth.x[-1]))  # of T in the source
    gaps = np.diff(x, prepend=-np.inf, append=np.inf)
    weight = np.minimum(1.0, factor * np.maximum(gaps[1:], gaps[:-1]) / 2)
    return x, bends / factor * weight


def cell_source(tension: Tension, growth: Growth, nodes: Array) -> CellSource:
    """Return the source C = -r T' - T (2 + kappa) in every cell [Pa].

    ``nodes`` are ln r, (n + 1,).  At a kink of the tension that is a node, each of the two cells
    has the slope T' of its own side.
    """

    def source(x: Array, side: Array) -> Array:
        """Return C; ``side`` is that of a kink."""
        r = np.exp(x)
        return -r * tension.slope(r, side) - tension.at(r) * (2 + growth(x))

    return evaluate_in_cells(nodes, source)


def source_error(tension: Tension, growth: Growth, nodes: Array) -> CellSource:
    """Estimate the error of the source in every cell due to the interpolation of kappa."""
    return evaluate_in_cells(
        nodes, lambda x, _: -tension.at(np.exp(x)) * growth.interpolation_error(x)
    )


def evaluate_in_cells(nodes: Array, values: Callable[[Array, Array], Array]) -> CellSource:
    """Return values(x, side) at the left end, in the middle and at the right end of every cell.

    ``nodes`` are x = ln r, (n + 1,).  ``side`` is 1 or -1 for values just outside or inside of x,
    which differ where the function has a kink.
    """
    n = nodes.size - 1
    side = np.repeat([1, 1, -1], n)  # inner or outer side of a kink that is a node
    return CellSource(*values(points_of_cells(nodes), side).reshape(3, n))


def points_of_cells(nodes: Array) -> Array:
    """Return ln r at the left ends, then in the middles, then at the right ends of cells, (3 n,).

    ``nodes`` are ln r, (n + 1,).
    """
    return np.concatenate([nodes[:-1], (nodes[1:] + nodes[:-1]) / 2, nodes[1:]])

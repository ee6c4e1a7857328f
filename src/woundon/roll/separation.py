r"""Contact in the finished roll: between core and roll, and between the layers.

After winding the core may be removed, or shrink away from the roll, and layers may part.  A contact
presses, P >= 0, or is open, with a gap >= 0.  With the strain eps_g >= 0 by gaps between the layers
the equations of a stage (:mod:`.equations`) become

    r^2 P'' + 3 r P' + P - E_t F(P) = C - E_t eps_g,   P >= 0,   eps_g >= 0,   P eps_g = 0,
    (gap at the core)/r_c = (b P - T_c - Q)/E_t,       P >= 0,   gap >= 0,     P gap = 0.

Open layers carry nothing, P = Q = 0, and eps_g = C/E_t.  The layers on either side of an open zone
are therefore rolls of their own, with P = 0 at their ends.  At the edge of an open zone inside the
roll Q = 0 too, which determines its radius.

So written the equations are those of thin layers.  With layers that are wound under the pressure p
of half a layer (:class:`.Layers`), the total P + p and its slope take the place of P and Q in these
conditions, and eps_g = C/E_t - F(p): layers that are compressed less fill a part of the gap.

For E_r < E_t the equations are those of the minimum of a strictly convex energy under P >= 0: there
is one solution, whichever change opened the contacts, and in whatever order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .build_up import Layers
from .equations import CellSource, StageData, StageEquations, StageSolution

__all__ = [
    "ContactZones",
    "NotSeparatedError",
    "contact_zones",
    "solve_on_core",
    "with_open_layers",
]

Array = np.ndarray
NodesBetween = Callable[[float, float], Array]  # ln r of both ends -> ln r of the nodes

PARTS = 4  # cells of the finite differences in each cell of the roll
MOST_STEPS = 200  # of the active set
STEP_TOLERANCE = 1e-9  # relative change of the pressure by the last step of the active set
# of Q at an edge, relative to the largest pressure, or T_c if that is larger
EDGE_TOLERANCE = 1e-9
SHORTEST = 1e-3  # of a cell of the finite differences: shortest zone on the core
NEGLIGIBLE = 1e-5  # pressure, relative to the largest as wound: all layers are open
OPEN_CELLS = 8  # in each open zone


class NotSeparatedError(ArithmeticError):
    """The open zones of a roll could not be determined; the text says why."""


class ContactZones(NamedTuple):
    """The zones of a finished roll whose layers are in contact, one after the other.

    Attributes
    ----------
    nodes : (n,) int array
        Numbers of their nodes, with both ends of each zone.
    gaps : (J - 1,) int array
        Last node of each zone but the last one, counted in ``nodes``.
    off_core : (J,) bool array
        True for a zone without contact at its inner end.
    """

    nodes: Array
    gaps: Array
    off_core: Array

    def stage(self, layers: Layers, x: Array, source: CellSource, T_c: float) -> StageData:
        """Return the equations of the zones, whose outer ends carry nothing.

        Parameters
        ----------
        layers : Layers
        x : (M,) array
            ln r of all nodes.
        source : CellSource
            Of all cells, (M - 1,) each [Pa].
        T_c : float
            Of the core condition [Pa].
        """
        cells, nodes = self.nodes[:-1], x[self.nodes]
        ends = np.append(nodes[self.gaps], nodes[-1])
        return StageData(
            nodes,
            CellSource(*(part[cells] for part in source)),
            T_c,
            -layers.own_pressure(ends),
            self.off_core,
            self.gaps,
            own=layers.own(nodes),
        )

    def spread(self, values: Array, count: int) -> Array:
        """Return values at all ``count`` nodes, zero in open zones."""
        everywhere = np.zeros(count)
        everywhere[self.nodes] = values
        return everywhere


def contact_zones(P: Array, Q: Array, off_core: bool) -> ContactZones:
    """Return the zones in contact of a solution, whose P and Q are exactly zero where it is open.

    Parameters
    ----------
    P, Q : (M,) arrays
        Pressure and Q = r dP/dr at the nodes [Pa].
    off_core : bool
        True without contact between core and roll.
    """
    is_open = (P == 0) & (Q == 0)
    cells = ~(is_open[:-1] & is_open[1:])  # cells in contact
    nodes = np.flatnonzero(np.append(cells, False) | np.append(False, cells))
    (gaps,) = np.nonzero(~cells[nodes[:-1]])
    first = off_core or bool(nodes.size and nodes[0] > 0)
    return ContactZones(nodes, gaps, np.append(first, np.ones(gaps.size, dtype=bool)))


def solve_on_core(
    equations: StageEquations, data: StageData, P: Array, Q: Array, removed: bool | Array
) -> tuple[StageSolution, Array] | None:
    """Solve for stages that press on the core, or have left it; None if that does not converge.

    Parameters
    ----------
    equations : StageEquations
    data : StageData
        Of J stages; ``off_core`` is the initial guess.
    P, Q : (n + 1,) arrays
        Initial guess [Pa].
    removed : bool or (J,) bool array
        True for a stage that never presses on the core: it is removed, or layers are open.

    Returns
    -------
    StageSolution, (J,) bool array
        The solution, and True for each stage without contact with the core.
    """
    firsts = data.firsts
    off = np.broadcast_to(data.off_core, firsts.shape) | removed
    for _ in range(2 + firsts.size):
        solved = equations.solve(replace(data, off_core=off), P, Q)
        if solved is None:
            return None
        P, Q = solved.P, solved.Q
        pressure = data.total(P)[firsts]
        gap = equations.core * P[firsts] - data.tension - Q[firsts]  # times E_t/r_c
        changed = np.where(off, gap >= 0, pressure < 0) | removed
        if (changed == off).all():
            return solved, off
        off = changed
    return None


def with_open_layers(
    layers: Layers,
    source_at: Callable[[Array], CellSource],
    nodes_between: NodesBetween,
    T_c: float,
    guess: tuple[Array, Array],
    removed: bool,
) -> tuple[Array, Array, Array]:
    """Solve for a finished roll with open zones between its layers.

    Finite differences with an active set give the nodes in contact; the edges of the zones are then
    moved until Q = 0 there, with the equations of order four on each zone.

    Parameters
    ----------
    layers : Layers
        Of the roll at rest.
    source_at : callable
        Returns C in the cells between nodes ln r, with the changes after winding [Pa].
    nodes_between : callable
        Returns the nodes ln r between two ends ln r.
    T_c : float
        Of the core condition, with the changes after winding [Pa].
    guess : (x, P)
        ln r from core to surface, and a total pressure there, such as that as wound [Pa].
    removed : bool
        True for a core that is removed.

    Returns
    -------
    three (M,) arrays
        Nodes ln r, the total pressure and r times its gradient [Pa], which are exactly zero in open
        zones and at their edges.

    Raises
    ------
    NotSeparatedError
    """
    x, P = guess
    fine = np.interp(np.arange(PARTS * (x.size - 1) + 1) / PARTS, np.arange(x.size), x)
    differences = _Differences(layers, fine, source_at(fine), T_c, removed)
    coarse = differences.solve(np.maximum(np.interp(fine, x, P), 0.0))
    zones = _zones_of(coarse > 0)
    if coarse[0] == 0 and T_c > 0 and not removed:
        zones.insert(0, (0, 0))  # on the core, thinner than a cell of the finite differences
    if not zones or 0 < np.max(coarse) <= NEGLIGIBLE * np.max(P):
        raise NotSeparatedError("all layers separate")
    in_contact = _Zones(layers, source_at, nodes_between, T_c, fine, coarse)
    solved = [in_contact.solve(first, last) for first, last in zones]
    return _with_open_zones(solved, float(x[0]), float(x[-1]))


def _zones_of(pressed: Array) -> list[tuple[int, int]]:
    """Return the first and the last node of each run of nodes that are pressed."""
    steps = np.diff(np.concatenate([[0], pressed.astype(int), [0]]))
    firsts, lasts = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


class _Differences:
    """The equations of a finished roll by finite differences, with an active set of open nodes.

    P is the pressure in addition to ``own``, that under which the layers are wound.  With x = ln r,
    r^2 P'' + 3 r P' = exp(-2 x) D(exp(2 x) D P).  The residual of the cell about each node is (E_t
    times) its strain by gaps times the width of the cell; the matrix has no positive entry off its
    diagonal, so that the active-set iteration converges.
    """

    def __init__(
        self, layers: Layers, x: Array, source: CellSource, T_c: float, removed: bool
    ) -> None:
        self.equations, self.x, self.T_c, self.removed = layers.equations, x, T_c, removed
        self.own = layers.own_pressure(x)
        h = np.diff(x)
        self.to_outer, self.to_inner = np.exp(h) / h, np.exp(-h) / h
        before, behind = np.append(0.0, h) / 2, np.append(h, 0.0) / 2
        self.width = before + behind
        C = before * np.append(0.0, source.right) + behind * np.append(source.left, 0.0)
        self.source = C  # times the width

    def residual(self, P: Array) -> Array:
        """Return the residual at pressures P >= -own, (n + 1,) [Pa]."""
        steps, equations = np.diff(P), self.equations
        F = equations.strain(P + self.own) - equations.strain(self.own)
        out = self.width * (equations.tangential * F - P) + self.source
        out[:-1] -= self.to_outer * steps
        out[1:] += self.to_inner * steps
        out[0] += equations.core * P[0] - self.T_c
        return np.asarray(out)

    def solve(self, total: Array) -> Array:
        """Return the total pressure, (n + 1,) [Pa], zero at open nodes, from an initial guess.

        Raises
        ------
        NotSeparatedError
        """
        from scipy.linalg import solve_banded

        equations = self.equations
        for _ in range(MOST_STEPS):
            residual = self.residual(total - self.own)
            diagonal = self.width * (equations.tangential / equations.modulus(total) - 1)
            diagonal[:-1] += self.to_outer
            diagonal[1:] += self.to_inner
            diagonal[0] += equations.core
            is_open = total * diagonal < residual
            is_open[-1] = True
            is_open[0] |= self.removed
            matrix = np.zeros((3, total.size))
            matrix[0, 1:] = np.where(is_open[:-1], 0.0, -self.to_outer)
            matrix[1] = np.where(is_open, 1.0, diagonal)
            matrix[2, :-1] = np.where(is_open[1:], 0.0, -self.to_inner)
            step = solve_banded((1, 1), matrix, np.where(is_open, total, residual))
            total = total - step
            total[is_open] = 0.0
            if np.max(np.abs(step)) <= STEP_TOLERANCE * np.max(np.abs(total)):
                return np.where(total > 0, total, 0.0)
        raise NotSeparatedError("the zones in which the layers separate are not found")


class _Zones:
    """The equations of zones of layers in contact, whose ends may be edges of open zones.

    Attributes
    ----------
    x, P : (n + 1,) arrays
        ln r from core to surface, and the total pressure by finite differences [Pa].
    """

    def __init__(
        self,
        layers: Layers,
        source_at: Callable[[Array], CellSource],
        nodes_between: NodesBetween,
        T_c: float,
        x: Array,
        P: Array,
    ) -> None:
        self.layers, self.source_at, self.nodes_between = layers, source_at, nodes_between
        self.T_c, self.x, self.P = T_c, x, P

    def solve(self, first: int, last: int) -> tuple[Array, Array, Array]:
        """Return nodes ln r, total pressure and gradient of a zone, both 0 at edges of open zones.

        Parameters
        ----------
        first, last : int
            Its first and last node with a pressure, by finite differences.

        Raises
        ------
        NotSeparatedError
        """
        x, on_core = self.x, first == 0
        # the ends, 0 and -1, that are edges, between the neighbours of an open and a pressed node
        edges = {}
        if first > 1:
            edges[0] = x[first - 2], x[first + 1]
        if last < x.size - 2:
            edges[-1] = x[max(last - 1, 0)], x[last + 2]
        nodes, P, Q = self._with_edges(edges, on_core)
        # tension at an end that is none: an open zone thinner than a cell of the differences
        if 0 not in edges and not on_core and Q[0] < 0:
            edges[0] = x[0], x[2]
        if -1 not in edges and Q[-1] > 0:
            edges[-1] = x[-3], x[-1]
        nodes, P, Q = self._with_edges(edges, on_core)
        for end in edges:
            P[end] = Q[end] = 0.0
        return nodes, P, Q

    def _with_edges(
        self, edges: Mapping[int, tuple[float, float]], on_core: bool
    ) -> tuple[Array, Array, Array]:
        """Return nodes, total pressure and gradient of a zone, with no gradient at its edges.

        ``edges`` are intervals in which the edges lie, by the number of the end: 0 or -1.
        """
        from scipy.optimize import brentq, root

        names, scale = list(edges), max(float(np.max(self.P)), abs(self.T_c))

        def with_edges_at(places: Array | float) -> tuple[Array, Array, Array]:
            """Return the zone with edges at given places in their intervals."""
            ends = [float(self.x[0]), float(self.x[-1])]
            for name, place in zip(names, np.atleast_1d(places), strict=True):
                ends[name] = float(np.clip(place, *edges[name]))
            return self._between(ends[0], ends[1], on_core)

        def gradients(places: Array | float) -> Array:
            """Return Q at the edges, relative to the stresses of the roll."""
            return np.asarray(with_edges_at(places)[2][names] / scale)

        places = np.zeros(0)
        if len(names) == 1:
            low, high = edges[names[0]]
            low = max(low, self.x[0] + SHORTEST * (self.x[1] - self.x[0]))
            if gradients(low)[0] * gradients(high)[0] > 0:
                raise NotSeparatedError("the edge of an open zone is not found")
            places = np.array([brentq(lambda place: gradients(place)[0], low, high, xtol=1e-15)])
        elif names:
            places = root(gradients, [sum(edges[name]) / 2 for name in names], tol=1e-13).x
        nodes, P, Q = with_edges_at(places)
        if np.any(np.abs(Q[names]) > EDGE_TOLERANCE * scale):
            raise NotSeparatedError("the edges of an open zone are not found")
        return nodes, P, Q

    def _between(self, left: float, right: float, on_core: bool) -> tuple[Array, Array, Array]:
        """Return the zone with given ends, which carry nothing but for an end on the core."""
        nodes, layers = self.nodes_between(left, right), self.layers
        own = layers.own_pressure(nodes)
        data = StageData(
            nodes,
            self.source_at(nodes),
            self.T_c,
            -own[-1],
            off_core=not on_core,
            own=layers.own(nodes),
        )
        P = np.interp(nodes, self.x, self.P) - own
        solved = layers.equations.solve(data, P, np.gradient(P, nodes))
        if solved is None:
            raise NotSeparatedError("a zone between open layers has no equilibrium")
        return nodes, *layers.total(nodes, solved.P, solved.Q)


def _with_open_zones(
    zones: list[tuple[Array, Array, Array]], start: float, end: float
) -> tuple[Array, Array, Array]:
    """Return nodes, P and Q of all zones in contact, and of the open ones between them.

    ``start`` and ``end`` are ln r of core and surface.
    """
    parts: list[tuple[Array, Array, Array]] = []
    inner = start
    for nodes, P, Q in zones:
        parts += _open_zone(inner, float(nodes[0]), with_start=inner == start)
        parts.append((nodes, P, Q))
        inner = float(nodes[-1])
    parts += _open_zone(inner, end, with_end=True)
    x, P, Q = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return x, P, Q


def _open_zone(
    inner: float, outer: float, *, with_start: bool = False, with_end: bool = False
) -> list[tuple[Array, Array, Array]]:
    """Return nodes, P and Q of an open zone, without its edges; no zone if it has no extent."""
    if not outer > inner:
        return []
    nodes = np.linspace(inner, outer, OPEN_CELLS + 1)[
        (0 if with_start else 1) : (None if with_end else -1)
    ]
    return [(nodes, np.zeros(nodes.size), np.zeros(nodes.size))]

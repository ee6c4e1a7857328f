"""Meshes of a nip and of the wraps next to it.

Coordinates are in units of the half width a, positive in the direction of web travel:

       drum wrap (optional)         nip           roll wrap (optional)
      |--|---|-----|---|--|-|||-- ... --|||-|--|---|-----|------|------|
    nodes[0]          nodes[first] = -1   nodes[last] = 1         nodes[-1]

Pressures and tractions are continuous, and linear between the nodes.  Slopes, strains and slip
velocities are collocated at one point in every cell.  The nip has the nodes x = -cos(theta) with
even steps of theta, because tractions vary as the square root of the distance from a contact edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import asinh, ceil, pi, sinh, sqrt
from typing import NamedTuple

import numpy as np

__all__ = ["Face", "Mesh", "Wrap", "cosine_nodes", "hat_weights", "nip_mesh"]

Array = np.ndarray

# Distance from a contact edge [a] up to which the cells of a wrap grow as those of the nip do; the
# fields of the web change over about a tenth of the half width next to the edge.
GRADED_LENGTH = 0.1
# Last part of the roll wrap, relative to its length, in which the curvature is that at its start
# (docs/theory/wraps.md).
END_SHARE = 0.1
# Cells at the far end of a wrap relative to those next to the nip: the hoop pressure ends there
# abruptly, but only the outputs at the end depend on it.
FAR_END_RATIO = 2.0
# Distance from a node at which one-sided values are evaluated, relative to the cell.
ONE_SIDED = 1e-9


@dataclass(frozen=True, eq=False)
class Mesh:
    """Nodes and collocation points along the web.

    Attributes
    ----------
    nodes : (N+1,) array
    points : (N,) array
        One in each cell.
    first, last : int
        Nodes at the leading and at the trailing edge of the nip.
    """

    nodes: Array
    points: Array
    first: int
    last: int

    @property
    def nip_cells(self) -> slice:
        """The cells of the nip."""
        return slice(self.first, self.last)

    @property
    def nip_nodes(self) -> slice:
        """The nodes of the nip, edges included."""
        return slice(self.first, self.last + 1)

    @cached_property
    def cells(self) -> Array:
        """Cell lengths, (N,)."""
        return self.nodes[1:] - self.nodes[:-1]  # a third of the time of np.diff

    @cached_property
    def fraction(self) -> Array:
        """Position of each point in its cell, from 0 to 1, (N,)."""
        return (self.points - self.nodes[:-1]) / self.cells

    @cached_property
    def weights(self) -> Array:
        """Integrals of the nodal hat functions, (N+1,)."""
        return hat_weights(self.cells)

    @cached_property
    def nip_weights(self) -> Array:
        """Integrals over the nip of the hat functions that vanish at the trailing edge, (N+1,)."""
        out = np.zeros(self.nodes.size)
        out[self.nip_nodes] = hat_weights(self.cells[self.nip_cells])
        out[self.last] = 0.0
        return out

    @cached_property
    def integral_to_nodes(self) -> Array:
        """Integral of a nodal function from the first node to each node, (N+1, N+1)."""
        # in the row of a node the complete hats of all nodes upstream of it
        out = np.tril(np.broadcast_to(self.weights, (self.nodes.size,) * 2), -1)
        k = np.arange(1, self.nodes.size)
        out[k, k] = self.cells / 2  # the upstream half of the hat of the node
        return out

    @cached_property
    def integral_to_points(self) -> Array:
        """Integral from the first node to each point, (N, N+1), with lumped hats.

        The integral of a hat function is attributed to its node: it is included completely from
        the next point on.  Then the slip of each node increases with its own traction, which makes
        the stick-slip problem unique (P-matrix).  Exact integrals lead to oscillating tractions
        against a rigid drum.
        """
        return np.tril(np.broadcast_to(self.weights, (self.nodes.size,) * 2))[:-1]

    @cached_property
    def hats(self) -> Array:
        """Values of the nodal hat functions at the points, (N, N+1)."""
        k, out = np.arange(self.cells.size), np.zeros((self.cells.size, self.nodes.size))
        out[k, k], out[k, k + 1] = 1 - self.fraction, self.fraction
        return out

    def at_points(self, values: Array) -> Array:
        """Interpolate nodal values (N+1,) at the collocation points."""
        return values[:-1] * (1 - self.fraction) + values[1:] * self.fraction

    @cached_property
    def roll_face(self) -> Face:
        """The part of the mesh on which the roll touches the web."""
        return Face(self, self.first, self.nodes.size - 1)

    @cached_property
    def drum_face(self) -> Face:
        """The part of the mesh on which the drum touches the web."""
        return Face(self, 0, self.last)


class Face:
    """The nodes and points on which a body touches the web.

    Parameters
    ----------
    mesh : Mesh
    start, stop : int
        First and last node, both included.

    Attributes
    ----------
    nodes : (n,) array
    points : (n+1,) array
        One in each cell, then one just downstream of the trailing edge of the nip, then the last
        node.  The last two coincide where the face ends at the trailing edge.
    first, last : int
        Nodes of the face at the leading and at the trailing edge of the nip.
    cells : (n-1,) array
        Cell lengths.
    nip_cells : slice
        The cells of the nip among those of the face.
    """

    def __init__(self, mesh: Mesh, start: int, stop: int) -> None:
        self.nodes, self.cells = mesh.nodes[start : stop + 1], mesh.cells[start:stop]
        self.first, self.last = mesh.first - start, mesh.last - start
        self.nip_cells = slice(self.first, self.last)
        self.size = mesh.last - mesh.first + 1
        # one-sided: slopes and strains jump at the edge, and are infinite at the end of a wrap
        edge, end = self.nodes[self.last], self.nodes[-1]
        if self.extends_downstream:
            edge = edge + ONE_SIDED * self.cells[self.last]
            end = end - ONE_SIDED * self.cells[-1]
        self.points = np.concatenate([mesh.points[start:stop], [edge, end]])

    @property
    def extends_downstream(self) -> bool:
        """True if the body touches the web downstream of the nip."""
        return self.last < self.nodes.size - 1

    @property
    def is_nip(self) -> bool:
        """True if the face has no wrap."""
        return self.nodes.size == self.size

    @cached_property
    def weights(self) -> Array:
        """Integrals of the nodal hat functions of the face, (n,)."""
        return hat_weights(self.cells)

    @cached_property
    def hats(self) -> Array:
        """Values of the nodal hat functions at the points, (n+1, n)."""
        k, out = np.arange(self.cells.size), np.zeros((self.points.size, self.nodes.size))
        fraction = (self.points[:-2] - self.nodes[:-1]) / self.cells
        out[k, k], out[k, k + 1] = 1 - fraction, fraction
        # the last two points are at the nodes of the trailing edge and of the end
        out[-2, self.last] = out[-1, -1] = 1.0
        return out

    @cached_property
    def derivative(self) -> Array:
        """Derivative of a nodal function at the points, per unit of a, (n+1, n)."""
        k, out = np.arange(self.cells.size), np.zeros((self.points.size, self.nodes.size))
        out[k, k], out[k, k + 1] = -1 / self.cells, 1 / self.cells
        # the last two points: the cell downstream of the trailing edge (if any), and the last cell
        out[-2] = out[min(self.last, self.cells.size - 1)]
        out[-1] = out[-3]
        return out

    def displacement_at_nodes(self, slope: Array, end: Array | float, a: float) -> Array:
        """Return v at the nodes (n, ...) from slopes at the points and v at the trailing edge.

        ``slope`` is dv/dx [1], (n+1, ...), ``end`` the v at the edge [m], ``a`` the half width [m].
        """
        # the last two points, at the edge and at the end, belong to no cell of their own
        steps = (a * self.cells).reshape(-1, *(1,) * (slope.ndim - 1)) * slope[:-2]
        v = np.zeros((self.nodes.size, *slope.shape[1:]))
        steps.cumsum(axis=0, out=v[1:])
        v += end - v[self.last]
        return v

    def curvature_change(self, slope: Array, a: float, ends: bool = True) -> Array:
        """Return -v'' at the nodes (n, ...) from slopes v' at the points (n+1, ...).

        ``a`` is the half width [m]; ``ends`` tells whether the pressure that deforms the surface
        ends with the face, as that on another face does not.

        The difference quotient of the slopes at neighbouring points satisfies the normal
        equilibrium of every piece of web exactly.  The curvature at the trailing edge is that of
        its downstream side: the web follows the drum upstream of the edge, and the roll downstream.
        """
        y, inner = self.points[:-2], slope[:-2]  # in the cells, without the edge and the end
        out = np.zeros((self.nodes.size, *slope.shape[1:]))
        distance = (a * (y[1:] - y[:-1])).reshape(-1, *(1,) * (slope.ndim - 1))
        out[1:-1] = (inner[:-1] - inner[1:]) / distance
        if self.extends_downstream:
            # extrapolate linearly from the mean between the edge and the first point downstream
            e, half = self.last, (y[self.last] - self.nodes[self.last]) / 2
            mean = (inner[e] - slope[-2]) / (-2 * a * half)  # slope[-2] is that at the edge
            fraction = half / self.cells[e]
            out[e] = (mean - fraction * out[e + 1]) / (1 - fraction)
        if self.extends_downstream and ends:
            # the end of the pressure bends the surface next to it without limit
            x = self.nodes[-1] - END_SHARE * (self.nodes[-1] - self.nodes[e])
            k = min(int(self.nodes.searchsorted(x)), self.nodes.size - 2)
            fraction = min((x - self.nodes[k - 1]) / self.cells[k - 1], 1.0)
            out[k:] = (1 - fraction) * out[k - 1] + fraction * out[k]
        out[0], out[-1] = out[1], out[-2]
        return out


def hat_weights(cells: Array) -> Array:
    """Return the integrals of the hat functions over neighbouring cells, (N+1,)."""
    out = np.zeros(cells.size + 1)
    out[:-1] = cells
    out[1:] += cells
    return out / 2


class Wrap(NamedTuple):
    """A wrap of the web next to the nip.

    Attributes
    ----------
    length : float
        Outside the nip, in units of the half width; 0 for none.
    radius : float
        Of the body, in units of the half width; it limits the length of the cells.
    graded_end : bool
        True if cells are graded to the far end too, as where the web meets the drum.
    """

    length: float = 0.0
    radius: float = 1.0
    graded_end: bool = False


def nip_mesh(size: int, drum_wrap: Wrap, roll_wrap: Wrap, like: Mesh | None = None) -> Mesh:
    """Return the mesh of a nip and its wraps.

    Parameters
    ----------
    size : int
        Nodes of the nip, edges included.
    drum_wrap, roll_wrap : Wrap
    like : Mesh, optional
        A mesh with the same numbers of cells, of another half width of the same problem.
    """
    x = cosine_nodes(size)
    step = pi / (size - 1) / sqrt(2 * GRADED_LENGTH)  # continues the growth of the nip's cells
    cells = (0, 0) if like is None else (like.first, like.nodes.size - 1 - like.last)
    upstream = _wrap_points(drum_wrap, step, cells[0])
    downstream = _wrap_points(roll_wrap, step, cells[1])
    # the first distance, 0, is the edge of the nip, which x contains
    nodes_and_points = np.concatenate([-1 - upstream[:0:-1], x, 1 + downstream[1:]])
    first = upstream.size // 2
    return Mesh(nodes_and_points[0::2], nodes_and_points[1::2], first, first + size - 1)


@lru_cache(maxsize=64)
def cosine_nodes(size: int) -> Array:
    """Return nodes (even entries) and points (odd entries) of a nip, x = -cos(theta).

    (2 size - 1,) from -1 to 1.
    """
    x = np.sin(np.linspace(-pi / 2, pi / 2, 2 * size - 1))
    out = (x - x[::-1]) / 2  # exactly antisymmetric
    out.setflags(write=False)
    return out


def _wrap_points(wrap: Wrap, step: float, cells: int) -> Array:
    """Return the distances of nodes (even entries) and points (odd entries) from the nip.

    They ascend from 0 at the edge of the nip to the end of the wrap.  ``step`` is that of the
    grading, ``cells`` the number of cells; 0 for that of the grading.
    """
    if not wrap.length:
        return np.zeros(1)
    # one step of the grading in rad: cells of the whole wrap shrink with those of the nip
    largest = step * wrap.radius
    if not wrap.graded_end:
        grading = _Grading(wrap.length, step, largest)
        return grading.points(cells or grading.cells)
    near_nip = _Grading(wrap.length / 2, step, largest)
    far_end = _Grading(wrap.length / 2, FAR_END_RATIO * step, largest)
    n_near, n_far = near_nip.cells, far_end.cells
    if cells:  # shared between both halves in the same ratio
        n_far = max(1, round(cells * n_far / (n_near + n_far)))
        n_near = cells - n_far
    # [-2::-1]: in reverse, without the node in the middle of the wrap, which both halves contain
    return np.concatenate([near_nip.points(n_near), wrap.length - far_end.points(n_far)[-2::-1]])


class _Grading:
    """Distances d = c sinh^2(t) of nodes and points from one end, with even steps of t.

    The growth is quadratic next to the end, as on a cosine mesh, then geometric, and stops where
    cells reach the largest permitted length: there d continues linearly in t.

    Parameters
    ----------
    length : float
        Of the graded part of the wrap [a].
    step : float
        Of t from node to node.
    largest : float
        Largest length of a cell [a].
    """

    def __init__(self, length: float, step: float, largest: float) -> None:
        c = GRADED_LENGTH
        self.t_linear = asinh(largest / (c * step)) / 2  # c sinh(2 t) step = largest
        self.d_linear, self.slope = c * sinh(self.t_linear) ** 2, c * sinh(2 * self.t_linear)
        if length <= self.d_linear:
            self.end = asinh(sqrt(length / c))
        else:
            self.end = self.t_linear + (length - self.d_linear) / self.slope
        self.cells = max(2, ceil(self.end / step))

    def points(self, cells: int) -> Array:
        """Return nodes (even entries) and points (odd entries), (2 cells + 1,)."""
        t = np.arange(2 * cells + 1) * (self.end / (2 * cells))
        graded = GRADED_LENGTH * np.sinh(np.minimum(t, self.t_linear)) ** 2
        linear = self.d_linear + self.slope * (t - self.t_linear)
        return np.where(t <= self.t_linear, graded, linear)

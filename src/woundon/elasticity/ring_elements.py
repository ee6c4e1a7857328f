r"""Finite elements of a ring on a rigid core, cut for a contact on its surface.

Nine-node quadratic elements in the plane (x, r), x = R theta along the surface: columns are graded
to both edges of the contact, rows to the surface, and the ring is closed.  The strains of
displacements v (along r) and u (along x) are

    e_r = dv/dr,   e_t = (R/r) du/dx + v/r,   gamma = (R/r) dv/dx + du/dr - u/r.

The unknowns of the surface are eliminated last.  The last block of the factors of the stiffness
matrix K = L U is then the Schur complement, and its inverse the compliance of the surface,

    K = [ K_ii  K_is ]      L = [ L_ii       ]   U = [ U_ii  U_is ]
        [ K_si  K_ss ]          [ L_si  L_ss ]       [       U_ss ],    dw/df = (L_ss U_ss)^-1.

A periodic cubic spline through the nodal displacements of the surface gives continuous slopes, also
at the nodes, where the slopes of the elements jump.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import pi
from typing import Literal

import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import SuperLU, splu

__all__ = ["Factors", "Fineness", "RingMesh", "Topology", "ring_topology"]

Array = np.ndarray

FIRST_ROW = 0.06  # height of the first row, of the width of the first column inside the contact
GAUSS = -0.5 / 3**0.5, 0.5 / 3**0.5


@dataclass(frozen=True)
class Fineness:
    """The numbers of elements of a ring.

    Attributes
    ----------
    inside, outside, rows : int
        Columns of elements under the contact, on either side of it, and rows.
    """

    inside: int
    outside: int
    rows: int

    @property
    def columns(self) -> int:
        """All columns."""
        return self.inside + 2 * self.outside


@dataclass(frozen=True, eq=False)
class Topology:
    """Shape functions and numbering of a ring of e = columns x rows elements, without geometry.

    Attributes
    ----------
    value, by_x, by_r : (9, 9) arrays
        Shape functions on the unit square at nine points, (function, point), and derivatives along
        x and r.
    points : (2, 9) array
        The quadrature points on the unit square; ``weights`` (9,) belong to them.
    nodes : (e, 9) int array
        Nodes of each element, numbered along x, circle after circle from the core.
    column, row : (e,) int arrays
        Column and row of each element, from x = -pi R and from the core.
    numbers : (2 rows + 1, 2 columns, 2) int array
        Unknowns v and u of all nodes, the surface's last; those of the core are -1.
    """

    value: Array
    by_x: Array
    by_r: Array
    points: Array
    weights: Array
    nodes: Array
    column: Array
    row: Array
    numbers: Array

    @cached_property
    def unknowns(self) -> Array:
        """Unknowns of each element, (e, 18)."""
        e = self.nodes.shape[0]
        return np.asarray(self.numbers.reshape(-1, 2)[self.nodes].reshape(e, 18))

    @property
    def surface(self) -> Array:
        """Unknowns v and u of the surface's nodes, (2, k)."""
        return np.asarray(self.numbers[-1].T)

    @cached_property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.numbers.max()) + 1

    @cached_property
    def _entries(self) -> tuple[Array, Array, Array, Array]:
        """The pattern of the assembled matrix, in compressed columns (CSC).

        Four int arrays: the entries of the element matrices, flattened, that are assembled (those
        of core nodes are not); the place of each in the data of the sparse matrix, which adds
        entries with the same row and column; row indices and column pointers of the sparse matrix.
        """
        n, ids = self.size, self.unknowns
        i = np.broadcast_to(ids[:, :, None], (*ids.shape, 18)).ravel()
        j = np.broadcast_to(ids[:, None, :], (*ids.shape, 18)).ravel()
        assembled = np.nonzero((i >= 0) & (j >= 0))[0]
        flat, slot = np.unique(j[assembled] * n + i[assembled], return_inverse=True)
        return assembled, slot, flat % n, np.searchsorted(flat, np.arange(n + 1) * n)

    def matrix(self, elements: Array) -> sparse.csc_matrix:
        """Assemble element matrices (e, 18, 18)."""
        assembled, slot, indices, pointers = self._entries
        data = np.bincount(slot, elements.ravel()[assembled], indices.size)
        return sparse.csc_matrix((data, indices, pointers), shape=(self.size,) * 2)

    def vector(self, elements: Array) -> Array:
        """Assemble element vectors (e, 18)."""
        # the unknowns of the core, numbered -1, are added to the first entry, which is left out
        return np.bincount(self.unknowns.ravel() + 1, elements.ravel(), self.size + 1)[1:]

    def element_unknowns(self, u: Array) -> Array:
        """Return the unknowns of each element, zero at the core, (e, 18)."""
        # the core is numbered -1, which is the appended zero
        return np.asarray(np.append(u, 0.0)[self.unknowns])

    def nodal_field(self, u: Array) -> Array:
        """Return v and u of the nodes, zero at the core, (2 rows + 1, 2 columns, 2)."""
        # the core is numbered -1, which is the appended zero
        return np.asarray(np.append(u, 0.0)[self.numbers])


@lru_cache(maxsize=16)
def ring_topology(columns: int, rows: int) -> Topology:
    """Return shape functions and numbering of a ring of columns x rows elements.

    Quadratic elements of nine nodes, all of them unit squares here; :class:`RingMesh` scales them.
    Shape functions and their derivatives are those of scikit-fem, in the coordinates of its own
    reference element; they are returned in those of the unit square along x and r.
    """
    from skfem import Basis, ElementQuad2, MeshQuad  # only hardening rolls need it

    # the element of column i and row k is the square from (i, k) to (i + 1, k + 1)
    mesh = MeshQuad.init_tensor(np.arange(columns + 1.0), np.arange(rows + 1.0))
    basis = Basis(mesh, ElementQuad2(), intorder=5)  # three Gauss points in each direction
    points, weights = basis.quadrature
    shapes = [basis.elem.lbasis(points, k) for k in range(9)]
    corner = mesh.p[:, mesh.t].min(axis=1)
    # the map from the reference element to the first square, which is the same for all squares: the
    # quadrature points in it, and by the chain rule the derivatives along x and r
    local = basis.mapping.F(points)[:, 0] - corner[:, :1]
    inverse = np.linalg.inv(basis.mapping.DF(points)[:, :, 0, 0])
    by_x, by_r = np.einsum("ji,kjq->ikq", inverse, np.array([slopes for _, slopes in shapes]))
    column, row = corner.astype(int)
    # nodes are at corners and middles: their numbers along x and r are twice their coordinates
    x, r = np.rint(2 * basis.doflocs).astype(int)
    # the ring is closed: the last column of nodes is the first
    nodes = (x % (2 * columns) + 2 * columns * r)[basis.element_dofs.T]
    return Topology(
        np.array([values for values, _ in shapes]),
        by_x,
        by_r,
        local,
        weights,
        nodes,
        column,
        row,
        _number_unknowns(nodes, 2 * columns, 2 * rows),
    )


def _number_unknowns(nodes: Array, columns: int, rows: int) -> Array:
    """Number v and u of every node: core -1, interior by minimum degree, surface last.

    The ordering of the interior nodes reduces the fill-in of the factors.

    Parameters
    ----------
    nodes : (e, 9) int array
    columns, rows : int
        Nodes along a circle, and intervals between the circles of nodes.

    Returns
    -------
    (rows + 1, columns, 2) int array
    """
    interior = columns * (rows - 1)
    ids = np.where(nodes < columns * rows, nodes - columns, -1)
    i, j = np.broadcast_arrays(ids[:, :, None], ids[:, None, :])
    used = (i >= 0) & (j >= 0)
    # a diagonally dominant matrix with the pattern of K: SuperLU returns the ordering
    entries = np.where(i == j, 100.0, 1.0)[used]
    graph = sparse.csc_matrix((entries, (i[used], j[used])), shape=(interior, interior))
    order = np.full(columns * (rows + 1), -1)
    order[columns : columns * rows] = _factorise(graph, "MMD_AT_PLUS_A").perm_c
    order[columns * rows :] = interior + np.arange(columns)
    numbers = np.where(order[:, None] < 0, -1, 2 * order[:, None] + np.arange(2))
    return np.asarray(numbers.reshape(rows + 1, columns, 2))


def _factorise(matrix: sparse.csc_matrix, order: Literal["NATURAL", "MMD_AT_PLUS_A"]) -> SuperLU:
    """Factorise a symmetric positive definite matrix."""
    return splu(
        matrix.astype(np.float64),
        permc_spec=order,
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


class Factors:
    """A factored stiffness matrix."""

    def __init__(self, topology: Topology, matrix: sparse.csc_matrix) -> None:
        self._lu = _factorise(matrix, "NATURAL")
        self._surface = topology.surface

    def solve(self, f: Array) -> Array:
        """Return the displacements under the forces f."""
        return np.asarray(self._lu.solve(f))

    @cached_property
    def compliance(self) -> Array:
        """Displacements of the surface by the forces on it, (2, k, 2, k)."""
        shape = self._surface.shape
        first = self._lu.shape[0] - self._surface.size  # the unknowns of the surface are the last
        L, U = (fraction[first:, first:].toarray() for fraction in (self._lu.L, self._lu.U))
        k = (self._surface - first).ravel()
        return np.linalg.inv(L @ U)[np.ix_(k, k)].reshape(shape + shape)


class RingMesh:
    """The elements of a ring for one half width.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m].
    fineness : Fineness
    a : float
        Half width of the contact [m].

    Attributes
    ----------
    x : (columns + 1,) array
        Boundaries of the columns, from -pi R to pi R, the contact in the middle [m].
    r : (rows + 1,) array
        Boundaries of the rows, from the core to the surface [m].
    """

    def __init__(self, radius: float, core_radius: float, fineness: Fineness, a: float) -> None:
        self.radius, self.half_width, self.fineness = radius, a, fineness
        self.topology = ring_topology(fineness.columns, fineness.rows)
        t = np.arange(fineness.inside + 1) / fineness.inside
        inside = a * (2 * t**2 / (t**2 + (1 - t) ** 2) - 1)  # quadratic growth from both edges
        first = inside[1] - inside[0]
        side = a + _graded(fineness.outside, first, pi * radius - a)[1:]
        self.x = np.concatenate([-side[::-1], inside, side])
        depth = _graded(fineness.rows, FIRST_ROW * first, radius - core_radius)
        self.r = radius - depth[::-1]

    @property
    def period(self) -> float:
        """The circumference [m]."""
        return 2 * pi * self.radius

    @cached_property
    def nodes(self) -> Array:
        """The surface's nodes, (k,) [m]."""
        return np.stack([self.x[:-1], (self.x[:-1] + self.x[1:]) / 2], axis=1).ravel()

    @cached_property
    def circles(self) -> Array:
        """Radii of the nodes, (2 rows + 1,) [m]."""
        middle = (self.r[:-1] + self.r[1:]) / 2
        return np.append(np.stack([self.r[:-1], middle], axis=1).ravel(), self.r[-1])

    # ---- the surface ---------------------------------------------------------------------------

    @cached_property
    def _spline(self) -> CubicSpline:
        """The cubic splines that are one at one node of the surface and zero at the others."""
        one = np.eye(self.nodes.size)
        return CubicSpline(
            np.append(self.nodes, self.x[-1]), np.vstack([one, one[:1]]), bc_type="periodic"
        )

    def splines(self, x: Array) -> tuple[Array, Array]:
        """Return values and slopes at x of the splines through unit nodal values, (n, k) each."""
        x = (x - self.x[0]) % self.period + self.x[0]
        return self._spline(x), self._spline(x, 1)

    def hat_forces(self, nodes: Array) -> Array:
        """Return the nodal forces of tractions that are hat functions on the nodes of the contact.

        They do the same work on the displacements of the elements as the tractions.

        The products of hat functions (linear) and shape functions (quadratic) are integrated by
        Gauss's rule between the nodes of both.

        Parameters
        ----------
        nodes : (n,) array
            Nodes of the contact, ascending x [m].

        Returns
        -------
        (k, n) array
            Forces at the k nodes of the surface, two for each column of elements, by the n nodal
            tractions [m].
        """
        columns = self.x.size - 1
        # the ring is closed: three turns contain every x of the contact
        corners = np.concatenate([self.x[:-1] - self.period, self.x[:-1], self.x + self.period])
        inside = corners[(corners > nodes[0]) & (corners < nodes[-1])]
        breakpoints = np.union1d(nodes, inside)
        middle, h = (breakpoints[1:] + breakpoints[:-1]) / 2, np.diff(breakpoints)
        x, weight = np.concatenate([middle + s * h for s in GAUSS]), np.tile(h / 2, 2)
        # the element and the cell of the contact that contain each x, and its coordinate, 0 to 1,
        # in each of them
        element, cell = np.searchsorted(corners, x) - 1, np.searchsorted(nodes, x) - 1
        t = (x - corners[element]) / (corners[element + 1] - corners[element])
        fraction = (x - nodes[cell]) / (nodes[cell + 1] - nodes[cell])
        out = np.zeros((2 * columns, nodes.size))
        # the quadratic shape functions of the first corner, the middle and the second corner of an
        # element's edge; the elements of all turns are those of the one ring
        for j, shape in enumerate(((1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1))):
            row = (2 * element + j) % (2 * columns)
            np.add.at(out, (row, cell), weight * shape * (1 - fraction))
            np.add.at(out, (row, cell + 1), weight * shape * fraction)
        return out

    # ---- the elements --------------------------------------------------------------------------

    @property
    def _points_of_element(self) -> list[tuple[Array, Array]]:
        """The three coordinates x, then r, of an element's quadrature points, (3,) in its units.

        With each the number, from 0 to 2, of the coordinate of each of the nine points.
        """
        # the coordinates of a column or row are equal except for rounding
        rounded = (np.round(coordinate, 12) for coordinate in self.topology.points)
        return [np.unique(coordinate, return_inverse=True) for coordinate in rounded]

    @property
    def quadrature_grid(self) -> tuple[Array, Array]:
        """The quadrature points, ascending x (3 columns,) and r (3 rows,) [m]."""
        (a, _), (b, _) = self._points_of_element
        x = (self.x[:-1, None] + np.diff(self.x)[:, None] * a).ravel()
        return x, (self.r[:-1, None] + np.diff(self.r)[:, None] * b).ravel()

    def on_quadrature_grid(self, values: Array) -> Array:
        """Return values (e, 9) at the points of :attr:`quadrature_grid`, (3 rows, 3 columns)."""
        topology = self.topology
        (_, i), (_, j) = self._points_of_element
        out = np.empty((3 * self.fineness.rows, 3 * self.fineness.columns))
        out[3 * topology.row[:, None] + j, 3 * topology.column[:, None] + i] = values
        return out

    @cached_property
    def quadrature_radii(self) -> Array:
        """r at the quadrature points of each element, (e, 9) [m]."""
        topology = self.topology
        return np.asarray(
            self.r[topology.row, None] + np.diff(self.r)[topology.row, None] * topology.points[1]
        )

    @cached_property
    def weights(self) -> Array:
        """Quadrature weights of the area r dr dtheta = (r/R) dr dx, (e, 9) [m2]."""
        topology = self.topology
        area = np.diff(self.x)[topology.column] * np.diff(self.r)[topology.row]
        return np.asarray(topology.weights * area[:, None] * self.quadrature_radii / self.radius)

    @cached_property
    def _strains(self) -> Array:
        """B: e_r, e_t, gamma at the quadrature points by the unknowns of elements, (e, 27, 18)."""
        topology, r = self.topology, self.quadrature_radii
        width, height = np.diff(self.x)[topology.column, None], np.diff(self.r)[topology.row]
        N_x = (self.radius / (r * width))[..., None] * topology.by_x.T  # (R/r) dN/dx
        N_r = topology.by_r.T / height[:, None, None]
        N = topology.value.T / r[..., None]  # N/r
        B = np.zeros((*r.shape, 3, 18))
        B[:, :, 0, 0::2] = N_r
        B[:, :, 1, 0::2], B[:, :, 1, 1::2] = N, N_x
        B[:, :, 2, 0::2], B[:, :, 2, 1::2] = N_x, N_r - N
        return B.reshape(r.shape[0], 27, 18)

    def strain(self, u: Array) -> Array:
        """Return e_r, e_t, gamma of the displacements u at the quadrature points, (e, 9, 3)."""
        strain = self._strains @ self.topology.element_unknowns(u)[:, :, None]
        return strain.reshape(-1, 9, 3)

    def forces(self, stress: Array) -> Array:
        """Return the nodal forces in equilibrium with stresses (e, 9, 3)."""
        elements = (stress * self.weights[..., None]).reshape(-1, 1, 27) @ self._strains
        return self.topology.vector(elements)

    def stiffness(self, tangent: Array) -> Factors:
        """Return the factored stiffness matrix K = int B^T D B dV of moduli D (e, 9, 3, 3)."""
        B = self._strains
        D_B = (tangent * self.weights[..., None, None]) @ B.reshape(-1, 9, 3, 18)
        elements = B.transpose(0, 2, 1) @ D_B.reshape(-1, 27, 18)
        return Factors(self.topology, self.topology.matrix(elements))

    def interpolate(self, u: Array, other: RingMesh) -> Array:
        """Return displacements u, (size,), of another mesh on this one, linear in x and in r."""
        field = other.topology.nodal_field(u)
        x = np.append(other.nodes, other.x[-1])
        closed = np.concatenate([field, field[:, :1]], axis=1)  # the first column again at 2 pi R
        k = np.clip(np.searchsorted(x, self.nodes, "right") - 1, 0, x.size - 2)
        t = ((self.nodes - x[k]) / (x[k + 1] - x[k]))[:, None]
        field = closed[:, k] * (1 - t) + closed[:, k + 1] * t
        r = other.circles
        k = np.clip(np.searchsorted(r, self.circles, "right") - 1, 0, r.size - 2)
        t = ((self.circles - r[k]) / (r[k + 1] - r[k]))[:, None, None]
        field = field[k] * (1 - t) + field[k + 1] * t
        out = np.zeros(self.topology.size + 1)
        out[self.topology.numbers] = field  # the core nodes, numbered -1, go to the last entry
        return out[:-1]


def _graded(n: int, first: float, last: float) -> Array:
    """Return n+1 graded positions from 0 to ``last``, c (e^kt - 1)^2 with even steps of t.

    k is found by bisection so that the length of the first cell is ``first``.
    """
    low, high = 1e-9, 60.0
    for _ in range(80):
        k = (low + high) / 2
        is_longer = last * (np.expm1(k / n) / np.expm1(k)) ** 2 > first
        low, high = (k, high) if is_longer else (low, k)
    return np.asarray(last * (np.expm1(k * np.arange(n + 1) / n) / np.expm1(k)) ** 2)

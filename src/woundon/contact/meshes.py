"""Surface responses on a grid: the meshes of the graded scheme, of elements and of the thesis.

All deliver the same matrices, so that one assembly serves them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from math import asinh
from typing import Any, ClassVar

import numpy as np

from .action import Action
from .certificate import from_edge, integral
from .elements import ElementGrid
from .grid import Grid
from .response import Act, Response

__all__ = [
    "RESOLVED", "ElementMesh", "FittedMesh", "GradedMesh", "Mesh", "ThesisMesh",
    "interpolation_rank",
]  # fmt: skip

Array = np.ndarray

MOST_RANK = 1200
RESOLVED = MOST_RANK / 20  # of the length on which kernels vary: the half width that is resolved


def interpolation_rank(length: float, a: float, least: int = 24) -> int:
    """Return the interpolation points that resolve kernels varying on ``length`` over [-a, a]."""
    return max(least, round(20 / asinh(length / a)))


@dataclass(frozen=True, eq=False)
class Mesh:
    """A nip's grid with the matrices of a scheme, all for unit half width.

    N cells, M = N + 1 nodes, n = N - 1 unknowns at the interior ones; matrices have a row for each
    cell, where a body's response has one more, the trailing edge.
    """

    grid: Grid

    # where borders of zones are, from the node before them to the next; None: slips tell it
    border_share: ClassVar[float | None] = None
    # whether tractions are linear between the nodes
    hats: ClassVar[bool] = True
    # whether nodes lie where they do whatever the zones, and their distance changes evenly
    regardless: ClassVar[bool] = False

    @property
    def unknowns(self) -> int:
        """Number n of interior nodes."""
        return self.grid.unknowns

    @property
    def nodes(self) -> Array:
        """All nodes from -1 to 1, (M,)."""
        return self.grid.nodes

    @property
    def columns(self) -> Array:
        """The interior nodes, (n,)."""
        return self.grid.nodes[1:-1]

    @property
    def points(self) -> Array:
        """One point in each cell, then the trailing edge, (M,)."""
        return np.append(self.middle, 1.0)

    @property
    def middle(self) -> Array:
        """Where the slope of the gap is taken, one point a cell, (N,)."""
        raise NotImplementedError

    @property
    def value(self) -> Array:
        """Traction in each cell and at the trailing edge, (M, n)."""
        raise NotImplementedError

    @cached_property
    def slope(self) -> Array:
        """Derivative of the traction in each cell; the last row repeats the last cell, (M, n)."""
        identity = np.eye(self.unknowns + 2)[:, 1:-1]
        slope = np.diff(identity, axis=0) / self.grid.cells[:, None]
        return np.vstack([slope, slope[-1:]])

    @cached_property
    def upstream(self) -> Array:
        """Integral of the traction from the leading edge to each cell, (N, n)."""
        cells, nodes = np.arange(self.unknowns + 1)[:, None], np.arange(self.unknowns)[None, :]
        return np.where(nodes < cells, self.grid.weights, 0.0)

    @cached_property
    def behind(self) -> Array:
        """Less the integral of the traction from each cell to the trailing edge, (N, n)."""
        return self.upstream - self.grid.weights

    @cached_property
    def web(self) -> Array:
        """What a web feels of a traction in the cells: slope, value and behind, (3N, n)."""
        return np.concatenate([self.slope[:-1], self.value[:-1], self.behind])

    def facing(self, rigid: bool) -> Mesh:
        """Return the mesh of the tractions on a body, which may jump on a rigid one."""
        return self

    def from_edge(self, values: Array, x: Array) -> Array:
        """Integrate nodal values from the first node to every node, (M,)."""
        return from_edge(values, x)

    def integral(self, values: Array, x: Array) -> float:
        """Integrate nodal values over the contact."""
        return integral(values, x)

    def peak(self, values: Array) -> float:
        """Return the largest value of a function by its values at the interior nodes."""
        return float(values.max())

    def rank(self, kernels: Any, a: float) -> int:
        """Return how many interpolation points the kernels' smooth parts ask for."""
        return interpolation_rank(kernels.length, a)

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return a linear body's response by its influence functions."""
        raise NotImplementedError

    @cached_property
    def _edge(self) -> Grid:
        """The same nodes with the trailing edge for a point."""
        return Grid(self.nodes, self.grid.points[-1:])

    def displaced(
        self, by_p: Any, by_q: Any, rank: int, a: float, points: Array | None
    ) -> tuple[Array, Array]:
        """Return a displacement at any points, or at the trailing edge, by influence functions."""
        rows, grid = slice(None), self.grid
        if points is not None:
            grid = Grid(self.nodes, points)
        elif self.hats and by_p.smooth is None and by_q.smooth is None:
            grid = self._edge  # one row, where the others would be made for nothing
        else:
            rows = slice(-1, None)
        return grid.integrate(by_p, a, rows, rank), grid.integrate(by_q, a, rows, rank)


@dataclass(frozen=True, eq=False)
class GradedMesh(Mesh):
    """Nodes graded towards edges or zone borders, points at the middle of each cell."""

    regardless: ClassVar[bool] = True

    @property
    def points(self) -> Array:
        """One point in each cell, then the trailing edge, (M,)."""
        return self.grid.points

    @property
    def middle(self) -> Array:
        """The points but for the edge, (N,)."""
        return self.grid.points[:-1]

    @property
    def value(self) -> Array:
        """Traction in each cell and at the trailing edge, (M, n)."""
        return self.grid.value

    def rank(self, kernels: Any, a: float) -> int:
        """Return how many interpolation points the kernels' smooth parts ask for.

        The least rank is what the weak kink at t = 0 asks for: 24 leave up to 6e-7 of NIT on random
        nips, 12 leave 4e-6, a hundredth of what the cells of a coarse graded grid leave.
        """
        return interpolation_rank(kernels.length, a, 12 if self.unknowns < 48 else 24)

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return a linear body's response by exact integrals of its influence functions."""
        grid, rank = self.grid, self.rank(kernels, a)
        return Response(
            lambda: tuple(
                grid.integrate_together(kernels.gradients, kernels.smooth, a, rank, kernels.lag)
            ),
            partial(self.displaced, kernels.normal_p, kernels.normal_q, rank, a),
            # alone it makes a static contact, whose borders start the next mesh: never coarse
            partial(self.displaced, kernels.tangent_p, kernels.tangent_q, max(rank, 24), a),
            pressure_slope=lambda: grid.integrate(kernels.slope_p, a, slice(0, -1), rank),
            act=self._act(kernels, a, rank),
            terms=kernels.terms,
            truncation_error=kernels.truncation_error,
        )

    def _act(self, kernels: Any, a: float, rank: int) -> Callable[[], Act] | None:
        """Return what makes integrals without matrices, where kernels are interpolated."""
        if kernels.lag is not None or rank > self.grid.highest_rank:
            return None
        return lambda: Action(self.grid, kernels.gradients, kernels.smooth, a, rank)


@dataclass(frozen=True, eq=False)
class FittedMesh(GradedMesh):
    """Nodes graded towards zone borders too."""

    regardless: ClassVar[bool] = False


@dataclass(frozen=True, eq=False)
class ElementMesh(GradedMesh):
    """Chebyshev elements between zone borders (:mod:`.elements`)."""

    grid: ElementGrid

    border_share: ClassVar[float | None] = 0.0
    hats: ClassVar[bool] = False
    regardless: ClassVar[bool] = False

    @property
    def slope(self) -> Array:
        """Derivative of the traction in each cell; the last row repeats the last cell, (M, n)."""
        return self.grid.slope

    @property
    def upstream(self) -> Array:
        """Integral of the traction from the leading edge to each cell's point, (N, n)."""
        return self.grid.upstream[:-1]

    def from_edge(self, values: Array, x: Array) -> Array:
        """Integrate nodal values from the first node to every node, (M,)."""
        return np.append(0.0, x[-1] * self.grid.to_nodes @ values[1:-1])

    def integral(self, values: Array, x: Array) -> float:
        """Integrate nodal values over the contact."""
        return float(x[-1] * self.grid.weights @ values[1:-1])

    def peak(self, values: Array) -> float:
        """Return the largest value of the polynomials beside the largest value at a node."""
        m, k = self.grid.order, int(np.argmax(values)) + 1
        nodal = np.concatenate([[0.0], values, [0.0]])
        beside = {(k - 1) // m, k // m}
        return max(self.grid.element.peak(nodal[s * m : (s + 1) * m + 1]) for s in beside)

    @cached_property
    def _split(self) -> ElementMesh:
        return ElementMesh(replace(self.grid, split=True))

    def facing(self, rigid: bool) -> ElementMesh:
        """Return the mesh of the tractions on a body, which may jump on a rigid one."""
        return self._split if rigid else self

    def _act(self, kernels: Any, a: float, rank: int) -> None:
        """Return nothing: elements have their matrices."""

    def rank(self, kernels: Any, a: float) -> int:
        """Return how many interpolation points the kernels' smooth parts ask for."""
        rank = max(48, 2 * interpolation_rank(kernels.length, a))
        if rank > self.grid.highest_rank:
            raise ArithmeticError("a layer is too thin beside the contact for elements")
        return rank


@dataclass(frozen=True, eq=False)
class ThesisMesh(Mesh):
    """Even nodes and backward differences; ``printed`` takes the web's coefficients (121) so."""

    printed: bool = False

    border_share: ClassVar[float | None] = 0.5

    @cached_property
    def middle(self) -> Array:
        """The middle of each cell, (N,)."""
        x = self.grid.nodes
        return (x[1:] + x[:-1]) / 2

    @cached_property
    def value(self) -> Array:
        """Traction in each cell and at the trailing edge, (M, n)."""
        identity = np.eye(self.unknowns + 2)[:, 1:-1]
        return np.vstack([(identity[1:] + identity[:-1]) / 2, identity[-1:]])

    @cached_property
    def upstream(self) -> Array:
        """Integral of the traction from the leading edge to each cell, (N, n)."""
        if not self.printed:
            return super().upstream
        # eq. (121): 1/6 of the own node's hat, 5/6 of the one before, all of the others
        cells, nodes = np.arange(self.unknowns + 1)[:, None], np.arange(self.unknowns)[None, :]
        share = np.select([nodes == cells, nodes == cells - 1, nodes < cells], [1 / 6, 5 / 6, 1])
        return share * self.grid.weights

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return a linear body's response by backward differences of nodal displacements.

        On even nodes all depends on the distance between node and hat alone: matrices are Toeplitz,
        and their products convolutions.
        """
        dx, rank = a * float(self.grid.cells[0]), self.rank(kernels, a)
        put = partial(self._by_distance, a=a, rank=rank)

        @lru_cache(maxsize=1)
        def gradients() -> tuple[Array, Array, Array, Array]:
            v_p, v_q = put(kernels.normal_p), put(kernels.normal_q)
            alike = kernels.tangent_p is kernels.normal_q  # Betti's reciprocity
            u_p, u_q = v_q if alike else put(kernels.tangent_p), put(kernels.tangent_q)
            strain_p = np.diff(u_p) / dx + curvature * v_p[1:]
            strain_q = np.diff(u_q) / dx + curvature * v_q[1:]
            return np.diff(v_p) / dx, np.diff(v_q) / dx, strain_p, strain_q

        def act(p: Array, q: Array) -> tuple[Array, Array]:
            slope_p, slope_q, strain_p, strain_q = gradients()
            slope = np.convolve(slope_p, p, "valid") + np.convolve(slope_q, q, "valid")
            strain = np.convolve(strain_p, p, "valid") + np.convolve(strain_q, q, "valid")
            return np.append(slope, slope[-1]), np.append(strain, strain[-1])

        return Response(
            lambda: tuple(map(self._rows, gradients())),  # type: ignore[return-value,arg-type]
            partial(self.displaced, kernels.normal_p, kernels.normal_q, rank, a),
            partial(self.displaced, kernels.tangent_p, kernels.tangent_q, rank, a),
            pressure_slope=lambda: self._rows(gradients()[0])[:-1],
            act=lambda: act,
            terms=kernels.terms,
            truncation_error=kernels.truncation_error,
        )

    def displaced(
        self, by_p: Any, by_q: Any, rank: int, a: float, points: Array | None
    ) -> tuple[Array, Array]:
        """Return a displacement at any points, or at the trailing edge, by influence functions."""
        grid = Grid(self.nodes, self.nodes[-1:] if points is None else points)
        v_p, v_q = (
            grid.integrate(kernel, a, rank=rank if kernel.twice is None else MOST_RANK)
            for kernel in (by_p, by_q)
        )
        return v_p, v_q

    def _by_distance(self, kernel: Any, a: float, rank: int) -> Array:
        """Integrate a kernel over the hat that is -n to n nodes before a node, (2 n + 1,).

        Exactly where its second integral is known; else by the outermost hats.
        """

        def outermost(integrals: Array) -> Array:
            return np.append(integrals[:n, -1], integrals[1:, 0])

        n, h = self.unknowns, a * float(self.grid.cells[0])
        if kernel.twice is None:
            return outermost(self.grid.integrate(kernel, a, rank=rank))
        values: Array = np.diff(kernel.twice(h * np.arange(-n - 1.0, n + 2.0)), 2) / h
        if kernel.lag is not None:
            values += outermost(self.grid.lagging(kernel.lag, a)[0])
        return values

    def _rows(self, values: Array) -> Array:
        """Return the matrix of what depends on the distance in cells, (M, n).

        Its last row is that of the last cell.
        """
        # row k is values[k:k+n] backwards; forwards, in the memory's order, it is copied quicker
        backwards = np.ascontiguousarray(values[::-1])
        out = np.empty((self.unknowns + 2, self.unknowns))
        out[:-1] = np.lib.stride_tricks.sliding_window_view(backwards, self.unknowns)[::-1]
        out[-1] = out[-2]
        return out

r"""A contact grid on [-1, 1] and the exact integrals of the singular kernels over its hats.

Tractions are piecewise linear on the nodes x_0 < ... < x_N and vanish at both ends, so the
unknowns live on the n = N - 1 interior nodes.  Slopes and strains are collocated at one point y_k
inside each cell (x_(k-1), x_k).  Node k belongs with the cell *before* it: material flows along +x,
and only the upstream cell gives the right sense of rolling.

      x_0      x_1      x_2              x_(N-1)    x_N
       |---y_1--|---y_2--|--- ...  --y_(N-1)-|---y_N---|
     -1  traction 0                            trailing edge 1, traction 0

Every kernel is scale-free up to a factor, so a grid on [-1, 1] serves all half widths a.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil
from typing import Protocol

import numpy as np

__all__ = [
    "HIGHEST_RANK",
    "Grid",
    "KernelParts",
    "Past",
    "chebyshev_transform",
    "cosine_grid",
    "distances",
    "nearest_nodes",
    "segmented_grid",
    "uniform_grid",
    "zone_borders",
]

Array = np.ndarray

HIGHEST_RANK = 600
BLOCK = 12000  # entries: small arrays stay in the cache, and cost little more than their call


class Past(Protocol):
    """Kernels that are told by their integrals alone, for hats to be integrated exactly."""

    @property
    def shares(self) -> Array:
        """What each kernel has of the ``parts``, (kernels, r); if as many, they are the kernels."""
        ...

    def parts(self, before: Array, logarithm: Array) -> Array:
        """Return second integrals by whether t < 0 and by ln|t|, (r, *shape)."""
        ...

    def twice(self, before: Array, logarithm: Array) -> Array:
        """Return those of the kernels, (kernels, *shape)."""
        ...

    def exactly(self, t: Array, order: int = 0) -> Array:
        """Return the second integrals at t (k,), or a derivative of them, (kernels, k)."""
        ...


class KernelParts(Protocol):
    """A kernel: inverse/t + delta*Dirac + log*ln|t| + sign*sgn(t) + smooth(t) + lag."""

    @property
    def inverse(self) -> float:
        """Coefficient of 1/t."""
        ...

    @property
    def delta(self) -> float:
        """Coefficient of Dirac(t)."""
        ...

    @property
    def log(self) -> float:
        """Coefficient of ln|t|."""
        ...

    @property
    def sign(self) -> float:
        """Coefficient of sgn(t)."""
        ...

    @property
    def smooth(self) -> Callable[[Array], Array] | None:
        """The rest."""
        ...

    @property
    def twice(self) -> Callable[[Array], Array] | None:
        """The second integral of all but the lag, where it is known."""
        ...

    @property
    def lag(self) -> Past | None:
        """What a viscoelastic surface adds."""
        ...


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes and collocation points on [-1, 1].

    Attributes
    ----------
    nodes : (N+1,) array
        Increasing from -1 to 1.
    points : (K,) array
        Where kernels are evaluated; by convention the last one is the trailing edge 1.
    """

    nodes: Array
    points: Array

    @property
    def unknowns(self) -> int:
        """Number n of interior nodes."""
        return self.nodes.size - 2

    def outside(self, points: Array) -> Grid:
        """Return the same nodes with other points, outside of them."""
        return Grid(self.nodes, points)

    @cached_property
    def cells(self) -> Array:
        """Cell lengths, (N,)."""
        return np.diff(self.nodes)

    @cached_property
    def weights(self) -> Array:
        """Integrals of the hats, (n,)."""
        return (self.cells[1:] + self.cells[:-1]) / 2

    @cached_property
    def distance(self) -> Array:
        """points - (left node of each cell), (K, N)."""
        return self.points[:, None] - self.nodes[None, :-1]

    def _hats(self, zeroth: Array, first: Array) -> Array:
        """Combine a cell's integrals of k and of k*(s - x_left)/h into those of the hats."""
        return first[:, :-1] + (zeroth - first)[:, 1:]

    @cached_property
    def inverse(self) -> Array:
        """Principal values of int psi_m(s)/(y - s) ds, (K, n); no point on an interior node."""
        # with z = h/(y - x_left) the cell's integrals of 1/(y - s) and of (s - x_left)/h/(y - s)
        # are -ln|1-z| and -ln|1-z|/z - 1
        with np.errstate(divide="ignore", invalid="ignore"):
            z = self.cells / self.distance
            zeroth = -np.log(np.abs(1 - z))
            first = zeroth / z - 1
        # far away the logarithm cancels, so it is expanded
        far = np.abs(z) < 2e-2
        zf = z[far]
        series = zf / 9
        for k in range(8, 1, -1):
            series += 1 / k
            series *= zf
        first[far] = series
        zeroth[far] = zf * (1 + series)
        # at the contact's own ends the hats vanish with the distance: only the finite rests stay
        starts, ends = self.distance == 0, z == 1
        zeroth[starts], first[starts] = -1.0, -1.0
        zeroth[ends], first[ends] = 0.0, -1.0
        return self._hats(zeroth, first)

    @cached_property
    def log(self) -> Array:
        """Integrals of psi_m(s) ln|y - s| ds, (K, n)."""
        d0, d1 = self.distance, self.distance - self.cells
        logarithm = self.apart[1]  # finite where a point lies on a node
        l0, l1 = logarithm[:, :-1], logarithm[:, 1:]
        zeroth = d0 * l0 - d1 * l1 - self.cells
        moment = d0 * (zeroth) - (d0**2 * (l0 / 2 - 0.25) - d1**2 * (l1 / 2 - 0.25))
        return self._hats(zeroth, moment / self.cells)

    @cached_property
    def sign(self) -> Array:
        """Integrals of psi_m(s) sgn(y - s) ds, (K, n)."""
        part = np.clip(self.distance / self.cells, 0.0, 1.0)  # share of the cell before y
        zeroth = self.cells * (2 * part - 1)
        return self._hats(zeroth, self.cells * (part**2 - 0.5))

    @cached_property
    def value(self) -> Array:
        """Value of the piecewise linear function at the points, (K, n)."""
        part = self.distance / self.cells
        inside = (part >= 0) & (part < 1)
        return self._hats(np.where(inside, 1.0, 0.0), np.where(inside, part, 0.0))

    @property
    def highest_rank(self) -> int:
        """The rank up to which kernels are interpolated: polynomials that the cells still see."""
        return min(HIGHEST_RANK, 8 * self.cells.size)

    def interpolation(self, rank: int) -> tuple[Array, Array]:
        """Return Lagrange polynomials at the points (K, r) and their hat moments (r, n)."""
        made = self._made.get(rank)
        if made is None:
            made = self._made[rank] = self._interpolate(rank)
        return made

    @cached_property
    def _made(self) -> dict[int, tuple[Array, Array]]:
        return {}

    def _interpolate(self, r: int) -> tuple[Array, Array]:
        transform, chebyshev = chebyshev_transform(r), np.polynomial.chebyshev.chebvander
        at_points = chebyshev(self.points, r - 1) @ transform
        # moments of T_j over the hats: eight points, more where a cell is longer than their waves
        phase = r * float(np.max(np.diff(np.arccos(-self.nodes)))) / 2
        part, weights = _gauss(8 + max(0, ceil(phase - 5)))
        s = self.nodes[:-1, None] + self.cells[:, None] * part
        polynomials = chebyshev(s.ravel(), r - 1).T.reshape(r, self.cells.size, part.size)
        zeroth, first = np.moveaxis(polynomials @ weights, -1, 0) * self.cells
        return at_points, transform.T @ self._hats(zeroth, first)

    def integrate(
        self, kernel: KernelParts, scale: float, rows: slice = slice(None), rank: int = 24
    ) -> Array:
        """Integrate a kernel against the hats of the grid scaled by ``scale`` (the half width a).

        Parameters
        ----------
        kernel : KernelParts
        scale : float
            a [m].
        rows : slice
            Which points; all by default.
        rank : int
            Interpolation points a direction for the smooth part, at least 24; where it asks for too
            many, the kernel's second integral is taken instead.

        Returns
        -------
        (K, n) array
            int k(a (y - s)) psi_m(s) a ds at each point y.
        """
        past = 0.0 if kernel.lag is None else self.lagging(kernel.lag, scale, rows)[0]
        if rank > self.highest_rank and kernel.twice is not None:
            return self.by_second_integral(kernel.twice, scale, rows) + past
        rank = min(rank, HIGHEST_RANK)
        out = np.zeros((self.points[rows].size, self.unknowns))
        if kernel.inverse:
            out += kernel.inverse * self.inverse[rows]
        if kernel.delta:
            out += kernel.delta * self.value[rows]
        if kernel.log:
            out += kernel.log * scale * (self.log[rows] + np.log(scale) * self.weights)
        if kernel.sign:
            out += kernel.sign * scale * self.sign[rows]
        if kernel.smooth is not None:
            at_points, moments = self.interpolation(rank)
            distance, where = distances(rank)
            core = kernel.smooth(scale * distance)[where]
            out += scale * ((at_points[rows] @ core) @ moments)  # of few rows the least work
        return out if kernel.lag is None else out + past

    def by_second_integral(
        self, twice: Callable[[Array], Array], scale: float, rows: slice = slice(None)
    ) -> Array:
        """Integrate a kernel k = K'' against the inner hats by differences of K, exactly."""
        t = scale * (self.points[rows, None] - self.nodes)
        rise = np.diff(twice(t), axis=1) / (scale * self.cells)
        return np.diff(rise, axis=1)

    def lagging(self, lag: Past, scale: float, rows: slice = slice(None)) -> Array:
        """Integrate what a viscoelastic surface adds against the hats, (kernels, K, n)."""
        before, logarithm = (part[rows] for part in self.apart)
        shares = lag.shares
        out = np.empty((len(shares), len(before), self.unknowns))
        rows_at_once, per_cell = 1 + BLOCK // self.nodes.size, 1 / (scale * self.cells)
        for first in range(0, len(before), rows_at_once):
            block = slice(first, first + rows_at_once)
            K = lag.parts(before[block], logarithm[block] + np.log(scale))
            rise = K[..., 1:] - K[..., :-1]
            rise *= per_cell
            if len(K) == len(out):
                np.subtract(rise[..., 1:], rise[..., :-1], out=out[:, block])
                continue
            hats = rise[..., 1:] - rise[..., :-1]
            out[:, block] = (shares @ hats.reshape(len(K), -1)).reshape(-1, *hats.shape[1:])
        return out

    @cached_property
    def apart(self) -> tuple[Array, Array]:
        """Whether points lie before nodes, and the logarithm of their distance, (K, N+1)."""
        t = self.points[:, None] - self.nodes
        return t < 0, np.log(np.maximum(np.abs(t), 1e-300))

    def integrate_together(
        self,
        kernels: Sequence[KernelParts],
        smooth: Callable[[Array], Array] | None,
        scale: float,
        rank: int = 24,
        lag: Past | None = None,
    ) -> Array:
        """Integrate several kernels as ``integrate`` does one, (kernels, K, n).

        Parameters
        ----------
        kernels : sequence of KernelParts
        smooth : callable or None
            Their smooth parts at once: t -> (kernels, *t.shape).
        scale : float
            a [m].
        rank : int
        lag : Past, optional
            Their lags at once.
        """
        if rank > self.highest_rank and all(k.twice is not None for k in kernels):
            return np.array([self.integrate(k, scale, rank=rank) for k in kernels])
        rank = min(rank, HIGHEST_RANK)
        factors = np.array([[k.inverse, k.delta, k.log * scale, k.sign * scale] for k in kernels])
        logs = factors[:, 2:].any()
        singular = self.singular if logs else self.poles
        factors = factors[:, : len(singular)]
        if smooth is None:
            out: Array = (factors @ singular).reshape(len(kernels), -1, self.unknowns)
        else:
            at_points, moments = self.interpolation(rank)
            distance, where = distances(rank)
            core = smooth(scale * distance).take(where, axis=1)
            out = at_points @ (core @ (scale * moments))
            for part, own in zip(out, factors, strict=True):  # small arrays stay in the cache
                part += (own @ singular).reshape(part.shape)
        if logs:
            out += (factors[:, 2] * np.log(scale))[:, None, None] * self.weights
        if lag is not None:
            out += self.lagging(lag, scale)
        return out

    @cached_property
    def singular(self) -> Array:
        """The integrals of the inverse, the pulse, the logarithm and the sign, (4, K n)."""
        return np.array([self.inverse, self.value, self.log, self.sign]).reshape(4, -1)

    @cached_property
    def poles(self) -> Array:
        """The integrals of the inverse and the pulse, all that a half-plane has, (2, K n)."""
        return np.array([self.inverse, self.value]).reshape(2, -1)


@lru_cache(maxsize=32)
def _gauss(points: int) -> tuple[Array, Array]:
    """Return Gauss's points on [0, 1], and weights that integrate f and f times the place."""
    g, w = np.polynomial.legendre.leggauss(points)
    part = (g + 1) / 2
    return part, np.array([w / 2, w / 2 * part]).T


def chebyshev_points(r: int) -> Array:
    """Return the r Chebyshev points of the first kind, increasing."""
    return -np.cos(np.pi * (2 * np.arange(r) + 1) / (2 * r))


@lru_cache(maxsize=32)
def chebyshev_transform(r: int) -> Array:
    """Return coefficients of Chebyshev polynomials by values at r points of the first kind."""
    transform = np.cos(np.outer(np.arange(r), np.arccos(chebyshev_points(r)))) * (2 / r)
    transform[0] /= 2
    return np.asarray(transform)


@lru_cache(maxsize=32)
def distances(r: int) -> tuple[Array, Array]:
    """Return the different distances between r Chebyshev points, and which belongs to each pair.

    The points are symmetric, so t_i - t_j comes back as t_(r-1-j) - t_(r-1-i): half are new.
    """
    i, j = np.divmod(np.arange(r * r), r)
    twin = np.minimum(r * i + j, r * (r - 1 - j) + (r - 1 - i))
    kept, where = np.unique(twin, return_inverse=True)
    t = chebyshev_points(r)
    return t[kept // r] - t[kept % r], where.reshape(r, r)


def _midpoints_and_edge(middle: Array) -> Array:
    return np.append(middle, 1.0)


@lru_cache(maxsize=32)
def cosine_grid(nodes: int) -> Grid:
    """Return the edge-graded grid x = -cos(theta) with points at the middle of each theta cell."""
    theta = np.pi * np.arange(2 * nodes - 1) / (2 * nodes - 2)
    # sine of the distance to the middle: exactly antisymmetric, so mirrored problems mirror
    x = np.sin(theta - np.pi / 2)
    x = (x - x[::-1]) / 2
    return Grid(x[0::2], _midpoints_and_edge(x[1::2]))


@lru_cache(maxsize=32)
def uniform_grid(nodes: int) -> Grid:
    """Return the evenly spaced grid of the thesis (eq. 108); points are all its nodes."""
    x = np.linspace(-1.0, 1.0, nodes)
    x = (x - x[::-1]) / 2
    return Grid(x, x)


def segmented_grid(borders: Array, nodes: int) -> Grid:
    """Return a grid graded towards both ends and towards given zone borders.

    Parameters
    ----------
    borders : (b,) array
        Increasing, inside (-1, 1); borders nearer than 2e-4 to another or to an end are dropped.
    nodes : int
        About how many nodes.  Cells go to the segments by the 0.4th power of their length, at
        least six each: a traction that leaves a border like the root of the distance needs nearly
        as many cells in a short segment as in a long one.  Near a border cells shrink a little
        faster than the root asks, x ~ t^2.2.  Both powers are the best of a few on Carter's and
        Cattaneo's problems; neighbouring ones are 10 to 40 % worse.
    """
    ends = [-1.0]
    for border in borders:
        if min(border - ends[-1], 1.0 - border) > 2e-4:
            ends.append(float(border))
    ends.append(1.0)
    share = np.diff(ends) ** 0.4
    cells = np.maximum(6, np.rint(share / share.sum() * (nodes - 1)).astype(int))
    x = []
    for left, right, count in zip(ends, ends[1:], cells, strict=False):
        t = np.arange(2 * count) / (2 * count)
        x.append(left + (right - left) * t**2.2 / (t**2.2 + (1 - t) ** 2.2))
    both = np.concatenate(x)
    return Grid(np.append(both[0::2], 1.0), _midpoints_and_edge(both[1::2]))


def nearest_nodes(old: Array, new: Array) -> Array:
    """Return which of the ``old`` nodes is nearest to each ``new`` one, (new.size,) int."""
    return np.searchsorted((old[1:] + old[:-1]) / 2, new)


def zone_borders(nodes: Array, zones: Array, slack: Array) -> Array:
    """Return where zones change on a face.

    Parameters
    ----------
    nodes : (M,) array
        All nodes, ends included.
    zones : (M-2,) int array
        States of the interior nodes.
    slack : (M-2,) array
        Bound less traction of each node.  It goes to a border of the stick zone like the root of
        the distance, which tells the border between the nodes; half-way between them where two
        sticking nodes are not at hand.
    """
    x, k = nodes[1:-1], np.nonzero(np.diff(zones))[0]
    borders = (x[k] + x[k + 1]) / 2
    for i, left in enumerate(k):
        # last stick node before the border, and the one before it, counted away from the border
        near, far = (left, left - 1) if zones[left] == 0 else (left + 1, left + 2)
        if not 0 <= far < x.size or zones[near] != 0 or zones[far] != 0:
            continue
        g_near, g_far = slack[near] ** 2, slack[far] ** 2
        if g_far > g_near:
            root = x[near] + (x[near] - x[far]) * g_near / (g_far - g_near)
            borders[i] = min(max(root, x[left]), x[left + 1])
    return borders

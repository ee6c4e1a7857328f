"""Integrals over rows of cells whose ends carry half hats: in closed form, and Gauss's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..contact.grid import Grid, Past

__all__ = ["OpenGrid", "closed", "closed_blocks", "gauss"]

Array = np.ndarray

MOST_POINTS = 150  # of a cell; three for each length on which a body responds
FAR = 0.2  # a cell over the distance to its end: beyond, logarithms cancel


@dataclass(frozen=True, eq=False)
class OpenGrid(Grid):
    """A grid whose ends carry half hats, so that every node is an unknown."""

    @property
    def unknowns(self) -> int:
        """Number of nodes, ends included."""
        return self.nodes.size

    @cached_property
    def weights(self) -> Array:
        """Integrals of the hats and half hats, (N+1,)."""
        return (np.append(self.cells, 0.0) + np.append(0.0, self.cells)) / 2

    def _hats(self, zeroth: Array, first: Array) -> Array:
        out = np.zeros((first.shape[0], first.shape[1] + 1))
        np.subtract(zeroth, first, out=out[:, :-1])
        out[:, 1:] += first
        return out

    def lagging(self, lag: Past, scale: float, rows: slice = slice(None)) -> Array:
        """Integrate what a viscoelastic surface adds against hats and half hats, (k, K, N+1)."""
        before, logarithm = (part[rows] for part in self.apart)
        rise = np.diff(lag.twice(before, logarithm + np.log(scale)), axis=-1) / (scale * self.cells)
        ends = [
            -lag.exactly(scale * (self.points[rows] - node), 1)[..., None]
            for node in self.nodes[[0, -1]]
        ]
        return np.diff(np.concatenate([ends[0], rise, ends[1]], axis=-1), axis=-1)


def closed(points: Array, nodes: Array) -> Array:
    """Integrate 1/t, the pulse, ln|t| and sgn(t), t = y - s, against hats and half hats.

    Parameters
    ----------
    points : (K,) array
        y; on a node what is singular there is large, but finite.
    nodes : (M+1,) array

    Returns
    -------
    (4, K, M+1) array
        As :attr:`woundon.contact.grid.Grid.singular` has them.
    """
    return closed_blocks((points, nodes))[0]


def closed_blocks(*blocks: tuple[Array, Array]) -> list[Array]:
    """Return :func:`closed` of several points and nodes, at hardly more than the cost of one."""
    ts = [points[:, None] - nodes for points, nodes in blocks]
    ends = np.concatenate([t[:, :-1].ravel() for t in ts] + [t[:, 1:].ravel() for t in ts])
    logarithms = np.log(np.maximum(np.abs(ends), 1e-300))
    (left, right), (t, after) = logarithms.reshape(2, -1), ends.reshape(2, -1)
    h, d, half = t - after, (t + after) / 2, (t - after) / 2
    # over each cell, and times the distance from its middle
    zeroth, first = np.empty((2, 4, d.size))
    inverse = np.subtract(left, right, out=zeroth[0])
    with np.errstate(divide="ignore"):
        share = h / after
    np.log1p(share, out=inverse, where=np.abs(share) < FAR)
    inside = np.minimum(np.maximum(d, -half), half)
    own = zeroth[1] = inside == d
    np.multiply(own, d, out=first[1])
    np.multiply(d, inverse, out=zeroth[2])
    np.subtract(zeroth[2], h, out=first[0])
    zeroth[2] += half * (left + right) - h
    first[2] = d / 2 * first[0] - half**2 / 2 * inverse
    np.multiply(inside, 2.0, out=zeroth[3])
    first[3] = inside**2 - half**2
    zeroth /= 2
    first /= h
    downward, upward, found, k = zeroth - first, zeroth + first, [], 0
    for t in ts:
        cells = slice(k, k := k + t[:, 1:].size)
        out = np.empty((4, *t.shape))
        out[..., :-1] = downward[:, cells].reshape(4, *t[:, 1:].shape)
        out[..., -1] = 0.0
        out[..., 1:] += upward[:, cells].reshape(4, *t[:, 1:].shape)
        found.append(out)
    return found


def gauss(nodes: Array, scale: float, length: float) -> tuple[Array, Array]:
    """Return Gauss's points along a row of nodes, and the hats there times weights.

    Parameters
    ----------
    nodes : (N+1,) array
        In units of the half width.
    scale : float
        a [m].
    length : float
        On which the kernels vary [m]: the longer a cell beside it, the more points.

    Returns
    -------
    (Q,), (Q, N+1) arrays
        Weights in metres; half hats at the ends.
    """
    cells = np.diff(nodes)
    share = scale * cells / length
    orders = np.where(share < 0.01, 1, 2 + np.minimum(3 * share, MOST_POINTS).astype(int))
    cell, part, weight = _in_cells(orders.tobytes())
    lengths = cells[cell]
    weight = weight * (lengths * scale)
    hats, k = np.zeros((part.size, nodes.size)), np.arange(part.size)
    after = weight * part
    hats[k, cell], hats[k, cell + 1] = weight - after, after
    return nodes[cell] + lengths * part, hats


@lru_cache(maxsize=64)
def _in_cells(orders: bytes) -> tuple[Array, Array, Array]:
    """Return which cell Gauss's points of so many each lie in, where, from 0 to 1, and weights."""
    counts = np.frombuffer(orders, dtype=int)
    rules = [_gauss(order) for order in counts.tolist()]
    points, weights = (np.concatenate(parts) for parts in zip(*rules, strict=True))
    return np.repeat(np.arange(counts.size), counts), (points + 1) / 2, weights / 2


@lru_cache
def _gauss(order: int) -> tuple[Array, Array]:
    """Return Gauss's points and weights on [-1, 1]."""
    g, w = np.polynomial.legendre.leggauss(order)
    return g, w

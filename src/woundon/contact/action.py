"""What given tractions do to a surface, its kernels integrated without matrices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import log

import numpy as np

from .grid import Grid, KernelParts, distances

__all__ = ["Action"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Action:
    """(p, q) -> slope and strain at the points, (K,) each, by nodal tractions, (n,) each.

    What :meth:`Grid.integrate_together` makes matrices of, times vectors: products with what the
    grid keeps, and with the kernels' smooth parts at the interpolation points alone.

    Parameters
    ----------
    grid : Grid
    kernels : sequence of KernelParts
        Of slope by p and by q, of strain by p and by q; without lag.
    smooth : callable or None
        Their smooth parts at once.
    scale : float
        a [m].
    rank : int
        Interpolation points, at most the grid's highest rank.
    """

    grid: Grid
    kernels: Sequence[KernelParts]
    smooth: Callable[[Array], Array] | None
    scale: float
    rank: int

    def __call__(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return slope and strain."""
        grid, loads, singular = self.grid, np.array([p, q]), self._singular
        hats = grid.poles if self._logs is None else grid.singular
        found = singular @ (loads @ hats.reshape(-1, grid.unknowns).T).reshape(2 * len(hats), -1)
        if self._logs is not None:
            found += (self._logs @ (loads @ grid.weights))[:, None]
        if self.smooth is not None:
            at_points, moments = grid.interpolation(self.rank)
            found += (self._core @ (loads @ moments.T).ravel()).reshape(2, -1) @ at_points.T
        slope, strain = found
        return slope, strain

    @cached_property
    def _singular(self) -> Array:
        """Coefficients of the singular parts that there are, (2, p's parts then q's)."""
        a, each = self.scale, [[k.inverse, k.delta, k.log, k.sign] for k in self.kernels]
        factors = np.array(each) * [1.0, 1.0, a, a]
        if not factors[:, 2:].any():
            factors = factors[:, :2]
        return factors.reshape(2, -1)

    @cached_property
    def _logs(self) -> Array | None:
        """What ln(a) adds, by the loads of p and of q."""
        singular = self._singular
        return singular[:, 2::4] * log(self.scale) if singular.shape[1] == 8 else None

    @cached_property
    def _core(self) -> Array:
        """Smooth parts between the interpolation points: slope and strain by p and q, (2r, 2r)."""
        assert self.smooth is not None
        distance, where = distances(self.rank)
        core = self.smooth(self.scale * distance).take(where, axis=1)
        r = self.rank
        core = core.reshape(2, 2, r, r).transpose(0, 2, 1, 3).reshape(2 * r, 2 * r)
        return np.asarray(self.scale * core)

"""What given tractions do to a surface with its arc, its kernels integrated without matrices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from ..contact.action import Action
from ..contact.schemes import interpolation_rank
from .grid import Influence

__all__ = ["FaceAction"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class FaceAction:
    """(p, q) -> slope and strain at the points, (K,) each, by nodal tractions, (N+1,) each.

    What :meth:`Influence.together` makes matrices of, times vectors.

    Parameters
    ----------
    put : Influence
    kernels : SurfaceKernels
        Without lag.
    rank : int
        Interpolation points inside the nip.
    """

    put: Influence
    kernels: Any
    rank: int

    @classmethod
    def of(cls, put: Influence, kernels: Any) -> Self | None:
        """Return it where kernels are interpolated, else None: then matrices are as quick."""
        rank = interpolation_rank(kernels.length, put.scale)
        if put.nip is None or kernels.lag is not None or rank > put.nip.highest_rank:
            return None
        return cls(put, kernels, rank)

    def __call__(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return slope and strain."""
        put, grid = self.put, self.put.grid
        rows, inside = put.rows, put.columns
        loads = np.array([p, q]).T
        outer = loads.copy()
        outer[inside] = 0.0  # inside the nip, its own integrals take the place of these
        parts = grid.singular.reshape(-1, grid.unknowns) @ np.hstack([loads, outer])
        parts = parts.reshape(4, -1, 2, 2)
        parts[:, rows, 0] = parts[:, rows, 1]
        found = self._singular @ parts[:, :, 0].transpose(0, 2, 1).reshape(8, -1)
        logs = self._logs @ np.array([grid.weights @ loads, grid.weights @ outer]).T
        found += logs[:, :1]
        found[:, rows] += logs[:, 1:] - logs[:, :1]
        for (block, points, values), by in zip(self._smooth, (loads, outer), strict=False):
            at = put.gauss.hats[points] @ by
            found[:, block] += (values @ at.T[:, :, None])[..., 0].sum(axis=1)
        own = self._nip(p[inside], q[inside])
        found[:, rows] += np.array(own)[:, : rows.size]
        slope, strain = found
        return slope, strain

    @cached_property
    def _nip(self) -> Action:
        put, kernels = self.put, self.kernels
        assert put.nip is not None
        return Action(put.nip, kernels.gradients, kernels.smooth, put.scale, self.rank)

    @cached_property
    def _singular(self) -> Array:
        """Coefficients of the singular parts, (slope and strain, parts by p and q)."""
        a = self.put.scale
        each = [[k.inverse, k.delta, k.log * a, k.sign * a] for k in self.kernels.gradients]
        return np.array(each).reshape(2, 2, 4).transpose(0, 2, 1).reshape(2, 8)

    @cached_property
    def _logs(self) -> Array:
        """What ln(a) adds, by the loads of p and of q, (slope and strain, p and q)."""
        a = self.put.scale
        logs = np.array([k.log for k in self.kernels.gradients]).reshape(2, 2)
        return np.asarray(logs * (a * np.log(a)))

    @cached_property
    def _smooth(self) -> list[tuple[Any, Any, Array]]:
        """Smooth parts between points and Gauss's, block by block, (2, 2, k, points)."""
        put, kernels = self.put, self.kernels
        if kernels.smooth is None:
            return []
        found = ((block, put.between(kernels.gradients, kernels.smooth, *block))
                 for block in put.blocks)  # fmt: skip
        return [(*block, values.reshape(2, 2, *values.shape[1:])) for block, values in found]

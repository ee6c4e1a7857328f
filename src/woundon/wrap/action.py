"""What given tractions do to a surface with its arc, its kernels integrated without matrices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import Any

import numpy as np

from .influence import Influence

__all__ = ["FaceAction"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class FaceAction:
    """(p, q) -> slope and strain at the points, (K,) each, by nodal tractions, (N+1,) each.

    What :meth:`Influence.together` makes matrices of, times vectors.

    Parameters
    ----------
    put : Influence
        With a nip.
    kernels : SurfaceKernels
        Without lag.
    """

    put: Influence
    kernels: Any

    def __call__(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return slope and strain."""
        put, loads = self.put, np.array([p, q]).T
        K = put.grid.points.size
        found = self._singular @ put.singular_under(loads).transpose(0, 2, 1).reshape(8, K)
        found += (self._logs @ (put.grid.weights @ loads))[:, None]
        if self._smooth is not None:
            apart, within = put.apart, put.within
            r = apart.interpolated
            values = self._smooth @ apart.moments_of(loads).T.ravel()
            found[:, apart.rows] += values[:, r:]
            assert within is not None
            found[:, within.rows] += values[:, :r] @ apart.at_nip.T
        slope, strain = found
        return slope, strain

    @cached_property
    def _singular(self) -> Array:
        """Coefficients of the singular parts, (slope and strain, parts by p and q)."""
        each = self.put.factors(self.kernels.gradients)
        return each.reshape(2, 2, 4).transpose(0, 2, 1).reshape(2, 8)

    @cached_property
    def _logs(self) -> Array:
        """What ln(a) adds, by the loads of p and of q, (slope and strain, p and q)."""
        a = self.put.scale
        logs = np.array([k.log for k in self.kernels.gradients]).reshape(2, 2)
        return np.asarray(logs * (a * log(a)))

    @cached_property
    def _smooth(self) -> Array | None:
        """Smooth parts between points and sources, (slope and strain, points, sources by p, q)."""
        put, kernels = self.put, self.kernels
        if kernels.smooth is None:
            return None
        values = put.between(kernels.gradients, kernels.smooth, put.apart.points)
        _, points, sources = values.shape
        values = values.reshape(2, 2, points, sources).transpose(0, 2, 1, 3)
        return values.reshape(2, points, 2 * sources)

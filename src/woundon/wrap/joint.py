r"""A wrapped nip's equations for one half width as one system: :mod:`..contact.joint` with arcs.

With z = (p+, p-, Delta/R*) and q = (q+, q-),

                 z            q       xi
    gap        [ by_z         by_q    0 ]
    balance    [ 1 - T kappa          0 ]
    resultant  [ -F w         w-      0 ]
    slips      [ slip_z       slip_q  e ]     nodes, then each face's last cell
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from ..contact.joint import Joint

if TYPE_CHECKING:
    from .equations import WrapEquations

__all__ = ["WrapJoint"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class WrapJoint(Joint):
    """The joint system of a wrapped nip.

    Attributes
    ----------
    order : (m + 2,) int array
        Which slips, of all cells of roll and drum, each of its rows has.
    size, force_size : float
        What makes the rows of pressures, and that of the force, as large as those of slopes.
    """

    order: Array
    size: float
    force_size: float

    @classmethod
    def of(cls, equations: WrapEquations) -> Self:
        """Return the system of equations that are linearised about a tension and a curvature."""
        n_q, m, k = equations.roll_q.size, equations.columns.size, equations.load_weights.size
        M = equations.grid.last - equations.grid.first
        N, last = M + equations.grid.size, [n_q, m + 1]
        order = np.concatenate([np.delete(np.arange(m + 2), last), last])
        matrix, right = np.zeros((k + m + 3, k + m + 1)), np.zeros(k + m + 3)
        by_z, by_q = matrix[:, :k], matrix[:, k:-1]
        right[:M] = equations.put_indentation(by_z[:M], by_q[:M])
        closing = by_z[:M, :-1]
        size = float(max(closing.max(), -closing.min()))
        force_size = size / float(equations.load_weights.max())
        right[M:N] = -equations.put_balance(by_z[M:N], by_q[M:N], size)
        if equations.drum_arc:
            matrix[N, 0] = size  # p+ begins with zero where the web comes off the drum's arc
        np.multiply(equations.load_weights, -force_size * equations.share, out=by_z[k])
        np.multiply(equations.force_weights, force_size, out=by_q[k])
        right[k] = force_size * equations.force
        slip_z, slip_q = equations.slips
        by_z[k + 1 :], by_q[k + 1 :] = slip_z[order], slip_q[order]
        matrix[k + 1 :, -1] = order > n_q
        right[k + 1 :] = -equations.slip_offset[order]
        return cls(
            matrix, right, equations.friction, equations.own_pressure,
            copy(equations).stick_slip,  # that has no joint, which would lead to itself
            order, size, force_size,
        )  # fmt: skip

    def _bring(self, columns: Array, shares: Array, to: Array) -> None:
        slid = shares.nonzero()[0]
        to[:, self.own[slid]] += columns[:, slid] * shares[slid]

r"""Collapse of the inner layers of a roll off its core: buckling of rings under external pressure.

Off its core the innermost layers are compressed along the web.  Between the inner end r_a of the
layers in contact and the radius r_b at which the hoop stress is zero they are a ring of the depth
d, which the layers outside press on with P_b.  Moment equilibrium of a ring that is bent
inextensionally into an oval under a pressure that follows its surface gives (M. Levy 1884)

    p = 3 E_t I/R^3,      R = (r_a + r_b)/2,   I per width,

and the same ring of d/h layers has

    bonded layers           I = d^3/12           p = E_t d^3/(4 R^3)
    freely sliding layers   I = (d/h) h^3/12     p = E_t d h^2/(4 R^3)

Freely sliding layers may buckle in any group of inner layers: that with the largest ratio of the
pressure on it to its p counts, usually the innermost layer.

Both are limits of thin rings: the layers outside press with a constant pressure and do not hold the
ring where it moves outwards, which makes both too low; the shear of the stack and imperfections,
which lower the buckling pressure, are left out.
"""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np

from ..quantities import pure
from .finished import opening
from .roll_fields import RollFields
from .stages import stresses_between

__all__ = ["BONDED", "SLIDING", "CollapseLoads", "collapse_loads"]

Array = np.ndarray
# both limits as outputs of a roll, and as margins
SLIDING = pure("c_s", "pressure on the inner layers / buckling, free sliding").named(
    "sliding_collapse_load"
)
BONDED = pure("c_b", "pressure on the inner layers / buckling, bonded layers").named(
    "bonded_collapse_load"
)
DEPTHS = 400  # groups of inner layers that are compared


class CollapseLoads(NamedTuple):
    """Pressure on the compressed inner layers over the pressure at which they buckle [1].

    Attributes
    ----------
    sliding, bonded : float
        Of layers that slide freely on each other, and of bonded layers; nan on a core.
    """

    sliding: float
    bonded: float


def collapse_loads(result: RollFields) -> CollapseLoads:
    """Return the loads of the compressed inner layers of a roll result.

    They are zero if no inner layer is compressed, and nan for a roll on its core, which supports
    them.
    """
    problem, r, hoop = result.problem, result.radius, result.hoop_stress
    if not result.is_off_core:
        return CollapseLoads(nan, nan)
    start = int(np.argmax(opening(result) == 0))  # the innermost layers in contact
    start = max(start - 1, 0)  # from the edge of the open zone
    tensile = np.flatnonzero(hoop[start + 1 :] >= 0)
    if not tensile.size or tensile[0] == 0:
        return CollapseLoads(0.0, 0.0)
    k = start + 1 + int(tensile[0])  # the first node that is not compressed
    zero = r[k - 1] + (r[k] - r[k - 1]) * hoop[k - 1] / (hoop[k - 1] - hoop[k])
    h, E_t = float(problem.web_thickness), problem.stack.tangential
    depth = np.linspace(min(h, zero - r[start]), zero - r[start], DEPTHS)
    P = stresses_between(result, r[start] + depth)["pressure"]
    by_stiffness = 4 * (r[start] + depth / 2) ** 3 * P / E_t
    sliding, bonded = by_stiffness / (depth * h**2), by_stiffness[-1] / max(depth[-1], h) ** 3
    return CollapseLoads(float(np.max(sliding)), float(bonded))

"""The thin orthotropic strip: the web in the nip (thesis sec. 2.3, eq. 72).

To leading order in the thickness 2h the web carries one pressure p through its thickness and a
tension T(x) with dT/dx = q+ + q-; its strain and its change of thickness are

    eps(x)         = c11 T(x)/(2h) - c12 p(x)
    v+(x) - v-(x)  = c12 T(x) - 2h F(p(x))

with the plane-strain compliances of the web's own material: F = c22 p of a linear one.  That of a
stack follows from one potential (:mod:`woundon.problems.stack`), which has c11 = 1/E_t and
c12 = -nu/E_t under any pressure, so that F = int dp/E_r alone is not linear, and c22 = F' is its
tangent.  The shear that the faces' friction puts through the web enters neither: by its thickness
it is small against what is kept, of any material.
"""

from __future__ import annotations

from functools import lru_cache
from math import sqrt
from typing import NamedTuple

__all__ = ["Compliance", "compliance", "stiffness_along"]


class Compliance(NamedTuple):
    """Plane-strain compliances [1/Pa]: 1 along the web, 2 through the thickness (thesis eq. 63)."""

    c11: float
    c12: float
    c22: float


def stiffness_along(A_rr: float, A_tt: float, A_rt: float) -> float:
    """Return D = A_tt - A_rt^2/A_rr [Pa], the stiffness along a surface free of pressure.

    The difference is taken before the squares.  Where A_rt is all but sqrt(A_rr A_tt), as in a
    nearly incompressible material, these three have lost D all the same: who knows it says it.
    """
    s = sqrt(A_rr * A_tt)
    return (s - A_rt) * (s + A_rt) / A_rr


@lru_cache  # asked for a dozen times in every solve
def compliance(A_rr: float, A_tt: float, A_rt: float, D: float | None = None) -> Compliance:
    """Return the inverse of the plane-strain stiffness [1/Pa]; c12 <= 0 for A_rt >= 0.

    ``D`` is :func:`stiffness_along`, where it is known better.
    """
    D = D or stiffness_along(A_rr, A_tt, A_rt)
    return Compliance(1 / D, -A_rt / A_rr / D, A_tt / A_rr / D)

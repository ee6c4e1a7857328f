"""The thin orthotropic strip: the web in the nip (thesis sec. 2.3, eq. 72).

To leading order in the thickness 2h the web carries one pressure p through its thickness and a
tension T(x) with dT/dx = q+ + q-; its strain and its change of thickness are

    eps(x)         = c11 T(x)/(2h) - c12 p(x)
    v+(x) - v-(x)  = c12 T(x) - 2h F(p(x))

with the plane-strain compliances of its material and F = c22 p for a linear web.  For a web that
hardens (:mod:`woundon.problems.stack`) c11 = 1/E_t and c12 = -nu/E_t are constant, F = int dp/E_r
is nonlinear, and c22 = F' is its tangent.  The shear strain of the web is neglected; its effect is
smaller by the ratio of the thickness to the nip width.
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
    """Return D = A_tt - A_rt^2/A_rr [Pa], the plane-strain stiffness along a free surface.

    The factored form reduces cancellation.  In a nearly incompressible material, A_rt close to
    sqrt(A_rr A_tt), D cannot be computed from the other three accurately and is passed separately.
    """
    s = sqrt(A_rr * A_tt)
    return (s - A_rt) * (s + A_rt) / A_rr


@lru_cache  # called a dozen times in every solution
def compliance(A_rr: float, A_tt: float, A_rt: float, D: float | None = None) -> Compliance:
    """Return the inverse of the plane-strain stiffness [1/Pa]; c12 <= 0 for A_rt >= 0.

    ``D`` is :func:`stiffness_along`, if it is known more accurately.
    """
    D = D or stiffness_along(A_rr, A_tt, A_rt)
    return Compliance(1 / D, -A_rt / A_rr / D, A_tt / A_rr / D)

"""The linear elastic, orthotropic half-plane (thesis sec. 2.1).

With tractions p (pressure) and q (along +x) on the surface of the lower half-plane

    u(x) = -(A/2) int p(s) sgn(x-s) ds - (B/pi) int q(s) ln|x-s| ds
    v(x) =  (C/pi) int p(s) ln|x-s| ds - (A/2)  int q(s) sgn(x-s) ds          (thesis eq. 32)

where v is the outward normal displacement and A, B, C follow from the stiffness (eq. 30, whose
print is garbled; checked against C = 2 (1 - nu^2)/E of an isotropic material).
"""

from __future__ import annotations

from functools import lru_cache
from math import pi, sqrt
from typing import NamedTuple

from .kernels import Kernel, SurfaceKernels
from .strip import stiffness_along

__all__ = ["Coefficients", "coefficients", "surface_kernels"]


class Coefficients(NamedTuple):
    """A, B, C of the half-plane's displacements [1/Pa] (thesis eq. 30)."""

    A: float
    B: float
    C: float


def coefficients(
    A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None = None
) -> Coefficients:
    """Return A, B, C [1/Pa] of a half-plane with normal direction r and surface direction t.

    Parameters
    ----------
    A_rr, A_tt, A_rt, G : float
        Plane-strain stiffness [Pa].
    D : float, optional
        As of :func:`.strip.stiffness_along`, if it is known more accurately.

    Notes
    -----
    Thesis eq. (30), re-derived: s = sqrt(A_rr A_tt), A = 1/(s + A_rt),
    B = sqrt(A_rr/G) root/det and C = sqrt(A_tt/G) root/det with
    root^2 = (s - A_rt)(s + A_rt + 2G) and det = A_rr A_tt - A_rt^2 = A_rr D.
    """
    s = sqrt(A_rr * A_tt)
    # with s - A_rt = A_rr D/(s + A_rt) no term becomes infinite for incompressible materials
    D = D or stiffness_along(A_rr, A_tt, A_rt)
    B = sqrt((1 + 2 * G / (s + A_rt)) / (G * D))
    return Coefficients(1 / (s + A_rt), B, sqrt(A_tt / A_rr) * B)


@lru_cache(maxsize=64)
def surface_kernels(
    A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None = None
) -> SurfaceKernels:
    """Return the influence functions of the half-plane (thesis eq. 32), with t in metres.

    Parameters as of :func:`coefficients`.
    """
    A, B, C = coefficients(A_rr, A_tt, A_rt, G, D)
    return SurfaceKernels(
        normal_p=Kernel(log=C / pi),
        normal_q=Kernel(sign=-A / 2),
        tangent_p=Kernel(sign=-A / 2),
        tangent_q=Kernel(log=-B / pi),
        slope_p=Kernel(inverse=C / pi),
        slope_q=Kernel(delta=-A),
        strain_p=Kernel(delta=-A),
        strain_q=Kernel(inverse=-B / pi),
        uniform_strain=-A,
    )

"""What ending the cylinder's Fourier series early does to the nip-induced tension.

The thesis and the independent program sum the series beyond the half-plane's part,
sum (Y_n - Y_1/n), term by term up to some n.  The covered drum of sec. 4.6 shows what is missing:

    python benchmarks/series_truncation.py
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import ceil, log2, pi, sinh
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import woundon as wo
from jorkama2001.cases import paper_nip
from woundon.elasticity import cylinder, half_plane
from woundon.elasticity.kernels import Kernel, SurfaceKernels

Array = np.ndarray
RANK = 240  # interpolation points, fine enough for the ripples


class TruncatedCylinder(wo.Cylinder):
    """A cylinder whose series ends after ``terms`` harmonics."""

    terms: int

    def kernels(self, reach: float = 1e-3) -> SurfaceKernels:
        """Return the influence functions with a finite sum, as far as ``reach`` [m]."""
        return _kernels(self, 2.0 ** ceil(log2(reach)))

    def respond(
        self, grid: wo.ContactGrid, a: float, about: wo.Tractions | None = None
    ) -> wo.Response:
        """Return them integrated; a sum that ends after n terms ripples: 2 pi R/n is its wave."""
        length = a * sinh(20 / RANK)
        kernels = replace(self.kernels(2 * a), length=length)
        return grid.integrated(kernels, self.curvature, self.radius, a)


@lru_cache
def _kernels(body: TruncatedCylinder, reach: float) -> SurfaceKernels:
    R, stiffness = body.radius, body.material.stiffness
    A, B, C = half_plane.coefficients(*stiffness)
    n = np.arange(1, body.terms + 1)
    gamma_1, gamma_2, chi_1, chi_2 = cylinder.sequences(n, R, body.core_radius, *stiffness)
    g1, g2, c1, c2 = gamma_1 - C * R / n, gamma_2 + A * R / n, chi_1 + A * R / n, chi_2 - B * R / n
    t = np.linspace(-reach, reach, 16 * ceil(body.terms * reach / R) + 401)
    sin, cos = np.sin(np.outer(t, n) / R), np.cos(np.outer(t, n) / R)
    log, cot = _circle(t, R)
    v_p = C / pi * log - cos @ g1 / (pi * R)
    slope_p = C / pi * cot + sin @ (n * g1) / (pi * R**2)
    slope_q = A / (2 * pi * R) + cos @ (n * g2) / (pi * R**2)
    v_q = A * t / (2 * pi * R) + sin @ g2 / (pi * R)
    du_p = A / (2 * pi * R) + cos @ (n * c1) / (pi * R**2)
    du_q = -B / pi * cot - sin @ (n * c2) / (pi * R**2)

    def smooth(values: Array) -> Any:
        return CubicSpline(t, values)

    return SurfaceKernels(
        normal_p=Kernel(log=C / pi, smooth=smooth(v_p)),
        normal_q=Kernel(sign=-A / 2, smooth=smooth(v_q)),
        slope_p=Kernel(inverse=C / pi, smooth=smooth(slope_p)),
        slope_q=Kernel(delta=-A, smooth=smooth(slope_q)),
        strain_p=Kernel(delta=-A, log=C / (pi * R), smooth=smooth(du_p + v_p / R)),
        strain_q=Kernel(inverse=-B / pi, sign=-A / (2 * R), smooth=smooth(du_q + v_q / R)),
    )


def _circle(t: Array, R: float) -> tuple[Array, Array]:
    """Return ln|2 sin(t/2R)| - ln|t| and its derivative."""
    off = np.where(t == 0, 1.0, t)
    log = np.where(t == 0, -np.log(R), np.log(np.abs(2 * np.sin(off / (2 * R)) / off)))
    return log, np.where(t == 0, 0.0, 1 / (2 * R * np.tan(off / (2 * R))) - 1 / off)


def truncated(body: wo.Cylinder, terms: int | None) -> wo.Cylinder:
    """Return the body with its series ended; None keeps it."""
    fields = {name: getattr(body, name) for name in ("radius", "core_radius", "material")}
    return body if terms is None else TruncatedCylinder(terms=terms, **fields)


def covered_nip(roll_terms: int | None, drum_terms: int | None) -> float:
    """Return NIT of Table 1's nip with a 20 mm cover of 10 MPa [N/m]."""
    cover = wo.Cylinder(radius=0.5, core_radius=0.48, material=wo.material("soft-cover"))
    problem = paper_nip(drum=truncated(cover, drum_terms))
    problem = problem.replace(roll=truncated(problem.roll, roll_terms))
    return wo.solve_nip(problem, nodes=129).nip_induced_tension


if __name__ == "__main__":
    print("terms    NIT [N/m], series of    roll and drum    roll       drum       ended")
    for terms in (250, 500, 1000, 2000, 4000):
        values = [covered_nip(*ends) for ends in ((terms, terms), (terms, None), (None, terms))]
        print(f"{terms:5d}" + " " * 27 + "   ".join(f"{value:10.4f}" for value in values))
    print(f"  all                           {covered_nip(None, None):10.4f}")

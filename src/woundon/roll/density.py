r"""Density of a wound roll over its radius.

A layer wound at s with the stress T loads the roll below by T h/s.  The surface moves inwards by
(1 + kappa) T h/E_t, so that the radius increases by less than the layer thickness,

    ds = h g dn,    g = 1 - (1 + kappa) T/E_t,

and the mass of this web, stretched by T/E_t, is dm = rho 2 pi s ds/(g (1 + T/E_t)).  Divided by the
increase of the roll volume, it is the density that a density analyser measures during winding, from
the diameter and the length of web on the roll.  Divided by the final volume of these layers, at
r + u, it is the density of the finished roll.  In the finished roll

    du/dr = (1 + kappa) T/E_t + eps_r,    eps_r = -F(P) - nu sigma_t/E_t + alpha_r dT

follows from the equations (:mod:`.equations`), so that a layer of the finished roll has the
thickness h (1 + eps_r) to first order of the strains: mass is conserved.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

__all__ = ["density_during_winding", "finished_density", "volume", "wound_mass"]

Array = np.ndarray
GAUSS = 4  # points of a cell


def _winding_strains(result: Any, r: Array) -> tuple[Array, Array]:
    """Return (1 + kappa) T/E_t and T/E_t at radii."""
    strain = result.problem.tension_curve.at(r) / result.problem.stack.tangential
    return (1 + result.kappa(np.log(r))) * strain, strain


def density_during_winding(result: Any, r: Array) -> Array:
    """Return the mass of web per increase of the roll volume [kg/m^3].

    It is nan without the density of the web, and where the surface moves inwards by more than the
    layer thickness, which is outside the range of small strains.
    """
    inward, strain = _winding_strains(result, r)
    g = np.where(inward < 1, 1 - inward, np.nan)
    density = result.problem.density
    return np.asarray((np.nan if density is None else density) / (g * (1 + strain)))


def finished_density(result: Any) -> Array:
    """Return the density of the finished roll at the nodes [kg/m^3]."""
    problem, r = result.problem, result.radius
    stack, hoop = problem.stack, result.hoop_stress
    radial_strain = (
        -stack.radial.strain_at(result.pressure)
        - stack.poissons_ratio / stack.tangential * hoop
        + problem.radial_expansion * problem.temperature_change
    )
    du_dr = _winding_strains(result, r)[0] + radial_strain
    volume_ratio = (1 + result.displacement / r) * (1 + du_dr)
    return np.asarray(density_during_winding(result, r) / volume_ratio)


def wound_mass(result: Any) -> float:
    """Return the mass of all layers, per metre of width [kg/m]."""
    points, weights = np.polynomial.legendre.leggauss(GAUSS)
    ends = np.union1d(result.radius, result.stage_radius)
    half = np.diff(ends)[:, None] / 2
    r = ends[:-1, None] + half * (1 + points)
    density = density_during_winding(result, r.ravel()).reshape(r.shape)
    return float(np.sum(half * weights * 2 * pi * r * density))


def volume(result: Any) -> float:
    """Return the volume of the finished roll, per metre of width [m^2]."""
    inner, outer = (result.radius + result.displacement)[[0, -1]].tolist()
    return pi * float(outer**2 - inner**2)

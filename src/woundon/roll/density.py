r"""How dense a wound roll is, over its radius.

A lap laid at s with the stress T presses the roll below by T h/s, which gives way by
(1 + kappa) T h/E_t; so the surface grows by less than the lap's thickness,

    ds = h g dn,    g = 1 - (1 + kappa) T/E_t,

and the mass of web laid there, drawn out by T/E_t, is dm = rho 2 pi s ds/(g (1 + T/E_t)).  Over the
volume that the roll has grown by it is the density that is measured while a roll is wound, by its
diameter and the length of web on it.  Over the volume which these laps have at last, between
r + u, it is that of the finished roll.  There

    du/dr = (1 + kappa) T/E_t + eps_r,    eps_r = -F(P) - nu sigma_t/E_t + alpha_r dT

follows of the equations (:mod:`.equations`), so that a lap of the finished roll is h (1 + eps_r)
thick, to first order of the strains: the mass laid is the mass there, in whichever way it is
counted.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

__all__ = ["as_wound", "in_the_roll", "volume", "wound_mass"]

Array = np.ndarray
GAUSS = 4  # points of a cell


def _drawn(result: Any, r: Array) -> tuple[Array, Array]:
    """Return (1 + kappa) T/E_t and T/E_t at radii."""
    strain = result.problem.tension_curve.at(r) / result.problem.stack.tangential
    return (1 + result.kappa(np.log(r))) * strain, strain


def as_wound(result: Any, r: Array) -> Array:
    """Return the density by which the roll has grown [kg/m^3]; nan without that of the web.

    Also where the roll below gives way by more than a lap's thickness, which no small strain tells.
    """
    sunk, strain = _drawn(result, r)
    grown = np.where(sunk < 1, 1 - sunk, np.nan)
    return np.asarray(_of_the_web(result) / (grown * (1 + strain)))


def in_the_roll(result: Any) -> Array:
    """Return the density of the finished roll at the nodes [kg/m^3]."""
    problem, r = result.problem, result.radius
    stack, hoop = problem.stack, result.hoop_stress
    thinner = (
        stack.radial.strain_at(result.pressure) + stack.poissons_ratio / stack.tangential * hoop
    )
    thinner = thinner - problem.radial_expansion * problem.temperature_change
    moved = 1 + _drawn(result, r)[0] - thinner
    return np.asarray(as_wound(result, r) / ((1 + result.displacement / r) * moved))


def wound_mass(result: Any) -> float:
    """Return the mass of all laps laid, per metre of width [kg/m]."""
    points, weights = np.polynomial.legendre.leggauss(GAUSS)
    ends = np.union1d(result.radius, result.stage_radius)
    half = np.diff(ends)[:, None] / 2
    r = ends[:-1, None] + half * (1 + points)
    laid = as_wound(result, r.ravel()).reshape(r.shape)
    return float(np.sum(half * weights * 2 * pi * r * laid))


def volume(result: Any) -> float:
    """Return the volume of the finished roll, per metre of width [m^2]."""
    inner, outer = (result.radius + result.displacement)[[0, -1]].tolist()
    return pi * float(outer**2 - inner**2)


def _of_the_web(result: Any) -> float:
    density = result.problem.density
    return float("nan") if density is None else float(density)

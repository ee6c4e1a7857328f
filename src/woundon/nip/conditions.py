"""Violations of contact conditions by given arrays, dimensionless."""

from __future__ import annotations

from math import inf

import numpy as np

from ..elasticity.surface import SurfaceResponse
from ..errors import InvalidProblem
from ..problems.contact_problem import ContactProblem
from ..results import largest

__all__ = [
    "LARGEST_MESH",
    "body_equilibrium",
    "difference",
    "friction_law",
    "integral",
    "negative_pressure",
]

Array = np.ndarray

# Nodes of the contact.  A file with more is rejected before matrices of their square are allocated.
LARGEST_MESH = 2049


def friction_law(
    zones: Array, traction: Array, slip: Array, bound: Array, *, unit: float, slip_scale: float
) -> dict[str, float]:
    """Return the largest violation of each condition of the friction law.

    Parameters
    ----------
    zones : (k,) int array
        0 stick, 1 and -1 slip; another number violates ``slip_traction``.
    traction, slip, bound : (k,) arrays
        q, v and mu p.
    unit : float
        mu times the largest pressure, to which tractions are relative.
    slip_scale : float
        Slip to which slips are relative.
    """
    # Signed violations are negative where a condition holds; ``largest`` is at least 0.
    sticks, slips = zones == 0, zones != 0
    direction = zones[slips]
    invalid_zone = 0.0 if (np.abs(direction) == 1).all() else inf
    excess = (np.abs(traction) - bound)[sticks] / unit
    deviation = np.abs(traction[slips] - direction * bound[slips]) / unit
    return {
        "stick": largest(np.abs(slip[sticks])) / slip_scale,
        "friction_bound": largest(excess),
        "slip_traction": invalid_zone + largest(deviation),
        "slip_direction": largest(-direction * slip[slips]) / slip_scale,
    }


def negative_pressure(*pressures: Array) -> float:
    """Return the largest tensile pressure relative to the largest pressure."""
    values = np.concatenate(pressures)
    return largest(np.maximum(-values, 0.0)) / float(np.abs(values).max())


def integral(values: Array, x: Array) -> float:
    """Return the integral of piecewise linear values over all nodes."""
    return float(np.trapezoid(values, x))


def difference(one: Array, two: Array) -> float:
    """Return the largest difference; inf unless the shapes and the places of nan are the same."""
    if one.shape != two.shape or not np.array_equal(np.isnan(one), np.isnan(two)):
        return inf
    defined = ~np.isnan(one)
    return largest(np.abs(one[defined] - two[defined]))


def body_equilibrium(
    problem: ContactProblem,
    surfaces: tuple[SurfaceResponse, SurfaceResponse],
    loads: tuple[tuple[Array, Array], ...],
) -> dict[str, float]:
    """Return the residual of the equilibrium inside each nonlinear body (energy norm).

    Parameters
    ----------
    problem : ContactProblem
    surfaces : two SurfaceResponse
    loads : two (pressures, tractions)
        At the nodes of the surfaces.

    Raises
    ------
    InvalidProblem
        If the state of a body lies outside of its law.
    """
    if problem.linear:
        return {}
    # imported late: SciPy's sparse solvers take a quarter of a second to load
    from ..elasticity.hardening_surface import HardeningSurface

    out = {}
    for name, surface, load in zip(problem.pair, surfaces, loads, strict=True):
        if isinstance(surface, HardeningSurface):
            if message := surface.range_message(*load):
                raise InvalidProblem.at(name, message)
            out[f"{name}_equilibrium"] = surface.residual(*load)
    return out

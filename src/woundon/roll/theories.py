"""Other theories of wound rolls: closed forms, and the published layer-by-layer scheme."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arguments import check_type, whole_number
from ..elasticity.quadrature import gauss_points
from ..errors import InvalidProblem
from ..problems.free_strains import FREE_STRAINS
from ..problems.radial_laws import Constant
from ..problems.roll import RollProblem
from ..problems.schedules import Profile
from ..problems.stack import Stack
from .finished import FinalChanges, equations_of, layers_of, middle_of_layers
from .layer_by_layer import wind_layers
from .stage_nodes import nodes_between

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["RollStresses", "constant_moduli", "layer_by_layer", "plateau_pressure"]

Array = np.ndarray

GAUSS = 20  # points on each cell of an integral


class RollStresses(NamedTuple):
    """Radii [m], pressure and hoop stress there [Pa]."""

    radius: Array
    pressure: Array
    hoop_stress: Array


def constant_moduli(problem: RollProblem, radius: ArrayLike) -> RollStresses:
    """Return the stresses in a roll with constant moduli, in closed form.

    With g^2 = E_t/E_r and F(r) = (r/rc)^(g-1) + A (r/rc)^(-g-1), A by the core condition::

        P(r) = F(r) int_r^R T/(s F(s)) ds,    sigma_t = T - (F + r F') int_r^R T/(s F(s)) ds

    the sum of the increments by each layer in the limit of thin ones.  Their thickness h adds, to
    first order, p = T h/2r and terms in r^(+-g - 1), by which the pressure at the surface is zero.
    A temperature change, core shrinkage and the removal of the core add such terms and a constant.
    Layers are taken to stay in contact.  The hoop stress is that in the middle of the layers.

    With centrifugal force the roll at rest is that of the tension T - c + Q_B(s), with c = rho V^2
    and P_B, Q_B = r P_B' the stresses by the rotation of the roll with the surface s: a layer
    presses with T - c, and when the roll stops, the stresses by the rotation vanish.

    Parameters
    ----------
    problem : RollProblem
        With a number for ``stack.radial``.
    radius : array_like
        [m].

    Raises
    ------
    InvalidProblem
        For a stack whose modulus depends on the pressure, and for changes over the radius.
    """
    check_type("problem", problem, RollProblem)
    stack = problem.stack
    if not isinstance(stack.radial, Constant):
        raise InvalidProblem.at(
            "stack.radial", "depends on the pressure; must be a number, the constant modulus"
        )
    for name in FREE_STRAINS:
        if isinstance(getattr(problem, name), Profile):
            raise InvalidProblem.at(name, "depends on the radius; must be a number")
    r = np.atleast_1d(np.asarray(radius, dtype=float))
    core, R, E_t = problem.core.radius, problem.radius, stack.tangential
    layers = layers_of(problem)
    equations = layers.equations
    g, b = float(np.sqrt(E_t / stack.radial.modulus(0.0))), equations.core
    A = (g - 1 - b) / (g + 1 + b)

    def homogeneous_solution(x: Array) -> tuple[Array, Array]:
        """Return F and r F' over x = ln(r/rc), scaled by exp((1 - g) x) to prevent overflow."""
        decaying_term = A * np.exp(-2 * g * x)
        return 1 + decaying_term, (g - 1) - (g + 1) * decaying_term

    # int_r^R T/(s F(s)) ds over y = ln(s/rc); the scaled integrand decays as exp(-(g-1)(y - x))
    curve, c = problem.tension_curve, problem.centrifugal_stress

    def tension(s: Array) -> Array:
        """Return T of the roll at rest at radii s [Pa]."""
        if not c:
            return curve.at(s)
        nu = stack.poissons_ratio
        return curve.at(s) + c * (_rotation_slope(np.log(s / core), g, b, nu) - 1)

    start, end, kinks = float(np.log(core)), float(np.log(R)), np.log(curve.kinks)
    layer = equations.core_layer
    grid = nodes_between(start, end, 400, min(1 / g, 0.3), kinks, core_layer=layer) - start
    # the first one is at the core; then those of the pressure and of the hoop stress
    middle = middle_of_layers(r, np.array([core, R]), layers.thickness)
    x_all = np.log(np.concatenate([[core], r, middle]) / core)
    integral = np.empty(x_all.size)
    for k, x in enumerate(x_all):
        # cells from x to the surface
        y, weights = gauss_points(np.concatenate([[x], grid[grid > x]]), GAUSS)
        integrand = (
            tension(core * np.exp(y)) * np.exp(-(g - 1) * (y - x)) / homogeneous_solution(y)[0]
        )
        integral[k] = float(weights @ integrand)
    P_wound, integral = float((1 + A) * integral[0]), integral[1:]
    r_all = core * np.exp(x_all[1:])
    F, slope = homogeneous_solution(x_all[1:])
    P_changes, Q_changes = layers.total(
        np.log(r_all), *_final_changes(problem, g, b, r_all, P_wound)
    )
    hoop = tension(r_all) - (F + slope) * integral - P_changes - Q_changes
    return RollStresses(r, (F * integral + P_changes)[: r.size], hoop[r.size :])


def _rotation_slope(x: Array, g: float, b: float, nu: float) -> Array:
    """Return Q_B/c at the surface of rotating rolls with the depth x = ln(s/r_c), constant moduli.

    With B = c r^2/s^2, g^2 = E_t/E_r and b of the core condition,
    r^2 P'' + 3 r P' + (1 - g^2) P = (3 + nu) B,  r P' - b P = B at the core,  P = 0 at the surface.
    """
    if abs(g - 3) < 1e-6:  # then r^2 is a homogeneous solution
        g = 3 + 1e-6
    k = (3 + nu) / (9 - g * g)  # particular solution P = k B
    # P = k B + c1 (r/s)^(g - 1) + c2 (r/r_c)^(-g - 1); c1 = -k - c2 exp(-(g + 1) x) at the surface
    at_core = np.exp(-2 * x)  # B/c at the core
    growing, decaying = np.exp(-(g - 1) * x), np.exp(-(g + 1) * x)
    of_c2 = -(g + 1 + b) - (g - 1 - b) * growing * decaying
    c2 = (at_core * (1 - k * (2 - b)) + k * (g - 1 - b) * growing) / of_c2
    c1 = -k - c2 * decaying
    return np.asarray(2 * k + (g - 1) * c1 - (g + 1) * c2 * decaying)


def _final_changes(
    problem: RollProblem, g: float, b: float, r: Array, P_wound: float
) -> tuple[Array, Array]:
    """Return the pressure P added by the changes after winding, and r P', at radii r (k,) [Pa].

    It does not contain p, under which the layers are wound.  ``P_wound`` is the pressure at the
    core as wound, of thin layers.

    With g^2 = E_t/E_r and b of the core condition,
    r^2 P'' + 3 r P' + (1 - g^2) P = dC,  r P' - b P = -dT_c at the core,  P = -p at the surface.

    Off the core the pressure there is zero: P = -P_c - p, with the pressure P_c as wound.
    """
    changes, core, R = FinalChanges(problem), problem.core.radius, problem.radius
    source, core_tension = float(changes.source(np.log(core))), changes.core

    def particular(r: Array) -> tuple[Array, Array]:
        """Return the particular solution P and r P': a constant, or a logarithm for g = 1."""
        if abs(g - 1) < 1e-9:
            return source * np.log(r / core) / 2, np.full(r.shape, source / 2)
        return np.full(r.shape, source / (1 - g**2)), np.zeros(r.shape)

    (P_core, P_surface), (Q_core, _) = particular(np.array([core, R]))
    p_core, p_surface = layers_of(problem).own_pressure(np.log([core, R])).tolist()
    growing, decaying = g - 1, -g - 1  # exponents of the homogeneous solutions
    # (r/R)^growing and (r/core)^decaying are at most 1; rows: core condition, surface
    at_core = (core / R) ** growing
    matrix = [[(growing - b) * at_core, decaying - b], [1.0, (R / core) ** decaying]]
    c = np.linalg.solve(matrix, [-core_tension - Q_core + b * P_core, -p_surface - P_surface])
    at_bore = P_wound + p_core + P_core
    if problem.core_removed or at_bore + c[0] * at_core + c[1] < 0:
        matrix[0] = [at_core, 1.0]
        c = np.linalg.solve(matrix, [-at_bore, -p_surface - P_surface])
    growing_part, decaying_part = c[0] * (r / R) ** growing, c[1] * (r / core) ** decaying
    P, Q = particular(r)
    return P + growing_part + decaying_part, Q + growing * growing_part + decaying * decaying_part


def plateau_pressure(stack: Stack, tension: float) -> float:
    """Return the pressure far from core and surface of a roll wound at constant tension.

    The first integral of the equations below a surface, many thin layers deep: the energy of the
    compression equals that of the tension.  For Pfeiffer's law, E_r = K2 (K1 + P)::

        T^2 K2/(2 E_t) = P - K1 ln(1 + P/K1)

    For other laws see :meth:`woundon.Stack.plateau_pressure`.  The curvature is neglected, which
    makes the pressure too low by the fraction 1.0 to 1.2 (E_r/E_t)^1/2: 3 to 13 % for real rolls.
    For E_t/E_r below 100 there is hardly a plateau.  The hoop stress on the plateau is -P.

    Parameters
    ----------
    stack : Stack
    tension : float
        Wound-on stress T [Pa].
    """
    check_type("stack", stack, Stack)
    return stack.plateau_pressure(tension)


def layer_by_layer(problem: RollProblem, groups: int | None = None) -> RollStresses:
    """Return the stresses by the published layer-by-layer scheme (Hakiel 1987), of order one.

    Parameters
    ----------
    problem : RollProblem
        Its final changes and the centrifugal force are ignored.
    groups : int, optional
        Number of groups of layers, 10 to 20 000; by default single layers.

    Returns
    -------
    RollStresses
        At the inner face of each layer, then at the surface.

    Raises
    ------
    InvalidProblem
        For more than 20 000 layers, or groups out of range.
    """
    check_type("problem", problem, RollProblem)
    core, R = problem.core.radius, problem.radius
    layers = round((R - core) / problem.web_thickness)
    if groups is None and layers > 20_000:
        raise InvalidProblem.at("groups", f"missing; must be given for {layers} layers, <= 20000")
    count = max(layers, 2) if groups is None else whole_number("groups", groups, 10, 20_000)
    r = core + (R - core) * np.arange(count + 1) / count
    T = problem.tension_curve.at(r)
    equations = equations_of(problem)
    P = wind_layers(equations.modulus, equations.tangential, equations.core, r, T)
    return RollStresses(r, P, -(P + r * np.gradient(P, r, edge_order=2)))

r"""The air film that a web entrains through a nip, and the reduced friction.

Near the inlet edge the pressure of the nip without air is K sqrt(s), s the distance downstream of
the edge.  K, the compliance C of the surfaces and the speed give the film that passes
(:mod:`.air_inlet`).  Under a pressure p the passing film has the thickness m/(p_a + p); friction
falls linearly with the thickness in units of the roughness (:func:`.air_films.friction_share`).

A viscoelastic surface responds to waves of the wave number 1/l, l the length of the inlet, with its
modulus at the frequency V/l; a drum that the web is wrapped on deforms by C/(1 + T C/l), as the web
tension acts in parallel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from ..elasticity import half_plane
from ..elasticity.relaxation import bulk_relaxation, modulus_ratio
from ..errors import InvalidProblem
from ..quantities import Quantity, length, pure, share
from ..results import ReadOnly, largest
from ..validity import LENGTH, THICKNESS
from .air_films import escaped_film, foil_film, friction_share, nip_film
from .conditions import difference

if TYPE_CHECKING:
    from ..problems.bodies import Body
    from ..problems.nip import NipProblem
    from .equations import NipState

__all__ = [
    "AirFilm",
    "air_conditions",
    "air_film",
    "air_warnings",
    "film_of_state",
    "films_of",
    "inlet_gradient",
]

Array = np.ndarray

# Smallest friction coefficient with a film: a nip without any friction has no unique solution.
MIN_FRICTION = 1e-6
# Smallest pressure of the inlet relative to the largest one, so that its logarithm exists.
MIN_PRESSURE = 1e-6
LENGTH_BRACKET = 1e-12, 1e3  # bracket of the length of the inlet [m]
# Node from which, and share of the half width up to which, K is taken: on the first two nodes a
# piecewise linear Hertz pressure is 9 and 1 % off.
FIRST_NODE, FARTHEST_SHARE = 3, 0.5
LONG_INLET = 0.3  # of the half width: up to there the film is accurate to 2 % (tests/verification)


@dataclass(frozen=True, eq=False, kw_only=True)
class AirFilm(ReadOnly):
    """The air film of a nip, and the friction coefficients reduced by it.

    Attributes
    ----------
    thickness : (M,) array
        Film between web and roll at the nodes of the nip [m].
    foil_film : float
        Film that the web would entrain without a nip [m].
    nip_film : float
        Film that passes the nip, under the pressure T_in/R of the outermost layer [m].
    film : float
        Film between the layers when the next layer is wound: the smaller one of the two, minus the
        air that has flowed through the web [m].
    film_in_nip : float
        Film under the mean pressure of the nip [m].
    roll_friction, wrap_friction : float
        Friction coefficients in the nip and on the roll wrap, reduced by the film [1].
    friction_share : float
        ``roll_friction`` relative to that without air [1].
    gradient : float
        K [Pa/sqrt(m)]: the pressure near the inlet edge is K sqrt(s).
    inlet_length : float
        Length of the inlet in which the film forms [m].

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example().replace(web_speed=20.0, air=wo.Air(roughness=3e-6))
    >>> film = wo.solve(problem, nodes=41).air
    >>> print(f"{1e6 * film.film:.2f} um of air, {film.friction_share:.0%} of the friction")
    1.90 um of air, 100% of the friction
    """

    part_of_result: ClassVar[bool] = True  # its fields are outputs of the result that holds it

    thickness: Annotated[Array, length("h_a", "air film in the nip", "um")]
    foil_film: Annotated[float, length("h_foil", "foil-bearing film thickness (no nip)", "um")]
    nip_film: Annotated[float, length("h_nip", "air film entrained through the nip", "um")]
    film: Annotated[float, length("h", "air film between the layers", "um")]
    film_in_nip: Annotated[float, length("h_in", "air film in the nip at its mean pressure", "um")]
    roll_friction: Annotated[float, pure("mu+ eff", "friction in the nip, reduced by the air film")]
    wrap_friction: Annotated[
        float, pure("mu_w+ eff", "friction on the roll wrap, reduced by the air film")
    ]
    friction_share: Annotated[float, share("mu/mu0", "fraction of friction retained in the nip")]
    gradient: Annotated[
        float, Quantity("K", "Pa/m**0.5", "inlet pressure-gradient coefficient, p = K sqrt(s)")
    ]
    inlet_length: Annotated[float, length("l", "length of the inlet of the air film", "um")]


def _compliance(problem: NipProblem, length: float) -> float:
    """Return C, half the sum of the compliances of both surfaces at wave number 1/length [1/Pa].

    The length is 0 if the web does not move.

    A web that is wrapped on the drum holds the drum down: its tension T acts in parallel, so that
    the compliance C of the drum becomes C/(1 + T C/length).
    """
    roll, drum = (_body_compliance(body, problem.web_speed, length) for body in problem.bodies)
    if problem.drum_wrap > 0 and length > 0:
        drum /= 1 + max(problem.hoop_tension, 0.0) * drum / length
    return (roll + drum) / 2


def _body_compliance(body: Body, speed: float | None, length: float) -> float:
    """Return the compliance of a body; of a viscoelastic one that at the frequency V/length."""
    material = body.surface_material
    if material is None or not material.relaxes or speed is None:
        return body.compliance
    relaxation, k = material.relaxation(speed), np.array(1 / length)
    creep = 1 / modulus_ratio(relaxation, k)
    if material.bulk_is_constant:  # 1/(2 G) and 3/(2 (3K + G)) creep as G and 3K + G
        stiffness = material.stiffness
        shear_part = 1 / (2 * stiffness.shear * half_plane.coefficients(*stiffness).C)
        bulk_creep = 1 / modulus_ratio(
            bulk_relaxation(stiffness.rt, stiffness.shear, relaxation), k
        )
        creep = shear_part * creep + (1 - shear_part) * bulk_creep
    return float(body.compliance * abs(creep))


def _inlet_length(problem: NipProblem, gradient: Callable[[float], float]) -> float:
    """Return the length l of the inlet, at which K is evaluated [m]; 0 without speed.

    Root of l = (12 mu V/(C(l)^2 K(l)^3))^(2/5).
    """
    V, air = problem.web_speed, problem.air
    assert air is not None
    if not V:
        return 0.0
    from scipy.optimize import brentq

    drag = 12 * air.viscosity * V

    def defect(ln_length: float) -> float:
        """Return the residual of the logarithm of this equation."""
        length = exp(ln_length)
        C, K = _compliance(problem, length), gradient(length)
        return ln_length - 0.4 * log(drag / (C**2 * K**3))

    low, high = map(log, LENGTH_BRACKET)
    return exp(float(brentq(defect, low, high, xtol=1e-14, rtol=1e-14)))


def inlet_gradient(problem: NipProblem, x: Array, pressure: Array, half_width: float) -> float:
    """Return K = p/sqrt(s) [Pa/sqrt(m)] of a nip at the distance s = l from the edge.

    Closer to the edge the pressure may vary differently, as with a viscoelastic drum or a web that
    is wrapped on the drum, but such short variations have no effect on the film.

    Parameters
    ----------
    problem : NipProblem
        With air.
    x, pressure : (M,) arrays
        Nodes of the nip [m] and the pressure between web and roll, without air [Pa].
    half_width : float
        a [m].
    """
    s, p = x[FIRST_NODE:] + half_width, pressure[FIRST_NODE:]
    gradient = np.maximum(p, MIN_PRESSURE * p.max()) / np.sqrt(s)

    def gradient_at(length: float) -> float:
        """Return K at the distance s = length."""
        return float(np.interp(min(length, FARTHEST_SHARE * half_width), s, gradient))

    return gradient_at(_inlet_length(problem, gradient_at))


def films_of(problem: NipProblem, gradient: float, half_width: float) -> dict[str, float]:
    """Return films and friction coefficients as a dict of fields of :class:`AirFilm`.

    Parameters
    ----------
    problem : NipProblem
        With air.
    gradient : float
        K [Pa/sqrt(m)].
    half_width : float
        a [m].

    Raises
    ------
    InvalidProblem
        If the pressure of the inlet exceeds 100 times the ambient pressure.
    """
    air, V, R, T = problem.air, problem.web_speed, problem.roll.radius, problem.hoop_tension
    T = max(T, 0.0)
    assert air is not None
    assert V is not None
    p_a, mean_pressure = air.ambient_pressure, problem.nip_load / (2 * half_width)
    compliance = _compliance(problem, _inlet_length(problem, lambda _: gradient))
    try:
        film_at_inlet = nip_film(gradient, compliance, V, air.viscosity, p_a)
    except ValueError as reason:
        text = f"of {V:.6g} m/s is out of range: in the inlet of the nip {reason}"
        raise InvalidProblem.at("web_speed", text) from None
    film_under_layer = film_at_inlet.film * p_a / (p_a + T / R)
    # without web tension only the nip limits the film
    foil = float(foil_film(R, V, T, air.viscosity)) if T > 0 else film_under_layer
    wound_in_film = min(film_under_layer, foil)
    film_in_nip = film_at_inlet.film * p_a / (p_a + mean_pressure)

    def reduced(friction: float, film: float) -> float:
        """Return a friction coefficient reduced by a film."""
        share = friction_share(film, air.roughness, air.full_friction, air.no_friction)
        return float(max(friction * share, min(MIN_FRICTION, friction)))

    friction = reduced(problem.roll_friction, film_in_nip)
    return {
        "foil_film": foil,
        "nip_film": film_under_layer,
        "film_in_nip": film_in_nip,
        "inlet_length": film_at_inlet.length,
        "film": float(escaped_film(wound_in_film, air.permeance, T, V)),
        "roll_friction": friction,
        "wrap_friction": reduced(problem.friction_on_wrap, wound_in_film),
        "friction_share": friction / problem.roll_friction,
    }


def air_film(problem: NipProblem, x: Array, pressure: Array, half_width: float) -> AirFilm:
    """Return the film of a nip; parameters as of :func:`inlet_gradient`."""
    gradient = inlet_gradient(problem, x, pressure, half_width)
    films = films_of(problem, gradient, half_width)
    thickness = _film_thickness(problem, pressure, half_width, films["film_in_nip"])
    return AirFilm(gradient=gradient, thickness=thickness, **films)


def film_of_state(problem: NipProblem, state: NipState) -> AirFilm:
    """Return the film for an iterate of the equations of the nip without air."""
    f = state.nips[0].fields
    nip = f.geometry.mesh.nip_nodes
    a = f.geometry.a
    return air_film(problem, a * f.geometry.mesh.nodes[nip], f.p_roll[nip], a)


def _film_thickness(
    problem: NipProblem, pressure: Array, half_width: float, film_in_nip: float
) -> Array:
    """Return m/(p_a + p), the film of a constant mass flow under the pressure p, (M,) [m].

    m is that of ``film_in_nip``, the film under the mean pressure of the nip.
    """
    assert problem.air is not None
    p_a = problem.air.ambient_pressure
    mass = film_in_nip * (p_a + problem.nip_load / (2 * half_width))
    return np.asarray(mass / (p_a + pressure))


def air_conditions(
    air: AirFilm, problem: NipProblem, x: Array, pressure: Array, half_width: float
) -> dict[str, float]:
    """Return the relative residuals of the equations of the film.

    ``air_inlet``: K, recomputed from the pressure.  ``air_film``: films and friction coefficients,
    recomputed from K and the half width; films that are and must be zero are satisfied.
    ``air_film_profile``: the film at every node.
    Parameters other than the film are those of :func:`air_film`.
    """
    gradient = inlet_gradient(problem, x, pressure, half_width)
    films = films_of(problem, air.gradient, half_width)
    profile = _film_thickness(problem, pressure, half_width, air.film_in_nip)
    return {
        "air_inlet": abs(air.gradient - gradient) / gradient,
        "air_film": largest(
            [
                abs(getattr(air, name) - value) / max(value, 1e-300)
                for name, value in films.items()
                if value or getattr(air, name)
            ]
        ),
        "air_film_profile": difference(air.thickness, profile) / max(air.film_in_nip, 1e-300),
    }


def air_warnings(problem: NipProblem, film: AirFilm, half_width: float) -> tuple[str, ...]:
    """Return warnings about the air film of a nip."""
    warnings: list[str] = []
    if film.inlet_length > LONG_INLET * half_width:
        warnings.append(
            "the inlet in which the air film forms is "
            f"{LENGTH.stored_text(film.inlet_length, '.3g')} long, "
            f"{film.inlet_length / half_width:.2g} of the half width; the model assumes that it is "
            "much shorter: the film changes the pressure of the nip"
        )
    air = problem.air
    assert air is not None
    if film.film_in_nip >= air.no_friction * air.roughness:
        warnings.append(
            f"the air film in the nip is {THICKNESS.stored_text(film.film_in_nip, '.3g')} thick, "
            f"more than {air.no_friction:.3g} roughnesses: web and roll do not touch, and the nip "
            "adds no tension"
        )
    return tuple(warnings)

"""Films of air between a web and the roll it runs on: closed forms, on numbers or arrays."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..quantities import Values, as_given
from .air_inlet import film_factor

if TYPE_CHECKING:
    from ..problems.air import Air

__all__ = [
    "NipFilm",
    "escaped_film",
    "foil_film",
    "friction_between",
    "friction_share",
    "nip_film",
]

Array = np.ndarray

# constant of y''' = (y - 1)/y^3, from y'' far upstream of the roll; a test integrates it
FOIL = 0.64304


def foil_film(
    radius: float | Array, speed: float | Array, tension: Values, viscosity: float
) -> Values:
    """Return the film under a web that runs onto a roll without a nip [m].

    h = 0.643 R (6 mu (V_web + V_roll)/T)^(2/3) with V_web = V_roll, for a wide, impermeable and
    perfectly flexible web (foil bearing; Knox and Sweeney 1971, cited by Ducotey and Good 1999).

    Parameters
    ----------
    radius, speed, tension : array_like
        R [m], V [m/s], T [N/m]; the film is inf for T = 0.
    viscosity : float
        mu [Pa s].
    """
    V, T = np.asarray(speed, dtype=float), np.asarray(tension, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        film = FOIL * np.asarray(radius) * (12 * viscosity * V / T) ** (2 / 3)
    return as_given(np.where(V == 0, 0.0, film))


class NipFilm(NamedTuple):
    """Air film that passes a nip."""

    film: float  # thickness at ambient pressure [m]
    length: float  # l, length of the inlet in which the film forms [m]
    beta: float  # ambient pressure relative to the pressure K sqrt(l) of the inlet [1]


def nip_film(
    gradient: float, compliance: float, speed: float, viscosity: float, ambient: float
) -> NipFilm:
    """Return the air film that passes a nip (:mod:`.air_inlet`), at ambient pressure.

    Parameters
    ----------
    gradient : float
        K [Pa/sqrt(m)]: without air the pressure is K sqrt(s) at the distance s from the inlet
        edge.
    compliance : float
        C [1/Pa], half the sum of the half-plane compliances of both surfaces; > 0.
    speed : float
        V of both surfaces [m/s].
    viscosity, ambient : float
        mu [Pa s], p_a [Pa].

    Raises
    ------
    ValueError
        If the pressure of the inlet is more than 100 times the ambient pressure.
    """
    if speed == 0:
        return NipFilm(0.0, 0.0, float("inf"))
    length = (12 * viscosity * speed / (compliance**2 * gradient**3)) ** 0.4
    beta = ambient / (gradient * length**0.5)
    return NipFilm(film_factor(beta) * compliance * gradient * length**1.5, length, beta)


def escaped_film(
    film: Values, permeance: float, tension: float | Array, speed: float | Array
) -> Values:
    """Return the thickness of a film after one revolution of the roll [m].

    Under the pressure T/R of a layer the air flows through the web at the speed k T/R.  During one
    revolution, 2 pi R/V, the film decreases by 2 pi k T/V.  Later flow through the layers above,
    and flow at the edges of the web, are neglected.

    Parameters
    ----------
    film, tension, speed : array_like
        h [m], T [N/m], V [m/s].
    permeance : float
        k, speed of the air through the web per pressure [m/(Pa s)].
    """
    h, V = np.asarray(film, dtype=float), np.asarray(speed, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        lost = 2 * pi * permeance * np.asarray(tension, dtype=float) / V
    left = np.maximum(h - np.where(V > 0, lost, 0.0), 0.0)
    return as_given(np.where(h > 0, left, 0.0))


def friction_share(film: Values, roughness: float, full: float, none: float) -> Values:
    """Return the fraction of the friction without air that remains with a film [1].

    It decreases linearly with the thickness of the film.

    Parameters
    ----------
    film : array_like
        h [m].
    roughness : float
        Root mean square of both surfaces together [m].
    full, none : float
        Thickness up to which friction is not reduced, and from which there is none, relative to
        the roughness.
    """
    relative = np.asarray(film, dtype=float) / roughness
    return as_given(np.clip((none - relative) / (none - full), 0.0, 1.0))


def friction_between(film: float, pressure: Values, air: Air) -> Values:
    """Return the fraction of the friction between layers that remains under a pressure [1].

    The film between the layers is compressed isothermally; no air escapes.

    Parameters
    ----------
    film : float
        At ambient pressure [m].
    pressure : array_like
        [Pa].
    air : Air
    """
    compressed = film * air.ambient_pressure / (air.ambient_pressure + np.asarray(pressure))
    share: Any = friction_share(compressed, air.roughness, air.full_friction, air.no_friction)
    return share

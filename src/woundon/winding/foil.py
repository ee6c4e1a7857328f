"""The air film of a winding without a nip: that of a foil bearing."""

from __future__ import annotations

import numpy as np

from ..nip.air_films import escaped_film, foil_film
from ..problems.winding import WindingProblem
from ..roll.density import mean_over_length

__all__ = ["mean_foil_film"]

RADII = 2049  # at which the film is averaged, in addition to the kinks of the tension


def mean_foil_film(problem: WindingProblem) -> float:
    """Return the film under a web that runs onto the roll, mean over the length of web [m].

    At the radius r it is 0.643 r (12 eta V/T)^(2/3) with T = T_in - m V^2, the tension that presses
    the web on the roll, less what escapes through the web in one revolution; see :func:`.foil_film`
    and :func:`.escaped_film`.  0 without air; inf where the centrifugal force lifts the web off.
    """
    if problem.air is None:
        return 0.0
    assert problem.web_speed is not None  # required with air
    r, speed = problem.radii(RADII), problem.web_speed
    T = np.maximum(problem.at("web_tension", r) - problem.centrifugal_tension, 0.0)
    film = foil_film(r, speed, T, problem.air.viscosity)
    film = escaped_film(film, problem.air.permeance, T, speed)
    return mean_over_length(r, film)

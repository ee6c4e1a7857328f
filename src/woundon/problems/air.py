"""Air that the web entrains."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Self

from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, length, pure, stress
from .air_law import AirBetween
from .description import Description
from .fields import Number, default
from .messages import quote
from .radial_laws import SolidLaw
from .roll import RollProblem

__all__ = ["Air", "with_film"]


class Air(Description):
    """The air around a winder, and the surfaces that it is caught between.

    Parameters
    ----------
    roughness : float
        Root mean square of both facing surfaces of the web together, sqrt(s1^2 + s2^2) [m].
    viscosity : float
        Of the air [Pa s].
    ambient_pressure : float
        [Pa].
    permeance : float
        Speed of the air through the web per pressure across it [m/(Pa s)]: 0 for film, of paper as
        measured.
    full_friction, no_friction : float
        Film up to which friction is that without air, and from which there is none, in
        roughnesses; linear between.
    """

    roughness: Annotated[
        Number,
        length("s", "rms roughness of both surfaces together", "um", (0.05e-6, 10e-6)),
        Field(gt=0, le=1e-3),
    ]
    viscosity: Annotated[
        Number,
        Quantity("mu_a", "Pa*s", "viscosity of the air", typical=(1.7e-5, 2e-5)),
        Field(ge=1e-7, le=1e-2),
    ] = default(1.81e-5)
    ambient_pressure: Annotated[
        Number, stress("p_a", "ambient pressure", "kPa", (80e3, 105e3)), Field(ge=1e3, le=1e7)
    ] = default(101325.0)
    permeance: Annotated[
        Number,
        Quantity("k_a", "m/Pa/s", "permeance of the web", typical=(0.0, 1e-5)),
        Field(ge=0, le=1),
    ] = default(0.0)
    full_friction: Annotated[
        Number,
        pure("h/s full", "air film up to which friction is unreduced, in roughnesses", (0.5, 2.0)),
        Field(ge=0, le=100),
    ] = default(1.0)
    no_friction: Annotated[
        Number,
        pure("h/s none", "air film from which on friction is zero, in roughnesses", (2.0, 4.0)),
        Field(gt=0, le=100),
    ] = default(3.0)

    @model_validator(mode="after")
    def _falls(self) -> Self:
        if self.no_friction <= self.full_friction:
            raise InvalidProblem.at(
                "no_friction",
                f"{quote(self.no_friction)} is out of range; must be > full_friction = "
                f"{self.full_friction:.6g} [1]",
            )
        return self

    def too_rough(self, thickness: float) -> Iterator[tuple[str, str]]:
        """Yield the field at fault and what to say where a web is rougher than thick [m]."""
        if self.roughness >= thickness:
            yield (
                "roughness",
                f"{quote(self.roughness)} is out of range; must be < the web's thickness, "
                f"{thickness:.6g} [m]",
            )


def with_film(roll: RollProblem, film: float, air: Air) -> RollProblem:
    """Return a roll whose laps hold a film of air between them; see :class:`.AirBetween`.

    Parameters
    ----------
    roll : RollProblem
        Without air.
    film : float
        At ambient pressure [m].
    air : Air

    Raises
    ------
    InvalidProblem
        If the roll's stack has air already.
    """
    if film == 0:
        return roll
    stack, web = roll.stack, roll.web_thickness
    if not isinstance(stack.radial, SolidLaw):
        raise InvalidProblem.at("stack.radial", "has air already; must be without")
    law = AirBetween(
        law=stack.radial, film=film, web_thickness=web, ambient_pressure=air.ambient_pressure
    )
    solid = web / (web + film)
    return roll.replace(
        stack=stack.replace(radial=law, tangential=stack.tangential * solid),
        web_thickness=web + film,
        density=None if roll.density is None else roll.density * solid,
    )

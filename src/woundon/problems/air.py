"""Entrained air."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Self

from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, length, pure
from .air_law import AirBetween, AmbientPressure
from .description import Description
from .fields import Number, default
from .messages import quote
from .radial_laws import SolidLaw
from .roll import RollProblem
from .stack import Stack

__all__ = ["Air", "stack_with_film", "with_film"]


class Air(Description):
    """Entrained air and the surfaces of the web that enclose it.

    Parameters
    ----------
    roughness : float
        Combined root-mean-square roughness of the facing surfaces, sqrt(s1^2 + s2^2) [m].
    viscosity : float
        Viscosity of the air [Pa s].
    ambient_pressure : float
        [Pa].
    permeance : float
        Air speed through the web per pressure difference [m/(Pa s)]; 0 for film, measured for
        paper.
    full_friction, no_friction : float
        Film thickness relative to the roughness up to which friction is not reduced, and above
        which it is zero; linear in between.

    Examples
    --------
    >>> import woundon as wo
    >>> air = wo.Air(roughness="3 um")
    >>> nip = wo.NipProblem.example().replace(air=air, web_speed="1000 m/min")
    >>> nip.air.no_friction
    3.0
    """

    roughness: Annotated[
        Number,
        length("s", "combined rms roughness of the facing surfaces", "um", (0.05e-6, 10e-6)),
        Field(gt=0, le=1e-3),
    ]
    viscosity: Annotated[
        Number,
        Quantity("mu_a", "Pa*s", "viscosity of the air", typical=(1.7e-5, 2e-5)),
        Field(ge=1e-7, le=1e-2),
    ] = default(1.81e-5)
    ambient_pressure: AmbientPressure = default(101325.0)
    permeance: Annotated[
        Number,
        Quantity("k_a", "m/Pa/s", "permeance of the web", typical=(0.0, 1e-5)),
        Field(ge=0, le=1),
    ] = default(0.0)
    full_friction: Annotated[
        Number,
        pure(
            "h/s full", "largest air film with full friction, relative to the roughness", (0.5, 2.0)
        ),
        Field(ge=0, le=100),
    ] = default(1.0)
    no_friction: Annotated[
        Number,
        pure(
            "h/s none", "smallest air film without friction, relative to the roughness", (2.0, 4.0)
        ),
        Field(gt=0, le=100),
    ] = default(3.0)

    @model_validator(mode="after")
    def _check_friction_law(self) -> Self:
        """Reject a friction law that does not decrease with the film."""
        if self.no_friction <= self.full_friction:
            raise InvalidProblem.at(
                "no_friction",
                f"{quote(self.no_friction)} is out of range; must be > full_friction = "
                f"{self.full_friction:.6g} [1]",
            )
        return self

    def too_rough(self, thickness: float) -> Iterator[tuple[str, str]]:
        """Yield (field, message) if the roughness is not less than the web thickness [m]."""
        if self.roughness >= thickness:
            yield (
                "roughness",
                f"{quote(self.roughness)} is out of range; must be < the web's thickness, "
                f"{thickness:.6g} [m]",
            )


def with_film(roll: RollProblem, film: float, air: Air) -> RollProblem:
    """Return a roll with an air film between its layers; see :class:`.AirBetween`.

    A layer is thicker by the film, and its density smaller, so that its mass is the same.

    Parameters
    ----------
    roll : RollProblem
        Without air.
    film : float
        Film thickness at ambient pressure [m].
    air : Air

    Raises
    ------
    InvalidProblem
        If the stack already contains air.
    """
    if film == 0:
        return roll
    stack, web = roll.stack, roll.web_thickness
    solid = web / (web + film)
    return roll.replace(
        stack=stack_with_film(stack, film, web, air),
        web_thickness=web + film,
        density=None if roll.density is None else roll.density * solid,
    )


def stack_with_film(stack: Stack, film: float, web_thickness: float, air: Air) -> Stack:
    """Return a stack without air with a film between its layers; parameters as of with_film.

    The film carries no tension: E_t is smaller by the share of the web in the thickness.
    """
    if not isinstance(stack.radial, SolidLaw):
        raise InvalidProblem.at("stack.radial", "already contains air; must be a law without air")
    law = AirBetween(
        law=stack.radial,
        film=film,
        web_thickness=web_thickness,
        ambient_pressure=air.ambient_pressure,
    )
    solid = web_thickness / (web_thickness + film)
    return stack.replace(radial=law, tangential=stack.tangential * solid)

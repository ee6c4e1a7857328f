"""Moments of inertia of the bodies that the drives of a winder accelerate."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..quantities import Quantity
from .description import Description
from .fields import Number, default

__all__ = ["Inertia"]


def _inertia(symbol: str, body: str) -> Quantity:
    """Return the quantity of a moment of inertia; ``body`` is what has it."""
    return Quantity(symbol, "kg*m^2", f"moment of inertia of {body}", typical=(0.0, 200.0))


class Inertia(Description):
    """Moments of inertia of core and drums, for the torque of their drives.

    That of the web on the core follows from its density.

    Parameters
    ----------
    core : float
        Of core, shaft and chucks, with the rotor of their drive [kg m^2].
    drum : float
        Of the winding drum, of a two-drum winder the rear drum, with its drive [kg m^2].
    front_drum, rider : float
        Of front drum and rider roll of a two-drum winder [kg m^2].

    Raises
    ------
    InvalidProblem
        For a value out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> inertia = wo.Inertia(core="3 kg*m^2", drum="60 kg*m^2")
    >>> inertia.core, inertia.rider
    (3.0, 0.0)
    """

    core: Annotated[Number, _inertia("J_c", "core and shaft"), Field(ge=0, le=1e7)] = default(0.0)
    drum: Annotated[Number, _inertia("J_1", "the winding drum"), Field(ge=0, le=1e7)] = default(0.0)
    front_drum: Annotated[Number, _inertia("J_2", "the front drum"), Field(ge=0, le=1e7)] = default(
        0.0
    )
    rider: Annotated[Number, _inertia("J_3", "the rider roll"), Field(ge=0, le=1e7)] = default(0.0)

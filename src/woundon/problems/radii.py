"""Radii at which a user asks for values of a roll."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InvalidProblem
from .messages import quote
from .permitted import is_within

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["radii_on_roll"]


def radii_on_roll(
    radius: ArrayLike, core: float, surface: float, name: str = "radius"
) -> np.ndarray:
    """Return radii [m] as an array; those outside the roll by a rounding error are set to its ends.

    A single number gives an array without dimensions.

    Parameters
    ----------
    radius : array_like
    core, surface : float
        Radii of both ends of the roll [m].
    name : str
        Of the radius in error messages.

    Raises
    ------
    InvalidProblem
        For a radius outside the roll.
    """
    must = f"must be >= {core:.6g} and <= {surface:.6g} [m], on the roll"
    try:
        r = np.asarray(radius, dtype=float)
        if radius is None:  # nan to NumPy
            raise TypeError
    except (TypeError, ValueError):
        raise InvalidProblem.at(name, f"{quote(radius)} is not a number; {must}") from None
    outside = r[~is_within(r, core, surface)]
    if outside.size:
        wrong = quote(float(outside.flat[0]))
        raise InvalidProblem.at(name, f"{wrong} is out of range; {must}")
    return np.clip(r, core, surface)

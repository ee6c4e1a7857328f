"""Bending and crown of the drums and of the core across the width of the web."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, length
from .description import Description
from .fields import (
    Number,
    OptionalNumber,
    OptionalNumbers,
    check_equal_lengths,
    check_rising,
    check_within,
    default,
)
from .inputs import NotANumber, real_number
from .messages import quote
from .paths import field_or_none
from .problem import Problem
from .thickness_profile import means_between

__all__ = ["BENDING", "Bending", "DrumBending", "bends", "faults_of_bending", "too_soft"]

Array = np.ndarray
# Fields of a winding.
BENDING = ("drum_bending", "core_bending", "winder.front_bending", "winder.rider_bending")
MOST_BENT = 0.1  # deflection [m] by a uniform nip load, the largest crown; beams bend far less
ROUNDED = 1e-9  # of the width, by which a table of a crown may miss the edges of the web


class Bending(Description):
    """A beam across the web on two bearings: the core in its chucks, with the roll on it.

    Parameters
    ----------
    flexural_rigidity : float
        EI, Young's modulus times second moment of area [N m^2], > 0.
    shear_rigidity : float, optional
        kappa G A, shear modulus times area and shear coefficient (0.5 of a thin tube) [N]; by
        default the beam does not yield to shear.
    bearing_distance : float
        From each edge of the web to the bearing [m].

    Raises
    ------
    InvalidProblem
        For a value out of range.

    Examples
    --------
    A steel tube of 0.3 m in diameter and 20 mm in thickness, its bearings 0.2 m beyond the web:

    >>> import woundon as wo
    >>> drum = wo.Bending(flexural_rigidity="36e6 N*m^2", bearing_distance="0.2 m")
    >>> f"{1e6 * drum.even_crown(3000.0, width=2.4):.0f} um"
    '50 um'
    """

    flexural_rigidity: Annotated[
        Number,
        Quantity("E I", "N*m^2", "flexural rigidity across the web", typical=(1e5, 1e9)),
        Field(gt=0, le=1e30),
    ] = Field(...)
    shear_rigidity: Annotated[
        OptionalNumber,
        Quantity("kappa G A", "N", "shear rigidity across the web", typical=(1e7, 1e10)),
        Field(gt=0, le=1e30),
    ] = default(None)
    bearing_distance: Annotated[
        Number,
        length("b_b", "distance of the bearings from the edges of the web", typical=(0.0, 1.0)),
        Field(ge=0, le=10),
    ] = default(0.0)

    def even_crown(self, nip_load: float, width: float) -> float:
        """Return the crown that makes the nip load of an even web uniform [m].

        It is the deflection in the middle of the web above that at its edges, under a uniform load
        P (Young and Budynas, Roark's Formulas, table 8.1, case 2e, for bearings at the edges),

            P W^3 (b/16 + 5 W/384)/EI + P W^2/(8 kappa G A).

        Parameters
        ----------
        nip_load : float
            P [N/m].
        width : float
            W [m].

        Raises
        ------
        InvalidProblem
            For what is no finite number >= 0.
        """
        for name, value, unit in (("nip_load", nip_load, "N/m"), ("width", width, "m")):
            try:
                is_valid = 0 <= real_number(value) < inf
            except NotANumber:
                is_valid = False
            if not is_valid:
                text = f"{quote(value)} is out of place; must be a finite number >= 0 [{unit}]"
                raise InvalidProblem.at(name, text)
        bent, sheared = _deflections_of_unit_rigidity(self.bearing_distance, nip_load, width)
        if self.shear_rigidity is None:
            return float(bent / self.flexural_rigidity)
        return float(bent / self.flexural_rigidity + sheared / self.shear_rigidity)


class DrumBending(Bending):
    """A drum that bends under its nip load, and its crown.

    Parameters
    ----------
    flexural_rigidity, shear_rigidity, bearing_distance
        As of :class:`Bending`.
    crown : float
        Height of the drum's surface in the middle of the web over that at its edges [m], between
        them a parabola; < 0: concave.
    crown_position, crown_height : sequences of float, optional
        A table in place of ``crown``: height of the surface [m] at positions across the web [m], as
        those of the thickness profile, which they cover; linear in between.  Only differences of
        the heights matter.

    Raises
    ------
    InvalidProblem
        For a value out of range, and for a table together with ``crown``.

    Examples
    --------
    >>> import woundon as wo
    >>> drum = wo.DrumBending(flexural_rigidity="2e6 N*m^2", crown="0.2 mm")
    >>> drum.heights([0.0, 0.6, 1.2], edges=(0.0, 2.4)).round(6).tolist()
    [0.0, 0.00015, 0.0002]
    """

    crown: Annotated[
        Number,
        length("c", "crown: height in the middle of the web over its edges", "um", (0.0, 1e-3)),
        Field(ge=-MOST_BENT, le=MOST_BENT),
    ] = default(0.0)
    crown_position: Annotated[
        OptionalNumbers,
        length("y_c", "positions across the web of the heights of the crown"),
        Field(min_length=2, max_length=10_000),
    ] = default(None)
    crown_height: Annotated[
        OptionalNumbers,
        length("c_y", "height of the drum's surface at these positions", "um"),
        Field(min_length=2, max_length=10_000),
    ] = default(None)

    @model_validator(mode="after")
    def _check_crown(self) -> Self:
        """Reject a table that is incomplete, does not rise, or contradicts the crown."""
        if (self.crown_position is None) != (self.crown_height is None):
            missing = "crown_height" if self.crown_height is None else "crown_position"
            raise InvalidProblem.at(missing, "missing; must be given [m] with the other list")
        if self.crown_position is None or self.crown_height is None:
            return self
        if self.crown:
            text = f"{quote(self.crown)} is given together with crown_height; must be "
            raise InvalidProblem.at("crown", f"{text}one of the two")
        check_equal_lengths(self, "crown_position", "crown_height")
        check_rising(self, "crown_position")
        check_within(self, "crown_height", -MOST_BENT, MOST_BENT)
        return self

    def heights(self, places: Array, edges: tuple[float, float]) -> Array:
        """Return the height of the surface at places across the web [m].

        Parameters
        ----------
        places : (n,) array
            [m].
        edges : (float, float)
            Positions of the edges of the web [m].

        Returns
        -------
        (n,) array
        """
        y = np.asarray(places, dtype=float)
        if self.crown_position is not None and self.crown_height is not None:
            return np.interp(y, self.crown_position, self.crown_height)
        across = (y - edges[0]) / (edges[1] - edges[0])
        return np.asarray(4 * self.crown * across * (1 - across))

    def mean_heights(self, ends: Array) -> Array:
        """Return the mean height of the surface in lanes between ``ends`` (L + 1,) [m], (L,) [m].

        The first and the last of the ends are the edges of the web.
        """
        if self.crown_position is not None and self.crown_height is not None:
            return means_between(self.crown_position, self.crown_height, ends)
        across = (ends - ends[0]) / (ends[-1] - ends[0])
        integral = 2 * across**2 - 4 * across**3 / 3
        return np.asarray(self.crown * np.diff(integral) / np.diff(across))


def _deflections_of_unit_rigidity(
    bearing_distance: float, nip_load: float, width: float
) -> tuple[float, float]:
    """Return the deflections (:meth:`.Bending.even_crown`) of E I = 1 N m^2, of kappa G A = 1 N."""
    bent = width**3 * (bearing_distance / 16 + 5 * width / 384)
    return nip_load * bent, nip_load * width**2 / 8


def too_soft(beam: Bending, nip_load: float, width: float) -> Iterator[tuple[str, str]]:
    """Yield (field, message) for a rigidity too small for a nip load [N/m] on a width [m]."""
    deflections = _deflections_of_unit_rigidity(beam.bearing_distance, nip_load, width)
    rigidities = ("flexural_rigidity", "[N*m^2]"), ("shear_rigidity", "[N]")
    for (name, unit), deflection in zip(rigidities, deflections, strict=True):
        rigidity, least = getattr(beam, name), deflection / MOST_BENT
        if rigidity is not None and rigidity < least:
            text = f"{quote(rigidity)} is out of range; must be >= {least:.3g} {unit}, or"
            bends_it = f"a uniform nip load of {nip_load:.6g} [N/m] bends it by more than"
            yield name, f"{text} {bends_it} {MOST_BENT:g} [m]"


def bends(problem: Problem) -> bool:
    """Return whether a drum or the core of a problem is a beam."""
    return any(field_or_none(problem, name) is not None for name in BENDING)


def faults_of_bending(problem: Any) -> Iterator[tuple[str, str]]:
    """Yield (field, message) for beams that do not fit to the rest of a winding."""
    profile, winder = problem.thickness_profile, problem.winder
    for name in BENDING:
        bending = field_or_none(problem, name)
        if bending is None:
            continue
        if profile is None:
            text = "is given without thickness_profile; must be left out"
            yield name, f"{text}, or the profile be given, which may be even"
            continue
        if problem.tension_law != "nip":
            yield name, "needs tension_law = 'nip', which computes the stiffness of the nip"
        if not problem.has_nip:
            yield name, "is given with nip_load = 0; must be left out without a nip"
        if name == "core_bending" and isinstance(bending, DrumBending):
            yield name, "DrumBending is out of place; must be Bending: a core has no crown"
        if name == "core_bending" and winder is not None:
            text = "is given together with winder; must be left out"
            yield name, f"{text}: the roll lies on the drums"
        if name == "winder.rider_bending" and winder is not None and winder.rider is None:
            yield name, "is given without winder.rider; must be left out"
        positions = getattr(bending, "crown_position", None)
        if positions is not None:
            low, high = profile.position[0], profile.position[-1]
            if positions[0] > low + ROUNDED * profile.width or (
                positions[-1] < high - ROUNDED * profile.width
            ):
                text = f"covers {positions[0]:.6g} to {positions[-1]:.6g} [m]; must cover "
                yield (
                    f"{name}.crown_position",
                    f"{text}thickness_profile, {low:.6g} to {high:.6g} [m]",
                )

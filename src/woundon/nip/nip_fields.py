"""The fields of the result of a winding nip."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

import numpy as np

from ..contact.refinement import Refinement
from ..errors import InvalidProblem
from ..problems.messages import quote
from ..problems.nip import NipProblem
from ..quantities import Quantity, length, line_load, pure, share, strain, stress
from ..results import Result, Zone
from .air_films import friction_between
from .contact_outputs import ContactOutputs
from .entrained_air import AirFilm

__all__ = ["NipFields"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NipFields(ContactOutputs, Result):
    """The fields of a :class:`.NipResult`, which describes them, for the functions of its outputs.

    The result imports these functions, so that they cannot name its class.
    """

    problem: NipProblem
    roll_wound_on_tension: Annotated[
        float, line_load("WOT_r", "wound-on tension of a closed layer on the roll")
    ]
    half_width: Annotated[float, length("a", "half-width of the nip")]
    approach: Annotated[
        float, length("delta", "centre approach (nip indentation) of roll and drum")
    ]
    offset: Annotated[
        float, length("Delta", "offset of the line of centres from the contact centre")
    ]
    drum_creepage: Annotated[float, strain("xi-", "creepage between web and drum")]
    leading_roll: Annotated[
        float, share("s_l+", "slip length at the roll's leading edge / nip width")
    ]
    trailing_roll: Annotated[
        float, share("s_t+", "slip length at the roll's trailing edge / nip width")
    ]
    dual: Annotated[float, share("s_d", "length of simultaneous slip on roll and drum / nip width")]
    x: Annotated[Array, length("x", "position along the web, nip: [-a, a]")]
    slip_x: Annotated[Array, length("x_v", "positions at which slip is evaluated")]
    drum_pressure: Annotated[Array, stress("p-", "pressure of the web on the drum")]
    roll_pressure: Annotated[Array, stress("p+", "pressure of the web on the roll")]
    roll_traction: Annotated[Array, stress("q+", "traction of the web on the roll")]
    drum_traction: Annotated[Array, stress("q-", "traction of the web on the drum")]
    roll_slip: Annotated[Array, strain("v+", "slip of the web against the roll, > 0: web faster")]
    drum_slip: Annotated[Array, strain("v-", "slip of the web against the drum, > 0: web faster")]
    roll_zone: Annotated[
        Array, pure("z+", "zone at the roll: 0 stick; slip: 1 web faster, -1 web slower"), Zone
    ]
    drum_zone: Annotated[
        Array, pure("z-", "zone at the drum: 0 stick; slip: 1 web faster, -1 web slower"), Zone
    ]
    tension: Annotated[Array, line_load("T", "web tension along the nip")]
    roll_strain: Annotated[Array, strain("eps1", "strain of the roll's surface along the web")]
    hoop_pressure: Annotated[Array, stress("p_h", "hoop pressure, web tension times curvature")] = (
        field(default_factory=lambda: np.zeros(0))
    )
    curvature: Annotated[
        Array, Quantity("kappa", "1/m", "curvature of the web, > 0: centre in the roll")
    ] = field(default_factory=lambda: np.zeros(0))
    next_positions: Annotated[
        Array, length("x_k", "centres of the further nips along the roll, from the first one")
    ] = field(default_factory=lambda: np.zeros(0))
    next_half_widths: Annotated[Array, length("a_k", "half-widths of the further nips")] = field(
        default_factory=lambda: np.zeros(0)
    )
    next_offsets: Annotated[
        Array, length("Delta_k", "offsets of the line of centres of the further nips")
    ] = field(default_factory=lambda: np.zeros(0))
    next_creepages: Annotated[
        Array, strain("xi_k-", "creepages between the web and the further drums")
    ] = field(default_factory=lambda: np.zeros(0))
    air: AirFilm | None = None
    iterations: Annotated[int, pure("n_it", "number of Newton iterations")] = 0
    series_terms: Annotated[int, pure("n_s", "number of Fourier terms")] = 0
    series_error: Annotated[float, pure("e_s", "estimated truncation error of the series")] = 0.0
    refinement: Refinement | None = field(
        default=None, repr=False, compare=False, metadata={"saved": False}
    )

    @cached_property
    def in_nip(self) -> slice:
        """The nodes of the nip: those between -a and a, edges included."""
        distances = np.abs(self.x - [[-self.half_width], [self.half_width]])
        nearest = distances.argmin(axis=1)
        if np.isnan(distances[[0, 1], nearest]).any():  # damaged arrays: use the valid nodes
            nearest = np.nanargmin(distances, axis=1)
        first, last = nearest.tolist()
        return slice(first, last + 1)

    @property
    def without_air(self) -> NipProblem:
        """The nip without air, with the friction coefficients that the film leaves."""
        if self.air is None:
            return self.problem
        return self.problem.without_air(self.air.roll_friction, self.air.wrap_friction)

    def layer_friction(self, pressure: float | Array) -> float | Array:
        """Return the friction between layers of the roll under a pressure P, an array of its shape.

        The air between the layers is compressed, h p_a/(p_a + P); none escapes.  Without air:
        ``roll_friction``.

        Parameters
        ----------
        pressure : array_like
            P [Pa], >= 0.

        Raises
        ------
        InvalidProblem
            For anything else.
        """
        try:
            P = np.asarray(pressure, dtype=float)
        except (TypeError, ValueError):
            text = f"{quote(pressure)} is out of place; must be numbers >= 0 [Pa]"
            raise InvalidProblem.at("pressure", text) from None
        if not (P >= 0).all():
            text = f"{quote(float(np.min(P)))} is out of range; must be >= 0 [Pa]"
            raise InvalidProblem.at("pressure", text)
        air, dry_friction = self.problem.air, self.problem.roll_friction
        if air is None or self.air is None:
            return dry_friction * np.ones(P.shape)[()]
        ratio = friction_between(self.air.film, pressure, air)
        return dry_friction * ratio

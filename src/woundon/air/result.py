"""A winding nip with the air that its web brings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, ClassVar

import numpy as np

from .. import kinds
from ..errors import InvalidProblem
from ..nip.result import WrappedNipResult
from ..problems.air import AirNipProblem, with_film
from ..problems.fields import shown
from ..problems.nip import WrappedNipProblem
from ..problems.roll import WoundRollProblem
from ..quantities import Quantity, length, line_load, pure, strain, stress
from ..results import Residuals, Result
from .certificate import friction_between

__all__ = ["AirNipResult"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class AirNipResult(Result):
    """The film of air in a winding nip, the friction that it leaves, and what the nip then does.

    Attributes
    ----------
    problem : AirNipProblem
    x, pressure, air_film : (N,) arrays
        Places in the nip [m], the pressure between web and roll [Pa], and the film under it [m].
    foil_film : float
        What the web would carry in without a nip [m].
    nip_film : float
        What the nip lets through, under the pressure of the lap laid, T_in/R [m].
    film : float
        What is left between the laps when the first is full: the less of the two, less what went
        through the web [m].
    film_in_nip : float
        Under the mean pressure of the nip [m].
    roll_friction, wrap_friction : float
        What the films leave in the nip and behind it [1].
    edge : float
        K [Pa/sqrt(m)]: the pressure is K sqrt(s) where the inlet ends, s behind the edge.
    inlet_length : float
        Over which the film is made [m].
    wound_on_tension, nip_induced_tension, half_width, peak_pressure : float
        Of the nip with these frictions; its other outputs by ``woundon.solve(result.nip)``.
    nip_residual : float
        The largest violation of a law of that nip.
    solved : WrappedNipResult, optional
        That nip; none after loading.
    """

    MAIN: ClassVar[tuple[str, ...]] = ("wound_on_tension", "film", "friction_share")
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({
        "roll_traction": "it is the nip's: woundon.solve(result.nip).roll_traction",
        "web_tension": "it is the nip's: woundon.solve(result.nip).web_tension",
    })  # fmt: skip
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset()

    problem: AirNipProblem
    x: Annotated[Array, length("x", "along the web, from the centre of the nip")]
    pressure: Annotated[Array, stress("p", "pressure between web and roll in the nip")]
    air_film: Annotated[Array, length("h_a", "film of air in the nip", "um")]
    foil_film: Annotated[float, length("h_foil", "film without a nip, or the limit", "um")]
    nip_film: Annotated[float, length("h_nip", "film that the nip lets through", "um")]
    film: Annotated[float, length("h", "film left between the laps", "um")]
    film_in_nip: Annotated[float, length("h_in", "film in the nip, under its mean pressure", "um")]
    roll_friction: Annotated[float, pure("mu+ eff", "friction that the film leaves in the nip")]
    wrap_friction: Annotated[float, pure("mu_w+ eff", "friction that it leaves behind the nip")]
    edge: Annotated[float, Quantity("K", "Pa/m**0.5", "rise of the pressure behind the inlet edge")]
    inlet_length: Annotated[float, length("l", "inlet over which the film is made", "um")]
    wound_on_tension: Annotated[float, line_load("WOT", "wound-on tension, far behind the nip")]
    nip_induced_tension: Annotated[float, line_load("NIT", "nip-induced tension")]
    half_width: Annotated[float, length("a", "half-width of the nip")]
    peak_pressure: Annotated[float, stress("p_max", "largest pressure")]
    nip_residual: Annotated[float, pure("r_n", "largest violation of a law of the nip")]
    solved: WrappedNipResult | None = field(
        default=None, repr=False, compare=False, metadata={"saved": False}
    )

    @property
    def friction_share(self) -> Annotated[float, strain("mu/mu0", "share of the friction left")]:
        """How much of the friction in the nip the film leaves [1]."""
        return self.roll_friction / self.problem.roll_friction

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        return int(self.x.size)

    @property
    def passed(self) -> float:
        """Film times absolute pressure that passes the nip [N/m]."""
        problem = self.problem
        p_a = problem.air.ambient_pressure
        return self.film_in_nip * (p_a + problem.nip_load / (2 * self.half_width))

    @property
    def nip(self) -> WrappedNipProblem:
        """The nip with the friction that the film leaves."""
        return self.problem.without_air(self.roll_friction, self.wrap_friction)

    def layer_friction(self, pressure: float | Array) -> float | Array:
        """Return the friction between laps of the roll under a pressure P, an array of its shape.

        The air that the laps hold is pressed together, h p_a/(p_a + P): none leaves.

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
            text = f"{shown(pressure)} is out of place; must be numbers >= 0 [Pa]"
            raise InvalidProblem.at("pressure", text) from None
        if not (P >= 0).all():
            text = f"{shown(float(np.min(P)))} is out of range; must be >= 0 [Pa]"
            raise InvalidProblem.at("pressure", text)
        return self.problem.roll_friction * friction_between(self.film, pressure, self.problem.air)

    def wound(self, roll: WoundRollProblem) -> WoundRollProblem:
        """Return a roll whose laps keep the film between them; see :class:`~woundon.AirBetween`.

        Parameters
        ----------
        roll : WoundRollProblem
            Of the same web, without air.

        Raises
        ------
        InvalidProblem
            If the web's thickness is not the nip's, or the roll's stack has air already.
        """
        web = roll.web_thickness
        if abs(web / self.problem.web.thickness - 1) > 1e-9:
            raise InvalidProblem.at(
                "web_thickness",
                f"{shown(web)} is out of range; must be the nip's, "
                f"{self.problem.web.thickness:.6g} [m]",
            )
        return with_film(roll, self.film, self.problem.air)

    def certified(self) -> Residuals:
        """Return the certificate, computed again from the problem and the fields of the result.

        A result that was loaded solves its nip again, on as many nodes.
        """
        from .certificate import certificate

        if self.solved is not None:
            return certificate(self, self.solved, same_mesh=True)
        solve = kinds.fetch("woundon.nip.solve:solve_nip")
        return certificate(self, solve(self.nip, nodes=self.nodes), same_mesh=False)

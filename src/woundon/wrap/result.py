"""The state of a nip with its wraps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, ClassVar

import numpy as np

from .. import kinds
from ..nip.result import NipResult, WindingNipResult
from ..problems.nip import WrappedNipProblem
from ..quantities import Quantity, angle, line_load, strain, stress
from ..results import Residuals, Zone

__all__ = ["WrappedNipResult"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WrappedNipResult(WindingNipResult):
    """The state of a winding nip with the web wrapped on the roll behind it and the drum before it.

    The arrays run along the whole web that touches anything: from the drum's arc, if any, through
    the nip (``in_nip`` tells which nodes) to the far side of the roll.

    Attributes
    ----------
    problem : WrappedNipProblem
    roll_pressure, hoop_pressure : (N,) arrays
        p+ on the roll, and T kappa, the web's weight on what it lies on [Pa]; ``pressure`` is p-.
    curvature : (N,) array
        kappa of the web, centre on the roll's side > 0 [1/m].
    roll_strain : (N,) array
        eps_theta1 of the roll's surface where the slips are taken; nan before the nip.
    extrapolation, extrapolation_behind, extrapolation_of_nip : float
        What ``wound_on_tension``, ``tension_behind_nip`` and ``nip_induced_tension`` have beyond
        what ``web_tension`` tells: zones end between nodes, and what where they do is worth to
        these is known [N/m].

    The others as of :class:`~woundon.nip.result.WindingNipResult`; slips are nan where the web does
    not touch the body.
    """

    MAIN: ClassVar[tuple[str, ...]] = ("wound_on_tension",)
    DIFFERENTIATED: ClassVar[str] = "woundon.wrap.sensitivity:wrapped_sensitivity"
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({
        "nip": "take the nodes in_nip of the arrays, or confined() for the nip alone",
        "rig_tension": "the wrapped web's wound_on_tension is what a load cell at roll_wrap reads",
        "wound_on_tension_estimate": "the wrapped web's wound_on_tension is solved, not estimated",
    })  # fmt: skip
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset(
        {"roll_slip", "drum_slip", "roll_strain", "rolling_resistance"}
    )
    ESTIMATES: ClassVar[frozenset[str]] = WindingNipResult.ESTIMATES | {
        "extrapolation", "extrapolation_behind", "extrapolation_of_nip",
    }  # fmt: skip

    problem: WrappedNipProblem
    roll_pressure: Annotated[Array, stress("p+", "pressure of the web on the roll")]
    hoop_pressure: Annotated[Array, stress("p_h", "hoop pressure, web tension times curvature")]
    curvature: Annotated[
        Array, Quantity("kappa", "1/m", "curvature of the web, > 0: centre in the roll")
    ]
    roll_strain: Annotated[Array, strain("eps1", "strain of the roll's surface along the web")]
    extrapolation: Annotated[
        float, line_load("dWOT", "part of WOT that extrapolates the web tension")
    ] = 0.0
    extrapolation_behind: Annotated[
        float, line_load("dT_out", "part of T_out that extrapolates the web tension")
    ] = 0.0
    extrapolation_of_nip: Annotated[
        float, line_load("dNIT", "part of NIT that extrapolates the web tension")
    ] = 0.0

    @property
    def wound_on_tension(
        self,
    ) -> Annotated[float, line_load("WOT", "wound-on tension, far behind the nip")]:
        """WOT, the tension at the far side of the roll [N/m]: what the roll keeps."""
        return float(self.web_tension[-1]) + self.extrapolation

    @property
    def wound_on_tension_error(
        self,
    ) -> Annotated[
        float, line_load("WOT error", "estimated discretisation error of the wound-on tension")
    ]:
        """Its estimated discretisation error [N/m]; nan where only one grid was solved."""
        return self.errors.get("wound_on_tension", float("nan"))

    @property
    def tension_before_nip(
        self,
    ) -> Annotated[float, line_load("T_n", "web tension at the leading edge of the nip")]:
        """T at x = -a [N/m]."""
        beyond = self.extrapolation_behind - self.extrapolation_of_nip
        return float(self.web_tension[self.in_nip.start]) + beyond

    @property
    def tension_behind_nip(
        self,
    ) -> Annotated[float, line_load("T_out", "web tension at the trailing edge of the nip")]:
        """T_out at x = a [N/m]."""
        return float(self.web_tension[self.in_nip.stop - 1]) + self.extrapolation_behind

    @property
    def nip_induced_tension(
        self,
    ) -> Annotated[float, line_load("NIT", "nip-induced tension, of the nip between its edges")]:
        """NIT = Q+ + Q- of the nip alone, T(a) - T(-a) [N/m]."""
        return self.tension_behind_nip - self.tension_before_nip

    @property
    def roll_wrap_traction(
        self,
    ) -> Annotated[float, line_load("Q_w+", "traction on the roll behind the nip, integrated")]:
        """Q_w+ [N/m]."""
        return self.wound_on_tension - self.tension_behind_nip

    @property
    def drum_wrap_traction(
        self,
    ) -> Annotated[float, line_load("Q_w-", "traction on the drum before the nip, integrated")]:
        """Q_w- [N/m]."""
        return self.tension_before_nip - float(self.web_tension[0])

    @property
    def slip_angle(
        self,
    ) -> Annotated[float, angle("theta_s", "how far the web slips on the roll behind the nip")]:
        """How far behind the trailing edge the web slips on the roll before it sticks [rad]."""
        last = self.in_nip.stop - 1
        zones, x = self.roll_zone[last:], self.x[last:]
        if zones[0] == 0 or self.problem.roll_wrap == 0:
            return 0.0
        other = np.nonzero(zones != zones[0])[0]
        border = (x[other[0]] + x[other[0] - 1]) / 2 if other.size else x[-1]
        return float((border - self.half_width) / self.problem.roll.radius)

    @property
    def slip_zone(self) -> Zone:
        """The way the web slips on the roll just behind the nip; STICK where it does not."""
        return super().slip_zone if self.slip_angle else Zone.STICK

    def confined(self, **options: Any) -> NipResult:
        """Solve the nip alone, the web held at its trailing edge (thesis eq. 97).

        Its ``tension_behind_nip`` and ``wound_on_tension_estimate()`` bracket ``wound_on_tension``.

        Parameters
        ----------
        options
            Of :func:`~woundon.nip.solve.solve_nip`.

        Raises
        ------
        NoSteadyState
            If the nip alone cannot carry the winding force.
        """
        solve_nip = kinds.fetch("woundon.nip.solve:solve_nip")
        return solve_nip(self.problem.confined(), **options)

    def certified(self) -> Residuals:
        """Return the certificate measured anew, from the problem and the arrays held here."""
        from .certificate import certificate, equations_of

        return certificate(self, equations_of(self))

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
        told: Mapping[str, tuple[float, float]] = kinds.fetch("woundon.wrap.outcome:recomputed")(
            self
        )
        return told

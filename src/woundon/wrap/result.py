"""The state of a nip with its wraps, and its certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..problems import NipProblem
from ..results import NipResult, Residuals, SlipRatios, Zone

__all__ = ["WrappedNipResult", "WrappedResiduals"]

Array = np.ndarray

_ALONG_NIP = (
    "x", "slip_x", "pressure", "roll_traction", "drum_traction", "roll_slip", "drum_slip",
    "roll_zone", "drum_zone", "web_tension",
)  # fmt: skip
_OF_NIP = (
    "half_width", "approach", "offset", "drum_creep", "slip_ratios", "warnings", "iterations",
    "series_terms", "series_error",
)  # fmt: skip


@dataclass(frozen=True)
class WrappedResiduals(Residuals):
    """The certificate of the plain nip and, added, the web's normal balance p+ - p- = T kappa.

    ``hoop_pressure`` is its largest violation over the largest of the terms T kappa.
    """

    hoop_pressure: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class WrappedNipResult:
    """The state of a winding nip with the web wrapped on the roll behind it and the drum before it.

    It has the fields of :class:`~woundon.results.NipResult`, the arrays along the whole web that
    touches anything: from the drum's arc, if any, through the nip to the far side of the roll.

    Attributes
    ----------
    problem : NipProblem
    roll_wrap, drum_wrap : float
        Where the web is held to the roll, from the line of centres; arc on the drum before the nip
        [rad].
    wrap_friction : float
        mu+ behind the nip.
    winding_force : float
        F = integral of q- over nip and drum wrap [N/m].
    wound_on_tension : float
        WOT, tension at the far side of the roll [N/m]; ``wound_on_tension_error`` its estimated
        discretisation error.
    tension_before_nip, tension_behind_nip : float
        T at x = -a and T_out at x = a [N/m].
    roll_wrap_traction, drum_wrap_traction : float
        Q_w+ and Q_w-, tractions on the arcs behind and before the nip, integrated [N/m].
    slip_angle : float
        How far behind the trailing edge the web slips on the roll before it first sticks [rad].
    half_width, approach, offset, drum_creep : float
        a [m], mutual approach > 0 [m], Delta [m], xi-: as of a plain nip.
    x, slip_x : (N,) arrays
        Nodes s along the web, and where the slips are taken [m]; the nip is [-a, a].
    pressure, roll_pressure, hoop_pressure : (N,) arrays
        p- on the drum, p+ on the roll, and T kappa, their difference [Pa].
    curvature : (N,) array
        kappa of the web, centre on the roll's side > 0 [1/m].
    roll_traction, drum_traction : (N,) arrays
        q+, q- [Pa].
    roll_slip, drum_slip : (N,) arrays
        v+, v-; nan where the web does not touch the body.
    roll_strain : (N,) array
        eps_theta1 of the roll's surface where the slips are taken; nan before the nip.
    roll_zone, drum_zone : (N,) int arrays
        :class:`~woundon.results.Zone` of each node.
    web_tension : (N,) array
        T(s) [N/m].
    residuals : WrappedResiduals
    warnings : tuple of str
    """

    problem: NipProblem
    roll_wrap: float
    drum_wrap: float
    wrap_friction: float
    winding_force: float
    wound_on_tension: float
    wound_on_tension_error: float
    tension_before_nip: float
    tension_behind_nip: float
    roll_wrap_traction: float
    drum_wrap_traction: float
    slip_angle: float
    half_width: float
    approach: float
    offset: float
    drum_creep: float
    x: Array
    slip_x: Array
    pressure: Array
    roll_pressure: Array
    hoop_pressure: Array
    curvature: Array
    roll_traction: Array
    drum_traction: Array
    roll_slip: Array
    drum_slip: Array
    roll_strain: Array
    roll_zone: Array
    drum_zone: Array
    web_tension: Array
    slip_ratios: SlipRatios
    residuals: WrappedResiduals
    warnings: tuple[str, ...] = ()
    iterations: int = 0
    series_terms: int = 0
    series_error: float = 0.0

    @property
    def nip_induced_tension(self) -> float:
        """NIT = Q+ + Q- of the nip alone, T(a) - T(-a) [N/m]."""
        return self.tension_behind_nip - self.tension_before_nip

    @property
    def in_nip(self) -> slice:
        """Which nodes are the nip's."""
        edge = self.half_width * (1 + 1e-12)
        return slice(
            int(np.searchsorted(self.x, -edge)), int(np.searchsorted(self.x, edge, side="right"))
        )

    @property
    def slip_zone(self) -> Zone:
        """The way the web slips on the roll just behind the nip; STICK where it does not."""
        return Zone(int(self.roll_zone[self.in_nip.stop - 1])) if self.slip_angle else Zone.STICK

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        return self.in_nip.stop - self.in_nip.start

    @property
    def nip(self) -> NipResult:
        """The nip alone as a plain result; its tension and winding force are those at its edges."""
        own = self.in_nip
        return NipResult(
            problem=self._problem_of_nip(),
            nip_induced_tension=self.nip_induced_tension,
            nip_induced_tension_error=self.wound_on_tension_error,
            residuals=self.residuals,
            **{name: getattr(self, name)[own] for name in _ALONG_NIP},
            **{name: getattr(self, name) for name in _OF_NIP},
        )

    def _problem_of_nip(self) -> NipProblem:
        problem, T = self.problem, self.tension_before_nip
        if self.drum_wrap == 0:
            return problem
        # a nip that slides wholly, held by the wrap, has no steady state of its own
        most = problem.drum_friction * problem.nip_load * (1 - 1e-12)
        force = float(np.clip(self.winding_force - (T - problem.web_tension), -most, most))
        return problem.replace(web_tension=max(T, 0.0), winding_force=force)

    def plot(self, path: Any = None) -> Any:
        """Draw tractions, slips, tension and hoop pressure in the nip and along the wraps."""
        from ..plots import plot_wrapped

        return plot_wrapped(self, path)

    def save(self, path: Any) -> None:
        """Write the result to a file, by its ending: ``.nc``, ``.json`` or ``.csv``."""
        from ..casefile import save_result

        save_result(self, path)

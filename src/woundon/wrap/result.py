"""The state of a nip with its wraps, and its certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..problems import NipProblem
from ..results import NipResult, Residuals, SlipRatios, Zone

__all__ = ["WrappedNipResult", "WrappedResiduals"]

Array = np.ndarray


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
    nip : NipResult
        The nip alone, its tension and winding force those at its edges; for plots and files.
    wound_on_tension : float
        WOT, tension at the far side of the roll [N/m]; ``wound_on_tension_error`` its estimated
        discretisation error.
    tension_before_nip, tension_behind_nip : float
        T at x = -a and T_out at x = a [N/m].
    roll_wrap_traction, drum_wrap_traction : float
        Q_w+ and Q_w-, tractions on the arcs behind and before the nip, integrated [N/m].
    slip_angle : float
        How far behind the trailing edge the web slips on the roll before it first sticks [rad].
    slip_zone : Zone
        The way it slips there.
    x : (N,) array
        Nodes s along the web [m]; the nip is [-a, a].
    pressure, roll_pressure, hoop_pressure : (N,) arrays
        p- on the drum, p+ on the roll, and T kappa, their difference [Pa].
    curvature : (N,) array
        kappa of the web, centre on the roll's side > 0 [1/m].
    roll_traction, drum_traction : (N,) arrays
        q+, q- [Pa].
    roll_slip, drum_slip : (N,) arrays
        v+, v-; nan where the web does not touch the body.
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
    nip: NipResult
    wound_on_tension: float
    wound_on_tension_error: float
    tension_before_nip: float
    tension_behind_nip: float
    roll_wrap_traction: float
    drum_wrap_traction: float
    slip_angle: float
    slip_zone: Zone
    x: Array
    pressure: Array
    roll_pressure: Array
    hoop_pressure: Array
    curvature: Array
    roll_traction: Array
    drum_traction: Array
    roll_slip: Array
    drum_slip: Array
    roll_zone: Array
    drum_zone: Array
    web_tension: Array
    residuals: WrappedResiduals
    warnings: tuple[str, ...] = ()

    @property
    def nip_induced_tension(self) -> float:
        """NIT = Q+ + Q- of the nip alone, T_out - T(-a) [N/m]."""
        return self.nip.nip_induced_tension

    @property
    def half_width(self) -> float:
        """a [m]."""
        return self.nip.half_width

    @property
    def approach(self) -> float:
        """Mutual approach of the centres, > 0 [m]."""
        return self.nip.approach

    @property
    def offset(self) -> float:
        """Delta [m]."""
        return self.nip.offset

    @property
    def drum_creep(self) -> float:
        """xi-, creep ratio of web and drum, unstrained web and drum as reference."""
        return self.nip.drum_creep

    @property
    def slip_ratios(self) -> SlipRatios:
        """Slip lengths in the nip over its width."""
        return self.nip.slip_ratios

    @property
    def iterations(self) -> int:
        """Number of linear stick-slip systems solved."""
        return self.nip.iterations

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        return self.nip.nodes

    def plot(self, path: Any = None) -> Any:
        """Draw the nip's tractions, slip speeds and web tension."""
        return self.nip.plot(path)

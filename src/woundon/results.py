"""What a solve returns: immutable results that carry their problem and their certificate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from enum import IntEnum
from math import nan
from typing import Any

import numpy as np

from .problems import NipProblem, RollerProblem

__all__ = ["NipResult", "Residuals", "RollerResult", "Sensitivity", "SlipRatios", "Zone"]

Array = np.ndarray


class Zone(IntEnum):
    """State of a contact point: stick, or slip with the web faster or slower than the body."""

    BACKWARD = -1
    STICK = 0
    FORWARD = 1


@dataclass(frozen=True)
class Residuals:
    """The certificate: the largest violation of each law, dimensionless.

    Pressures and tractions are measured by the largest pressure (times mu for the tractions),
    slips by the largest strain that the contact produces, loads by the nip load.
    """

    indentation: float
    positive_pressure: float
    stick: float
    friction_bound: float
    slip_traction: float
    slip_direction: float
    load_equilibrium: float
    force_equilibrium: float
    web_equilibrium: float = 0.0

    def items(self) -> Iterator[tuple[str, float]]:
        """Yield (law, violation)."""
        return ((f.name, getattr(self, f.name)) for f in fields(self))

    @property
    def largest(self) -> float:
        """The largest of them."""
        return max(value for _, value in self.items())


@dataclass(frozen=True)
class SlipRatios:
    """Slip lengths over the nip width, > 0 where the web is the faster one (thesis eq. 172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """First derivatives of a nip's outputs at one problem.

    Attributes
    ----------
    outputs : tuple of str
        ``nip_induced_tension``, ``half_width``, ``drum_creep``.
    parameters : tuple of str
        Dotted names of the fields.
    derivatives : (outputs, parameters) array
        SI units of output per SI unit of field.
    values, fields : (outputs,), (parameters,) arrays
        Where they were taken.
    zone_change : str
        Empty, or the nodes that are about to change between stick and slip: there the
        derivatives to both sides differ.
    """

    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    derivatives: Array
    values: Array
    fields: Array
    zone_change: str = ""

    def derivative(self, output: str, parameter: str) -> float:
        """Return d output / d parameter."""
        at = self.outputs.index(output), self.parameters.index(parameter)
        return float(self.derivatives[at])

    @property
    def elasticities(self) -> Array:
        """Percent of output per percent of field, (outputs, parameters); 0 for a field at 0.

        nan for an output that is 0.
        """
        values = np.where(self.values == 0, np.nan, self.values)
        return self.derivatives * self.fields / values[:, None]

    def sorted(self) -> Sensitivity:
        """Return the same, the parameters of the largest NIT elasticity first."""
        order = np.argsort(-np.abs(np.nan_to_num(self.elasticities[0])), kind="stable")
        return replace(
            self,
            parameters=tuple(self.parameters[k] for k in order),
            derivatives=self.derivatives[:, order],
            fields=self.fields[order],
        )


@dataclass(frozen=True, eq=False)
class NipResult:
    """The state of a winding nip.

    Attributes
    ----------
    problem : NipProblem
    nip_induced_tension : float
        NIT = Q+ + Q- [N/m].
    nip_induced_tension_error : float
        Estimated discretisation error of NIT [N/m]; nan where only one grid was solved.
    half_width : float
        a [m]; contact is [-a, a].
    approach : float
        Mutual approach of the centres, > 0 [m].  With a half-plane it holds up to a constant.
    offset : float
        Delta, shift of the contact centre from the line of centres along +x [m].
    drum_creep : float
        xi-, creep ratio of web and drum (thesis eq. 92), unstrained web and drum as reference.
    x : (M,) array
        Nodes [m], from -a to a.
    slip_x : (M,) array
        Where the slips are taken [m]: the middle of the cell before each node.
    pressure, roll_traction, drum_traction : (M,) arrays
        p, q+, q- [Pa]; q is the traction of the web on the body along +x.
    roll_slip, drum_slip : (M,) arrays
        v+, v- relative slip speeds, > 0 where the web is faster (thesis eq. 133); a node's slip is
        that of the collocation point before it.
    roll_zone, drum_zone : (M,) int arrays
        :class:`Zone` of each node.
    web_tension : (M,) array
        T(x) [N/m].
    slip_ratios : SlipRatios
    residuals : Residuals
        The certificate.
    warnings : tuple of str
        Where the solved case leaves the model's validity, with numbers.
    scheme, algorithm : str
        How it was solved.
    iterations : int
        Number of linear stick-slip systems solved.
    series_terms : int
        Fourier terms summed for the bodies; ``series_error`` their estimated truncation error.
    """

    problem: NipProblem
    nip_induced_tension: float
    nip_induced_tension_error: float
    half_width: float
    approach: float
    offset: float
    drum_creep: float
    x: Array
    slip_x: Array
    pressure: Array
    roll_traction: Array
    drum_traction: Array
    roll_slip: Array
    drum_slip: Array
    roll_zone: Array
    drum_zone: Array
    web_tension: Array
    slip_ratios: SlipRatios
    residuals: Residuals
    warnings: tuple[str, ...] = ()
    scheme: str = "graded"
    algorithm: str = "pivoting"
    iterations: int = 0
    series_terms: int = 0
    series_error: float = 0.0

    @property
    def wound_on_tension(self) -> float:
        """T_out = T_in + NIT, tension of the web just behind the nip [N/m]."""
        return self.problem.web_tension + self.nip_induced_tension

    @property
    def nodes(self) -> int:
        """Number of nodes M."""
        return self.x.size

    def with_warnings(self, warnings: tuple[str, ...]) -> NipResult:
        """Return the same result with other warnings."""
        return replace(self, warnings=warnings)

    def sensitivity(self, *parameters: str) -> Sensitivity:
        """Return exact derivatives of NIT, half width and creep with respect to problem fields.

        Parameters
        ----------
        parameters : str
            Dotted names (``"roll.material.shear"``); every continuous field if none is given.

        Returns
        -------
        Sensitivity
        """
        from .sensitivity import nip_sensitivity

        return nip_sensitivity(self, parameters)

    def plot(self, path: Any = None) -> Any:
        """Draw tractions with friction bounds, slip speeds and web tension (as thesis Fig. 15)."""
        from .plots import plot_nip

        return plot_nip(self, path)

    def save(self, path: Any) -> None:
        """Write the result to a file, by its ending: ``.nc``, ``.json`` or ``.csv``."""
        from .casefile import save_result

        save_result(self, path)


@dataclass(frozen=True, eq=False)
class RollerResult:
    """The state of two rollers in contact.

    Attributes
    ----------
    problem : RollerProblem
    creepage : float
        xi, the lower roller's surface speed less the upper's, over the speed, before strain; > 0
        where it drags the upper roller along +x.  nan for a static contact.
    tangential_load : float
        Q on the upper roller along +x [N/m].
    half_width, approach, offset : float
        a, approach > 0 and Delta [m].
    x, pressure, traction, slip, zone : (M,) arrays
        Nodes [m], p and q [Pa] (on the upper roller), relative slip of the surfaces, zones.
    residuals : Residuals
    traction_error : float
        Estimated discretisation error of the traction, L2 norm relative to its own [1].
    """

    problem: RollerProblem
    creepage: float
    tangential_load: float
    half_width: float
    approach: float
    offset: float
    x: Array
    pressure: Array
    traction: Array
    slip: Array
    zone: Array
    residuals: Residuals
    traction_error: float = nan
    warnings: tuple[str, ...] = field(default=())
    iterations: int = 0

"""The state of a winding nip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import nan
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from ..errors import InvalidProblem, warn
from ..problems.air import with_film
from ..problems.messages import quote
from ..problems.roll import RollProblem
from ..problems.web import CENTRIFUGAL_TENSION
from ..quantities import angle, length, line_load, on_request, stress
from ..results import Residuals, Zone
from .layer_slip import LayerSlip, layer_slip
from .nip_fields import NipFields
from .roll_contact import RollContact, contacts_of

if TYPE_CHECKING:
    from ..contact.refinement import MeshSolution

__all__ = ["NipResult", "SlipRatios"]

Array = np.ndarray


@dataclass(frozen=True)
class SlipRatios:
    """Slip lengths over the nip width, > 0 where the web is the faster one (thesis eq. 172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NipResult(NipFields):
    """The solution of a winding nip; the arrays run along the web.

    With wraps the arrays run from the web's first contact with the drum through the nip (the nodes
    ``in_nip``) to where it is held to the roll, through all further nips.  Scalars without a word
    on the further nips are those of the first one.  Slips are nan where the web does not touch the
    body, and roll strains upstream of the nip.

    Attributes
    ----------
    problem : NipProblem
    roll_wound_on_tension : float
        Wound-on tension reduced to the closed layer of a wound roll without nip [N/m]; windings
        use it.
    half_width : float
        a [m]; the nip is [-a, a].
    approach : float
        Mutual approach of the centres, > 0 [m].  With a half-plane it holds up to a constant.
    offset : float
        Delta, where the line of centres lies along +x, from the centre of the contact [m].
    drum_creepage : float
        xi-, creepage of web and drum (thesis eq. 92), unstrained web and drum as reference.
    leading_roll, trailing_roll, dual : float
        Signed slip lengths over the nip width (thesis eq. 172), to a fraction of a cell;
        ``slip_ratios`` holds all three.
    x : (M,) array
        Nodes [m].
    slip_x : (M,) array
        Where the slips are evaluated [m]: a point in the cell upstream of each node.
    drum_pressure, roll_pressure : (M,) arrays
        p- on the drum and p+ on the roll [Pa].
    roll_traction, drum_traction : (M,) arrays
        q+, q- [Pa], traction of the web on the body along +x.
    roll_slip, drum_slip : (M,) arrays
        v+, v- relative slip speeds, > 0 where the web is faster (thesis eq. 133).
    roll_zone, drum_zone : (M,) int arrays
        :class:`~woundon.results.Zone` of each node.
    tension : (M,) array
        T(x) [N/m].
    roll_strain : (M,) array
        eps_1 of the roll's surface at ``slip_x``.
    hoop_pressure : (M,) array
        T kappa, the pressure of the web on what it is wrapped on [Pa]; length 0 without wraps.
    curvature : (M,) array
        kappa of the web on the wraps, centre on the roll's side > 0 [1/m]; length 0 without wraps.
    next_positions, next_half_widths, next_offsets, next_creepages : (K-1,) arrays
        Of the contacts of ``next_nips``: centre along the roll from the first contact [m], a [m],
        Delta [m], xi-; length 0 without further nips.  ``contacts`` describes all nips.
    air : AirFilm or None
        Film of entrained air, and the friction coefficients that it leaves.
    iterations : int
        Number of Newton iterations on all meshes.
    series_terms, series_error : int, float
        Fourier terms summed for the bodies, their estimated relative truncation error.
    refinement : Refinement
        The solutions on all meshes, from which a neighbouring case starts; None of a result that
        was loaded from a file.

    Examples
    --------
    >>> import woundon as wo
    >>> nip = wo.solve(wo.NipProblem.example(), nodes=41)
    >>> print(f"{nip.wound_on_tension:.0f} N/m, of that {nip.nip_induced_tension:.0f} by the nip")
    700 N/m, of that 350 by the nip
    >>> print(f"nip width {1e3 * nip.nip_width:.2f} mm, slip angle {nip.slip_angle:.2f} rad")
    nip width 4.95 mm, slip angle 0.07 rad
    """

    MAIN: ClassVar[tuple[str, ...]] = ("wound_on_tension",)
    CONTACT_PRESSURE: ClassVar[str] = "drum_pressure"
    # outputs of ``sensitivity`` where none is named
    _differentiated: ClassVar[tuple[str, ...]] = (
        "wound_on_tension",
        "nip_induced_tension",
        "outlet_tension",
        "half_width",
        "nip_width",
        "drum_creepage",
    )
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset(
        {"roll_slip", "drum_slip", "roll_strain", "rolling_resistance"}
    )
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("roll_slip", "drum_slip", "roll_strain"), "slip_x")
    )
    ESTIMATES: ClassVar[frozenset[str]] = frozenset({"iterations", "series_error", "series_terms"})

    @property
    def nip_width(self) -> Annotated[float, length("2a", "nip width")]:
        """2a [m]."""
        return 2 * self.half_width

    @property
    def peak_pressure(self) -> Annotated[float, stress("p_max", "largest pressure")]:
        """Largest nodal pressure on the drum [Pa]."""
        return float(self.drum_pressure.max())

    @property
    def slip_ratios(self) -> SlipRatios:
        """The three signed slip lengths over the nip width (thesis eq. 172)."""
        return SlipRatios(self.leading_roll, self.trailing_roll, self.dual)

    @on_request
    def layer_slip(self) -> LayerSlip | None:
        """Index of slip between the layers of the roll, which the model takes as bonded.

        None of a roll whose interior stresses are not known (rigid, viscoelastic).  Layers that
        would slip issue a :class:`~woundon.errors.ValidityWarning`.
        """
        slip = layer_slip(self)
        warn([slip.warning] if slip and slip.warning else ())
        return slip

    @property
    def _excluded(self) -> dict[str, str]:
        """Fields without a derivative, with the reason."""
        text = "0 has no derivative: with a wrap the path of the web changes"
        return {
            name: text for name in ("roll_wrap", "drum_wrap") if getattr(self.problem, name) == 0
        }

    def _recomputed_solution(self) -> MeshSolution:
        """Return the solution on the last mesh from the arrays of this result."""
        from .certificate import recomputed_solution

        return recomputed_solution(self)

    def certified(self) -> Residuals:
        """Return the certificate, evaluated from the problem and the arrays of this result."""
        from .certificate import certificate, equations_of

        return certificate(self, equations_of(self))

    @property
    def consistency(self) -> Residuals:
        """Conditions of the continuous fields: the balance of power, and other quadratures.

        Their defects are of the order of the discretisation error and converge with the mesh.
        """
        from .certificate import consistency

        return consistency(self)

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return the scalars that no condition determines: values from the arrays, tolerances."""
        from .certificate import recomputed

        return recomputed(self)

    # ---- tensions and wraps ----------------------------------------------------------------------

    @property
    def wound_on_tension(self) -> Annotated[float, line_load("WOT", "wound-on tension")]:
        """WOT, the tension at the end of the roll wrap, as a load cell reads it [N/m]."""
        return float(self.tension[-1])

    @property
    def wound_on_tension_error(
        self,
    ) -> Annotated[
        float, line_load("WOT error", "estimated discretisation error of the wound-on tension")
    ]:
        """Its estimated discretisation error [N/m]; nan where only one mesh was solved."""
        return self.errors.get("wound_on_tension", float("nan"))

    @property
    def inlet_tension(
        self,
    ) -> Annotated[float, line_load("T_n", "web tension at the leading edge of the nip")]:
        """T at x = -a [N/m]."""
        return float(self.tension[self.in_nip.start])

    @property
    def outlet_tension(
        self,
    ) -> Annotated[float, line_load("T_out", "web tension at the trailing edge of the nip")]:
        """T_out at x = a [N/m]."""
        return float(self.tension[self.in_nip.stop - 1])

    @property
    def nip_induced_tension(
        self,
    ) -> Annotated[float, line_load("NIT", "nip-induced tension, WOT - T_in")]:
        """NIT = wound_on_tension - web_tension, as the integral of all tractions [N/m].

        The difference of the tensions would lose digits at a high web tension.
        """
        return float(np.trapezoid(self.roll_traction + self.drum_traction, self.x))

    @property
    def nip_induced_tension_error(
        self,
    ) -> Annotated[
        float, line_load("NIT error", "estimated discretisation error of the nip-induced tension")
    ]:
        """Estimated discretisation error of NIT [N/m]; nan where only one mesh was solved."""
        return self.errors.get("nip_induced_tension", float("nan"))

    @property
    def centrifugal_tension(self) -> Annotated[float, CENTRIFUGAL_TENSION]:
        """m V^2, by which the web presses less on wraps [N/m]; nan without speed or density."""
        return self.problem.centrifugal_tension or nan

    @property
    def roll_wrap_traction(
        self,
    ) -> Annotated[
        float, line_load("Q_w+", "tangential force on the roll downstream of the nip, per width")
    ]:
        """Q_w+, that of the roll alone if there are further nips [N/m]."""
        by_drums = sum(nip.winding_force for nip in self.problem.next_nips)
        return self.wound_on_tension - self.outlet_tension - by_drums

    @property
    def drum_wrap_traction(
        self,
    ) -> Annotated[
        float, line_load("Q_w-", "tangential force on the drum upstream of the nip, per width")
    ]:
        """Q_w- [N/m]."""
        return self.inlet_tension - float(self.tension[0])

    @property
    def slip_angle(
        self,
    ) -> Annotated[float, angle("theta_s", "slip angle on the roll downstream of the nip")]:
        """Angle on the roll downstream of the trailing edge on which the web slips [rad]."""
        last = self.in_nip.stop - 1
        zones, x = self.roll_zone[last:], self.x[last:]
        if zones[0] == 0 or self.problem.roll_wrap == 0:
            return 0.0
        other = np.nonzero(zones != zones[0])[0]
        boundary = (x[other[0]] + x[other[0] - 1]) / 2 if other.size else x[-1]
        return float((boundary - self.half_width) / self.problem.roll.radius)

    @property
    def slip_zone(self) -> Zone:
        """The way the web slips on the roll at the trailing edge.

        With a roll wrap it is that of the slip which continues there on ``slip_angle``.
        """
        return Zone(int(self.roll_zone[self.in_nip.stop - 1]))

    # ---- several nips ---------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> tuple[RollContact, ...]:
        """The nips in the direction of travel: the first one, then those of ``next_nips``."""
        return tuple(contacts_of(self))

    # ---- entrained air --------------------------------------------------------------------------

    def wound(self, roll: RollProblem) -> RollProblem:
        """Return a roll with the film of this nip between its layers; see :class:`.AirBetween`.

        Parameters
        ----------
        roll : RollProblem
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
                f"{quote(web)} is out of range; must be the nip's, "
                f"{self.problem.web.thickness:.6g} [m]",
            )
        if self.air is None or self.problem.air is None:
            return roll
        return with_film(roll, self.air.film, self.problem.air)

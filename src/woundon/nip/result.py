"""The state of a winding nip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from ..errors import InvalidProblem, warn
from ..problems.air import with_film
from ..problems.messages import quote
from ..problems.nip import NipProblem
from ..problems.roll import RollProblem
from ..quantities import Quantity, angle, length, line_load, on_request, pure, share, strain, stress
from ..results import Residuals, Result, Zone
from .air_films import friction_between
from .energy import pressure_resultant
from .entrained_air import AirFilm
from .layer_slip import LayerSlip, layer_slip
from .roll_contact import RollContact, contacts_of, tensions_of_first_nips

if TYPE_CHECKING:
    from ..contact.refinement import MeshSolution
    from ..sensitivity import Sensitivity

__all__ = ["ContactOutputs", "NipResult", "SlipRatios"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ContactOutputs:
    """What the results of a nip and of two rollers have in common.

    Attributes
    ----------
    rolling_resistance : float
        Dissipation of the viscoelastic bodies per length rolled [N/m], a force per metre of width;
        nan without a viscoelastic body.
    """

    CONTACT_PRESSURE: ClassVar[str] = "pressure"  # name of the array of the contact pressure

    rolling_resistance: Annotated[
        float, line_load("F_R", "rolling resistance of the viscoelastic bodies")
    ] = nan

    @property
    def dissipated_power(
        self,
    ) -> Annotated[
        float, Quantity("D", "W/m", "power dissipated in the viscoelastic bodies, per width")
    ]:
        """V F_R [W/m]: the heat that goes into the covers."""
        V = self.problem.rolling_speed  # type: ignore[attr-defined]
        return nan if V is None else float(V * self.rolling_resistance)

    @property
    def pressure_shift(
        self,
    ) -> Annotated[float, length("e_p", "pressure resultant, downstream of the line of centres")]:
        """Position of the pressure's resultant along +x, from the line of centres [m]."""
        result: Any = self
        if not result.problem.viscoelastic:
            return nan
        x, p = result.x[result.in_nip], getattr(result, result.CONTACT_PRESSURE)[result.in_nip]
        return float(pressure_resultant(x, p)[1] - result.offset)

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        in_nip: slice = self.in_nip  # type: ignore[attr-defined]
        return in_nip.stop - in_nip.start

    def sensitivity(self, *parameters: str, outputs: Sequence[str] = ()) -> Sensitivity:
        """Return exact derivatives of outputs with respect to fields of the problem.

        Parameters
        ----------
        parameters : str
            Dotted names (``"roll.material.shear"``, ``"upper.material.youngs_modulus"``); every
            continuous field if none is given.
        outputs : sequence of str
            Names; the main ones if none is given.
        """
        # imported late: many results are never differentiated
        from .sensitivity import contact_sensitivity

        result: Any = self
        if result.refinement is not None:
            meshes = result.refinement.meshes
        else:  # loaded from a file
            meshes = [result._recomputed_solution()]
        outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        return contact_sensitivity(
            result, meshes, parameters, outputs or result._differentiated, result._excluded
        )


@dataclass(frozen=True)
class SlipRatios:
    """Slip lengths over the nip width, > 0 where the web is the faster one (thesis eq. 172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NipResult(ContactOutputs, Result):
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
    refinement: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})

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

    @cached_property
    def in_nip(self) -> slice:
        """The nodes of the nip: those between -a and a, edges included."""
        distances = np.abs(self.x - [[-self.half_width], [self.half_width]])
        nearest = distances.argmin(axis=1)
        if np.isnan(distances[[0, 1], nearest]).any():  # damaged arrays: use the valid nodes
            nearest = np.nanargmin(distances, axis=1)
        first, last = nearest.tolist()
        return slice(first, last + 1)

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
    def centrifugal_tension(
        self,
    ) -> Annotated[float, line_load("m V^2", "part of the tension taken by centrifugal force")]:
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
        """The way the web slips on the roll at the trailing edge; with a roll wrap, beyond it."""
        if self.problem.roll_wrap > 0 and not self.slip_angle:
            return Zone.STICK
        return Zone(int(self.roll_zone[self.in_nip.stop - 1]))

    # ---- several nips ---------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> tuple[RollContact, ...]:
        """The nips in the direction of travel: the first one, then those of ``next_nips``."""
        return tuple(contacts_of(self))

    @cached_property
    def _tensions_of_first_nips(self) -> list[float]:
        """Wound-on tensions of the first nips alone, for :attr:`.RollContact.added_tension`."""
        return tensions_of_first_nips(self)

    # ---- entrained air --------------------------------------------------------------------------

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
        ratio: float | Array = friction_between(self.air.film, pressure, air)
        return dry_friction * ratio

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

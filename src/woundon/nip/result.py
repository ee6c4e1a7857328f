"""The state of a winding nip: what it has with and without its wraps, and the plain one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import nan, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NoReturn

import numpy as np

from .. import kinds
from ..errors import warn
from ..problems.nip import NipProblem, WrappedNipProblem
from ..quantities import Quantity, angle, length, line_load, pure, strain, stress
from ..results import Residuals, Result, Zone

if TYPE_CHECKING:
    from .layer_slip import LayerSlip
    from .sensitivity import Sensitivity

__all__ = ["Dissipation", "NipResult", "SlipRatios", "WindingNipResult", "WrappedNipResult"]

Array = np.ndarray

RIG_ANGLE = pi / 2  # behind the nip, where the laboratory winder leads the web to its load cell


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Dissipation:
    """Outputs of rolling contacts with a viscoelastic body; nan without one.

    Attributes
    ----------
    rolling_resistance : float
        Dissipation of the viscoelastic bodies per length rolled [N/m], a force per metre of width.
    """

    rolling_resistance: Annotated[
        float, line_load("F_R", "rolling resistance of the viscoelastic bodies")
    ] = nan

    @property
    def dissipated_power(
        self,
    ) -> Annotated[
        float, Quantity("D", "W/m", "power that the viscoelastic bodies turn into heat, per width")
    ]:
        """V F_R [W/m]: the heat that goes into the covers."""
        V = self.problem.rolling_speed  # type: ignore[attr-defined]
        return nan if V is None else float(V * self.rolling_resistance)

    @property
    def pressure_shift(
        self,
    ) -> Annotated[
        float,
        length("e_p", "the pressure's resultant downstream of the line of centres, < 0: upstream"),
    ]:
        """Position of the pressure's resultant along +x, from the line of centres [m]."""
        own: Any = self
        if own.problem.rolling_speed is None:
            return nan
        x, p = own.x[own.in_nip], own.pressure[own.in_nip]
        moment = np.diff(x) @ (x[:-1] * (2 * p[:-1] + p[1:]) + x[1:] * (p[:-1] + 2 * p[1:])) / 6
        return float(moment / np.trapezoid(p, x) - own.offset)


@dataclass(frozen=True)
class SlipRatios:
    """Slip lengths over the nip width, > 0 where the web is the faster one (thesis eq. 172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WindingNipResult(Dissipation, Result):
    """What every solved winding nip has; the arrays along the web.

    Attributes
    ----------
    half_width : float
        a [m]; contact is [-a, a].
    approach : float
        Mutual approach of the centres, > 0 [m].  With a half-plane it holds up to a constant.
    offset : float
        Delta, where the line of centres lies along +x, from the centre of the contact [m].
    drum_creep : float
        xi-, creep ratio of web and drum (thesis eq. 92), unstrained web and drum as reference.
    leading_roll, trailing_roll, dual : float
        Signed slip lengths over the nip width (thesis eq. 172), to a fraction of a cell;
        ``slip_ratios`` holds all three.
    x : (M,) array
        Nodes [m].
    slip_x : (M,) array
        Where the slips are taken [m]: a point in the cell before each node.
    pressure, roll_traction, drum_traction : (M,) arrays
        p (of a wrapped nip p-, that on the drum), q+, q- [Pa]; q is the traction of the web on the
        body along +x.
    roll_slip, drum_slip : (M,) arrays
        v+, v- relative slip speeds, > 0 where the web is faster (thesis eq. 133).
    roll_zone, drum_zone : (M,) int arrays
        :class:`~woundon.results.Zone` of each node.
    web_tension : (M,) array
        T(x) [N/m].
    iterations : int
        Number of Newton iterations on all meshes.
    series_terms, series_error : int, float
        Fourier terms summed for the bodies, their estimated relative truncation error.
    refinement : Refinement
        The solutions on all meshes, from which a neighbouring case starts; None of a result that
        was loaded from a file.
    """

    DIFFERENTIATED: ClassVar[tuple[str, ...]]  # outputs of ``sensitivity`` where none is named
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("roll_slip", "drum_slip", "roll_strain"), "slip_x")
    )
    ESTIMATES: ClassVar[frozenset[str]] = frozenset({"iterations", "series_error", "series_terms"})

    half_width: Annotated[float, length("a", "half-width of the nip")]
    approach: Annotated[float, length("delta", "approach of the centres of roll and drum")]
    offset: Annotated[float, length("Delta", "line of centres, from the centre of the contact")]
    drum_creep: Annotated[float, strain("xi-", "creep of web and drum")]
    leading_roll: Annotated[
        float, strain("s_l+", "slip length at the roll's leading edge / nip width")
    ]
    trailing_roll: Annotated[
        float, strain("s_t+", "slip length at the roll's trailing edge / nip width")
    ]
    dual: Annotated[float, strain("s_d", "length of slip at both roll and drum / nip width")]
    x: Annotated[Array, length("x", "position along the nip, with the web; the contact is [-a, a]")]
    slip_x: Annotated[Array, length("x_v", "where the slips are taken, in the cell before a node")]
    pressure: Annotated[Array, stress("p", "pressure")]
    roll_traction: Annotated[Array, stress("q+", "traction of the web on the roll")]
    drum_traction: Annotated[Array, stress("q-", "traction of the web on the drum")]
    roll_slip: Annotated[Array, strain("v+", "slip of the web against the roll, > 0: web faster")]
    drum_slip: Annotated[Array, strain("v-", "slip of the web against the drum, > 0: web faster")]
    roll_zone: Annotated[
        Array, pure("z+", "zone at the roll: 0 stick, 1 slip with the web faster, -1 slower"), Zone
    ]
    drum_zone: Annotated[
        Array, pure("z-", "zone at the drum: 0 stick, 1 slip with the web faster, -1 slower"), Zone
    ]
    web_tension: Annotated[Array, line_load("T", "web tension along the nip")]
    iterations: Annotated[int, pure("n_it", "Newton iterations")] = 0
    series_terms: Annotated[int, pure("n_s", "Fourier terms summed")] = 0
    series_error: Annotated[float, pure("e_s", "estimated truncation error of the series")] = 0.0
    refinement: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})

    @property
    def nip_width(self) -> Annotated[float, length("2a", "nip width")]:
        """2a [m]."""
        return 2 * self.half_width

    @property
    def peak_pressure(self) -> Annotated[float, stress("p_max", "largest pressure")]:
        """Largest nodal pressure on the drum [Pa]."""
        return float(self.pressure.max())

    @property
    def slip_ratios(self) -> SlipRatios:
        """The three signed slip lengths over the nip width (thesis eq. 172)."""
        return SlipRatios(self.leading_roll, self.trailing_roll, self.dual)

    @cached_property
    def in_nip(self) -> slice:
        """Which nodes are the nip's."""
        apart = np.abs(self.x - [[-self.half_width], [self.half_width]])
        nearest = apart.argmin(axis=1)
        if np.isnan(apart[[0, 1], nearest]).any():  # damaged: the others tell
            nearest = np.nanargmin(apart, axis=1)
        first, last = nearest.tolist()
        return slice(first, last + 1)

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        return self.in_nip.stop - self.in_nip.start

    @property
    def slip_zone(self) -> Zone:
        """The way the web slips on the roll at the nip's trailing edge."""
        return Zone(int(self.roll_zone[self.in_nip.stop - 1]))

    @cached_property
    def layer_slip(self) -> LayerSlip | None:
        """Index of slip between the layers of the roll, which the model takes as bonded.

        None of a roll whose interior stresses are not known (rigid, viscoelastic).  A ratio above
        1 issues a :class:`~woundon.errors.ValidityWarning`.
        """
        from .layer_slip import layer_slip  # imported late: it is not part of every report

        found = layer_slip(self)
        warn([found.warning] if found and found.warning else ())
        return found

    def sensitivity(self, *parameters: str, outputs: Sequence[str] = ()) -> Sensitivity:
        """Return exact derivatives of outputs with respect to fields of the problem.

        Parameters
        ----------
        parameters : str
            Dotted names (``"roll.material.shear"``); every continuous field if none is given.
        outputs : sequence of str
            Names; the main ones if none is given.
        """
        outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        # imported late: many results are never differentiated
        from .certificate import solutions
        from .sensitivity import contact_sensitivity

        return contact_sensitivity(
            self, solutions(self), parameters, outputs, self.DIFFERENTIATED, self._excluded
        )

    @property
    def _excluded(self) -> dict[str, str]:
        """Fields without a derivative, with the reason."""
        text = "0 has no derivative: with a wrap the path of the web changes"
        return {
            name: text for name in ("roll_wrap", "drum_wrap")
            if getattr(self.problem, name, None) == 0
        }  # fmt: skip

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


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NipResult(WindingNipResult):
    """The state of a winding nip, the web held to the roll at its trailing edge (thesis eq. 97).

    Attributes
    ----------
    problem : NipProblem
    nip_induced_tension : float
        NIT = Q+ + Q- [N/m], the integral of the tractions.

    The others as of :class:`WindingNipResult`.
    """

    MAIN: ClassVar[tuple[str, ...]] = ("nip_induced_tension",)
    DIFFERENTIATED: ClassVar[tuple[str, ...]] = (
        "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width", "drum_creep",
    )  # fmt: skip
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({
        "wound_on_tension": "a nip alone has tension_behind_nip (at its trailing edge) and "
        "wound_on_tension_estimate(angle) by eq. (183); the wound-on tension itself is that of "
        "problem.wrapped()",
    })  # fmt: skip
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset({"rolling_resistance"})

    problem: NipProblem
    nip_induced_tension: Annotated[float, line_load("NIT", "nip-induced tension")]

    @property
    def in_nip(self) -> slice:
        """All nodes."""
        return slice(0, self.x.size)

    @property
    def nip_induced_tension_error(
        self,
    ) -> Annotated[
        float, line_load("NIT error", "estimated discretisation error of the nip-induced tension")
    ]:
        """Estimated discretisation error of NIT [N/m]; nan where only one grid was solved."""
        return self.errors.get("nip_induced_tension", float("nan"))

    @property
    def tension_behind_nip(
        self,
    ) -> Annotated[float, line_load("T_out", "web tension at the trailing edge of the nip")]:
        """T_out = T_in + NIT [N/m]."""
        return float(self.problem.web_tension + self.nip_induced_tension)

    def wound_on_tension_estimate(
        self, angle: float = pi
    ) -> Annotated[
        float, line_load("WOT est.", "wound-on tension estimated by eq. (183), half a turn behind")
    ]:
        """Return the tension of a web that sticks to the roll behind the nip (thesis eq. 183).

        Parameters
        ----------
        angle : float
            Where the web is held, or led off the roll, behind the nip [rad].

        Returns
        -------
        float
            T_out + 2h/c11 [eps1(angle) - eps1(a)] [N/m].  With the confined ``tension_behind_nip``
            it brackets the wound-on tension of the wrapped nip.
        """
        from .roll_strain import wound_on_tension_estimate

        return wound_on_tension_estimate(self, angle)

    @property
    def rig_tension(
        self,
    ) -> Annotated[
        float,
        line_load(
            "T_rig", "tension at a load cell to which the web is led off the roll, eq. (183)"
        ),
    ]:
        """The estimate (183) where the web leaves the roll a quarter turn behind the nip [N/m]."""
        return self.wound_on_tension_estimate(RIG_ANGLE)

    @property
    def wound_on_tension(self) -> NoReturn:
        """Not a nip's alone: the error names what it has instead."""
        raise AttributeError(f"no wound_on_tension: {self.REPLACED['wound_on_tension']}")


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

    The others as of :class:`WindingNipResult`; slips are nan where the web does
    not touch the body.
    """

    MAIN: ClassVar[tuple[str, ...]] = ("wound_on_tension",)
    DIFFERENTIATED: ClassVar[tuple[str, ...]] = (
        "wound_on_tension", "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width",
        "drum_creep",
    )  # fmt: skip
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({
        "nip": "take the nodes in_nip of the arrays, or confined() for the nip alone",
        "rig_tension": "the wrapped web's wound_on_tension is what a load cell at roll_wrap reads",
        "wound_on_tension_estimate": "the wrapped web's wound_on_tension is solved, not estimated",
    })  # fmt: skip
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset(
        {"roll_slip", "drum_slip", "roll_strain", "rolling_resistance"}
    )

    problem: WrappedNipProblem
    roll_pressure: Annotated[Array, stress("p+", "pressure of the web on the roll")]
    hoop_pressure: Annotated[Array, stress("p_h", "hoop pressure, web tension times curvature")]
    curvature: Annotated[
        Array, Quantity("kappa", "1/m", "curvature of the web, > 0: centre in the roll")
    ]
    roll_strain: Annotated[Array, strain("eps1", "strain of the roll's surface along the web")]

    @property
    def wound_on_tension(
        self,
    ) -> Annotated[float, line_load("WOT", "wound-on tension, far behind the nip")]:
        """WOT, the tension at the far side of the roll [N/m]: what the roll keeps."""
        return float(self.web_tension[-1])

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
        return float(self.web_tension[self.in_nip.start])

    @property
    def tension_behind_nip(
        self,
    ) -> Annotated[float, line_load("T_out", "web tension at the trailing edge of the nip")]:
        """T_out at x = a [N/m]."""
        return float(self.web_tension[self.in_nip.stop - 1])

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
                Of :func:`woundon.solve`.

        Raises
        ------
        NoSteadyState
            If the nip alone cannot carry the winding force.
        """
        return kinds.solve(self.problem.confined(), **options)

"""The state of a winding nip: what it has with and without its wraps, and the plain one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NoReturn

import numpy as np

from .. import kinds
from ..losses import Losses
from ..problems.nip import NipProblem
from ..quantities import length, line_load, pure, strain, stress
from ..results import Residuals, Result, Zone

if TYPE_CHECKING:
    from .sensitivity import Sensitivity

__all__ = ["NipResult", "SlipRatios", "WindingNipResult"]

Array = np.ndarray

RIG_ANGLE = pi / 2  # behind the nip, where the laboratory winder leads the web to its load cell


@dataclass(frozen=True)
class SlipRatios:
    """Slip lengths over the nip width, > 0 where the web is the faster one (thesis eq. 172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WindingNipResult(Losses, Result):
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
    scheme, algorithm : str
        How it was solved.
    iterations : int
        Number of linear stick-slip systems solved.
    series_terms, series_error : int, float
        Fourier terms summed for the bodies, their estimated relative truncation error.
    mesh : Mesh
        On which it was solved.
    widths : Widths
        The half widths of all meshes: what a neighbouring case starts from.
    """

    DIFFERENTIATED: ClassVar[str]  # where its derivatives are found
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
    scheme: str = "graded"
    algorithm: str = "pivoting"
    iterations: Annotated[int, pure("n_it", "linear stick-slip systems solved")] = 0
    series_terms: Annotated[int, pure("n_s", "Fourier terms summed")] = 0
    series_error: Annotated[float, pure("e_s", "estimated truncation error of the series")] = 0.0
    mesh: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})
    widths: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})
    refinement: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})
    consistency: Mapping[str, float] = field(
        default_factory=dict, repr=False, compare=False, metadata={"saved": False}
    )

    @property
    def nip_width(self) -> Annotated[float, length("2a", "nip width")]:
        """2a [m]."""
        return 2 * self.half_width

    @property
    def peak_pressure(self) -> Annotated[float, stress("p_max", "largest pressure")]:
        """Largest pressure [Pa]: at a node, or of the polynomials of elements."""
        from ..two_bodies import mesh_of

        if self.refinement is not None:
            return float(self.pressure.max())
        return mesh_of(self).peak(self.pressure[1:-1])

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

    def sensitivity(self, *parameters: str, outputs: Sequence[str] = ()) -> Sensitivity:
        """Return exact derivatives of outputs with respect to fields of the problem.

        Parameters
        ----------
        parameters : str
            Dotted names (``"roll.material.shear"``); every continuous field if none is given.
        outputs : sequence of str
            Names; the main ones if none is given.  Of a nip alone ``"rig_tension"`` too.
        """
        outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        found: Sensitivity = kinds.fetch(self.DIFFERENTIATED)(self, parameters, outputs)
        return found


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class NipResult(WindingNipResult):
    """The state of a winding nip, the web held to the roll at its trailing edge (thesis eq. 97).

    Attributes
    ----------
    problem : NipProblem
    nip_induced_tension : float
        NIT = Q+ + Q- [N/m]: the integral of the tractions, plus ``extrapolation``.
    extrapolation : float
        What is added to that integral [N/m]: on graded meshes for where borders of stick and jumps
        come to rest within their cells and for what these miss at the trailing edge, with ``rtol``
        what extrapolation to zero cells adds.  It is about as large as the told error; 0 on
        elements, and by the thesis's scheme.

    The others as of :class:`WindingNipResult`.
    """

    MAIN: ClassVar[tuple[str, ...]] = ("nip_induced_tension",)
    DIFFERENTIATED: ClassVar[str] = "woundon.nip.sensitivity:nip_sensitivity"
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({
        "wound_on_tension": "a nip alone has tension_behind_nip (at its trailing edge) and "
        "wound_on_tension_estimate(angle) by eq. (183); the wound-on tension itself is that of "
        "problem.wrapped()",
    })  # fmt: skip
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset({"rolling_resistance"})

    problem: NipProblem
    nip_induced_tension: Annotated[float, line_load("NIT", "nip-induced tension")]
    extrapolation: Annotated[
        float, line_load("dNIT", "part of it beyond the integral of the tractions")
    ] = 0.0

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
        estimate = kinds.fetch("woundon.nip.roll_surface:wound_on_tension_estimate")
        return float(estimate(self, angle))

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

    def certified(self) -> Residuals:
        """Return the certificate measured anew, from the problem and the arrays held here."""
        from .certificate import certificate, matrices_of

        if self.refinement is not None:
            from ..web_nip.certificate import certificate as certified
            from ..web_nip.certificate import equations_of

            return certified(self, equations_of(self))
        return certificate(self, matrices_of(self))

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
        told: Mapping[str, tuple[float, float]] = kinds.fetch("woundon.nip.solve:recomputed")(self)
        return told

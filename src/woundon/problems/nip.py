"""The winding nip: a web between wound roll and winding drum, which may be wrapped on both."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import InitVar
from functools import cached_property
from itertools import chain
from math import pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem, NoSteadyState
from ..quantities import angle, length, line_load, pure, tension, velocity
from . import wound_roll as wound_roll  # registers its body
from .air import Air
from .assumptions import of_nip
from .bodies import AnyBody, Body, Cylinder, Rigid
from .consistency import different_moduli
from .contact_problem import ContactProblem
from .fields import Nested, Number, OptionalNested, OptionalNumber, default
from .finished_roll import OF_FINISHED_ROLL
from .materials import material
from .next_nip import NextNips
from .permitted import Conditional
from .problem import only_in
from .stack import Stack
from .web import Web, WebDensity, centrifugal_stress

if TYPE_CHECKING:
    from .grades import Grade

__all__ = [
    "WRAP_TABLE",
    "DrumFriction",
    "DrumWrap",
    "NipProblem",
    "OptionalDrumFriction",
    "RollFriction",
    "RollWrap",
    "Width",
    "WrapFriction",
    "friction_capacity",
    "slack_on_drum",
]

LEAST_FRICTION = 1e-8  # below, rounding errors decide between stick and slip
_FRICTION = Field(ge=LEAST_FRICTION, le=10.0)
_ROUND = 1 + 1e-12  # an angle in degrees may be rounded up
_HALF_TURN = Field(ge=0, le=pi * _ROUND)

Width = Annotated[
    OptionalNumber, length("w", "width of the web", "m", (0.2, 10.0)), Field(gt=0, le=100)
]

# Fields that nips and windings share.
RollFriction = Annotated[
    Number, pure("mu+", "friction coefficient of web and roll", (0.1, 0.6)), _FRICTION
]
DrumFriction = Annotated[
    Number, pure("mu-", "friction coefficient of web and drum", (0.1, 0.6)), _FRICTION
]
OptionalDrumFriction = Annotated[
    OptionalNumber, pure("mu-", "friction coefficient of web and drum", (0.1, 0.6)), _FRICTION
]
_ROLL_WRAP = angle("theta+", "wrap angle on the roll downstream of the nip", (0.0, pi))
RollWrap = Annotated[Number, _ROLL_WRAP, _HALF_TURN]
DrumWrap = Annotated[
    Number, angle("theta-", "wrap angle on the drum upstream of the nip", (0.0, pi)), _HALF_TURN
]
WrapFriction = Annotated[
    OptionalNumber,
    pure("mu_w+", "friction coefficient on the roll wrap", (0.1, 0.6)),
    Field(ge=1e-6, le=10.0),
]
WRAP_TABLE: Mapping[str, tuple[str, ...]] = {"wrap": ("roll_wrap", "drum_wrap", "wrap_friction")}


def friction_capacity(
    nip_load: float | np.ndarray,
    hoop_tension: float | np.ndarray,
    drum_friction: float,
    drum_wrap: float,
) -> tuple[float | np.ndarray, float | np.ndarray]:
    """Return the smallest and the largest winding force that friction on the drum transmits [N/m].

    It is mu P in the nip, and (T_in - m V^2) (exp(+-mu theta) - 1) on the drum wrap (Euler-
    Eytelwein).

    Parameters
    ----------
    nip_load, hoop_tension : float or array
        P, and T_in - m V^2 upstream of the drum wrap [N/m], which presses the web on the drum.
    drum_friction : float
        mu between web and drum [1].
    drum_wrap : float
        theta [rad].
    """
    nip, wrap = drum_friction * nip_load, drum_friction * drum_wrap
    return -nip + hoop_tension * np.expm1(-wrap), nip + hoop_tension * np.expm1(wrap)


def slack_on_drum(web_tension: float, centrifugal: float, place: str = "") -> InvalidProblem:
    """Return the error for a web whose tension does not hold it on the drum wrap.

    Parameters
    ----------
    web_tension, centrifugal : float
        T_in and m V^2 [N/m].
    place : str
        Where it is slack, with a space before it.
    """
    needed = f"{centrifugal:.6g} [N/m], its centrifugal force" if centrifugal else "0 [N/m]"
    text = f"{web_tension:.6g}{place} is out of range; a web wrapped on the drum must be taut, > "
    return InvalidProblem.at("web_tension", text + needed)


class NipProblem(ContactProblem):
    """A winding nip in steady state, per metre of width (thesis ch. 3 and sec. 3.5).

    The web runs over the drum (``drum_wrap``), through the nip and onto the roll (``roll_wrap``).
    Downstream of the nip it slips on the roll as far as friction permits, and is held to the roll
    at the end of the roll wrap (thesis eq. 96); its tension there is the wound-on tension.  With
    ``roll_wrap=0`` it is held at the trailing edge of the nip (thesis eq. 97).

    Parameters
    ----------
    web : Web
    roll, drum : Rigid, HalfPlane, Cylinder or another Body
        Wound roll (body 1, +) and winding drum (body 2, -).
    roll_friction, drum_friction : float
        mu+ between the layers and mu- between web and drum, 1e-8 to 10, both without air.
    nip_load : float
        P [N/m], 1e-12 to 1e7.
    winding_force : float
        F = integral of q- on nip and drum wrap together = -M2/R2 [N/m]; F > 0: the drum brakes,
        F = 0: centre winding, F = -web_tension: surface winding.  In the nip
        |F| < mu- P; a drum wrap carries mu- P + (T_in - m V^2) (exp(mu- drum_wrap) - 1).
    web_tension : float
        T_in upstream of drum wrap and nip [N/m], >= 0; > m V^2 with a drum wrap.
    roll_wrap : float
        Angle from the line of centres to where the web is held to the roll [rad]: 0, or from 2 % of
        the half width downstream of the trailing edge to pi.
        Behind ``next_nips`` it goes on for at most pi after the last one, less than 2 pi in all.
    drum_wrap : float
        Angle of the arc on which the web lies on the drum upstream of the nip [rad], 0 to pi.
    wrap_friction : float, optional
        mu+ on the roll wrap, 1e-6 to 10; ``roll_friction`` if None.
    web_speed : float, optional
        V of web, roll and drum [m/s]; required with ``air`` (0: a film of no thickness) and with
        viscoelastic bodies (> 0).  With a density the web carries its centrifugal force m V^2.
        Otherwise nothing depends on it, and the report says so.
    density : float, optional
        Density [kg/m^3] or basis weight, "45 gsm", of the web; with ``web_speed`` it presses on
        what it is wrapped on with (T - m V^2)/R, m = density * web.thickness.
    air : Air, optional
        The air that the web entrains, which reduces the friction.
    next_nips : sequence of NextNip, optional
        Further nips through which the laid web runs: front drum and rider roll.
    width : float, optional
        Of the web [m].  With it, loads and tensions may be entered as totals, "3.6 kN"; they are
        held per metre of width.

    Raises
    ------
    InvalidProblem
        Naming every field, value and permitted range.
    NoSteadyState
        If the drum slips in the nip and on its wrap (capstan equation, thesis eq. 179).

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example()
    >>> problem.nip_load, problem.roll_wrap, problem.air
    (3502.0, 3.141592653589793, None)
    """

    graded: ClassVar[tuple[str, ...]] = ("web", "roll", "roll_friction", "drum_friction", "density")
    pair: ClassVar[tuple[str, str]] = ("roll", "drum")
    speed_field: ClassVar[str] = "web_speed"
    tables: ClassVar[Mapping[str, tuple[str, ...]]] = WRAP_TABLE
    counterparts: ClassVar[Mapping[str, str]] = {
        "torque_split": "give winding_force = -torque_split * web_tension [N/m]",
        "tangential_load": "give winding_force",
        "creepage": "it is an output, drum_creepage",
        "upper": "give roll",
        "lower": "give drum",
        "radius": "give roll.radius",
        "core": "give roll.core_radius",
        "stack": "give roll.stack of a wound roll, or web.material",
        "web_thickness": "give web.thickness",
        "wound_on_tension": "it is an output",
        "winder": "give next_nips, the nips of front drum and rider",
        "nip_induced_tension": "it is an output; a WindingProblem may prescribe it",
        "roll_body": "give roll, a cylinder or a wound roll",
        **only_in("WindingProblem", "tension_law", "limits"),
        **only_in("WindingProblem", "gauge_excess", "caliper_pressure"),
        **only_in("WindingProblem", "thickness_profile", "oscillation"),
        **only_in("WindingProblem", "drum_bending", "core_bending", "inertia"),
        **only_in("RollProblem or WindingProblem", *OF_FINISHED_ROLL),
        **only_in("RollerProblem", "motion"),
    }

    # Fields that the grade supplies are required without one; type checkers must accept both.
    if TYPE_CHECKING:
        grade: InitVar[Grade | str | Mapping[str, Any]] = Field(...)
    web: Annotated[Nested[Web], Field(description="the paper or film")] = Field(...)
    roll: Annotated[AnyBody, Field(description="the wound roll")]
    drum: Annotated[AnyBody, Field(description="the winding drum")]
    roll_friction: RollFriction = Field(...)
    drum_friction: DrumFriction = Field(...)
    nip_load: Annotated[Number, line_load("P", "nip load", (500.0, 10e3)), Field(ge=1e-12, le=1e7)]
    winding_force: Annotated[
        Number,
        line_load("F", "winding force (drum traction resultant), F = -M2/R2", (-500.0, 500.0)),
        Field(ge=-1e7, le=1e7),
    ] = default(0.0)
    web_tension: Annotated[
        Number,
        tension("T_in", "web tension upstream of the nip", (50.0, 1000.0)),
        Field(ge=0, le=1e6),
    ] = default(0.0)
    roll_wrap: Annotated[Number, _ROLL_WRAP, Field(ge=0, le=2 * pi * _ROUND)] = default(pi)
    drum_wrap: DrumWrap = default(0.0)
    wrap_friction: WrapFriction = default(None)
    web_speed: Annotated[
        OptionalNumber,
        velocity("web speed", (1.0, 50.0)),
        Field(ge=0, le=1e4),
        Conditional("required with air or a viscoelastic body"),
    ] = default(None)
    density: WebDensity = default(None)
    air: Annotated[OptionalNested[Air], Field(description="entrained air")] = default(None)
    next_nips: Annotated[
        NextNips, Field(max_length=5, description="further nips of the laid web, in its direction")
    ] = default(())
    width: Width = default(None)

    @model_validator(mode="after")
    def _check_web(self) -> Self:
        """Reject a viscoelastic web."""
        if self.web.material.relaxes:
            raise InvalidProblem.at("web.material", "viscoelastic; must be elastic (no prony)")
        return self

    @model_validator(mode="before")
    @classmethod
    def _check_friction(cls, fields: Any) -> Any:
        """Reject a face without friction: its web speed is not determined.

        This runs before the range of the field is checked, whose message would not say why.
        """
        for name in ("roll_friction", "drum_friction"):
            if (
                isinstance(fields, dict)
                and type(fields.get(name)) in (int, float)
                and not fields[name]
            ):
                raise InvalidProblem.at(
                    name,
                    f"0 is out of range; must be >= {LEAST_FRICTION:g} and <= 10: without "
                    "friction the web speed relative to the "
                    f"{name.partition('_')[0]} is undetermined; use the smallest allowed value to "
                    "represent the frictionless limit",
                )
        return fields

    @model_validator(mode="after")
    def _check_next_nips(self) -> Self:
        """Reject nips beyond the roll wrap, a longer wrap than their model, and slipping drums."""
        arc = sum(nip.angle for nip in self.next_nips)
        low, high = arc, min(arc + pi, 2 * pi)
        if not self.next_nips and self.roll_wrap > high * _ROUND:
            text = f"{self.roll_wrap:.6g} is out of range; must be >= 0 and <= {high:.6g} [rad]"
            raise InvalidProblem.at("roll_wrap", text)
        if self.next_nips and not low < self.roll_wrap <= high * _ROUND:
            raise InvalidProblem.at(
                "roll_wrap",
                f"{self.roll_wrap:.6g} is out of range; must be > {low:.6g}, the sum of the angles "
                f"of next_nips, and <= {high:.6g} [rad]",
            )
        for k, nip in enumerate(self.next_nips):
            capacity = self.drum_frictions[k + 1] * nip.nip_load
            if not abs(nip.winding_force) < capacity:
                raise NoSteadyState.at(
                    f"next_nips.{k}.winding_force",
                    f"{nip.winding_force:.10g} is out of range; must be > {-capacity:.10g} and < "
                    f"{capacity:.10g} [N/m], the friction capacity drum_friction * nip_load; "
                    "otherwise the drum slips",
                )
        return self

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        name = "stack" if hasattr(self.roll, "stack") else "material"
        layers = getattr(self.roll, name, None)
        return (
            *super().input_warnings,
            *different_moduli(self.web, f"roll.{name}", layers),
            *chain.from_iterable(
                stack.input_warnings(field)
                for field, stack in (("web.material", self.web.material), (f"roll.{name}", layers))
                if isinstance(stack, Stack)
            ),
        )

    @model_validator(mode="after")
    def _check_steady_state(self) -> Self:
        """Reject a slack web on a drum wrap, and a winding force that exceeds the friction."""
        if self.drum_wrap > 0 and self.hoop_tension <= 0:
            raise slack_on_drum(self.web_tension, self.centrifugal_tension)
        low, high = friction_capacity(
            self.nip_load, self.hoop_tension, self.drum_friction, self.drum_wrap
        )
        if not low < self.winding_force < high:
            raise NoSteadyState.at(
                "winding_force",
                f"{self.winding_force:.10g} is out of range; must be > {low:.10g} and < "
                f"{high:.10g} [N/m], the friction capacity of the nip (drum_friction * nip_load) "
                "and the drum wrap; otherwise the drum slips",
            )
        return self

    @model_validator(mode="after")
    def _check_speed(self) -> Self:
        """Reject a speed of zero with viscoelastic bodies."""
        if self.web_speed == 0 and self.viscoelastic:
            uses = next(text for _, text in super().uses_of_speed())  # of the bodies, not of air
            raise InvalidProblem.at("web_speed", f"0 is out of range; must be > 0 [m/s], as {uses}")
        return self

    @model_validator(mode="after")
    def _check_air(self) -> Self:
        """Reject air with a surface rougher than the web, or between rigid bodies."""
        if self.air is not None:
            for field, text in self.air.too_rough(self.web.thickness):
                raise InvalidProblem.at(f"air.{field}", text)
            if not (self.roll.compliance + self.drum.compliance) > 0:
                raise InvalidProblem.at(
                    "roll",
                    "is rigid, and so is the drum; one of them must be elastic for a nip with air",
                )
        return self

    def uses_of_speed(self) -> Iterator[tuple[str, str]]:
        """Yield (field, reason) for entrained air and viscoelastic bodies."""
        if self.air is not None:
            yield "air", "the web entrains air"
        yield from super().uses_of_speed()

    @cached_property
    def centrifugal_tension(self) -> float:
        """m V^2 of the web [N/m]; 0 without web speed or density."""
        return centrifugal_stress(self.density, self.web_speed) * self.web.thickness

    @property
    def hoop_tension(self) -> float:
        """T_in - m V^2, with which the web presses on what it is wrapped on [N/m]."""
        return self.web_tension - self.centrifugal_tension

    @property
    def speed_has_effect(self) -> bool:
        """True with a density, entrained air or a viscoelastic body."""
        return self.density is not None or super().speed_has_effect

    @cached_property
    def linear(self) -> bool:
        """True if the bodies and the web are linear."""
        return self.web.linear and super().linear

    @property
    def named_bodies(self) -> dict[str, Body]:
        """Roll, drum and the drums of further nips by their dotted names."""
        further = {f"next_nips.{k}.drum": nip.drum for k, nip in enumerate(self.next_nips)}
        return super().named_bodies | further

    @property
    def thinning(self) -> float:
        """-2h c22, thickness change of the unloaded web per pressure [m/Pa]."""
        return -self.web.thickness * self.web.compliance.c22

    @property
    def drum_frictions(self) -> tuple[float, ...]:
        """mu- of the drum of each nip, the first one and those of ``next_nips``."""
        mu = self.drum_friction
        own = (nip.drum_friction for nip in self.next_nips)
        return (mu, *(mu if each is None else each for each in own))

    @property
    def friction_on_wrap(self) -> float:
        """mu+ on the roll wrap."""
        return self.roll_friction if self.wrap_friction is None else self.wrap_friction

    @property
    def is_wrapped(self) -> bool:
        """True if the roll wrap or the drum wrap is not zero."""
        return self.roll_wrap > 0 or self.drum_wrap > 0

    def without_air(
        self, roll_friction: float | None = None, wrap_friction: float | None = None
    ) -> Self:
        """Return the nip without air, with other friction coefficients in the nip and on the wrap.

        Parameters
        ----------
        roll_friction, wrap_friction : float, optional
            Effective coefficients with the air film; by default those of this problem.
        """
        if self.air is None:
            return self
        changes: dict[str, Any] = {"air": None}
        if not self.viscoelastic and self.density is None:
            changes["web_speed"] = None  # only the air depends on it
        if roll_friction is not None and roll_friction != self.roll_friction:
            changes["roll_friction"] = roll_friction
        if wrap_friction is not None and wrap_friction != self.friction_on_wrap:
            changes["wrap_friction"] = wrap_friction
        elif "roll_friction" in changes:  # which the friction on the wrap would follow
            changes["wrap_friction"] = self.friction_on_wrap
        return self.replace(**changes)

    @property
    def unused(self) -> tuple[str, ...]:
        """See :attr:`.Problem.unused`."""
        # a frozen roll has G at the pressure wound in, on which the exponent has no effect
        frozen = (
            f"{name}.stack.shear_exponent"
            for name in self.pair
            if getattr(getattr(self, name), "hardening", "") == "frozen"
        )
        return (
            "web.material.shear_exponent",
            *frozen,
            *(("density",) if self.web_speed is None else ()),
        )

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return of_nip(self)

    @classmethod
    def example(cls) -> Self:
        """Return newsprint on a hard drum (thesis Table 2)."""
        newsprint = material("newsprint")
        return cls(
            web=Web(thickness=66e-6, material=newsprint),
            roll=Cylinder(radius=0.1, core_radius=0.0445, material=newsprint),
            drum=Rigid(radius=0.0762),
            roll_friction=0.19,
            drum_friction=0.2,
            nip_load=3502.0,
            winding_force=0.0,
            web_tension=350.0,
        )

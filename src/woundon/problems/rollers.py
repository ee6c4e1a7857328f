"""Two rollers in contact without a web."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from ..errors import InvalidProblem, NoSteadyState
from ..quantities import line_load, pure, strain, velocity
from .assumptions import of_rollers
from .bodies import AnyBody, HalfPlane
from .contact_problem import ContactProblem
from .fields import Number, OptionalNumber, default
from .finished_roll import OF_FINISHED_ROLL
from .materials import material
from .nip import LEAST_FRICTION, WRAP_TABLE
from .permitted import Conditional
from .problem import only_in

__all__ = ["RollerProblem"]


class RollerProblem(ContactProblem):
    """Two rollers in contact without a web, rolling or static, per metre of width.

    Parameters
    ----------
    upper, lower : Rigid, HalfPlane, Cylinder or another Body
    load : float
        P [N/m], 1e-12 to 1e9.
    friction : float
        mu, 1e-8 to 10; 0 is the frictionless (Hertz) problem.
    tangential_load : float, optional
        Q, resultant of the traction on the upper roller along +x [N/m]; |Q| < mu P.  0 by default.
    creepage : float, optional
        xi [1], instead of the tangential load; rolling only.
    motion : {"rolling", "static"}
        Rolling along the material flow +x, or a monotone static load.
    speed : float, optional
        V of both surfaces [m/s]; needed if a roller is viscoelastic.

    Raises
    ------
    InvalidProblem
        Naming every invalid field with its value and permitted range.
    NoSteadyState
        If |Q| >= mu P: the rollers slip.

    Examples
    --------
    >>> import woundon as wo
    >>> steel = wo.HalfPlane(radius=0.25, material="steel")
    >>> wo.RollerProblem(upper=steel, lower=steel, load="89 kN/m", friction=0.5).motion
    'rolling'
    """

    pair: ClassVar[tuple[str, str]] = ("upper", "lower")
    speed_field: ClassVar[str] = "speed"
    counterparts: ClassVar[Mapping[str, str]] = {
        "roll": "give upper",
        "drum": "give lower",
        "roll_friction": "give friction",
        "drum_friction": "give friction",
        "nip_load": "give load",
        "winding_force": "give tangential_load",
        "web_speed": "give speed",
        "radius": "give upper.radius and lower.radius",
        "core": "give upper.core_radius",
        "stack": "give upper.stack of a wound roll",
        **only_in(
            "NipProblem", "next_nips", "web", "web_tension", "air", "width", *WRAP_TABLE["wrap"]
        ),
        **only_in("RollProblem", "web_thickness", "wound_on_tension"),
        **only_in("RollProblem or WindingProblem", *OF_FINISHED_ROLL),
        **only_in("WindingProblem", "torque_split", "roll_body", "tension_law", "limits"),
        **only_in("WindingProblem", "nip_induced_tension", "winder"),
        **only_in("WindingProblem", "density", "gauge_excess", "caliper_pressure"),
        **only_in("WindingProblem", "thickness_profile", "oscillation"),
        **only_in("WindingProblem", "drum_bending", "core_bending", "inertia"),
    }

    upper: Annotated[AnyBody, Field(description="the upper roller")]
    lower: Annotated[AnyBody, Field(description="the lower roller")]
    load: Annotated[Number, line_load("P", "load", (1e3, 1e6)), Field(ge=1e-12, le=1e9)]
    friction: Annotated[
        Number, pure("mu", "friction coefficient of the rollers", (0.05, 1.0)), Field(ge=0, le=10.0)
    ]
    tangential_load: Annotated[OptionalNumber, line_load("Q", "tangential load")] = default(None)
    creepage: Annotated[OptionalNumber, strain("xi", "creepage"), Field(gt=-0.5, lt=0.5)] = default(
        None
    )
    motion: Annotated[Literal["rolling", "static"], Field(description="motion of the rollers")] = (
        "rolling"
    )
    speed: Annotated[
        OptionalNumber,
        velocity("surface speed", (0.1, 50.0)),
        Field(gt=0, le=1e4),
        Conditional("required with a viscoelastic roller"),
    ] = default(None)

    @model_validator(mode="after")
    def _check_loads(self) -> Self:
        """Reject loads without a steady state, and inputs that contradict each other."""
        if self.creepage is not None and self.tangential_load is not None:
            raise InvalidProblem.at(
                "creepage",
                f"{self.creepage:.10g} is given together with tangential_load = "
                f"{self.tangential_load:.10g}; must be one of the two",
            )
        if self.creepage is not None and self.motion == "static":
            raise InvalidProblem.at(
                "creepage",
                f"{self.creepage:.10g} is given, but a static contact has no creepage; "
                "omit it, or set motion = 'rolling'",
            )
        if self.viscoelastic and self.motion == "static":
            raise InvalidProblem.at(
                "motion",
                "'static' is out of place; must be 'rolling': the response of a "
                "viscoelastic roller to a static load depends on time",
            )
        if 0 < self.friction < LEAST_FRICTION:
            raise InvalidProblem.at(
                "friction", f"{self.friction:.10g} is out of range; must be 0 or >= 1e-08 and <= 10"
            )
        if not self.friction and self.tangential_load:
            raise NoSteadyState.at(
                "tangential_load",
                f"{self.tangential_load:.10g} is out of range; must be 0 or omitted for "
                "rollers without friction",
            )
        limit = self.friction * self.load
        if self.tangential_load and abs(self.tangential_load) >= limit:
            raise NoSteadyState.at(
                "tangential_load",
                f"{self.tangential_load:.10g} is out of range; "
                f"|tangential_load| must be < friction * load = {limit:.10g} [N/m], "
                "otherwise the rollers slip",
            )
        return self

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return of_rollers(self)

    @classmethod
    def example(cls) -> Self:
        """Return two steel rollers, one braked (thesis ch. 1.2, Fig. 5)."""
        steel = HalfPlane(radius=0.25, material=material("steel"))
        return cls(upper=steel, lower=steel, load=89e3, tangential_load=8.4e3, friction=0.5)

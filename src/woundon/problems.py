"""The problems woundon solves, as immutable descriptions: a winding nip, two rollers."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from .bodies import AnyBody, Rigid
from .description import Description, Number
from .errors import InvalidProblem, NoSteadyState
from .materials import Material

__all__ = ["NipProblem", "RollerProblem", "Web"]


def _line_load(what: str, **kw: Any) -> Any:
    return Field(description=what, json_schema_extra={"unit": "N/m"}, **kw)


def _friction(what: str) -> Any:
    # below 1e-8 rounding decides on stick and slip
    return Field(description=what, ge=1e-8, le=10.0, json_schema_extra={"unit": "1"})


class Web(Description):
    """The paper or film web, a thin strip (thesis sec. 2.3).

    Parameters
    ----------
    thickness : float
        2h [m], 0.1 um to 10 mm.
    material : Orthotropic or Isotropic
        The web's own plane-strain stiffness.
    """

    thickness: Number = Field(
        description="web thickness 2h", ge=1e-7, le=1e-2, json_schema_extra={"unit": "m"}
    )
    material: Material


class NipProblem(Description):
    """A winding nip in steady state, per metre of width (thesis ch. 3).

    Parameters
    ----------
    web : Web
    roll, drum : Rigid, HalfPlane or Cylinder
        Wound roll (body 1, +) and winding drum (body 2, -).
    roll_friction, drum_friction : float
        mu+ between the layers and mu- between web and drum, 1e-8 to 10.
    nip_load : float
        P [N/m], 1e-12 to 1e7.
    winding_force : float
        F = integral of q- = -M2/R2 [N/m]; F > 0: the drum brakes, F = 0: centre winding,
        F = -web_tension: surface winding.  |F| < mu- P.
    web_tension : float
        T_in before the nip [N/m], >= 0.

    Raises
    ------
    InvalidProblem
        Naming every field, value and range at fault.
    NoSteadyState
        If |F| >= mu- P: the web would slide on the whole drum.
    """

    web: Web
    roll: AnyBody
    drum: AnyBody
    roll_friction: Number = _friction("mu+, friction between the layers")
    drum_friction: Number = _friction("mu-, friction between web and drum")
    nip_load: Number = _line_load("nip load P", ge=1e-12, le=1e7)
    winding_force: Number = _line_load("winding force F", default=0.0)
    web_tension: Number = _line_load("web tension T_in before the nip", default=0.0, ge=0, le=1e6)

    @model_validator(mode="after")
    def _has_steady_state(self) -> NipProblem:
        if isinstance(self.roll, Rigid) and isinstance(self.drum, Rigid):
            raise InvalidProblem.at(
                "roll", "roll and drum are both Rigid; one must be HalfPlane or Cylinder"
            )
        limit = self.drum_friction * self.nip_load
        if abs(self.winding_force) >= limit:
            raise NoSteadyState.at(
                "winding_force",
                f"{self.winding_force:.10g} is out of range; |winding_force| "
                f"must be < drum_friction * nip_load = {limit:.10g} [N/m], or the drum slides",
            )
        return self


class RollerProblem(Description):
    """Two rollers in contact without a web, rolling or static, per metre of width.

    Parameters
    ----------
    upper, lower : Rigid, HalfPlane or Cylinder
    load : float
        P [N/m], 1e-12 to 1e9.
    friction : float
        mu, > 0.
    tangential_load : float, optional
        Q, the traction on the upper roller along +x, integrated [N/m]; |Q| < mu P.  Zero if
        neither it nor ``creepage`` is given.
    creepage : float, optional
        xi [1], in place of the tangential load; rolling only.
    motion : {"rolling", "static"}
        Rolling along the material flow +x, or a monotone static load.

    Raises
    ------
    InvalidProblem
        Naming every field, value and range at fault.
    NoSteadyState
        If |Q| >= mu P: the rollers slide.
    """

    upper: AnyBody
    lower: AnyBody
    load: Number = _line_load("load P", ge=1e-12, le=1e9)
    friction: Number = _friction("mu, friction between the rollers")
    tangential_load: Number | None = _line_load("tangential load Q", default=None)
    creepage: Number | None = Field(
        default=None, description="creepage xi", gt=-0.5, lt=0.5, json_schema_extra={"unit": "1"}
    )
    motion: Literal["rolling", "static"] = "rolling"

    @model_validator(mode="after")
    def _has_a_state(self) -> RollerProblem:
        if isinstance(self.upper, Rigid) and isinstance(self.lower, Rigid):
            raise InvalidProblem.at(
                "upper", "upper and lower are both Rigid; one must be HalfPlane or Cylinder"
            )
        if self.creepage is not None and self.tangential_load is not None:
            raise InvalidProblem.at(
                "creepage",
                f"{self.creepage:.10g} is given beside tangential_load = "
                f"{self.tangential_load:.10g}; must be one of the two",
            )
        if self.creepage is not None and self.motion == "static":
            raise InvalidProblem.at(
                "creepage",
                f"{self.creepage:.10g} is given, but motion = 'static' has none; "
                "must be left out, or motion = 'rolling'",
            )
        limit = self.friction * self.load
        if abs(self.tangential_load or 0.0) >= limit:
            raise NoSteadyState.at(
                "tangential_load",
                f"{self.tangential_load:.10g} is out of range; "
                f"|tangential_load| must be < friction * load = {limit:.10g} [N/m], "
                "or the rollers slide",
            )
        return self

"""The bodies in contact, wound roll or drum: geometry and material in, surface response out.

Every body answers one question (the protocol :class:`Body`): what its surface does under a
line load.  The answer is a set of :class:`~woundon.elasticity.kernels.SurfaceKernels`; how they
are integrated over a grid is the business of :mod:`woundon.contact`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Protocol

from pydantic import Discriminator, Field, Tag, model_validator

from .description import Description, Number
from .elasticity import cylinder, half_plane
from .elasticity.kernels import SurfaceKernels
from .errors import InvalidProblem
from .materials import Material

__all__ = ["AnyBody", "Body", "Cylinder", "HalfPlane", "Rigid"]


# of the radius; a core that is smaller still is no other roll, but its powers overflow
SMALLEST_CORE = 1e-9


class Body(Protocol):
    """What the nip and the rollers need to know of a body."""

    @property
    def radius(self) -> float:
        """Outer radius R [m]; it enters the gap between the bodies."""
        ...

    @property
    def curvature(self) -> float:
        """1/R where the surface strain has the term v/R, 0 where it has not [1/m]."""
        ...

    def surface(self, reach: float) -> SurfaceKernels:
        """Return the response to line loads for distances up to ``reach`` [m] along the surface."""
        ...


def _radius(what: str) -> Any:
    return Field(description=what, gt=1e-4, le=50.0, json_schema_extra={"unit": "m"})


class Rigid(Description):
    """A rigid cylinder: it has a radius and does not deform.

    Parameters
    ----------
    radius : float
        R [m].
    """

    kind: Literal["rigid"] = Field(default="rigid", repr=False)
    radius: Number = _radius("outer radius R")

    @property
    def curvature(self) -> float:
        """0: no strain at all [1/m]."""
        return 0.0

    def surface(self, reach: float) -> SurfaceKernels:
        """Return the response of a body that does not deform: none."""
        return SurfaceKernels.zero()


class HalfPlane(Description):
    """An elastic half-plane (thesis sec. 2.1); its radius enters the gap only.

    Parameters
    ----------
    radius : float
        R [m].
    material : Orthotropic or Isotropic
    """

    kind: Literal["half_plane"] = Field(default="half_plane", repr=False)
    radius: Number = _radius("outer radius R")
    material: Material

    @property
    def curvature(self) -> float:
        """0: a half-plane's strain has no term v/R [1/m]."""
        return 0.0

    def surface(self, reach: float) -> SurfaceKernels:
        """Return the half-plane's response (thesis eq. 32), the same at any distance."""
        return half_plane.surface_kernels(*self.material.stiffness)


class Cylinder(Description):
    """An elastic cylinder on a rigid core (thesis sec. 2.2); a drum cover's core is the shell.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], 1e-9 R <= R0 <= 0.9995 R.
    material : Orthotropic or Isotropic

    Raises
    ------
    InvalidProblem
        For a core that is not smaller than the cylinder, or a layer thinner than R/2000.
    """

    kind: Literal["cylinder"] = Field(default="cylinder", repr=False)
    radius: Number = _radius("outer radius R")
    core_radius: Number = Field(
        description="radius R0 of the rigid core", gt=0, json_schema_extra={"unit": "m"}
    )
    material: Material

    @model_validator(mode="after")
    def _core_inside(self) -> Cylinder:
        least, limit = self.radius * SMALLEST_CORE, self.radius * (1 - 1 / 2000)
        if not least <= self.core_radius <= limit:
            raise InvalidProblem.at(
                "core_radius",
                f"{self.core_radius:.10g} is out of range; must be >= {SMALLEST_CORE:g} * radius "
                f"= {least:.10g} and <= 0.9995 * radius = {limit:.10g} [m]",
            )
        return self

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of the elastic layer [m]."""
        return self.radius - self.core_radius

    @property
    def curvature(self) -> float:
        """1/R [1/m]."""
        return 1 / self.radius

    def surface(self, reach: float) -> SurfaceKernels:
        """Return the cylinder's response (thesis eq. 59), series summed beyond the half-plane."""
        return cylinder.surface_kernels(
            self.radius, self.core_radius, *self.material.stiffness, reach=reach
        )


def _kind_of(value: Any) -> str | None:
    """Tell a body's kind; where none is said, its field names give it away."""
    if not isinstance(value, dict):
        return getattr(value, "kind", None)
    if "kind" in value:
        return str(value["kind"])
    # part of the name, so that a misspelt one still leads to the right list of fields
    if any("core" in str(name) for name in value):
        return "cylinder"
    return "half_plane" if "material" in value else "rigid"


AnyBody = Annotated[
    Annotated[Rigid, Tag("rigid")]
    | Annotated[HalfPlane, Tag("half_plane")]
    | Annotated[Cylinder, Tag("cylinder")],
    Discriminator(_kind_of),
]

"""The bodies in contact, wound roll and drum: geometry and material, and their surface response.

A body implements :meth:`Body.surface`: the slope and the strain of its surface under nodal
pressures and tractions (:class:`~woundon.elasticity.surface.SurfaceResponse`).  The bodies of this
module are linear and homogeneous along their circumference, so that influence functions describe
them (:class:`KernelBody`).

The set of bodies is open: a subclass of :class:`Body` is a body like these.
"""

from __future__ import annotations

from dataclasses import InitVar
from functools import cached_property
from math import inf, log1p, pi, sqrt
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, SerializeAsAny, model_validator

from ..elasticity import cylinder, half_plane, rolling
from ..elasticity.fourier import uniform_response
from ..elasticity.influence import InfluenceSurface
from ..elasticity.interior_stress import Section, cylinder_sections, half_plane_sections
from ..elasticity.kernels import SurfaceKernels
from ..elasticity.layers import stacked_compliance
from ..elasticity.surface import RigidSurface, SurfaceResponse
from ..errors import InvalidProblem
from ..quantities import length
from . import viscoelastic as viscoelastic  # it joins the materials
from .description import Description
from .family import Family
from .fields import Number
from .materials import AnyMaterial, Material

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from ..elasticity.layers import Layers as Stacked
    from ..elasticity.mesh import Face
    from .fields import CoercedField, Nested

__all__ = [
    "AnyBody",
    "Body",
    "CoreRadius",
    "Cylinder",
    "HalfPlane",
    "KernelBody",
    "Layer",
    "Layered",
    "Radius",
    "Rigid",
    "contact_radius",
    "core_inside",
    "half_width_guess",
]


# of the radius; a core that is smaller still is no other roll, but its powers overflow
SMALLEST_CORE = 1e-9
# Largest half width, in lengths on which the influence functions of a body vary: up to there their
# interpolation has at most 1200 points.
RESOLVED = 60
# of a truncated series, relative to the half-plane's response: above, nothing of it can be trusted
SERIES_ERROR = 1e-2

Radius = Annotated[Number, length("R", "outer radius", "mm", (0.02, 1.0)), Field(gt=1e-4, le=50.0)]

CoreRadius = Annotated[
    Number, length("R0", "radius of the rigid core", "mm", (0.02, 0.9)), Field(gt=0)
]


class Body(Family):
    """What nip and rollers need to know of a body; subclass it to add one.

    Attributes
    ----------
    radius : float
        Outer radius R [m]; it enters the gap between the bodies.
    rigid : bool
        Whether the surface does not deform at all.
    linear : bool
        Whether the response is the same about every state.
    caution : str
        What is to be said with every result, empty for nothing.
    viscoelastic : bool
        Whether its response depends on the speed at which it rolls.
    """

    # Required, but type checkers must accept a diameter in its place.
    radius: Radius = Field(...)
    if TYPE_CHECKING:
        diameter: InitVar[float | str] = Field(...)
    rigid: ClassVar[bool] = False
    linear: ClassVar[bool] = True
    caution: ClassVar[str] = ""

    @property
    def viscoelastic(self) -> bool:
        """Whether the response depends on the speed."""
        return False

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> SurfaceResponse:
        """Return the response of the surface on a face scaled by the half width.

        Parameters
        ----------
        face : Face
            Nodes of the tractions and points of slopes and strains, in units of the half width.
        half_width : float
            a [m].
        speed : float, optional
            Speed at which the surface rolls along +x [m/s]; elastic bodies do not depend on it.
        """
        raise NotImplementedError(f"{type(self).__name__} has no surface response")

    def uniform_strain(self, pressure: float) -> float:
        """Return the surface strain under a uniform pressure on the whole circumference.

        It is that of a roll under a closed layer of web; 0 for a body that does not define it.

        Parameters
        ----------
        pressure : float
            [Pa].
        """
        return 0.0

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses at depths below the surface; None of a body that does not know them.

        Parameters
        ----------
        x, p, q : (k,) arrays
            Nodes [m], pressures and tractions of the web on the body along +x [Pa].
        depths : (m,) array
            z [m], > 0 and less than the thickness.
        half_width : float
            a of the nip [m].
        """
        return None

    @property
    def curvature(self) -> float:
        """1/R where the surface strain has the term v/R, 0 where it has not [1/m]."""
        return 1 / self.radius

    @property
    def thickness(self) -> float:
        """Thickness of what deforms [m]: inf where it is deep."""
        return float("inf")

    @property
    def widest(self) -> float:
        """Largest half width of a contact on which the response is resolved [m]."""
        return float("inf")

    @property
    def unresolved(self) -> str:
        """Why the response is not resolved at all; '' where it is."""
        return ""

    @property
    def surface_material(self) -> Material | None:
        """The material at the surface, where the body is of linear elastic ones."""
        found = getattr(self, "material", None)
        return found if isinstance(found, Material) else None

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials that it is made of, where it says."""
        return ()

    @property
    def compliance(self) -> float:
        """C of the half-plane that the surface is near a line load (thesis eq. 30) [1/Pa].

        A contact's first guess of its width comes of it, nothing else.
        """
        material = self.surface_material
        return 0.0 if material is None else half_plane.coefficients(*material.stiffness).C

    def bending_load(self, contact_radius: float) -> float:
        """Return about the line load that bends an open tube off a gap 1/R* [N/m].

        inf of all other bodies.
        """
        return inf


if TYPE_CHECKING:
    AnyBody = Nested[Body]
else:
    AnyBody = Annotated[SerializeAsAny[Body], BeforeValidator(Body.coerce)]


class Rigid(Body):
    """A rigid cylinder: it has a radius and does not deform.

    Parameters
    ----------
    radius : float
        R [m].
    """

    rigid: ClassVar[bool] = True

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> RigidSurface:
        """Return a surface that does not deform."""
        return RigidSurface(face)


class KernelBody(Body, abstract=True):
    """A linear body told by the influence functions of its surface."""

    @cached_property
    def viscoelastic(self) -> bool:
        """Whether one of its materials is."""
        return any(material.relaxes for material in self.materials)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the influence functions, valid on the whole surface.

        Those of a viscoelastic body without a speed are of all that relaxes relaxed.
        """
        raise NotImplementedError

    def surface(
        self, face: Face, half_width: float, speed: float | None = None
    ) -> InfluenceSurface:
        """Return the response of the surface by its influence functions."""
        kernels = self.kernels(speed) if self.viscoelastic and speed else self.kernels()
        return InfluenceSurface(kernels, self.radius, self.curvature > 0, face, half_width)

    def uniform_strain(self, pressure: float) -> float:
        """Return the surface strain under a uniform pressure on the whole circumference.

        A viscoelastic body is fully relaxed: in the material the load is constant.
        """
        return pressure * uniform_response(self.kernels().strain_p)

    @property
    def widest(self) -> float:
        """Largest half width whose contact the smooth parts' interpolation resolves [m]."""
        return RESOLVED * self.kernels().length

    @property
    def unresolved(self) -> str:
        """Why the series of the influence functions is cut off too early; '' where it is not."""
        kernels = self.kernels()
        if kernels.truncation_error <= SERIES_ERROR:
            return ""
        return (
            f"the response of its layer, {self.thickness:.3g} m thick, takes more than "
            f"{kernels.terms} Fourier terms (they leave {kernels.truncation_error:.2g} of it); the "
            "layer must be thicker, or the stiffnesses of its material nearer to each other"
        )

    @property
    def compliance(self) -> float:
        """C of the half-plane that the surface is near a line load [1/Pa]."""
        return pi * self.kernels().slope_p.inverse


class HalfPlane(KernelBody):
    """An elastic half-plane (thesis sec. 2.1); its radius enters the gap only.

    Parameters
    ----------
    radius : float
        R [m].
    material : Orthotropic or Isotropic
    """

    material: AnyMaterial

    @property
    def curvature(self) -> float:
        """0: a half-plane's strain has no term v/R [1/m]."""
        return 0.0

    @property
    def materials(self) -> tuple[Material, ...]:
        """Its material."""
        return (self.material,)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the half-plane's influence functions (thesis eq. 32)."""
        stiffness = self.material.stiffness
        if speed is None:
            return half_plane.surface_kernels(*stiffness)
        reach = (pi + 1) * self.radius  # as far as a wrap goes
        return rolling.half_plane_kernels(stiffness, self.material.relaxation(speed), reach)

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses below the surface; None if the material is viscoelastic."""
        if self.viscoelastic:
            return None
        return half_plane_sections(x, p, q, depths, self.radius, self.material.stiffness)


class Cylinder(KernelBody):
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

    core_radius: CoreRadius = Field(...)
    if TYPE_CHECKING:
        core_diameter: InitVar[float | str] = Field(...)
    material: AnyMaterial

    @model_validator(mode="after")
    def _core_inside(self) -> Self:
        core_inside(self)
        return self

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of the elastic layer [m]."""
        return self.radius - self.core_radius

    @property
    def materials(self) -> tuple[Material, ...]:
        """Its material."""
        return (self.material,)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the cylinder's influence functions (thesis eq. 59)."""
        R, R0, stiffness = self.radius, self.core_radius, self.material.stiffness
        if speed is None:
            return cylinder.surface_kernels(R, R0, *stiffness)
        layer = (cylinder.depth(R, R0), *stiffness)
        return rolling.layered_kernels(R, (layer,), (self.material.relaxation(speed),))

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses below the surface; None if the material is viscoelastic."""
        if self.viscoelastic:
            return None
        layer = (cylinder.depth(self.radius, self.core_radius), *self.material.stiffness)
        return cylinder_sections(x, p, q, depths, self.radius, (layer,))


def core_inside(body: Any) -> None:
    """Refuse a core that is not smaller than its body, or leaves a layer thinner than R/2000.

    Raises
    ------
    InvalidProblem
    """
    least, limit = body.radius * SMALLEST_CORE, body.radius * (1 - 1 / 2000)
    if not least <= body.core_radius <= limit:
        raise InvalidProblem.at(
            "core_radius",
            f"{body.core_radius:.10g} is out of range; must be >= {SMALLEST_CORE:g} * radius "
            f"= {least:.10g} and <= 0.9995 * radius = {limit:.10g} [m]",
        )


class Layer(Description):
    """A layer of a :class:`Layered` body.

    Parameters
    ----------
    thickness : float
        h [m].
    material : Orthotropic or Isotropic
    """

    thickness: Annotated[
        Number, length("h", "thickness of the layer", "mm", (0.01e-3, 0.05)), Field(ge=1e-9, le=50)
    ]
    material: AnyMaterial


if TYPE_CHECKING:
    Layers = CoercedField[tuple[Layer, ...], Iterable[Layer | Mapping[str, Any]]]
else:
    Layers = tuple[Layer, ...]


class Layered(KernelBody):
    """An elastic cylinder of layers, as a covered shell or a core under a wound roll.

    Parameters
    ----------
    radius : float
        R [m].
    layers : sequence of Layer
        Outermost first.
    core : "rigid" or "free"
        What is below the innermost layer: a rigid core, or an open bore.  A bore is free of
        traction but for a uniform one, across or around, that holds what force and torque act on
        the surface; on average it does not move.

    Raises
    ------
    InvalidProblem
        For layers that are thicker than the radius, or thinner than R/2000 together.
    """

    layers: Annotated[Layers, Field(min_length=1, max_length=5000, description="outermost first")]
    core: Literal["rigid", "free"] = "rigid"

    @model_validator(mode="after")
    def _layers_fit(self) -> Self:
        least, most = self.radius / 2000, self.radius * (1 - SMALLEST_CORE)
        if not least <= self.thickness <= most:
            raise InvalidProblem.at(
                "layers",
                f"a thickness of {self.thickness:.10g} in all is out of range; must be >= radius "
                f"/ 2000 = {least:.10g} and < radius = {self.radius:.10g} [m]",
            )
        return self

    @cached_property
    def thickness(self) -> float:
        """Thickness of all layers [m]."""
        return sum(layer.thickness for layer in self.layers)

    @property
    def surface_material(self) -> Material:
        """The material of the outermost layer."""
        return self.layers[0].material

    @cached_property
    def _stack(self) -> Stacked:
        """The layers by the logarithms of their radii's ratios, and their stiffness."""
        outside, made = self.radius, []
        for layer in self.layers:
            made.append((-log1p(-layer.thickness / outside), *layer.material.stiffness))
            outside -= layer.thickness
        return tuple(made)

    @property
    def widest(self) -> float:
        """Any half width: kernels that are too short to interpolate are integrated exactly [m]."""
        return inf

    def bending_load(self, contact_radius: float) -> float:
        """Return about the line load that bends an open tube off a gap 1/R* [N/m].

        A thin ring of bending stiffness B, held around its bore, is made flatter by a line load P
        by P R/(pi B) sum_(n>1) 1/(n^2 - 1) = 3 P R/(4 pi B), and Y_2 = R^3/(9 B) tells its B.
        Where that is 1/R* the ring leaves the other body in the middle of their contact.
        """
        if self.core == "rigid":
            return inf
        Y_2 = float(stacked_compliance(np.array([2.0]), self._stack, free=True)[0, 0, 0])
        return 4 * pi * self.radius**2 / (27 * Y_2 * contact_radius)

    @property
    def materials(self) -> tuple[Material, ...]:
        """Those of all layers."""
        return tuple(layer.material for layer in self.layers)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the influence functions of all layers together."""
        free = self.core == "free"
        if speed is None:
            return cylinder.layered_kernels(self.radius, self._stack, free)
        relaxations = tuple(material.relaxation(speed) for material in self.materials)
        return rolling.layered_kernels(self.radius, self._stack, relaxations, free)

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses below the surface; None if a material is viscoelastic."""
        if self.viscoelastic:
            return None
        return cylinder_sections(x, p, q, depths, self.radius, self._stack, self.core == "free")


def contact_radius(one: Body, two: Body) -> float:
    """Return R* of two bodies, 1/R* = 1/R1 + 1/R2 [m]."""
    return 1 / (1 / one.radius + 1 / two.radius)


def half_width_guess(load: float, one: Body, two: Body) -> float:
    """Return a half width to start from [m]: Hertz's, or less where a layer is thin.

    Hertz's theory for half-planes, a = 2 sqrt(P R*/(pi E*)) with 1/E* = sum C/2 (thesis eqs. 101
    to 103), is an upper bound; on a layer much thinner than a it is far off.
    """
    C, radius = one.compliance + two.compliance, contact_radius(one, two)
    # a body that tells no compliance: any width is a start, for the load grows with it
    hertz = sqrt(2 * C * load * radius / pi) or 0.01 * radius
    return min(hertz, 4 * one.thickness, 4 * two.thickness, 0.3 * radius)

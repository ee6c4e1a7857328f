"""The bodies in contact, wound roll and drum: geometry and material, and their surface response.

A body implements :meth:`Body.surface`: the slope and the strain of its surface due to nodal
pressures and tractions (:class:`~woundon.elasticity.surface.SurfaceResponse`).  The bodies of this
module are linear and homogeneous along their circumference, so that influence functions describe
them (:class:`KernelBody`).

The set of bodies is open: subclass :class:`Body` to add one.
"""

from __future__ import annotations

from dataclasses import InitVar
from functools import cached_property
from math import inf, log1p, pi, sqrt
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, SerializeAsAny, model_validator

from ..elasticity import cylinder, half_plane, rolling
from ..elasticity.influence import InfluenceSurface
from ..elasticity.interior_stress import Section, cylinder_sections, half_plane_sections
from ..elasticity.kernels import SurfaceKernels
from ..elasticity.layers import stacked_compliance
from ..elasticity.surface import RigidSurface, SurfaceResponse
from ..errors import InvalidProblem
from ..quantities import length
from . import measured_moduli as measured_moduli  # registers its materials
from . import viscoelastic as viscoelastic
from .description import Description
from .family import Family
from .fields import Number, listed
from .materials import AnyMaterial, Material
from .permitted import is_within

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from ..elasticity.layers import Layers as Stacked
    from ..elasticity.mesh import Face
    from .fields import CoercedField, Nested, OptionalNested

__all__ = [
    "AnyBody",
    "Body",
    "CoreRadius",
    "Cylinder",
    "HalfPlane",
    "KernelBody",
    "Layer",
    "Layered",
    "OptionalBody",
    "Radius",
    "Rigid",
    "check_core",
    "contact_radius",
    "half_width_guess",
]


# Smallest core radius relative to the radius: a smaller core has no effect, but powers of the ratio
# overflow.
SMALLEST_CORE = 1e-9
# Largest half width relative to the length over which the influence functions vary; their
# interpolation then has at most 1200 points.
LARGEST_RELATIVE_HALF_WIDTH = 60
# Largest truncation error of a Fourier series, relative to the response of a half-plane.
LARGEST_SERIES_ERROR = 1e-2

Radius = Annotated[Number, length("R", "outer radius", "mm", (0.02, 1.0)), Field(gt=1e-4, le=50.0)]

CoreRadius = Annotated[
    Number, length("R0", "radius of the rigid core", "mm", (0.02, 0.9)), Field(gt=0)
]


class Body(Family):
    """A body in contact; subclass it to add one.

    Attributes
    ----------
    radius : float
        Outer radius R [m]; it enters the gap between the bodies.
    rigid : bool
        Whether the surface does not deform at all.
    linear : bool
        Whether the response is linear in pressure and traction.
    validity_warning : str
        A warning for every result with this body; empty if there is none.
    viscoelastic : bool
        Whether the response depends on the rolling speed.

    Examples
    --------
    >>> import woundon as wo
    >>> isinstance(wo.Rigid(radius=0.25), wo.Body), wo.Rigid(radius=0.25).rigid
    (True, True)
    """

    # Required, but type checkers must accept a diameter in its place.
    radius: Radius = Field(...)
    if TYPE_CHECKING:
        diameter: InitVar[float | str] = Field(...)
    rigid: ClassVar[bool] = False
    linear: ClassVar[bool] = True
    validity_warning: ClassVar[str] = ""

    @property
    def viscoelastic(self) -> bool:
        """True if the response depends on the rolling speed."""
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
            Speed of the surface along +x [m/s]; elastic bodies do not depend on it.
        """
        raise NotImplementedError(f"{type(self).__name__} has no surface response")

    def uniform_strain(self, pressure: float) -> float:
        """Return the surface strain under a uniform pressure on the whole circumference.

        A closed layer of web loads a roll in this way.  Zero unless a subclass defines it.

        Parameters
        ----------
        pressure : float
            [Pa].
        """
        return 0.0

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses at depths below the surface; None if the body does not provide them.

        A section of the result has the stresses at one depth.

        Parameters
        ----------
        x, p, q : (k,) arrays
            Nodes [m]; pressures and tractions along +x on the body [Pa].
        depths : (m,) array
            z [m], > 0 and less than the thickness.
        half_width : float
            a of the nip [m].
        """
        return None

    @property
    def curvature(self) -> float:
        """1/R if the surface strain includes the term v/R, otherwise 0 [1/m]."""
        return 1 / self.radius

    @property
    def thickness(self) -> float:
        """Thickness of the deformable part [m]; inf for a half-plane."""
        return float("inf")

    @property
    def max_half_width(self) -> float:
        """Largest half width of a contact for which the response is resolved [m]."""
        return float("inf")

    @property
    def resolution_fault(self) -> str:
        """The reason why the response is not resolved at any half width; otherwise empty."""
        return ""

    @property
    def surface_material(self) -> Material | None:
        """The linear elastic material at the surface; None if there is none."""
        material = getattr(self, "material", None)
        return material if isinstance(material, Material) else None

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of the body; empty if it does not state them."""
        return ()

    @property
    def compliance(self) -> float:
        """C of the half-plane that the surface resembles near a line load (thesis eq. 30) [1/Pa].

        It is used for the initial guess of the half width only.
        """
        material = self.surface_material
        return 0.0 if material is None else half_plane.coefficients(*material.stiffness).C

    def bending_load(self, contact_radius: float) -> float:
        """Return an estimate of the load at which an open tube lifts off in mid-contact [N/m].

        inf for all other bodies.
        """
        return inf


if TYPE_CHECKING:
    AnyBody = Nested[Body]
    OptionalBody = OptionalNested[Body]
else:
    AnyBody = Annotated[SerializeAsAny[Body], BeforeValidator(Body.coerce)]
    OptionalBody = AnyBody | None


class Rigid(Body):
    """A rigid cylinder.

    Parameters
    ----------
    radius : float
        R [m].

    Examples
    --------
    >>> import woundon as wo
    >>> wo.Rigid(diameter="6 in").radius
    0.0762
    """

    rigid: ClassVar[bool] = True

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> RigidSurface:
        """Return a surface that does not deform."""
        return RigidSurface(face)


class KernelBody(Body, abstract=True):
    """A linear body that is described by the influence functions of its surface."""

    @cached_property
    def viscoelastic(self) -> bool:
        """True if one of the materials is viscoelastic."""
        return any(material.relaxes for material in self.materials)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the influence functions, valid on the whole surface.

        Without a speed, a viscoelastic body is fully relaxed.
        """
        raise NotImplementedError

    def surface(
        self, face: Face, half_width: float, speed: float | None = None
    ) -> InfluenceSurface:
        """Return the response of the surface, computed from the influence functions."""
        kernels = self.kernels(speed) if self.viscoelastic and speed else self.kernels()
        is_curved = self.curvature > 0
        return InfluenceSurface(kernels, self.radius, is_curved, face, half_width)

    def uniform_strain(self, pressure: float) -> float:
        """Return the surface strain under a uniform pressure on the whole circumference.

        A viscoelastic body is fully relaxed, because the load on a material point is constant.
        """
        return pressure * self.kernels().uniform_strain

    @property
    def max_half_width(self) -> float:
        """Largest half width for which the influence functions are interpolated [m]."""
        return LARGEST_RELATIVE_HALF_WIDTH * self.kernels().length

    @property
    def resolution_fault(self) -> str:
        """A message if the Fourier series of the influence functions is truncated too early."""
        kernels = self.kernels()
        if kernels.truncation_error <= LARGEST_SERIES_ERROR:
            return ""
        return (
            f"the response of its layer, {self.thickness:.3g} m thick, needs more than "
            f"{kernels.terms} Fourier terms (relative error {kernels.truncation_error:.2g}); use a "
            "thicker layer or a material with less different stiffnesses"
        )

    @property
    def compliance(self) -> float:
        """C of the half-plane that the surface resembles near a line load [1/Pa]."""
        return pi * self.kernels().slope_p.inverse  # near a line load P the slope is C P/(pi x)

    def interior_stress(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray, half_width: float
    ) -> tuple[Section, ...] | None:
        """Return the stresses below the surface; None if a material is viscoelastic."""
        return None if self.viscoelastic else self._sections(x, p, q, depths)

    def _sections(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray
    ) -> tuple[Section, ...] | None:
        """Return the stresses in an elastic body; parameters as of :meth:`interior_stress`."""
        return None


class LayeredBody(KernelBody, abstract=True):
    """A cylinder of concentric layers on a rigid core or an open bore (thesis sec. 2.2)."""

    _is_open: ClassVar[bool] = False  # True for an open bore

    @property
    def _stack(self) -> Stacked:
        """Each layer, outermost first: ln(outer/inner radius), A_rr, A_tt, A_rt, G [Pa], D."""
        raise NotImplementedError

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the influence functions of the cylinder (thesis eq. 59)."""
        if speed is None:
            return cylinder.layered_kernels(self.radius, self._stack, self._is_open)
        relaxations = tuple(material.relaxation(speed) for material in self.materials)
        constant_bulk = tuple(material.bulk_is_constant for material in self.materials)
        return rolling.layered_kernels(
            self.radius, self._stack, relaxations, self._is_open, constant_bulk
        )

    def _sections(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray
    ) -> tuple[Section, ...]:
        """Return the stresses in the layers of the cylinder."""
        return cylinder_sections(x, p, q, depths, self.radius, self._stack, self._is_open)


class HalfPlane(KernelBody):
    """An elastic half-plane (thesis sec. 2.1); its radius enters the gap only.

    Parameters
    ----------
    radius : float
        R [m].
    material : Orthotropic or Isotropic

    Examples
    --------
    >>> import woundon as wo
    >>> wo.HalfPlane(radius=0.25, material="steel").material.poissons_ratio
    0.3
    """

    material: AnyMaterial

    @property
    def curvature(self) -> float:
        """0: the strain of a half-plane has no term v/R [1/m]."""
        return 0.0

    @property
    def materials(self) -> tuple[Material, ...]:
        """The material, as a tuple."""
        return (self.material,)

    def kernels(self, speed: float | None = None) -> SurfaceKernels:
        """Return the half-plane's influence functions (thesis eq. 32)."""
        stiffness = self.material.stiffness
        if speed is None:
            return half_plane.surface_kernels(*stiffness)
        reach = (pi + 1) * self.radius  # covers the largest wrap angle, pi
        return rolling.half_plane_kernels(
            stiffness, self.material.relaxation(speed), reach, self.material.bulk_is_constant
        )

    def _sections(
        self, x: np.ndarray, p: np.ndarray, q: np.ndarray, depths: np.ndarray
    ) -> tuple[Section, ...]:
        """Return the stresses in the half-plane."""
        return half_plane_sections(x, p, q, depths, self.radius, self.material.stiffness)


class Cylinder(LayeredBody):
    """An elastic cylinder on a rigid core (thesis sec. 2.2); the core of a drum cover is its shell.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], 1e-9 R <= R0 <= 0.9995 R.
    material : Orthotropic or Isotropic

    Raises
    ------
    InvalidProblem
        For a core that is not smaller than the cylinder, or a layer thinner than R/2000.

    Examples
    --------
    >>> import woundon as wo
    >>> roll = wo.Cylinder(diameter="200 mm", core_diameter="89 mm", material="newsprint")
    >>> round(roll.thickness, 4)
    0.0555
    """

    core_radius: CoreRadius = Field(...)
    if TYPE_CHECKING:
        core_diameter: InitVar[float | str] = Field(...)
    material: AnyMaterial

    @model_validator(mode="after")
    def _check_core(self) -> Self:
        """Reject a core that is too large or too small."""
        check_core(self)
        return self

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of the elastic layer [m]."""
        return self.radius - self.core_radius

    @property
    def materials(self) -> tuple[Material, ...]:
        """The material, as a tuple."""
        return (self.material,)

    @property
    def _stack(self) -> Stacked:
        return ((cylinder.depth(self.radius, self.core_radius), *self.material.stiffness),)


def check_core(body: Any) -> None:
    """Reject a core that is not smaller than the body, or leaves a layer thinner than R/2000.

    Raises
    ------
    InvalidProblem
    """
    smallest, limit = body.radius * SMALLEST_CORE, body.radius * (1 - 1 / 2000)
    if not is_within(body.core_radius, smallest, limit):
        raise InvalidProblem.at(
            "core_radius",
            f"{body.core_radius:.10g} is out of range; must be >= {SMALLEST_CORE:g} * radius "
            f"= {smallest:.10g} and <= 0.9995 * radius = {limit:.10g} [m]",
        )


class Layer(Description):
    """A layer of a :class:`Layered` body.

    Parameters
    ----------
    thickness : float
        h [m].
    material : Orthotropic or Isotropic

    Examples
    --------
    >>> import woundon as wo
    >>> wo.Layer(thickness="15 mm", material="rubber").thickness
    0.015
    """

    thickness: Annotated[
        Number, length("h", "thickness of the layer", "mm", (0.01e-3, 0.05)), Field(ge=1e-9, le=50)
    ]
    material: AnyMaterial


if TYPE_CHECKING:
    Layers = CoercedField[tuple[Layer, ...], Iterable[Layer | Mapping[str, Any]]]
else:
    Layers = Annotated[tuple[Layer, ...], BeforeValidator(listed)]


class Layered(LayeredBody):
    """An elastic cylinder of concentric layers, such as a covered shell.

    Parameters
    ----------
    radius : float
        R [m].
    layers : sequence of Layer
        Outermost first.
    core : "rigid" or "free"
        Support of the innermost layer: a rigid core, or an open bore.  The bore carries only the
        tractions that balance the force and the torque on the surface; its mean displacement is
        zero.

    Raises
    ------
    InvalidProblem
        If the total thickness exceeds the radius or is less than R/2000.

    Examples
    --------
    >>> import woundon as wo
    >>> cover = {"thickness": "15 mm", "material": "soft-cover"}
    >>> drum = wo.Layered(radius=0.25, layers=[cover, {"thickness": 0.03, "material": "steel"}])
    >>> drum.thickness
    0.045
    """

    layers: Annotated[Layers, Field(min_length=1, max_length=5000, description="outermost first")]
    core: Literal["rigid", "free"] = "rigid"

    @model_validator(mode="after")
    def _check_layers(self) -> Self:
        """Reject layers that are thicker than the radius or too thin for the solver."""
        smallest, largest = self.radius / 2000, self.radius * (1 - SMALLEST_CORE)
        # the largest is exact: with the radius itself nothing is left for the core
        if self.thickness > largest or not is_within(self.thickness, smallest, largest):
            raise InvalidProblem.at(
                "layers",
                f"a total thickness of {self.thickness:.10g} is out of range; must be >= radius "
                f"/ 2000 = {smallest:.10g} and < radius = {self.radius:.10g} [m]",
            )
        return self

    @cached_property
    def thickness(self) -> float:
        """Total thickness of the layers [m]."""
        return sum(layer.thickness for layer in self.layers)

    @property
    def surface_material(self) -> Material:
        """The material of the outermost layer."""
        return self.layers[0].material

    @property
    def _is_open(self) -> bool:  # type: ignore[override]
        return self.core == "free"

    @cached_property
    def _stack(self) -> Stacked:
        R, layers = self.radius, []
        for layer in self.layers:
            layers.append((-log1p(-layer.thickness / R), *layer.material.stiffness))
            R -= layer.thickness
        return tuple(layers)

    @property
    def max_half_width(self) -> float:
        """inf: kernels that vary over a short length are integrated exactly [m]."""
        return inf

    def bending_load(self, contact_radius: float) -> float:
        """Return an estimate of the load at which an open tube lifts off in mid-contact [N/m].

        A line load P changes the curvature of a thin ring of bending stiffness B by
        P R/(pi B) sum_(n>1) 1/(n^2 - 1) = 3 P R/(4 pi B); B follows from Y_2 = R^3/(9 B), the
        radial compliance of the second harmonic.  If the change equals 1/R*, with R* the
        ``contact_radius`` [m] of both bodies, the ring lifts off the other body in the middle of
        the contact.  inf without an open bore.
        """
        if not self._is_open:
            return inf
        # radial displacement [0] due to pressure [0] of the only harmonic [0]
        Y_2 = float(stacked_compliance(np.array([2.0]), self._stack, open_bore=True)[0, 0, 0])
        return 4 * pi * self.radius**2 / (27 * Y_2 * contact_radius)

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of all layers."""
        return tuple(layer.material for layer in self.layers)


def contact_radius(body_1: Body, body_2: Body) -> float:
    """Return R* of two bodies, 1/R* = 1/R1 + 1/R2 [m]."""
    return 1 / (1 / body_1.radius + 1 / body_2.radius)


def half_width_guess(load: float, body_1: Body, body_2: Body) -> float:
    """Return an initial guess of the half width [m]: Hertz's, or less for thin layers.

    Hertz's theory for half-planes, a = 2 sqrt(P R*/(pi E*)) with 1/E* = sum C/2 (thesis eqs. 101
    to 103), gives an upper bound, which is a poor guess for layers much thinner than a.
    """
    C, radius = body_1.compliance + body_2.compliance, contact_radius(body_1, body_2)
    # Bodies without a compliance: any guess converges, because the load increases with the width.
    hertz = sqrt(2 * C * load * radius / pi) or 0.01 * radius
    return min(hertz, 4 * body_1.thickness, 4 * body_2.thickness, 0.3 * radius)

"""The web: a thin strip of paper or film."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import InitVar
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, SerializeAsAny

from ..elasticity.strip import Compliance, compliance
from ..errors import InvalidProblem
from ..quantities import (
    Quantity,
    density_of_web,
    line_load,
    stress,
    thickness_of_web,
    velocity,
)
from .description import Description
from .fields import Number, OptionalNumber
from .inputs import Inputs, is_basis_weight, read_number
from .materials import Material, Solid
from .paths import Faults
from .radial_laws import Constant
from .stack import Stack

if TYPE_CHECKING:
    from .fields import CoercedField

__all__ = [
    "CENTRIFUGAL_TENSION",
    "CaliperPressure",
    "Web",
    "WebDensity",
    "WebSpeed",
    "centrifugal_stress",
]

WebDensity = Annotated[OptionalNumber, density_of_web((500.0, 1500.0)), Field(gt=0, le=3e4)]
WebSpeed = Annotated[OptionalNumber, velocity("web speed", (1.0, 50.0)), Field(ge=0, le=200)]
CaliperPressure = Annotated[
    OptionalNumber,
    stress("p_c", "pressure under which the web thickness was measured", typical=(2e3, 100e3)),
    Field(ge=0, le=1e7),
]
# an output of nips, rolls and windings
CENTRIFUGAL_TENSION = line_load("m V^2", "part of the tension taken by centrifugal force")

Array = np.ndarray


def centrifugal_stress(density: float | None, speed: float | None) -> float:
    """Return rho V^2 of a running web [Pa]; 0 if density [kg/m^3] or speed [m/s] is not given."""
    return 0.0 if density is None or speed is None else density * speed**2


_ONLY_FOR_BASIS_WEIGHT = (
    "converts a thickness that is given as a basis weight; must be left out here"
)


def _solid(value: Any) -> Any:
    """Convert the name of a material or a table to a material or stack."""
    return Material.coerce(value) if isinstance(value, str) else Solid.coerce(value)


if TYPE_CHECKING:
    AnySolid = CoercedField[Solid, Solid | str | Mapping[str, Any]]
else:
    AnySolid = Annotated[SerializeAsAny[Solid], BeforeValidator(_solid)]


class Web(Description):
    """The paper or film web, a thin strip (thesis sec. 2.3).

    Parameters
    ----------
    thickness : float
        2h [m], 0.1 um to 10 mm; or a basis weight, "45 gsm", with the ``density`` of the web,
        "680 kg/m^3".
    material : Orthotropic, Isotropic or Stack
        Plane-strain stiffness of the web.  A stack makes the web harden under the pressure in the
        nip; its shear modulus has no effect.

    Examples
    --------
    >>> import woundon as wo
    >>> web = wo.Web(thickness="45 gsm", density="680 kg/m^3", material="newsprint")
    >>> round(web.thickness * 1e6, 1)
    66.2
    """

    input_only: ClassVar[Mapping[str, Quantity]] = {"density": density_of_web()}

    thickness: Annotated[Number, thickness_of_web((10e-6, 500e-6)), Field(ge=1e-7, le=1e-2)]
    material: AnySolid
    if TYPE_CHECKING:
        density: InitVar[float | str] = Field(...)

    @classmethod
    def _fields_of(cls, inputs: Inputs, faults: Faults) -> dict[str, Any]:
        """Return the values by field, without the density that converts a basis weight."""
        fields = super()._fields_of(inputs, faults)
        if "density" in fields:
            density = fields.pop("density")
            try:
                if not is_basis_weight(fields.get("thickness")):
                    raise InvalidProblem.at("density", _ONLY_FOR_BASIS_WEIGHT)
                # only to reject it; the validator of the thickness reads it by Inputs.known
                read_number(density, cls.input_only["density"], "density", inputs)
            except InvalidProblem as fault:
                faults += fault.faults
        return fields

    @property
    def linear(self) -> bool:
        """True unless the material is a stack whose modulus depends on the pressure."""
        stack = self.material
        return not isinstance(stack, Stack) or isinstance(stack.radial, Constant)

    @cached_property
    def compliance(self) -> Compliance:
        """The plane-strain compliances [1/Pa]; c22, through the thickness, without pressure."""
        A_rr, A_tt, A_rt, _, D = self.material.stiffness
        return compliance(A_rr, A_tt, A_rt, D)

    def thinned(self, p: Array) -> tuple[Array, Array]:
        """Return the thickness reduction [m] by pressures [Pa], and its derivative [m/Pa].

        Both have the shape of ``p``.
        """
        if not isinstance(self.material, Stack):
            by_p = np.full(p.shape, self.thickness * self.compliance.c22)
            return by_p * p, by_p
        radial = self.material.radial
        return self.thickness * radial.strain_at(p), self.thickness / radial.modulus(p)

    def radial_modulus(self, pressure: float) -> float:
        """Return A_rr, or of a stack the secant modulus P/F(P) at a pressure > 0 [Pa]."""
        if isinstance(self.material, Stack):
            return pressure / float(self.material.radial.strain_at(pressure))
        return self.material.stiffness.rr

    def check_pressure(self, pressure: float) -> None:
        """Raise an error if a pressure [Pa] is beyond the range of the stack law.

        Raises
        ------
        InvalidProblem
        """
        if isinstance(self.material, Stack) and pressure > self.material.limit:
            raise self.material.beyond_limit(pressure).under("web.material")

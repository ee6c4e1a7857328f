"""Linear elastic materials in plane strain, and a small library of named ones with their source.

An orthotropic material relates stress and strain in the (radial, tangential) axes by

    sigma_r     = A_rr eps_r + A_rt eps_t
    sigma_t     = A_rt eps_r + A_tt eps_t
    tau_rt      = G gamma_rt

(thesis eqs. 10 and 34).  Paper is of this kind: stiff along the web, soft through the stack.
"""

from __future__ import annotations

from functools import cached_property
from math import sqrt
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from .description import Description, Number, shown
from .errors import InvalidProblem, did_you_mean

__all__ = ["Isotropic", "Material", "NamedMaterial", "Orthotropic", "Stiffness", "material"]


class Stiffness(NamedTuple):
    """Plane-strain stiffness A_rr, A_tt, A_rt and shear modulus G [Pa]."""

    rr: float
    tt: float
    rt: float
    shear: float


def _modulus(what: str, **kw: Any) -> Any:
    return Field(description=what, json_schema_extra={"unit": "Pa"}, le=1e14, **kw)


# softer than any solid, and soft enough for numbers without dimension around 1
SOFTEST = 1e-3


class Orthotropic(Description):
    """An orthotropic material by its plane-strain stiffness (thesis eq. 34).

    Parameters
    ----------
    radial, tangential : float
        A_rr and A_tt, direct stiffness through the thickness and along the web [Pa], 1e-3 to 1e14.
    cross : float
        A_rt [Pa], 0 <= A_rt < sqrt(A_rr A_tt).
    shear : float
        G_rt [Pa], in the same range.

    Raises
    ------
    InvalidProblem
        For a modulus out of range, or a cross stiffness that makes the energy indefinite.
    """

    kind: Literal["orthotropic"] = Field(default="orthotropic", repr=False)
    radial: Number = _modulus("A_rr, direct stiffness through the thickness", ge=SOFTEST)
    tangential: Number = _modulus("A_tt, direct stiffness along the web", ge=SOFTEST)
    cross: Number = _modulus("A_rt, cross stiffness", ge=0)
    shear: Number = _modulus("G_rt, shear modulus", ge=SOFTEST)

    @model_validator(mode="after")
    def _positive_energy(self) -> Orthotropic:
        limit = sqrt(self.radial) * sqrt(self.tangential)
        if self.cross >= limit * (1 - 1e-9):
            raise InvalidProblem.at(
                "cross",
                f"{self.cross:.10g} is out of range; must be >= 0 and < "
                f"sqrt(radial * tangential) = {limit:.10g} [Pa]",
            )
        return self

    @cached_property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr, A_tt, A_rt, G [Pa]."""
        return Stiffness(self.radial, self.tangential, self.cross, self.shear)


class Isotropic(Description):
    """An isotropic material by Young's modulus and Poisson's ratio, used in plane strain.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa], 1e-3 to 1e14.
    poissons_ratio : float
        nu, 0 <= nu < 0.5; the model excludes incompressible bodies (thesis sec. 2.1).

    Raises
    ------
    InvalidProblem
        For values out of range.
    """

    kind: Literal["isotropic"] = Field(default="isotropic", repr=False)
    youngs_modulus: Number = _modulus("E, Young's modulus", ge=SOFTEST)
    poissons_ratio: Number = Field(
        description="nu, Poisson's ratio", ge=0, lt=0.5, json_schema_extra={"unit": "1"}
    )

    @cached_property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr = A_tt, A_rt, G [Pa]."""
        E, nu = self.youngs_modulus, self.poissons_ratio
        direct = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
        return Stiffness(direct, direct, direct * nu / (1 - nu), E / (2 * (1 + nu)))


def _kind_of(value: Any) -> str | None:
    """Tell a material's kind; where none is said, its field names give it away."""
    if not isinstance(value, dict):
        return getattr(value, "kind", None)
    if "kind" in value:
        return str(value["kind"])
    # parts of names, so that a misspelt one still leads to the right list of fields
    isotropic = any(part in str(name) for name in value for part in ("young", "poisson"))
    return "isotropic" if isotropic else "orthotropic"


def _named(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    try:
        return material(value)
    except InvalidProblem as fault:
        raise InvalidProblem(fault.faults[0][1]) from None  # the field's name is the caller's


# a material itself, a table of its fields, or the name of one
Material = Annotated[
    Annotated[Orthotropic, Tag("orthotropic")] | Annotated[Isotropic, Tag("isotropic")],
    Discriminator(_kind_of),
    BeforeValidator(_named),
]


class NamedMaterial(NamedTuple):
    """A library entry: the material and where its numbers come from."""

    material: Orthotropic | Isotropic
    source: str


def _library() -> dict[str, NamedMaterial]:
    thesis = "Jorkama 2001"
    return {
        "paper": NamedMaterial(
            Orthotropic(radial=20e6, tangential=3e9, cross=5e6, shear=10e6), f"{thesis}, Table 1"
        ),
        "newsprint": NamedMaterial(
            Orthotropic(radial=27e6, tangential=3.38e9, cross=5e6, shear=10e6),
            f"{thesis}, Table 2 (A_rr and G fitted there to one measured point)",
        ),
        "steel": NamedMaterial(
            Isotropic(youngs_modulus=206e9, poissons_ratio=0.3), f"{thesis}, ch. 1.2 (Fig. 5)"
        ),
        "hard-drum": NamedMaterial(
            Isotropic(youngs_modulus=211e9, poissons_ratio=0.3), f"{thesis}, ch. 4.6 (Fig. 26)"
        ),
        "soft-cover": NamedMaterial(
            Isotropic(youngs_modulus=10e6, poissons_ratio=0.1), f"{thesis}, ch. 4.6 (Fig. 25)"
        ),
        "rubber": NamedMaterial(
            Isotropic(youngs_modulus=1e6, poissons_ratio=0.499), f"{thesis}, ch. 4.6 (Fig. 26)"
        ),
        "cellular-elastomer": NamedMaterial(
            Isotropic(youngs_modulus=1e6, poissons_ratio=0.1), f"{thesis}, ch. 4.6 (Fig. 26)"
        ),
    }


MATERIALS: dict[str, NamedMaterial] = _library()


def material(name: str) -> Orthotropic | Isotropic:
    """Return the named material, e.g. ``material("newsprint")``.

    Raises
    ------
    InvalidProblem
        For an unknown name, with the nearest known one.
    """
    if not isinstance(name, str) or name not in MATERIALS:
        raise InvalidProblem.at(
            "material", f"{shown(name)} is no named material{did_you_mean(name, MATERIALS)}"
        )
    return MATERIALS[name].material

"""Linear elastic materials in plane strain, and a library of named materials with sources.

An orthotropic material relates stress and strain in the (radial, tangential) axes by

    sigma_r     = A_rr eps_r + A_rt eps_t
    sigma_t     = A_rt eps_r + A_tt eps_t
    tau_rt      = G gamma_rt

(thesis eqs. 10 and 34).  Paper is orthotropic: stiff along the web, soft through the stack.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from math import sqrt
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

from pydantic import BeforeValidator, Field, SerializeAsAny, model_validator

from ..elasticity.relaxation import INCOMPRESSIBLE
from ..errors import InvalidProblem, did_you_mean
from ..quantities import Quantity, pure, stress
from .description import Description
from .family import Family, from_table
from .fields import Number, default, listed
from .library import entry_of, library
from .messages import quote

if TYPE_CHECKING:
    from .fields import CoercedField

__all__ = [
    "AnyMaterial",
    "Isotropic",
    "Material",
    "NamedMaterial",
    "OneModulus",
    "OptionalMaterial",
    "Orthotropic",
    "PronyTerm",
    "RelaxationTime",
    "RelaxingTerm",
    "Solid",
    "Stiffness",
    "isotropic_stiffness",
    "material",
]


class Stiffness(NamedTuple):
    """Plane-strain stiffness A_rr, A_tt, A_rt and shear modulus G [Pa].

    ``along`` is D = A_tt - A_rt^2/A_rr, if known: the difference loses all digits for a nearly
    incompressible material.
    """

    rr: float
    tt: float
    rt: float
    shear: float
    along: float | None = None


class Solid(Family):
    """The materials of webs and rolls: linear elastic materials, and stacks that harden."""

    @property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr, A_tt, A_rt, G [Pa]; viscoelastic materials: relaxed."""
        raise NotImplementedError

    @property
    def relaxes(self) -> bool:
        """True for a viscoelastic material."""
        return False

    @property
    def validity_warning(self) -> str:
        """A warning for every result with this material; empty if there is none."""
        return ""

    @property
    def measured_frequencies(self) -> tuple[float, float] | None:
        """Range of frequencies in which a viscoelastic material is known [Hz]; None for all."""
        return None

    @property
    def bulk_is_constant(self) -> bool:
        """True if the shear modulus alone relaxes, False if all moduli relax in proportion."""
        return False

    def relaxation(self, speed: float) -> tuple[tuple[float, float], ...]:
        """Return the relaxation in rolling: pairs E_k/E_inf [1], speed * tau_k [m].

        They are those of the shear modulus if the bulk modulus is constant.
        """
        return ()


class Material(Solid, abstract=True):
    """A linear elastic material: an open set of classes with a plane-strain stiffness.

    >>> import woundon as wo
    >>> isinstance(wo.material("steel"), wo.Material)
    True
    """

    @classmethod
    def coerce(cls, value: Any) -> Any:
        """Return the material of a table or of a name."""
        if not isinstance(value, str):
            return super().coerce(value)
        try:
            return material(value)
        except InvalidProblem as fault:
            raise InvalidProblem(fault.faults[0][1]) from None  # the caller adds the field's name


# A field with a material accepts the material, a table of its fields, or a name.
if TYPE_CHECKING:
    AnyMaterial = CoercedField[Material, Material | str | Mapping[str, Any]]
    OptionalMaterial = CoercedField[Material | None, Material | str | Mapping[str, Any] | None]
else:
    AnyMaterial = Annotated[SerializeAsAny[Material], BeforeValidator(Material.coerce)]
    OptionalMaterial = AnyMaterial | None

# Range of moduli [Pa]: wider than that of solids, so that dimensionless problems can be entered.
SOFTEST = 1e-3
STIFFEST = 1e14


class Orthotropic(Material):
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

    Examples
    --------
    >>> import woundon as wo
    >>> newsprint = wo.Orthotropic(radial="27 MPa", tangential="3.38 GPa", cross=5e6, shear=10e6)
    >>> newsprint.tangential
    3380000000.0
    """

    radial: Annotated[
        Number,
        stress("A_rr", "direct stiffness through the thickness", "MPa", (5e6, 5e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    tangential: Annotated[
        Number,
        stress("A_tt", "direct stiffness along the web", "MPa", (5e8, 1e10)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    cross: Annotated[
        Number, stress("A_rt", "cross stiffness", "MPa", (0.0, 1e8)), Field(ge=0, le=STIFFEST)
    ]
    shear: Annotated[
        Number,
        stress("G_rt", "shear modulus", "MPa", (1e6, 1e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]

    @model_validator(mode="after")
    def _check_energy(self) -> Orthotropic:
        """Reject stiffness with an indefinite strain energy."""
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


PoissonsRatio = Annotated[Number, pure("nu", "Poisson's ratio", (0.0, 0.49)), Field(ge=0, le=0.5)]


def isotropic_stiffness(E: float, nu: float) -> Stiffness:
    """Return the plane-strain stiffness A_rr = A_tt, A_rt, G, D of an isotropic material [Pa].

    A_rr varies as 1/(1 - 2 nu); D stays bounded and is therefore given separately.

    Parameters
    ----------
    E, nu : float
        Young's modulus [Pa] and Poisson's ratio.
    """
    direct = E * (1 - nu) / ((1 + nu) * max(1 - 2 * nu, 1 / INCOMPRESSIBLE))
    return Stiffness(
        direct, direct, direct * nu / (1 - nu), E / (2 * (1 + nu)), E / ((1 - nu) * (1 + nu))
    )


class OneModulus(Material, abstract=True):
    """An isotropic material with one modulus: Poisson's ratio does not depend on time."""

    if TYPE_CHECKING:

        @property
        def poissons_ratio(self) -> float:
            """Poisson's ratio [1]; a field of each subclass."""

    @property
    def long_term_modulus(self) -> float:
        """E_inf, Young's modulus after all relaxation [Pa]."""
        raise NotImplementedError

    @property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """The Prony terms (E_k [Pa], tau_k [s]); empty for an elastic material."""
        return ()

    @property
    def relaxes(self) -> bool:
        """True for a viscoelastic material."""
        return bool(self.prony_series)

    def relaxation(self, speed: float) -> tuple[tuple[float, float], ...]:
        """Return the relaxation in rolling: pairs E_k/E_inf [1], speed * tau_k [m]."""
        return tuple((E / self.long_term_modulus, speed * tau) for E, tau in self.prony_series)

    @cached_property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr = A_tt, A_rt, G, D after all relaxation [Pa]."""
        return isotropic_stiffness(self.long_term_modulus, self.poissons_ratio)


# Sum of the moduli of a Prony series relative to E_inf below which it has no effect on a nip: the
# default tolerance of the solver is ten times as large.
SMALLEST_RELAXATION = 1e-5


RelaxationTime = Annotated[
    Number, Quantity("tau_k", "s", "relaxation time", "ms", (1e-6, 10.0)), Field(gt=0, le=1e15)
]


class RelaxingTerm(Description):
    """A term of a Prony series: its first field is a modulus or a part of one, then ``time``."""

    @classmethod
    def coerce(cls, value: Any) -> Any:
        """Return the term of a pair or of a table."""
        if isinstance(value, (tuple, list)) and len(value) == 2:
            return cls(**dict(zip(cls.model_fields, value, strict=True)))
        return from_table(value, [cls]) if isinstance(value, Mapping) else value


class PronyTerm(RelaxingTerm):
    """A term E_k exp(-t/tau_k) of a Prony series; fields also accept a pair (E_k, tau_k).

    Parameters
    ----------
    modulus : float
        E_k [Pa], > 0.
    time : float
        tau_k [s], > 0.

    Examples
    --------
    >>> import woundon as wo
    >>> wo.PronyTerm(modulus="2 MPa", time="1 ms").time
    0.001
    """

    modulus: Annotated[
        Number, stress("E_k", "relaxing modulus", "MPa", (1e5, 1e8)), Field(gt=0, le=STIFFEST)
    ]
    time: RelaxationTime


if TYPE_CHECKING:
    Prony = CoercedField[
        tuple[PronyTerm, ...] | None,
        Iterable[PronyTerm | tuple[float | str, float | str] | Mapping[str, Any]] | None,
    ]
else:
    Prony = (
        Annotated[
            tuple[Annotated[PronyTerm, BeforeValidator(PronyTerm.coerce)], ...],
            BeforeValidator(listed),
        ]
        | None
    )


class Isotropic(OneModulus):
    """An isotropic material by Young's modulus and Poisson's ratio, used in plane strain.

    With a Prony series it is viscoelastic, E(t) = E_inf + sum E_k exp(-t/tau_k), with a constant
    Poisson's ratio; the problem then needs a speed.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa], 1e-3 to 1e14; E_inf, the relaxed modulus, if it is viscoelastic.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5.
    prony : sequence of (float, float), optional
        E_k [Pa] and tau_k [s], both > 0.

    Raises
    ------
    InvalidProblem
        For values out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> rubber = wo.Isotropic(youngs_modulus="10 MPa", poissons_ratio=0.49, prony=[(2e6, 1e-3)])
    >>> rubber.relaxes
    True
    """

    youngs_modulus: Annotated[
        Number,
        stress("E", "Young's modulus", "MPa", (1e6, 2.1e11)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    poissons_ratio: PoissonsRatio
    prony: Annotated[
        Prony,
        Field(min_length=1, max_length=100, description="Prony terms of the relaxation modulus"),
    ] = default(None)

    @model_validator(mode="after")
    def _check_moduli(self) -> Self:
        """Reject terms without an effect: mostly moduli relative to the instantaneous one."""
        total = sum(term.modulus for term in self.prony or ())
        least = SMALLEST_RELAXATION * self.youngs_modulus
        if self.prony and total < least:
            raise InvalidProblem.at(
                "prony",
                f"moduli with the sum {quote(total)} are out of range; must be >= "
                f"{SMALLEST_RELAXATION:g} * youngs_modulus = {quote(least)} [Pa]; fractions g_k of "
                "the instantaneous modulus are entered as prony_relative, with "
                "instantaneous_modulus in place of youngs_modulus (RelativeProny)",
            )
        return self

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa]."""
        return self.youngs_modulus

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_k [Pa] and tau_k [s]."""
        return tuple((term.modulus, term.time) for term in self.prony or ())


class NamedMaterial(NamedTuple):
    """A material of the library with its source and relative standard deviations."""

    material: Orthotropic | Isotropic
    source: str
    spread: Mapping[str, float] = MappingProxyType({})


def _library() -> dict[str, NamedMaterial]:
    """Return the named materials of the data file: those of the thesis, then covers of drums."""
    tables = library("materials")
    materials = {name: _thesis_material(table) for name, table in tables["materials"].items()}
    return materials | {name: _cover(table) for name, table in tables["covers"].items()}


def _thesis_material(table: Mapping[str, Any]) -> NamedMaterial:
    """Return a material of the data file with its source."""
    values = dict(table)
    source = values.pop("source")
    return NamedMaterial(from_table(values, (Orthotropic, Isotropic)), source)


def _cover(table: Mapping[str, Any]) -> NamedMaterial:
    """Return a cover material of the data file with its source and spread."""
    entry = entry_of(table)
    title, values = entry.values.pop("title"), entry.values
    source = f"{title}; modulus: {entry.sources['youngs_modulus']}"
    return NamedMaterial(Isotropic(**values), source, MappingProxyType(entry.spread))


MATERIALS: dict[str, NamedMaterial] = _library()


def material(name: str) -> Orthotropic | Isotropic:
    """Return the elastic constants of a named material.

    >>> import woundon as wo
    >>> wo.material("steel").youngs_modulus
    206000000000.0

    Raises
    ------
    InvalidProblem
        For an unknown name; the message suggests the most similar known name.
    """
    if not isinstance(name, str) or name not in MATERIALS:
        raise InvalidProblem.at(
            "material", f"{quote(name)} is not a named material{did_you_mean(name, MATERIALS)}"
        )
    return MATERIALS[name].material

"""Grades of paper, film, foil and nonwoven: material, stack, friction, limits and their spread.

The values are those of ``grades.toml``, each with its source and its relative standard deviation.
Users write grades of their own in a file of the same form, complete or ``like`` a known grade.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, field_validator

from ..errors import InputWarning, InvalidProblem, did_you_mean, warn
from ..quantities import (
    Quantity,
    density_of_web,
    length,
    pure,
    quantity_of,
    stress,
    tension,
    thickness_of_web,
)
from .bodies import Cylinder
from .description import Description
from .fields import Nested, Number, Numbers, OptionalNumber, default
from .free_strains import (
    ALONG_EXPANSION,
    ALONG_SWELLING,
    EXPANSION_RANGE,
    OF_WEB,
    SWELLING_RANGE,
    THROUGH_EXPANSION,
    THROUGH_SWELLING,
)
from .inputs import Inputs, is_basis_weight
from .library import entry_of, library, read_file, relative_deviation
from .limits import Limits
from .materials import SOFTEST, STIFFEST, Orthotropic
from .messages import quote
from .paths import Faults, field_or_none, field_quantity, is_part_of, nest_tables
from .radial_laws import Pfeiffer
from .schedules import Profile
from .stack import Stack
from .units import text_with_unit
from .web import Web
from .wound_roll import WoundRoll

__all__ = [
    "Grade",
    "Grades",
    "changes_of_grade",
    "grade",
    "grades",
    "source_of_limit",
    "states_all",
    "warn_of_contradictions",
    "with_grade",
]

_Modulus = Field(ge=SOFTEST, le=STIFFEST)
_Friction = Field(gt=0, le=10)
# Relative difference from which a value in a case differs from that of its grade.
SAME = 1e-6


class Grade(Description):
    """A grade of paper, film, foil or nonwoven, as it is wound.

    Parameters
    ----------
    name, title : str
    thickness, density : float
        Of the web [m], [kg/m^3].
    tangential : float
        E_t, modulus along the web [Pa].
    poissons_ratio : float
        nu of the stack.
    web_radial, cross : float
        A_rr of the web itself, through its thickness, and A_rt [Pa].
    roll_radial, roll_shear : float
        A_rr and G of the roll as a linear material under the pressure of a nip [Pa].
    K1, K2, stack_shear : float
        Pfeiffer's law of the stack, and its shear modulus [Pa].
    friction, drum_friction : float
        Between the layers; between web and drum.
    roughness : float
        Root mean square of both facing surfaces together [m].
    tangential_expansion, radial_expansion : float, optional
        Thermal expansion along the web and through the stack [1/K]; None if no source is known.
    tangential_swelling, radial_swelling : float, optional
        Strains along the web and through the stack by a moisture content of 1 [1]; None if no
        source is known.
    tension : float
        Wound-on tension that is usual for the grade [N/m].
    pressure : (float, float)
        Pressure near the core that is usual for rolls of the grade, low and high [Pa].
    limits : Limits
        Default limits of a wound roll.
    spread : mapping of str to float
        Relative standard deviations by field.
    sources : mapping of str to str
        Sources by field; "typical" marks a value that is usual in the trade.

    Raises
    ------
    InvalidProblem
        Naming every invalid field with its value and permitted range.

    Examples
    --------
    >>> import woundon as wo
    >>> newsprint = wo.grade("newsprint")
    >>> isinstance(newsprint, wo.Grade), newsprint.thickness < 1e-4
    (True, True)
    """

    name: str
    title: str
    thickness: Annotated[Number, thickness_of_web(), Field(ge=1e-7, le=1e-2)]
    density: Annotated[Number, density_of_web(), Field(gt=0, le=3e4)]
    tangential: Annotated[Number, stress("E_t", "modulus along the web", "GPa"), _Modulus]
    poissons_ratio: Annotated[
        Number,
        pure("nu", "Poisson's ratio, thinning due to strain along the web"),
        Field(ge=0, le=10),
    ]
    web_radial: Annotated[Number, stress("A_rr", "stiffness through the web", "MPa"), _Modulus]
    cross: Annotated[Number, stress("A_rt", "cross stiffness", "MPa"), Field(ge=0, le=STIFFEST)]
    roll_radial: Annotated[
        Number, stress("A_rr", "stiffness through the roll in a nip", "MPa"), _Modulus
    ]
    roll_shear: Annotated[
        Number, stress("G", "shear modulus of the roll in a nip", "MPa"), _Modulus
    ]
    K1: Annotated[
        Number, stress("K1", "pressure of Pfeiffer's law", "kPa"), Field(gt=0, le=STIFFEST)
    ]
    K2: Annotated[Number, pure("K2", "springiness of Pfeiffer's law"), Field(gt=0, le=1e6)]
    stack_shear: Annotated[Number, stress("G", "shear modulus of the stack", "MPa"), _Modulus]
    friction: Annotated[Number, pure("mu+", "interlayer friction coefficient"), _Friction]
    drum_friction: Annotated[Number, pure("mu-", "friction coefficient of web and drum"), _Friction]
    roughness: Annotated[
        Number, length("s", "rms roughness of both surfaces together", "um"), Field(gt=0, le=1e-3)
    ]
    tangential_expansion: Annotated[OptionalNumber, ALONG_EXPANSION, EXPANSION_RANGE] = default(
        None
    )
    radial_expansion: Annotated[OptionalNumber, THROUGH_EXPANSION, EXPANSION_RANGE] = default(None)
    tangential_swelling: Annotated[OptionalNumber, ALONG_SWELLING, SWELLING_RANGE] = default(None)
    radial_swelling: Annotated[OptionalNumber, THROUGH_SWELLING, SWELLING_RANGE] = default(None)
    tension: Annotated[Number, tension("WOT", "usual wound-on tension"), Field(gt=0, le=1e6)]
    pressure: Annotated[
        Numbers,
        stress("P", "usual pressure near the core, low to high", "kPa"),
        Field(min_length=2, max_length=2),
    ]
    limits: Annotated[Nested[Limits], Field(description="default limits of a wound roll")] = (
        default(Limits())
    )
    spread: Mapping[str, float] = {}
    sources: Mapping[str, str] = {}

    @field_validator("spread", "sources")
    @classmethod
    def _check_names_of_fields(cls, entries: Mapping[str, Any]) -> Mapping[str, Any]:
        """Reject names that are no fields, as misspelt ones."""
        for name in entries:
            field_quantity(cls, name)
        return entries

    @field_validator("spread")
    @classmethod
    def _check_spread(cls, spread: Mapping[str, float]) -> Mapping[str, float]:
        """Reject what is no relative standard deviation."""
        return {name: relative_deviation(value, name) for name, value in spread.items()}

    @classmethod
    def _fields_of(cls, inputs: Inputs, faults: Faults) -> dict[str, Any]:
        """Return the values by field.

        A grade may be created within a problem, whose width and thickness must not convert its
        values: they are no longer the outer ones.
        """
        inputs.outer = None
        return super()._fields_of(inputs, faults)

    @property
    def material(self) -> Orthotropic:
        """The elastic constants of the web."""
        return self._orthotropic(self.web_radial)

    @property
    def roll_material(self) -> Orthotropic:
        """The elastic constants of the roll as a linear material in a nip."""
        return self._orthotropic(self.roll_radial)

    def _orthotropic(self, radial: float) -> Orthotropic:
        """Return the moduli of the layers for a radial modulus [Pa]."""
        return Orthotropic(
            radial=radial, tangential=self.tangential, cross=self.cross, shear=self.roll_shear
        )

    @property
    def stack(self) -> Stack:
        """The layers in a roll, which harden under pressure."""
        return Stack(
            radial=Pfeiffer(K1=self.K1, K2=self.K2),
            tangential=self.tangential,
            poissons_ratio=self.poissons_ratio,
            shear=self.stack_shear,
        )

    def web(self) -> Web:
        """Return the web."""
        return Web(thickness=self.thickness, material=self.material)

    def roll(
        self,
        radius: float | str,
        core_radius: float | str,
        pressure: float | str | Profile | None = None,
    ) -> Cylinder | WoundRoll:
        """Return a roll of the grade for a nip.

        Parameters
        ----------
        radius, core_radius : float or str
            R and R0 [m].
        pressure : float, str or Profile, optional
            Wound into the roll [Pa]: the roll then hardens under the nip.  Without it the roll is a
            linear cylinder.
        """
        if pressure is None:
            return Cylinder(radius=radius, core_radius=core_radius, material=self.roll_material)
        return WoundRoll(
            radius=radius, core_radius=core_radius, stack=self.stack, pressure=pressure
        )

    def spread_of(self, problem: Description) -> dict[str, float]:
        """Return the relative standard deviations of the fields of a problem, by dotted name.

        Coefficients of changes that a roll does not have are left out.
        """
        without_effect = getattr(problem, "unused", ())
        return {
            path: self.spread[name]
            for path, name in _FIELDS
            if name in self.spread
            and field_or_none(problem, path) is not None
            and not (name in OF_WEB and path in without_effect)
        }

    def tied_fields(self, problem: Description) -> dict[str, str]:
        """Return the fields with the same value of the grade as another one: follower -> leader."""
        leaders, ties = dict[str, str](), dict[str, str]()
        names = dict(_FIELDS)
        for path in self.spread_of(problem):
            leader = leaders.setdefault(names[path], path)
            if path != leader:
                ties[path] = leader
        return ties

    def __str__(self) -> str:
        rows = [f"{self.name}: {self.title}"]
        for name, text in self.texts():
            spread = f"{100 * self.spread[name]:.3g} %" if name in self.spread else ""
            rows.append(
                f"  {name:<26}{text:>18}  {spread:>5}  {self.sources.get(name, '')}".rstrip()
            )
        return "\n".join(rows)

    def texts(self) -> Iterator[tuple[str, str]]:
        """Yield (name, text with unit) of all values that are set, of limits only with a source."""
        for holder, prefix in ((self, ""), (self.limits, "limits.")):
            for name, field in type(holder).model_fields.items():
                quantity, value = quantity_of(field), getattr(holder, name)
                if (
                    quantity is not None
                    and value is not None
                    and (not prefix or f"limits.{name}" in self.sources)
                ):
                    yield f"{prefix}{name}", _text(value, quantity)


def _text(value: Any, quantity: Quantity) -> str:
    """Return a value [SI] as text with its unit; of a pair "LOW to HIGH"."""
    if isinstance(value, tuple):
        return " to ".join(_text(item, quantity) for item in value)
    # a basis weight that was converted has rounding errors
    text = text_with_unit(float(f"{value:.6g}"), quantity.unit, quantity.display)
    return text if isinstance(text, str) else f"{text:.6g}"  # a pure number has no text


# Fields of problems that a grade supplies, and the value of the grade that they hold.
_FIELDS = (
    ("web.thickness", "thickness"),
    ("web_thickness", "thickness"),
    ("web.material.radial", "web_radial"),
    ("web.material.tangential", "tangential"),
    ("web.material.cross", "cross"),
    ("web.material.shear", "roll_shear"),
    ("roll.material.radial", "roll_radial"),
    ("roll.material.tangential", "tangential"),
    ("roll.material.cross", "cross"),
    ("roll.material.shear", "roll_shear"),
    *(
        (f"{roll}{path}", name)
        for roll in ("", "roll.")
        for path, name in (
            ("stack.radial.K1", "K1"),
            ("stack.radial.K2", "K2"),
            ("stack.tangential", "tangential"),
            ("stack.shear", "stack_shear"),
            ("stack.poissons_ratio", "poissons_ratio"),
        )
    ),
    ("roll_friction", "friction"),
    ("drum_friction", "drum_friction"),
    ("density", "density"),
    ("air.roughness", "roughness"),
    *((name, name) for name in OF_WEB),
)


# ---- the list -----------------------------------------------------------------------------------


class Grades(dict[str, Grade]):
    """Grades by name; printing it lists them."""

    def __repr__(self) -> str:
        return "\n".join(f"{name:<18}{grade.title}" for name, grade in self.items())

    __str__ = __repr__


def grades(path: str | Path | None = None) -> Grades:
    """Return all grades by name.

    >>> import woundon as wo
    >>> "newsprint" in wo.grades()
    True

    Parameters
    ----------
    path : path, optional
        A TOML file with grades of your own, added to those of the package.

    Raises
    ------
    InvalidProblem
        If the file cannot be read, or a grade in it has an invalid value.
    """
    known_grades = Grades()
    tables = [library("grades")["grades"], *([] if path is None else [read_file(path)])]
    for known in tables:
        for name, table in known.items():
            known_grades[name] = _make_grade(name, table, known_grades, f"grades.{name}")
    return known_grades


def grade(name: str | Grade | Mapping[str, Any], path: str | Path | None = None) -> Grade:
    """Return a grade by its name.

    >>> import woundon as wo
    >>> newsprint = wo.grade("newsprint")
    >>> newsprint.web().thickness
    6.6e-05
    >>> newsprint.spread["K2"], newsprint.sources["thickness"]
    (0.3, 'Table 2')

    Parameters
    ----------
    name : str
        Such as "newsprint"; :func:`grades` lists them.  A grade itself is returned as it is, and a
        table makes one.
    path : path, optional
        A TOML file with grades of your own::

            [grades.our-newsprint]
            like = "newsprint"
            thickness = "64 um"
            friction = { value = 0.22, spread = 0.05, source = "laboratory" }

    Raises
    ------
    InvalidProblem
        For an unknown name, with the nearest known one, and as of :func:`grades`.
    """
    if isinstance(name, Grade):
        return name
    if isinstance(name, Mapping):
        return _make_grade("own grade", table=name, known=grades(), where="grade")
    tables = library("grades")["grades"]
    if path is None and isinstance(name, str) and name in tables:
        # only this one, which is like no other grade of the package
        return _make_grade(name, tables[name], known=Grades(), where="grade")
    return _named(name, grades(path), where="grade")


def _named(name: Any, known: Mapping[str, Grade], where: str) -> Grade:
    """Return a known grade by its name; ``where`` is the field of the name."""
    if not isinstance(name, str) or name not in known:
        text = f"{quote(name)} is not a known grade{did_you_mean(name, known)}"
        raise InvalidProblem.at(where, text)
    return known[name]


def _make_grade(
    name: str, table: Mapping[str, Any], known: Mapping[str, Grade], where: str
) -> Grade:
    """Create the grade of a table; missing values are those of the grade named by ``like``.

    Parameters
    ----------
    name : str
    table : mapping
        Values, and ``like``, the name of a grade.
    known : mapping
        The grades that ``like`` may name.
    where : str
        Name of the table, for the error message.
    """
    try:
        entry = entry_of({key: value for key, value in table.items() if key != "like"})
        if table.get("like") is None:
            fields = {"name": name, "title": name, **nest_tables(entry.values)}
            return Grade(**fields | {"spread": entry.spread, "sources": entry.sources})
        base = _named(table["like"], known, where="like")
        spread = {key: value for key, value in base.spread.items() if key not in entry.values}
        sources = {key: value for key, value in base.sources.items() if key not in entry.values}
        changes = {"name": name, "title": name, **entry.values}
        changes |= {"spread": spread | entry.spread, "sources": sources | entry.sources}
        return base.replace(**changes)
    except InvalidProblem as fault:
        raise fault.under(where) from None
    except RecursionError:
        raise InvalidProblem.at(where, "is nested too deeply") from None


# ---- in a case ----------------------------------------------------------------------------------


def with_grade(model: type[Any], fields: Mapping[str, Any], faults: Faults) -> dict[str, Any]:
    """Return the fields of a problem, completed by those of its grade.

    A value that is given next to the grade has precedence; :func:`warn_of_contradictions` names it.
    A basis weight of the web is converted with the density of the grade.

    Parameters
    ----------
    model : type
        Class of the problem.
    fields : mapping
        With ``grade``: a name, a table or a :class:`Grade`.
    faults : list
        A grade that cannot be read is appended here, (field, text).
    """
    completed = dict(fields)
    try:
        named_grade = grade(completed.pop("grade"))
    except InvalidProblem as fault:
        faults += fault.faults
        # an empty text: no further error that they are missing or incomplete
        faults += [(name, "") for name in model.graded]
        return {name: value for name, value in completed.items() if name not in model.graded}
    if not model.graded:
        faults.append(("grade", f"a {model.__name__} has no web; must be left out"))
        return completed
    web = completed.get("web")
    if isinstance(web, Mapping) and is_basis_weight(web.get("thickness")):
        completed["web"] = {"density": named_grade.density, **web}
    for name, value in _fields_of_grade(named_grade, model, completed).items():
        completed[name] = _merge_tables(completed[name], value) if name in completed else value
    return completed


def changes_of_grade(
    grade: Grade, problem: Description, changes: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the values by dotted name that replace those of a problem's previous grade.

    Parameters
    ----------
    grade : Grade
    problem : Problem
    changes : mapping
        Other changes by dotted name, which have precedence.
    """
    # the tables that decide what the grade supplies in them
    parts = {
        name: _table(part)
        for name in ("roll", "air")
        if isinstance(part := getattr(problem, name, None), Description)
    }
    values: dict[str, Any] = {}
    for name, value in _fields_of_grade(grade, type(problem), parts).items():
        nested = name in parts or name in ("web", "limits")
        values |= {f"{name}.{k}": v for k, v in value.items()} if nested else {name: value}
    return {
        path: value
        for path, value in values.items()
        if not any(is_part_of(path, changed) for changed in changes)
    }


def states_all(problem: Description, named_grade: Grade) -> bool:
    """Return True if a problem has a value for everything that a grade would supply."""
    return all(
        _has_values(field_or_none(problem, path), supplied)
        for path, supplied in changes_of_grade(named_grade, problem, {}).items()
    )


def _has_values(part: Any, supplied: Any) -> bool:
    """Return True if a part of a problem has a value for each name of a table."""
    if isinstance(part, Description) and isinstance(supplied, Mapping):
        return all(
            _has_values(field_or_none(part, name), value)
            for name, value in supplied.items()
            if name != "kind"
        )
    return part is not None


def source_of_limit(
    name: str,
    value: float,
    thickness: float,
    tangential: float,
    named_grade: Grade | None = None,
) -> str:
    """Return the grade that a limit comes from and its source; "" if it is no grade's limit.

    Parameters
    ----------
    name : str
        Field of :class:`Limits`.
    value : float
        The limit [SI].
    thickness, tangential : float
        Of the web [m], [Pa].  They identify a grade of the package.
    named_grade : Grade, optional
        The grade that the problem was created with, which may be one of the user's own.
    """
    for known in (*([] if named_grade is None else [named_grade]), *_library()):
        is_same_web = (
            abs(known.thickness - thickness) <= SAME * thickness
            and abs(known.tangential - tangential) <= SAME * tangential
        )
        if getattr(known.limits, name) == value and (known is named_grade or is_same_web):
            return f"grade {known.name}, {known.sources.get(f'limits.{name}', 'no source given')}"
    return ""


@cache
def _library() -> tuple[Grade, ...]:
    return tuple(grades().values())


def warn_of_contradictions(named_grade: Grade, problem: Description) -> None:
    """Warn of values of a problem that differ from those of its grade."""
    texts = []
    for path, name in _FIELDS:
        value = field_or_none(problem, path)
        grade_value = getattr(named_grade, name)
        if grade_value is None:  # of a coefficient whose value is not known
            continue
        if isinstance(value, float) and abs(value - grade_value) > SAME * abs(grade_value):
            quantity = quantity_of(Grade.model_fields[name])
            assert quantity is not None
            texts.append(
                f"{path} = {_text(value, quantity)} replaces the {_text(grade_value, quantity)} "
                f"of the grade {named_grade.name!r}"
            )
    warn(texts, InputWarning)


def _fields_of_grade(
    named_grade: Grade, model: type[Any], fields: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the fields of a problem that a grade supplies, values or tables by name.

    Parameters
    ----------
    named_grade : Grade
    model : type
        Class of the problem.
    fields : mapping
        Fields of the problem that are given, of which a table ``roll`` decides by its kind what is
        supplied for it, and a table ``air`` receives the roughness.
    """
    known: dict[str, Any] = {
        "web": {"thickness": named_grade.thickness, "material": _table(named_grade.material)},
        "web_thickness": named_grade.thickness,
        "density": named_grade.density,
        "stack": _table(named_grade.stack),
        "limits": _table(named_grade.limits),
        "roll_friction": named_grade.friction,
        "drum_friction": named_grade.drum_friction,
        # 0 replaces the coefficient of a previous grade
        **{name: getattr(named_grade, name) or 0.0 for name in OF_WEB},
    }
    roll, air = fields.get("roll"), fields.get("air")
    if isinstance(roll, Mapping):
        # of other bodies, as a layered one, a grade supplies nothing
        is_wound = roll.get("kind") == "wound_roll" or "pressure" in roll
        is_plain = roll.get("kind", "cylinder") in ("cylinder", "half_plane")
        if is_wound:
            known["roll"] = {"stack": _table(named_grade.stack)}
        elif is_plain:
            known["roll"] = {"material": _table(named_grade.roll_material)}
    supplied = {name: known[name] for name in model.graded if name in known}
    if isinstance(air, Mapping):
        supplied["air"] = {"roughness": named_grade.roughness}
    return supplied


def _table(part: Description) -> dict[str, Any]:
    return part.model_dump(exclude_none=True)


def _merge_tables(explicit: Any, supplied: Any) -> Any:
    """Return given values completed by supplied ones; tables in tables are completed alike.

    A given value that is no table, or a table of another kind, is returned unchanged.
    """
    if not isinstance(explicit, Mapping) or not isinstance(supplied, Mapping):
        return explicit
    kinds = {part.get("kind") for part in (explicit, supplied)} - {None}
    if len(kinds) > 1:
        return explicit
    merged = dict(supplied)
    for name, value in explicit.items():
        merged[name] = _merge_tables(value, supplied[name]) if name in supplied else value
    return merged

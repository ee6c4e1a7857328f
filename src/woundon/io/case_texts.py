"""Write case files, and the template that ``woundon new`` prints.

Names, units, ranges and descriptions are those of the fields of the problem.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from pydantic.fields import FieldInfo

from .. import kinds
from ..errors import InvalidProblem, one_of
from ..problems.description import Description, is_unset
from ..problems.family import Family
from ..problems.grades import grade, grades, states_all
from ..problems.materials import MATERIALS, Material
from ..problems.permitted import bounds, requirement, words_of
from ..problems.problem import Problem
from ..problems.units import text_with_unit
from ..quantities import Quantity, is_list, members_of, quantity_of
from .files import write_whole

__all__ = [
    "FILE_KEYS",
    "SCHEMA",
    "field_comment",
    "field_ranges",
    "grade_template",
    "material_name",
    "save_case",
    "template",
    "to_toml",
    "toml_value",
]

SCHEMA = 1
FILE_KEYS = ("csv", "log")  # of a file in place of the lists of a table
UNSET = "..."  # in place of the value of an optional field that is not set
_TABLE, _TABLES = "a table of its fields", "tables of their fields"
_NAME_OR_TABLE = f"a name ('woundon materials' lists them), or {_TABLE}"
_WIDTH = 100
_LONGEST_ALIGNED = 24  # characters of a value; the comment of a longer one starts further right
_UNBREAKABLE = "\N{NO-BREAK SPACE}"  # in a comment, where a line must not be broken

_HEADER = """\
{about}

  woundon solve case.toml                            solve it
  woundon solve case.toml --set {setting:<20} change a value for this run
  woundon solve case.toml --plot case.png --save case.nc

A value is a text with its unit ("66 um", "3.38 GPa", "20 pli", "19 %") or a plain number in SI.
Loads and tensions are per metre of width.  Fields outside of a [section] come first.

Each comment gives symbol, description, typical range and, in parentheses, the permitted range."""

TomlValue: TypeAlias = "bool | str | float | tuple[TomlValue, ...] | list[TomlValue]"


def template(kind: str = "nip") -> str:
    """Return the text of a commented case file that is ready to run.

    Parameters
    ----------
    kind : str
        Name of the kind of problem, with hyphens or underscores.

    Raises
    ------
    InvalidProblem
        For an unknown kind, or one that has no example.

    Examples
    --------
    >>> print(template("rollers").splitlines()[0])
    # Two rollers in contact without a web, rolling or static.
    """
    return to_toml(kinds.named(kind).example(), comments=True)


_GRADE_CASE = """\
# {about}
#
# Grade: {title}.  It supplies what is not stated here;
# 'woundon grades {grade}' lists its values, 'woundon describe {kind}' all fields.
# A value is a text with its unit: "20 pli", "1.5 kN/m", "30 in", "60 gsm" for the thickness; with
# the width of the web also a total, "3.6 kN"; for the web tension also a stress, "5 MPa".
# The web tension is half of the wound-on tension that is usual for the grade, {wound_on}: the nip
# adds about as much.

schema        = {schema}
grade         = {grade_and_file}
width         = "1.2 m"
web_tension   = "{web_tension}"
nip_load      = "2 kN/m"
{winder}
[web]
thickness     = "{thickness}"

[drum]
kind          = "rigid"
diameter      = "0.8 m"
"""
_GRADE_WINDERS = {
    "nip": """
[roll]
diameter      = "1 m"
core_diameter = "100 mm"
""",
    "winding": """\
diameter      = "1.2 m"

[core]
diameter      = "100 mm"
stiffness     = "1 GPa"
""",
}


def grade_template(kind: str, grade_name: str, file: str | None = None) -> str:
    """Return the text of a short case file of a grade: the inputs that depend on the winder.

    Parameters
    ----------
    kind : str
        "nip" or "winding".
    grade_name : str
        Name of the grade.
    file : str, optional
        A TOML file with grades of your own.

    Examples
    --------
    >>> grade_template("nip", "uncoated-fine").splitlines()[-1]
    'diameter      = "0.8 m"'
    """
    if kind not in _GRADE_WINDERS:
        must = one_of(_GRADE_WINDERS)
        raise InvalidProblem.at("kind", f"{kind!r} has no short case; must be {must}")
    values, quoted = grade(grade_name, file), json.dumps(grade_name)
    return _GRADE_CASE.format(
        about=kinds.named(kind).about,
        title=values.title,
        grade=grade_name,
        kind=kind,
        schema=SCHEMA,
        grade_and_file=f"{quoted}\ngrades        = {json.dumps(file)}" if file else quoted,
        wound_on=text_with_unit(values.tension, "N/m"),
        web_tension=text_with_unit(values.tension / 2, "N/m"),  # the nip adds about as much
        winder=_GRADE_WINDERS[kind],
        thickness=text_with_unit(values.thickness, "m", "um"),
    )


def to_toml(problem: Problem, comments: bool = False, under: str = "") -> str:
    """Return the case file of a problem; reading it gives an equal problem.

    Parameters
    ----------
    problem : Problem
        Of any kind.
    comments : bool
        Add instructions, and to each field its symbol, description, unit and ranges; a material
        that has a name is written as this name at its first occurrence.
    under : str
        The table of another file that contains the case; the header is omitted.

    Returns
    -------
    str
        Numbers as texts with units where that is readable and exact, otherwise in SI.
    """
    sections = list(_Writer(comments).sections(problem, under))
    lines = [*_header(problem), ""] if comments and not under else []
    lines += _aligned_lines(sections, comments)
    return "\n".join(lines).rstrip() + "\n"


def save_case(problem: Problem, path: Path) -> None:
    """Write the case file of a problem, without comments."""
    write_whole(path, to_toml(problem).encode())


def _header(problem: Problem) -> list[str]:
    """Return the comment at the top of a case file, which explains its use."""
    quantities = {n: quantity_of(info) for n, info in type(problem).model_fields.items()}
    # of --set in the header: fields at the upper end of their typical range
    settings = (
        f"{name}={toml_value(quantity.typical[1], quantity)}"
        for name, quantity in quantities.items()
        if quantity and quantity.unit != "1" and quantity.typical
    )
    text = _HEADER.format(about=kinds.of(problem).about, setting=next(settings, "FIELD=VALUE"))
    return [f"# {line}".rstrip() for line in text.split("\n")]


# ---- from a problem to sections -----------------------------------------------------------------


class Row(NamedTuple):
    """A line of the file: name, value as TOML, comment; the value is UNSET if it is not set."""

    key: str
    value: str
    comment: str = ""


class Section(NamedTuple):
    """A table of the file with its rows; that of the problem itself may have no header."""

    header: str
    rows: list[Row]
    comment: str = ""


@dataclass
class _Writer:
    """Converts a problem to sections.

    Attributes
    ----------
    comments : bool
        Whether the file has comments: then unset fields are listed, and names of materials used.
    named : set of str
        Materials that were written by their name.
    listed : set of type
        Members of families whose fields were listed in a comment.
    """

    comments: bool
    named: set[str] = field(default_factory=set)
    listed: set[type[Any]] = field(default_factory=set)

    def sections(self, problem: Problem, under: str) -> Iterator[Section]:
        """Yield the sections of a problem: its own fields, its groups, then nested descriptions."""
        prefix = f"{under}." if under else ""
        own, *nested = self.description(problem, prefix, f"[{under}]" if under else "")
        schema = [] if under else [Row("schema", str(SCHEMA), "version of the format")]
        yield own._replace(rows=[*schema, *_grade_rows(problem), *own.rows])
        for group, names in problem.tables.items():
            rows = [self.row(problem, name) for name in names if self.is_shown(problem, name)]
            yield Section(f"[{prefix}{group}]", rows)
        yield from nested

    def description(
        self,
        thing: Description,
        prefix: str,
        header: str,
        holder: FieldInfo | None = None,
        quantity: Quantity | None = None,
    ) -> Iterator[Section]:
        """Yield the section of a description, then those of the descriptions in it.

        Parameters
        ----------
        thing : Description
            The problem, or a body, material, ... in it.
        prefix : str
            Beginning of the dotted names of its fields.
        header : str
            First line of the section.
        holder : FieldInfo, optional
            The field that holds the description; None for a problem.
        quantity : Quantity, optional
            That of this field, which the values of a profile have.
        """
        # the fields of a group have a section of their own (:meth:`sections`)
        grouped = {name for names in getattr(thing, "tables", {}).values() for name in names}
        fields = {n: f for n, f in type(thing).model_fields.items() if n not in grouped}
        inner = [name for name in fields if self.is_nested(getattr(thing, name))]
        rows = [self.kind_row(thing, holder)] if isinstance(thing, Family) and holder else []
        rows += [
            self.row(thing, name, quantity)
            for name in fields
            if name not in inner and self.is_shown(thing, name)
        ]
        # of a schedule: symbol, meaning and ranges of its values
        yield Section(header, rows, "" if holder is None else field_comment(holder))
        for name in inner:
            value, path = getattr(thing, name), f"{prefix}{name}"
            # TOML writes each item of a list as [[name]]
            items, form = (value, "[[{}]]") if isinstance(value, tuple) else ((value,), "[{}]")
            quantity_inside = quantity_of(fields[name], quantity)
            for item in items:
                yield from self.description(
                    item, f"{path}.", form.format(path), fields[name], quantity_inside
                )

    def is_shown(self, thing: Description, name: str) -> bool:
        """Return True if a field is written: if it is set, or if the file has comments."""
        return self.comments or not is_unset(getattr(thing, name))

    def is_nested(self, value: Any) -> bool:
        """Return True if a value is written as sections.

        With comments, a named material is written as its name the first time that this is called
        for it, which ``self.named`` records, and as a section after that.
        """
        if isinstance(value, tuple):
            return any(isinstance(item, Description) for item in value)
        name = material_name(value) if self.comments else None
        if name is None or name in self.named:
            return isinstance(value, Description)
        self.named.add(name)
        return False

    def row(self, thing: Description, name: str, of_field: Quantity | None = None) -> Row:
        """Return the line of a field that has no section of its own (:meth:`is_nested`).

        It has the value, "..." if it is not set, or the name of a material.

        Parameters
        ----------
        thing : Description
            The description that has the field.
        name : str
            The field.
        of_field : Quantity, optional
            That of the field which holds the description: fields that are the values of a profile
            have no other.
        """
        value, info = getattr(thing, name), type(thing).model_fields[name]
        if is_unset(value):
            return Row(name, UNSET, _comment_of_unset(info, of_field))
        if isinstance(value, Description):
            material = material_name(value)
            assert material is not None  # others have sections
            return Row(name, toml_value(material), _NAME_OR_TABLE)
        return Row(name, toml_value(value, quantity_of(info, of_field)), field_comment(info))

    def kind_row(self, thing: Family, holder: FieldInfo) -> Row:
        """Return the line with the kind of a description; its comment lists the alternatives.

        The fields of an alternative are stated the first time that it is listed in the file:
        ``self.listed``, which is extended, remembers those that were.

        Parameters
        ----------
        thing : Family
            Body, material or law of which there are several kinds.
        holder : FieldInfo
            The field that holds it, whose annotation admits all kinds.
        """
        members = members_of(holder.annotation)
        names = []
        for member in members:
            if issubclass(member, Family) and member is not type(thing):
                fields = "" if member in self.listed else f" ({', '.join(member.model_fields)})"
                names.append(f"{member.member_name()}{fields}")
        self.listed.update(members)
        return Row(
            "kind", toml_value(thing.member_name()), f"or {', '.join(names)}" if names else ""
        )


def _grade_rows(problem: Problem) -> list[Row]:
    """Return the line with the grade, from which studies take the spreads of the values.

    There is none for a grade of the user's own file, whose place is not known, and for a problem
    without a value that the grade would supply.
    """
    named_grade = getattr(problem, "named_grade", None)
    if named_grade is None or grades().get(named_grade.name) != named_grade:
        return []
    if not states_all(problem, named_grade):
        return []
    comment = "supplies what is not stated here, and the spreads of the values"
    return [Row("grade", toml_value(named_grade.name), comment)]


def material_name(value: Any) -> str | None:
    """Return the name of a material; None for a material without one and for any other value."""
    return next((name for name, known in MATERIALS.items() if known.material == value), None)


# ---- from sections to lines ---------------------------------------------------------------------


def _aligned_lines(sections: Sequence[Section], comments: bool) -> Iterator[str]:
    """Yield the lines of sections, and an empty line after each.

    Equals signs and comments are aligned in the file, without comments the signs in each section.
    """
    rows = [row for section in sections for row in section.rows]
    key_width = max(len(row.key) for row in rows)
    value_width = max(min(len(row.value), _LONGEST_ALIGNED) for row in rows)
    for section in sections:
        if not comments:
            key_width = max((len(row.key) for row in section.rows), default=0)
        lines = [(section.header, section.comment)] if section.header else []
        for row in section.rows:
            is_set = row.value != UNSET  # a field that is not set is a comment
            name = row.key.ljust(key_width) if is_set else f"# {row.key}"
            lines.append((f"{name} = {row.value}", row.comment))
        for text, comment in lines:
            column = key_width + len(" = ") + value_width
            yield from _with_comment(text, comment if comments else "", column)
        yield ""


def _with_comment(text: str, comment: str, column: int) -> list[str]:
    """Return the lines of a text with a wrapped comment that starts at a column."""
    if not comment:
        return [text]
    width = max(_WIDTH - column - len("  # "), 30)  # at least some words
    parts = textwrap.wrap(comment, width, break_long_words=False)
    first, *others = (part.replace(_UNBREAKABLE, " ") for part in parts)
    return [f"{text.ljust(column)}  # {first}", *(f"{'':{column}}  # {part}" for part in others)]


def toml_value(value: TomlValue, quantity: Quantity | None = None) -> str:
    """Return the value of a field as TOML; a number of a quantity as a text with its unit.

    A number for which no text with a unit is exact is written as a plain number in SI.

    >>> from woundon.quantities import length
    >>> toml_value(66e-6, length("2h", "web thickness", "um")), toml_value((0.5, 1.0))
    ('"66 um"', '[0.5, 1.0]')
    """
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(toml_value(item, quantity) for item in value)}]"
    if quantity is not None and not isinstance(value, (bool, str)):
        text = text_with_unit(float(value), quantity.unit, quantity.display)
        value = text if isinstance(text, str) else value
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


# ---- description of a field --------------------------------------------------------------------


def field_comment(field: FieldInfo) -> str:
    """Return symbol, meaning, typical and allowed range of a field, in the unit for display.

    For a field without a quantity: the words that it may be, else its description.
    """
    quantity = quantity_of(field)
    if quantity is None:
        words = words_of(field)
        return one_of(map(json.dumps, words)) if words else field.description or ""
    text, ranges = f"{quantity.symbol}: {quantity.meaning}", field_ranges(field, quantity)
    if ranges:
        # "meaning, typical range (permitted range)", which is only broken before the parenthesis
        comma = "" if ranges.startswith("(") else ","
        text += f"{comma} {ranges.replace(' ', _UNBREAKABLE).replace(f'{_UNBREAKABLE}(', ' (')}"
    note = requirement(field)
    return text if not note or note.startswith("default") else f"{text}; {note}"


def _comment_of_unset(field: FieldInfo, of_field: Quantity | None) -> str:
    """Return the comment of a field that is not set, which states whether it is a table."""
    comment, members = field_comment(field), members_of(field.annotation)
    if quantity_of(field, of_field) is not None or not members:
        return comment
    form = _TABLES if is_list(field.annotation) else _TABLE
    if any(issubclass(member, Material) for member in members):
        form = _NAME_OR_TABLE
    return "; ".join(filter(None, (comment, form)))


def field_ranges(field: FieldInfo, quantity: Quantity, with_unit: bool = True) -> str:
    """Return the typical range of a field and, in parentheses, the allowed range.

    >>> from woundon import NipProblem
    >>> from woundon.quantities import quantity_of
    >>> field = NipProblem.model_fields["roll_friction"]
    >>> field_ranges(field, quantity_of(field))
    '0.1 to 0.6 (1e-08 to 10)'
    """
    typical, limits = "", _limits(field, quantity)
    if quantity.typical:
        typical = " to ".join(_number(quantity.shown(end)) for end in quantity.typical)
    unit = f" {quantity.display}" if with_unit and quantity.display else ""
    parts = [f"{typical}{unit}"] if typical else []
    if limits and limits != typical:
        parts.append(f"({limits})" if typical else f"({limits}{unit})")
    return " ".join(parts)


def _limits(field: FieldInfo, quantity: Quantity) -> str:
    """Return the permitted range: "0 to 10", "> 0", "0 to < 0.5"."""
    ends = dict(bounds(field))  # ">=", ">", "<=" or "<" -> end, the lower one first
    ends_shown = {sign: _number(quantity.shown(end)) for sign, end in ends.items()}
    if len(ends_shown) == 2:
        marks = {">": "> ", "<": "< "}  # of ends that are not permitted themselves
        return " to ".join(f"{marks.get(sign, '')}{end}" for sign, end in ends_shown.items())
    return "".join(f"{sign} {end}" for sign, end in ends_shown.items())


def _number(value: float) -> str:
    """Return an end of a range as text."""
    return f"{value:.6g}"

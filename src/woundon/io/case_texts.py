"""Write case files, and the template that ``woundon new`` prints.

Names, units, ranges and descriptions are those of the fields of the problem.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple, get_args

from .. import kinds
from ..errors import InvalidProblem, one_of
from ..problems.description import Description
from ..problems.family import Family
from ..problems.grades import grade, grades, states_all
from ..problems.materials import MATERIALS
from ..problems.permitted import bounds, requirement
from ..problems.problem import Problem
from ..problems.units import text_with_unit
from ..quantities import Quantity, members_of, quantity_of

__all__ = ["SCHEMA", "field_comment", "field_ranges", "grade_template", "template", "to_toml"]

SCHEMA = 1
_WIDTH = 100
_UNBREAKABLE = "\N{NO-BREAK SPACE}"  # in a comment, where a line must not be broken

_HEADER = """\
{about}

  woundon solve case.toml                            solve it
  woundon solve case.toml --set {setting:<20} change a value for this run
  woundon solve case.toml --plot case.png --save case.nc

A value is a text with its unit ("66 um", "3.38 GPa", "20 pli", "19 %") or a plain number in SI.
Loads and tensions are per metre of width.  Fields outside of a [section] come first.

Each comment gives symbol, description, typical range and, in parentheses, the permitted range."""


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
    return to_toml(kinds.named(kind.replace("-", "_")).example(), comments=True)


_GRADE_HEADER = """\
# {about}
#
# Grade: {title}.  It supplies what is not stated here;
# 'woundon grades {grade}' lists its values, 'woundon describe {kind}' all fields.
# A value is a text with its unit: "20 pli", "1.5 kN/m", "30 in", "60 gsm" for the thickness; with
# the width of the web also a total, "3.6 kN"; for the web tension also a stress, "5 MPa".
# The web tension is half of the wound-on tension that is usual for the grade, {wound_on}: the nip
# adds about as much.
"""
_GRADE_ROWS = {
    "nip": (
        ("nip_load", "2 kN/m"),
        ("[roll]",),
        ("diameter", "1 m"),
        ("core_diameter", "100 mm"),
    ),
    "winding": (
        ("nip_load", "2 kN/m"),
        ("diameter", "1.2 m"),
        ("[core]",),
        ("diameter", "100 mm"),
        ("stiffness", "1 GPa"),
    ),
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
    if kind not in _GRADE_ROWS:
        raise InvalidProblem.at(
            "kind", f"{kind!r} has no short case; must be {one_of(_GRADE_ROWS)}"
        )
    grade_data, summary = grade(grade_name, file), kinds.named(kind).about
    # the nip adds about as much as the winder pulls
    wound_on, web_tension = (text_with_unit(grade_data.tension * k, "N/m") for k in (1.0, 0.5))
    rows = [
        ("grade", grade_name),
        *([("grades", file)] if file else []),
        ("width", "1.2 m"),
        ("web_tension", str(web_tension)),
        *_GRADE_ROWS[kind],
        ("[web]",),
        ("thickness", str(text_with_unit(grade_data.thickness, "m", "um"))),
        ("[drum]",),
        ("kind", "rigid"),
        ("diameter", "0.8 m"),
    ]
    lines = [f"schema        = {SCHEMA}"]
    for name, *value in rows:
        lines.append(f"{name:<13} = {json.dumps(value[0])}" if value else f"\n{name}")
    header = _GRADE_HEADER.format(
        about=summary, grade=grade_name, title=grade_data.title, kind=kind, wound_on=wound_on
    )
    return header + "\n" + "\n".join(lines) + "\n"


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
    sections = list(_Writer(comments).problem(problem))
    lines = [*_header(problem), ""] if comments and not under else []
    if under:
        first, *others = (section.under(under) for section in sections)
        sections = [first._replace(rows=first.rows[1:]), *others]  # without the schema
    keys = max(len(row.key) for section in sections for row in section.rows)
    values = max(min(len(row.value), 24) for section in sections for row in section.rows)
    for section in sections:
        lines += section.lines(keys if comments else 0, values)
    return "\n".join(lines).rstrip() + "\n"


def _header(problem: Problem) -> list[str]:
    """Return the comment at the top of a case file, which explains its use."""
    kind = kinds.of(problem)
    known = {n: quantity_of(info) for n, info in type(problem).model_fields.items()}
    settings = [
        f"{n}={_value(q.typical[1], q)}"
        for n, q in known.items()
        if q and q.unit != "1" and q.typical
    ]
    text = _HEADER.format(about=kind.about, setting=[*settings, "FIELD=VALUE"][0])
    return [f"# {line}".rstrip() for line in text.split("\n")]


# ---- rows and sections --------------------------------------------------------------------------


class Row(NamedTuple):
    """A line of the file; without a value it is an optional field that is not set."""

    key: str
    value: str
    comment: str = ""

    def lines(self, keys: int, values: int) -> list[str]:
        """Return the line with its comment, aligned with the others and wrapped."""
        text = f"{self.key.ljust(keys)} = {self.value}"
        if self.value == "...":
            text = f"# {self.key} = ..."
        return _commented(text, self.comment, keys + 3 + values)


class Section(NamedTuple):
    """A table of the file with its rows; the first one has no header."""

    header: str
    rows: list[Row]
    comment: str = ""

    def under(self, table: str) -> Section:
        """Return the section nested in a table."""
        path = ".".join(filter(None, (table, self.header.strip("[]"))))
        item = self.header.startswith("[[")
        return self._replace(header=f"[[{path}]]" if item else f"[{path}]")

    def lines(self, keys: int, values: int) -> list[str]:
        """Return the lines of the section and an empty line."""
        key_width = keys or max(
            (len(row.key) for row in self.rows if row.value != "..."), default=0
        )
        head = _commented(self.header, self.comment, key_width + 3 + values) if self.header else []
        return [*head, *(line for row in self.rows for line in row.lines(key_width, values)), ""]


def _commented(text: str, comment: str, column: int) -> list[str]:
    """Return the lines of a text with a wrapped comment that starts at a column."""
    if not comment:
        return [text]
    parts = textwrap.wrap(comment, max(_WIDTH - column - 4, 30), break_long_words=False)
    first, *others = (part.replace(_UNBREAKABLE, " ") for part in parts)
    return [f"{text.ljust(column)}  # {first}", *(f"{'':{column}}  # {part}" for part in others)]


# ---- from a problem to sections -----------------------------------------------------------------


@dataclass
class _Writer:
    """Converts a problem to sections; remembers the names and kinds that were written."""

    comments: bool
    named: set[str] = field(default_factory=set)
    listed: set[type[Any]] = field(default_factory=set)

    def problem(self, problem: Problem) -> Iterator[Section]:
        """Yield the sections of a problem: its own fields, its groups, then nested descriptions."""
        grouped = {name for names in problem.tables.values() for name in names}
        top, *nested = self.description(problem, "", "", grouped)
        schema = Row("schema", str(SCHEMA), self.comment("version of the format"))
        yield Section("", [schema, *self.grade(problem), *top.rows])
        for group, names in problem.tables.items():
            yield Section(
                f"[{group}]",
                [self.row(problem, name) for name in names if self.shows(problem, name)],
                self.comment(_without(problem, group)),
            )
        yield from nested

    def grade(self, problem: Problem) -> list[Row]:
        """Return the line with the grade, from which studies take the spreads of the values.

        There is none for a grade of the user's own file, whose place is not known, and for a
        problem without a value that the grade would supply.
        """
        named_grade = getattr(problem, "named_grade", None)
        if named_grade is None or grades().get(named_grade.name) != named_grade:
            return []
        if not states_all(problem, named_grade):
            return []
        comment = "supplies what is not stated here, and the spreads of the values"
        return [Row("grade", json.dumps(named_grade.name), self.comment(comment))]

    def description(
        self,
        thing: Description,
        path: str,
        header: str,
        excluded: set[str],
        comment: str = "",
        of_field: Quantity | None = None,
        alternatives: tuple[type[Any], ...] = (),
    ) -> Iterator[Section]:
        """Yield the section of a description, then those of the descriptions in it."""
        fields = {
            name: getattr(thing, name) for name in type(thing).model_fields if name not in excluded
        }
        inner = {name: value for name, value in fields.items() if self.is_nested(value)}
        rows = [self.kind(thing, alternatives)] if isinstance(thing, Family) else []
        rows += [
            self.row(thing, name, of_field)
            for name in fields
            if name not in inner and self.shows(thing, name)
        ]
        yield Section(header, rows, comment)
        for name, value in inner.items():
            inner_path = f"{path}{name}"
            field = type(thing).model_fields[name]
            description, quantity = (
                self.comment(field.description or ""),
                quantity_of(field, of_field),
            )
            members = members_of(field.annotation)
            for item in value if isinstance(value, tuple) else (value,):
                head = f"[[{inner_path}]]" if isinstance(value, tuple) else f"[{inner_path}]"
                yield from self.description(
                    item, f"{inner_path}.", head, set(), description, quantity, members
                )

    def comment(self, comment: str) -> str:
        """Return a comment if comments are written."""
        return comment if self.comments else ""

    def shows(self, thing: Description, name: str) -> bool:
        """Return True if a field is written: if it is set, or if the file has comments."""
        return self.comments or getattr(thing, name) is not None

    def is_nested(self, value: Any) -> bool:
        """Return True if a value is written as sections; a named material is not at first."""
        if isinstance(value, tuple):
            return any(isinstance(item, Description) for item in value)
        name = _name_of(value) if self.comments else None
        if name is None or name in self.named:
            return isinstance(value, Description)
        self.named.add(name)
        return False

    def row(self, thing: Description, name: str, of_field: Quantity | None = None) -> Row:
        """Return the line of a field."""
        value, info = getattr(thing, name), type(thing).model_fields[name]
        quantity = quantity_of(info, of_field)
        if isinstance(value, Description):
            comment = "a name ('woundon materials' lists them), or a table of its fields"
            return Row(name, json.dumps(_name_of(value)), self.comment(comment))
        text = "..." if value is None else _value(value, quantity) or _plain(value)
        return Row(name, text, self.comment(field_comment(info)))

    def kind(self, thing: Family, alternatives: tuple[type[Any], ...]) -> Row:
        """Return the line with the kind of a description; the first one lists the alternatives."""
        others = [m for m in alternatives if m is not type(thing) and issubclass(m, Family)]
        names = [
            m.member_name()
            if m in self.listed
            else f"{m.member_name()} ({', '.join(m.model_fields)})"
            for m in others
        ]
        self.listed.update(alternatives)
        comment = f"or {', '.join(names)}" if names else ""
        return Row("kind", json.dumps(thing.member_name()), self.comment(comment))


def _name_of(value: Any) -> str | None:
    return next((name for name, known in MATERIALS.items() if known.material == value), None)


def _without(problem: Problem, group: str) -> str:
    """Return a comment on the problem that results if a group is omitted."""
    names = set(type(problem).model_fields) - set(problem.tables[group])
    other = kinds.for_fields(names)
    if isinstance(problem, other.problem):
        return ""
    return f"without this table: {other.about[:1].lower()}{other.about[1:].rstrip('.')}"


def _value(value: Any, quantity: Quantity | None) -> str | None:
    """Return a number with its unit as TOML; None if it has no unit."""
    if quantity is None or isinstance(value, (bool, str)) or value is None:
        return None
    if isinstance(value, tuple):
        return f"[{', '.join(_value(item, quantity) or _plain(item) for item in value)}]"
    text = text_with_unit(float(value), quantity.unit, quantity.display)
    return _plain(text) if isinstance(text, str) else None


def _plain(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(_plain, value))}]"
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


# ---- description of a field --------------------------------------------------------------------


def field_comment(field: Any) -> str:
    """Return symbol, meaning, typical and allowed range of a field, in the unit for display."""
    quantity = quantity_of(field)
    if quantity is None:
        words = [part for part in get_args(field.annotation) if isinstance(part, str)]
        return one_of(map(json.dumps, words)) if words else field.description or ""
    text, ranges = f"{quantity.symbol}: {quantity.meaning}", field_ranges(field, quantity)
    if ranges:
        comma = "" if ranges.startswith("(") else ","
        text += f"{comma} {ranges.replace(' ', _UNBREAKABLE).replace(f'{_UNBREAKABLE}(', ' (')}"
    note = requirement(field)
    return text if not note or note.startswith("default") else f"{text}; {note}"


def field_ranges(field: Any, quantity: Quantity, with_unit: bool = True) -> str:
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


def _limits(field: Any, quantity: Quantity) -> str:
    """Return the permitted range: "0 to 10", "> 0", "0 to < 0.5"."""
    ends = dict(bounds(field))
    ends_shown = {sign: _number(quantity.shown(end)) for sign, end in ends.items()}
    if len(ends_shown) == 2:
        marks = {">": "> ", "<": "< "}
        return " to ".join(f"{marks.get(sign, '')}{end}" for sign, end in ends_shown.items())
    return "".join(f"{sign} {end}" for sign, end in ends_shown.items())


def _number(value: float) -> str:
    return f"{value:.6g}"

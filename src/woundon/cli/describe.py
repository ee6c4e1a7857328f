"""The commands ``woundon describe``, ``materials`` and ``grades``: print the available names."""

from __future__ import annotations

from collections.abc import Iterator
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import click

from ..errors import one_of
from . import options

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic.fields import FieldInfo

    from ..kinds import Kind
    from ..problems.problem import Problem
    from ..quantities import Quantity
    from ..results import Result

__all__ = ["describe", "grades", "materials"]

Row = tuple[str, str, str, str]  # name, symbol, unit, meaning
WIDEST = 120  # characters of a line
LEAST_MEANING = 20  # characters of the last column


@options.command(
    "List the fields, outputs and solver options of a kind of problem. KIND is nip (the default), "
    "rollers, roll or winding. A line states name, symbol, unit, meaning, typical range and, in "
    "parentheses, permitted range."
)
@click.argument("kind", type=options.KindName(), default="nip", metavar="KIND")
def describe(kind: str) -> None:
    """List the fields, outputs and solver options of a kind of problem."""
    from .. import kinds

    described = kinds.named(kind)
    click.echo(described.about)
    for title, rows in (
        *_field_tables(described.problem),
        *_output_tables(described.result),
        ("Options of 'woundon solve'", list(_option_rows(described))),
    ):
        click.echo()
        for line in wrap(title, _width()):
            click.secho(line, bold=True)
        for line in _lines(rows):
            click.echo(line)


def _width() -> int:
    """Return the number of characters of a line."""
    return min(get_terminal_size((100, 24)).columns, WIDEST)


def _lines(rows: list[Row]) -> Iterator[str]:
    """Yield the lines of a table; the meaning is wrapped in the last column."""
    widths = [max(len(row[k]) for row in rows) for k in range(3)]  # of name, symbol, unit
    indent = sum(width + 2 for width in widths) + 1  # two spaces between columns, one before all
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row[:3], widths, strict=True))
        first, *others = wrap(row[3], max(_width() - indent, LEAST_MEANING)) or [""]
        yield f" {'  '.join(cells)}  {first}".rstrip()
        for part in others:
            yield f"{'':{indent}}{part}"


def _field_tables(problem: type[Problem]) -> Iterator[tuple[str, list[Row]]]:
    """Yield title and rows of tables: the fields of a problem, then those of its members.

    Members are the bodies, materials and laws that a field may hold; each is listed once.
    """
    graded = getattr(problem, "graded", ())
    yield (
        "Fields of a case; required unless they have a default or are optional",
        [_field_row(name, f, name in graded) for name, f in problem.model_fields.items()],
    )
    for names, members in _members(problem):
        kind: Row = ("kind", "", "", one_of(map(_member_name, members)))
        rows = [kind] if len(members) > 1 else []
        # members that have a row: a name may have another meaning in another member
        owners: dict[Row, list[type[BaseModel]]] = {}
        for member in members:
            for name, field in member.model_fields.items():
                owners.setdefault(_field_row(name, field), []).append(member)
        for (field_name, symbol, unit, meaning), some in owners.items():
            note = "" if some == members else f"[{', '.join(map(_member_name, some))}] "
            rows.append((field_name, symbol, unit, note + meaning))
        yield f"Fields of {one_of(names, 'and')}", rows


def _members(problem: type[Problem]) -> list[tuple[list[str], list[type[BaseModel]]]]:
    """Return (names of fields, classes of the descriptions that they may hold) inside a problem.

    Descriptions that one field may hold, such as the bodies, form a family and are listed together.
    """
    from ..problems.family import Family
    from ..quantities import members_of

    families: dict[type, tuple[list[str], list[type[BaseModel]]]] = {}
    waiting: list[type[BaseModel]] = [problem]
    for model in waiting:  # grows in the loop
        for name, field in model.model_fields.items():
            for member in members_of(field.annotation):
                # the base class of the family; a description without one is listed alone
                base = next((b for b in member.__mro__ if Family in b.__bases__), member)
                names, members = families.setdefault(base, ([], []))
                if name not in names:
                    names.append(name)
                if member not in members:
                    members.append(member)
                    waiting.append(member)
    return list(families.values())


def _member_name(member: type) -> str:
    """Return the name of a member of a family in files, else the name of the class."""
    return str(member.member_name()) if hasattr(member, "member_name") else member.__name__


def _field_row(name: str, field: FieldInfo, is_graded: bool = False) -> Row:
    """Return name, symbol, unit and meaning of a field, with its ranges and default.

    ``is_graded``: a grade may supply the value.
    """
    from ..io.case_texts import field_comment, field_ranges
    from ..problems.permitted import requirement
    from ..quantities import members_of, quantity_of

    quantity, note = quantity_of(field), requirement(field)
    if is_graded and not note:
        note = "or from a grade"
    if quantity is None:
        text = field_comment(field) or ("see below" if members_of(field.annotation) else "")
        return name, "", "", "; ".join(filter(None, (text, note)))
    ranges = field_ranges(field, quantity, with_unit=False)
    # no comma before the permitted range in parentheses, or without ranges
    meaning = f"{quantity.meaning}, {ranges}".replace(", (", " (").removesuffix(", ")
    return name, quantity.symbol, quantity.display or "-", "; ".join(filter(None, (meaning, note)))


def _output_tables(result: type[Result]) -> Iterator[tuple[str, list[Row]]]:
    """Yield title and rows of tables: scalar outputs, the main ones first, then arrays."""
    from ..quantities import outputs, scalar_outputs

    rows = {p.path: _output_row(p.path, p.quantity) for p in outputs(result) if p.quantity}
    scalars = scalar_outputs(result)
    main = [name for name in result.MAIN if name in scalars]
    yield "Outputs", [rows[name] for name in dict.fromkeys((*main, *scalars))]
    arrays = [row for name, row in rows.items() if name not in scalars]
    if arrays:
        yield "Output arrays", arrays


def _output_row(name: str, quantity: Quantity) -> Row:
    """Return name, symbol, unit and meaning of an output."""
    unit = quantity.unit if quantity.unit != "1" else "-"
    return name, quantity.symbol, unit, quantity.meaning


def _option_rows(kind: Kind[Any, Any]) -> Iterator[Row]:
    """Yield name, type and description of the options of a solver."""
    for name, option in kind.solver_options().items():
        kind_of_value = "|".join(option.choices) or option.type.__name__
        text = f"{option.help} {option.details}".strip()
        yield options.option_name(name), "", kind_of_value, text


@options.command("List the named materials with their values and sources.")
def materials() -> None:
    """List the named materials with their values and sources."""
    from ..io.case_texts import toml_value
    from ..problems.materials import MATERIALS
    from ..quantities import walk

    for name, known in MATERIALS.items():
        values = [
            f"{place.path} = {toml_value(place.value, place.quantity)}"
            for place in walk(known.material)
            if place.value is not None and place.quantity is not None
        ]
        click.secho(name, bold=True)
        click.echo(f"  {{ {', '.join(values)} }}")
        click.secho(f"  {known.source}", dim=True)


@options.command(
    "List the grades of paper, film, foil and nonwoven, or the values of one. With NAME, the "
    "values of that grade are listed with their spread and source.",
)
@click.argument("name", required=False)
@click.option("--file", metavar="FILE", help="A TOML file with your own grades.")
def grades(name: str | None, file: str | None) -> None:
    """List the grades, or the values of one with their spread and source."""
    from ..problems import grades as library

    click.echo(str(library.grades(file) if name is None else library.grade(name, file)))

"""Directives for tables of names, symbols, units and ranges, generated from the program."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from pkgutil import walk_packages
from typing import Any, get_args

import numpy as np
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import woundon
from woundon import kinds, solve
from woundon.errors import one_of
from woundon.problems.family import Family
from woundon.problems.grades import grades
from woundon.problems.library import entry_of, library
from woundon.problems.materials import MATERIALS
from woundon.problems.paths import find_places
from woundon.problems.permitted import bounds
from woundon.problems.roll import RollProblem
from woundon.quantities import (
    OF_FIELD,
    Place,
    Quantity,
    members_of,
    outputs,
    scalar_outputs,
    walk,
)
from woundon.report.figures import symbol_text, unit_of
from woundon.report.report_parts import printed_unit

Rows = list[tuple[str, ...]]


def _table(header: tuple[str, ...], rows: Rows) -> str:
    lines = [header, tuple("---" for _ in header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


class Sections(SphinxDirective):
    """Write a section for each title and text that ``sections`` yields; without title the text."""

    def run(self) -> list[nodes.Node]:
        self.env.note_reread()  # the program may have changed although the page has not
        found: list[nodes.Node] = []
        for title, text in self.sections():
            parsed = self.parse_text_to_nodes(text)
            if title:
                section = nodes.section("", nodes.title(title, title), *parsed)
                section["names"].append(nodes.fully_normalize_name(title))
                self.state.document.note_implicit_target(section, section)
                parsed = [section]
            found += parsed
        return found

    def sections(self) -> Iterator[tuple[str, str]]:
        raise NotImplementedError


# ---- inputs -------------------------------------------------------------------------------------


class Inputs(Sections):
    """``{inputs}``: the fields of every kind of problem, then those of its parts."""

    def sections(self) -> Iterator[tuple[str, str]]:
        parts: dict[Any, None] = {}
        for kind in kinds.every():
            own = _heads(kind.problem)
            parts |= {owner: None for place in own for owner in _nested(place)}
            rows = [_input(place, "") for place in own]
            yield kind.problem.__name__, f"{kind.about}\n\n{_table(_INPUT, rows)}"
        for family, members in _families(parts).items():
            yield family.__name__, _of_members(members)


_INPUT = ("symbol", "name", "SI unit", "meaning", "usual", "admissible", "default")


def _heads(description: Any) -> list[Place]:
    """Return the place of each direct field of a description, also of fields with parts."""
    names = dict.fromkeys(place.path.partition(".")[0] for place in walk(description))
    return [find_places(description, name)[0] for name in names]


def _nested(place: Place) -> tuple[type, ...]:
    return members_of(place.field.annotation)


def _families(parts: Iterable[Any]) -> dict[Any, list[Any]]:
    """Group descriptions, and their parts, by the family that they belong to."""
    waiting, found = list(parts), {}
    for part in waiting:  # grows during the iteration
        family = next((base for base in part.__mro__ if Family in base.__bases__), part)
        if part not in found.setdefault(family, []):
            found[family].append(part)
            waiting += [model for place in _heads(part) for model in _nested(place)]
    return found


def _of_members(members: list[Any]) -> str:
    """Return one table for all members of a family."""
    owners: dict[str, list[str]] = {}
    places: dict[str, Any] = {}
    for member in members:
        for place in _heads(member):
            owners.setdefault(place.path, []).append(f"`{member.__name__}`")
            places.setdefault(place.path, place)
    rows = [
        _input(place, "" if len(owners[name]) == len(members) else ", ".join(owners[name]))
        for name, place in places.items()
    ]
    known = ", ".join(f"`{member.__name__}`" for member in members)
    return f"{known}.\n\n{_table(_INPUT, rows)}" if len(members) > 1 else _table(_INPUT, rows)


def _input(place: Place, only: str) -> tuple[str, ...]:
    """Return the row of a field; ``only`` names the classes that have it."""
    field, quantity = place.field, place.quantity
    about = quantity.meaning if quantity else field.description or ""
    if inner := _nested(place):
        about = ", ".join(filter(None, (about, one_of(f"`{m.__name__}`" for m in inner))))
    elif quantity is None and not about:  # a word
        about = one_of(f"`{word}`" for word in get_args(field.annotation))
    meaning = f"{about} ({only})" if only else about
    default = "" if field.is_required() else _default(field.default, quantity)
    if quantity is None:
        unit = "of its field" if OF_FIELD in field.metadata else ""
        return ("", f"`{place.name}`", unit, meaning, "", "", default)
    usual = _range(quantity, quantity.typical) if quantity.typical else ""
    limits = _limits(field)
    return (_tex(quantity), f"`{place.name}`", _unit(quantity), meaning, usual, limits, default)


def _default(value: Any, quantity: Quantity | None) -> str:
    if value is None:
        return "`None`"
    word = quantity is None or isinstance(value, str)
    return f"`{value}`" if word else _range(quantity, (value,))


def _range(quantity: Quantity, ends: Iterable[float]) -> str:
    """Return values in the display unit, which is named if it is not the SI unit."""
    unit = "" if _unit(quantity) == unit_of(quantity) else f" {unit_of(quantity)}"
    return " to ".join(_number(quantity.shown(end)) for end in ends) + unit


def _limits(field: Any) -> str:
    """Return the admissible range in SI units: "0 to 10", "> 0", "≥ 0, < 0.5"."""
    known = [(sign, _number(end)) for sign, end in bounds(field)]
    if [sign for sign, _ in known] == [">=", "<="]:
        return " to ".join(end for _, end in known)
    text = ", ".join(f"{sign} {end}" for sign, end in known)
    return text.replace(">=", "≥").replace("<=", "≤")


def _number(value: float) -> str:
    """Return a number as text, 1e7 instead of 1e+07."""
    return re.sub(r"e([+-])0*", r"e\1", f"{value:.6g}").replace("e+", "e")


def _unit(quantity: Quantity) -> str:
    return "" if quantity.unit == "1" else printed_unit(quantity.unit)


def _tex(quantity: Quantity) -> str:
    """Return the symbol as in figures, with upright words."""
    return symbol_text(quantity.symbol)


# ---- outputs, materials, modules ----------------------------------------------------------------


class Outputs(Sections):
    """``{outputs}``: the outputs of every kind's result."""

    def sections(self) -> Iterator[tuple[str, str]]:
        header = ("symbol", "name", "SI unit", "as", "meaning")
        for kind in kinds.every():
            scalars = scalar_outputs(kind.result)
            rows = [
                (
                    _tex(place.quantity),
                    f"`{place.path}`",
                    _unit(place.quantity),
                    "number" if place.path in scalars else "array",
                    place.quantity.meaning,
                )
                for place in outputs(kind.result)
            ]
            rows.sort(key=lambda row: row[3] == "array")
            yield kind.result.__name__, _table(header, rows)


class Materials(Sections):
    """``{materials}``: the library of named materials and their sources."""

    def sections(self) -> Iterator[tuple[str, str]]:
        rows = []
        for name, entry in MATERIALS.items():
            values = (
                f"{_tex(q)} {_range(q, [value])}"
                for _, q, _, _, value in walk(entry.material)
                if q is not None and value is not None
            )
            rows.append((f"`{name}`", ", ".join(values), entry.source))
        yield "", _table(("name", "values", "source"), rows)


class Covers(Sections):
    """``{covers}``: covers and shells of drums with spread and source."""

    def sections(self) -> Iterator[tuple[str, str]]:
        rows: Rows = []
        for name, table in library("materials")["covers"].items():
            entry = entry_of(table)
            cells = [
                _with_spread(str(entry.values[key]), entry.spread.get(key))
                for key in ("youngs_modulus", "poissons_ratio")
            ]
            rows.append((f"`{name}`", *cells, entry.sources["youngs_modulus"]))
        yield (
            "",
            _table(("name", "Young's modulus", "Poisson's ratio", "source of the modulus"), rows),
        )


class Grades(Sections):
    """``{grades}``: a section for each grade with its values, spreads and sources."""

    def sections(self) -> Iterator[tuple[str, str]]:
        for name, grade in grades().items():
            rows: Rows = [
                (f"`{field}`", text, _percent(grade.spread.get(field)), grade.sources[field])
                for field, text in grade.texts()
            ]
            yield name, f"{grade.title}\n\n" + _table(("field", "value", "spread", "source"), rows)


class GradeSources(Sections):
    """``{grade-sources}``: the sources that grades and covers name."""

    def sections(self) -> Iterator[tuple[str, str]]:
        yield "", _table(("name", "source"), list(library("grades")["sources"].items()))


class GradePressures(Sections):
    """``{grade-pressures}``: pressures in a roll of each grade, wound with its usual tension."""

    def sections(self) -> Iterator[tuple[str, str]]:
        rows: Rows = []
        for name, grade in grades().items():
            roll = solve(
                RollProblem(
                    grade=grade,
                    core={"radius": 0.05, "stiffness": 1e9},
                    radius=0.5,
                    wound_on_tension=grade.tension,
                )
            )
            texts = dict(grade.texts())
            halfway = float(np.interp(0.275, roll.radius, roll.pressure))
            rows.append(
                (
                    f"`{name}`",
                    texts["tension"],
                    f"{roll.pressure[0] / 1e3:.3g} kPa",
                    f"{halfway / 1e3:.3g} kPa",
                    texts["pressure"],
                )
            )
        header = ("grade", "wound-on tension", "at the core", "halfway", "usual near the core")
        yield "", _table(header, rows)


def _percent(spread: float | None) -> str:
    return "" if spread is None else f"{100 * spread:.3g} %"


def _with_spread(text: str, spread: float | None) -> str:
    return text if spread is None else f"{text} ± {_percent(spread)}"


class Modules(Sections):
    """``{modules}``: every module with the first sentence of its docstring, by package."""

    def sections(self) -> Iterator[tuple[str, str]]:
        packages: dict[str, Rows] = {"woundon": []}
        for found in walk_packages(woundon.__path__, "woundon."):
            package, _, name = found.name.rpartition(".")
            about = _about(found.name)
            if found.ispkg:
                packages[found.name] = [(f"**{name}/**", about)]
            else:
                packages[package].append((f"`{name}`", about))
        rows = [row for rows in packages.values() for row in rows if row[0] != "`__main__`"]
        yield "", _table(("module", "contents"), rows)


def _about(module: str) -> str:
    """Return the first paragraph of the docstring of a module, without importing it."""
    spec = find_spec(module)
    assert spec is not None
    text = ast.get_docstring(ast.parse(Path(spec.origin).read_text("utf-8"))) or ""
    line = " ".join(text.partition("\n\n")[0].split())
    return re.sub(r":\w+:`[~.]*([^`]*)`", r"`\1`", line).replace("``", "`")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directives."""
    app.add_directive("inputs", Inputs)
    app.add_directive("outputs", Outputs)
    app.add_directive("materials", Materials)
    app.add_directive("grades", Grades)
    app.add_directive("grade-pressures", GradePressures)
    app.add_directive("grade-sources", GradeSources)
    app.add_directive("covers", Covers)
    app.add_directive("modules", Modules)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""STUDY.toml of ``woundon plan``: a base case, unknown fields, measurements and candidates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem
from ..io.case_files import read_case
from .planned import Measurement
from .study_file import base_case, check_names, check_tables, flat_names, table_of

__all__ = ["load_plan"]

_BY_FIELD = ("unknown", "tie", "operating_point")  # tables of values by names of fields
_KNOWN = ("schema", "case", "candidate", "completed", "plan", "solver", *_BY_FIELD)
_PLAN = ("count", "criterion", "output", "draws", "seed")
_MEASUREMENT = ("case", *(field.name for field in fields(Measurement) if field.name != "problem"))


def load_plan(path: str | Path) -> dict[str, Any]:
    """Return the keywords of :func:`~woundon.studies.plan.next_experiment` in a study file.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, or invalid fields.
    """
    path = Path(path)
    content = read_case(path)
    check_tables(content, _KNOWN)
    settings = table_of(content, "plan")
    check_names(settings, _PLAN, "plan.")
    return {
        "problem": base_case(content.get("case"), path.parent),
        "candidates": _measurements(content, "candidate", path.parent),
        "completed": _measurements(content, "completed", path.parent),
        "options": table_of(content, "solver"),
        **{name: flat_names(table_of(content, name)) for name in _BY_FIELD},
        **settings,
    }


def _measurements(content: Mapping[str, Any], name: str, folder: Path) -> list[Measurement]:
    """Return the measurements in an array of tables of a study file."""
    tables = content.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InvalidProblem.at(name, f"must be tables; write [[{name}]] above each")
    return [_measurement(table, f"{name}.{k}", folder) for k, table in enumerate(tables)]


def _measurement(table: Mapping[str, Any], where: str, folder: Path) -> Measurement:
    """Return the measurement that a table of a study file describes."""
    check_names(table, _MEASUREMENT, f"{where}.")
    if "quantity" not in table:
        raise InvalidProblem.at(f"{where}.quantity", "missing; give the name of an output")
    keywords = {name: value for name, value in table.items() if name != "case"}
    for name in ("at", "fields"):
        keywords[name] = flat_names(table_of(table, name))
    if "case" in table:
        keywords["problem"] = base_case(table["case"], folder)
    return Measurement(**keywords)

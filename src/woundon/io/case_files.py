"""Cases in, results out: TOML with units to a problem; a result to netCDF, JSON or CSV and back.

A case file's names are those of the descriptions (:class:`~woundon.problems.NipProblem`), and the
unit of each field is the one that the description itself states; there is no second table.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from importlib import resources
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel

from .errors import InvalidProblem
from .materials import material
from .problems import NipProblem
from .resultfile import load_result, save_result
from .units import parse

__all__ = [
    "apply_settings",
    "load_case",
    "load_result",
    "make_problem",
    "read_case",
    "save_result",
    "template",
]

SCHEMA = 1

_BARE = re.compile(r"[\w.-]+\s*=\s*[\d.+-]+\s*[^\W\d_].*")  # nip_load = 3.5 kN/m

Models = tuple[type[BaseModel], ...]


def load_case(path: str | Path, settings: Iterable[str] = ()) -> NipProblem:
    """Return the problem that a case file describes.

    Parameters
    ----------
    path : path
        TOML file (see :func:`template`).
    settings : str or iterable of str
        Changes such as "nip_load=3.5 kN/m" or "web.thickness=57 um", made before validation.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, broken TOML, or wrong fields: every fault of the file, by
        field, value and admissible range.
    NoSteadyState
        If the drum would slide.
    """
    return make_problem(apply_settings(read_case(path), settings))


def template() -> str:
    """Return the text of a commented case file that is ready to run."""
    file = resources.files(__package__) / "data" / "case_template.toml"
    return file.read_text(encoding="utf-8")


def read_case(path: str | Path) -> dict[str, Any]:
    """Return the case file's tables as written, values neither converted nor checked.

    Raises
    ------
    InvalidProblem
        If the file cannot be read, is empty, or is no TOML (with the line).
    """
    try:
        # Windows editors put a mark before the first byte of UTF-8
        text = Path(path).read_bytes().decode("utf-8-sig")
        case = tomllib.loads(text)
    except OSError as fault:
        raise InvalidProblem([(str(path), f"cannot be read: {fault.strerror}")]) from None
    except UnicodeDecodeError as fault:
        why = f"is no UTF-8 text, from byte {fault.start}; save it as UTF-8"
        raise InvalidProblem([(str(path), why)]) from None
    except tomllib.TOMLDecodeError as fault:
        why = f"is no valid TOML: {fault}{_line_at_fault(text, str(fault))}"
        raise InvalidProblem([(str(path), why)]) from None
    except RecursionError:
        raise InvalidProblem([(str(path), "is no case file: nested too deeply")]) from None
    if not case:
        raise InvalidProblem(
            [(str(path), "is empty; 'woundon new > case.toml' writes a case to start from")]
        )
    return case


def _line_at_fault(text: str, fault: str) -> str:
    """Return the line that a TOML error names, for its value is what must be changed."""
    found = re.search(r"line (\d+)", fault)
    lines = text.rstrip().split("\n")
    line = lines[min(int(found[1]), len(lines)) - 1 if found else -1].split("#")[0].strip()
    hint = '; text with a unit needs quotes: "3.5 kN/m"' if _BARE.fullmatch(line) else ""
    return f": {line[:60]}{hint}"


def apply_settings(case: Mapping[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """Return the case's tables with settings "field=value" applied; nested fields by dotted name.

    A value with a unit, a plain number (SI) or a name is taken as in the file.

    Raises
    ------
    InvalidProblem
        For a text that is no setting, or a dotted name through a field that has no fields.
    """
    changed = deepcopy(dict(case))
    for setting in [settings] if isinstance(settings, str) else settings:
        path, sign, value = setting.partition("=")
        *heads, leaf = path.strip().split(".")
        if not sign or not all((*heads, leaf, value.strip())):
            raise InvalidProblem(
                [(setting, "is no setting; write field=value, e.g. nip_load='3.5 kN/m'")]
            )
        table: dict[str, Any] = changed
        for head in heads:
            table = _subtable(table, head, path.strip())
        table[leaf] = _plain(value)
    return changed


def _subtable(table: dict[str, Any], name: str, path: str) -> dict[str, Any]:
    inner = table.setdefault(name, {})
    if name == "material" and isinstance(inner, str):
        # a named material is opened up, so that one of its moduli can be changed
        inner = table[name] = material(inner).model_dump()
    if not isinstance(inner, dict):
        raise InvalidProblem([(path, f"{name} has no fields of its own")])
    return inner


def _plain(text: str) -> str | float:
    text = text.strip()
    if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'":
        text = text[1:-1]
    try:
        return float(text)
    except ValueError:
        return text


def make_problem(case: Mapping[str, Any]) -> NipProblem:
    """Return the validated problem of a case's tables.

    Raises
    ------
    InvalidProblem
        With all faults: units first, then whatever validation finds in the rest.
    """
    fields = {name: value for name, value in case.items() if name != "schema"}
    faults = list(_schema_faults(case))
    fields = _in_si(fields, (NipProblem,), "", faults)
    try:
        problem = NipProblem(**fields)
    except InvalidProblem as report:
        told = {field for field, _ in faults}
        faults += [_helped(f, t) for f, t in report.faults if f not in told]
        raise (type(report) if len(faults) == len(report.faults) else InvalidProblem)(
            faults
        ) from None
    if faults:
        raise InvalidProblem(faults)
    return problem


def _schema_faults(case: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    given = case.get("schema")
    if given is None:
        yield "schema", f"missing; write 'schema = {SCHEMA}' at the top of the file"
    elif isinstance(given, bool) or given != SCHEMA:
        yield "schema", f"{given!r} is unknown; this version reads schema = {SCHEMA}"


def _in_si(
    table: Mapping[str, Any], models: Models, prefix: str, faults: list[tuple[str, str]]
) -> dict[str, Any]:
    """Return ``table`` in SI; faulty values are kept as they are and told in ``faults``."""
    converted = dict(table)
    for name, value in table.items():
        path = f"{prefix}{name}"
        fields = [model.model_fields[name] for model in models if name in model.model_fields]
        if isinstance(value, Mapping):
            inner = tuple(model for f in fields for model in _models_in(f.annotation))
            converted[name] = _in_si(value, inner, f"{path}.", faults)
            continue
        unit = next(filter(None, (_unit_of(f.json_schema_extra) for f in fields)), None)
        if unit is None:
            continue
        try:
            converted[name] = parse(value, unit, path)
        except InvalidProblem as fault:
            faults += fault.faults
    return converted


def _models_in(annotation: Any) -> Models:
    """Return the descriptions that an annotation, a union or Annotated, allows."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return (annotation,)
    return tuple(model for part in get_args(annotation) for model in _models_in(part))


def _unit_of(extra: Any) -> str | None:
    return extra.get("unit") if isinstance(extra, dict) else None


def _helped(field: str, text: str) -> tuple[str, str]:
    """Mend the text for the slip that TOML invites: a loose field below a [section]."""
    *heads, leaf = field.split(".")
    if heads and leaf in NipProblem.model_fields and text.startswith("no such field"):
        return (
            field,
            f"no such field in [{'.'.join(heads)}]; write {leaf} above the first [section]",
        )
    return field, text

"""Read case files: TOML with units becomes a problem of any kind; :mod:`.case_texts` writes them.

The names in a case file are the fields of the problem, and units are converted to that of the
field.  The names determine the kind of problem.  Fields that a problem groups (``[wrap]``) may be
in their table or at the top level.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from .. import kinds
from ..arguments import check_type
from ..errors import InvalidProblem, did_you_mean, mapping_of
from ..problems.grades import grade
from ..problems.messages import check_names, quote
from ..problems.paths import counterpart, parts_of, set_in_tables
from ..problems.problem import Problem
from .case_texts import FILE_KEYS, SCHEMA, template, to_toml
from .files import read_whole

__all__ = [
    "apply_settings",
    "check_like_a_case",
    "load_case",
    "make_problem",
    "names_of_files",
    "read_case",
    "tables_of_text",
    "template",
    "to_toml",
]

MAX_BYTES = 10_000_000  # a case file has some hundreds, tables of a wound roll some thousands
MAX_DEPTH = 20  # of nested tables
MAX_NAMES = 5000  # a thousand layers

_BARE = re.compile(r"[\w.-]+\s*=\s*[\d.+-]+\s*[^\W\d_].*")  # nip_load = 3.5 kN/m
_NAME = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*"""
_LONG_KEY = re.compile(rf"(?<![\w-])(?:{_NAME}\.[ \t]*){{{MAX_DEPTH}}}")  # a.a.a.a...
_NOT_A_CASE = (
    "not a case file; 'woundon table CASES' solves the cases of a table, and 'woundon compare "
    "MEASURED CASE' and 'woundon fit CASE DATA' take measured values"
)

Faults = list[tuple[str, str]]


def load_case(path: str | Path, settings: Iterable[str] = ()) -> Problem:
    """Return the problem that a case file describes.

    Parameters
    ----------
    path : path
        TOML file (see :func:`~.case_texts.template`).
    settings : str or iterable of str
        Changes such as "nip_load=3.5 kN/m", "web.thickness=57 um" or, of the first item of a list,
        "drum.layers.0.thickness=4 mm", made before validation.

    Returns
    -------
    Problem
        Of the kind that has the fields and tables of the file.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, invalid TOML, or invalid fields; lists all errors of the
        file with field, value and permitted range.
    NoSteadyState
        If no steady state exists for these loads.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import woundon as wo
    >>> from woundon.io.case_texts import template
    >>> path = pathlib.Path(tempfile.mkdtemp(), "rollers.toml")
    >>> _ = path.write_text(template("rollers"))
    >>> wo.load_case(path, ["load=100 kN/m"]).load
    100000.0
    """
    return make_problem(apply_settings(read_case(path), settings), needs_schema=True)


def read_case(path: str | Path) -> dict[str, Any]:
    """Return the tables of a case file as written, values neither converted nor checked.

    ``csv = "file.csv"`` in a table is replaced by the columns of that file, ``log = "file.csv"`` by
    the means of the log of a winder over the radius, and ``grade`` is looked up in the file of
    ``grades = "file.toml"``; all are relative to the folder of the case.

    Raises
    ------
    InvalidProblem
        If the file cannot be read, is empty, or is not TOML (names the line).
    """
    written = tables_of_text(read_whole(path, MAX_BYTES), str(path))
    folder = Path(path).parent
    tables = written
    if any(names_of_files(written)):
        from .columns import with_columns  # with the readers of all formats of tables

        tables = with_columns(written, folder, lambda: _kind_of(written).problem)
    if "grades" not in tables:
        return tables
    file, name = tables.pop("grades"), tables.get("grade")
    if not isinstance(file, str) or not isinstance(name, str):
        text = f"{quote(file)} is out of place; must be the name of a file, with grade = 'NAME'"
        raise InvalidProblem.at("grades", text)
    return tables | {"grade": grade(name, folder / file)}


def names_of_files(part: Mapping[str, Any] | list[object], path: str = "") -> Iterator[str]:
    """Yield the dotted names of a case, or of a part of it, that hold a file in place of lists.

    Parameters
    ----------
    part : mapping or list
        Tables, or a list in them.
    path : str
        Dotted name of the part with a dot at its end; empty for all tables.
    """
    for name, value in part.items() if isinstance(part, Mapping) else enumerate(part):
        if name in FILE_KEYS:
            yield f"{path}{name}"
        if isinstance(value, Mapping | list):
            yield from names_of_files(value, f"{path}{name}.")


def tables_of_text(content: bytes, where: str) -> dict[str, Any]:
    """Return the tables of the content of a case file, as written; no other file is read.

    Raises
    ------
    InvalidProblem
        If it is empty, or is not TOML; names the file ``where`` it is, and the line.
    """
    try:
        # Windows editors put a byte order mark before the text
        text = content.decode("utf-8-sig")
        if _LONG_KEY.search(text):  # tomllib takes time proportional to its square
            raise RecursionError  # reported below, as when tomllib itself raises it
        case = tomllib.loads(text)
    except UnicodeDecodeError as fault:
        why = f"is not UTF-8 text, from byte {fault.start}; save it as UTF-8"
        if content.startswith(b"PK"):  # a zip archive, as Excel files are
            why = f"is an Excel file, {_NOT_A_CASE}"
        raise InvalidProblem.at(where, why) from None
    except RecursionError:
        raise InvalidProblem.at(where, "is not a case file: it is nested too deeply") from None
    except tomllib.TOMLDecodeError as fault:
        reason = f"is not valid TOML: {fault}{_line_at_fault(text, str(fault))}"
        if where.lower().endswith((".csv", ".txt", ".tsv")):
            reason = f"is a table, {_NOT_A_CASE}"
        raise InvalidProblem.at(where, reason) from None
    except ValueError:  # Python's limit on the digits of a whole number
        text = "is not a case file: it has a number of thousands of digits"
        raise InvalidProblem.at(where, text) from None
    check_like_a_case(case, where)
    if not case.keys() - {"schema"}:
        text = "is empty; 'woundon new > case.toml' writes a case to start from"
        raise InvalidProblem.at(where, text)
    return case


def check_like_a_case(case: Mapping[str, Any], where: str = "") -> None:
    """Reject tables that are larger or deeper than those of any case.

    Raises
    ------
    InvalidProblem
    """
    if reason := _excess(case):
        raise InvalidProblem.at(where, f"is not a case file: {reason}")


def _excess(case: Mapping[str, Any]) -> str:
    """Return the limit that the tables exceed; '' if they exceed none."""
    level: list[Any] = [case]  # tables and lists of one depth; no recursion, which may be too deep
    names = 0
    for _ in range(MAX_DEPTH):
        values: list[Any] = []
        for part in level:
            if isinstance(part, Mapping):
                names += len(part)
                values += part.values()
            else:
                values += part
        if any(isinstance(value, int) and value.bit_length() > 10_000 for value in values):
            return "it has a number of thousands of digits"
        level = [value for value in values if isinstance(value, (dict, list))]
    if level:
        return "it is nested too deeply"
    return f"it has {names} names" if names > MAX_NAMES else ""


def _line_at_fault(text: str, fault: str) -> str:
    """Return the line of a TOML error, with a hint if it has a unit without quotes.

    ``fault`` is the text of the error, which has the number of the line, or none for the last one.
    """
    match = re.search(r"line (\d+)", fault)
    lines = text.rstrip().split("\n")
    line = lines[min(int(match[1]), len(lines)) - 1 if match else -1].split("#")[0].strip()
    hint = '; text with a unit needs quotes: "3.5 kN/m"' if _BARE.fullmatch(line) else ""
    return f": {line[:60]}{hint}"


# ---- settings -----------------------------------------------------------------------------------


def apply_settings(case: Mapping[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """Return the case's tables with settings "field=value" applied.

    Nested fields have dotted names, items of a list numbers; fields of a table such as ``[wrap]``
    are named without the table.  Values are read as in the file: with a unit, as a plain number
    (SI) or as a name; "none" unsets an optional field or a table.

    Raises
    ------
    InvalidProblem
        For a text that is not a setting, two settings of one field, a name below a field that has
        no fields of its own, or an unset field that does not exist.
    """
    check_type("settings", settings, str, Iterable)
    changed = deepcopy(dict(case))
    values: list[tuple[str, str]] = []
    for setting in [settings] if isinstance(settings, str) else settings:
        check_type("setting", setting, str)
        path, sign, value = setting.partition("=")
        parts = parts_of(path.strip())
        if not sign or not all((*parts, value.strip())):
            text = "is not a setting; write field=value, e.g. nip_load='3.5 kN/m'"
            raise InvalidProblem.at(setting, text)
        if len(parts) > MAX_DEPTH:
            text = f"a name of {len(parts)} parts; must have at most {MAX_DEPTH}"
            raise InvalidProblem.at(path.strip(), text)
        if len(parts) > 1 and parts[-1] in FILE_KEYS:
            text = "names a file, which is read for a case file only; name it there, or set lists"
            raise InvalidProblem.at(path.strip(), text)
        model = _kind_of([*changed, parts[0]]).problem  # the new name may determine the kind
        if len(parts) == 1:
            # a field of a group is changed in the table of the group, if the case has it
            groups = (group for group, names in model.tables.items() if parts[0] in names)
            parts = [*(group for group in groups if group in changed), *parts]
        name = ".".join(parts)
        set_in_tables(changed, name, _plain(value), model)
        parts[-1] = counterpart(parts[-1], "diameter") or parts[-1]  # it is the same field
        values.append((".".join(parts), setting))
    mapping_of(values)  # raises an error for a field that is set twice
    return changed


def _plain(text: str) -> str | float | None:
    """Return the value of a setting: a number, a text without quotes, or None."""
    text = text.strip()
    if text.lower() == "none":
        return None
    if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'":
        text = text[1:-1]
    try:
        return float(text)
    except ValueError:
        return text


# ---- from tables to a problem -------------------------------------------------------------------


def make_problem(
    tables: Mapping[str, Any], kind: str | None = None, *, needs_schema: bool = False
) -> Problem:
    """Return the validated problem that a case's tables describe.

    Parameters
    ----------
    tables : mapping
        As in a case file: numbers in SI, or texts with units.
    kind : str, optional
        The kind of problem; by default the one that has these fields.
    needs_schema : bool
        Whether the tables must state the version of the format, as those of a file must.

    Raises
    ------
    InvalidProblem
        Lists all errors.
    """
    check_type("case", tables, Mapping)
    check_names(tables)
    model = (kinds.named(kind) if kind else _kind_of(tables)).problem
    faults: Faults = []
    fields = dict(tables)
    schema = fields.pop("schema", None if needs_schema else SCHEMA)
    if schema is None:
        faults.append(("schema", f"missing; write 'schema = {SCHEMA}' at the top of the file"))
    elif isinstance(schema, bool) or schema != SCHEMA:
        text = f"{schema!r} is unknown; this version reads schema = {SCHEMA}"
        faults.append(("schema", text))
    fields = _flatten_groups(fields, model, faults)
    try:
        problem = model(**fields)
    except InvalidProblem as report:
        reported = {field for field, _ in faults}
        faults += [_with_hint(f, t, model) for f, t in report.faults if f not in reported]
        # a NoSteadyState remains one unless the tables have other errors too
        whole = len(faults) == len(report.faults)
        raise (type(report) if whole else InvalidProblem)(faults) from None
    if faults:
        raise InvalidProblem(faults)
    return problem


def _kind_of(names: Iterable[str]) -> kinds.Kind:
    """Return the kind of problem that has fields, or tables, of these names."""
    return kinds.for_fields(name for name in names if name != "schema")


def _flatten_groups(fields: dict[str, Any], model: type[Any], faults: Faults) -> dict[str, Any]:
    """Return the fields, those of groups at the top level; errors are added to ``faults``."""
    flat = dict(fields)
    for group, names in model.tables.items():
        if group not in flat or group in model.model_fields:
            continue
        table = flat.pop(group)
        if not isinstance(table, Mapping):
            text = f"{quote(table)} is out of place; must be a table of {', '.join(names)}"
            faults.append((group, text))
            continue
        for name, value in table.items():
            if name not in names:
                text = f"no such field{did_you_mean(name, names)}"
                faults.append(_with_hint(f"{group}.{name}", text, model))
            elif name in flat:
                faults.append((name, f"given twice, in [{group}] and at the top level"))
            else:
                flat[name] = value
    return flat


def _with_hint(field: str, text: str, model: type[Any]) -> tuple[str, str]:
    """Return an error, field and text, with a hint if a top-level field is below a [section]."""
    *heads, leaf = parts_of(field)
    if heads and leaf in model.model_fields and text.startswith("no such field"):
        section = ".".join(head for head in heads if not head.isdecimal())
        return field, f"no such field in [{section}]; write {leaf} above the first [section]"
    return field, text

"""Checks of the arguments of public functions: types, numbers, names, mappings.

An argument that several functions have is checked by its name (:func:`check_arguments`), where it
is first used; the other functions check an argument of one function.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import cache
from inspect import signature
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from .errors import InvalidProblem, one_of
from .problems.messages import quote

__all__ = [
    "Option",
    "check_arguments",
    "check_type",
    "keywords_of",
    "nodes_or_rtol",
    "tolerance",
    "whole_number",
]


class Option(NamedTuple):
    """Description of a solver's option, as metadata of its annotation.

    ``Annotated[int | None, Option("Nodes on the last mesh.", "7 to 2049.")]``

    Attributes
    ----------
    help : str
        The sentence that the help of the command line shows.
    details : str
        Range, default and conditions, which differ between kinds of problem.
    """

    help: str
    details: str = ""


@cache
def keywords_of(function: Callable[..., object]) -> Mapping[str, object]:
    """Return the keyword-only arguments of a function with their defaults."""
    arguments = signature(function).parameters.values()
    return {a.name: a.default for a in arguments if a.kind is a.KEYWORD_ONLY}


def check_type(name: str, value: object, *types: type) -> None:
    """Raise an error unless a value has one of the types."""
    if not isinstance(value, types):
        must = one_of(kind.__name__ for kind in types)
        raise InvalidProblem.at(name, f"{quote(value)} is out of place; must be a {must}")


def nodes_or_rtol(nodes: object, rtol: object) -> None:
    """Raise an error if both are given: one fixes the grid, the other chooses it."""
    if nodes is not None and rtol is not None:
        text = f"{quote(nodes)} is given together with rtol, which chooses the nodes; omit one"
        raise InvalidProblem.at("nodes", text)


def whole_number(name: str, value: object, low: int, high: int) -> int:
    """Return an integer; raise an error unless it is from ``low`` to ``high``."""
    must = f"a whole number, {low} to {high}"
    return int(_in_range(name, value, (int, np.integer), low, high, must))


def tolerance(name: str, value: object, low: float, high: float) -> float:
    """Return a relative tolerance; raise an error unless it is from ``low`` to ``high``."""
    types = (int, float, np.floating)
    return float(_in_range(name, value, types, low, high, f">= {low:g} and <= {high:g}"))


def _in_range(
    name: str, value: Any, types: tuple[type[Any], ...], low: float, high: float, must: str
) -> Any:
    """Return a value of one of the types from ``low`` to ``high``; raise an error for another one.

    ``must`` is the permitted range as text.  True and False, which are integers of Python, and nan
    are rejected.
    """
    if isinstance(value, bool) or not isinstance(value, types) or not low <= value <= high:
        raise InvalidProblem.at(name, f"{quote(value)} is out of range; must be {must}")
    return value


# ---- arguments that several functions have ------------------------------------------------------


class _Kind(NamedTuple):
    """The values that an argument may have.

    Attributes
    ----------
    description : str
        The values as text: "must be ...".
    admits : callable
        Value -> whether it is one of them.
    optional : bool
        Whether None is permitted too.
    """

    description: str
    admits: Callable[[Any], bool]
    optional: bool = True


def _is_name(value: Any) -> bool:
    """Return True for a text."""
    return isinstance(value, str)


def _is_seed(value: Any) -> bool:
    """Return True for a seed of a random generator."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and int(value) >= 0


def _are_names(value: Any) -> bool:
    """Return True for one name, or a collection of names."""
    names = value.tolist() if isinstance(value, np.ndarray) else value
    if not isinstance(names, Collection) or isinstance(names, Mapping):
        return False
    return all(isinstance(name, str) for name in names)


def _maps_names(value: object, *types: type[Any]) -> bool:
    """Return True for a mapping of names to values; values of ``types`` only, if any are given."""
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and isinstance(entry, types or object)
        for name, entry in value.items()
    )


_NAME = _Kind("a name, as text", _is_name)
_NUMBER_OF_EACH = "a mapping of fields to numbers or texts with units"
_FIELD_OF_EACH = _Kind(
    "a mapping of fields to fields, {'web.material': 'roll.material'}",
    lambda value: _maps_names(value, str),
)
_KINDS = {
    "at": _Kind(_NUMBER_OF_EACH, _maps_names, optional=False),
    "columns": _Kind(
        "a mapping of headers to names or None", lambda v: _maps_names(v, str, type(None))
    ),
    "criterion": _NAME._replace(optional=False),
    "design": _NAME._replace(optional=False),
    "fields": _FIELD_OF_EACH._replace(optional=False),
    "label": _NAME._replace(optional=False),
    "maximise": _NAME,
    "minimise": _NAME,
    "operating_point": _Kind(_NUMBER_OF_EACH, _maps_names),
    "options": _Kind("a mapping of options of the solver to their values", _maps_names),
    "out": _Kind(
        "the path of a folder", lambda v: isinstance(v, (str, PathLike)) and "\0" not in str(v)
    ),
    "output": _NAME,
    "over": _Kind("a mapping of fields to values or ranges", _maps_names),
    "outputs": _Kind("names of outputs", _are_names),
    "preview": _Kind("a function of the coarse window", callable),
    "panels": _Kind("names of panels", _are_names),
    "profiles": _Kind(
        "True, False or names of fitted fields",
        lambda value: isinstance(value, bool) or _are_names(value),
        optional=False,
    ),
    "progress": _Kind(
        "True, False or a function (done, expected)",
        lambda value: isinstance(value, bool) or callable(value),
        optional=False,
    ),
    "quantity": _Kind("the name of an output", _is_name, optional=False),
    "resume": _Kind("True or False", lambda value: isinstance(value, bool), optional=False),
    "scheduler": _Kind("the address of a Dask scheduler, 'tcp://...'", _is_name),
    "seed": _Kind("a whole number >= 0", _is_seed, optional=False),
    "spread": _Kind(_NUMBER_OF_EACH, _maps_names),
    "tie": _FIELD_OF_EACH,
    "uncertain": _Kind("a mapping of fields to relative standard deviations", _maps_names),
    "unknown": _Kind(
        "a mapping of fields to relative standard deviations", _maps_names, optional=False
    ),
    "vary": _Kind(
        "names of fields, or {name: (low, high)}",
        lambda value: _are_names(value) or _maps_names(value),
        optional=False,
    ),
}


def check_arguments(**arguments: Any) -> None:
    """Reject arguments that are not of the kind that their name permits.

    Parameters
    ----------
    arguments
        By their names, which mean the same in all functions.

    Raises
    ------
    InvalidProblem
        With name, value and permitted kind.

    Examples
    --------
    >>> check_arguments(tie={"web.material": "roll.material"}, options=None)
    >>> check_arguments(resume="yes")
    Traceback (most recent call last):
    woundon.errors.InvalidProblem: resume: 'yes' is out of place; must be True or False
    """
    for name, value in arguments.items():
        kind = _KINDS[name]
        if value is None and kind.optional:
            continue
        if not kind.admits(value):
            text = f"{quote(value)} is out of place; must be {kind.description}"
            raise InvalidProblem.at(name, text)

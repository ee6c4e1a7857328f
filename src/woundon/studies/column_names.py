"""Columns that tables of cases and of measured data may have: names of fields and outputs.

Names are dotted, with ``*`` for the number of an item of a list.
"""

from __future__ import annotations

from ..errors import InvalidProblem
from ..io.cells import Conversion
from ..io.tables import Names
from ..problems.inputs import Inputs
from ..problems.paths import counterpart, field_quantity, get_field, names_above
from ..problems.problem import Problem
from ..quantities import Quantity, scalar_outputs, walk
from .model import kind_of

__all__ = [
    "ANNOTATIONS",
    "column_names",
    "columns_of",
    "conversion_of",
    "input_columns",
    "measurable_outputs",
    "output_columns",
]

ANNOTATIONS = ("case", "failure", "warnings")  # further columns of the tables of studies


def input_columns(problem: Problem) -> dict[str, Quantity | None]:
    """Return the quantities of all columns that are inputs, also of those that only convert."""
    return {**columns_of(problem), **conversion_of(problem).helpers}


def output_columns(problem: Problem) -> dict[str, Quantity]:
    """Return the quantities of all outputs and of their estimated errors."""
    known = scalar_outputs(kind_of(problem).result)
    return known | {f"errors.{name}": quantity for name, quantity in known.items()}


def column_names(problem: Problem) -> Names:
    """Return all names that a header may have: fields, outputs and the columns of studies."""
    return Names(
        {**dict.fromkeys(ANNOTATIONS), **output_columns(problem), **input_columns(problem)}
    )


def measurable_outputs(problem: Problem) -> dict[str, Quantity]:
    """Return the outputs that a column of measured data may contain.

    A quantity that is set in the problem, such as the tangential load of rollers, is an input.
    """
    known = scalar_outputs(kind_of(problem).result)
    fields = type(problem).model_fields
    return {
        name: quantity
        for name, quantity in known.items()
        if name not in fields or getattr(problem, name) is None
    }


def columns_of(problem: Problem) -> dict[str, Quantity | None]:
    """Return the quantities that a column of inputs may contain; None if it is not a number.

    Names are dotted, with ``*`` for the number of an item of a list.  Fields of other bodies and
    materials are included, and these themselves.  A schedule is a number if the problem has a
    number for it.
    """
    known: dict[str, Quantity | None] = {}
    for place in walk(type(problem)):  # all fields, also those of nested bodies and materials
        above = names_above(place.path)
        # a number of one material may be a body or a curve of another, which has fields itself
        for name in above:
            if name not in known:
                known[name] = _if_number(problem, name)
        # the same path may have been entered before, as a name above, with or without a quantity
        known[place.path] = known.get(place.path) or place.quantity
        # "diameter" alone is the position of a measurement on a roll
        if above and (diameter := counterpart(place.path, "radius")):
            known[diameter] = field_quantity(problem, diameter)
    return known


def conversion_of(problem: Problem, complete: bool = False) -> Conversion:
    """Return the conversion of the columns of a table: with the values of a problem, or without.

    Parameters
    ----------
    problem : Problem
    complete : bool
        Whether the columns describe the complete problem, so that its values do not matter.
    """
    # columns next to a field that convert it, e.g. web.density next to web.thickness
    helpers = {
        f"{place.path.removesuffix(place.name)}{name}": quantity
        for place in walk(type(problem))
        for name, quantity in getattr(place.owner, "input_only", {}).items()
    }
    inputs = Inputs(type(problem), {}) if complete else Inputs.of(problem)
    return Conversion(inputs, helpers)


def _if_number(problem: Problem, path: str) -> Quantity | None:
    """Return the quantity of a field whose value is a number; otherwise None."""
    try:
        is_number = isinstance(get_field(problem, path), float)
    except InvalidProblem:  # of another body or material
        return None
    return field_quantity(problem, path) if is_number else None

"""Rows of the outputs of a result, and the report of a kind without its own report."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import isinf, isnan
from typing import Any

from .. import kinds, quantities
from ..problems.bodies import Body
from ..problems.description import Description
from ..problems.problem import Problem
from ..quantities import Quantity
from ..results import Result
from .report_parts import Part, Row, Section, output_row, value_row

__all__ = [
    "LEAST_FRICTION",
    "LEFT_OUT",
    "approach_note",
    "field_rows",
    "is_half_plane",
    "not_applicable",
    "outputs_report",
    "rows_of",
]

# Below, a friction coefficient does not differ from 0: the air film carries the nip load.
LEAST_FRICTION = 1e-3

# in other rows, at the end, or only if they are relevant
LEFT_OUT = frozenset(
    {
        "residual",
        "half_width",
        "inlet_tension",
        "drum_wrap_traction",
        "creepage",
        "shift",
        "tangential_load",
        "traction_error",
        "iterations",
        "series_terms",
        "series_error",
    }
)

# pressures on the core, which are zero without a core
ON_CORE = frozenset({"core_pressure", "worst_lane.core_pressure"})


def not_applicable(problem: Problem) -> frozenset[str]:
    """Return the names of the outputs without a meaning: of pressures on a core that is removed."""
    return ON_CORE if getattr(problem, "core_removed", False) else frozenset()


def rows_of(
    result: Result, names: list[str], leave: Iterable[str] = LEFT_OUT, **notes: str
) -> tuple[Row, ...]:
    """Return the rows of the named outputs and of outputs of plug-ins.

    Parameters
    ----------
    result : Result
    names : list of str
        Outputs in their order; all other scalar outputs follow.
    leave : iterable of str
        Other outputs that are omitted.
    notes : str
        By the name of an output: text after its unit.
    """
    shown_elsewhere = {f"{name}_error" for name in result.errors} | _no_friction(result)
    others = [
        name
        for name in quantities.scalar_outputs(result)
        if name not in leave
        and name not in shown_elsewhere
        and name not in names
        and not _is_nan(quantities.value_of(result, name))  # not defined for this case
    ]
    return tuple(output_row(result, name, note=notes.get(name, "")) for name in names + others)


def _no_friction(result: Result) -> set[str]:
    """Return the names of friction coefficients that the air film reduces to practically zero."""
    names = ("air.roll_friction", "air.wrap_friction")
    film = getattr(result, "air", None)
    return {
        name
        for name in names
        if film is not None and quantities.value_of(result, name) < LEAST_FRICTION
    }


def _is_nan(value: Any) -> bool:
    """Return True for a float that is nan; other values may be whole numbers."""
    return isinstance(value, float) and isnan(value)


def approach_note(*bodies: Body) -> str:
    """Return a remark on the approach of bodies, which a half-plane leaves undetermined."""
    return ", up to a constant" if any(is_half_plane(body) for body in bodies) else ""


def is_half_plane(body: Body) -> bool:
    """Return True for a deformable body of infinite thickness."""
    return not body.rigid and isinf(body.thickness)


def outputs_report(result: Result) -> list[Part]:
    """Return a report of any kind: the fields of the problem and all scalar outputs."""
    kind = kinds.of(result)
    title = kind.name.replace("_", " ").capitalize()
    errors = {f"{name}_error" for name in result.errors}  # in the rows of their outputs
    rows = (
        output_row(result, name)
        for name in quantities.scalar_outputs(result)
        if name != "residual" and name not in errors
    )
    return [
        Section(f"{title}: problem", tuple(field_rows(result.problem))),
        Section(f"{title}: result", tuple(rows)),
    ]


def field_rows(
    problem: Description, prefix: str = "", of_field: Quantity | None = None
) -> Iterator[Row]:
    """Yield every field of a description, nested ones by dotted name.

    ``of_field`` is the quantity of the field that holds the description, as a schedule.
    """
    for name, field in type(problem).model_fields.items():
        value = getattr(problem, name)
        quantity = quantities.quantity_of(field, of_field)
        items = enumerate(value) if isinstance(value, tuple) else ()
        inner = [(f"{prefix}{name}.{k}", v) for k, v in items if isinstance(v, Description)]
        inner += [(f"{prefix}{name}", value)] if isinstance(value, Description) else []
        for path, part in inner:  # a row with the name of its class, then its fields
            yield Row(path, "", type(part).__name__)
            yield from field_rows(part, f"{path}.", quantity)
        if not inner and value is not None:
            row = value_row(quantity, value)
            # the name that --set takes; the meaning of a nested field would not say whose it is
            named = prefix or quantity is None
            yield replace(row, meaning=f"{prefix}{name}") if named else row

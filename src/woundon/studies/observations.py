"""Measured quantities of a winder and their predictions by the result of any kind of problem.

scalar output                     the result's own
scalar output at a diameter       that of the roll when its surface was there
array over the radius at a radius interpolated in the finished roll
length, at a diameter             wound_length: length of web, its layers compressed as wound
pull_tab_force at a radius        converted to a pressure by the calibration of the tab
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np

from ..errors import InvalidProblem, one_of
from ..io.logs import POSITIONS
from ..problems.messages import quote
from ..problems.problem import Problem
from ..problems.radii import radii_on_roll
from ..problems.units import parse
from ..quantities import Quantity, length, outputs, scalar_outputs, value_of
from ..results import Result
from .column_names import columns_of, conversion_of, measurable_outputs
from .measured_tables import read_measured
from .model import kind_of
from .pull_tab import PullTab

__all__ = [
    "RADIUS",
    "Observable",
    "Observations",
    "arrays_over_radius",
    "definitions",
    "error_at",
    "measured_columns",
    "predict",
    "read_deviation",
    "read_observations",
]

Array = np.ndarray

# Column -> its factor to a radius; ``radius`` is a field of the problem, that of the whole roll.
MEASURED_POSITIONS = {name: factor for name, factor in POSITIONS.items() if name != "radius"}
RADIUS = length("r", "where it was measured")
FORCE = Quantity("F_t", "N", "force that moves a pull tab")
TAB = "pull tab"  # name of the uncertainty of its calibration
TAB_FORCE, PRESSURE, LENGTH = "pull_tab_force", "pressure", "wound_length"
AT_SURFACE = 1e-6  # relative distance from the surface of a roll: the rounding of a table


class Observable(NamedTuple):
    """A quantity of a result that can be measured.

    Attributes
    ----------
    output : str
        Name of a scalar output or of an array over the radius.
    radius : float
        Where it is measured [m]; nan for a scalar output of the complete result.
    """

    output: str
    radius: float = nan


@dataclass(frozen=True, eq=False)
class Observations:
    """Measured values in one list, row by row.

    Attributes
    ----------
    rows : (m,) int array
        Row of the table, counted from 0.
    numbers : tuple of int
        Row of each value as a spreadsheet shows it.
    names : tuple of str
        The output that each value is compared with.
    position : (m,) array
        Radius [m]; nan of a value that belongs to no radius.
    measured, deviation : (m,) arrays
        Value and standard deviation; nan where the latter is not known.
    common : (m,) array
        Standard deviation that all values of a pull tab share.
    inputs : mapping of str to (rows,) array
    quantities : mapping of str to Quantity
        Of inputs and outputs.
    where : str
        The table, for error texts.
    input_deviations : mapping of str to (rows,) array
        Standard deviations of the inputs that have them.
    """

    rows: Array
    numbers: tuple[int, ...]
    names: tuple[str, ...]
    position: Array
    measured: Array
    deviation: Array
    common: Array
    inputs: Mapping[str, Array]
    quantities: Mapping[str, Quantity]
    where: str
    input_deviations: Mapping[str, Array] = field(default_factory=dict)

    @property
    def observables(self) -> list[Observable]:
        """The predicted quantity of each value."""
        return [Observable(*each) for each in zip(self.names, self.position.tolist(), strict=True)]

    @property
    def inputs_of_values(self) -> dict[str, Array]:
        """The inputs of each value, (m,) arrays."""
        return {name: values[self.rows] for name, values in self.inputs.items()}


def read_observations(
    problem: Problem,
    data: Any,
    columns: Mapping[str, str | None] | None,
    tab: PullTab | None = None,
    over_radius: bool = True,
) -> Observations:
    """Return the measured values of a table, row by row.

    Parameters
    ----------
    problem : Problem
    data, columns
        As of :func:`~.measured_tables.read_measured`.
    tab : PullTab, optional
    over_radius : bool
        Whether the table may contain values that belong to a radius of a roll.

    Raises
    ------
    InvalidProblem
        For an invalid table.
    """
    if hasattr(data, "measured"):  # the log of a winder
        data = data.measured()
    result = kind_of(problem).result
    fields, known = columns_of(problem), measured_columns(problem, over_radius)
    scalars = measurable_outputs(problem)
    replacements = {name: text for name, text in result.REPLACED.items() if name not in known}
    table = read_measured(data, fields, known, columns, replacements, conversion_of(problem))
    values_of, deviations = dict(table.outputs), dict(table.deviations)
    radius = _radius(values_of, table.where, len(table.numbers))
    common = _convert_tab_forces(values_of, deviations, tab, table.where)
    for name, of_rows in values_of.items():
        nowhere = np.isnan(radius) & np.isfinite(of_rows)
        if name not in scalars and nowhere.any():
            row = table.numbers[int(np.argmax(nowhere))]
            column = TAB_FORCE if name == PRESSURE and TAB_FORCE in table.outputs else name
            text = f"row {row}: {column} needs a column {one_of(MEASURED_POSITIONS)}"
            raise InvalidProblem.at(table.where, text)
    names, shape = list(values_of), (len(values_of), len(table.numbers))

    def of_all_outputs(by_name: Mapping[str, Array], missing: float) -> Array:
        """Return an (outputs, rows) array of values by output, which some outputs may lack."""
        rows = [by_name.get(name, np.full(shape[1], missing)) for name in names]
        return np.reshape(rows, shape)

    values = of_all_outputs(values_of, nan)
    rows, outputs = np.nonzero(np.isfinite(values.T))  # row by row
    if not rows.size:
        raise InvalidProblem.at(table.where, "has no measured value")
    names_of_values = tuple(names[output] for output in outputs.tolist())
    quantities = {name: known[name] for name in names_of_values}
    quantities |= {name: q for name in table.inputs if (q := fields.get(name)) is not None}
    return Observations(
        rows=rows,
        numbers=tuple(table.numbers[row] for row in rows.tolist()),
        names=names_of_values,
        position=radius[rows],
        measured=values[outputs, rows],
        deviation=of_all_outputs(deviations, nan)[outputs, rows],
        common=of_all_outputs(common, 0.0)[outputs, rows],
        inputs=table.inputs,
        quantities=quantities,
        where=table.where,
        input_deviations={n: s for n, s in table.deviations.items() if n in table.inputs},
    )


def measured_columns(problem: Problem, over_radius: bool = True) -> dict[str, Quantity]:
    """Return the columns that a table of measured values may have in addition to inputs.

    Parameters
    ----------
    problem : Problem
    over_radius : bool
        Whether the table may contain values that belong to a radius of a roll.
    """
    result = kind_of(problem).result
    arrays = arrays_over_radius(result, columns_of(problem)) if over_radius else {}
    known = {**arrays, **measurable_outputs(problem)}
    if arrays:
        known |= {**dict.fromkeys(MEASURED_POSITIONS, RADIUS), TAB_FORCE: FORCE}
    return known


def _convert_tab_forces(
    values_of: dict[str, Array], deviations: dict[str, Array], tab: PullTab | None, where: str
) -> dict[str, Array]:
    """Replace the forces on a pull tab, and their standard deviations, by pressures, in place.

    Returns
    -------
    dict
        The standard deviations that the calibration has in common, by name; empty without forces.
    """
    if TAB_FORCE not in values_of:
        if tab is not None:
            raise InvalidProblem.at(where, f"has no column {TAB_FORCE}, but a tab is given")
        return {}
    if tab is None:
        text = (
            f"{TAB_FORCE} needs the calibration of the tab: --tab-slope, or --tab-friction and "
            "--tab-area; in Python tab=wo.PullTab(...)"
        )
        raise InvalidProblem.at(where, text)
    if PRESSURE in values_of:
        raise InvalidProblem.at(where, f"has {PRESSURE} and {TAB_FORCE}; must be one of them")
    values_of[PRESSURE] = tab.pressure(values_of.pop(TAB_FORCE))
    if TAB_FORCE in deviations:
        deviations[PRESSURE] = tab.pressure_per_force * deviations.pop(TAB_FORCE)
    return {PRESSURE: tab.deviation * np.abs(values_of[PRESSURE])}


def _radius(values_of: dict[str, Array], where: str, count: int) -> Array:
    """Remove the column of positions from the outputs; return the radii, nan without a column.

    Parameters
    ----------
    values_of : dict of str to (rows,) array
        Columns by name.
    where : str
        Name of the table in error messages.
    count : int
        Number of rows.
    """
    columns = [name for name in MEASURED_POSITIONS if name in values_of]
    if len(columns) > 1:
        raise InvalidProblem.at(where, f"has {' and '.join(columns)}; must be one of them")
    if not columns:
        return np.full(count, nan)
    return MEASURED_POSITIONS[columns[0]] * values_of.pop(columns[0])


def arrays_over_radius(result: type[Result], fields: Collection[str]) -> dict[str, Quantity]:
    """Return the arrays of a kind of result that are functions of the radius, by name.

    Those of a winding include the arrays of the roll that it has wound.

    Parameters
    ----------
    result : type
        Class of the results.
    fields : collection of str
        Fields of the problem: an array of the same name, such as the wound-on tension, is an input.
    """
    arrays = {  # outputs whose annotation is Annotated[ndarray, quantity]
        place.path: place.quantity
        for place in outputs(result)
        if place.quantity is not None and np.ndarray in get_args(place.field)
    }
    if "radius" not in arrays:
        return {}
    of_roll: dict[str, Quantity] = {}
    roll = getattr(result, "roll", None)
    if isinstance(roll, property) and roll.fget is not None:  # its annotation is the class
        class_of_roll = get_type_hints(roll.fget)["return"]
        if class_of_roll is not result:
            of_roll = arrays_over_radius(class_of_roll, fields)
    others = {"radius", *fields, *scalar_outputs(result), *result.ALONG}
    return of_roll | {name: quantity for name, quantity in arrays.items() if name not in others}


def read_deviation(
    value: float | str, number_in_si: Callable[[float | str], float], where: str
) -> tuple[float, bool]:
    """Return a standard deviation, and whether it is relative.

    Parameters
    ----------
    value : float or str
        "20 %" is relative; a number is SI, a text has a unit.
    number_in_si : callable
        Converts one that is not relative.
    where : str
        Name of the value in error messages.

    Raises
    ------
    InvalidProblem
        If it is not a number > 0.

    Examples
    --------
    >>> read_deviation("20 %", float, "spread"), read_deviation(1e-3, float, "spread")
    ((0.2, True), (0.001, False))
    """
    is_relative = isinstance(value, str) and value.strip().endswith("%")
    deviation = float(parse(value, "1", where) if is_relative else number_in_si(value))
    if not (isfinite(deviation) and deviation > 0):
        text = f"{quote(value)} is out of range; must be a standard deviation > 0"
        raise InvalidProblem.at(where, text)
    return deviation, is_relative


# ---- predictions --------------------------------------------------------------------------------


def _roll_of(result: Result) -> Any:
    """Return the roll of a result; the result itself of a kind of problem that has no roll."""
    return getattr(result, "roll", result)


def predict(result: Result, observable: Observable) -> float:
    """Return the prediction of a measured value.

    Raises
    ------
    InvalidProblem
        For a radius outside the roll, or an output that the roll does not have there.
    """
    name, radius = observable
    if not isfinite(radius):
        return float(value_of(result, name))
    roll = _roll_of(result)
    R = roll.radius[-1] if hasattr(roll, "radius") else np.nan
    if name == PRESSURE and abs(radius / R - 1) <= AT_SURFACE:
        text = "is zero at the surface of the roll, so that a value measured there is left out"
        raise InvalidProblem.at(name, text)
    # which interpolates with the derivatives at the nodes
    if name in (PRESSURE, "hoop_stress") and hasattr(roll, "at_radius"):
        return float(roll.at_radius(radius)[name])
    if name in scalar_outputs(result):  # the value when the roll had this radius
        if name not in scalar_outputs(roll):
            raise InvalidProblem.at(
                name,
                "is not known of a stage of the build-up; leave out the column with its radius",
            )
        return float(value_of(roll.at(radius), name))
    # an array over the radius, of the winding or of the roll that it has wound
    holder: Any = result if hasattr(type(result), name) or name in vars(result) else roll
    core, surface = holder.radius[[0, -1]].tolist()
    radius = float(radii_on_roll(radius, core, surface, "measured_radius"))
    values = np.asarray(value_of(holder, name))
    if values.shape != np.shape(holder.radius):
        raise InvalidProblem.at(name, "is not an output over the radius")
    return float(np.interp(radius, holder.radius, values))


def definitions(result: Result, names: Sequence[str]) -> Iterator[str]:
    """Yield the definitions of measured quantities that have two, with their values."""
    roll = _roll_of(result)
    if LENGTH not in names or not hasattr(roll, LENGTH):
        return
    known = scalar_outputs(type(roll))

    def text(name: str) -> str:
        value = known[name].stored_text(value_of(roll, name), ".5g")
        return f"{known[name].meaning} ({name}), {value}"

    yield f"{LENGTH}: the {text(LENGTH)}; the finished roll also has the {text('length')}"


def error_at(result: Result, observable: Observable) -> float:
    """Return the estimated discretisation error of a prediction; nan where it is not known.

    In a roll the errors of pressure and hoop stress are interpolated between those of the pressure
    at the core and at the mid-radius; for other arrays that of their mean stands in.
    """
    (name, radius), errors = observable, result.errors
    if name in errors and not isfinite(radius):
        return float(errors[name])
    if name in (PRESSURE, "hoop_stress") and {"core_pressure", "mid_pressure"} <= set(errors):
        roll = _roll_of(result)
        radii = roll.radius
        ends = (radii[0], (radii[0] + radii[-1]) / 2)
        return float(np.interp(radius, ends, (errors["core_pressure"], errors["mid_pressure"])))
    return float(errors.get(name, errors.get(f"mean_{name}", nan)))

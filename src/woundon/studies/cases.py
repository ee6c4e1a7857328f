"""The cases of a study: a table with a row for each case, however they were made.

    grid, rows of a table, random draw --> Cases --> chunks of neighbouring cases

The cases of a chunk are solved in order, each from the state of the previous one.  Chunks depend on
the cases only, so results do not depend on the number of processes or on interruptions.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from math import ceil, log2, prod
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import check_arguments, whole_number
from ..errors import InvalidProblem, did_you_mean
from ..problems.inputs import NotANumber, real_number
from ..problems.messages import quote

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "DESIGNS",
    "MOST_CASES",
    "Cases",
    "Chunk",
    "Solved",
    "as_labels",
    "cases_in_ranges",
    "check_number",
    "is_numeric",
    "make_cases",
    "table_of_cases",
]

Array = np.ndarray
DESIGNS = ("grid", "table", "latin-hypercube", "sobol")
MOST_CASES = 100_000_000
# A list of more than eight values in the text of a description: the first and the last one.
_LONG_LIST = re.compile(r"([(\[])([^()\[\],]+)(?:, [^()\[\],]+){7,}, ([^()\[\],]+)([)\]])")


class Chunk(NamedTuple):
    """Cases that one worker solves in a row.

    Attributes
    ----------
    number : int
        Its position among the chunks of the study.
    cases : (k,) int array
        Numbers of the cases.
    inputs : list of k mappings
        The inputs of each case by dotted name, SI.
    """

    number: int
    cases: Array
    inputs: list[dict[str, Any]]


class Solved(NamedTuple):
    """The results of k cases.

    Attributes
    ----------
    values : (k, outputs) array
        The outputs in SI; nan where the case failed.
    failure, warnings : lists of k str
        Why a case failed, '' where it did not; where it leaves the validity of the model.
    """

    values: Array
    failure: list[str]
    warnings: list[str]


@dataclass(frozen=True, eq=False)
class Cases:
    """The cases of a study.

    Attributes
    ----------
    frame : pandas.DataFrame
        A row for each case, a column for each input by its dotted name: numbers as float64 in SI,
        bodies, names of materials and other values as objects.
    design : str
        "grid", "table", "latin-hypercube" or "sobol".
    axes : mapping of str to array
        Of a grid, the values of each input; the last input varies fastest.  Otherwise empty.
    """

    frame: pd.DataFrame
    design: str = "table"
    axes: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(self.frame.columns)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis of a grid; otherwise (cases,)."""
        return tuple(len(values) for values in self.axes.values()) or (len(self),)

    @property
    def columns(self) -> dict[str, Array]:
        """The values of each input: on its axis of a grid, otherwise of every case."""
        return dict(self.axes) or {name: v.to_numpy() for name, v in self.frame.items()}

    def chunks(self, size: int | None = None) -> list[Chunk]:
        """Divide the cases into chunks of neighbours, by default of 10 to 100 cases.

        Chunks of small studies are small, so that every worker gets some.
        """
        if size is None:
            size = min(100, max(10, ceil(len(self) / 32)))
        size = whole_number("chunk", size, 1, MOST_CASES)
        inputs = self.frame.to_dict("records")
        return [
            Chunk(number, rows, [inputs[row] for row in rows])
            for number, rows in enumerate(self._neighbours(size))
        ]

    def _neighbours(self, size: int) -> list[Array]:
        """Return the numbers of the cases of each chunk, in the order in which they are solved."""
        if self.axes:
            # objects vary slowest, then nested fields: they change the solution most
            rank = [(is_numeric(v), -name.count(".")) for name, v in self.axes.items()]
            path = serpentine(self.shape, sorted(range(len(rank)), key=lambda k: rank[k]))
            return _divided(path, size)
        numbers = self.frame.select_dtypes("number")
        if numbers.columns.empty:
            return _divided(np.arange(len(self)), size)
        # a missing value counts as the mean of its column
        points = numbers.fillna(numbers.mean()).fillna(0.0).to_numpy()
        return [rows[tour(points[rows])] for rows in _divided(bisection_order(points), size)]

    def record(self) -> dict[str, Any]:
        """Return the inputs and a hash of their values, which identify the cases, for JSON."""
        values = {name: [_plain(v) for v in column] for name, column in self.columns.items()}
        sha256 = hashlib.sha256(json.dumps(values).encode()).hexdigest()
        return {"kind": self.design, "inputs": list(self.names), "sha256": sha256}


def is_numeric(values: Array) -> bool:
    """Return True if the values of an input are numbers."""
    return values.dtype.kind == "f"


def as_labels(values: Array) -> Array:
    """Return the values of an input, (n,), for tables and axes: numbers, or texts of others.

    Of a long list in a text, such as the positions of a profile, the ends are stated; texts that
    are equal without the values between them are numbered.
    """
    if is_numeric(values):
        return values
    complete = [v if isinstance(v, str) else repr(v) for v in values]
    short = [
        text if isinstance(v, str) else _LONG_LIST.sub(r"\1\2, ..., \3\4", text)
        for v, text in zip(values, complete, strict=True)
    ]
    meant: dict[str, list[str]] = {}  # complete texts by the short one
    for text, whole in zip(short, complete, strict=True):
        known = meant.setdefault(text, [])
        if whole not in known:
            known.append(whole)
    labels = [
        text if len(meant[text]) == 1 else f"{text} #{meant[text].index(whole) + 1}"
        for text, whole in zip(short, complete, strict=True)
    ]
    return np.array(labels, dtype=object)


def _plain(value: Any) -> Any:
    """Return a value of an input for JSON."""
    return value.model_dump() if hasattr(value, "model_dump") else value


# ---- ways to make cases -------------------------------------------------------------------------


def make_cases(
    over: Mapping[str, Any], design: str = "grid", samples: int | None = None, seed: int = 0
) -> Cases:
    """Return the cases of a sweep.

    Parameters
    ----------
    over : mapping
        Dotted name of a field -> values (grid, table) or range (low, high[, "log"]) (drawn).
    design : {"grid", "table", "latin-hypercube", "sobol"}
        All combinations; row by row; or drawn by scipy.stats.qmc.
    samples : int
        Number of cases to draw; for "sobol" a power of 2.
    seed : int
        Of the generator.

    Raises
    ------
    InvalidProblem
        Names the invalid input.

    Examples
    --------
    >>> cases = make_cases({"nip_load": [1e3, 2e3, 4e3], "roll_friction": [0.2, 0.3]})
    >>> cases.shape, cases.names
    ((3, 2), ('nip_load', 'roll_friction'))
    >>> cases.frame.iloc[1].tolist()
    [1000.0, 0.3]
    """
    check_arguments(seed=seed)
    if design not in DESIGNS:
        raise InvalidProblem.at("design", f"{design!r} is unknown{did_you_mean(design, DESIGNS)}")
    if not isinstance(over, Mapping) or not over:
        raise InvalidProblem.at("over", "nothing to vary: give fields and their values")
    if design in ("grid", "table") and samples is not None:
        raise InvalidProblem.at("samples", f"{samples!r} has no meaning in a {design} design")
    if design == "grid":
        return _grid(over)
    if design == "table":
        return table_of_cases(over)
    return cases_in_ranges(over, _draw_points(design, len(over), samples, seed), design)


def table_of_cases(over: Mapping[str, Any]) -> Cases:
    """Return the cases of columns of values, row by row."""
    columns = {name: _as_array(name, values) for name, values in over.items()}
    lengths = {len(values) for values in columns.values()}
    if len(lengths) > 1:
        raise InvalidProblem.at("over", f"columns of a table differ in length: {lengths}")
    check_number(*lengths)
    return Cases(_frame(columns))


def _grid(over: Mapping[str, Any]) -> Cases:
    """Return all combinations of the values of fields; the last field varies fastest."""
    axes = {name: _as_array(name, values) for name, values in over.items()}
    shape = tuple(len(values) for values in axes.values())
    check_number(prod(shape))
    indices = np.unravel_index(np.arange(prod(shape)), shape)  # of every case on each axis
    columns = {name: axis[k] for (name, axis), k in zip(axes.items(), indices, strict=True)}
    return Cases(_frame(columns), "grid", axes)


def check_number(count: int) -> None:
    """Reject too many cases."""
    if count > MOST_CASES:
        raise InvalidProblem.at("over", f"{count} cases are more than {MOST_CASES}")


def _as_array(name: str, values: Any) -> Array:
    """Return the values of a field as an array of float64, or of objects.

    Raises
    ------
    InvalidProblem
        If it is not a sequence, is empty, or mixes numbers with other values.
    """
    if isinstance(values, (str, bytes, Mapping)) or not hasattr(values, "__len__"):
        raise InvalidProblem.at(name, f"{values!r} is not a list of values")
    check_number(len(values))
    items = list(values)
    if not items:
        raise InvalidProblem.at(name, "an empty list of values")
    numbers = [_number_or_none(item) for item in items]
    if None not in numbers:
        return np.array(numbers, dtype=float)
    if any(number is not None for number in numbers):
        raise InvalidProblem.at(name, "contains numbers and other values; must be all of one type")
    array = np.empty(len(items), dtype=object)
    array[:] = items  # np.array(items) would unpack values that are sequences
    return array


def _number_or_none(value: Any) -> float | None:
    """Return a real number as a float; None for another value."""
    with suppress(NotANumber):
        return real_number(value)
    return None


def _frame(columns: Mapping[str, Array]) -> pd.DataFrame:
    """Return a table of columns; texts stay Python's own."""
    import pandas as pd

    return pd.DataFrame({name: pd.Series(v, dtype=v.dtype) for name, v in columns.items()})


def cases_in_ranges(ranges: Mapping[str, Any], points: Array, design: str = "table") -> Cases:
    """Return cases at points of the unit cube, (cases, inputs), mapped onto the ranges of inputs.

    >>> cases = cases_in_ranges({"load": (1.0, 3.0)}, np.array([[0.0], [0.5]]))
    >>> cases.frame["load"].tolist()
    [1.0, 2.0]
    """
    columns = {
        name: _scaled_to_range(name, ends, fractions)
        for (name, ends), fractions in zip(ranges.items(), points.T, strict=True)
    }
    return Cases(_frame(columns), design)


def _scaled_to_range(name: str, ends: Any, fractions: Array) -> Array:
    """Map fractions in [0, 1] onto the range of a drawn input.

    Parameters
    ----------
    name : str
        Of the input, for error messages.
    ends : sequence
        (low, high), or (low, high, "log") for a uniform distribution of the logarithm.
    fractions : array

    Raises
    ------
    InvalidProblem
        If it is not a range.

    Examples
    --------
    >>> _scaled_to_range("load", (1.0, 100.0, "log"), np.array([0.0, 0.5]))
    array([ 1., 10.])
    """
    parts = list(ends) if isinstance(ends, (list, tuple, np.ndarray)) else []
    is_log = len(parts) == 3 and parts[2] == "log"
    numbers = [number for end in parts[:2] if (number := _number_or_none(end)) is not None]
    if not (len(parts) == 2 or is_log) or len(numbers) < 2 or not np.isfinite(numbers).all():
        text = f"{quote(ends)} is not a range; write (low, high) or (low, high, 'log')"
        raise InvalidProblem.at(name, text)
    low, high = numbers
    if not low < high or (is_log and low <= 0):
        positive = "0 < " if is_log else ""
        raise InvalidProblem.at(name, f"{quote(ends)} is not a range; must be {positive}low < high")
    scaled = low * (high / low) ** fractions if is_log else low + (high - low) * fractions
    return np.asarray(scaled)


def _draw_points(design: str, inputs: int, samples: int | None, seed: int) -> Array:
    """Draw points of the unit cube, (samples, inputs)."""
    from scipy.stats import qmc

    samples = whole_number("samples", samples, 2, MOST_CASES)
    if design == "latin-hypercube":
        return np.asarray(qmc.LatinHypercube(inputs, rng=seed).random(samples))
    power = int(log2(samples))
    if samples != 2**power:
        nearest = f"{2**power} or {2 ** (power + 1)}"
        text = f"{samples} is not a power of 2, which Sobol points require: {nearest}"
        raise InvalidProblem.at("samples", text)
    return np.asarray(qmc.Sobol(inputs, rng=seed).random_base2(power))


def _divided(cases: Array, size: int) -> list[Array]:
    """Return the numbers of cases in parts of a size; the last part may be smaller."""
    return [cases[k : k + size] for k in range(0, len(cases), size)]


# ---- orders in which successive cases are neighbours --------------------------------------------


def serpentine(shape: Sequence[int], axes: Sequence[int]) -> Array:
    """Return the cases of a grid in an order that moves one step along one axis at a time.

    Parameters
    ----------
    shape : sequence of int
        The grid; cases are numbered with the last axis running fastest.
    axes : sequence of int
        The axes from the slowest to the fastest on the path.

    Returns
    -------
    (cases,) int array
        The reflected mixed-radix Gray code.

    Examples
    --------
    >>> serpentine((2, 3), (0, 1)).tolist()
    [0, 1, 2, 5, 4, 3]
    """
    step = np.arange(int(np.prod(shape)))
    index: list[Array] = [step] * len(shape)  # on each axis, set below
    stride = step.size
    for axis in axes:
        count = shape[axis]
        passes = step // stride  # number of completed passes: every second one is reversed
        stride //= count
        digit = step // stride % count
        index[axis] = np.where(passes % 2 == 0, digit, count - 1 - digit)
    return np.ravel_multi_index(tuple(index), tuple(shape))


def bisection_order(points: Array) -> Array:
    """Return an order of the rows of a table in which successive rows form compact groups.

    Recursive bisection: the column with the largest range is divided at its median.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scale_columns(points)
    out = np.empty(len(points), dtype=np.intp)
    stack = [(np.arange(len(points)), 0)]  # (rows of a group, its start in the order)
    while stack:
        rows, start = stack.pop()
        if len(rows) <= 8:
            out[start : start + len(rows)] = rows
            continue
        widest = int(np.argmax(np.ptp(unit[rows], axis=0)))
        ranked = rows[np.argsort(unit[rows, widest], kind="stable")]
        half = len(rows) // 2
        stack += [(ranked[:half], start), (ranked[half:], start + half)]
    return out


def tour(points: Array) -> Array:
    """Return the nearest-neighbour tour of the rows of a table, from the first one.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scale_columns(points)
    out = np.zeros(len(points), dtype=np.intp)  # the tour starts with row 0
    unvisited = np.ones(len(points), dtype=bool)
    for k in range(1, len(points)):
        unvisited[out[k - 1]] = False
        distance = np.sum((unit - unit[out[k - 1]]) ** 2, axis=1)
        out[k] = np.argmin(np.where(unvisited, distance, np.inf))
    return out


def _scale_columns(points: Array) -> Array:
    """Return every column divided by its range."""
    spread = np.ptp(points, axis=0)
    return np.asarray(points / np.where(spread > 0, spread, 1.0))

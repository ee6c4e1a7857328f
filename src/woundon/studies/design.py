"""Designs of studies: grids, and tables of given or drawn cases.

    over + kind --> Design --> chunks of neighbouring cases

The cases of a chunk are solved in order, each from the state of the previous one.  Chunks depend on
the design only, so results do not depend on the number of processes or on interruptions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import ceil, log2, prod
from numbers import Real
from typing import Any

import numpy as np

from ..errors import InvalidProblem, did_you_mean
from .order import bisection_order, serpentine, tour

__all__ = ["Column", "Design", "Range", "make_design"]

Array = np.ndarray
DESIGNS = ("grid", "table", "latin-hypercube", "sobol")
MOST_CASES = 100_000_000


@dataclass(frozen=True, eq=False)
class Column:
    """The values of one input: numbers, or objects such as bodies and names of materials.

    Attributes
    ----------
    name : str
        Dotted name of the field.
    values : float array or tuple
    """

    name: str
    values: Array | tuple[Any, ...]

    @classmethod
    def of(cls, name: str, values: Any) -> Column:
        """Return the column of a sequence of values.

        Raises
        ------
        InvalidProblem
            If it is not a sequence, is empty, or mixes numbers with other objects.
        """
        if isinstance(values, (str, Mapping)) or not hasattr(values, "__len__"):
            raise InvalidProblem.at(name, f"{values!r} is not a list of values")
        items = list(values)
        if not items:
            raise InvalidProblem.at(name, "an empty list of values")
        numbers = [isinstance(v, (Real, np.number)) and not isinstance(v, bool) for v in items]
        if all(numbers):
            return cls(name, np.array(items, dtype=float))
        if any(numbers):
            raise InvalidProblem.at(
                name, "contains numbers and other values; must be all of one type"
            )
        return cls(name, tuple(items))

    @property
    def numeric(self) -> bool:
        """True if the values are numbers."""
        return isinstance(self.values, np.ndarray)

    def at(self, index: Array) -> Array | tuple[Any, ...]:
        """Return the values at the given places."""
        if isinstance(self.values, np.ndarray):
            return np.asarray(self.values[index])
        return tuple(self.values[int(k)] for k in index)

    @cached_property
    def labels(self) -> Array:
        """The values for tables and axes: numbers, or the text of other objects."""
        if isinstance(self.values, np.ndarray):
            return self.values
        return np.array([v if isinstance(v, str) else repr(v) for v in self.values], dtype=object)

    def record(self) -> Any:
        """Return the values for JSON; for long numeric columns their SHA-256."""
        if isinstance(self.values, np.ndarray):
            if self.values.size <= 1000:
                return self.values.tolist()
            return hashlib.sha256(self.values.astype("<f8").tobytes()).hexdigest()
        return [v.model_dump() if hasattr(v, "model_dump") else v for v in self.values]


class Range:
    """The range of a drawn input with a uniform or log-uniform distribution.

    >>> Range("load", (1.0, 100.0, "log")).scaled(np.array([0.0, 0.5]))
    array([ 1., 10.])
    """

    def __init__(self, name: str, ends: Any) -> None:
        parts = list(ends) if isinstance(ends, (list, tuple, np.ndarray)) else []
        self.name, self.log = name, len(parts) == 3 and parts[2] == "log"
        if not (len(parts) == 2 or self.log) or not all(
            isinstance(v, (Real, np.number)) and np.isfinite(float(v)) for v in parts[:2]
        ):
            raise InvalidProblem.at(
                name, f"{ends!r} is not a range; write (low, high) or (low, high, 'log')"
            )
        self.low, self.high = float(parts[0]), float(parts[1])
        if not self.low < self.high or (self.log and self.low <= 0):
            positive = "0 < " if self.log else ""
            raise InvalidProblem.at(name, f"{ends!r} is not a range: must be {positive}low < high")

    def scaled(self, fractions: Array) -> Array:
        """Map fractions in [0, 1] onto the range."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** fractions)
        return np.asarray(self.low + (self.high - self.low) * fractions)


@dataclass(frozen=True, eq=False)
class Design:
    """The cases of a study.

    Attributes
    ----------
    kind : str
        "grid", "table", "latin-hypercube" or "sobol".
    columns : tuple of Column
        The values on each axis of a grid; otherwise one value for each case.
    """

    kind: str
    columns: tuple[Column, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(column.name for column in self.columns)

    @property
    def gridded(self) -> bool:
        """True if the cases are all combinations of the values of the columns."""
        return self.kind == "grid"

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis; (cases,) of a table."""
        sizes = tuple(len(column.values) for column in self.columns)
        return sizes if self.gridded else sizes[:1]

    @property
    def size(self) -> int:
        """Number of cases."""
        return prod(self.shape)

    def _places(self, cases: Array) -> tuple[Array, ...]:
        """Return the positions of the cases in each column."""
        if self.gridded:
            return tuple(np.unravel_index(cases, self.shape))
        return (cases,) * len(self.columns)

    def inputs(self, cases: Array) -> dict[str, Array | tuple[Any, ...]]:
        """Return the inputs of the cases by column."""
        places = self._places(cases)
        return {c.name: c.at(k) for c, k in zip(self.columns, places, strict=True)}

    def labels(self, cases: Array) -> dict[str, Array]:
        """Return the inputs of the cases by column, for tables."""
        places = self._places(cases)
        return {c.name: c.labels[k] for c, k in zip(self.columns, places, strict=True)}

    def chunks(self, size: int | None = None) -> list[Array]:
        """Divide the cases into chunks of neighbours, by default of 10 to 100 cases.

        Chunks of small studies are small, so that every worker gets some.
        """
        size = size or min(100, max(10, ceil(self.size / 32)))
        order, points = np.arange(self.size), None
        if self.gridded:
            # objects vary slowest, then nested fields: they change the solution most
            rank = [(c.numeric, -c.name.count(".")) for c in self.columns]
            order = serpentine(self.shape, sorted(range(len(rank)), key=lambda k: rank[k]))
        elif numbers := [c.values for c in self.columns if isinstance(c.values, np.ndarray)]:
            points = np.column_stack(numbers)
            order = bisection_order(points)
        chunks = [order[k : k + size] for k in range(0, self.size, size)]
        return chunks if points is None else [rows[tour(points[rows])] for rows in chunks]

    def record(self) -> dict[str, Any]:
        """Return the design for JSON."""
        return {"kind": self.kind, "columns": {c.name: c.record() for c in self.columns}}


def make_design(
    over: Mapping[str, Any], kind: str = "grid", samples: int | None = None, seed: int = 0
) -> Design:
    """Return the design of a study.

    Parameters
    ----------
    over : mapping
        Dotted name of a field -> values (grid, table) or range (low, high[, "log"]) (drawn).
    kind : {"grid", "table", "latin-hypercube", "sobol"}
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
    >>> design = make_design({"nip_load": [1e3, 2e3, 4e3], "roll_friction": [0.2, 0.3]})
    >>> design.size, design.names
    (6, ('nip_load', 'roll_friction'))
    """
    if kind not in DESIGNS:
        raise InvalidProblem.at("design", f"{kind!r} is unknown{did_you_mean(kind, DESIGNS)}")
    if not isinstance(over, Mapping) or not over:
        raise InvalidProblem.at("over", "nothing to vary: give fields and their values")
    if kind in ("grid", "table"):
        if samples is not None:
            raise InvalidProblem.at("samples", f"{samples!r} has no meaning in a {kind} design")
        design = Design(kind, tuple(Column.of(name, values) for name, values in over.items()))
        lengths = {len(c.values) for c in design.columns}
        if kind == "table" and len(lengths) > 1:
            raise InvalidProblem.at("over", f"columns of a table differ in length: {lengths}")
    else:
        ranges = [Range(name, ends) for name, ends in over.items()]
        points = _draw_points(kind, len(ranges), _check_samples(kind, samples), seed)
        columns = (Column(r.name, r.scaled(points[:, k])) for k, r in enumerate(ranges))
        design = Design(kind, tuple(columns))
    if design.size > MOST_CASES:
        raise InvalidProblem.at("over", f"{design.size} cases are more than {MOST_CASES}")
    return design


def _check_samples(kind: str, samples: int | None) -> int:
    """Return the number of samples; for Sobol points it must be a power of 2."""
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 2:
        raise InvalidProblem.at("samples", f"{samples!r} is not a number of cases, at least 2")
    power = int(log2(samples))
    if kind == "sobol" and samples != 2**power:
        nearest = f"{2**power} or {2 ** (power + 1)}"
        text = f"{samples} is not a power of 2, which Sobol points require: {nearest}"
        raise InvalidProblem.at("samples", text)
    return int(samples)


def _draw_points(kind: str, inputs: int, samples: int, seed: int) -> Array:
    """Draw points of the unit cube, (samples, inputs)."""
    from scipy.stats import qmc

    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InvalidProblem.at("seed", f"{seed!r} is not a whole number, at least 0")
    if kind == "sobol":
        return np.asarray(qmc.Sobol(inputs, rng=seed).random_base2(int(log2(samples))))
    return np.asarray(qmc.LatinHypercube(inputs, rng=seed).random(samples))

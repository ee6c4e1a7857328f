"""Table of the cases of a study with outputs, failures and warnings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidProblem, NoSteadyState, NotConverged
from ..quantities import Quantity
from ..results import Presented
from .design import Design
from .evaluate import Block

if TYPE_CHECKING:
    import xarray

__all__ = ["Table", "failures"]

Array = np.ndarray
TEXTS = {
    "failure": "reason of the failure; empty if the case was solved",
    "warnings": "warnings about the validity of the model",
}


_REJECTIONS = tuple(f"{kind.__name__}: " for kind in (InvalidProblem, NoSteadyState))


@dataclass(frozen=True, eq=False, repr=False)
class Table(Presented):
    """Every case of a study.

    Attributes
    ----------
    design : Design
    outputs : mapping of str to (cases,) float array
        nan where the case failed.
    failure, warnings : (cases,) object arrays of str
    quantities : mapping of str to Quantity
        Of inputs and outputs; bodies, materials and words have none.
    record : mapping
        All that the results depend on: base problem, settings, version.
    """

    design: Design
    outputs: Mapping[str, Array]
    failure: Array
    warnings: Array
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    record: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def empty(
        cls,
        design: Design,
        outputs: tuple[str, ...],
        quantities: Mapping[str, Quantity],
        record: Mapping[str, Any],
    ) -> Table:
        """Return a table to be filled by :meth:`put`."""
        n = design.size
        columns = {name: np.full(n, np.nan) for name in outputs}
        reasons = np.full(n, "not solved", dtype=object)
        return cls(design, columns, reasons, np.full(n, "", dtype=object), quantities, record)

    def put(self, block: Block) -> None:
        """Enter the rows of a solved chunk."""
        for column, values in zip(self.outputs.values(), block.values.T, strict=True):
            column[block.cases] = values
        self.failure[block.cases] = block.failure
        self.warnings[block.cases] = block.warnings

    @property
    def failed(self) -> Array:
        """Numbers of the failed cases."""
        return np.nonzero(self.failure != "")[0]

    def check_any_solved(self) -> Table:
        """Return the table itself if a case was solved.

        Raises
        ------
        InvalidProblem, NotConverged
            If no case was solved, with the most frequent reasons; InvalidProblem if all cases were
            rejected before they were solved.
        """
        if self.failed.size < self.design.size:
            return self
        reasons = failures(self.failure)
        others = self.design.size - sum(count for _, count in reasons)
        texts = [f"{count} x {reason}" for reason, count in reasons]
        texts += [f"{others} x others"] if others else []
        text = f"none of the {self.design.size} cases was solved: {'; '.join(texts)}"
        if all(reason.startswith(_REJECTIONS) for reason in self.failure):
            raise InvalidProblem.at("over", text)
        raise NotConverged(text, self.to_dataset())

    def columns(self) -> dict[str, Array]:
        """Return all columns: case, inputs, outputs, failure, warnings."""
        cases = np.arange(self.design.size)
        return {
            "case": cases,
            **self.design.labels(cases),
            **self.outputs,
            "failure": self.failure,
            "warnings": self.warnings,
        }

    def __repr__(self) -> str:
        return (
            f"Table({self.design.size} cases of {', '.join(self.design.names)}; "
            f"{', '.join(self.outputs)}; {self.failed.size} failed)"
        )

    def to_dataset(self) -> xarray.Dataset:
        """Return an xarray Dataset: a dimension for each axis of a grid, or ``case``.

        Inputs are coordinates.  Every variable has ``units``, ``long_name`` and ``symbol``; the
        attributes hold the base problem, the settings and the version.
        """
        import xarray

        design = self.design
        dims = design.names if design.gridded else ("case",)
        coordinates: dict[str, Any] = {
            c.name: (c.name if design.gridded else "case", c.labels, self._attributes(c.name))
            for c in design.columns
        }
        if not design.gridded:
            coordinates["case"] = np.arange(design.size)
        variables: dict[str, Any] = {
            name: (dims, values.reshape(design.shape), self._attributes(name))
            for name, values in self.outputs.items()
        }
        for name, meaning in TEXTS.items():
            texts = getattr(self, name).reshape(design.shape)
            variables[name] = (dims, texts, {"long_name": meaning})
        record = {k: v if isinstance(v, str) else json.dumps(v) for k, v in self.record.items()}
        return xarray.Dataset(variables, coordinates, {"design": design.kind, **record})

    def _attributes(self, name: str) -> dict[str, str]:
        """Return unit, name and symbol of an input or output for xarray."""
        quantity = self.quantities.get(name)
        if quantity is None:
            return {}
        return {"units": quantity.unit, "long_name": quantity.meaning, "symbol": quantity.symbol}

    def plot(self, output: str, path: Any = None) -> Any:
        """Draw one output over the inputs."""
        return self._figure(output, path)


def failures(reasons: Array, limit: int = 5) -> list[tuple[str, int]]:
    """Return the most frequent reasons of failure with their counts, ignoring numbers in them.

    >>> failures(np.array(["load 1 N", "load 2 N", ""], dtype=object))
    [('load 1 N', 2)]
    """
    import re

    kinds: dict[str, list[Any]] = {}
    for reason in reasons[reasons != ""]:
        kinds.setdefault(re.sub(r"[-+]?\d[\d.eE+-]*", "#", reason), []).append(reason)
    ranked = sorted(kinds.values(), key=len, reverse=True)
    return [(group[0], len(group)) for group in ranked[:limit]]

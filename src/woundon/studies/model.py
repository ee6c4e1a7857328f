"""Interface between studies and solvers: inputs by name, outputs, and a state for warm starts.

Studies use a solver through a :class:`Model` only.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Protocol

from ..quantities import Quantity

__all__ = ["Answer", "Model", "quantities_of"]


class Answer(NamedTuple):
    """One solved case.

    Attributes
    ----------
    values : tuple of float
        The outputs, in the order of ``Model.outputs``, in SI units.
    warnings : str
        Warnings about the validity of the model; empty if there are none.
    state : object
        Warm start for a neighbouring case.
    """

    values: tuple[float, ...]
    warnings: str
    state: Any


class Model(Protocol):
    """A solver bound to a base problem; it is sent to worker processes, so it must pickle."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        ...

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        """Solve one case; ``start`` is the state of a neighbour and must not change the result.

        An exception is the reason for the failure of the case.
        """
        ...

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of an input or output; None if it is not a number.

        Raises
        ------
        InvalidProblem
            If there is no such input or output.
        """
        ...

    def record(self) -> dict[str, Any]:
        """Return all that the results depend on (base problem, settings, version), for JSON."""
        ...


def quantities_of(model: Model, names: Iterable[str]) -> dict[str, Quantity]:
    """Return the quantities of those inputs and outputs that are numbers."""
    known = {name: model.quantity(name) for name in names}
    return {name: quantity for name, quantity in known.items() if quantity is not None}

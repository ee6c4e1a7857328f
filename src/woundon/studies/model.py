"""What a study needs of a solver: inputs by name in, numbers out, and a state to start from.

A study knows nothing of what it studies.  Whoever binds a solver to it writes a :class:`Model`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..quantities import Quantity

__all__ = ["Answer", "Model", "quantities_of"]


class Answer(NamedTuple):
    """One solved case.

    Attributes
    ----------
    values : tuple of float
        The outputs, in the order of ``Model.outputs``, in SI units.
    warnings : str
        Where the case leaves the model's validity; empty where it does not.
    state : object
        What a neighbouring case may start from.
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
        """Solve one case; ``start`` is the state of a neighbour and must not change the answer.

        Whatever it raises is the reason why the case failed.
        """
        ...

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        """Return exact derivatives of a solved case's outputs, (outputs, names), None without."""
        ...

    def quantity(self, name: str) -> Quantity | None:
        """Return what an input or output is, None for what is not a number.

        Raises
        ------
        InvalidProblem
            If there is no such input or output.
        """
        ...

    def record(self) -> dict[str, Any]:
        """Return all that the numbers depend on (base problem, settings, version) for JSON."""
        ...


def quantities_of(model: Model, names: Iterable[str]) -> dict[str, Quantity]:
    """Return what inputs and outputs are, those that are numbers."""
    told = {name: model.quantity(name) for name in names}
    return {name: quantity for name, quantity in told.items() if quantity is not None}

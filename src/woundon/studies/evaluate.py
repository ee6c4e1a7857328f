"""Solving a chunk of cases: the one function that runs in worker processes."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import __version__
from ..parallel import progress
from .model import Model

__all__ = ["Block", "Chunk", "solve_chunk"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Chunk:
    """Cases that one worker solves in a row.

    Attributes
    ----------
    number : int
        Its place in the study.
    cases : (k,) int array
        Numbers of the cases.
    inputs : mapping of str to (k,) float array or tuple
        Inputs of the cases by column.
    """

    number: int
    cases: Array
    inputs: Mapping[str, Array | tuple[Any, ...]]

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the inputs of each case; numbers as Python's own."""
        columns = (c.tolist() if isinstance(c, np.ndarray) else c for c in self.inputs.values())
        for row in zip(*columns, strict=True):
            yield dict(zip(self.inputs, row, strict=True))


@dataclass(frozen=True, eq=False)
class Block:
    """A solved chunk.

    Attributes
    ----------
    number, cases
        As of the chunk.
    values : (k, outputs) array
        nan where the case failed.
    failure, warnings : (k,) object arrays of str
        Why it failed, '' where it did not; where it leaves the model's validity.
    seconds : float
        Time spent in the solver.
    version : str
        The program's version at the worker.
    """

    number: int
    cases: Array
    values: Array
    failure: Array
    warnings: Array
    seconds: float = 0.0
    version: str = __version__

    @classmethod
    def failed(cls, chunk: Chunk, outputs: int, reason: str) -> Block:
        """Return the block of a chunk that could not be solved at all."""
        k = len(chunk.cases)
        reasons, no_warnings = np.full(k, reason, dtype=object), np.full(k, "", dtype=object)
        return cls(chunk.number, chunk.cases, np.full((k, outputs), np.nan), reasons, no_warnings)


def solve_chunk(model: Model, chunk: Chunk) -> Block:
    """Solve the cases in their order, each from the state of the last one that was solved.

    If a case raises an exception, this is the reason of its failure in the block.
    """
    block = Block.failed(chunk, len(model.outputs), "")
    state, began = None, time.perf_counter()
    for row, inputs in enumerate(chunk.rows()):
        progress(row / len(chunk.cases))
        try:
            answer = model.run(inputs, state)
        except Exception as fault:
            # an exception of a solver or of an output of a plug-in must not end the study
            block.failure[row] = f"{type(fault).__name__}: {fault}".replace("\n", "; ")
            continue
        block.values[row], block.warnings[row] = answer.values, answer.warnings
        state = answer.state
    seconds = time.perf_counter() - began
    return Block(block.number, block.cases, block.values, block.failure, block.warnings, seconds)

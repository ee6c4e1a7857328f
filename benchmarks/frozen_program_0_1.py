"""Version 0.1 of the program under the names of 0.2, to make the frozen set's reference numbers.

    PYTHONPATH=<tree of 0.1>/src python benchmarks/frozen.py make

Nothing else imports it where the program has ``wo.solve``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
from frozen_cases import Case

import woundon as wo
import woundon.nip
import woundon.rollers
import woundon.wrap.solve

__all__ = ["solved", "tightened"]

# what 0.2 calls a plain nip's tension behind the nip
_OLD_NAMES = {"tension_behind_nip": "wound_on_tension"}


class _Renamed:
    """A result of 0.1 with the names of 0.2."""

    def __init__(self, result: Any) -> None:
        self._result = result

    def __getattr__(self, name: str) -> Any:
        result = self._result
        if name == "peak_pressure":
            return float(np.max(result.pressure))
        if name == "nip_width":
            return 2 * result.half_width
        if isinstance(result, wo.NipResult):
            if name == "wound_on_tension":
                raise AttributeError(name)
            name = _OLD_NAMES.get(name, name)
        return getattr(result, name)


def solved(case: Case) -> Any:
    """Solve a case."""
    problem, options, study = case.problem, case.table("options"), case.table("study")
    if case.kind == "sweep":
        outputs = [_OLD_NAMES.get(name, name) for name in case.given["outputs"]]
        dataset = wo.sweep(problem, case.table("over"), outputs, workers=1, **study, **options)
        names = {old: new for new, old in _OLD_NAMES.items() if old in dataset}
        return dataset.rename(names)
    if case.kind == "fit":
        data = {_old_column(name): values for name, values in case.given["measured"].items()}
        return wo.fit(problem, data, case.table("vary"), **study, **options)
    if case.kind == "rollers":
        return _Renamed(wo.solve_rollers(problem, **options))
    if case.kind == "wrap":
        return _Renamed(wo.solve_wrapped_nip(problem, **case.table("wrap"), **options))
    if "start" in case.given:
        neighbour = problem.replace(**case.table("start"))
        options["start"] = wo.solve_nip(neighbour, **options)
    result = wo.solve_nip(problem, **options)
    return result.sensitivity() if case.kind == "sensitivity" else _Renamed(result)


def _old_column(name: str) -> str:
    head, _, rest = name.partition(" ")
    return f"{_OLD_NAMES.get(head, head)} {rest}".strip()


@contextmanager
def tightened(tight: float) -> Iterator[None]:
    """Solve for loads, and for the balance of a wrapped web, to ``tight`` on every grid."""
    nip, wrap, rollers = woundon.nip, woundon.wrap.solve, woundon.rollers
    solve: Any = nip._Solver.solve  # has the constant for a default, bound when it was defined
    width: Any = rollers.width_for_load

    def exact_width(evaluate: Any, load: float, guess: float, rtol: float, **others: Any) -> Any:
        return width(evaluate, load, guess, min(rtol, tight), **others)

    with ExitStack() as changed:
        for module, names in (
            (nip, ("LOAD_RTOL", "COARSE_LOAD_RTOL")),
            (wrap, ("LOAD_RTOL", "COARSE_LOAD_RTOL", "BALANCE_RTOL", "COARSE_BALANCE_RTOL")),
        ):
            for name in names:
                changed.enter_context(patch.object(module, name, tight))
        changed.enter_context(patch.object(solve, "__defaults__", (tight,)))
        changed.enter_context(patch.object(rollers, "width_for_load", exact_width))
        yield

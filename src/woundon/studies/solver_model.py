"""Binds woundon's problems and solvers to the study engine: a base problem as a ``Model``.

What knows of nips in this folder is here, in ``nip`` and in ``studyfile``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from inspect import signature
from math import nan
from operator import attrgetter
from typing import Any

import numpy as np

from .. import __version__
from ..errors import InvalidProblem, NotConverged, did_you_mean
from ..problems import NipProblem, RollerProblem
from ..quantities import QUANTITIES
from ..results import NipResult, RollerResult
from .fields import field_label, follow
from .model import Answer, Label

__all__ = ["Problem", "SolverModel", "all_labels", "solver_model"]

Problem = NipProblem | RollerProblem
Result = NipResult | RollerResult


def _rig_tension(result: Any) -> float:
    from ..surface import rig_tension

    return rig_tension(result)


# outputs that are no fields of a result
_DERIVED: dict[str, Callable[[Any], float]] = {
    "peak_pressure": lambda result: float(np.max(result.pressure)),
    "nip_width": lambda result: 2 * result.half_width,
    "residual": lambda result: result.residuals.largest,
}
_OF_NIPS: dict[str, Callable[[Any], float]] = {
    "wound_on_tension": lambda result: result.wound_on_tension,
    "rig_tension": _rig_tension,
    "leading_roll": lambda result: result.slip_ratios.leading_roll,
    "trailing_roll": lambda result: result.slip_ratios.trailing_roll,
    "dual": lambda result: result.slip_ratios.dual,
}
_LABELS = {
    "rig_tension": Label(
        "N/m", "tension at a load cell to which the web is led off the roll, eq. (183)", "T_rig"
    )
}


# by the winding theorem these depend on the web tension before the nip through T_in + NIT alone
_FREE_OF_TENSION = {
    "nip_induced_tension", "nip_induced_tension_error", "wound_on_tension", "rig_tension",
    "half_width", "nip_width", "offset", "peak_pressure", "leading_roll", "trailing_roll", "dual",
}  # fmt: skip
# output -> the one that NipResult.sensitivity gives, and the factor between them
_DIFFERENTIABLE = {
    "nip_induced_tension": ("nip_induced_tension", 1.0),
    "wound_on_tension": ("nip_induced_tension", 1.0),
    "half_width": ("half_width", 1.0),
    "nip_width": ("half_width", 2.0),
    "drum_creep": ("drum_creep", 1.0),
}


def _at_tension(result: NipResult, T_in: float) -> NipResult:
    """Return the result under another web tension, but for approach and creep."""
    from ..validity import nip_warnings

    step = T_in - result.problem.web_tension
    moved = replace(
        result,
        problem=result.problem.replace(web_tension=T_in),
        web_tension=result.web_tension + step,
        approach=nan, drum_creep=nan,
    )  # fmt: skip
    return moved.with_warnings(nip_warnings(moved))


def _outputs_of(problem: Problem) -> dict[str, Callable[[Any], float]]:
    """Return how to take each scalar output from a result."""
    of: type[Any] = NipResult if isinstance(problem, NipProblem) else RollerResult
    plain = [f.name for f in fields(of) if f.type in ("float", "int")]
    known = {name: attrgetter(name) for name in plain} | _DERIVED
    return known | (_OF_NIPS if of is NipResult else {})


def _solver_of(problem: Problem) -> Callable[..., Result]:
    if isinstance(problem, RollerProblem):
        from ..rollers import solve_rollers

        return solve_rollers
    from ..nip import solve_nip

    return solve_nip


def _check_values(problem: Problem, options: Mapping[str, Any]) -> None:
    """Refuse options out of range before any case is solved."""
    if isinstance(problem, RollerProblem):
        from .. import rollers

        rollers.check_options(**options)
    else:
        from .. import nip

        nip.check_options(**options)


@cache
def _keywords(solver: Callable[..., Result]) -> frozenset[str]:
    parameters = signature(solver).parameters.values()
    return frozenset(p.name for p in parameters if p.kind is p.KEYWORD_ONLY)


@dataclass(frozen=True, eq=False)
class SolverModel:
    """A base problem, the outputs wanted and the solver's options: a :class:`~.model.Model`.

    Attributes
    ----------
    problem : NipProblem or RollerProblem
    outputs : tuple of str
    options : mapping
        Keywords of the solver.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``: one paper.
    """

    problem: Problem
    outputs: tuple[str, ...]
    options: Mapping[str, Any] = field(default_factory=dict)
    tie: Mapping[str, str] = field(default_factory=dict)

    def checked(self) -> SolverModel:
        """Return itself.

        Raises
        ------
        InvalidProblem
            For an output, an option or a tied field that does not exist.
        """
        known = _outputs_of(self.problem)
        if not self.outputs:
            raise InvalidProblem([("outputs", f"none is asked for; known: {', '.join(known)}")])
        twice = [name for name in dict.fromkeys(self.outputs) if self.outputs.count(name) > 1]
        if twice:
            raise InvalidProblem([("outputs", f"{twice[0]!r} is given twice")])
        faults = [
            (name, f"no scalar output{did_you_mean(name, known)}")
            for name in self.outputs
            if name not in known
        ]
        if faults:
            raise InvalidProblem(faults)
        keywords = _keywords(_solver_of(self.problem)) - {"start"}
        for name in self.options:
            if name not in keywords:
                raise InvalidProblem([(name, f"no such option{did_you_mean(name, keywords)}")])
        self._check_ties()
        _check_values(self.problem, self.options)
        self.variant({})
        return self

    def _check_ties(self) -> None:
        given: Mapping[Any, Any] = self.tie
        for follower, leader in given.items():
            if not isinstance(follower, str) or not isinstance(leader, str):
                text = f"{leader!r} is no name of a field; write FIELD = 'FIELD'"
                raise InvalidProblem([(f"tie.{follower}", text)])

    def check_free(self, names: Iterable[Any]) -> None:
        """Refuse to vary a field that follows another: its values would never be used."""
        for name in names:
            for follower, leader in self.tie.items():
                if name == follower or str(name).startswith(f"{follower}."):
                    text = f"cannot be varied, for {follower} is tied to {leader}"
                    raise InvalidProblem([(str(name), text)])

    def variant(self, inputs: Mapping[str, Any]) -> Problem:
        """Return the problem of one case."""
        problem: Problem = follow(self.problem.replace(**inputs), self.tie)
        return problem

    def solve(self, problem: Problem, start: Any | None) -> Result:
        """Solve; a start that leads nowhere is put aside."""
        if isinstance(start, NipResult) and isinstance(problem, NipProblem) and self.free_inputs:
            others = (name for name in NipProblem.model_fields if name != "web_tension")
            if all(getattr(start.problem, name) == getattr(problem, name) for name in others):
                return _at_tension(start, problem.web_tension)
        solver: Callable[..., Result] = _solver_of(self.problem)
        if start is not None and "start" in _keywords(solver):
            try:
                return solver(problem, start=start, **self.options)
            except NotConverged:
                pass
        return solver(problem, **self.options)

    @cached_property
    def _takers(self) -> tuple[Callable[[Any], float], ...]:
        known = _outputs_of(self.problem)
        return tuple(known[name] for name in self.outputs)

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        """Solve one case."""
        result = self.solve(self.variant(inputs), start)
        values = tuple(float(take(result)) for take in self._takers)
        return Answer(values, "; ".join(result.warnings), result)

    @property
    def free_inputs(self) -> frozenset[str]:
        """The web tension before the nip, where no output depends on more than T_in + NIT."""
        only_shifts = isinstance(self.problem, NipProblem) and set(self.outputs) <= _FREE_OF_TENSION
        return frozenset({"web_tension"} if only_shifts else ())

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        """Return exact derivatives of the outputs, None where one of them has none."""
        if not isinstance(state, NipResult) or not set(self.outputs) <= set(_DIFFERENTIABLE):
            return None
        paths = [(name, *self._followers(name)) for name in names]
        flat = tuple(dict.fromkeys(path for group in paths for path in group))
        found = state.sensitivity(*flat)
        columns = {path: found.derivatives[:, k] for k, path in enumerate(found.parameters)}
        summed = np.column_stack([sum(columns[path] for path in group) for group in paths])
        gradient = np.empty((len(self.outputs), len(names)))
        for row, output in enumerate(self.outputs):
            source, factor = _DIFFERENTIABLE[output]
            gradient[row] = factor * summed[found.outputs.index(source)]
            if output == "wound_on_tension":
                gradient[row] += [name == "web_tension" for name in names]
        return gradient

    def _followers(self, name: str) -> list[str]:
        """Return the tied fields that change when ``name`` does."""
        return [
            path + name.removeprefix(leader)
            for path, leader in self.tie.items()
            if name == leader or name.startswith(f"{leader}.")
        ]

    def label(self, name: str) -> Label:
        """Return unit and meaning of a field or an output."""
        if name in _LABELS:
            return _LABELS[name]
        if name in QUANTITIES and name in _outputs_of(self.problem):
            quantity = QUANTITIES[name]
            return Label(quantity.unit, quantity.description, quantity.symbol)
        return field_label(self.problem, name)

    def record(self) -> dict[str, Any]:
        """Return all that the numbers depend on, for JSON."""
        return {
            "version": __version__,
            "problem": self.problem.model_dump(),
            "options": dict(self.options),
            "tie": dict(self.tie),
        }


def solver_model(
    problem: Any,
    outputs: Sequence[str],
    tie: Mapping[str, str] | None,
    options: Mapping[str, Any],
) -> SolverModel:
    """Return the model of a study; options that are None are left to the solver."""
    if not isinstance(problem, (NipProblem, RollerProblem)):
        text = f"{problem!r} is no problem; must be a NipProblem or a RollerProblem"
        raise InvalidProblem([("problem", text)])
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    given = {name: value for name, value in options.items() if value is not None}
    return SolverModel(problem, names, given, dict(tie or {})).checked()


def all_labels(problem: Problem) -> dict[str, Label]:
    """Return every scalar output that has a unit, with it."""
    model = SolverModel(problem, ())
    known = (name for name in _outputs_of(problem) if name in QUANTITIES or name in _LABELS)
    return {name: model.label(name) for name in known}

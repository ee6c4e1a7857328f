"""Binds woundon's problems and solvers to the study engine: ``wo.sweep`` and its kin.

The only module of this folder that knows what a nip is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from inspect import signature
from math import nan
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__
from ..errors import InvalidProblem, NotConverged, did_you_mean
from ..problems import NipProblem, RollerProblem
from ..quantities import QUANTITIES
from ..results import NipResult, RollerResult
from .design import make_design
from .engine import Progress, run_study
from .fields import field_label, follow, get_field
from .fit import FitResult, fit_parameters
from .measured import Measured, read_measured
from .model import Answer, Label
from .predict import Parameter, Predictor
from .runners import runner_for
from .sobol import SobolIndices, saltelli_design, sobol_indices_of
from .table import Table

if TYPE_CHECKING:
    import xarray

__all__ = ["SolverModel", "fit", "global_sensitivity", "solver_model", "sweep", "sweep_table"]

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
        self.variant({})
        return self

    def variant(self, inputs: Mapping[str, Any]) -> Problem:
        """Return the problem of one case."""
        problem: Problem = follow(self.problem.replace(**inputs), self.tie)
        return problem

    def solve(self, problem: Problem, start: Any | None) -> Result:
        """Solve; a start that leads nowhere is put aside."""
        if isinstance(start, NipResult) and isinstance(problem, NipProblem) and self.free_inputs:
            T_in = problem.web_tension
            if start.problem.replace(web_tension=T_in) == problem:
                return _at_tension(start, T_in)
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
    problem: Problem,
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


def sweep(
    problem: Problem,
    over: Mapping[str, Any],
    outputs: Sequence[str] = ("nip_induced_tension",),
    **options: Any,
) -> xarray.Dataset:
    """Solve a problem for many values of its fields.

    Parameters
    ----------
    problem : NipProblem or RollerProblem
        What is not varied.
    over : mapping
        Dotted name of any field -> its values, SI; for a drawn design (low, high) or
        (low, high, "log").  Values may be bodies or names of materials too.
    outputs : sequence of str
        Any scalar of the result; also ``peak_pressure``, ``nip_width``, ``dual``, ``leading_roll``,
        ``trailing_roll``, ``residual`` (largest violation of a law), ``rig_tension``.
    design : {"grid", "table", "latin-hypercube", "sobol"}
        All combinations (default); row by row; drawn.
    samples, seed : int
        Of a drawn design: number of cases (a power of 2 for "sobol"), and the generator's seed.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    workers : int
        Processes; by default one a core where it pays.
    scheduler : str
        Address of a Dask scheduler, "tcp://..."; its workers solve.
    out : path
        Folder that keeps results as they come; ``resume=True`` goes on with what it holds.
    chunk : int
        Cases that are solved in a row, each from the state of the one before.
    progress : bool or callable
        Show rate and time left, or call with (cases done, cases in all).
    scheme, nodes, rtol, algorithm
        As of :func:`~woundon.nip.solve_nip`.

    Returns
    -------
    xarray.Dataset
        A dimension for each input of a grid, or ``case``.  Failed cases are nan, their reason is in
        the variable ``failure``.  The numbers depend neither on workers nor on interruptions.

    Raises
    ------
    InvalidProblem
        For a name that does not exist, or a folder that holds another study.
    """
    return sweep_table(problem, over, outputs, **options).to_dataset()


def sweep_table(
    problem: Problem,
    over: Mapping[str, Any],
    outputs: Sequence[str] = ("nip_induced_tension",),
    *,
    design: str = "grid",
    samples: int | None = None,
    seed: int = 0,
    tie: Mapping[str, str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    chunk: int | None = None,
    progress: bool | Progress = False,
    **options: Any,
) -> Table:
    """Return the table of :func:`sweep`."""
    model = solver_model(problem, outputs, tie, options)
    return run_study(
        model, make_design(over, design, samples, seed), runner_for(workers, scheduler),
        out=out, resume=resume, chunk=chunk, progress=progress,
    )  # fmt: skip


def global_sensitivity(
    problem: Problem,
    over: Mapping[str, Any],
    outputs: Sequence[str] = ("nip_induced_tension",),
    *,
    samples: int = 256,
    seed: int = 0,
    tie: Mapping[str, str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    progress: bool | Progress = False,
    **options: Any,
) -> SobolIndices:
    """Return how much of each output's variance the ranges of inputs explain (Sobol's indices).

    Parameters
    ----------
    problem : NipProblem or RollerProblem
    over : mapping
        Dotted name -> range (low, high), or (low, high, "log") for one even in the logarithm.
    outputs : sequence of str
    samples : int
        Base samples, a power of 2; samples * (inputs + 2) cases are solved.
    seed, tie, workers, scheduler, out, resume, progress, options
        As of :func:`sweep`.

    Raises
    ------
    InvalidProblem
        Also if a case of the ranges cannot be solved: the indices need every one.
    """
    model = solver_model(problem, outputs, tie, options)
    table = run_study(
        model, saltelli_design(over, samples, seed), runner_for(workers, scheduler),
        out=out, resume=resume, progress=progress,
    )  # fmt: skip
    return sobol_indices_of(table, samples, seed)


def fit(
    problem: Problem,
    measured: Any,
    vary: Mapping[str, tuple[float, float] | None] | Sequence[str],
    *,
    tie: Mapping[str, str] | None = None,
    columns: Mapping[str, str | None] | None = None,
    starts: int = 6,
    seed: int = 0,
    profiles: bool = True,
    **options: Any,
) -> FitResult:
    """Fit fields of a problem to measured data by least squares.

    Parameters
    ----------
    problem : NipProblem or RollerProblem
        Everything that is neither measured nor fitted.
    measured : path or mapping
        CSV or Excel file with units in its header, or columns by name: inputs ("nip_load [kN/m]"),
        outputs ("wound_on_tension [N/m]"), and standard deviations of these
        ("wound_on_tension +- [N/m]").
    vary : mapping or sequence of str
        Dotted name -> bounds (low, high) in SI; without bounds, a tenth to ten times the value.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    columns : mapping
        Name in the data -> name here, None for a column to leave out.
    starts, seed : int
        Starting points: the problem as it is, the others drawn.
    profiles : bool
        Find profile-likelihood intervals.
    scheme, nodes
        As of :func:`~woundon.nip.solve_nip`.  Leave ``rtol`` out: on one grid the outputs are
        continuous in the parameters, between grids they jump by the discretisation's error.

    Returns
    -------
    FitResult
        Its ``problem`` has the estimates put in.

    Raises
    ------
    InvalidProblem
        For names, bounds, or data at fault.
    NotConverged
        If no start can be solved.
    """
    # all outputs serve for reading; those measured are then the model's
    names = tuple(_outputs_of(problem)) if isinstance(problem, (NipProblem, RollerProblem)) else ()
    reader = solver_model(problem, names, tie, options)
    data = read_measured(
        measured, {name: reader.label(name) for name in names if name in QUANTITIES or name in _LABELS},
        lambda name: field_label(problem, name), columns,
    )  # fmt: skip
    model = solver_model(problem, tuple(data.outputs), tie, options)
    parameters = tuple(_parameter(problem, name, bounds) for name, bounds in _bounds(vary).items())
    labels = {n: model.label(n) for n in (*(p.name for p in parameters), *data.outputs)}
    _one_unit(labels, data)
    found = fit_parameters(
        Predictor(model, data, parameters), starts=starts, seed=seed, profiles=profiles,
        labels=labels,
    )  # fmt: skip
    return replace(found, problem=model.variant(dict(zip(found.names, found.estimates, strict=True))))


def _bounds(vary: Any) -> dict[str, Any]:
    given = dict(vary) if isinstance(vary, Mapping) else dict.fromkeys(
        [vary] if isinstance(vary, str) else vary
    )  # fmt: skip
    if not given:
        raise InvalidProblem([("vary", "nothing to fit: give fields and their bounds")])
    return given


def _parameter(problem: Problem, name: str, bounds: Any) -> Parameter:
    base = get_field(problem, name)
    if not isinstance(base, float):
        raise InvalidProblem([(name, f"{base!r} is no number, so it cannot be fitted")])
    if bounds is None:
        if base <= 0:
            raise InvalidProblem([(name, f"is {base:g}: give bounds for it")])
        bounds = (base / 10, base * 10)
    try:
        low, high = (float(end) for end in bounds)
    except (TypeError, ValueError):
        raise InvalidProblem([(name, f"{bounds!r} are no bounds; write (low, high)")]) from None
    return Parameter(name, low, high, base)


def _one_unit(labels: Mapping[str, Label], data: Measured) -> None:
    """Refuse to weigh outputs of different units against each other without deviations."""
    units = {labels[name].unit for name in data.outputs}
    if len(units) > 1 and set(data.deviations) != set(data.outputs):
        text = f"outputs of different units ({', '.join(sorted(units))}) need standard deviations"
        raise InvalidProblem([("measured", text)])

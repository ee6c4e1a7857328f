"""Models of studies: inputs by name, outputs, and a state for warm starts.

Studies use a solver through a :class:`Model` only.  :class:`KindModel` is the model of a problem of
any kind, with outputs, solver options and tied fields; problem, solver and result class are looked
up in :mod:`woundon.kinds`, fields and outputs in :mod:`woundon.quantities`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from .. import __version__, kinds
from ..arguments import check_arguments, check_type, keywords_of
from ..errors import InvalidProblem, NotConverged, did_you_mean, unwarned
from ..parallel import progress
from ..problems.paths import field_quantity, get_field, is_part_of
from ..problems.problem import Problem
from ..quantities import Quantity, scalar_outputs, value_of
from ..results import Result

__all__ = [
    "Answer",
    "KindModel",
    "Model",
    "kind_of",
    "model_of",
    "options_of",
    "quantities_of",
    "solver_options",
]

ProblemT = TypeVar("ProblemT", bound=Problem)
_ERROR = "errors."  # of an output: "errors.half_width"
ERROR_OUTPUT = "_error"  # end of the name of an output that is an error estimate


class Answer(NamedTuple):
    """One solved case.

    Attributes
    ----------
    values : tuple of float
        The outputs, in the order of ``Model.outputs``, in SI units.
    warnings : str
        Warnings about inputs and about the validity of the model; empty if there are none.
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

    def run(self, inputs: Mapping[str, Any], start: Result | None) -> Answer:
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


@dataclass(frozen=True, eq=False)
class KindModel:
    """A problem of any kind with the requested outputs and the options of the solver.

    Attributes
    ----------
    problem : Problem
    outputs : tuple of str
    options : mapping
        Keyword arguments of the solver.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    """

    problem: Problem
    outputs: tuple[str, ...]
    options: Mapping[str, Any] = field(default_factory=dict)
    tie: Mapping[str, str] = field(default_factory=dict)

    @property
    def kind(self) -> kinds.Kind:
        """The kind of the problem; looked up, because solvers are not sent to worker processes."""
        return kinds.of(self.problem)

    # ---- validation ----------------------------------------------------------------------------

    def checked(self) -> KindModel:
        """Return the model itself after validation.

        Raises
        ------
        InvalidProblem
            For an output, an option or a tied field that does not exist, or an option out of range.
        """
        self._check_outputs()
        self._check_options()
        self.variant({})  # rejects tied fields that do not exist
        return self

    def _check_outputs(self) -> None:
        """Reject outputs that are missing, repeated or unknown."""
        known = scalar_outputs(self.kind.result)
        if not self.outputs:
            text = f"missing; known: {', '.join(known)}"
            raise InvalidProblem.at("outputs", text)
        repeated = [name for name in dict.fromkeys(self.outputs) if self.outputs.count(name) > 1]
        if repeated:
            raise InvalidProblem.at("outputs", f"{repeated[0]!r} is given twice")
        unknown = [name for name in self.outputs if name.removeprefix(_ERROR) not in known]
        if unknown:
            raise InvalidProblem((name, _no_output(self.problem, name)) for name in unknown)

    def _check_options(self) -> None:
        """Reject unknown options of the solver, and values out of range."""
        known = options_of(self.problem)
        for name in self.options:
            if name in type(self.problem).model_fields:
                text = f"is a field of the problem, not an option: use problem.replace({name}=...)"
                raise InvalidProblem.at(name, text)
            if name not in known:
                text = f"no such option{did_you_mean(name, known)}"
                raise InvalidProblem.at(name, text)
        if self.kind.check is not None:
            self.kind.check(**self.options)

    def check_varied(self, names: Iterable[Any]) -> None:
        """Reject varied fields that do not exist or are tied to others.

        A field that the base problem lacks may belong to a body or material that is varied too.
        """
        varied = [str(name) for name in names]
        for name in varied:
            for follower, leader in self.tie.items():
                if is_part_of(name, follower):  # the field itself, or a field in a tied body
                    text = f"cannot be varied, because {follower} is tied to {leader}"
                    raise InvalidProblem.at(name, text)
            if not any(name != other and is_part_of(name, other) for other in varied):
                get_field(self.problem, name)  # raises an error if it does not exist

    def check_effects(
        self, ranges: Mapping[str, tuple[float, float]], rows: Iterable[Mapping[str, Any]] = ({},)
    ) -> None:
        """Reject a field on which nothing depends, nor on those that follow it.

        Parameters
        ----------
        ranges : mapping of str to (float, float)
            Ends of the varied fields.  A field may have an effect by another one: all are tried at
            their upper ends, in the middle, and at their lower ends.
        rows : iterable of mappings
            Other inputs of the cases.

        Raises
        ------
        InvalidProblem
            With the reason, if it is known.

        Examples
        --------
        >>> import woundon as wo
        >>> coreless = wo.RollProblem.example().replace(core_removed=True)
        >>> try:
        ...     KindModel(coreless, ()).check_effects({"core_shrinkage": (0, 0.01)})
        ... except wo.InvalidProblem as fault:
        ...     print(str(fault).partition(";")[0])
        core_shrinkage: has no effect in this case, as core_removed = true
        """
        without = list(ranges)
        for inputs in rows:
            for share in (1.0, 0.5, 0.0):
                point = {name: low + share * (high - low) for name, (low, high) in ranges.items()}
                with suppress(InvalidProblem), unwarned():  # not every combination is valid
                    unused = self.variant({**inputs, **point}).unused
                    without = [name for name in without if not self._has_effect(name, unused)]
                if not without:
                    return
        for name in without:
            if not self._has_effect(name, self.problem.unused):
                reason = _reason_without_effect(self.problem, name, ranges[name][1])
                text = f"has no effect in this case{reason}; must be a field that has one"
                raise InvalidProblem.at(name, text)

    def _has_effect(self, name: str, unused: Sequence[str]) -> bool:
        """Return whether a field, or one that follows it, is not among the unused ones."""
        in_parts = [f for f, leader in self.tie.items() if is_part_of(leader, name)]
        names = [name, *self.followers(name), *in_parts]
        return any(not any(is_part_of(each, part) for part in unused) for each in names)

    def followers(self, name: str) -> list[str]:
        """Return the fields that follow a field: of one in a body, the same in each tied body."""
        return [
            follower + name.removeprefix(leader)
            for follower, leader in self.tie.items()
            if is_part_of(name, leader)
        ]

    def without_estimates(self) -> KindModel:
        """Return the model that omits error estimates if no output is one and none are asked for.

        With given nodes a case that starts from another one is then solved on its last mesh alone.
        """
        is_estimated = any(
            name.startswith(_ERROR) or name.endswith(ERROR_OUTPUT) for name in self.outputs
        )
        if is_estimated or {"errors", "rtol"} & self.options.keys() or "nodes" not in self.options:
            return self
        if "errors" not in options_of(self.problem):
            return self
        return replace(self, options={**self.options, "errors": False})

    # ---- one case -------------------------------------------------------------------------------

    def variant(self, inputs: Mapping[str, Any]) -> Problem:
        """Return the problem of one case."""
        return self.with_ties(self.problem.replace(**inputs))

    def admits(self, inputs: Mapping[str, Any]) -> bool:
        """Return True if the problem of a case is valid."""
        try:
            with unwarned():
                self.variant(inputs)
        except InvalidProblem:
            return False
        return True

    def with_ties(self, problem: ProblemT) -> ProblemT:
        """Return a problem whose tied fields have the values of the fields that they follow."""
        if not self.tie:
            return problem
        return problem.replace(
            **{follower: get_field(problem, leader) for follower, leader in self.tie.items()}
        )

    def solve(self, problem: Problem, start: Result | None) -> Result:
        """Solve a problem; if a warm start does not converge, solve without it.

        In a worker process the solver is cancelled at its next report of progress, if requested.
        """
        kind, options = self.kind, dict(self.options)
        known = keywords_of(kind.solver)
        if "progress" in known:
            options["progress"] = progress
        if isinstance(start, kind.result) and "start" in known:
            with suppress(NotConverged):
                return kind.solver(problem, start=start, **options)
        return kind.solver(problem, **options)

    def run(self, inputs: Mapping[str, Any], start: Result | None) -> Answer:
        """Solve one case."""
        with unwarned():  # warnings are a column of the table
            problem = self.variant(inputs)
            result = self.solve(problem, start)
            values = tuple(float(_value(result, name)) for name in self.outputs)
        warnings = (*getattr(problem, "input_warnings", ()), *result.warnings)
        return Answer(values, "; ".join(warnings), result)

    # ---- quantities and record ------------------------------------------------------------------

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of an output or a field; None for a field that is not a number."""
        output = name.removeprefix(_ERROR)
        known = scalar_outputs(self.kind.result)
        if output not in known:
            return field_quantity(self.problem, name)
        base = known[output]
        return (
            base if output == name else replace(base, meaning=f"estimated error of: {base.meaning}")
        )

    def record(self) -> dict[str, Any]:
        """Return all inputs that the results depend on, for JSON."""
        plain = (str, int, float, type(None))
        return {
            "version": __version__,
            "kind": self.kind.name,
            "problem": self.problem.model_dump(),
            "options": {k: v if isinstance(v, plain) else repr(v) for k, v in self.options.items()},
            "tie": dict(self.tie),
        }


def model_of(
    problem: Problem,
    outputs: Sequence[str] | None,
    tie: Mapping[str, str] | None,
    options: Mapping[str, Any],
) -> KindModel:
    """Return the model of a study; options that are None are omitted.

    Raises
    ------
    InvalidProblem
        If it is not a problem, and as of :meth:`KindModel.checked`.

    Examples
    --------
    >>> import woundon as wo
    >>> model = model_of(wo.RollerProblem.example(), ["half_width"], None, {"nodes": 33})
    >>> round(model.run({"load": 50e3}, None).values[0] * 1e6)
    265
    """
    check_arguments(outputs=outputs, tie=tie, options=options)
    if outputs is None:
        outputs = kind_of(problem).result.MAIN
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    settings = {name: value for name, value in options.items() if value is not None}
    return KindModel(problem, names, settings, dict(tie or {})).checked()


def solver_options(
    nodes: object, rtol: object, options: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Return the options of the solver that are not None.

    >>> solver_options(65, None, {"progress": None})
    {'nodes': 65, 'progress': None}
    """
    check_arguments(options=options)
    further = dict(options or {})
    explicit = {
        name: value for name, value in (("nodes", nodes), ("rtol", rtol)) if value is not None
    }
    for name in explicit.keys() & further.keys():
        raise InvalidProblem.at(name, "is given twice, also among the options")
    return explicit | further


def kind_of(problem: Any) -> kinds.Kind:
    """Return the kind of a problem; reject results, classes and other objects.

    >>> import woundon as wo
    >>> kind_of(wo.RollerProblem.example()).name
    'rollers'
    """
    kind = kinds.of(problem)
    check_type("problem", problem, kind.problem)
    return kind


def options_of(problem: Problem) -> dict[str, Any]:
    """Return the options of the solver of a problem with their defaults.

    >>> import woundon as wo
    >>> "nodes" in options_of(wo.RollerProblem.example())
    True
    """
    excluded = {"start", "progress", *type(problem).model_fields}
    keywords = keywords_of(kind_of(problem).solver)
    return {name: default for name, default in keywords.items() if name not in excluded}


def _reason_without_effect(problem: Problem, name: str, value: float) -> str:
    """Return why a field with a value has no effect, ", as ..."; empty if that is not known."""
    texts: tuple[str, ...] = ()
    with suppress(InvalidProblem), unwarned():
        texts = problem.replace(**{name: value}).input_warnings
    reasons = [t.split("is not used")[1] for t in texts if t.startswith(f"{name} is not used")]
    return reasons[0] if reasons else ""


# ---- outputs by name ----------------------------------------------------------------------------


def _no_output(problem: Problem, name: str) -> str:
    """Return the reason for an unknown output, with an existing one or a suggestion."""
    replacements = kinds.of(problem).result.REPLACED
    if name in replacements:
        return f"no such output: {replacements[name]}"
    known = scalar_outputs(kinds.of(problem).result)
    symbols = {quantity.symbol.lower(): output for output, quantity in known.items()}
    if name.lower() in symbols:
        return f"not a scalar output; did you mean {symbols[name.lower()]!r}?"
    return f"not a scalar output{did_you_mean(name, known)}"


def _value(result: Result, name: str) -> Any:
    """Return an output or its error estimate; nan if there is none."""
    if name.startswith(_ERROR):
        return result.errors.get(name.removeprefix(_ERROR), np.nan)
    return value_of(result, name)

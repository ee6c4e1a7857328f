"""Models of studies: problems of any kind with outputs, solver options and tied fields.

Problem, solver and result class are looked up in :mod:`woundon.kinds`, fields and outputs in
:mod:`woundon.quantities`; all kinds of problem are treated alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from inspect import signature
from typing import Any

import numpy as np

from .. import __version__, kinds
from ..arguments import check_type
from ..errors import InvalidProblem, NotConverged, did_you_mean, unwarned
from ..io.cells import Conversion
from ..parallel import progress
from ..problems.inputs import Inputs
from ..problems.paths import counterpart, field_quantity, get_field, is_part_of
from ..problems.problem import Problem
from ..quantities import Quantity, scalar_outputs, value_of, walk
from .model import Answer

__all__ = [
    "KindModel",
    "columns_of",
    "conversion_of",
    "kind_of",
    "measurable_outputs",
    "model_of",
    "options_of",
]

_ERROR = "errors."  # of an output: "errors.half_width"


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
        ties: Mapping[Any, Any] = self.tie
        for follower, leader in ties.items():
            if not isinstance(follower, str) or not isinstance(leader, str):
                text = f"{leader!r} is not the name of a field; write FIELD = 'FIELD'"
                raise InvalidProblem.at(f"tie.{follower}", text)
        self.variant({})
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
        unknown = [name for name in self.outputs if str(name).removeprefix(_ERROR) not in known]
        if unknown:
            raise InvalidProblem((str(name), _no_output(self.problem, name)) for name in unknown)

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
                if is_part_of(name, follower):
                    text = f"cannot be varied, because {follower} is tied to {leader}"
                    raise InvalidProblem.at(name, text)
            if not any(name != other and is_part_of(name, other) for other in varied):
                get_field(self.problem, name)

    # ---- one case -------------------------------------------------------------------------------

    def variant(self, inputs: Mapping[str, Any]) -> Any:
        """Return the problem of one case."""
        return self.with_ties(self.problem.replace(**inputs))

    def with_ties(self, problem: Problem) -> Problem:
        """Return a problem whose tied fields have the values of the fields that they follow."""
        if not self.tie:
            return problem
        return problem.replace(
            **{follower: get_field(problem, leader) for follower, leader in self.tie.items()}
        )

    def solve(self, problem: Any, start: Any | None) -> Any:
        """Solve a problem; if a warm start does not converge, solve without it.

        In a worker process the solver is cancelled at its next report of progress, if requested.
        """
        kind, options = self.kind, dict(self.options)
        known = _keywords(kind.solver)
        if "progress" in known:
            options["progress"] = progress
        if isinstance(start, kind.result) and "start" in known:
            with suppress(NotConverged):
                return kind.solver(problem, start=start, **options)
        return kind.solver(problem, **options)

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        """Solve one case."""
        with unwarned():  # warnings are a column of the table
            result = self.solve(self.variant(inputs), start)
            values = tuple(float(_value(result, name)) for name in self.outputs)
        return Answer(values, "; ".join(result.warnings), result)

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
    problem: Any,
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
    if outputs is None:
        outputs = kind_of(problem).result.MAIN
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    settings = {name: value for name, value in options.items() if value is not None}
    return KindModel(problem, names, settings, dict(tie or {})).checked()


def kind_of(problem: Any) -> kinds.Kind:
    """Return the kind of a problem; reject results, classes and other objects.

    >>> import woundon as wo
    >>> kind_of(wo.RollerProblem.example()).name
    'rollers'
    """
    kind = kinds.of(problem)
    check_type("problem", problem, kind.problem)
    return kind


@cache
def _keywords(solver: Callable[..., Any]) -> Mapping[str, Any]:
    """Return the keyword arguments of a solver with their defaults."""
    parameters = signature(solver).parameters.values()
    return {p.name: p.default for p in parameters if p.kind is p.KEYWORD_ONLY}


def options_of(problem: Problem) -> dict[str, Any]:
    """Return the options of the solver of a problem with their defaults.

    >>> import woundon as wo
    >>> "nodes" in options_of(wo.RollerProblem.example())
    True
    """
    excluded = {"start", "progress", *type(problem).model_fields}
    keywords = _keywords(kind_of(problem).solver)
    return {name: default for name, default in keywords.items() if name not in excluded}


# ---- fields and outputs by name -----------------------------------------------------------------


def measurable_outputs(problem: Problem) -> dict[str, Quantity]:
    """Return the outputs that a column of measured data may contain.

    A quantity that is set in the problem, such as the tangential load of rollers, is an input.
    """
    known = scalar_outputs(kind_of(problem).result)
    fields = type(problem).model_fields
    return {
        name: quantity
        for name, quantity in known.items()
        if name not in fields or getattr(problem, name) is None
    }


def columns_of(problem: Problem) -> dict[str, Quantity | None]:
    """Return the quantities that a column of inputs may contain; None if it is not a number.

    Names are dotted, with ``*`` for the number of an item of a list.  Fields of other bodies and
    materials are included, and these themselves.  A schedule is a number if the problem has a
    number for it.
    """
    known: dict[str, Quantity | None] = {}
    for place in walk(type(problem)):
        *heads, leaf = place.path.split(".")
        # a number of one material may be a description of another
        for k in range(1, len(heads) + 1):
            head = ".".join(heads[:k])
            if head not in known:
                known[head] = _if_number(problem, head)
        known[place.path] = known.get(place.path) or place.quantity
        # "diameter" alone is the position of a measurement on a roll
        if heads and (diameter := counterpart(leaf, "radius")):
            path = ".".join((*heads, diameter))
            known[path] = field_quantity(problem, path)
    return known


def conversion_of(problem: Problem, complete: bool = False) -> Conversion:
    """Return the conversion of the columns of a table: with the values of a problem, or without.

    Parameters
    ----------
    problem : Problem
    complete : bool
        Whether the columns describe the complete problem, so that its values do not matter.
    """
    helpers = {
        f"{place.path.removesuffix(place.name)}{name}": quantity
        for place in walk(type(problem))
        for name, quantity in getattr(place.owner, "input_only", {}).items()
    }
    inputs = Inputs(type(problem), {}) if complete else Inputs.of(problem)
    return Conversion(inputs, helpers)


def _if_number(problem: Problem, path: str) -> Quantity | None:
    """Return the quantity of a field whose value is a number; otherwise None."""
    try:
        is_number = isinstance(get_field(problem, path), float)
    except InvalidProblem:  # of another body or material
        return None
    return field_quantity(problem, path) if is_number else None


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


def _value(result: Any, name: str) -> Any:
    """Return an output or its error estimate; nan if there is none."""
    if name.startswith(_ERROR):
        return result.errors.get(name.removeprefix(_ERROR), np.nan)
    return value_of(result, name)

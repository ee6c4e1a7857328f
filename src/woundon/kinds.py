"""The kinds of problem: the class, solver and result of each, registered in one place.

    kinds.register(MyProblem, my_solver, MyResult)

adds a kind.  ``wo.solve``, case files, result files, studies, reports and the command line look it
up here.

>>> import woundon as wo
>>> kind = wo.kinds.named("roll")
>>> kind.problem.__name__, kind.result.__name__, list(kind.solver_options())
('RollProblem', 'RollResult', ['rtol', 'lanes'])
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import (
    Annotated,
    Any,
    Generic,
    Literal,
    NamedTuple,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

from . import plugins
from .arguments import Option, keywords_of
from .errors import InputWarning, InvalidProblem, did_you_mean, one_of, warn
from .nip.result import NipResult
from .nip.roller_result import RollerResult
from .nip.solve import check_options as check_nip_options
from .nip.solve import solve_nip
from .nip.solve_rollers import check_options as check_roller_options
from .nip.solve_rollers import solve_rollers
from .problems.family import best_match, snake_case
from .problems.messages import quote
from .problems.nip import NipProblem
from .problems.problem import Problem
from .problems.roll import RollProblem
from .problems.rollers import RollerProblem
from .problems.winding import WindingProblem
from .quantities import on_request
from .results import Result
from .roll.result import RollResult
from .roll.solve import check_options as check_roll_options
from .roll.solve import solve_wound_roll
from .winding.margins import margins
from .winding.result import WindingResult
from .winding.solve import check_options as check_winding_options
from .winding.solve import solve_winding

__all__ = ["Kind", "SolverOption", "every", "for_fields", "named", "of", "register", "solve"]

ProblemT = TypeVar("ProblemT", bound=Problem)
ResultT = TypeVar("ResultT", bound=Result)
Progress = Callable[[float], None]


class SolverOption(NamedTuple):
    """An option of a solver that can be given as text: its type, choices and description."""

    type: type[int] | type[float] | type[str]
    choices: tuple[str, ...] = ()
    help: str = ""
    details: str = ""


@dataclass(frozen=True, eq=False)
class Kind(Generic[ProblemT, ResultT]):
    """A kind of problem; see :func:`register`.

    Attributes
    ----------
    name, about : str
        Name in files and commands, and a sentence for the help of the command line.
    problem : type
        Class of the problems.
    solver : callable
        (problem, **options) -> result.
    result : type
        Class of the results.
    check : callable or None
        (**options): rejects options before anything is solved.
    report, plot : callable or None
        (result) -> parts of a report, and panels of a figure by name, of a plug-in's kind.
    margins : callable or None
        (result, limits) -> margins of a wound roll.
    """

    name: str
    about: str
    problem: type[ProblemT]
    solver: Callable[..., ResultT]
    result: type[ResultT]
    check: Callable[..., Any] | None = None
    report: Callable[..., Any] | None = None
    plot: Callable[..., Any] | None = None
    margins: Callable[..., Any] | None = None

    def example(self) -> ProblemT:
        """Return an example problem.

        Raises
        ------
        InvalidProblem
            If the kind has none.
        """
        try:
            return self.problem.example()
        except NotImplementedError:
            raise InvalidProblem.at("kind", f"{self.name!r} has no example") from None

    def solver_options(self) -> dict[str, SolverOption]:
        """Return the options of the solver by name.

        These are its keyword-only arguments of type int, float, str or Literal that are not fields
        of the problem.  The others (functions, warm starts) are for Python only.
        """
        hints = get_type_hints(self.solver, include_extras=True)
        names = [n for n in keywords_of(self.solver) if n not in self.problem.model_fields]
        options = {name: _option_of(hints.get(name)) for name in names}
        return {name: option for name, option in options.items() if option is not None}


def _option_of(hint: Any) -> SolverOption | None:
    """Return the option that a type hint describes; None for a hint of another type."""
    description = Option("")  # its fields are the last two of a SolverOption: help, details
    if get_origin(hint) is Annotated:
        hint, *metadata = get_args(hint)
        description = next((part for part in metadata if isinstance(part, Option)), description)
    for part in (hint, *get_args(hint)):  # the members of a union, such as int | None, too
        if part in (int, float, str):
            return SolverOption(part, (), *description)
        if get_origin(part) is Literal:
            return SolverOption(str, get_args(part), *description)
    return None


_KINDS: dict[str, Kind[Any, Any]] = {
    kind.name: kind
    for kind in (
        Kind(
            "nip",
            "A winding nip: stick and slip, nip-induced and wound-on tension.",
            NipProblem,
            solve_nip,
            NipResult,
            check_nip_options,
        ),
        Kind(
            "rollers",
            "Two rollers in contact without a web, rolling or static.",
            RollerProblem,
            solve_rollers,
            RollerResult,
            check_roller_options,
        ),
        Kind(
            "roll",
            "The stresses in a wound roll of given wound-on tension.",
            RollProblem,
            solve_wound_roll,
            RollResult,
            check_roll_options,
            margins=margins,
        ),
        Kind(
            "winding",
            "A complete winding: nip and roll coupled over the radius, stresses and margins.",
            WindingProblem,
            solve_winding,
            WindingResult,
            check_winding_options,
            margins=margins,
        ),
    )
}


def register(
    problem: type[ProblemT],
    solver: Callable[..., ResultT],
    result: type[ResultT],
    *,
    name: str | None = None,
    about: str | None = None,
    report: Callable[..., Any] | None = None,
    plot: Callable[..., Any] | None = None,
    check: Callable[..., Any] | None = None,
    margins: Callable[..., Any] | None = None,
) -> None:
    """Register a kind of problem.

    Parameters
    ----------
    problem : class
        A :class:`~woundon.problems.problem.Problem`.
    solver : callable
        ``(problem, **options) -> result``.  Its keyword-only arguments of type int, float, str or
        Literal become options of ``woundon solve``; ``Annotated[int, Option("Number of terms.")]``
        gives one a help text.
    result : class
        A :class:`~woundon.results.Result`.
    name : str
        By default the class of the problem in snake case without "Problem": ``capstan`` of
        ``CapstanProblem``.
    about : str
        A sentence for the help of the command line; by default the name of the class.
    report, plot : callable
        (result) -> parts of a report, and panels of a figure by name; by default all outputs and
        all arrays.
    check : callable
        Checks options before anything is solved: ``(**options)``.
    margins : callable
        (result, limits) -> :class:`~woundon.Margins` of a wound roll, which
        :func:`woundon.optimise_schedule` keeps.
    """
    title = problem.__name__
    name = name or snake_case(title.removesuffix("Problem"))
    _KINDS[name] = Kind(name, about or title, problem, solver, result, check, report, plot, margins)


def every() -> tuple[Kind[Any, Any], ...]:
    """Return all kinds, those of woundon first, with the outputs that plug-ins add."""
    for kind, name, output in plugins.take_outputs():
        if isinstance(output, on_request):  # Python names it in the body of a class only
            output.__set_name__(_KINDS[kind].result, name)
        setattr(_KINDS[kind].result, name, output)
    return tuple(_KINDS.values())


def named(name: str) -> Kind[Any, Any]:
    """Return a kind by its name, with hyphens or underscores.

    >>> named("nip").problem.__name__, list(named("nip").solver_options())
    ('NipProblem', ['nodes', 'rtol'])

    Raises
    ------
    InvalidProblem
        For an unknown name.
    """
    known = {kind.name: kind for kind in every()}
    with_underscores = str(name).replace("-", "_")
    if with_underscores not in known:
        text = f"{quote(name)} is not a kind of problem{did_you_mean(with_underscores, known)}"
        raise InvalidProblem.at("kind", text)
    return known[with_underscores]


def of(thing: object) -> Kind[Any, Any]:
    """Return the kind of a problem or of a result.

    >>> of(NipProblem.example()).name
    'nip'

    Raises
    ------
    InvalidProblem
        For anything else.
    """
    cls = thing if isinstance(thing, type) else type(thing)
    for kind in every():
        if cls is kind.problem or cls is kind.result:
            return kind
    names = one_of(kind.problem.__name__ for kind in every())
    raise InvalidProblem.at("problem", f"{quote(thing)} is out of place; must be a {names}")


def for_fields(names: Iterable[str]) -> Kind[Any, Any]:
    """Return the kind whose problem matches names of fields, or of a file's tables, best.

    >>> for_fields(["upper", "lower", "load"]).name
    'rollers'
    """
    kinds = every()
    problem = best_match(names, [kind.problem for kind in kinds])
    return next(kind for kind in kinds if kind.problem is problem)


@overload
def solve(
    problem: NipProblem,
    *,
    nodes: int | None = None,
    rtol: float | None = None,
    start: NipResult | None = None,
    errors: bool = ...,
    progress: Progress | None = None,
) -> NipResult: ...
@overload
def solve(
    problem: RollerProblem,
    *,
    nodes: int | None = None,
    rtol: float | None = None,
    start: RollerResult | None = None,
    errors: bool = ...,
    progress: Progress | None = None,
) -> RollerResult: ...
@overload
def solve(
    problem: RollProblem, *, rtol: float = ..., lanes: int = ..., progress: Progress | None = None
) -> RollResult: ...
@overload
def solve(
    problem: WindingProblem,
    *,
    rtol: float = ...,
    nodes: int = ...,
    coupling_rtol: float | None = None,
    lanes: int = ...,
    start: WindingResult | None = None,
    progress: Progress | None = None,
) -> WindingResult: ...
@overload
def solve(problem: Problem, **options: Any) -> Any: ...
def solve(problem: Any, **options: Any) -> Any:
    """Solve a problem of any kind.

    ==================================  =================================================
    :class:`~woundon.NipProblem`        one rolling nip: the wound-on tension
    :class:`~woundon.RollerProblem`     two rollers in contact without a web
    :class:`~woundon.RollProblem`       stresses in a roll of given wound-on tension
    :class:`~woundon.WindingProblem`    a winding: nip and roll coupled over the radius
    ==================================  =================================================

    and the kinds of plug-ins (:func:`woundon.kinds.register`).

    >>> import woundon as wo
    >>> result = wo.solve(wo.NipProblem.example(), nodes=33)
    >>> bool(result.wound_on_tension > result.problem.web_tension)
    True

    Parameters
    ----------
    problem : Problem
        Of any kind.
    options
        Of the solver of the kind.  Nips and rollers: ``nodes`` of the last mesh, or ``rtol``, the
        relative error; ``start``, the result of a neighbouring problem; ``errors=False`` with
        both ``nodes`` and ``start``, without error estimates and twice as fast; ``progress``,
        called with the fraction of the work that is done.

    Returns
    -------
    Result
        Of the kind: :class:`~woundon.NipResult`, :class:`~woundon.RollerResult`,
        :class:`~woundon.RollResult`, :class:`~woundon.WindingResult`, ...

    Raises
    ------
    InvalidProblem
        If the argument is not a problem, or an option is out of range.
    NoSteadyState
        If no steady rolling carries the loads.
    NotConverged
        If the solver did not reach the tolerance; carries the best result.

    Warns
    -----
    InputWarning
        If an input has no effect or contradicts another one.
    """
    kind, progress = of(problem), options.get("progress")
    if progress is not None and not callable(progress):
        text = f"{quote(progress)} is out of place; must be a function of the fraction that is done"
        raise InvalidProblem.at("progress", text)
    if not isinstance(problem, type):  # the solver rejects a class
        warn(getattr(problem, "input_warnings", ()), InputWarning)
    return kind.solver(problem, **options)

"""The kinds of problem: for each its class, its solver and its result, registered in one place.

    kinds.register(MyProblem, my_solver, MyResult)

is all that a new kind needs.  ``wo.solve``, case files, result files, studies, reports and the
command line look it up here.  The kinds of this package import their classes when they are used.

Plug-ins are found by the entry-point group ``woundon.plugins``: a module named there is imported
once, before the first look-up, in worker processes too.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from .errors import InputWarning, InvalidProblem, did_you_mean, one_of, warn

if TYPE_CHECKING:
    from .nip.result import NipResult
    from .nip.roller_result import RollerResult
    from .problems.nip import NipProblem
    from .problems.problem import Problem
    from .problems.roll import RollProblem
    from .problems.rollers import RollerProblem
    from .problems.winding import WindingProblem
    from .roll.result import RollResult
    from .winding.result import WindingResult

__all__ = [
    "Kind", "Option", "entry_points", "every", "for_fields", "load_plugins", "named", "of",
    "register", "solve",
]  # fmt: skip

PLUGINS = "woundon.plugins"
_TYPES: dict[str, type] = {"int": int, "float": float, "str": str}


class Option(NamedTuple):
    """Help text of an option of a solver, the words that it admits, and its type."""

    about: str
    words: tuple[str, ...] = ()
    type: type = str


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of problem; see :func:`register`.

    Attributes
    ----------
    name, about : str
    problem_class, solver_function, result_class, check_function : callables
        Without arguments; they import and return the class of the problems, the solver
        (problem, **options) -> result, the class of the results, and the function (**options) that
        checks options before anything is solved, or None.
    options : mapping
        Help texts and choices of the solver's options by name.
    report, plot : callable or None
        (result) -> parts of a report, and panels of a figure by name, of a plug-in's kind.
    """

    name: str
    about: str
    problem_class: Callable[[], type[Any]]
    solver_function: Callable[[], Callable[..., Any]]
    result_class: Callable[[], type[Any]]
    check_function: Callable[[], Callable[..., Any] | None] = lambda: None
    options: Mapping[str, Option] = field(default_factory=dict)
    report: Callable[..., Any] | None = None
    plot: Callable[..., Any] | None = None

    @property
    def problem(self) -> type[Any]:
        """The class of its problems."""
        return self.problem_class()

    @property
    def solver(self) -> Callable[..., Any]:
        """The solver: (problem, **options) -> result."""
        return self.solver_function()

    @property
    def result(self) -> type[Any]:
        """The class of its results."""
        return self.result_class()

    @property
    def check(self) -> Callable[..., Any] | None:
        """Checks options before anything is solved: (**options); None if there is no check."""
        return self.check_function()

    def example(self) -> Any:
        """Return an example problem.

        Raises
        ------
        InvalidProblem
            If the kind has none.
        """
        try:
            return self.problem.example()
        except NotImplementedError:
            text = f"{self.name!r} has no example to start from"
            raise InvalidProblem.at("kind", text) from None

    def solver_options(self) -> dict[str, Option]:
        """Return the options of the solver by name, with their types.

        These are its keyword-only arguments of type int, float or str that are not fields of the
        problem; the others (functions, warm starts) are for Python only.
        """
        found = {}
        fields = self.problem.model_fields
        for name, argument in inspect.signature(self.solver).parameters.items():
            hint = argument.annotation
            words = re.findall(r"\w+", hint if isinstance(hint, str) else repr(hint))
            types = [_TYPES[word] for word in words if word in _TYPES and "Callable" not in words]
            if types and argument.kind is argument.KEYWORD_ONLY and name not in fields:
                found[name] = self.options.get(name, Option(""))._replace(type=types[0])
        return found

    @property
    def command(self) -> str:
        """The name on the command line: ``woundon new NAME``."""
        return self.name.replace("_", "-")


# ---- the kinds of this package ------------------------------------------------------------------


def _nip_problem() -> type[Any]:
    from .problems.nip import NipProblem

    return NipProblem


def _solve_nip() -> Callable[..., Any]:
    from .nip.solve import solve_nip

    return solve_nip


def _nip_result() -> type[Any]:
    from .nip.result import NipResult

    return NipResult


def _check_nip() -> Callable[..., Any]:
    from .nip.solve import check_options

    return check_options


def _roller_problem() -> type[Any]:
    from .problems.rollers import RollerProblem

    return RollerProblem


def _solve_rollers() -> Callable[..., Any]:
    from .nip.solve_rollers import solve_rollers

    return solve_rollers


def _roller_result() -> type[Any]:
    from .nip.roller_result import RollerResult

    return RollerResult


def _check_rollers() -> Callable[..., Any]:
    from .nip.solve_rollers import check_options

    return check_options


def _roll_problem() -> type[Any]:
    from .problems.roll import RollProblem

    return RollProblem


def _solve_roll() -> Callable[..., Any]:
    from .roll.solve import solve_wound_roll

    return solve_wound_roll


def _roll_result() -> type[Any]:
    from .roll.result import RollResult

    return RollResult


def _check_roll() -> Callable[..., Any]:
    from .roll.solve import check_options

    return check_options


def _winding_problem() -> type[Any]:
    from .problems.winding import WindingProblem

    return WindingProblem


def _solve_winding() -> Callable[..., Any]:
    from .winding.solve import solve_winding

    return solve_winding


def _winding_result() -> type[Any]:
    from .winding.result import WindingResult

    return WindingResult


def _check_winding() -> Callable[..., Any]:
    from .winding.solve import check_options

    return check_options


_KINDS = {
    kind.name: kind for kind in (
        Kind(
            "nip", "The winding nip: stick and slip, nip-induced and wound-on tension.",
            _nip_problem, _solve_nip, _nip_result, _check_nip,
            {
                "nodes": Option(
                    "Nodes of the nip on the last mesh, 13 to 1025. By default as many as it takes "
                    "until the estimated error of the wound-on tension is below 0.1 % of it, and "
                    "that of the nip-induced tension below 2 %."
                ),
                "rtol": Option(
                    "Relative error of the wound-on tension in place of 0.1 %; 1e-5 to 0.1. The "
                    "nip-induced tension may have 20 times this error."
                ),
            },
        ),
        Kind(
            "rollers", "Two rollers in contact without a web, rolling or static.",
            _roller_problem, _solve_rollers, _roller_result, _check_rollers,
            {
                "nodes": Option("Nodes of the contact on the last mesh, 7 to 2049."),
                "rtol": Option(
                    "Relative error of half width, largest pressure, and creepage or tangential "
                    "load, in place of 0.1 %; 1e-5 to 0.1."
                ),
            },
        ),
        Kind(
            "roll", "The stresses in a roll of given wound-on tension.",
            _roll_problem, _solve_roll, _roll_result, _check_roll,
            {
                "rtol": Option(
                    "Accepted error of the pressure, relative to the largest; 1e-8 to 0.1."
                ),
            },
        ),
        Kind(
            "winding", "A winding: nips and roll coupled over the radius, stresses and margins.",
            _winding_problem, _solve_winding, _winding_result, _check_winding,
            {
                "rtol": Option(
                    "Accepted error of the interpolation between the nips, relative to the "
                    "wound-on tension, and of the pressure in the roll; 1e-6 to 0.1."
                ),
                "nodes": Option(
                    "Nodes of every nip, 25 to 1025; with fewer there is no error estimate."
                ),
                "agreed": Option(
                    "Accepted difference of the wound-on tensions of nips and roll, relative, 1e-8 "
                    "to 1e-2; by default 1e-6, and 1e-5 with a direct roll."
                ),
            },
        ),
    )
}  # fmt: skip


def register(
    problem: type[Any],
    solver: Callable[..., Any],
    result: type[Any],
    *,
    name: str | None = None,
    about: str | None = None,
    report: Callable[..., Any] | None = None,
    plot: Callable[..., Any] | None = None,
    check: Callable[..., Any] | None = None,
    options: Mapping[str, Option] | None = None,
) -> None:
    """Register a kind of problem.

    Parameters
    ----------
    problem : class
        A :class:`~woundon.problems.problem.Problem`.
    solver : callable
        ``(problem, **options) -> result``.
    result : class
        A :class:`~woundon.results.Result`.
    name : str
        By default the class of the problem in snake case without "Problem": ``capstan`` of
        ``CapstanProblem``.
    about : str
        One line for the command line's help; by default the first line of the class's docstring.
    report, plot : callable
        (result) -> parts of a report, and panels of a figure by name; by default all outputs and
        all arrays.
    check : callable
        Checks options before anything is solved: ``(**options)``.
    options : mapping
        Help texts and choices of the solver's options by name; by default those of the solver's
        docstring, which Python does not have under ``-OO``.
    """
    title = problem.__name__
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", title.removesuffix("Problem")).lower()
    name = name or snake
    text = about or (getattr(problem, "__doc__", "") or title).strip().partition("\n")[0]
    _KINDS[name] = Kind(
        name, text, lambda: problem, lambda: solver, lambda: result, lambda: check, options or {},
        report, plot,
    )  # fmt: skip


@cache
def _installed() -> Any:
    # looks through every package that is installed: once is enough
    return metadata.entry_points()


def entry_points(**wanted: str) -> Iterable[metadata.EntryPoint]:
    """Return the entry points of a ``group``, or of a ``name`` in it, that are installed."""
    found: Iterable[metadata.EntryPoint] = _installed().select(**wanted)
    return found


@cache
def load_plugins() -> None:
    """Import what the entry-point group ``woundon.plugins`` names; once."""
    for found in entry_points(group=PLUGINS):
        found.load()


def every() -> tuple[Kind, ...]:
    """Return all kinds, woundon's own first."""
    load_plugins()
    return tuple(_KINDS.values())


def named(name: str) -> Kind:
    """Return a kind by its name.

    Raises
    ------
    InvalidProblem
        For an unknown name.
    """
    load_plugins()
    if name not in _KINDS:
        text = f"{name!r} is not a kind of problem{did_you_mean(name, _KINDS)}"
        raise InvalidProblem.at("kind", text)
    return _KINDS[name]


def of(thing: Any) -> Kind:
    """Return the kind of a problem or of a result.

    Raises
    ------
    InvalidProblem
        For anything else.
    """
    cls = thing if isinstance(thing, type) else type(thing)
    for kind in every():
        if cls is kind.problem or cls is kind.result:
            return kind
    from .problems.messages import quote

    names = one_of(kind.problem.__name__ for kind in every())
    raise InvalidProblem.at("problem", f"{quote(thing)} is out of place; must be a {names}")


def for_fields(names: Iterable[str]) -> Kind:
    """Return the kind whose problem has the fields, or a file's tables, of these names."""
    from .problems.family import best_match

    kinds = every()
    chosen = best_match(names, [kind.problem for kind in kinds])
    return next(kind for kind in kinds if kind.problem is chosen)


@overload
def solve(problem: NipProblem, **options: Any) -> NipResult: ...
@overload
def solve(problem: RollerProblem, **options: Any) -> RollerResult: ...
@overload
def solve(problem: RollProblem, **options: Any) -> RollResult: ...
@overload
def solve(problem: WindingProblem, **options: Any) -> WindingResult: ...
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

    and whatever :func:`woundon.kinds.register` made known.

    Parameters
    ----------
    problem : Problem
        Of any kind.
    options
        Of the kind's solver.  Nips and rollers: ``nodes`` of the last mesh, or ``rtol``, the
        relative error; ``start``, the result of a neighbouring problem; ``progress``, called with
        the fraction of the work that is done.

    Returns
    -------
    Result
        Of the kind: :class:`~woundon.NipResult`, :class:`~woundon.RollerResult`,
        :class:`~woundon.RollResult`, :class:`~woundon.WindingResult`, ...

    Raises
    ------
    InvalidProblem
        For what is no problem, or options out of range.
    NoSteadyState
        If no steady rolling carries the loads.
    NotConverged
        If it was not solved to tolerance; carries the best result.

    Warns
    -----
    InputWarning
        If an input has no effect or contradicts another one.
    """
    kind = of(problem)
    if not isinstance(problem, type):  # a class is rejected by the solver
        warn(getattr(problem, "remarks", ()), InputWarning)
    return kind.solver(problem, **options)

"""The kinds of problem: for each its class, its solver and its result, registered in one place.

    kinds.register(MyProblem, my_solver, MyResult)

is all that a new kind needs.  ``wo.solve``, case files, result files, studies and the command line
look it up here.  What is heavy or comes later on the data's way (solvers, plots, reports) is named
by text, "package.module:name", and fetched when first used: nobody imports it in a circle.

Plug-ins are found by the entry-point group ``woundon.plugins``: a module named there is imported
once, before the first look-up, in worker processes too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from .errors import InputWarning, InvalidProblem, did_you_mean, one_of, warn

if TYPE_CHECKING:
    from .nip.result import NipResult
    from .nip.roller_result import RollerResult
    from .problems.fields import Problem
    from .problems.nip import NipProblem
    from .problems.roll import RollProblem
    from .problems.rollers import RollerProblem
    from .problems.winding import WindingProblem
    from .roll.result import RollResult
    from .winding.result import WindingResult

__all__ = [
    "Kind", "Option", "entry_points", "every", "fetch", "for_fields", "load_plugins", "named", "of",
    "register", "solve",
]  # fmt: skip

PLUGINS = "woundon.plugins"


def fetch(name: str) -> Any:
    """Return what "package.module:name" names."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)


class Option(NamedTuple):
    """Help text of an option of a solver, and the words that it admits."""

    about: str
    words: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of problem; see :func:`register`."""

    name: str
    about: str
    _problem: Any
    _solver: Any
    _result: Any
    _report: Any
    _plot: Any
    _check: Any
    options: Mapping[str, Option] = field(default_factory=dict)

    @cached_property
    def problem(self) -> type[Any]:
        """The class of its problems."""
        return _got(self._problem)

    @cached_property
    def solver(self) -> Callable[..., Any]:
        """What solves them: (problem, **options) -> result."""
        return _got(self._solver)

    @cached_property
    def result(self) -> type[Any]:
        """The class of its results."""
        return _got(self._result)

    @cached_property
    def report(self) -> Callable[..., Any]:
        """What tells a result in tables: (result) -> parts of a report."""
        return _got(self._report)

    @cached_property
    def plot(self) -> Callable[..., Any]:
        """What draws a result: (result) -> panels of a figure, by name."""
        return _got(self._plot)

    @cached_property
    def check(self) -> Callable[..., Any] | None:
        """What refuses options before anything is solved: (**options); None without."""
        return None if self._check is None else _got(self._check)

    def example(self) -> Any:
        """Return a problem to start from.

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

    @property
    def command(self) -> str:
        """The kind's own command: ``woundon roll CASE``."""
        return self.name.replace("_", "-")


def _got(named: Any) -> Any:
    return fetch(named) if isinstance(named, str) else named


_KINDS: dict[str, Kind] = {}


def register(
    problem: type[Any] | str,
    solver: Callable[..., Any] | str,
    result: type[Any] | str,
    *,
    name: str | None = None,
    about: str | None = None,
    report: Callable[..., Any] | str = "woundon.show.report:outputs_report",
    plot: Callable[..., Any] | str = "woundon.show.plots:output_panels",
    check: Callable[..., Any] | str | None = None,
    options: Mapping[str, Option] | None = None,
) -> None:
    """Register a kind of problem.

    Parameters
    ----------
    problem, solver, result : class, callable, class
        Themselves, or their names, "package.module:name".  The problem's class is a
        :class:`~woundon.problems.fields.Problem`, the result's a
        :class:`~woundon.results.Result`; ``solver(problem, **options)`` returns one.
    name : str
        By default the snake-case of the problem's class less "Problem": ``wound_roll`` of
        ``RollProblem``.
    about : str
        One line for the command line's help; by default the first of the class's text.
    report, plot : callable or name
        What tells and draws a result: its parts of a report, its panels by name; by default all
        outputs, all arrays.
    check : callable or name
        What refuses options of the solver before anything is solved.
    options : mapping
        Help texts and choices of the solver's options by name; by default those of the docstring
        of the solver, which Python does not have under ``-OO``.
    """
    title = problem.rpartition(":")[2] if isinstance(problem, str) else problem.__name__
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", title.removesuffix("Problem")).lower()
    name = name or snake
    text = about or (getattr(problem, "__doc__", "") or title).strip().partition("\n")[0]
    _KINDS[name] = Kind(name, text, problem, solver, result, report, plot, check, options or {})


NIP_OPTIONS = {
    "nodes": Option(
        "Nodes of the nip on the last mesh, 13 to 1025. By default as many as it takes until the "
        "estimated error of the wound-on tension is below 0.1 % of it, and that of the "
        "nip-induced tension below 2 %."
    ),
    "rtol": Option(
        "Relative error of the wound-on tension in place of 0.1 %; 1e-5 to 0.1. The "
        "nip-induced tension may have 20 times this error."
    ),
}


register(
    "woundon.problems.nip:NipProblem",
    "woundon.nip.solve:solve_nip",
    "woundon.nip.result:NipResult",
    about="The winding nip: stick and slip, nip-induced and wound-on tension.",
    report="woundon.show.report:nip_report",
    plot="woundon.show.nip_plots:nip_panels",
    check="woundon.nip.solve:check_options",
    options=NIP_OPTIONS,
)
register(
    "woundon.problems.rollers:RollerProblem",
    "woundon.nip.solve_rollers:solve_rollers",
    "woundon.nip.roller_result:RollerResult",
    name="rollers",
    about="Two rollers in contact without a web, rolling or static.",
    report="woundon.show.report:roller_report",
    plot="woundon.show.roller_plots:roller_panels",
    check="woundon.nip.solve_rollers:check_options",
    options={
        "nodes": Option("Nodes of the contact on the last mesh, 7 to 2049."),
        "rtol": Option(
            "Relative error of half width, largest pressure, and creepage or tangential load, in "
            "place of 0.1 %; 1e-5 to 0.1."
        ),
    },
)


register(
    "woundon.problems.roll:RollProblem",
    "woundon.roll.solve:solve_wound_roll",
    "woundon.roll.result:RollResult",
    about="The stresses that winding leaves in a roll.",
    report="woundon.show.wound_roll_report:wound_roll_report",
    plot="woundon.show.wound_roll_plots:wound_roll_panels",
    check="woundon.roll.solve:check_options",
    options={
        "rtol": Option(
            "Accepted error of the pressure, relative to the largest; 1e-8 to 0.1.",
        ),
    },
)
register(
    "woundon.problems.winding:WindingProblem",
    "woundon.winding.solve:solve_winding",
    "woundon.winding.result:WindingResult",
    about="The winding of a roll: what its nips add as it grows, and the stresses that stay.",
    report="woundon.show.winding_report:winding_report",
    plot="woundon.show.winding_plots:winding_panels",
    check="woundon.winding.solve:check_options",
    options={
        "rtol": Option(
            "Accepted error of the interpolation between the nips, relative to the wound-on "
            "tension, and of the roll's pressure; 1e-6 to 0.1.",
        ),
        "nodes": Option(
            "Of every nip, 25 to 1025: on fewer none tells its error.",
        ),
        "agreed": Option(
            "To what of the wound-on tension nips and roll are to agree, 1e-8 to 1e-2; by "
            "default 1e-6, and 1e-5 with a direct roll.",
        ),
    },
)


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
        # a class not yet imported has no instances
        for name in (kind._problem, kind._result):
            if name is cls or (
                isinstance(name, str) and name == f"{cls.__module__}:{cls.__name__}"
            ):
                return kind
    from .problems.fields import shown

    names = one_of(kind.problem.__name__ for kind in every())
    raise InvalidProblem.at("problem", f"{shown(thing)} is out of place; must be a {names}")


def for_fields(names: Iterable[str]) -> Kind:
    """Return the kind whose problem has the fields, or a file's tables, of these names."""
    from .problems.fields import best_match

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
    :class:`~woundon.RollProblem`  stresses in a roll of given wound-on tension
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

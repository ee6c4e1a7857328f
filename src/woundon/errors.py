"""Exceptions and warnings; messages name field, value and permitted range."""

from __future__ import annotations

import difflib
import re
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Self, TypeVar

__all__ = [
    "InputWarning",
    "InvalidProblem",
    "NoSolution",
    "NoSteadyState",
    "NotConverged",
    "ResolutionWarning",
    "ValidityWarning",
    "mapping_of",
    "unwarned",
    "warn",
]

Value = TypeVar("Value")

RESOLUTION = "resolution: "  # prefix of a warning about the grid

# Bounds of messages, which quote inputs: numbers of lines, and characters per line and word.
MOST_LINES = 50
LONGEST_LINE = 1000
LONGEST_WORD = 200  # longer than names, values and most paths


class InvalidProblem(ValueError):
    """Invalid input: the message names field, value and permitted range.

    Attributes
    ----------
    faults : tuple of (field, text)
        One entry per fault, ``field`` as a dotted path (``roll.material.shear``).  The message has
        a line for each of the first 50.

    Examples
    --------
    >>> import woundon as wo
    >>> try:
    ...     wo.Rigid(radius=-1)
    ... except wo.InvalidProblem as error:
    ...     print(error)
    radius: -1 is out of range; must be > 0.0001 and <= 50 [m]
    """

    def __init__(self, faults: str | Iterable[tuple[str, str]]) -> None:
        self.faults: tuple[tuple[str, str], ...] = (
            (("", faults),) if isinstance(faults, str) else tuple(faults)
        )
        lines = [
            printable_line(f"{field}: {text}" if field else text)
            for field, text in self.faults[:MOST_LINES]
        ]
        beyond = len(self.faults) - len(lines)
        super().__init__("\n".join([*lines, f"and {beyond} more"] if beyond else lines))

    def __reduce__(self) -> Any:  # a pickle of an exception would have its message only
        return type(self), (self.faults,)

    @classmethod
    def at(cls, field: str, text: str) -> Self:
        """Return the error of a single field."""
        return cls([(field, text)])

    def under(self, prefix: str) -> Self:
        """Return the same faults with ``prefix`` before every field; in place of an empty one."""
        return type(self)(
            (".".join(part for part in (prefix, f) if part), t) for f, t in self.faults
        )


def printable_line(line: str) -> str:
    """Return an error text as one line of bounded length that any terminal can display.

    Long words are quoted inputs; they are shortened, so that the rest of the text stays readable.
    """
    long_word = rf"\S{{{LONGEST_WORD + 1},}}"
    line = re.sub(long_word, lambda word: _shortened(word[0], LONGEST_WORD), line)
    line = _shortened(line, LONGEST_LINE)
    if not line.isprintable():  # the escapes are longer than the characters
        line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)
    return _shortened(line, LONGEST_LINE)


def _shortened(text: str, longest: int) -> str:
    """Return a text without its middle if it is longer than ``longest``."""
    half = longest // 2
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def mapping_of(pairs: Iterable[tuple[str, Value]], where: str = "") -> dict[str, Value]:
    """Return pairs of a name and a value as a mapping; reject a name that is given twice.

    Parameters
    ----------
    pairs : iterable of (str, value)
    where : str
        Stands before the name in the error, such as the option of a command.

    Raises
    ------
    InvalidProblem
        Names both values.

    Examples
    --------
    >>> mapping_of([("load", 1.0), ("friction", 0.3)])
    {'load': 1.0, 'friction': 0.3}
    """
    mapping: dict[str, Value] = {}
    for name, value in pairs:
        if name in mapping:
            text = f"is given twice, {mapping[name]!r} and {value!r}; must be given once"
            raise InvalidProblem.at(f"{where} {name}".strip(), text)
        mapping[name] = value
    return mapping


class NoSteadyState(InvalidProblem):
    """No steady state exists for the loads: the drum or the rollers slip.

    >>> import woundon as wo
    >>> try:
    ...     wo.NipProblem.example().replace(winding_force=5000.0)
    ... except wo.NoSteadyState as error:
    ...     print(error.faults[0][0])
    winding_force
    """


class NoSolution(InvalidProblem):
    """No value of a field gives the target: it lies outside the range that the output reaches.

    Attributes
    ----------
    reachable : (low, high) or None
        Smallest and largest output on the scan, SI units; None if no point was solved.
    values, outputs : tuple of float
        The points of the scan: values of the field, and outputs; nan where no solution exists.
    failures : tuple of (value, reason)
        The points that were not solved.

    Examples
    --------
    >>> import woundon as wo
    >>> error = wo.NoSolution("no value gives the target", reachable=(10.0, 20.0))
    >>> print(error, error.reachable)
    no value gives the target (10.0, 20.0)
    """

    def __init__(
        self,
        faults: str | Iterable[tuple[str, str]],
        reachable: tuple[float, float] | None = None,
        values: Iterable[float] = (),
        outputs: Iterable[float] = (),
        failures: Iterable[tuple[float, str]] = (),
    ) -> None:
        super().__init__(faults)
        self.reachable = reachable
        self.values, self.outputs = tuple(values), tuple(outputs)
        self.failures = tuple(failures)

    def __reduce__(self) -> Any:
        scan = (self.reachable, self.values, self.outputs, self.failures)
        return type(self), (self.faults, *scan)


class NotConverged(RuntimeError):
    """The solver did not converge; ``best`` is the best iterate.

    >>> import woundon as wo
    >>> wo.NotConverged("no convergence", best=1.0).best
    1.0
    """

    def __init__(self, text: str, best: Any = None) -> None:
        super().__init__(text)
        self.best = best


class ValidityWarning(UserWarning):
    """A solved case is outside the validity range of the linear, small-strain, plane model.

    >>> import warnings
    >>> import woundon as wo
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", wo.ValidityWarning)
    ...     result = wo.solve(wo.RollProblem.example())
    """


class InputWarning(UserWarning):
    """An input has no effect, or contradicts another one.

    >>> import warnings
    >>> import woundon as wo
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", wo.InputWarning)
    ...     result = wo.solve(wo.RollProblem.example())
    """


class ResolutionWarning(UserWarning):
    """The mesh is too coarse for a detail of the solution; increase the number of nodes.

    >>> import warnings
    >>> import woundon as wo
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", wo.ResolutionWarning)
    ...     result = wo.solve(wo.RollProblem.example())
    """


def warn(texts: Iterable[str], kind: type[Warning] | None = None) -> None:
    """Issue warnings at the line outside this package that called it.

    Parameters
    ----------
    texts : iterable of str
    kind : type, optional
        Category; by default ValidityWarning, or ResolutionWarning by the prefix of the text.
    """
    if not (texts := tuple(texts)):
        return
    # functools calls the methods of cached properties
    inner = (__name__.partition(".")[0], "functools")
    frame, level = sys._getframe(), 1
    while frame.f_back and str(frame.f_globals.get("__name__")).partition(".")[0] in inner:
        frame, level = frame.f_back, level + 1
    for text in texts:
        category = kind or (ResolutionWarning if text.startswith(RESOLUTION) else ValidityWarning)
        warnings.warn(text.removeprefix(RESOLUTION), category, stacklevel=level)


@contextmanager
def unwarned() -> Iterator[None]:
    """Suppress the warnings of results, which are reported in another way."""
    with warnings.catch_warnings():
        for category in (InputWarning, ValidityWarning, ResolutionWarning):
            warnings.simplefilter("ignore", category)
        yield


def nearest(word: object, known: Iterable[str]) -> str:
    """Return the known name most similar to a misspelt ``word``, ignoring case.

    It is empty if none is similar, or if ``word`` is not a text.
    """
    if not isinstance(word, str):
        return ""
    by_lower = {name.lower(): name for name in sorted(known)}
    near = difflib.get_close_matches(word.lower(), by_lower, n=1, cutoff=0.55)
    return by_lower[near[0]] if near else ""


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return ``'; did you mean ...?'`` for a misspelt ``word``, or the list of known names."""
    known = sorted(known)
    near = nearest(word, known)
    return f"; did you mean {near!r}?" if near else f"; known: {', '.join(known)}"


def one_of(words: Iterable[str], last: str = "or") -> str:
    """Return 'a, b or c', with the word ``last`` before the last one; a single word as it is."""
    *heads, tail = words
    return f"{', '.join(heads)} {last} {tail}" if heads else tail

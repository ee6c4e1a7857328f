"""What can go wrong, as types; every text names the field, the value and what is admissible."""

from __future__ import annotations

import difflib
import re
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Self

__all__ = [
    "InputWarning",
    "InvalidProblem",
    "NoSolution",
    "NoSteadyState",
    "NotConverged",
    "ResolutionWarning",
    "ValidityWarning",
    "unwarned",
    "warn",
]

RESOLUTION = "resolution: "  # how a warning on the grid begins

MOST_LINES = 50
LONGEST_LINE = 1000
LONGEST_WORD = 200  # names and values are shorter, and most paths


class InvalidProblem(ValueError):
    """The description of a problem is not admissible.

    Attributes
    ----------
    faults : tuple of (field, text)
        One entry a fault, ``field`` as a dotted path (``roll.material.shear``).

    Its text has a line for each of the first 50.
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
        super().__init__("\n".join([*lines, *[f"and {beyond} more"] * (beyond > 0)]))

    def __reduce__(self) -> Any:
        return type(self), (self.faults,)

    @classmethod
    def at(cls, field: str, text: str) -> Self:
        """Return the error of a single field."""
        return cls([(field, text)])

    def under(self, prefix: str) -> Self:
        """Return the same faults with ``prefix`` before every field."""
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


class NoSteadyState(InvalidProblem):
    """The loads are admissible one by one, but no steady rolling carries them (the drum slides)."""


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
    """A solution was not brought to tolerance; ``best`` carries the best state that was reached."""

    def __init__(self, text: str, best: Any = None) -> None:
        super().__init__(text)
        self.best = best


class ValidityWarning(UserWarning):
    """A solved case lies where the linear, small-strain, plane model no longer holds."""


class InputWarning(UserWarning):
    """An input has no effect, or contradicts another one."""


class ResolutionWarning(UserWarning):
    """The grid is too coarse for something that a solved case shows; more nodes mend it."""


def warn(texts: Iterable[str], kind: type[Warning] | None = None) -> None:
    """Issue warnings at the line outside this package that asked for a result.

    Parameters
    ----------
    texts : iterable of str
    kind : type, optional
        By default that of a result's warning: of validity, or of resolution.
    """
    if not (texts := tuple(texts)):
        return
    own, frame, level = __name__.partition(".")[0], sys._getframe(), 1
    while frame.f_back and str(frame.f_globals.get("__name__")).partition(".")[0] == own:
        frame, level = frame.f_back, level + 1
    for text in texts:
        category = kind or (ResolutionWarning if text.startswith(RESOLUTION) else ValidityWarning)
        warnings.warn(text.removeprefix(RESOLUTION), category, stacklevel=level)


@contextmanager
def unwarned() -> Iterator[None]:
    """Issue no warnings of results: they are told in another way, or are another result's."""
    with warnings.catch_warnings():
        for category in (InputWarning, ValidityWarning, ResolutionWarning):
            warnings.simplefilter("ignore", category)
        yield


def nearest(word: Any, known: Iterable[str]) -> str:
    """Return the known name that a misspelt ``word`` is most like, '' if it is like none."""
    by_lower = {name.lower(): name for name in sorted(known)}
    near = difflib.get_close_matches(str(word).lower(), by_lower, n=1, cutoff=0.55)
    return by_lower[near[0]] if near else ""


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return ``'; did you mean ...?'`` for a misspelt ``word``, or the list of known names."""
    known = sorted(known)
    near = nearest(word, known)
    return f"; did you mean {near!r}?" if near else f"; known: {', '.join(known)}"


def one_of(words: Iterable[str], last: str = "or") -> str:
    """Return 'a, b or c'."""
    *heads, tail = words
    return f"{', '.join(heads)} {last} {tail}" if heads else tail

"""Verdicts on a figure or table in words; if one fails, with the verdict of the other solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .catalogue import made_by
from .exhibits import Exhibit
from .verdicts import Outcome, Verdict

__all__ = ["SOLVERS", "Judged", "judged"]

SOLVERS = {"accurate": "the accurate solver", "thesis": "the thesis's procedure"}


@dataclass(frozen=True, eq=False)
class Judged:
    """An exhibit, and its verdicts by the other solver if a statement does not hold.

    Attributes
    ----------
    exhibit : Exhibit
    solver : {"accurate", "thesis"}
        By which it was computed.
    others : sequence of Verdict
        One for each of the exhibit's, or none.
    """

    exhibit: Exhibit
    solver: str
    others: Sequence[Verdict] = ()

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of statements that hold, fail and cannot be tested."""
        return tuple(self.exhibit.count(outcome) for outcome in Outcome)

    @property
    def tally(self) -> str:
        """Sentence with the counts."""
        words = [
            f"{n} {outcome.value if n == 1 else _PLURAL[outcome]}"
            for n, outcome in zip(self.counts, Outcome, strict=True)
            if n
        ]
        return f"{len(self.exhibit.verdicts)} statements: {', '.join(words)}"

    @property
    def failures(self) -> list[str]:
        """Sentences about the statements that do not hold."""
        said = zip(self.exhibit.verdicts, self.lines(), strict=True)
        return [line for verdict, line in said if verdict.outcome is Outcome.FAILS]

    def lines(self, *, strong: str = "") -> list[str]:
        """Return a sentence for each statement, outcome and number between marks if given."""
        others: Sequence[Verdict | None] = self.others or (None,) * len(self.exhibit.verdicts)
        pairs = zip(self.exhibit.verdicts, others, strict=True)
        return [self._line(mine, other, strong) for mine, other in pairs]

    def _line(self, verdict: Verdict, other: Verdict | None, strong: str) -> str:
        """Return the sentence on a statement, with its number and outcome."""
        # capitals make a failure visible in a long list
        word = verdict.outcome.value
        word = word.upper() if verdict.outcome is Outcome.FAILS else word
        text = f"{strong}{word}{strong}: {verdict.statement}"
        if verdict.outcome is not Outcome.UNTESTED:
            text += f": {strong}{verdict.measured}{strong}, asked {verdict.expected}"
        if other is not None and _may_depend_on_solver(verdict):
            name = SOLVERS["thesis" if self.solver == "accurate" else "accurate"]
            text += f"; with {name} {other.measured}, {other.outcome.value}"
        note = _sentence(verdict.note)
        return f"{text}. {note}" if note else f"{text}."

    def report(self) -> str:
        """Return all verdicts as text for a terminal."""
        exhibit = self.exhibit
        lines = [f"{exhibit.label}: {exhibit.title}", self._how(), ""]
        if exhibit.text:
            lines += [exhibit.text, ""]
        return "\n".join([*lines, *(f"- {line}" for line in self.lines())]) + "\n"

    def markdown(self, picture: str = "") -> str:
        """Return the same as Markdown, with the picture at this path if there is one."""
        exhibit = self.exhibit
        lines = [f"# {exhibit.label}: {exhibit.title}", "", self._how(), ""]
        if picture:
            lines += [f"![{exhibit.label}]({picture})", ""]
        if exhibit.text:
            lines += ["```text", exhibit.text, "```", ""]
        said = (f"- {line}" for line in self.lines(strong="**"))
        return "\n".join([*lines, *said]) + "\n"

    def _how(self) -> str:
        """Return a sentence with the solver, if it makes a difference, and the counts."""
        if self.exhibit.one_solver:
            return f"{self.tally}."
        name = SOLVERS[self.solver]
        return f"{name[0].upper()}{name[1:]}. {self.tally}."


_PLURAL = {
    Outcome.HOLDS: "hold",
    Outcome.FAILS: "do not hold",
    Outcome.UNTESTED: "cannot be tested",
}
_SYMBOLS = ("x", "v", "p", "q")


def _sentence(note: str) -> str:
    """Return a note as a sentence."""
    text = note.strip()
    if not text:
        return ""
    # words take a capital, symbols such as s_r2 do not
    first = text.split()[0].strip(",.;:")
    start = text[0].upper() if first.isalpha() and first not in _SYMBOLS else text[0]
    return start + text[1:] + ("" if text[-1] in ".?!" else ".")


def _may_depend_on_solver(verdict: Verdict) -> bool:
    """Return True for a failed statement, unless both solvers compute its number accurately."""
    return verdict.outcome is Outcome.FAILS and not verdict.accurate


def judged(module: str, names: Sequence[str], solver: str) -> list[Judged]:
    """Compute the exhibits of a module that are asked for, by both solvers where one fails.

    A failed statement is not computed by the other solver if the solver makes no difference:
    exhibits of measured data or closed forms, and numbers that both solvers compute accurately.

    Parameters
    ----------
    module : str
        From :func:`~woundon.jorkama2001.catalogue.modules`.
    names : sequence of str
        Exhibits asked for; the module may make more.
    solver : {"accurate", "thesis"}
    """
    exhibits = [exhibit for exhibit in made_by(module, solver) if exhibit.name in names]
    to_compare = {
        exhibit.name
        for exhibit in exhibits
        if not exhibit.one_solver and any(map(_may_depend_on_solver, exhibit.verdicts))
    }
    other_verdicts = {}
    if to_compare:
        other = "thesis" if solver == "accurate" else "accurate"
        other_verdicts = {e.name: e.verdicts for e in made_by(module, other)}
    return [
        Judged(e, solver, other_verdicts[e.name] if e.name in to_compare else ()) for e in exhibits
    ]

"""A figure with its verdicts in words, and where one fails, what the other scheme says to it."""

from __future__ import annotations

from dataclasses import dataclass

from .frame import Figure, Outcome, Scheme, Verdict
from .registry import figures

__all__ = ["SCHEME_NAMES", "Judged", "judged"]

SCHEME_NAMES: dict[Scheme, str] = {
    "graded": "the accurate scheme",
    "thesis": "the thesis's scheme",
}


@dataclass(frozen=True, eq=False)
class Judged:
    """A figure, and its verdicts by the other scheme if a statement does not hold.

    Attributes
    ----------
    figure : Figure
    others : tuple of Verdict
        One for each of the figure's, or none.
    """

    figure: Figure
    others: tuple[Verdict, ...] = ()

    @property
    def tally(self) -> str:
        """How many statements hold, do not, and cannot be tested."""
        figure = self.figure
        counts = [(figure.count(outcome), outcome) for outcome in Outcome]
        words = [
            f"{n} {outcome.value if n == 1 else _PLURAL[outcome]}" for n, outcome in counts if n
        ]
        return f"{len(figure.verdicts)} statements: {', '.join(words)}"

    def lines(self, *, strong: str = "") -> list[str]:
        """Return a sentence for each statement, outcome and number between marks if given."""
        others: tuple[Verdict | None, ...] = self.others or (None,) * len(self.figure.verdicts)
        pairs = zip(self.figure.verdicts, others, strict=True)
        return [self._line(mine, other, strong) for mine, other in pairs]

    def _line(self, verdict: Verdict, other: Verdict | None, strong: str) -> str:
        # failures are to meet the eye of who runs down the list
        word = verdict.outcome.value
        word = word.upper() if verdict.outcome is Outcome.FAILS else word
        text = f"{strong}{word}{strong}: {verdict.statement}"
        if verdict.outcome is not Outcome.UNTESTED:
            text += f": {strong}{verdict.measured}{strong}, asked {verdict.expected}"
        if other is not None and verdict.outcome is Outcome.FAILS:
            name = SCHEME_NAMES["thesis" if self.figure.scheme == "graded" else "graded"]
            text += f"; with {name} {other.measured}, {other.outcome.value}"
        return f"{text}. {_sentence(verdict.note)}".strip()

    def report(self) -> str:
        """Return all that is to be said, as text for a terminal."""
        figure = self.figure
        lines = [f"{figure.label}: {figure.title}", self._how(), ""]
        if figure.text:
            lines += [figure.text, ""]
        return "\n".join([*lines, *(f"- {line}" for line in self.lines())]) + "\n"

    def markdown(self, picture: str = "") -> str:
        """Return the same as Markdown, with the picture at this path if there is one."""
        figure = self.figure
        lines = [f"# {figure.label}: {figure.title}", "", self._how(), ""]
        if picture:
            lines += [f"![{figure.label}]({picture})", ""]
        if figure.text:
            lines += ["```text", figure.text, "```", ""]
        said = (f"- {line}" for line in self.lines(strong="**"))
        return "\n".join([*lines, *said]) + "\n"

    def _how(self) -> str:
        if self.figure.one_scheme:
            return f"{self.tally}."
        name = SCHEME_NAMES[self.figure.scheme]
        return f"{name[0].upper()}{name[1:]}. {self.tally}."


_PLURAL = {
    Outcome.HOLDS: "hold",
    Outcome.FAILS: "do not hold",
    Outcome.UNTESTED: "cannot be tested",
}
_SYMBOLS = ("x", "v", "p", "q")


def _sentence(note: str) -> str:
    text = note.strip()
    if not text:
        return ""
    # words take a capital, symbols such as s_r2 do not
    first = text.split()[0].strip(",.;:")
    start = text[0].upper() if first.isalpha() and first not in _SYMBOLS else text[0]
    return start + text[1:] + ("" if text[-1] in ".?!" else ".")


def judged(module: str, names: tuple[str, ...], scheme: Scheme) -> tuple[Judged, ...]:
    """Compute the figures of a module that are asked for, by both schemes where one fails.

    Parameters
    ----------
    module : str
        From :func:`~woundon.thesis.registry.modules`.
    names : tuple of str
        Figures asked for; the module may make more.
    scheme : {"graded", "thesis"}
    """
    mine = [figure for figure in figures(module, scheme) if figure.name in names]
    if not any(figure.count(Outcome.FAILS) and not figure.one_scheme for figure in mine):
        return tuple(Judged(figure) for figure in mine)
    other: Scheme = "thesis" if scheme == "graded" else "graded"
    others = {figure.name: figure.verdicts for figure in figures(module, other)}
    return tuple(
        Judged(figure, others[figure.name])
        if figure.count(Outcome.FAILS) and not figure.one_scheme
        else Judged(figure)
        for figure in mine
    )

"""The parts of a report on a terminal: columns, marks, colours."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from io import StringIO
from textwrap import wrap

from rich.console import Console
from rich.text import Text

from .report_parts import Line, Part, Row, Section, Verdicts, ZoneStrips, zone_line

__all__ = ["WIDTH", "plain_text", "print_columns", "print_parts"]

WIDTH = 100
ZONES_WIDTH = 60
MARKS = {-1: "◀", 0: "·", 1: "▶"}
ASCII_MARKS = {-1: "<", 0: ".", 1: ">"}
ZONE_STYLES = {-1: "yellow", 0: "dim", 1: "blue"}
TONES = {
    "quiet": "dim",
    "warning": "bold yellow",
    "answer": "bold",
    "good": "green",
    "bad": "bold red",
}


def plain_text(write: Callable[[Console], None]) -> str:
    """Return the text that a function writes on a console, in the width of the reports."""
    paper = StringIO()
    console = Console(
        file=paper,
        width=WIDTH,
        color_system=None,
        legacy_windows=False,
        force_jupyter=False,  # or the text would be shown in a notebook, and not be returned
    )
    write(console)
    return paper.getvalue().strip("\n")


def print_parts(parts: Iterable[Part], console: Console) -> None:
    """Print the parts of a report, in ASCII if the terminal has no other characters."""
    parts = list(parts)
    ascii_only = console.options.ascii_only
    marks, plus_minus = (ASCII_MARKS, "+-") if ascii_only else (MARKS, "±")
    # of all sections alike, that their columns stand below each other
    rows = [row for part in parts if isinstance(part, Section) for row in part.rows]
    cells = [("", "", "", ""), *(_cells(r, "") for r in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    previous: Part | None = None
    for part in parts:
        if previous is not None and not (isinstance(part, Line) and isinstance(previous, Line)):
            console.print()
        if isinstance(part, Section):
            _print(Text(part.title, style="bold"), console)
            print_columns([_cells(r, plus_minus) for r in part.rows], widths, "<<><", console)
            for line in wrap(part.text, WIDTH - 1):
                _print(Text(f" {line}", style="dim"), console)
        elif isinstance(part, ZoneStrips):
            _print_zones(part, marks, console)
        elif isinstance(part, Verdicts):
            _print_verdicts(part, console)
        else:
            _print(Text(part.text, style=TONES.get(part.tone, "")), console)
        previous = part


def _cells(row: Row, plus_minus: str) -> tuple[str, str, str, str]:
    error = f"  {plus_minus} {row.error_text}" if row.error_text else ""
    return row.meaning, row.symbol, row.value_text, f"{row.unit}{error}{row.note}"


def print_columns(
    table: Iterable[Sequence[str]], widths: Sequence[int], justify: str, console: Console
) -> None:
    """Print rows of cells in columns.

    Parameters
    ----------
    table : iterable of sequences of str
    widths : sequence of int
        At least, of each column.
    justify : str
        "<" or ">" for each column; every second one is dim.
    console : Console
    """
    for row in table:
        text = Text()
        for k, (cell, width) in enumerate(zip(row, widths, strict=True)):
            text.append("  " if k else " ")
            text.append(f"{cell:{justify[k]}{width}}", style="dim" if k % 2 else "")
        text.rstrip()
        _print(text, console)


def _print(text: Text, console: Console) -> None:
    # never folded nor cut: a pipe or a log gets the same text as a wide terminal
    console.print(text, soft_wrap=True)


def _print_zones(part: ZoneStrips, marks: dict[int, str], console: Console) -> None:
    """Print the zones of each face as a line of characters, and a legend."""
    _print(Text(part.TITLE, style="bold"), console)
    indent = max(len(face) for face in part.faces) + 3
    for face, zones in part.faces.items():
        text = Text(f" {face}".ljust(indent))
        for zone, length in zone_line(part.x, zones, ZONES_WIDTH):
            text.append(marks[zone] * length, style=ZONE_STYLES[zone])
        _print(text, console)
    legend = "   ".join(f"{marks[zone]} {word}" for zone, word in part.words.items())
    _print(Text(" " * indent + legend, style="dim"), console)


def _print_verdicts(part: Verdicts, console: Console) -> None:
    """Print a table of limits, with the limitations of each criterion below its row."""
    head = (part.title, *part.HEAD)
    table = [(row.meaning, row.value, row.limit, row.unit, row.place) for row in part.rows]
    widths = [max(map(len, column)) for column in zip(head[:5], *table, strict=True)]

    def line(cells: Iterable[str]) -> str:
        columns = zip("<>><<", cells, widths, strict=True)
        return "  ".join(f"{cell:{side}{width}}" for side, cell, width in columns)

    _print(Text(line(head[:5]).rstrip(), style="bold"), console)
    for row, cells in zip(part.rows, table, strict=True):
        text = Text(f" {line(cells)}  ")
        _print(text.append(row.word, style=TONES.get(row.tone, "")), console)
        for text_line in wrap(row.below, WIDTH - 5):
            _print(Text(f"     {text_line}", style="dim"), console)

"""The parts of a report on a terminal: columns, marks, colours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from io import StringIO
from textwrap import wrap

from rich.console import Console
from rich.text import Text

from .report_parts import COLUMNS, Column, Line, Part, Section, Table, ZoneStrips, zone_line

__all__ = ["WIDTH", "in_characters", "plain_text", "print_parts"]

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


def plain_text(parts: Iterable[Part]) -> str:
    """Return the parts of a report as text, in the width of the reports."""
    paper = StringIO()
    console = Console(
        file=paper,
        width=WIDTH,
        color_system=None,
        legacy_windows=False,
        force_jupyter=False,  # or the text would be shown in a notebook, and not be returned
    )
    print_parts(parts, console)
    return paper.getvalue().strip("\n")


def print_parts(parts: Iterable[Part], console: Console) -> None:
    """Print the parts of a report, in ASCII if the terminal has no other characters."""
    parts = list(parts)
    marks = ASCII_MARKS if console.options.ascii_only else MARKS
    # of all sections alike, so that their columns stand below each other
    rows = [row.cells for part in parts if isinstance(part, Section) for row in part.rows]
    widths = _widths([("", "", "", ""), *rows])  # the first one in case that there are no rows
    previous: Part | None = None
    for part in parts:
        if previous is not None and not (isinstance(part, Line) and isinstance(previous, Line)):
            console.print()
        if isinstance(part, Section):
            _print(Text(part.title, style="bold"), console)
            for row in part.rows:
                _print(_in_columns(row.cells, widths, COLUMNS), console)
            _print_below(part.text, 1, console)
        elif isinstance(part, Table):
            _print_table(part, console)
        elif isinstance(part, ZoneStrips):
            _print_zones(part, marks, console)
        else:
            _print(Text(part.text, style=TONES.get(part.tone, "")), console)
        previous = part


def _widths(table: Sequence[Sequence[str]]) -> list[int]:
    """Return the largest width of the cells of each column."""
    return [max(map(len, column)) for column in zip(*table, strict=True)]


def _in_columns(cells: Sequence[str], widths: Sequence[int], columns: Sequence[Column]) -> Text:
    """Return cells in columns of given widths, numbers on the right, symbols and units dim."""
    text = Text()
    for k, (cell, width, column) in enumerate(zip(cells, widths, columns, strict=True)):
        side = ">" if column.kind == "number" else "<"
        style = "dim" if column.kind in ("symbol", "unit") else ""
        text.append("  " if k else " ").append(f"{cell:{side}{width}}", style=style)
    text.rstrip()
    return text


def _print_table(table: Table, console: Console) -> None:
    """Print a table; its title stands above the first column if there is room for it."""
    heads = [column.head for column in table.columns]
    widths = _widths([heads, *(row.cells for row in table.rows)])
    head = _in_columns(heads, widths, table.columns).plain
    if heads[0] or len(table.title) > widths[0]:
        _print(Text(table.title, style="bold"), console)
        _print(Text(head, style="bold"), console)
    else:
        # over the spaces of the first column, whose head is empty
        _print(Text(table.title + head[len(table.title) :], style="bold"), console)
    for row in table.rows:
        text = _in_columns(row.cells, widths, table.columns)
        if row.tone:
            text.stylize(TONES[row.tone], len(text) - len(row.cells[-1]))  # the last cell
        _print(text, console)
        _print_below(row.below, 5, console)
    _print_below(table.text, 1, console)


def _print_below(text: str, indent: int, console: Console) -> None:
    """Print remarks below a table or a row."""
    for line in wrap(text, WIDTH - indent):
        _print(Text(" " * indent + line, style="dim"), console)


def in_characters(text: str, console: Console) -> str:
    """Return a text in characters that the terminal has."""
    return text.replace("±", "+-") if console.options.ascii_only else text


def _print(text: Text, console: Console) -> None:
    text.plain = in_characters(text.plain, console)
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

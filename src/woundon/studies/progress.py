"""A bar with rate and time left, on the error channel: results may go through a pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

__all__ = ["bar", "fraction_bar"]


class _Rate(ProgressColumn):
    """How fast it goes since the work was started or resumed."""

    def render(self, task: Task) -> Text:
        solved = task.completed - task.fields["begun_with"]
        elapsed = task.finished_time or task.elapsed or 0.0
        unit = task.fields["unit"]
        seconds = 60.0 if unit.endswith("/min") else 1.0
        rate = f"{seconds * solved / elapsed:.3g}" if elapsed > 0 and solved > 0 else "-"
        return Text(f"{rate} {unit}")


class _Channel(Console):
    """The error channel; a study goes on where nobody reads it any more."""

    def on_broken_pipe(self) -> None:
        self.quiet = True  # rich would end the program


@contextmanager
def bar(
    done: int, size: int, label: str = "solving", unit: str = "cases/s"
) -> Iterator[Callable[[int], None]]:
    """Provide a function to tell how many more are done.

    Parameters
    ----------
    done, size : int
        How many were done before, and are in all.
    label : str
        What is being done.
    unit : str
        Of the rate: ".../s" or ".../min".
    """
    with _progress() as progress:
        task = progress.add_task(label, total=size, completed=done, begun_with=done, unit=unit)
        yield lambda more: progress.advance(task, more)


@contextmanager
def fraction_bar(label: str = "solving") -> Iterator[Callable[[float], None]]:
    """Provide a function to report the fraction of the work that is done."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(),
               TimeElapsedColumn())  # fmt: skip
    with Progress(*columns, console=_Channel(stderr=True), transient=True) as progress:
        task = progress.add_task(label, total=1.0)
        yield lambda fraction: progress.update(task, completed=fraction)


def _progress() -> Progress:
    console = _Channel(stderr=True)
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _Rate(),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    return Progress(*columns, console=console)

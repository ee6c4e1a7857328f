"""Progress bars on the error channel, because results may go through a pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

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

INTERVAL = 10.0  # of the lines that replace a bar in a file or a pipe [s]


class _Rate(ProgressColumn):
    """Rate since the work was started or resumed.

    The task has the fields ``begun_with``, the cases finished before, and ``unit``, of the rate.
    """

    def render(self, task: Task) -> Text:
        """Return the mean rate since the start as text, such as "12 cases/s"."""
        solved = task.completed - task.fields["begun_with"]
        elapsed = task.finished_time or task.elapsed or 0.0
        unit = task.fields["unit"]
        seconds = 60.0 if unit.endswith("/min") else 1.0
        rate = f"{seconds * solved / elapsed:.3g}" if elapsed > 0 and solved > 0 else "-"
        return Text(f"{rate} {unit}")


class _Channel(Console):
    """The error channel; a study continues if its reader has closed the pipe."""

    def on_broken_pipe(self) -> None:
        self.quiet = True  # rich would end the program


@contextmanager
def bar(label: str, unit: str = "", done: int = 0) -> Iterator[Callable[[float, float], None]]:
    """Provide a function that shows the numbers of finished and expected cases on a bar.

    The numbers include the cases that were finished before.  A bar with a rate stays on the screen
    at the end; one with a percentage vanishes.  If the error channel is not a terminal, a line is
    printed every 10 s, and at the end the bar with a rate.

    Parameters
    ----------
    label : str
        Name of the work.
    unit : str, optional
        Of the rate: ".../s" or ".../min"; without it the bar shows a percentage.
    done : int
        Number of cases finished before, which do not count for the rate.
    """
    with_rate = (
        MofNCompleteColumn(),
        _Rate(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    columns = with_rate if unit else (TaskProgressColumn(), TimeElapsedColumn())
    console = _Channel(stderr=True)
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        *columns,
        console=console,
        transient=not unit,
    ) as progress:
        task = progress.add_task(label, total=None, completed=done, begun_with=done, unit=unit)
        began = last_line = monotonic()

        def report(completed: float, expected: float) -> None:
            """Update the bar, or print a line."""
            nonlocal last_line
            progress.update(task, completed=completed, total=expected)
            now = monotonic()
            if not console.is_terminal and not console.is_jupyter and now - last_line >= INTERVAL:
                last_line = now
                count = f"{completed:g} of {expected:g}" if unit else f"{completed / expected:.0%}"
                console.print(f"{label}: {count} after {now - began:.0f} s", highlight=False)

        yield report


@contextmanager
def fraction_bar() -> Iterator[Callable[[float], None]]:
    """Provide a function that shows a fraction on a progress bar."""
    with bar("solving") as report:
        yield lambda fraction: report(fraction, 1.0)

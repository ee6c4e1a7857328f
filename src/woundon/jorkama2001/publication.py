"""Figures and tables of the thesis written to files: PNG, SVG, CSV, and the verdict as Markdown."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from functools import partial
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import woundon as wo

from .catalogue import NAMES, chosen, modules
from .judgement import Judged, judged
from .verdicts import Outcome

__all__ = ["Published", "publish", "summary"]


class Published(NamedTuple):
    """A published figure or table.

    Attributes
    ----------
    judged : Judged
    files : list of Path
    seconds : float
        Spent on the module that made it, and perhaps others with it.
    """

    judged: Judged
    files: list[Path]
    seconds: float

    @property
    def name(self) -> str:
        """``fig16``, ``table3``."""
        return self.judged.exhibit.name


def publish(
    names: Sequence[str],
    folder: Path,
    solver: str = "accurate",
    *,
    jobs: int | None = None,
    dpi: int | None = None,
) -> Generator[Published]:
    """Compute figures and tables and write them, each as soon as it is done.

    Parameters
    ----------
    names : sequence of str
        ``fig16``, ``table3``, ...
    folder : Path
        Made if it is not there.
    solver : {"accurate", "thesis"}
    jobs : int, optional
        Number of processes; by default one for each processor.  One is this process.
    dpi : int, optional
        Of the PNG files.

    Raises
    ------
    InvalidProblem
        For an unknown name.
    """
    names = chosen(names)
    folder.mkdir(parents=True, exist_ok=True)
    work = partial(_publish_module, names=names, folder=folder, solver=solver, dpi=dpi)
    makers = modules(names)
    jobs = min(jobs or wo.parallel.usable_cores(), len(makers))
    if jobs == 1:  # another process would take as long to start as a figure takes
        yield from chain.from_iterable(map(work, makers))
        return
    with closing(wo.parallel.in_processes(work, makers, jobs)) as parts:
        for _, done in parts:
            yield from done


def _publish_module(
    module: str, *, names: Sequence[str], folder: Path, solver: str, dpi: int | None
) -> list[Published]:
    """Compute those figures and tables of a module that are asked for, and write their files."""
    begun = perf_counter()
    written = [(one, _write(one, folder, dpi)) for one in judged(module, names, solver)]
    seconds = perf_counter() - begun
    return [Published(one, files, seconds) for one, files in written]


def _write(one: Judged, folder: Path, dpi: int | None) -> list[Path]:
    """Write data, figure and verdicts of one exhibit; return the paths."""
    from ..report.figures import save_figure  # the parent process draws nothing

    exhibit = one.exhibit
    data, verdicts = (folder / f"{exhibit.name}.{ending}" for ending in ("csv", "md"))
    data.write_text(exhibit.csv(), encoding="utf-8")
    pictures = []
    if exhibit.panels:
        figure = exhibit.figure()
        pictures = [folder / f"{exhibit.name}.{ending}" for ending in ("png", "svg")]
        for path in pictures:
            save_figure(figure, path, dpi=dpi)
    verdicts.write_text(one.markdown(pictures[0].name if pictures else ""), encoding="utf-8")
    return [data, *pictures, verdicts]


def summary(done: Iterable[Published], folder: str = "") -> str:
    """Return a Markdown table of the published figures and the numbers of statements that hold.

    ``folder``, with a final slash, is the path of the pages relative to the table.
    """
    words = " | ".join(outcome.value for outcome in Outcome)
    lines = [f"| | shows | {words} |", "|---|---|---|---|---|"]
    for one in sorted(done, key=lambda one: NAMES.index(one.name)):
        exhibit, counts = one.judged.exhibit, " | ".join(map(str, one.judged.counts))
        lines.append(f"| [{exhibit.label}]({folder}{one.name}.md) | {exhibit.title} | {counts} |")
    return "\n".join(lines) + "\n"

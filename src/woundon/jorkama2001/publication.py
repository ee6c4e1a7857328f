"""Figures and tables of the thesis written to files: PNG, SVG, CSV, and the verdict as Markdown."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from importlib import resources
from itertools import chain
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import woundon as wo

from .catalogue import NAMES, chosen, modules
from .judgement import Judged, judged
from .verdicts import Outcome

__all__ = ["Published", "known_counts", "publish", "summary"]


class Published(NamedTuple):
    """Files and verdicts of a published figure or table.

    Attributes
    ----------
    judged : Judged
        Without data and drawing.
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
    work = partial(_write_module, names=names, folder=folder, solver=solver, dpi=dpi)
    makers = modules(names)
    jobs = min(jobs or wo.parallel.usable_cores(), len(makers))
    if jobs == 1:  # another process would take as long to start as a figure takes
        yield from chain.from_iterable(map(work, makers))
        return
    with closing(wo.parallel.in_processes(work, makers, jobs)) as parts:
        for _, done in parts:
            yield from done


def _write_module(
    module: str, *, names: Sequence[str], folder: Path, solver: str, dpi: int | None
) -> list[Published]:
    """Compute the figures of a module and write their files."""
    begun = perf_counter()
    made = judged(module, names, solver)
    files = [_write(one, folder, dpi) for one in made]
    seconds = perf_counter() - begun
    # drawings cannot be sent between processes, and data would import xarray in the other process
    judgements = [
        replace(one, exhibit=replace(one.exhibit, data=None, draw=None))  # type: ignore[arg-type]
        for one in made
    ]
    return [Published(one, paths, seconds) for one, paths in zip(judgements, files, strict=True)]


def _write(one: Judged, folder: Path, dpi: int | None) -> list[Path]:
    """Write figure, data and verdicts of one exhibit."""
    from .drawing import figure_bytes  # the parent process draws nothing

    exhibit = one.exhibit
    paths = [folder / f"{exhibit.name}.csv"]
    paths[0].write_text(exhibit.csv(), encoding="utf-8")
    picture = ""
    if exhibit.draw is not None:
        drawing = exhibit.draw()
        for ending in ("png", "svg"):
            paths.append(folder / f"{exhibit.name}.{ending}")
            paths[-1].write_bytes(figure_bytes(drawing, ending, dpi))
            # all files have the same layout
            drawing.set_layout_engine(None)
        picture = f"{exhibit.name}.png"
    paths.append(folder / f"{exhibit.name}.md")
    paths[-1].write_text(one.markdown(picture), encoding="utf-8")
    return paths


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


def known_counts() -> dict[str, tuple[int, ...]]:
    """Return the known numbers of statements that hold, fail and cannot be tested, by exhibit.

    By the accurate solver.  The exhibit states why a statement fails.
    """
    lines = (resources.files(__package__) / "known_counts.csv").read_text("utf-8").splitlines()
    rows = (line.split(",") for line in lines if not line.startswith("#"))
    return {name: tuple(map(int, counts)) for name, *counts in rows}

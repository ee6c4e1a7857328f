"""Figures and tables of the thesis written to files: PNG, SVG, CSV, and the verdict as Markdown."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

from .frame import Outcome, Scheme
from .judgement import Judged, judged
from .registry import chosen, modules

__all__ = ["Published", "publish"]


@dataclass(frozen=True)
class Published:
    """What has been written of a figure or table, to tell those who wait.

    Attributes
    ----------
    name, label, title : str
        ``fig16``, ``Fig. 16``, and what it shows.
    tally : str
        How many statements hold, do not, cannot be tested.
    report : str
        All verdicts as text.
    failures : tuple of str
        The statements that do not hold.
    counts : tuple of int
        Statements that hold, do not, cannot be tested.
    files : tuple of Path
    seconds : float
        Spent on the module that made it, and perhaps others with it.
    """

    name: str
    label: str
    title: str
    tally: str
    report: str
    failures: tuple[str, ...]
    counts: tuple[int, int, int]
    files: tuple[Path, ...]
    seconds: float


def publish(
    names: tuple[str, ...],
    folder: Path,
    scheme: Scheme = "graded",
    *,
    jobs: int | None = None,
    dpi: int | None = None,
) -> Iterator[Published]:
    """Compute figures and tables and write them, each as soon as it is done.

    Parameters
    ----------
    names : tuple of str
        ``fig16``, ``table3``, ...
    folder : Path
        Made if it is not there.
    scheme : {"graded", "thesis"}
    jobs : int, optional
        Number of processes; by default one for each processor.
    dpi : int, optional
        Of the PNG files.

    Raises
    ------
    InvalidProblem
        For an unknown name.
    """
    names = chosen(names)
    folder.mkdir(parents=True, exist_ok=True)
    work = partial(_write_module, names=names, folder=folder, scheme=scheme, dpi=dpi)
    todo = modules(names)
    jobs = min(jobs or os.cpu_count() or 1, len(todo))
    if jobs <= 1:
        for module in todo:
            yield from work(module)
        return
    # spawned workers load the program afresh: the same on every system
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for done in as_completed([pool.submit(work, module) for module in todo]):
            yield from done.result()


def _write_module(
    module: str, *, names: tuple[str, ...], folder: Path, scheme: Scheme, dpi: int | None
) -> tuple[Published, ...]:
    begun = perf_counter()
    made = judged(module, names, scheme)
    files = [_write(one, folder, dpi) for one in made]
    seconds = perf_counter() - begun
    return tuple(_published(one, paths, seconds) for one, paths in zip(made, files, strict=True))


def _write(one: Judged, folder: Path, dpi: int | None) -> tuple[Path, ...]:
    figure = one.figure
    paths = [folder / f"{figure.name}.csv"]
    paths[0].write_text(figure.table.csv(), encoding="utf-8")
    picture = ""
    if figure.draw is not None:
        from ..plots import save_figure

        drawing = figure.draw()
        for ending in ("png", "svg"):
            paths.append(folder / f"{figure.name}.{ending}")
            save_figure(drawing, paths[-1], dpi=dpi)
        picture = f"{figure.name}.png"
    paths.append(folder / f"{figure.name}.md")
    paths[-1].write_text(one.markdown(picture), encoding="utf-8")
    return tuple(paths)


def _published(one: Judged, files: tuple[Path, ...], seconds: float) -> Published:
    figure = one.figure
    return Published(
        name=figure.name,
        label=figure.label,
        title=figure.title,
        tally=one.tally,
        report=one.report(),
        failures=tuple(
            line
            for verdict, line in zip(figure.verdicts, one.lines(), strict=True)
            if verdict.outcome is Outcome.FAILS
        ),
        counts=(
            figure.count(Outcome.HOLDS),
            figure.count(Outcome.FAILS),
            figure.count(Outcome.UNTESTED),
        ),
        files=files,
        seconds=seconds,
    )

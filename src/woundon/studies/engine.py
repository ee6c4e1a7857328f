"""Runs a study: design -> chunks -> runner -> store and table."""

from __future__ import annotations

import warnings
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path

from ..errors import InvalidProblem
from .design import Design
from .evaluate import Chunk
from .model import Model, quantities_of
from .progress import Progress, progress_reporter
from .runners import Runner
from .store import Store, open_store
from .table import Table

__all__ = ["Progress", "run_study"]


def run_study(
    model: Model,
    design: Design,
    runner: Runner,
    *,
    out: str | Path | None = None,
    resume: bool = False,
    chunk: int | None = None,
    progress: bool | Progress = False,
) -> Table:
    """Solve every case of a design.

    Parameters
    ----------
    model : Model
    design : Design
    runner : Runner
    out : path, optional
        Folder of the file to which chunks are added as they are solved.
    resume : bool
        Continue the study in ``out``; the cases that it holds are not solved again.
    chunk : int, optional
        Cases in a chunk.
    progress : bool or callable
        Show rate and remaining time, or call with (cases done, all cases).

    Raises
    ------
    InvalidProblem
        For an unknown name, or a folder that contains another study.
    OSError
        If ``out`` cannot be written; chunks in the file remain valid.
    KeyboardInterrupt
        After Ctrl-C; finished chunks are in ``out``.

    Warns
    -----
    UserWarning
        If the file in ``out`` is damaged; the damaged chunks are solved again.

    Examples
    --------
    >>> import woundon as wo
    >>> from woundon.studies.api import study_of
    >>> from woundon.studies.runners import SerialRunner
    >>> model, design = study_of(
    ...     wo.RollerProblem.example(), {"load": [5e4, 1e5]}, ["half_width"], options={"nodes": 17}
    ... )
    >>> run_study(model, design, SerialRunner()).failed.size
    0
    """
    if resume and out is None:
        raise InvalidProblem.at("resume", "needs out, the folder of the study to resume")
    for name in set(design.names) & set(model.outputs):
        raise InvalidProblem.at(name, "is varied, so it cannot be an output")
    quantities = quantities_of(model, (*design.names, *model.outputs))
    record = model.record()
    table = Table.empty(design, model.outputs, quantities, record)
    cases = design.chunks(chunk)
    storing: AbstractContextManager[Store | None] = nullcontext()
    if out is not None:
        settings = {"chunk": chunk, **record}
        storing = open_store(out, design, cases, model.outputs, settings, resume=resume)
    with storing as store:
        if store is not None:
            for text in store.messages:
                warnings.warn(text, UserWarning, stacklevel=3)
            for block in store.kept.values():
                table.put(block)
        chunks = [
            Chunk(number, rows, design.inputs(rows))
            for number, rows in enumerate(cases)
            if store is None or number not in store.kept
        ]
        remaining = sum(len(c.cases) for c in chunks)
        done = design.size - remaining
        reporting = progress_reporter(progress, "solving", unit="cases/s", done=done)
        # closing ends the workers here, not when the garbage is collected
        with reporting as report, closing(runner.solved(model, chunks)) as blocks:
            for block in blocks:
                if store is not None:
                    store.write(block)
                table.put(block)
                done += len(block.cases)
                report(done, design.size)
    return table

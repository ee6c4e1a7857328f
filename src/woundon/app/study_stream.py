"""Studies of the page: chunks of cases go to the workers of studies, events come back as a stream.

    begun(tables) in a worker --> model and chunks --> solved_cases(...) in the workers --> events

Two users' studies take turns, chunk by chunk; one that is cancelled, or whose page is gone, leaves
its workers at once.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable, Mapping
from math import prod
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from ..io.case_files import check_like_a_case
from ..problems.messages import quote
from ..studies.api import study_of
from ..studies.evaluate import Chunk, solve_chunk
from ..studies.kind_model import KindModel
from ..studies.studyfile import SCHEMA, study_of_tables
from .computations import as_json
from .limits import LIMITS
from .request_errors import RequestError
from .worker_pool import Pool

__all__ = ["begun", "events", "solved_cases"]

CHUNK = 10  # cases in a row, each from the one before; then the page hears of them
RANK = 5  # behind the small things that a page asks for


# ---- in the workers ---------------------------------------------------------------------------


def begun(tables: Any) -> tuple[bytes, KindModel, list[Chunk]]:
    """Return the first event of a study, its model and its chunks.

    Raises
    ------
    InvalidProblem
    RequestError
        If there are more cases than a page's study may have.
    """
    if not isinstance(tables, Mapping):
        raise InvalidProblem(f"{quote(tables)} is out of place; must be the tables of a study file")
    check_like_a_case(tables)
    _check_size(tables)
    study = study_of_tables({"schema": SCHEMA, **tables}, None)
    if not study.over:
        raise InvalidProblem.at("over", "nothing is varied; give fields and their values")
    model, design = study_of(
        study.problem, study.over, study.outputs, tie=study.tie, options=study.options,
        **study.design,
    )  # fmt: skip
    chunks = [Chunk(number, rows, design.inputs(rows))
              for number, rows in enumerate(design.chunks(CHUNK))]  # fmt: skip
    labels = {c.name: c.labels.tolist() for c in design.columns}
    first = {
        "event": "started", "cases": design.size, "kind": model.kind.name,
        "dims": list(design.names) if design.gridded else ["case"],
        "inputs": labels, "outputs": list(model.outputs),
    }  # fmt: skip
    return _line(first), model, chunks


def _check_size(tables: Mapping[str, Any]) -> None:
    """Refuse a study of too many cases before any of them is made."""
    over, design = tables.get("over"), tables.get("design", {})
    drawn = design.get("samples") if isinstance(design, Mapping) else None
    entries = list(_entries(over)) if isinstance(over, Mapping) else []
    cases = drawn if isinstance(drawn, int) else prod(max(entry, 1) for entry in entries)
    if cases > LIMITS["sweep_cases"]:
        text = (f"{cases} cases are too many for the page, which solves {LIMITS['sweep_cases']} "
                "at most; 'woundon sweep' solves any number")  # fmt: skip
        raise RequestError(413, "too-large", text)


def _entries(over: Mapping[str, Any]) -> Any:
    """Yield the number of values of each field that is varied."""
    for given in over.values():
        if isinstance(given, list):
            yield len(given)
        elif isinstance(given, Mapping) and isinstance(given.get("count"), int):
            yield given["count"]
        elif isinstance(given, Mapping):
            yield from _entries(given)


def solved_cases(model: KindModel, chunk: Chunk) -> tuple[int, bytes]:
    """Return how many cases were solved, and the event that tells of them but for the count."""
    block = solve_chunk(model, chunk)
    values = dict(zip(model.outputs, block.values.T.tolist(), strict=True))
    told = {
        "event": "cases", "numbers": np.asarray(block.cases).tolist(), "values": values,
        "failures": block.failure.tolist(), "warnings": block.warnings.tolist(),
    }  # fmt: skip
    return len(block.cases), as_json(told)


def _line(event: Mapping[str, Any]) -> bytes:
    return as_json(event) + b"\n"


# ---- in the server ----------------------------------------------------------------------------


async def events(
    pool: Pool, study: tuple[bytes, KindModel, list[Chunk]], session: Hashable,
    gone: Callable[[], Awaitable[bool]], stopped: asyncio.Event,
) -> AsyncIterator[bytes]:  # fmt: skip
    """Yield the events of a study, a line of JSON each, as they come.

    Parameters
    ----------
    pool : Pool
    study
        As :func:`begun` returned it.
    session : hashable
    gone : callable
        Whether the page is.
    stopped : asyncio.Event
        Is set where the study is to end.
    """
    first, model, chunks = study
    began, done, size = time.monotonic(), 0, sum(len(c.cases) for c in chunks)
    yield first
    todo = iter(chunks)
    running: set[asyncio.Task[Any]] = set()
    try:
        while True:
            while len(running) < pool.size and (chunk := next(todo, None)) is not None:
                work = pool.run(solved_cases, model, chunk, rank=RANK, session=session)
                running.add(asyncio.create_task(work))
            if not running:
                yield _line({"event": "done", "seconds": time.monotonic() - began})
                return
            ready, running = await asyncio.wait(
                running, timeout=0.25, return_when=asyncio.FIRST_COMPLETED
            )
            for task in ready:
                cases, told = task.result()
                done += cases
                yield told[:-1] + f',"done":{done},"of":{size}}}\n'.encode()
            if stopped.is_set() or await gone():
                yield _line({"event": "cancelled"})
                return
            if time.monotonic() - began > LIMITS["study_seconds"]:
                text = f"the study took longer than {LIMITS['study_seconds']} s"
                raise RequestError(504, "too-slow", text)
    except RequestError as refusal:
        yield b'{"event":"failed","problem":' + refusal.body() + b"}\n"
    finally:
        for task in running:
            task.cancel()

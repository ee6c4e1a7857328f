"""Studies of the page: chunks of cases are solved in workers, events are sent as a stream.

    start_study(tables) in a worker -> model and chunks -> solve_cases(...) in workers -> events

Studies of two sessions take turns, chunk by chunk.  A study ends when it is cancelled or its client
disconnects.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable, Mapping
from math import prod
from typing import Any

from ..errors import InvalidProblem
from ..io.case_files import check_like_a_case
from ..problems.messages import quote
from ..studies.api import study_of
from ..studies.cases import Chunk, as_labels
from ..studies.model import KindModel
from ..studies.run import solve_chunk
from ..studies.study_file import SCHEMA, study_of_tables
from .json_texts import to_json
from .limits import LIMITS
from .request_errors import RequestError
from .worker_pool import Pool

__all__ = ["events", "solve_cases", "start_study"]

CHUNK = 10  # cases in a chunk, each started from the previous one; then the page is informed
RANK = 5  # after the shorter requests of a page


# ---- in the workers ---------------------------------------------------------------------------


def start_study(tables: Any) -> tuple[bytes, KindModel, list[Chunk]]:
    """Return the first event of a study, its model and its chunks.

    Raises
    ------
    InvalidProblem
    RequestError
        If there are more cases than a page's study may have.
    """
    if not isinstance(tables, Mapping):
        raise InvalidProblem(f"{quote(tables)} is not a table; must be the tables of a study file")
    check_like_a_case(tables)
    _check_size(tables)
    study = study_of_tables({"schema": SCHEMA, **tables}, None)
    if not study.over:
        raise InvalidProblem.at("over", "nothing is varied; give fields and their values")
    model, cases = study_of(
        study.problem,
        study.over,
        study.outputs,
        tie=study.tie,
        options=study.options,
        **study.design,
    )
    labels = {name: as_labels(values).tolist() for name, values in cases.columns.items()}
    first = {
        "event": "started",
        "cases": len(cases),
        "kind": model.kind.name,
        "dims": list(cases.names) if cases.axes else ["case"],
        "inputs": labels,
        "outputs": list(model.outputs),
    }
    return _line(first), model, cases.chunks(CHUNK)


def _check_size(tables: Mapping[str, Any]) -> None:
    """Reject a study of too many cases before they are created."""
    over, design = tables.get("over"), tables.get("design", {})
    samples = design.get("samples") if isinstance(design, Mapping) else None
    entries = list(_entries(over)) if isinstance(over, Mapping) else []
    cases = samples if isinstance(samples, int) else prod(max(entry, 1) for entry in entries)
    if cases > LIMITS["sweep_cases"]:
        text = (
            f"{cases} cases are too many for the page, which solves {LIMITS['sweep_cases']} "
            "at most; 'woundon sweep' solves any number"
        )
        raise RequestError(413, "too-large", text)


def _entries(over: Mapping[str, Any]) -> Any:
    """Yield the number of values of each varied field."""
    for values in over.values():
        if isinstance(values, list):
            yield len(values)
        elif isinstance(values, Mapping) and isinstance(values.get("count"), int):
            yield values["count"]
        elif isinstance(values, Mapping):
            yield from _entries(values)


def solve_cases(model: KindModel, chunk: Chunk) -> tuple[int, bytes]:
    """Return the number of cases solved, and their event without the progress."""
    solved = solve_chunk(model, chunk)
    values = dict(zip(model.outputs, solved.values.T.tolist(), strict=True))
    event = {
        "event": "cases",
        "numbers": chunk.cases.tolist(),
        "values": values,
        "failures": solved.failure,
        "warnings": solved.warnings,
    }
    return len(chunk.cases), to_json(event)


def _line(event: Mapping[str, Any]) -> bytes:
    return to_json(event) + b"\n"


# ---- in the server ----------------------------------------------------------------------------


async def events(
    pool: Pool,
    study: tuple[bytes, KindModel, list[Chunk]],
    session: Hashable,
    is_disconnected: Callable[[], Awaitable[bool]],
    stopped: asyncio.Event,
) -> AsyncIterator[bytes]:
    """Yield the events of a study as they occur, one line of JSON each.

    Parameters
    ----------
    pool : Pool
    study
        As :func:`start_study` returned it.
    session : hashable
    is_disconnected : callable
        Whether the client has disconnected.
    stopped : asyncio.Event
        Is set to end the study.
    """
    first, model, chunks = study
    start, done, size = time.monotonic(), 0, sum(len(c.cases) for c in chunks)
    yield first
    todo = iter(chunks)
    running: set[asyncio.Task[Any]] = set()
    try:
        while True:
            while len(running) < pool.size and (chunk := next(todo, None)) is not None:
                work = pool.run(solve_cases, model, chunk, rank=RANK, session=session)
                running.add(asyncio.create_task(work))
            if not running:
                yield _line({"event": "done", "seconds": time.monotonic() - start})
                return
            ready, running = await asyncio.wait(
                running, timeout=0.25, return_when=asyncio.FIRST_COMPLETED
            )
            for task in ready:
                cases, event = task.result()
                done += cases
                yield event[:-1] + f',"done":{done},"of":{size}}}\n'.encode()
            if stopped.is_set() or await is_disconnected():
                yield _line({"event": "cancelled"})
                return
            if time.monotonic() - start > LIMITS["study_seconds"]:
                text = f"the study took longer than {LIMITS['study_seconds']} s"
                raise RequestError(504, "too-slow", text)
    except RequestError as error:
        yield b'{"event":"failed","problem":' + error.body() + b"}\n"
    finally:
        for task in running:
            task.cancel()

"""Studies of the page: sweeps, fits and operating windows, whose events are sent as one stream.

    sweep    start_sweep in a worker; then solve_cases in workers, an event for each chunk of cases
    fit      fit_table in a worker          } these write their events to a journal, a file whose
    window   map_window in a thread         } lines the server sends

A study is an asynchronous generator of lines, an event as JSON each.  :func:`event_lines` sends
them, and ends a study that is cancelled or takes too long, or whose client disconnects.
"""

from __future__ import annotations

import asyncio
import binascii
import threading
import time
from base64 import b64decode
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Mapping
from concurrent.futures import Future
from math import inf, prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from ..errors import InvalidProblem, unwarned
from ..io.case_files import check_like_a_case
from ..io.sheets import BINARY, Sheet, TableFile, find_table
from ..io.tables import Names, is_known_header
from ..parallel import Cancelled, usable_cores
from ..problems.problem import Problem
from ..studies.api import study_of
from ..studies.cases import Chunk, as_labels
from ..studies.column_names import columns_of
from ..studies.fit import fit as fit_problem
from ..studies.fit_result import FitResult
from ..studies.model import KindModel
from ..studies.observations import measured_columns
from ..studies.run import solve_chunk
from ..studies.study_file import SCHEMA, study_of_tables
from ..studies.window import operating_window
from ..studies.window_result import OperatingWindow
from .computations import problem_of
from .json_texts import records, to_json
from .limits import LIMITS
from .request_errors import RequestError, request_error_of
from .worker_pool import Pool

__all__ = ["event_lines", "fit", "start_sweep", "sweep", "window"]

Lines = AsyncGenerator[bytes, None]

POLL_SECONDS = 0.25  # between two looks at a journal, and at the connection
RANK = 5  # after the shorter requests of a page
CHUNK = 10  # cases in a chunk, each started from the previous one; then the page is informed
MOST_PROCESSES = 4  # that solve the windings of an operating window


def _line(event: str, **content: Any) -> bytes:
    """Return an event, its name and its content, as a line of JSON."""
    return to_json({"event": event} | content) + b"\n"


async def event_lines(
    study: Lines,
    is_disconnected: Callable[[], Awaitable[bool]],
    stopped: asyncio.Event | None = None,
    seconds: float = inf,
) -> AsyncIterator[bytes]:
    """Yield the events of a study as they occur, one line of JSON each.

    The last one is that of the study, ``cancelled``, or ``failed`` with the details of the error.

    Parameters
    ----------
    study : async generator of bytes
        :func:`sweep`, :func:`fit` or :func:`window`.
    is_disconnected : callable
        Whether the client has disconnected, which ends the study.
    stopped : asyncio.Event, optional
        Is set to end the study.
    seconds : float
        Time limit.
    """
    end = time.monotonic() + seconds
    upcoming = asyncio.ensure_future(anext(study, b""))  # b"" at the end of the study
    try:
        while True:
            await asyncio.wait({upcoming}, timeout=POLL_SECONDS)
            if upcoming.done():
                line = upcoming.result()
                if not line:
                    return
                upcoming = asyncio.ensure_future(anext(study, b""))
                yield line
            if (stopped and stopped.is_set()) or await is_disconnected():
                yield _line("cancelled")
                return
            if time.monotonic() > end:
                text = f"the study took longer than {seconds:g} s"
                raise RequestError(504, "too-slow", text)
    except RequestError as error:
        yield _line("failed", problem=error.details())
    finally:
        upcoming.cancel()  # which ends the work for it


# ---- sweeps -----------------------------------------------------------------------------------


class Sweep(NamedTuple):
    """A study that can be solved: its first event, its model and its chunks of cases.

    The model is the base problem with the requested outputs and the options of the solver.
    """

    first: bytes
    model: KindModel
    chunks: list[Chunk]


def start_sweep(tables: Mapping[str, Any]) -> Sweep:
    """Return the sweep that the tables of a study file describe.

    Raises
    ------
    InvalidProblem
    RequestError
        If there are more cases than a study of the page may have.
    """
    check_like_a_case(tables)
    study = study_of_tables({"schema": SCHEMA, **tables}, folder=None)  # they name no files
    if not isinstance(study.over, Mapping) or not study.over:
        raise InvalidProblem.at("over", "nothing is varied; give fields and their values")
    _check_size(study.over, study.design)
    model, cases = study_of(**study.arguments)
    first = _line(
        "started",
        cases=len(cases),
        kind=model.kind.name,
        dims=cases.names if cases.axes else ["case"],
        inputs={name: as_labels(values) for name, values in cases.columns.items()},
        outputs=model.outputs,
    )
    return Sweep(first, model, cases.chunks(CHUNK))


def _check_size(over: Mapping[str, Any], design: Mapping[str, Any]) -> None:
    """Reject a study of too many cases before they are made.

    Parameters
    ----------
    over : mapping
        Values by the dotted names of the varied fields.
    design : mapping
        Keyword arguments of :func:`woundon.sweep`: ``design``, ``samples``, ``seed``.
    """
    samples, counts = design.get("samples"), [len(values) for values in over.values()]
    if isinstance(samples, int):
        cases = samples
    else:  # all combinations, or the values of all fields in parallel
        cases = prod(counts) if design["design"] == "grid" else max(counts)
    if cases > LIMITS["sweep_cases"]:
        raise _too_many(cases, "cases", limit="sweep_cases", command="sweep", verb="solves")


def _too_many(count: int, things: str, limit: str, command: str, verb: str) -> RequestError:
    """Return the error for a study that only the command line takes.

    Parameters
    ----------
    count, things
        What there is too much of: 3000, "cases".
    limit : str
        Name in :data:`.LIMITS`.
    command, verb : str
        The command of woundon for any number, and what it does with them: "sweep", "solves".
    """
    text = (
        f"{count} {things} are too many for the page, which {verb} {LIMITS[limit]} at most; "
        f"'woundon {command}' {verb} any number"
    )
    return RequestError(413, "too-large", text)


def solve_cases(model: KindModel, chunk: Chunk) -> dict[str, Any]:
    """Return the solved cases of a chunk, for its event.

    ``numbers`` are those of the cases in the study; the other lists have an item for each of them.
    """
    solved = solve_chunk(model, chunk)
    return {
        "numbers": chunk.cases,
        # solved.values has the shape (cases, outputs)
        "values": dict(zip(model.outputs, solved.values.T, strict=True)),
        "failures": solved.failure,
        "warnings": solved.warnings,
    }


async def sweep(pool: Pool, started: Sweep, session: str) -> Lines:
    """Yield the events of a sweep: ``started``, ``cases`` for each chunk as it is solved, ``done``.

    The chunks of one study occupy as many workers as there are, so that studies of two sessions
    take turns.
    """
    start, turns = time.monotonic(), asyncio.Semaphore(pool.size)

    async def solve(chunk: Chunk) -> dict[str, Any]:
        async with turns:
            cases: dict[str, Any] = await pool.run(
                solve_cases, started.model, chunk, rank=RANK, session=session
            )
            return cases

    yield started.first
    tasks = [asyncio.create_task(solve(chunk)) for chunk in started.chunks]
    done, size = 0, sum(len(chunk.cases) for chunk in started.chunks)
    try:
        for task in asyncio.as_completed(tasks):
            cases = await task
            done += len(cases["numbers"])
            yield _line("cases", **cases, done=done, of=size)
    finally:
        for unfinished in tasks:
            unfinished.cancel()
    yield _line("done", seconds=time.monotonic() - start)


# ---- studies with a journal -------------------------------------------------------------------


class Journal:
    """The events of a study, as lines of a file that the server reads.

    Parameters
    ----------
    path : Path
        In a folder that the server deletes when the study is to end.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def write(self, event: str, **content: Any) -> None:
        """Add an event.

        Raises
        ------
        Cancelled
            If the study is to end.
        """
        try:
            with self.path.open("ab") as file:
                file.write(_line(event, **content))
        except FileNotFoundError:
            raise Cancelled from None

    def progress(self, done: int, expected: int) -> None:
        """Add an event of progress; for the argument ``progress`` of a study."""
        self.write("progress", done=done, of=expected)


async def _written(start: Callable[[Journal], Awaitable[Any]]) -> Lines:
    """Yield the lines that a study writes to its journal, until it ends.

    Parameters
    ----------
    start : callable
        Journal -> the study in progress.
    """
    with TemporaryDirectory(prefix="woundon-study-", ignore_cleanup_errors=True) as folder:
        journal = Journal(Path(folder, "journal"))
        journal.path.touch()
        study = asyncio.ensure_future(start(journal))
        try:
            with journal.path.open("rb") as file:
                incomplete, is_done = b"", False
                while not is_done:
                    # waited for before reading: what the study has written last is read too
                    ended, _ = await asyncio.wait({study}, timeout=POLL_SECONDS)
                    is_done = bool(ended)
                    # the last line may be incomplete
                    lines, newline, incomplete = (incomplete + file.read()).rpartition(b"\n")
                    if newline:
                        yield lines + newline
            study.result()  # raises the error that has ended the study
        finally:
            study.cancel()


# ---- fits -------------------------------------------------------------------------------------


def fit(pool: Pool, request: Mapping[str, Any], session: str) -> Lines:
    """Return the events of a fit: ``started``, ``progress``, ``fitted``.

    Parameters
    ----------
    pool, session
        As of :func:`sweep`.
    request : mapping
        As :class:`.request_models.FitRequest`.
    """
    return _written(
        lambda journal: pool.run(fit_table, request, journal, rank=RANK, session=session)
    )


def fit_table(request: Mapping[str, Any], journal: Journal) -> None:
    """Fit a table of measured values; this runs in a worker.

    Raises
    ------
    InvalidProblem, NotConverged
    RequestError
        If the table has more rows than a fit of the page may have.
    """
    journal.write("started")
    problem = problem_of(request["case"])
    sheet = _sheet_of(request, problem)
    with unwarned():
        result = fit_problem(problem, sheet, request["vary"], workers=1, progress=journal.progress)
    fitted = _fitted(result)
    journal.write("fitted", **fitted | {"remarks": [*sheet.remarks, *fitted["remarks"]]})


def _sheet_of(request: Mapping[str, Any], problem: Problem) -> Sheet:
    """Return the table of measured values in a request."""
    (name, _, sheet), content = request["file"].partition("#"), request["table"].encode()
    if Path(name).suffix.lower() in BINARY:
        try:
            content = b64decode(content, validate=True)
        except binascii.Error:
            raise InvalidProblem.at("table", f"{name} is not in base64") from None
    names = Names({**columns_of(problem), **measured_columns(problem)})
    table = find_table(TableFile(name, content), "table", is_known_header(names), sheet)
    if len(table.numbers) > LIMITS["fit_rows"]:
        count = len(table.numbers)
        raise _too_many(count, "rows", limit="fit_rows", command="fit", verb="fits")
    return table


def _fitted(result: FitResult) -> dict[str, Any]:
    """Return a fit for its event, SI units.

    The remarks begin with the parameters that the data do not determine.
    """
    intervals = {profile.name: (profile.low, profile.high) for profile in result.profiles}
    _, *estimates = result.answer()  # a headline, and a line for each parameter
    lines = zip(result.names, estimates, strict=True)
    undetermined = {*result.not_identified, *result.at_bound}
    return {
        "parameters": records(
            name=result.names,
            estimate=result.estimates,
            standard_error=result.standard_errors,
            interval=[intervals.get(name) for name in result.names],
            is_identified=[name not in result.not_identified for name in result.names],
            is_at_bound=[name in result.at_bound for name in result.names],
        ),
        "rms": result.rms,
        "is_weighted": result.weighted,
        "remarks": [*(line for name, line in lines if name in undetermined), *result.remarks()],
        "rows": records(
            row=result.row_numbers,
            output=result.row_outputs,
            measured=result.measured,
            fitted=result.fitted,
        ),
    }


# ---- operating windows ------------------------------------------------------------------------


def window(request: Mapping[str, Any]) -> Lines:
    """Return the events of an operating window: ``progress``, ``window`` (first coarse), ``done``.

    Parameters
    ----------
    request : mapping
        As :class:`.request_models.WindowRequest`.
    """
    return _written(lambda journal: _in_thread(map_window, request, journal))


def map_window(request: Mapping[str, Any], journal: Journal) -> None:
    """Map an operating window; windings are solved in processes, for which this thread waits."""
    given = {name: value for name, value in request.items() if name != "case"}
    with unwarned():
        result = operating_window(
            problem_of(request["case"]),
            **given,
            # at least two: a single one would solve in the server itself
            workers=max(2, min(usable_cores(), MOST_PROCESSES)),
            progress=journal.progress,
            preview=lambda coarse: journal.write("window", **_map(coarse)),
        )
    journal.write("window", **_map(result))
    journal.write("done")


def _in_thread(work: Callable[..., None], *args: Any) -> Awaitable[None]:
    """Start ``work(*args)`` in a thread that does not delay the end of the server.

    Returns
    -------
    awaitable
        Raises the :class:`RequestError` of the exception that ended the work.
    """
    ended: Future[None] = Future()
    ended.set_running_or_notify_cancel()  # cannot be cancelled from now on, only awaited or not

    def run() -> None:
        try:
            work(*args)
            ended.set_result(None)
        except Exception as fault:
            ended.set_exception(request_error_of(fault))
        except Cancelled:  # not an Exception; nobody waits for the result
            ended.set_result(None)

    threading.Thread(target=run, daemon=True).start()
    return asyncio.wrap_future(ended)


def _map(result: OperatingWindow) -> dict[str, Any]:
    """Return a window for its event, SI units; the map by rows of equal first set point.

    The levels of a third set point are innermost.  ``binding`` is the index of the margin that
    limits a point, ``dominant`` that of the input that contributes most to the variance of this
    margin; -1 if there is none.
    """
    return {
        **{name: getattr(result, name) for name in ("names", "axes", "margins", "errors")},
        **{name: getattr(result, name).ravel() for name in ("probability", "binding", "dominant")},
        "inputs": list(result.uncertain),
        "remarks": result.remarks(),
        "best": result.best._asdict(),
        "windings": result.windings,
        "failed": len(result.failures),
        "is_coarse": result.is_coarse,
    }

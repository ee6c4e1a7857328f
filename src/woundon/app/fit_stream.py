"""Fits of the page: a worker fits a table of measured values, events are sent as a stream.

    events -> fit_table(...) in a worker, which writes its progress to a file -> events

A fit ends when it is cancelled or its client disconnects.
"""

from __future__ import annotations

import asyncio
import binascii
from base64 import b64decode
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ..errors import InvalidProblem, unwarned
from ..io.sheets import Sheet, sheet_of_content
from ..studies.fit import fit
from ..studies.fit_result import FitResult
from .computations import problem_of
from .json_texts import to_json
from .limits import LIMITS
from .request_errors import RequestError
from .worker_pool import Pool

__all__ = ["events", "fit_table"]

POLL_SECONDS = 0.25  # between two looks at the progress
RANK = 5  # after the shorter requests of a page, as studies


# ---- in the worker ----------------------------------------------------------------------------


def fit_table(request: Mapping[str, Any], progress_file: str) -> bytes:
    """Return the fit of a table as an event; ``request`` as :class:`.request_models.FitRequest`.

    Raises
    ------
    InvalidProblem
    NotConverged
    RequestError
        If the table has more rows than a fit of the page may have.
    """
    problem, sheet = problem_of(request["case"]), _sheet_of(request)

    def report(done: int, expected: int) -> None:
        event = to_json({"event": "progress", "done": done, "of": expected})
        Path(progress_file).write_bytes(event + b"\n")

    with unwarned():
        result = fit(problem, sheet, request["vary"], workers=1, progress=report)
    return to_json({"event": "fitted"} | _content(result)) + b"\n"


def _sheet_of(request: Mapping[str, Any]) -> Sheet:
    """Return the table of measured values in a request."""
    content = request["table"].encode()
    if request["is_workbook"]:
        try:
            content = b64decode(content, validate=True)
        except binascii.Error:
            raise InvalidProblem.at("table", "is not an .xlsx file in base64") from None
    sheet = sheet_of_content(content, "table", excel=request["is_workbook"])
    if len(sheet.numbers) > LIMITS["fit_rows"]:
        text = (
            f"{len(sheet.numbers)} rows are too many for the page, which fits at most "
            f"{LIMITS['fit_rows']}; 'woundon fit' fits any number"
        )
        raise RequestError(413, "too-large", text)
    return sheet


def _content(result: FitResult) -> dict[str, Any]:
    """Return a fit for JSON, SI units."""
    intervals = {profile.name: [profile.low, profile.high] for profile in result.profiles}
    return {
        "parameters": [
            {
                "name": name,
                "estimate": estimate,
                "standard_error": error,
                "interval": intervals.get(name),
                "is_identified": name not in result.not_identified,
                "is_at_bound": name in result.at_bound,
            }
            for name, estimate, error in zip(
                result.names,
                result.estimates.tolist(),
                result.standard_errors.tolist(),
                strict=True,
            )
        ],
        "rms": result.rms,
        "is_weighted": result.weighted,
        "remarks": result.lines()[1 + len(result.names) :],
        "rows": [
            {"row": row, "output": output, "measured": measured, "fitted": fitted}
            for row, output, measured, fitted in zip(
                result.row_numbers,
                result.row_outputs,
                result.measured.tolist(),
                result.fitted.tolist(),
                strict=True,
            )
        ],
    }


# ---- in the server ----------------------------------------------------------------------------


async def events(
    pool: Pool,
    request: Mapping[str, Any],
    session: Hashable,
    is_disconnected: Callable[[], Awaitable[bool]],
    stopped: asyncio.Event,
) -> AsyncIterator[bytes]:
    """Yield the events of a fit, a line of JSON each: progress, and the fit or its failure.

    Parameters
    ----------
    pool, session, is_disconnected, stopped
        As of :func:`.study_stream.events`.
    request : mapping
        As :class:`.request_models.FitRequest`.
    """
    with TemporaryDirectory(prefix="woundon-fit-") as folder:
        file, sent = Path(folder, "progress"), b""
        work = pool.run(fit_table, request, str(file), rank=RANK, session=session)
        task = asyncio.create_task(work)
        yield to_json({"event": "started"}) + b"\n"
        try:
            while not (await asyncio.wait({task}, timeout=POLL_SECONDS))[0]:
                if stopped.is_set() or await is_disconnected():
                    yield to_json({"event": "cancelled"}) + b"\n"
                    return
                with suppress(FileNotFoundError):
                    line = file.read_bytes()
                    if line.endswith(b"\n") and line != sent:
                        yield (sent := line)
            yield task.result()
        except RequestError as error:
            yield b'{"event":"failed","problem":' + error.body() + b"}\n"
        finally:
            task.cancel()

"""The HTTP interface of the page, and of whoever else asks: FastAPI over :mod:`.answers`.

request -> Guard -> route -> Pool (a worker's process: answers, sweeps, papers) -> answer
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import re
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Annotated, Any

from fastapi import FastAPI, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, StreamingResponse
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware

from .. import __version__
from ..parallel import usable_cores
from . import answers, papers, sweeps
from .catalogue import LIMITS, catalogue
from .guard import Guard, json_of, whole_body
from .openapi import OF_CASE, OF_CASES, OF_DESIGN, OF_STUDY, OF_TOML, described, page_of
from .refusals import MEDIA, Refusal
from .workers import Pool

__all__ = ["application"]

STATIC = Path(__file__).parent / "static"
MOST_SOLVERS = 4
LISTENING = 0.2  # seconds between two looks whether the client is still there
_SESSION = re.compile(r"[A-Za-z0-9_-]{8,64}")
_TYPES = {
    "csv": "text/csv", "json": "application/json", "nc": "application/x-netcdf",
    "svg": "image/svg+xml", "png": "image/png", "pdf": "application/pdf",
}  # fmt: skip


class _Office:
    """The workers, and who has a study under way."""

    def __init__(self) -> None:
        size = max(2, min(usable_cores(), MOST_SOLVERS))
        self.solvers = Pool(size, answers.warm_up, seconds=LIMITS["solve_seconds"])
        # neither a slider nor what is drawn around it waits for a study, which stands back
        self.others = Pool(1, answers.warm_up, seconds=LIMITS["paper_seconds"], nice=1)
        self.cases = Pool(size, answers.warm_up, seconds=LIMITS["study_seconds"], nice=10)
        self.studies: dict[str, asyncio.Event] = {}

    async def open(self) -> None:
        for pool in (self.solvers, self.others, self.cases):  # the first that is needed first
            await pool.open()

    async def close(self) -> None:
        for pool in (self.solvers, self.others, self.cases):
            pool.close()


def application(names: Iterable[str] = (), token: str = "") -> Guard:
    """Return the ASGI application; see :class:`~.guard.Guard` for the arguments."""
    office = _Office()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        opening = asyncio.create_task(office.open())  # the page comes before the workers are ready
        yield
        opening.cancel()
        await office.close()

    app = FastAPI(
        title="woundon", version=__version__, lifespan=lifespan, docs_url=None, redoc_url=None,
        description="Winding mechanics over HTTP: what 'woundon' computes, for cases as JSON.",
    )  # fmt: skip
    app.add_exception_handler(Refusal, _refused)
    app.add_exception_handler(HTTPException, _refused_by_route)
    app.add_exception_handler(RequestValidationError, _refused_query)
    _pages(app)
    _states(app, office)
    _around(app, office)
    _studies(app, office)
    _papers(app, office)
    app.openapi = lambda: described(FastAPI.openapi(app))  # type: ignore[method-assign]
    return Guard(app, names, token)


# ---- refusals ---------------------------------------------------------------------------------


async def _refused(request: Request, refusal: Any) -> Response:
    # what was not read of a body is not waited for
    closing = {"connection": "close"} if refusal.status in (408, 413, 415) else {}
    return Response(refusal.body(), refusal.status, closing, media_type=MEDIA)


async def _refused_by_route(request: Request, fault: Any) -> Response:
    return await _refused(request, Refusal(fault.status_code, "refused", str(fault.detail)))


async def _refused_query(request: Request, fault: Any) -> Response:
    errors = tuple({"field": str(one["loc"][-1]), "message": one["msg"]} for one in fault.errors())
    detail = "\n".join(f"{one['field']}: {one['message']}" for one in errors)
    return await _refused(request, Refusal(422, "invalid", detail, errors))


def _session_of(request: Request) -> str:
    told = request.headers.get("x-session", "")
    return told if _SESSION.fullmatch(told) else ""


async def _tables(request: Request) -> Any:
    return json_of(await whole_body(request))


def _options(request: Request, *known: str) -> dict[str, Any]:
    """Return the solver's options: what the address says beside a route's own arguments."""
    return {name: value for name, value in request.query_params.items() if name not in known}


async def _asked(
    pool: Pool, request: Request, what: str, call: Callable[..., Any], *given: Any, rank: int = 0
) -> Any:
    """Return a worker's answer; of one session and route the newest request wins.

    The work is cancelled when the client disconnects.
    """
    session = _session_of(request)
    key = (session, what) if session else None
    answer = asyncio.create_task(pool.run(call, *given, key=key, session=session, rank=rank))
    try:
        while not (await asyncio.wait({answer}, timeout=LISTENING))[0]:
            if await request.is_disconnected():
                raise Refusal(408, "disconnected", "the client has disconnected")
        return answer.result()
    finally:
        answer.cancel()


# ---- routes -----------------------------------------------------------------------------------


def _pages(app: FastAPI) -> None:
    @app.get("/", include_in_schema=False)
    async def page() -> Response:
        return FileResponse(STATIC / "index.html")

    @app.get("/api", include_in_schema=False)
    async def interface() -> Response:
        return Response(page_of(app.openapi()), media_type="text/html")

    @app.get("/api/catalogue", tags=["catalogue"])
    async def what_there_is(request: Request) -> Response:
        """Kinds of problem, their forms with units and ranges, their outputs, named materials."""
        body = await asyncio.to_thread(lambda: answers.as_json(catalogue()))
        tag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers={"etag": tag})
        headers = {"etag": tag, "cache-control": "no-cache", "vary": "accept-encoding"}
        if "gzip" in request.headers.get("accept-encoding", ""):
            body = gzip.compress(body, 6, mtime=0)
            headers["content-encoding"] = "gzip"
        return Response(body, headers=headers, media_type="application/json")

    # its files alone: what is streamed elsewhere must not wait for a block to fill
    app.mount("/static", GZipMiddleware(StaticFiles(directory=STATIC)), name="static")


def _states(app: FastAPI, office: _Office) -> None:
    @app.post("/api/solve", tags=["states"], openapi_extra=OF_CASE)
    async def solve(
        request: Request, warm: bool = False, report: bool = False, drawn: bool = False
    ) -> Response:
        """Solve a case.  What else the address says are options of the solver: ``?nodes=129``."""
        tables = await _tables(request)
        options = _options(request, "warm", "report", "drawn", "token")
        body = await _asked(office.solvers, request, "solve", answers.solve, tables, options,
                            _session_of(request), warm, report, drawn)  # fmt: skip
        return Response(body, media_type="application/json")

    @app.post("/api/design", tags=["states"], openapi_extra=OF_DESIGN)
    async def design(request: Request) -> Response:
        """Find the tension over the radius that leaves a wanted pressure in a wound roll."""
        body = await _asked(
            office.solvers, request, "design", answers.design, await _tables(request)
        )
        return Response(body, media_type="application/json")


def _around(app: FastAPI, office: _Office) -> None:
    @app.post("/api/curve", tags=["states"], openapi_extra=OF_CASE)
    async def curve(
        request: Request,
        field: str,
        points: Annotated[int, Query(ge=2, le=LIMITS["curve_points"])] = 11,
        low: Annotated[float | None, Query(allow_inf_nan=False)] = None,
        high: Annotated[float | None, Query(allow_inf_nan=False)] = None,
        outputs: str = "",
    ) -> Response:
        """Outputs against one field, around a case."""
        tables = await _tables(request)
        options = _options(request, "field", "points", "low", "high", "outputs", "token")
        named = [name for name in outputs.split(",") if name]
        body = await _asked(office.others, request, "curve", answers.curve, tables, field, options,
                            points, low, high, named)  # fmt: skip
        return Response(body, media_type="application/json")

    @app.post("/api/sensitivities", tags=["states"], openapi_extra=OF_CASE)
    async def sensitivities(request: Request) -> Response:
        """How much the outputs depend on each field."""
        tables, options = await _tables(request), _options(request, "token")
        body = await _asked(office.others, request, "sensitivities", answers.sensitivities,
                            tables, options, rank=1)  # fmt: skip
        return Response(body, media_type="application/json")


def _studies(app: FastAPI, office: _Office) -> None:
    @app.post("/api/sweep", tags=["studies"], openapi_extra=OF_STUDY)
    async def sweep(request: Request) -> Response:
        """Solve a study: its events, a line of JSON each, as they come."""
        tables, session = await _tables(request), _session_of(request)
        if session in office.studies:
            office.studies[session].set()
        study = await _asked(office.cases, request, "sweep", sweeps.begun, tables)
        stopped = asyncio.Event()
        if session:
            office.studies[session] = stopped

        async def told() -> AsyncIterator[bytes]:
            try:
                async for line in sweeps.events(
                    office.cases, study, session, request.is_disconnected, stopped
                ):
                    yield line
            finally:
                if office.studies.get(session) is stopped:
                    del office.studies[session]

        return StreamingResponse(told(), media_type="application/x-ndjson")

    @app.post("/api/cancel", tags=["studies"])
    async def cancel(request: Request) -> dict[str, bool]:
        """End the study of the session that the header X-Session names."""
        stopped = office.studies.get(_session_of(request))
        if stopped is not None:
            stopped.set()
        return {"cancelled": stopped is not None}


def _papers(app: FastAPI, office: _Office) -> None:
    def route(path: str, media: str, call: Callable[..., Any], of: dict[str, Any]) -> None:
        async def paper(request: Request) -> Response:
            body = await _asked(office.others, request, path, call, await _tables(request), rank=1)
            return Response(body, media_type=media)

        paper.__doc__ = (call.__doc__ or "").partition("\n")[0]
        name = path.removeprefix("/api/").replace("/", "_")
        app.post(path, tags=["in and out"], openapi_extra=of, name=name)(paper)

    route("/api/case/read", "application/json", papers.read_case, OF_TOML)
    route("/api/case/write", "text/plain", papers.written_case, OF_CASE)
    route("/api/python", "text/plain", papers.python_text, OF_CASE)
    route("/api/report", "text/html", papers.report, OF_CASES)

    @app.post("/api/file", tags=["in and out"], openapi_extra=OF_CASE)
    async def file(
        request: Request, format: Annotated[str, Query(pattern="^(csv|json|nc)$")] = "csv"
    ) -> Response:
        """Return the solved case as a result file."""
        options = _options(request, "format", "token")
        body = await _asked(office.others, request, "file", papers.result_file,
                            await _tables(request), format, options, rank=1)  # fmt: skip
        return _attached(body, f"result.{format}")

    @app.post("/api/figure", tags=["in and out"], openapi_extra=OF_CASES)
    async def figure(
        request: Request, format: Annotated[str, Query(pattern="^(svg|png|pdf)$")] = "svg",
        panels: str = "",
    ) -> Response:  # fmt: skip
        """Return a picture of one case, or of several in one."""
        chosen = [name for name in panels.split(",") if name]
        body = await _asked(office.others, request, "figure", papers.figure,
                            await _tables(request), format, chosen, rank=1)  # fmt: skip
        return _attached(body, f"figure.{format}")

    @app.get("/api/thesis/{name}", tags=["in and out"])
    async def exhibit(request: Request, name: str) -> Response:
        """Compute a figure that the catalogue names among its exhibits."""
        body = await _asked(office.others, request, "exhibit", papers.exhibit, name, rank=2)
        return Response(body, media_type=_TYPES["svg"])


def _attached(body: bytes, name: str) -> Response:
    headers = {"content-disposition": f'attachment; filename="{name}"'}
    return Response(body, headers=headers, media_type=_TYPES[name.rpartition(".")[2]])

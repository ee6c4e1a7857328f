"""The HTTP interface of the page and of programs: FastAPI in front of :mod:`.computations`.

request -> middleware -> route -> Pool (a worker process) -> response
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import json
import re
from collections.abc import AsyncIterator, Callable, Coroutine, Iterable
from contextlib import asynccontextmanager
from html import escape
from pathlib import Path
from typing import Annotated, Any

from fastapi import FastAPI, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, StreamingResponse
from fastapi.routing import APIRoute
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect

from .. import __version__
from ..parallel import usable_cores
from . import computations, documents, fit_stream, study_stream, window_stream
from .input_forms import catalogue
from .json_texts import from_json, to_json
from .limits import LIMITS
from .middleware import COOKIE, middleware
from .request_errors import REJECTIONS, RequestError
from .request_models import (
    Case,
    Cases,
    CaseText,
    DesignRequest,
    FindRequest,
    FitRequest,
    GradeRequest,
    Study,
    WindowRequest,
)
from .worker_pool import Pool

__all__ = ["application"]

STATIC = Path(__file__).parent / "static"
MOST_SOLVERS = 4
BODY_SECONDS = 10.0  # for a body to arrive
POLL_SECONDS = 0.2  # between two checks whether the client is still connected
SESSION = re.compile(r"[A-Za-z0-9_-]{8,64}")
MEDIA_TYPES = {
    "csv": "text/csv",
    "json": "application/json",
    "nc": "application/x-netcdf",
    "svg": "image/svg+xml",
    "png": "image/png",
    "pdf": "application/pdf",
}


class Workers:
    """The worker processes, and the studies in progress by session."""

    def __init__(self) -> None:
        size, warm_up = max(2, min(usable_cores(), MOST_SOLVERS)), computations.warm_up
        # single cases, which sliders wait for
        self.solvers = Pool(size, warm_up, seconds=LIMITS["solve_seconds"])
        # variations of a case (curves, sensitivities, targets), files, reports and figures
        self.others = Pool(1, warm_up, seconds=LIMITS["document_seconds"], nice=1)
        # the cases of studies: at the lowest priority, so that no slider waits for them
        self.cases = Pool(size, warm_up, seconds=LIMITS["study_seconds"], nice=10)
        # the running study of each session, by the event that stops it
        self.studies: dict[str, asyncio.Event] = {}
        self.window = asyncio.Lock()  # of the only operating window at a time

    async def open(self) -> None:
        """Start the processes, those needed first before the others."""
        for pool in (self.solvers, self.others, self.cases):
            await pool.open()

    def close(self) -> None:
        """End the processes."""
        for pool in (self.solvers, self.others, self.cases):
            pool.close()


class JSONRequest(Request):
    """A request whose body arrives in time and is strict JSON: no nan, no infinity."""

    async def body(self) -> bytes:
        """Return the body.

        Raises
        ------
        HTTPException
            If it arrives too slowly or incompletely.
        """
        try:
            async with asyncio.timeout(BODY_SECONDS):
                return await super().body()
        except TimeoutError:
            text = f"the body did not arrive within {BODY_SECONDS:g} s"
            raise HTTPException(408, text) from None
        except ClientDisconnect:
            raise HTTPException(400, "the connection was closed within the body") from None

    async def json(self) -> Any:
        """Return the value of the body.

        Raises
        ------
        HTTPException
            If it is not JSON.
        """
        try:
            return from_json(await self.body())
        except ValueError as fault:
            raise HTTPException(400, f"the body is not JSON: {str(fault)[:200]}") from None


class JSONRoute(APIRoute):
    """A route whose requests are of :class:`JSONRequest`."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of the route."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(JSONRequest(request.scope, request.receive))

        return handle


def application(names: Iterable[str] = (), token: str = "") -> FastAPI:
    """Return the ASGI application; see :func:`~.middleware.middleware` for the arguments."""
    workers = Workers()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        """Start the workers with the server, and stop them at its end."""
        opening = asyncio.create_task(workers.open())  # the page is served before they are ready
        yield
        opening.cancel()
        workers.close()

    app = FastAPI(
        title="woundon",
        version=__version__,
        description="Winding mechanics over HTTP: the results of woundon for cases as JSON.",
        lifespan=lifespan,
        docs_url=None,  # Swagger and Redoc load their scripts from other sites
        redoc_url=None,
        middleware=middleware(names, token),
        responses=REJECTIONS,
        exception_handlers={
            RequestError: _rejected,
            HTTPException: _rejected_by_starlette,
            RequestValidationError: _invalid,
        },
    )
    app.router.route_class = JSONRoute
    _add_pages(app, token)
    _add_states(app, workers)
    _add_variations(app, workers)
    _add_studies(app, workers)
    _add_documents(app, workers)
    return app


# ---- errors -------------------------------------------------------------------------------------


async def _rejected(request: Request, error: Any) -> Response:
    response: Response = error.response()
    return response


async def _rejected_by_starlette(request: Request, error: Any) -> Response:
    return RequestError(error.status_code, "rejected", str(error.detail)).response()


async def _invalid(request: Request, error: Any) -> Response:
    """Return the response to a request of invalid form."""
    errors = tuple(
        {"field": ".".join(map(str, entry["loc"][1:])), "message": entry["msg"]}
        for entry in error.errors()
    )
    detail = "\n".join(
        f"{entry['field']}: {entry['message']}".removeprefix(": ") for entry in errors
    )
    return RequestError(422, "invalid", detail, errors).response()


# ---- requests to workers ------------------------------------------------------------------------


def _session_of(request: Request) -> str:
    session = request.headers.get("x-session", "")
    return session if SESSION.fullmatch(session) else ""


def _options(request: Request, *known: str) -> dict[str, Any]:
    """Return the options of the solver: the fields of the query except those of the route."""
    excluded = {"token", *known}
    return {name: value for name, value in request.query_params.items() if name not in excluded}


async def _computed(
    pool: Pool, request: Request, call: Callable[..., Any], *args: Any, rank: int = 0
) -> Any:
    """Return ``call(*args)``, computed by a worker.

    A new request of a session cancels its earlier one for the same function.  The computation is
    also cancelled when the client disconnects.
    """
    session = _session_of(request)
    key = (session, call.__name__) if session else None
    answer = asyncio.create_task(pool.run(call, *args, key=key, session=session, rank=rank))
    try:
        while not (await asyncio.wait({answer}, timeout=POLL_SECONDS))[0]:
            if await request.is_disconnected():
                raise RequestError(408, "disconnected", "the client has disconnected")
        return answer.result()
    finally:
        answer.cancel()


def _json(body: bytes) -> Response:
    return Response(body, media_type="application/json")


def _file(body: bytes, name: str) -> Response:
    headers = {"content-disposition": f'attachment; filename="{name}"'}
    return Response(body, headers=headers, media_type=MEDIA_TYPES[name.rpartition(".")[2]])


# ---- routes -------------------------------------------------------------------------------------


def _add_pages(app: FastAPI, secret: str) -> None:
    """Add the routes of the page, the description of the interface and the catalogue."""

    @app.get("/", include_in_schema=False)
    async def page(token: str = "") -> Response:
        """Return the page; with a valid token, set the cookie that carries it."""
        response = FileResponse(STATIC / "index.html")
        if secret and token == secret:  # the requests of the page carry it from then on
            response.set_cookie(COOKIE, secret, httponly=True, samesite="strict")
        return response

    @app.get("/api", include_in_schema=False)
    async def interface() -> Response:
        return Response(_description(app.openapi()), media_type="text/html")

    @app.get("/api/catalogue", tags=["catalogue"])
    async def describe(request: Request) -> Response:
        """Return kinds of problem, their forms with units and ranges, outputs, grades."""
        body = await asyncio.to_thread(lambda: to_json(catalogue()))
        tag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers={"etag": tag})
        headers = {"etag": tag, "cache-control": "no-cache", "vary": "accept-encoding"}
        if "gzip" in request.headers.get("accept-encoding", ""):
            body = gzip.compress(body, 6, mtime=0)
            headers["content-encoding"] = "gzip"
        return Response(body, headers=headers, media_type="application/json")

    # for files only: it would hold back the lines of streams until a block is full
    app.mount("/static", GZipMiddleware(StaticFiles(directory=STATIC)), name="static")


def _add_states(app: FastAPI, workers: Workers) -> None:
    """Add the routes that solve a case or change its tables."""

    @app.post("/api/solve", tags=["states"])
    async def solve(
        request: Request, case: Case, warm: bool = False, report: bool = False, drawn: bool = False
    ) -> Response:
        """Solve a case.  Other fields of the query are options of the solver: ``?nodes=129``."""
        options = _options(request, "warm", "report", "drawn")
        args = (case, options, _session_of(request), warm, report, drawn)
        return _json(await _computed(workers.solvers, request, computations.solve, *args))

    @app.post("/api/grade", tags=["states"])
    async def grade(request: Request, body: GradeRequest) -> Response:
        """Return the tables of a case with the web, friction and limits of a grade."""
        args = (body.case, body.grade)
        return _json(await _computed(workers.solvers, request, computations.with_grade, *args))

    @app.post("/api/design", tags=["states"])
    async def design(request: Request, body: DesignRequest) -> Response:
        """Find the tension over the radius that gives a wound roll a target pressure."""
        args = (body.case, body.pressure, body.rtol)
        return _json(await _computed(workers.solvers, request, computations.design, *args))


def _add_variations(app: FastAPI, workers: Workers) -> None:
    """Add the routes that vary the fields of a case."""

    @app.post("/api/curve", tags=["states"])
    async def curve(
        request: Request,
        case: Case,
        field: str,
        points: Annotated[int, Query(ge=2, le=LIMITS["curve_points"])] = 11,
        low: Annotated[float | None, Query(allow_inf_nan=False)] = None,
        high: Annotated[float | None, Query(allow_inf_nan=False)] = None,
        outputs: str = "",
    ) -> Response:
        """Return outputs against one field around a case."""
        options = _options(request, "field", "points", "low", "high", "outputs")
        names = [name for name in outputs.split(",") if name]
        args = (case, field, options, points, low, high, names)
        return _json(await _computed(workers.others, request, computations.curve, *args))

    @app.post("/api/sensitivities", tags=["states"])
    async def sensitivities(request: Request, case: Case) -> Response:
        """Return the derivatives of the outputs with respect to each field."""
        call, args = computations.sensitivities, (case, _options(request))
        return _json(await _computed(workers.others, request, call, *args, rank=1))

    @app.post("/api/find", tags=["states"])
    async def find(request: Request, body: FindRequest) -> Response:
        """Find the values of a field for which an output reaches a target."""
        args = (body.case, body.field, body.output, body.target, body.between)
        return _json(await _computed(workers.others, request, computations.find, *args))


def _add_studies(app: FastAPI, workers: Workers) -> None:
    """Add the routes of studies, which stream their events."""

    def streamed(request: Request, events: Callable[..., AsyncIterator[bytes]], tables: Any) -> Any:
        """Return the events of a study; a running study of the same session is stopped."""
        session, studies, stopped = _session_of(request), workers.studies, asyncio.Event()
        if session in studies:
            studies[session].set()
        if session:
            studies[session] = stopped

        async def lines() -> AsyncIterator[bytes]:
            try:
                args = (workers.cases, tables, session, request.is_disconnected, stopped)
                async for line in events(*args):
                    yield line
            finally:
                if studies.get(session) is stopped:
                    del studies[session]

        return StreamingResponse(lines(), media_type="application/x-ndjson")

    @app.post("/api/sweep", tags=["studies"])
    async def sweep(request: Request, study: Study) -> Response:
        """Solve a study; its events are streamed, one line of JSON each."""
        tables = study.model_dump(exclude_unset=True)
        started = await _computed(workers.cases, request, study_stream.start_study, tables)
        return streamed(request, study_stream.events, started)

    @app.post("/api/fit", tags=["studies"])
    async def fit(request: Request, body: FitRequest) -> Response:
        """Fit one or two fields to a table of measured values; events as those of a study."""
        return streamed(request, fit_stream.events, body.model_dump())

    @app.post("/api/window", tags=["studies"])
    async def window(request: Request, body: WindowRequest) -> Response:
        """Map the probability that a roll keeps its limits; events as those of a study."""
        if workers.window.locked():
            raise RequestError(503, "busy", "another operating window is being computed")

        async def lines() -> AsyncIterator[bytes]:
            async with workers.window:
                events = window_stream.events(body.model_dump(), request.is_disconnected)
                async for line in events:
                    yield line

        return StreamingResponse(lines(), media_type="application/x-ndjson")

    @app.post("/api/cancel", tags=["studies"])
    async def cancel(request: Request) -> dict[str, bool]:
        """Stop the study of the session in the header X-Session."""
        stopped = workers.studies.get(_session_of(request))
        if stopped is not None:
            stopped.set()
        return {"cancelled": stopped is not None}


def _add_documents(app: FastAPI, workers: Workers) -> None:
    """Add the routes that read and write files, reports and figures."""

    async def written(request: Request, call: Callable[..., Any], *args: Any, rank: int = 1) -> Any:
        return await _computed(workers.others, request, call, *args, rank=rank)

    @app.post("/api/case/read", tags=["documents"])
    async def read_case(request: Request, text: CaseText) -> Response:
        """Return the tables of the text of a case file, complete and in SI."""
        return _json(await written(request, documents.read_case, text.toml))

    @app.post("/api/case/write", tags=["documents"])
    async def case_file(request: Request, case: Case) -> Response:
        """Return the case file of a case, with comments."""
        body = await written(request, documents.case_file, case)
        return Response(body, media_type="text/plain")

    @app.post("/api/python", tags=["documents"])
    async def python_text(request: Request, case: Case) -> Response:
        """Return the Python script that computes a case."""
        body = await written(request, documents.python_text, case)
        return Response(body, media_type="text/plain")

    @app.post("/api/file", tags=["documents"])
    async def result_file(
        request: Request,
        case: Case,
        format: Annotated[str, Query(pattern="^(csv|json|nc)$")] = "csv",
    ) -> Response:
        """Return the solved case as a result file."""
        options = _options(request, "format")
        body = await written(request, documents.result_file, case, format, options)
        return _file(body, f"result.{format}")

    @app.post("/api/report", tags=["documents"])
    async def report(request: Request, cases: Cases) -> Response:
        """Return the report of solved cases as a self-contained HTML file."""
        body = await written(request, documents.report, cases.model_dump())
        return Response(body, media_type="text/html")

    @app.post("/api/figure", tags=["documents"])
    async def figure(
        request: Request,
        cases: Cases,
        format: Annotated[str, Query(pattern="^(svg|png|pdf)$")] = "svg",
        panels: str = "",
    ) -> Response:
        """Return a figure of one case or of several cases."""
        panel_names = [name for name in panels.split(",") if name]
        body = await written(request, documents.figure, cases.model_dump(), format, panel_names)
        return _file(body, f"figure.{format}")

    @app.get("/api/thesis/{name}", tags=["documents"])
    async def exhibit(request: Request, name: str) -> Response:
        """Compute a figure that the catalogue names among its exhibits."""
        body = await written(request, documents.exhibit, name, rank=2)
        return Response(body, media_type=MEDIA_TYPES["svg"])


def _description(document: dict[str, Any]) -> str:
    """Return the routes of the OpenAPI document as a page without external scripts."""
    rows = "".join(
        f"<tr><td><code>{method.upper()} {escape(path)}</code></td>"
        f"<td>{escape(route.get('description', ''))}</td>"
        f"<td><code>{escape(', '.join(p['name'] for p in route.get('parameters', ())))}</code>"
        "</td></tr>"
        for path, routes in document["paths"].items()
        for method, route in routes.items()
    )
    schemas = escape(json.dumps(document["components"]["schemas"], indent=1))
    info = document["info"]
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{info["title"]}: HTTP</title>'
        f"<h1>{info['title']} {info['version']}</h1><p>{escape(info['description'])} The same as "
        '<a href="/openapi.json">OpenAPI document</a>; names, units and ranges of all fields: '
        '<a href="/api/catalogue">catalogue</a>.</p><table><tr><th>route</th><th></th>'
        f"<th>query</th></tr>{rows}</table><h2>Bodies</h2><pre>{schemas}</pre></html>"
    )

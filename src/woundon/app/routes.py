"""The HTTP interface of the page and of programs: FastAPI in front of :mod:`.computations`.

request -> middleware -> route -> Pool (a worker process) -> response

A study streams its events (:mod:`.study_stream`).
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import json
import re
from collections.abc import AsyncIterator, Callable, Coroutine, Iterable
from contextlib import asynccontextmanager
from functools import cache
from html import escape
from pathlib import Path
from typing import Annotated, Any, TypeVar, TypeVarTuple

from fastapi import APIRouter, FastAPI, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, StreamingResponse
from fastapi.routing import APIRoute
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect

from .. import __version__
from ..errors import InvalidProblem
from ..parallel import usable_cores
from . import computations, documents, study_stream
from .input_forms import catalogue
from .json_texts import from_json, to_json
from .limits import LIMITS
from .middleware import COOKIE, middleware
from .request_errors import REJECTIONS, RequestError, request_error_of
from .request_models import (
    Case,
    Cases,
    CaseText,
    CurveQuery,
    DesignRequest,
    FileQuery,
    FindRequest,
    FitRequest,
    GradeRequest,
    SolveQuery,
    SolverQuery,
    Study,
    WindowRequest,
)
from .worker_pool import Pool

__all__ = ["application"]

Answer = TypeVar("Answer")
Args = TypeVarTuple("Args")
STATIC = Path(__file__).parent / "static"
MOST_SOLVERS = 4
BODY_SECONDS = 10.0  # for a body to arrive
POLL_SECONDS = 0.2  # between two checks whether the client is still connected
LATER, LAST = 1, 2  # ranks of requests: after those that a user waits for, and after these
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

    def stop_study(self, session: str) -> bool:
        """Stop the running study of a session; return whether there was one."""
        stopped = self.studies.get(session)
        if stopped is not None:
            stopped.set()
        return stopped is not None


class APIRequest(Request):
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

    @property
    def session_name(self) -> str:
        """Name of the user's session; "" without one."""
        name = self.headers.get("x-session", "")
        return name if SESSION.fullmatch(name) else ""

    @property
    def workers(self) -> Workers:
        """The worker processes of the application."""
        workers: Workers = self.app.state.workers
        return workers

    async def computed(
        self, pool: Pool, call: Callable[[*Args], Answer], *args: *Args, rank: int = 0
    ) -> Answer:
        """Return ``call(*args)``, computed by a worker.

        A new request of a session cancels its earlier one for the same function.  The computation
        is also cancelled when the client disconnects.
        """
        session = self.session_name
        key = (session, call.__name__) if session else None
        answer = asyncio.create_task(pool.run(call, *args, key=key, session=session, rank=rank))
        try:
            # wait returns the tasks that are finished, and those that are not
            while not (await asyncio.wait({answer}, timeout=POLL_SECONDS))[0]:
                if await self.is_disconnected():
                    raise RequestError(408, "disconnected", "the client has disconnected")
            return answer.result()
        finally:
            answer.cancel()  # without effect on an answer

    async def answered(
        self,
        call: Callable[..., bytes],
        *args: Any,
        pool: Pool | None = None,
        rank: int = 0,
        media_type: str = MEDIA_TYPES["json"],
        file_name: str = "",
    ) -> Response:
        """Return the response whose content ``call(*args)`` a worker computes.

        Parameters
        ----------
        call, args
            A function and its arguments.
        pool : Pool, optional
            By default ``workers.others``.
        rank : int
            Lower ones first.
        media_type : str
            Of content that browsers show.
        file_name : str
            Under which browsers save the content.
        """
        body = await self.computed(pool or self.workers.others, call, *args, rank=rank)
        if not file_name:
            return Response(body, media_type=media_type)
        media_type = MEDIA_TYPES[file_name.rpartition(".")[2]]
        headers = {"content-disposition": f'attachment; filename="{file_name}"'}
        return Response(body, headers=headers, media_type=media_type)


class _Route(APIRoute):
    """A route whose requests are of :class:`APIRequest`."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler of the route."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(APIRequest(request.scope, request.receive))

        return handle


router = APIRouter(route_class=_Route)


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
        exception_handlers=dict.fromkeys(
            (RequestError, HTTPException, RequestValidationError), _rejected
        ),
    )
    app.state.workers, app.state.token = workers, token
    app.include_router(router)
    # for files only: it would hold back the lines of streams until a block is full
    app.mount("/static", GZipMiddleware(StaticFiles(directory=STATIC)), name="static")
    return app


async def _rejected(request: Request, fault: Any) -> Response:
    """Return the response to a request that a route, Starlette or FastAPI rejects."""
    if isinstance(fault, HTTPException):
        fault = RequestError(fault.status_code, "rejected", str(fault.detail))
    elif isinstance(fault, RequestValidationError):
        fault = InvalidProblem(
            # loc: "body" or "query", then the path of the field
            (".".join(map(str, error["loc"][1:])), error["msg"])
            for error in fault.errors()
        )
    return request_error_of(fault).response()


# ---- the page, the description of the interface, the catalogue ----------------------------------


@router.get("/", include_in_schema=False)
async def page(request: APIRequest, token: str = "") -> Response:
    """Return the page; with a valid token, set the cookie that carries it."""
    response, secret = FileResponse(STATIC / "index.html"), request.app.state.token
    if secret and token == secret:  # the requests of the page carry it from then on
        response.set_cookie(COOKIE, secret, httponly=True, samesite="strict")
    return response


@router.get("/api", include_in_schema=False)
async def interface(request: APIRequest) -> Response:
    """Return the description of the interface."""
    return Response(_description(request.app.openapi()), media_type="text/html")


@router.get("/api/catalogue", tags=["catalogue"])
async def describe(request: APIRequest) -> Response:
    """Return kinds of problem, their forms with units and ranges, outputs, grades."""
    body, compressed, tag = await asyncio.to_thread(_encoded_catalogue)
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers={"etag": tag})
    headers = {"etag": tag, "cache-control": "no-cache", "vary": "accept-encoding"}
    if "gzip" in request.headers.get("accept-encoding", ""):
        body, headers["content-encoding"] = compressed, "gzip"
    return Response(body, headers=headers, media_type="application/json")


@cache
def _encoded_catalogue() -> tuple[bytes, bytes, str]:
    """Return the catalogue as JSON, compressed, and its entity tag."""
    body = to_json(catalogue())
    return body, gzip.compress(body, 6, mtime=0), f'"{hashlib.sha256(body).hexdigest()[:32]}"'


# ---- one case: its solution, its tables, its variations ------------------------------------------


@router.post("/api/solve", tags=["states"])
async def solve(request: APIRequest, case: Case, query: Annotated[SolveQuery, Query()]) -> Response:
    """Solve a case.  Other fields of the query are options of the solver: ``?nodes=129``."""
    args = (case, query.options, request.session_name, query.warm, query.report, query.drawn)
    return await request.answered(computations.solve, *args, pool=request.workers.solvers)


@router.post("/api/grade", tags=["states"])
async def grade(request: APIRequest, body: GradeRequest) -> Response:
    """Return the tables of a case with the web, friction and limits of a grade."""
    args = (body.case, body.grade)
    return await request.answered(computations.with_grade, *args, pool=request.workers.solvers)


@router.post("/api/design", tags=["states"])
async def design(request: APIRequest, body: DesignRequest) -> Response:
    """Find the tension over the radius that gives a wound roll a target pressure."""
    args = (body.case, body.pressure, body.rtol)
    return await request.answered(computations.design, *args, pool=request.workers.solvers)


@router.post("/api/curve", tags=["states"])
async def curve(request: APIRequest, case: Case, query: Annotated[CurveQuery, Query()]) -> Response:
    """Return outputs against one field around a case."""
    return await request.answered(computations.curve, case, query.model_dump(), query.options)


@router.post("/api/sensitivities", tags=["states"])
async def sensitivities(
    request: APIRequest, case: Case, query: Annotated[SolverQuery, Query()]
) -> Response:
    """Return the derivatives of the outputs with respect to each field."""
    return await request.answered(computations.sensitivities, case, query.options, rank=LATER)


@router.post("/api/find", tags=["states"])
async def find(request: APIRequest, body: FindRequest) -> Response:
    """Find the values of a field for which an output reaches a target."""
    args = (body.case, body.field, body.output, body.target, body.between)
    return await request.answered(computations.find, *args)


# ---- studies, which stream their events ----------------------------------------------------------


@router.post("/api/sweep", tags=["studies"])
async def sweep(request: APIRequest, study: Study) -> Response:
    """Solve a study; its events are streamed, one line of JSON each."""
    pool, tables = request.workers.cases, study.model_dump(exclude_unset=True)
    started = await request.computed(pool, study_stream.start_sweep, tables)
    return _streamed(_of_session(request, study_stream.sweep(pool, started, request.session_name)))


@router.post("/api/fit", tags=["studies"])
async def fit(request: APIRequest, body: FitRequest) -> Response:
    """Fit one or two fields to a table of measured values; events as those of a study."""
    args = (request.workers.cases, body.model_dump(), request.session_name)
    return _streamed(_of_session(request, study_stream.fit(*args)))


@router.post("/api/window", tags=["studies"])
async def window(request: APIRequest, body: WindowRequest) -> Response:
    """Map the probability that a roll keeps its limits; events as those of a study."""
    if request.workers.window.locked():
        raise RequestError(503, "busy", "another operating window is being computed")

    async def lines() -> AsyncIterator[bytes]:
        """Yield the events while no other window can be computed."""
        async with request.workers.window:
            study = study_stream.window(body.model_dump())
            async for line in study_stream.event_lines(study, request.is_disconnected):
                yield line

    return _streamed(lines())


@router.post("/api/cancel", tags=["studies"])
async def cancel(request: APIRequest) -> dict[str, bool]:
    """Stop the study of the session in the header X-Session."""
    return {"cancelled": request.workers.stop_study(request.session_name)}


async def _of_session(request: APIRequest, study: study_stream.Lines) -> AsyncIterator[bytes]:
    """Yield the events of a study; an older study of the same session is stopped."""
    workers, session, stopped = request.workers, request.session_name, asyncio.Event()
    workers.stop_study(session)
    if session:
        workers.studies[session] = stopped
    try:
        args = (study, request.is_disconnected, stopped, LIMITS["study_seconds"])
        async for line in study_stream.event_lines(*args):
            yield line
    finally:
        if workers.studies.get(session) is stopped:
            del workers.studies[session]


def _streamed(lines: AsyncIterator[bytes]) -> Response:
    return StreamingResponse(lines, media_type="application/x-ndjson")


# ---- files, reports and figures ------------------------------------------------------------------


@router.post("/api/case/read", tags=["documents"])
async def read_case(request: APIRequest, text: CaseText) -> Response:
    """Return the tables of the text of a case file, complete and in SI."""
    return await request.answered(documents.read_case, text.toml, rank=LATER)


@router.post("/api/case/write", tags=["documents"])
async def case_file(request: APIRequest, case: Case) -> Response:
    """Return the case file of a case, with comments."""
    return await request.answered(documents.case_file, case, rank=LATER, media_type="text/plain")


@router.post("/api/python", tags=["documents"])
async def python_text(request: APIRequest, case: Case) -> Response:
    """Return the Python script that computes a case."""
    return await request.answered(documents.python_text, case, rank=LATER, media_type="text/plain")


@router.post("/api/file", tags=["documents"])
async def result_file(
    request: APIRequest, case: Case, query: Annotated[FileQuery, Query()]
) -> Response:
    """Return the solved case as a result file."""
    args, name = (case, query.format, query.options), f"result.{query.format}"
    return await request.answered(documents.result_file, *args, rank=LATER, file_name=name)


@router.post("/api/report", tags=["documents"])
async def report(request: APIRequest, cases: Cases) -> Response:
    """Return the report of solved cases as a self-contained HTML file."""
    args = (documents.report, cases.model_dump())
    return await request.answered(*args, rank=LATER, media_type="text/html")


@router.post("/api/figure", tags=["documents"])
async def figure(
    request: APIRequest,
    cases: Cases,
    format: Annotated[str, Query(pattern="^(svg|png|pdf)$")] = "svg",
    panels: str = "",
) -> Response:
    """Return a figure of one case or of several cases."""
    args = (cases.model_dump(), format, [name for name in panels.split(",") if name])
    name = f"figure.{format}"
    return await request.answered(documents.figure, *args, rank=LATER, file_name=name)


@router.get("/api/thesis/{name}", tags=["documents"])
async def exhibit(request: APIRequest, name: str) -> Response:
    """Compute a figure that the catalogue names among its exhibits."""
    args = (documents.exhibit, name)
    return await request.answered(*args, rank=LAST, media_type=MEDIA_TYPES["svg"])


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

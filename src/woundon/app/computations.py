"""Computations of the page, from the tables of a case: functions that run in workers.

The tables of a case are its fields as in a case file; a solved case is a state.  The functions take
parsed JSON and return JSON.  Errors are those of :mod:`woundon.errors`;
:mod:`.request_errors` translates them into HTTP.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from math import isinf
from typing import Any

import numpy as np

from .. import kinds
from ..arguments import keywords_of
from ..errors import InvalidProblem, did_you_mean, unwarned
from ..io.case_files import check_like_a_case, make_problem
from ..problems.bodies import Body
from ..problems.messages import quote
from ..problems.paths import find_places, varied_number
from ..problems.permitted import extremes
from ..problems.problem import Problem
from ..quantities import scalar_outputs, value_of, walk
from ..report.answer import answer_lines, main_outputs
from ..report.report_parts import Section, certificate_of, friction_bounds, zone_strips
from ..report.result_report import report_parts
from ..results import ACCEPTED_RESIDUAL, Result, zone_runs
from ..roll.design import design_tension
from ..studies.api import range_in_si
from ..studies.cases import Chunk
from ..studies.column_names import measurable_outputs
from ..studies.find import find as find_values
from ..studies.model import KindModel, model_of, quantities_of
from ..studies.run import solve_chunk
from ..studies.slopes import derivatives
from ..winding.margins import FIELDS, Margin
from .input_forms import quantity_schema, tables_of
from .json_texts import records, to_json
from .plot_data import panel_data, slow_panel_data

__all__ = [
    "curve",
    "design",
    "find",
    "problem_of",
    "sensitivities",
    "solve",
    "solved",
    "warm_up",
    "with_grade",
]

# While a slider moves: a third of the time of a converged solve; curves differ by less than a line
# width.
WARM_OPTIONS = {"nodes": 49, "errors": False}
WARM_UP = 1.0  # seconds after which no further example is solved
DERIVATIVES = ("outputs", "parameters", "elasticities", "derivatives", "zone_change")
DESIGNED = ("radius", "target_pressure", "pressure", "outer_layer", "surface_deviation")
MOST_OUTPUTS = 6  # of kinds without main outputs
MOST_SESSIONS = 32  # whose last results are kept as initial guesses
# by session: the last result, and the problem and options that it solves without a warm start
_LAST: OrderedDict[str, tuple[Any, Any]] = OrderedDict()


def problem_of(tables: Mapping[str, Any]) -> Problem:
    """Return the problem of a case's tables from JSON.

    Raises
    ------
    InvalidProblem
        Also for tables that name files, which are on the client's machine.
    """
    check_like_a_case(tables)  # size and depth
    return make_problem(tables)  # files are read by the reader of case files only


def warm_up() -> None:
    """Solve examples, which imports modules and fills caches.

    Windings are omitted, because each worker would need seconds for them.
    """
    began = time.perf_counter()
    for kind in kinds.every():
        slow = "coupling_rtol" in keywords_of(kind.solver)  # iterates over nips and rolls
        if not slow and time.perf_counter() - began < WARM_UP:
            with suppress(InvalidProblem):
                state_of(solved(kind.example(), {}))


# ---- one state --------------------------------------------------------------------------------


def solve(
    tables: Mapping[str, Any],
    options: Mapping[str, Any],
    session: str = "",
    warm: bool = False,
    report: bool = False,
    drawn: bool = False,
) -> bytes:
    """Return the solved state of a case, as JSON; see :func:`state_of`.

    ``warm`` starts from the last result of the session, on few nodes and without error estimates
    where the solver permits: for a figure that follows a slider.  A case that the session has
    solved last is not solved again, for instance for its ``report``.
    """
    began = time.perf_counter()
    problem = problem_of(tables)
    previous, solution_of = _LAST.get(session, (None, None))
    if not warm and solution_of == (problem, options):
        result = previous
    else:
        result = solved(problem, options, previous if warm else None, warm=warm)
    if session:
        _LAST[session] = result, None if warm else (problem, options)
        _LAST.move_to_end(session)
        if len(_LAST) > MOST_SESSIONS:
            _LAST.popitem(last=False)
    answer = state_of(result, report, drawn)
    answer["seconds"] = time.perf_counter() - began
    return to_json(answer)


def solved(
    problem: Problem, options: Mapping[str, Any], start: Result | None = None, warm: bool = False
) -> Any:
    """Return the result of a problem, which contains its warnings.

    Parameters
    ----------
    problem : Problem
    options : mapping
        Of the solver; they take precedence over those of ``warm``.
    start : Result, optional
        Initial guess.
    warm : bool
        Solve quickly, on few nodes and without error estimates, where the solver has these options.
    """
    kind = kinds.of(problem)
    options = checked_options(kind, options)
    if warm and "errors" in keywords_of(kind.solver):
        options = WARM_OPTIONS | options
    model = KindModel(problem, outputs=(), options=options)
    with unwarned():
        return model.solve(problem, start)


def checked_options(kind: kinds.Kind, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options of a kind's solver, converted from text.

    Raises
    ------
    InvalidProblem
        For an unknown option, or a text that is not a number.
    """
    if not options:
        return {}  # the type hints of the solver are not read for each move of a slider
    known, converted = kind.solver_options(), dict[str, Any]()
    for name, text in options.items():
        if name not in known:
            reason = f"no option of the kind {kind.name!r}; it has {', '.join(known) or 'none'}"
            raise InvalidProblem.at(name, reason)
        number_type = known[name].type
        try:
            converted[name] = number_type(text)
        except (TypeError, ValueError):  # TypeError: of an option that is given twice
            must = f"must be a {'whole ' * (number_type is int)}number"
            reason = f"{quote(text)} is out of place; {must}"
            raise InvalidProblem.at(name, reason) from None
    return converted


def state_of(result: Result, report: bool = False, drawn: bool = False) -> dict[str, Any]:
    """Return a result for JSON, SI units.

    ``report`` adds the sections of the report; ``drawn`` returns the panels of the page instead of
    the arrays, the slow ones with the report.
    """
    parts = report_parts(result) if report else []
    slow = {"slow_panels": slow_panel_data(result)} if report and drawn else {}
    return {
        "kind": kinds.of(result).name,
        "problem": tables_of(result.problem),
        "outputs": {
            name: {"value": value_of(result, name), "error": result.errors.get(name)}
            for name in scalar_outputs(result)
        },
        **({"panels": panel_data(result), **slow} if drawn else _arrays(result)),
        "answer": [line.text for line in answer_lines(result, full=report)],
        "headline": [
            {"name": name, "words": words} for name, words in main_outputs(result).items()
        ],
        "certificate": _certificate(result),
        "margins": [_margin(margin) for margin in getattr(result, "margins", ())],
        "warnings": [*getattr(result.problem, "input_warnings", ()), *result.warnings],
        "geometry": _geometry(result),
        "sections": [_section(part) for part in parts if isinstance(part, Section)],
    }


def _certificate(result: Result) -> dict[str, Any]:
    """Return the certificate of a result for JSON."""
    line = certificate_of(result)
    return {
        "ok": bool(result.residuals.largest <= ACCEPTED_RESIDUAL),
        "residual": result.residuals.largest,
        "conditions": dict(result.residuals.items()),
        "text": line.text,
    }


# by margin the field of its limit
LIMIT_FIELDS = {name: f"limits.{field}" for name, field in FIELDS.items()} | {
    "slip": "limits.torque_share"
}


def _margin(margin: Margin) -> dict[str, Any]:
    """Return a margin of a winding for JSON."""
    names = ("name", "title", "hint", "value", "limit", "radius", "ok", "note")
    values = {name: getattr(margin, name) for name in names}
    field = LIMIT_FIELDS.get(margin.name)
    return values | {"quantity": quantity_schema(margin.quantity), "limit_field": field}


def _section(section: Section) -> dict[str, Any]:
    """Return a section of a report for JSON."""
    names = ("symbol", "value", "unit", "value_text", "error_text", "note")
    rows = [
        {"label": row.meaning, **{name: getattr(row, name) for name in names}}
        for row in section.rows
    ]
    return {"title": section.title, "text": section.text, "rows": rows}


def _arrays(result: Result) -> dict[str, Any]:
    """Return all arrays of a result, with the nodes of the nip, zones and friction bounds.

    ``nip`` are the indices of its first and last node; nodes on wraps are outside.  The runs of a
    face are those of :func:`.zone_runs`: (zone, from, to) [m].
    """
    arrays = {p.path: p.value for p in walk(result) if isinstance(p.value, np.ndarray)}
    strips = zone_strips(result)
    if strips is None:
        return {"arrays": arrays, "nip": None, "zones": [], "zone_words": {}, "bounds": []}
    nip = getattr(result, "in_nip", slice(0, len(strips.x)))
    runs = [zone_runs(strips.x, zones) for zones in strips.faces.values()]
    bounds = friction_bounds(result)
    return {
        "arrays": arrays,
        "nip": (nip.start, nip.stop - 1),
        "zones": records(name=strips.faces, runs=runs),
        "zone_words": {str(zone): word for zone, word in strips.words.items()},
        "bounds": records(of=bounds, values=bounds.values()),
    }


def _geometry(result: Result) -> dict[str, Any]:
    """Return the geometry for a drawing to scale [m, rad]."""
    problem = result.problem
    web = getattr(problem, "web", None)
    scalars = {name: getattr(result, name, None) for name in ("half_width", "offset", "approach")}
    wraps = {name: getattr(problem, name, None) for name in ("roll_wrap", "drum_wrap")}
    return {
        "bodies": [_body(name, getattr(problem, name)) for name in getattr(problem, "pair", ())],
        "web": None if web is None else {"thickness": web.thickness},
        **wraps,
        **scalars,
    }


def _body(name: str, body: Body) -> dict[str, Any]:
    """Return radius, layers and core of a body for the drawing of the nip."""
    deep = not body.rigid and isinf(body.thickness)  # a half-plane
    layers = getattr(body, "layers", None)
    if layers is None and not (body.rigid or deep):
        layers = [body]  # a single layer, with the thickness of the body
    return {
        "name": name,
        "radius": body.radius,
        "rigid": body.rigid,
        "deep": deep,
        "core": None if body.rigid or deep else getattr(body, "core", "rigid"),
        "layers": [{"thickness": layer.thickness} for layer in layers or ()],
    }


def with_grade(tables: Mapping[str, Any], name: str) -> bytes:
    """Return the tables of a case with all values that a grade supplies, as JSON."""
    problem = problem_of(tables)
    with unwarned():
        changed = problem.replace(grade=name)
    return to_json({"kind": kinds.of(changed).name, "problem": tables_of(changed)})


# ---- inverse problems -------------------------------------------------------------------------


def design(tables: Mapping[str, Any], pressure: Any, rtol: float) -> bytes:
    """Return the tension over the radius that gives a wound roll a target pressure, as JSON.

    ``pressure`` and ``rtol``, the tolerance of the pressure, are as those of
    :class:`.request_models.DesignRequest`.
    """
    problem: Any = problem_of(tables)  # design_tension rejects other kinds
    solution = design_tension(problem, pressure, rtol=rtol)
    return to_json(
        {
            "tension": tables_of(solution.tension),
            **{name: getattr(solution, name) for name in DESIGNED},
        }
    )


def find(
    tables: Mapping[str, Any],
    field: str,
    output: str,
    target: float | str,
    between: Sequence[float | str] | None,
) -> bytes:
    """Return the values of a field for which an output reaches a target, as JSON.

    ``solutions`` are in ascending order; ``values`` and ``outputs`` are the points of the search;
    ``unconfirmed`` are solutions that only the result for a neighbouring value leads to.
    """
    problem = problem_of(tables)
    if output not in (known := measurable_outputs(problem)):
        text = f"{quote(output)} is not an output{did_you_mean(output, known)}"
        raise InvalidProblem.at("output", text)
    aim: dict[str, Any] = {output: target}
    with unwarned():
        outcome = find_values(problem, field, between=between, **aim)
    return to_json(
        {
            "field": field,
            "output": output,
            "target": outcome.target,
            "solutions": records(
                value=[value for value, _ in outcome.solutions],  # pairs of value and result
                reached=outcome.reached,
                uncertainty=outcome.uncertainties,
                slope=outcome.slopes,
            ),
            "values": outcome.values,
            "outputs": outcome.outputs,
            "failures": _failures(outcome.failures),
            "unconfirmed": _failures(outcome.unconfirmed),
        }
    )


def _failures(reasons: Iterable[tuple[float, str]]) -> list[dict[str, Any]]:
    """Return the values of a field that were not solved or confirmed, with the reason, for JSON."""
    return [{"value": value, "why": reason} for value, reason in reasons if reason]


# ---- around a state ---------------------------------------------------------------------------


def curve(tables: Mapping[str, Any], query: Mapping[str, Any], options: Mapping[str, Any]) -> bytes:
    """Return outputs against one field around a case, as JSON.

    ``query`` is as :class:`.request_models.CurveQuery`.  Each solve starts from the previous one.
    By default from 0.5 to 1.5 times the field's value.
    """
    problem, field, points = problem_of(tables), query["field"], query["points"]
    base = varied_number(problem, field)
    names = tuple(filter(None, query["outputs"].split(","))) or _usual_outputs(problem)
    options = checked_options(kinds.of(problem), options)
    model = model_of(problem, names, tie={}, options=options)
    ends = _ends(problem, field, base, query["low"], query["high"])
    values = np.linspace(*ends, points).tolist()
    inputs = [{field: value} for value in values]
    chunk = Chunk(number=0, cases=np.arange(points), inputs=inputs)
    solved_cases = solve_chunk(model, chunk)
    return to_json(
        {
            "field": field,
            "unit": quantities_of(model, [field])[field].unit,
            "at": base,
            "values": values,
            "outputs": dict(zip(names, solved_cases.values.T, strict=True)),
            "failures": _failures(zip(values, solved_cases.failure, strict=True)),
        }
    )


def _usual_outputs(problem: Problem) -> tuple[str, ...]:
    """Return the main outputs of a problem's kind, and of a nip its tensions.

    The first :data:`MOST_OUTPUTS` outputs of a kind without main ones.
    """
    known = measurable_outputs(problem)
    tensions = ("nip_induced_tension", "outlet_tension")
    main = kinds.of(problem).result.MAIN
    names = dict.fromkeys((*main, *(name for name in tensions if name in known)))
    return tuple(names or list(known)[:MOST_OUTPUTS])


def _ends(
    problem: Problem, field: str, base: float, low: float | None, high: float | None
) -> tuple[float, float]:
    """Return the ends of the range of a curve.

    Parameters
    ----------
    problem, field, base
        The case, the varied field, and its value in the case [SI].
    low, high : float, optional
        The requested ends; by default half the value below and above it, and for a value of 0 half
        of the usual range of the field, within the permitted range.

    Raises
    ------
    InvalidProblem
        If ``low`` is not less than ``high``, or the field does not permit one of them.
    """
    place = find_places(problem, field)[0]
    smallest, largest = (place.quantity.typical if place.quantity else None) or (-1.0, 1.0)
    half = abs(base) / 2 or (largest - smallest) / 2
    least, most = extremes(place.field)
    usual = max(base - half, least), min(base + half, most)
    if low is None and high is None:
        return usual  # another field may not permit an end, which is then a failure of the curve
    return range_in_si(
        problem, field, (usual[0] if low is None else low, usual[1] if high is None else high)
    )


def sensitivities(tables: Mapping[str, Any], options: Mapping[str, Any]) -> bytes:
    """Return the derivatives of the outputs by field, the largest elasticity first, as JSON.

    Exact if results of the kind have ``sensitivity``, else by central differences on one grid.
    """
    problem = problem_of(tables)
    result = solved(problem, options)
    is_exact = hasattr(result, "sensitivity")
    # the options are those of the differences; exact derivatives are those of the solved equations
    used = {} if is_exact else checked_options(kinds.of(problem), options)
    largest_first = derivatives(result, **used).sorted()
    return to_json(
        {
            "method": "exact" if is_exact else "differences",
            **{name: getattr(largest_first, name) for name in DERIVATIVES},
        }
    )

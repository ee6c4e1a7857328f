"""Results as text: for each kind what matters, its zones, other theories, and the certificate.

:func:`report_text` is what ``print(result)`` says.  A kind's report is a function from a result to
parts (:mod:`.parts`), found through :mod:`woundon.kinds`; warnings and certificate end every one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from io import StringIO
from math import isinf, isnan
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.text import Text

from .. import kinds, quantities, theories
from ..errors import InvalidProblem, NoSteadyState, NotConverged, unwarned
from ..nip.result import NipResult
from ..nip.roller_result import RollerResult
from ..problems.bodies import Body
from ..problems.description import Description
from ..problems.nip import NipProblem
from ..problems.stack import Stack
from ..problems.wound_roll import WoundRoll
from ..quantities import Quantity
from ..results import Result
from .parts import (
    Line,
    Part,
    Row,
    Section,
    field_row,
    nip_zones,
    output_row,
    roller_zones,
    row_of,
)
from .terminal import WIDTH, print_columns

if TYPE_CHECKING:
    from ..nip.sensitivity import Sensitivity

__all__ = [
    "LEAST_FRICTION", "field_rows", "nip_report", "outputs_report", "plain_console",
    "print_sensitivity", "roller_report", "rows_of", "sensitivity_text",
]  # fmt: skip


def plain_console(paper: StringIO) -> Console:
    """Return what writes plain text, as wide as reports are."""
    return Console(
        file=paper, width=WIDTH, color_system=None, legacy_windows=False,
        force_jupyter=False,  # or the text would be shown in a notebook, and not be returned
    )  # fmt: skip


# Below, a friction coefficient does not differ from 0: the air film carries the nip load.
LEAST_FRICTION = 1e-3
# told by another name, at the end, where they say something, or not at all
LEFT_OUT = frozenset({
    "residual", "half_width", "inlet_tension", "drum_wrap_traction",
    "creepage", "shift", "tangential_load", "traction_error",
    "iterations", "series_terms", "series_error",
})  # fmt: skip


def rows_of(
    result: Result, names: list[str], leave: Iterable[str] = LEFT_OUT, **notes: str
) -> tuple[Row, ...]:
    """Return the rows of the outputs named, then of all that nobody here knows of.

    Those to ``leave`` are left out; ``notes`` stand behind the units, by name.
    """
    shown_elsewhere = {f"{name}_error" for name in result.errors} | _no_friction(result)
    others = [
        name
        for name in quantities.scalar_outputs(result)
        if name not in leave and name not in shown_elsewhere and name not in names
        and not _is_nan(quantities.value_of(result, name))  # what it does not have, as no speed
    ]  # fmt: skip
    return tuple(output_row(result, name, note=notes.get(name, "")) for name in names + others)


def _no_friction(result: Result) -> set[str]:
    """Return the friction coefficients of an air film that are 0 for all practical purposes."""
    names = ("air.roll_friction", "air.wrap_friction")
    film = getattr(result, "air", None)
    return {name for name in names if film is not None
            and quantities.value_of(result, name) < LEAST_FRICTION}  # fmt: skip


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and isnan(value)


# ---- the nip ------------------------------------------------------------------------------------

NIP = ["nip_width", "peak_pressure", "approach", "offset", "drum_creepage", "leading_roll",
       "trailing_roll", "dual"]  # fmt: skip
HELD = "Winding nip, the web held at its trailing edge"
WRAPPED = "Winding nip, the web wrapped on the roll"
HELD_NOTE = (
    "The web is held to the roll at the trailing edge (thesis eq. 97), which underestimates the "
    "wound-on tension of a web that is wrapped on the roll: set roll_wrap to compute it."
)
# wound-on tension and wraps, of a nip that has some
OF_WRAPS = frozenset({
    "wound_on_tension", "inlet_tension", "roll_wrap_traction", "drum_wrap_traction",
    "slip_angle",
})  # fmt: skip


def nip_report(result: NipResult) -> list[Part]:
    """Return the report of a nip; with a roll wrap, also of the same nip without wraps."""
    problem = result.problem
    rows, wraps = _tension_rows(result), tuple(_wraps(problem))
    return [
        _how(result),
        *_hardening(problem),
        Section("Loads and wraps" if wraps else "Loads", (*_loads(result), *wraps)),
        Section(
            WRAPPED if problem.roll_wrap else HELD, rows,
            "" if problem.is_wrapped else HELD_NOTE,
        ),
        nip_zones(result),
        *_held_at_the_edge(result),
        *_layer_slip(result),
        *_other_theories(result),
    ]  # fmt: skip


def _wraps(problem: NipProblem) -> Iterator[Row]:
    """Yield the wrap angles and the friction on the wrap, of those that there are."""
    if problem.is_wrapped:
        yield field_row(problem, "roll_wrap")
    if problem.drum_wrap:
        yield field_row(problem, "drum_wrap")
    if problem.roll_wrap and problem.wrap_friction is not None:
        yield field_row(problem, "wrap_friction")


def _tension_rows(result: NipResult) -> tuple[Row, ...]:
    level = _level(result)
    if not result.problem.is_wrapped:
        names = ["nip_induced_tension", "outlet_tension"]
        return rows_of(result, names + NIP, LEFT_OUT | OF_WRAPS, approach=level)
    on_drum = ["inlet_tension", "drum_wrap_traction"] if result.problem.drum_wrap else []
    names = ["wound_on_tension", "nip_induced_tension", "outlet_tension", *on_drum,
             "roll_wrap_traction", "slip_angle"]  # fmt: skip
    way = f", web {result.slip_zone.word}" if result.slip_zone else ""
    return rows_of(result, names + NIP, approach=level, slip_angle=way)


def _how(result: NipResult) -> Line:
    return Line(f"{result.nodes} nodes in the nip, {result.iterations} Newton iterations", "quiet")


def _hardening(problem: NipProblem) -> Iterator[Line]:
    """Say of a nip with a stack in it whether the nip's pressure hardens roll and web."""
    if isinstance(problem.roll, WoundRoll) or isinstance(problem.web.material, Stack):
        told = (f"the {name} {'does not harden' if part.linear else 'hardens'}"
                for name, part in (("roll", problem.roll), ("web", problem.web)))  # fmt: skip
        yield Line(f"under the nip's pressure {', '.join(told)}", "quiet")


def _loads(result: NipResult) -> tuple[Row, ...]:
    moving = [] if result.problem.web_speed is None else ["web_speed"]
    names = ("nip_load", "winding_force", "web_tension", *moving)
    return tuple(field_row(result.problem, name) for name in names)


def _level(result: NipResult) -> str:
    """Return what is to be said of an approach: that of a half-plane has no fixed level."""
    return _up_to_a_constant(result.problem.roll, result.problem.drum)


def _up_to_a_constant(*bodies: Body) -> str:
    return ", up to a constant" if any(_deep(body) for body in bodies) else ""


def _deep(body: Body) -> bool:
    return not body.rigid and isinf(body.thickness)


LAYERS = "Slip between the layers of the roll, which the model takes as bonded"


def _layer_slip(result: NipResult) -> Iterator[Part]:
    """Yield the index of slip between the layers, where interior stresses are known."""
    with unwarned():
        slip = result.layer_slip
    if slip is None:
        return
    names = ("ratio", "layers", "depth", "width") if slip.layers else ("ratio",)
    places = ((name, quantities.output(slip, name)) for name in names)
    rows = tuple(row_of(place.quantity, getattr(slip, name)) for name, place in places
                 if place is not None and place.quantity is not None)  # fmt: skip
    yield Section(LAYERS, rows, f"warning: {slip.warning}" if slip.warning else "")


def _held_at_the_edge(result: NipResult) -> Iterator[Section]:
    """Yield a section on the same nip without its wraps, solved with as many nodes."""
    if result.problem.roll_wrap == 0:
        return  # held there already
    title = "The same nip, its web held at the trailing edge"
    try:
        with unwarned():
            nip = kinds.solve(
                result.without_air.replace(roll_wrap=0.0, drum_wrap=0.0), nodes=result.nodes
            )
    except NoSteadyState as fault:
        yield Section(title, (), f"Has no steady state: {fault}")
        return
    except (InvalidProblem, NotConverged) as fault:
        yield Section(title, (), f"Was not solved: {fault}")
        return
    rows = (
        output_row(
            nip, "outlet_tension", meaning="web tension at the trailing edge of the nip, eq. (97)"
        ),
    )
    yield Section(title, rows)


# ---- two rollers --------------------------------------------------------------------------------


def roller_report(result: RollerResult) -> list[Part]:
    """Return the report of two rollers."""
    problem, rolling = result.problem, result.problem.motion == "rolling"
    given = "creepage" if problem.creepage is not None else "tangential_load"
    moving = [] if problem.speed is None else ["speed"]
    names = ("load", given, "friction", *moving)
    loads = (field_row(problem, name, empty=0.0) for name in names)
    how = f"{problem.motion} contact, {result.nodes} nodes, {result.iterations} linear systems"
    return [
        Line(how, "quiet"),
        Section("Loads", tuple(loads)),
        Section("Rolling contact" if rolling else "Static contact", _roller_rows(result)),
        roller_zones(result),
        *_roller_theories(result),
    ]


def _roller_rows(result: RollerResult) -> tuple[Row, ...]:
    problem = result.problem
    found = "creepage" if problem.motion == "rolling" else "shift"
    names = ["tangential_load" if problem.creepage is not None else found, "nip_width",
             "peak_pressure", "approach", "offset", "slip_share"]  # fmt: skip
    if not isnan(result.traction_error):
        names.append("traction_error")
    level = _up_to_a_constant(problem.upper, problem.lower)
    return rows_of(result, names, approach=level, shift=level)


# ---- other theories, where they apply -----------------------------------------------------------


def _other_theories(result: NipResult) -> Iterator[Section]:
    """Yield closed forms of a nip; those of the tension take the solved approach and zones."""
    rows = [
        output_row(result, "nip_induced_tension", value, meaning=label)
        for label, value in _rival_tensions(result)
    ]
    rows += _hertz(result, "Hertz (half-planes, no web)")
    if rows:
        yield Section("Other theories", tuple(rows))


def _rival_tensions(result: NipResult) -> Iterator[tuple[str, float]]:
    problem = result.problem
    if problem.drum_wrap or problem.air:
        return  # they know of no winding force but the nip's
    yield "friction limit mu+ P + F (upper bound)", theories.friction_limit(problem)
    if result.dual:
        dual = float(theories.dual_slip(problem, result.dual))
        yield "dual-slip formula, with the solved dual slip", dual
    if not (_deep(problem.roll) or _deep(problem.drum)):
        jalkanen = theories.jalkanen(problem, result.approach)
        yield "Jalkanen, with the solved approach", jalkanen


def _hertz(result: NipResult | RollerResult, label: str) -> list[Row]:
    if result.problem.viscoelastic:
        label += ", all relaxed"
    try:
        contact = theories.hertz(result.problem)
    except InvalidProblem:  # a body of no linear elastic material
        return []
    return [
        output_row(result, "nip_width", 2 * contact.half_width, meaning=label),
        output_row(result, "peak_pressure", contact.peak_pressure, meaning=label),
    ]


def _roller_theories(result: RollerResult) -> Iterator[Section]:
    elastic = not result.problem.viscoelastic
    rows = [*_partial_slip(result), *_free_rolling(result)] if elastic else []
    rows += _hertz(result, "Hertz (half-planes)")
    if rows:
        yield Section("Closed forms", tuple(rows))


def _partial_slip(result: RollerResult) -> Iterator[Row]:
    """Yield Carter's or Cattaneo's answer, where the rollers are elastically similar."""
    rolling = result.problem.motion == "rolling"
    name, theory = ("Carter", theories.carter) if rolling else ("Cattaneo", theories.cattaneo)
    try:
        found = theory(result.problem)
    except InvalidProblem:
        return
    label = f"{name} (similar half-planes)"
    if rolling and result.problem.creepage is None:
        yield output_row(result, "creepage", found.creepage, meaning=label)
    if rolling and result.problem.creepage is not None:
        yield output_row(result, "tangential_load", found.tangential_load, meaning=label)
    share = 1 - found.stick_half_width / found.half_width
    yield output_row(result, "slip_share", share, meaning=label)


def _free_rolling(result: RollerResult) -> Iterator[Row]:
    """Yield the limits of Bentall and Johnson, where dissimilar rollers roll freely."""
    problem = result.problem
    if problem.motion != "rolling" or problem.creepage is not None or problem.tangential_load:
        return
    try:
        stick = theories.bentall_johnson_stick(problem)
        slip = theories.bentall_johnson_frictionless(problem)
    except InvalidProblem:
        return
    if stick.oscillation:  # similar ones roll freely without creepage
        for value, without in ((slip, "friction"), (stick.creepage, "slip")):
            label = f"Bentall and Johnson (half-planes), without {without}"
            yield output_row(result, "creepage", value, meaning=label)


# ---- any kind -----------------------------------------------------------------------------------


def outputs_report(result: Result) -> list[Part]:
    """Return a report of any kind: the problem's fields, all outputs that are single numbers."""
    kind = kinds.of(result)
    title = kind.name.replace("_", " ").capitalize()
    errors = {f"{name}_error" for name in result.errors}  # told beside their outputs already
    rows = (
        output_row(result, name)
        for name in quantities.scalar_outputs(result)
        if name != "residual" and name not in errors
    )
    return [
        Section(f"{title}: problem", tuple(field_rows(result.problem))),
        Section(f"{title}: result", tuple(rows)),
    ]


def field_rows(
    problem: Description, under: str = "", of_field: Quantity | None = None
) -> Iterator[Row]:
    """Yield every field of a description, nested ones by dotted name.

    ``of_field`` is the quantity of the field that holds the description, as a schedule.
    """
    for name in type(problem).model_fields:
        value = getattr(problem, name)
        quantity = quantities.find(problem, name, of_field)[0].quantity
        items = enumerate(value) if isinstance(value, tuple) else ()
        inner = [(f"{under}{name}.{k}", v) for k, v in items if isinstance(v, Description)]
        inner += [(f"{under}{name}", value)] if isinstance(value, Description) else []
        for path, part in inner:
            yield Row(path, "", type(part).__name__)
            yield from field_rows(part, f"{path}.", quantity)
        if not inner and value is not None:
            yield _field(name, value, under, quantity)


def _field(name: str, value: Any, under: str, quantity: Quantity | None) -> Row:
    if quantity is None or not isinstance(value, (int, float)):
        return Row(f"{under}{name}", "", str(value))
    row = row_of(quantity, value)
    # the name that --set takes; the meaning of a nested field would not say whose it is
    return replace(row, meaning=f"{under}{name}") if under else row


# ---- sensitivities ------------------------------------------------------------------------------


def sensitivity_text(sensitivity: Sensitivity) -> str:
    """Return elasticities as plain text, as the command line prints them."""
    paper = StringIO()
    print_sensitivity(sensitivity, plain_console(paper))
    return paper.getvalue().strip("\n")


def print_sensitivity(sensitivity: Sensitivity, console: Console) -> None:
    """Print elasticities, what matters most for the first output first."""
    ordered = sensitivity.sorted()
    known: dict[str, quantities.Quantity] = {}
    for kind in kinds.every():  # the same name means the same in all of them
        known = {**quantities.scalar_outputs(kind.result), **known}
    # the width's elasticities are the half width's
    told = [k for k, name in enumerate(ordered.outputs) if name != "half_width"]
    head = ["", "value [SI]", *(known[ordered.outputs[k]].symbol for k in told)]
    table = [
        [name, f"{field:.5g}", *(f"{_rounded(value):+.4f}" for value in values)]
        for name, field, values in zip(
            ordered.parameters, ordered.fields, ordered.elasticities[told].T, strict=True
        )
        if field
    ]
    widths = [max(32, *map(len, ordered.parameters)), 10, *(9 for _ in told)]
    console.print(Text("\nElasticities: percent of output per percent of field", style="bold"))
    print_columns([head, *table], widths, "<" + ">" * len(head), console)
    for name, field in zip(ordered.parameters, ordered.fields, strict=True):
        if not field:  # no percent of it; what it does all the same
            main = ordered.outputs[0]
            slope, symbol = ordered.derivative(main, name), known[main].symbol
            quantity = quantities.find(NipProblem, name)[0].quantity
            unit = "unit" if quantity is None else quantity.unit.replace("1", "unit")
            text = f"{name} is 0: {symbol} changes by {slope:+.4g} N/m per {unit} of it"
            console.print(Text(text))
    if ordered.zone_change:
        text = f"warning: at a zone change ({ordered.zone_change}): one-sided derivatives differ"
        console.print(Text(text, style="bold yellow"))


def _rounded(value: float) -> float:
    return float(np.round(value, 4)) + 0.0  # no minus zero

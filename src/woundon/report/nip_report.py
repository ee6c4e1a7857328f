"""The report of a nip."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isinf

from .. import kinds
from ..errors import InvalidProblem, NoSteadyState, NotConverged, unwarned
from ..nip.result import NipResult
from ..problems.nip import NipProblem
from ..problems.stack import Stack
from ..problems.wound_roll import WoundRoll
from ..quantities import in_chosen_units, pure
from .closed_forms import nip_closed_forms
from .contacts_report import contacts_parts
from .outputs_report import LEFT_OUT, approach_note, rows_of
from .report_parts import (
    Line,
    Part,
    Row,
    Section,
    field_row,
    nip_zones,
    output_row,
    quantity_of,
    row_of,
)
from .trade_rule import nip_trade_rule

__all__ = ["nip_report"]

NIP = [
    "nip_width",
    "peak_pressure",
    "approach",
    "offset",
    "drum_creepage",
    "leading_roll",
    "trailing_roll",
    "dual",
]

HELD = "Winding nip, web held at the trailing edge"

WRAPPED = "Winding nip, web wrapped on the roll"

HELD_NOTE = (
    "The web is held to the roll at the trailing edge (thesis eq. 97), which underestimates the "
    "wound-on tension of a web that is wrapped on the roll: set roll_wrap to compute it."
)

# wound-on tension and wraps, of a nip that has some
OF_WRAPS = frozenset(
    {
        "wound_on_tension",
        "inlet_tension",
        "roll_wrap_traction",
        "drum_wrap_traction",
        "slip_angle",
    }
)


def nip_report(result: NipResult) -> list[Part]:
    """Return the report of a nip; with a roll wrap, also of the same nip without wraps."""
    problem = result.problem
    rows, wraps = _tension_rows(result), tuple(_wraps(problem))
    return [
        Line(f"{result.nodes} nodes in the nip, {result.iterations} Newton iterations", "quiet"),
        *_hardening(problem),
        Section("Loads and wraps" if wraps else "Loads", (*_loads(result), *wraps)),
        Section(
            WRAPPED if problem.roll_wrap else HELD,
            rows,
            "" if problem.is_wrapped else HELD_NOTE,
        ),
        *contacts_parts(result),
        nip_trade_rule(result),
        nip_zones(result),
        *_without_wraps(result),
        *_layer_slip(result),
        *nip_closed_forms(result),
    ]


def _wraps(problem: NipProblem) -> Iterator[Row]:
    """Yield the wrap angles, and the friction on the wrap if it is given."""
    if problem.is_wrapped:
        yield field_row(problem, "roll_wrap")
    if problem.drum_wrap:
        yield field_row(problem, "drum_wrap")
    if problem.roll_wrap and problem.wrap_friction is not None:
        yield field_row(problem, "wrap_friction")


def _tension_rows(result: NipResult) -> tuple[Row, ...]:
    """Return the rows of tensions, nip width, pressure and other main outputs."""
    undetermined = approach_note(result.problem.roll, result.problem.drum)
    if not result.problem.is_wrapped:
        names = ["nip_induced_tension", "outlet_tension"]
        return rows_of(result, names + NIP, LEFT_OUT | OF_WRAPS, approach=undetermined)
    on_drum = ["inlet_tension", "drum_wrap_traction"] if result.problem.drum_wrap else []
    names = [
        "wound_on_tension",
        "nip_induced_tension",
        "outlet_tension",
        *on_drum,
        "roll_wrap_traction",
        "slip_angle",
    ]
    direction = f", web {result.slip_zone.word}" if result.slip_zone else ""
    return rows_of(result, names + NIP, approach=undetermined, slip_angle=direction)


def _hardening(problem: NipProblem) -> Iterator[Line]:
    """Yield a remark whether roll and web harden under the nip pressure, in nips with a stack."""
    if isinstance(problem.roll, WoundRoll) or isinstance(problem.web.material, Stack):
        texts = (
            f"the {name} {'does not harden' if part.linear else 'hardens'}"
            for name, part in (("roll", problem.roll), ("web", problem.web))
        )
        yield Line(f"under the nip pressure {', '.join(texts)}", "quiet")


def _loads(result: NipResult) -> tuple[Row, ...]:
    """Return the rows of the loads."""
    moving = [] if result.problem.web_speed is None else ["web_speed"]
    names = ("nip_load", "winding_force", "web_tension", *moving)
    return tuple(field_row(result.problem, name) for name in names)


LAYERS = "Interlayer slip in the roll (the model assumes bonded layers)"
# of the numbers of LayerSlip, whose definitions differ
SLIP_MEASURES = (
    "S_tau compares the largest shear of an interface with friction under its largest pressure; "
    "n_slip counts layers whose shear exceeds friction anywhere along the nip, also at S_tau < 1."
)
LAYER_FRICTION = pure("mu_l", "friction between the layers at S_tau, reduced by the air film")


def _layer_slip(result: NipResult) -> Iterator[Part]:
    """Yield the layer-slip index, if the interior stresses are computed."""
    with unwarned():
        slip = result.layer_slip
    if slip is None:
        return
    # depth and width of the slipping layers, if there are any
    names = ("ratio", "layers", "depth", "width") if slip.layers else ("ratio",)
    rows = [
        row_of(quantity_of(type(result), f"layer_slip.{name}"), getattr(slip, name))
        for name in names
    ]
    if isinf(slip.ratio):  # of shear to a friction of zero
        rows[0] = replace(rows[0], value="no friction")
    elif result.air is not None:
        rows.append(row_of(LAYER_FRICTION, slip.friction[slip.critical]))
    warning = f"warning: {in_chosen_units(slip.warning)}. {SLIP_MEASURES}" if slip.warning else ""
    yield Section(LAYERS, tuple(rows), warning)


def _without_wraps(result: NipResult) -> Iterator[Section]:
    """Yield a section on the same nip without wraps, solved with the same number of nodes."""
    if result.problem.roll_wrap == 0:
        return  # held there already
    name = "First nip alone" if result.problem.next_nips else "Same nip"
    title = f"{name} with the web held at the trailing edge"
    try:
        with unwarned():
            nip = kinds.solve(
                result.without_air.replace(roll_wrap=0.0, drum_wrap=0.0, next_nips=()),
                nodes=result.nodes,
            )
    except NoSteadyState as fault:
        yield Section(title, (), f"No steady state exists: {in_chosen_units(str(fault))}")
        return
    except (InvalidProblem, NotConverged) as fault:
        yield Section(title, (), f"Not solved: {in_chosen_units(str(fault))}")
        return
    label = "web tension at the trailing edge of the nip, eq. (97)"
    yield Section(title, (output_row(nip, "outlet_tension", meaning=label),))

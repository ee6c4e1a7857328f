"""The panels of two rollers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .. import theories
from ..errors import InvalidProblem
from ..nip.roller_result import RollerResult
from ..quantities import Quantity
from .figures import COLOURS, along_contact, axis_label, draw_zones, quantity_of
from .panels import NEUTRAL, Case, Panel
from .report_parts import roller_zones

__all__ = ["roller_panels"]

Array = np.ndarray
Cases = Sequence[Case]
Handles = list[Any]


def roller_panels(result: RollerResult) -> dict[str, Panel]:
    """Return the panels of two rollers.

    - tractions: p and q over the shaded bound +-mu p, next to the closed forms that
      apply: Carter's (rolling), Cattaneo's (static), or Bentall and Johnson's for dissimilar
      rollers that roll freely without slip
    - slip: a speed over the speed in rolling, a length in static contact
    - zones
    """
    return {
        "tractions": Panel(_draw_roller_tractions, "contact"),
        "slip": Panel(_draw_roller_slip, "contact", height=2.8),
        "zones": Panel(_draw_roller_zones, "contact", height=0.3, strip=True),
    }


def _draw_roller_tractions(axes: Axes, cases: Cases) -> Handles:
    """Plot pressure and traction of rollers, with closed forms for a single result."""
    x, stress = (quantity_of(cases[0].result, name) for name in ("x", "pressure"))
    handles: Handles = []
    for case in cases:
        result, mu = case.result, case.result.problem.friction
        at, p, marks = x.shown(result.x), stress.shown(result.pressure), []
        if case.alone:
            shade = axes.fill_between(at, -mu * p, mu * p, color="#DDDDDD", linewidth=0)
            shade.set_label(r"$\pm\mu p$")
            marks.append(shade)
        (pressure,) = axes.plot(at, p, "-.", color=case.colour_or(NEUTRAL), label="$p$")
        (traction,) = axes.plot(at, stress.shown(result.traction), color=case.colour_or(COLOURS[0]))
        traction.set_label("$q$ on upper roller")
        marks += _draw_closed_forms(axes, result, x, stress) if case.alone else []
        handles = handles or [pressure, traction, *marks]
    axes.set_ylabel(axis_label("Pressure $p$, traction $q$", stress))
    _format_x_axis(axes, cases)
    return handles


def _draw_closed_forms(axes: Axes, result: RollerResult, x: Quantity, stress: Quantity) -> Handles:
    """Plot p and q of the applicable closed form; return its legend entry, if any."""
    name, forms = _closed_forms(result)
    x_marks = -np.cos(np.linspace(0, np.pi, 42)) * result.half_width
    marks: Handles = []
    for form in forms:
        marks += axes.plot(
            x.shown(x_marks),
            stress.shown(form(x_marks)),
            "o",
            color=COLOURS[1],
            markersize=3.5,
            fillstyle="none",
            markeredgewidth=0.8,
            label=name,
        )
    return marks[-1:]


def _closed_forms(result: RollerResult) -> tuple[str, tuple[Callable[[Array], Array], ...]]:
    """Return name and (p(x), q(x)) of the applicable closed form; "" and () if there is none."""
    problem = result.problem
    known: list[tuple[str, Callable[..., Any]]] = [("Cattaneo", theories.cattaneo)]
    if problem.motion == "rolling":
        known = [("Carter", theories.carter)]
        if problem.creepage is None and not problem.tangential_load:
            known.append(("Bentall-Johnson, no slip", theories.bentall_johnson_stick))
    for name, theory in known:
        try:
            solution = theory(problem)
        except InvalidProblem:  # not similar, or of no linear elastic material
            continue
        return name, (solution.pressure, solution.traction)
    return "", ()


def _draw_roller_slip(axes: Axes, cases: Cases) -> Handles:
    """Plot the slip of rollers along the contact."""
    first = cases[0].result
    rolling = first.problem.motion == "rolling"
    if any((case.result.problem.motion == "rolling") != rolling for case in cases):
        text = "the slip of rolling rollers is a speed, of static ones a length; leave it out"
        raise InvalidProblem.at("panels", text)
    x, quantity = quantity_of(first, "x"), quantity_of(first, "creepage" if rolling else "shift")
    for case in cases:
        result = case.result
        axes.plot(
            x.shown(result.slip_x),
            quantity.shown(result.slip),
            color=case.colour_or(COLOURS[0]),
        )
    axes.set_ylabel(axis_label("Relative slip speed $v$" if rolling else "Slip $v$", quantity))
    _format_x_axis(axes, cases)
    return []


def _draw_roller_zones(axes: Axes, cases: Cases) -> Handles:
    """Plot the stick and slip zones of rollers."""
    strips, colours = [roller_zones(c.result) for c in cases], [case.colour for case in cases]
    handles = draw_zones(axes, strips, quantity_of(cases[0].result, "x"), colours)
    _format_x_axis(axes, cases)
    return list(handles)


def _format_x_axis(axes: Axes, cases: Cases) -> None:
    along_contact(axes, [case.result for case in cases], "contact")

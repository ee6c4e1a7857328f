"""The panels of two rollers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import theories
from ..errors import InvalidProblem
from ..nip.roller_result import RollerResult
from .moduli_panels import moduli
from .nip_panels import along_contact, bounds_of_friction, zones_panel
from .panels import Axis, Curve, Panel, PanelMaker
from .report_parts import quantity_of

__all__ = ["roller_panels"]

Array = np.ndarray
Form = Callable[[Array], Array]
MARKS = 42  # of a closed form along the contact


def roller_panels(result: RollerResult) -> dict[str, PanelMaker]:
    """Return the panels of two rollers.

    - tractions: p and q over the shaded bound +-mu p, next to the closed forms that
      apply: Carter's (rolling), Cattaneo's (static), or Bentall and Johnson's for dissimilar
      rollers that roll freely without slip
    - slip: a speed over the speed in rolling, a length in static contact
    - zones
    - moduli: with a viscoelastic roller, its moduli over the frequency with V/2a, if asked for
    """
    panels = {
        "tractions": PanelMaker(tractions),
        "slip": PanelMaker(slip),
        "zones": PanelMaker(zones),
    }
    if result.problem.viscoelastic:
        panels["moduli"] = PanelMaker(moduli, by_default=False)
    return panels


def tractions(result: RollerResult) -> Panel:
    """Return the panel of pressure and traction with the closed form that applies."""
    x = result.x
    return Panel(
        "tractions",
        along_contact(result, "contact"),
        Axis("Pressure $p$, traction $q$", quantity_of(result, "pressure")),
        title="Tangential tractions and friction bounds",
        curves=(
            Curve("pressure", x, result.pressure, symbol="p", colour="web", line="dashdot"),
            Curve("traction", x, result.traction, symbol="q", label="on upper roller"),
            *_closed_form_curves(result),
        ),
        areas=bounds_of_friction(result, {"traction": "mu p"}),
        column="contact",
    )


def _closed_form_curves(result: RollerResult) -> list[Curve]:
    """Return p and q of the closed form that applies as points, with one entry in the legend."""
    name, forms = _closed_forms(result)
    # closest at the edges, where the closed forms are steep
    x = -np.cos(np.linspace(0, np.pi, MARKS)) * result.half_width
    return [
        Curve(
            name,
            x,
            form(x),
            label=name,
            colour="drum",
            line="none",
            marker="ring",
            alone=True,
            in_legend=k == 0,
        )
        for k, form in enumerate(forms)
    ]


def _closed_forms(result: RollerResult) -> tuple[str, tuple[Form, ...]]:
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


def slip(result: RollerResult) -> Panel:
    """Return the panel of the slip along the contact: a speed in rolling, else a length."""
    rolling = result.problem.motion == "rolling"
    quantity = quantity_of(result, "creepage" if rolling else "shift")
    return Panel(
        "slip",
        along_contact(result, "contact"),
        Axis("Relative slip speed $v$" if rolling else "Slip $v$", quantity),
        title="Slip",
        curves=(
            Curve("slip", result.slip_x, result.slip, symbol="v", label="lower surface faster"),
        ),
        column="contact",
        height=2.8,
    )


def zones(result: RollerResult) -> Panel:
    """Return the panel of the zones along the contact."""
    return zones_panel(result, "contact", height=0.3)

"""Thesis Fig. 34, sec. 4.9: how fast web and roll stretch under a web that slips all round."""

from __future__ import annotations

from functools import cache
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from ..elasticity.strip import compliance
from ..problems import NipProblem
from ..wrap.grid import Influence, OpenGrid
from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

FRICTION = 0.5
TENSION = 500.0  # T_0 [N/m]; the ratio of the rates does not depend on it
CELLS = 720  # a quarter of a degree each
AWAY = 5.0  # [deg] from either end of the load, where strains are singular


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Load the roll of Table 1 by eq. (181) with mu+ = 0.5; return Fig. 34."""
    table = _rates()
    title = "Growth rates of the strains of web and roll under a web that slips all round"
    made = Figure(
        "fig34", title, scheme, table, _verdicts(table), lambda: _draw(table), one_scheme=True
    )
    return (made,)


@cache
def _rates() -> Table:
    problem = paper_nip(roll_friction=FRICTION)
    theta = np.linspace(0.0, pi, CELLS + 1)
    middle = (theta[1:] + theta[:-1]) / 2
    pressure = TENSION / problem.roll.radius * np.exp(FRICTION * theta)
    strain = _roll_strain(problem, theta, middle, pressure)
    inner = theta[1:-1]
    c11 = compliance(*problem.web.material.stiffness[:3]).c11
    web = c11 / problem.web.thickness * TENSION * FRICTION * np.exp(FRICTION * inner)
    return Table.of(
        {
            "angle [rad]": inner,
            "roll_rate [1/rad]": np.diff(strain) / np.diff(middle),
            "web_rate [1/rad]": web,
        }
    )


def _roll_strain(problem: NipProblem, theta: Array, at: Array, pressure: Array) -> Array:
    """Return the roll's surface strain under a pressure and mu+ times it as traction."""
    roll = problem.roll
    R, kernels = roll.radius, roll.surface(pi * roll.radius)
    none = np.arange(0)
    put = Influence(
        OpenGrid(theta, at), None, none, slice(0), R, kernels.length, 2 * pi * R
    )  # fmt: skip
    both = put(kernels.strain_p) + FRICTION * put(kernels.strain_q)
    strain: Array = both @ pressure
    return strain


def _verdicts(table: Table) -> tuple[Verdict, ...]:
    angle = np.degrees(table["angle"])
    away = (angle > AWAY) & (angle < 180 - AWAY)
    ratio = table["web_rate"] / np.abs(table["roll_rate"])
    return (
        Verdict(
            "the rates of web and roll differ by several decades: median of their ratio",
            float(np.median(ratio[away])), 100.0,
            note=f"between {AWAY:g} and {180 - AWAY:g} degrees; the smallest is "
            f"{ratio[away].min():.0f}, at the end, where the load stops and the roll's strain is "
            "singular",
        ),
        Verdict(
            "so a slipping web does not stick again: its strain outgrows the roll's everywhere",
            float(ratio[away].min()), 1.0, note="smallest ratio",
        ),
    )  # fmt: skip


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 1, (6.0, 4.0))
    axes = figure.axes[0]
    angle = np.degrees(table["angle"])
    axes.semilogy(angle, np.abs(table["roll_rate"]), "-", color="#0072B2", label="roll")
    axes.semilogy(angle, table["web_rate"], "--", color="#D55E00", label="web")
    axes.set_xlabel(r"Angle behind the start of slip $\theta$ [deg]")
    axes.set_ylabel(r"$|d\varepsilon/d\theta|$ [1/rad]")
    drawing.shared_legend(figure, 2)
    return figure

"""Thesis Fig. 33, sec. 4.8: NIT and computing time against the number of nodes M.

P = 2000 N/m and F = 0, Table 1.  The thesis's scheme is computed in any case, since the figure is
about it; the accurate one beside it.  Seconds are those of the machine at hand.
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from ..bodies import HalfPlane
from ..nip import solve_nip
from ..problems import NipProblem
from ..results import NipResult
from .cases import paper_nip
from .covers import covered_nip
from .fig26 import COVERS
from .frame import Figure, Scheme, Table, Verdict
from .sweep import solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

NODES = np.array([25, 50, 75, 100, 150, 200, 250, 300, 400])
SCHEMES: tuple[Scheme, ...] = ("thesis", "graded")
NIP_WIDTH_LOADS = (1330.0, 2000.0, 4000.0, 7000.0, 11200.0)  # 2a from 7 to 20 mm
ROLL_LOADS = (2000.0, 5000.0, 11000.0)
COVER_LOADS = (2000.0, 5000.0)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve on ever finer grids; return Fig. 33."""
    problem = paper_nip(nip_load=2000.0, winding_force=0.0)
    table = _convergence(problem)
    limit = solve_nip(problem, rtol=1e-5)
    verdicts = (*_errors(table, limit), *_widths(), *_half_planes(), _terms(limit))
    shown = SCHEMES if scheme == "graded" else SCHEMES[:1]
    draw = lambda: _draw(table, shown)  # noqa: E731
    title = "Computing time and NIT against the number of nodes"
    return (Figure("fig33", title, scheme, table, verdicts, draw, one_scheme=True),)


def _convergence(problem: NipProblem) -> Table:
    rows = []
    for graded, scheme in enumerate(SCHEMES):
        for M in NODES:
            begun = perf_counter()
            result = solve_nip(problem, scheme=scheme, nodes=int(M))
            rows.append([graded, M, result.nip_induced_tension, perf_counter() - begun])
    header = ("graded [1]", "nodes [1]", "nip_induced_tension [N/m]", "time [s]")
    return Table(header, np.array(rows))


def _errors(table: Table, limit: NipResult) -> tuple[Verdict, ...]:
    thesis, graded = (table.where(graded=k) for k in (0, 1))
    exact = limit.nip_induced_tension
    missing = 1 - thesis["nip_induced_tension"] / exact
    order = -float(np.polyfit(np.log(NODES), np.log(missing), 1)[0])
    at_200 = 100 * float(missing[NODES == 200][0])
    seconds = float(np.polyfit(np.log(NODES[3:]), np.log(thesis["time"][3:]), 1)[0])
    best = 100 * float(np.max(np.abs(1 - graded["nip_induced_tension"] / exact)[1:]))
    return (
        Verdict(
            "NIT seems to converge as M grows: smallest step towards the limit",
            float(np.min(np.diff(thesis["nip_induced_tension"]))), 0.0, unit="N/m",
            note=f"the limit is {exact:.2f} N/m",
        ),
        Verdict(
            "but slowly: order of convergence", order, high=1.0,
            note="fitted exponent of 1/M.  The wound-on condition takes the roll's strain half a "
            "cell before the trailing edge, where the pressure goes like the root of the distance",
        ),
        Verdict(
            "M = 200 is a compromise of time and accuracy: NIT is too low by", at_200, high=10.0,
            unit="%", note=f"the accurate scheme is within {best:.2f} % from 50 nodes on",
        ),
        Verdict.untested(
            "the computing time grows exponentially with M",
            "the thesis's program and machine are not at hand.  Here the time of its scheme grows "
            f"about like M to the power {seconds:.1f}, and ends with the matrices' solution, M^3",
        ),
    )  # fmt: skip


def _widths() -> tuple[Verdict, ...]:
    errors, widths = [], []
    for P in NIP_WIDTH_LOADS:
        problem = paper_nip(nip_load=P, winding_force=0.0)
        good, rough = solved(problem, "graded"), solved(problem, "thesis")
        errors.append(100 * (rough.nip_induced_tension / good.nip_induced_tension - 1))
        widths.append(2e3 * good.half_width)
    return (
        Verdict(
            "with M = 200 the error varies by less than 5 % between nips 7 and 20 mm wide, so that "
            "trends are not touched", float(np.ptp(errors)), high=5.0, unit="%",
            note=f"it is {errors[0]:.1f} % at {widths[0]:.1f} mm, {errors[-1]:.1f} % at "
            f"{widths[-1]:.1f} mm",
        ),
    )  # fmt: skip


def _half_plane_error(problem: NipProblem, body: str) -> float:
    """Return by how much NIT changes if a half-plane stands for the roll or the drum [%]."""
    cylinder = getattr(problem, body)
    flat = HalfPlane(radius=cylinder.radius, material=cylinder.material)
    exact = solved(problem, "graded").nip_induced_tension
    return 100 * abs(
        solved(problem.replace(**{body: flat}), "graded").nip_induced_tension / exact - 1
    )


def _half_planes() -> tuple[Verdict, ...]:
    core = paper_nip().roll.core_radius  # type: ignore[union-attr]
    thin = {"roll.radius": core + 0.05}
    roll = [_half_plane_error(paper_nip(nip_load=P, **thin), "roll") for P in ROLL_LOADS]
    soft = {
        (name, P, t): _half_plane_error(covered_nip(*COVERS[name], t, nip_load=P), "drum")
        for name in ("rubber", "cellular elastomer")
        for P in COVER_LOADS
        for t in (0.01, 0.05)
    }
    thick = {key[:2]: error for key, error in soft.items() if key[2] == 0.05}
    growth = [soft[(*key, 0.01)] - error for key, error in thick.items()]
    return (
        Verdict(
            "with a rigid drum and 5 cm of paper on the core, the half-plane's NIT is typically "
            "less than 3 % off", max(roll), high=3.0, unit="%",
            note="largest of " + ", ".join(f"{P / 1e3:.0f}" for P in ROLL_LOADS) + " kN/m",
        ),
        Verdict(
            "on a cover of 5 cm it can be about 15 % off", max(thick.values()), 15.0, unit="%",
            note="covers of Fig. 26: "
            + ", ".join(f"{name} at {P / 1e3:.0f} kN/m {e:.0f} %" for (name, P), e in thick.items())
            + ".  It can be more: what counts is the nip's width over the cover's thickness",
        ),
        Verdict(
            "and the error grows fast as the cover gets thinner: smallest growth from 5 to 1 cm",
            min(growth), 10.0, unit="%",
        ),
    )  # fmt: skip


def _terms(limit: NipResult) -> Verdict:
    return Verdict(
        "15 000 to 35 000 terms of the cylinder's Fourier series are needed",
        float(limit.series_terms),
        15e3,
        unit="terms",
        note="the half-plane's share, which decays like 1/n, is summed in closed form here; what "
        f"is left of the series after these terms is below {limit.series_error:.0e} of the whole",
    )


def _draw(table: Table, shown: tuple[Scheme, ...]) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 1, (6.0, 4.0))
    (axes,) = figure.axes
    twin = axes.twinx()
    names = {"thesis": "thesis's scheme", "graded": "accurate scheme"}
    for k, scheme in enumerate(shown):
        rows = table.where(graded=k)
        colour = drawing.COLOURS[k]
        axes.plot(rows["nodes"], rows["time"], "-", color=colour, label=f"time, {names[scheme]}")
        twin.plot(
            rows["nodes"], rows["nip_induced_tension"], "--", color=colour,
            label=f"NIT, {names[scheme]} (right axis)",
        )  # fmt: skip
    axes.set_xlabel("Number of nodes $M$")
    axes.set_ylabel("Computing time [s]")
    twin.set_ylabel("NIT [N/m]")
    twin.grid(visible=False)
    drawing.shared_legend(figure, 2)
    return figure

"""Thesis Fig. 33, sec. 4.8: NIT and computing time against the number of nodes M.

P = 2000 N/m and F = 0, Table 1.  The thesis's procedure is computed in any case, since the figure
is about it, and the accurate solution next to it.  Computing times were measured once, as multiples
of a dense solve, so that the figure is the same whenever it is drawn; a campaign of the tests
measures them again.
"""

from __future__ import annotations

from importlib import resources

import numpy as np
import pandas as pd
import xarray as xr

import woundon as wo

from ..report.panels import Axis, Curve, Panel
from . import procedure
from .cases import COVERS, covered_nip, paper_nip
from .exhibits import Exhibit
from .nips import dataset, joined, quiet, solved_accurately, swept
from .panels import COLOURS, axis
from .verdicts import Verdict, at_least, at_most, grows, untested, verdict

__all__ = ["exhibits"]

NODES = np.array([25, 50, 75, 100, 150, 200, 250, 300, 400])
NIP_WIDTH_LOADS = (1330.0, 2000.0, 4000.0, 7000.0, 11200.0)  # 2a from 7 to 20 mm
ROLL_LOADS = (2000.0, 5000.0, 11000.0)
COVER_LOADS = (2000.0, 5000.0)
NAMES = ("thesis's procedure", "accurate solver")
PROBLEM = paper_nip(nip_load=2000.0, winding_force=0.0)


def exhibits(solver: str) -> list[Exhibit]:
    """Solve on ever finer grids; return Fig. 33."""
    times = _times()
    # 0: the thesis's procedure, 1: the accurate solver
    thesis, graded = (_converging(name, times[name]) for name in ("thesis", "accurate"))
    data = joined("accurate [1]", {0: thesis, 1: graded})
    with quiet():
        limit = wo.solve(PROBLEM, rtol=1e-5)
    verdicts = [*_errors(data, limit), _widths(), *_half_planes(), _terms(limit)]
    shown = 2 if solver == "accurate" else 1
    panel = _panel(data.isel(accurate=slice(shown)))
    return [Exhibit("fig33", data, verdicts, [panel], one_solver=True)]


def _times() -> pd.DataFrame:
    """Return nodes and the measured computing times by solver, in dense solves."""
    names = ["nodes", "thesis", "accurate"]
    with (resources.files(__package__) / "computing_time.csv").open(encoding="utf-8") as file:
        times = pd.read_csv(file, comment="#", names=names)
    assert np.array_equal(times["nodes"], NODES)
    return times


def _converging(solver: str, times: pd.Series) -> xr.Dataset:
    """Solve the nip on finer and finer meshes."""
    NIT = []
    for M in NODES.tolist():
        by_thesis = solver == "thesis"
        result = procedure.solve(PROBLEM, M) if by_thesis else solved_accurately(PROBLEM, M)
        NIT.append(result.nip_induced_tension)
    data = dataset("nodes", {"nip_induced_tension [N/m]": NIT, "time [1]": times.to_numpy()})
    return data.assign_coords(nodes=("nodes", NODES, {"units": "1"}))


def _errors(data: xr.Dataset, limit: wo.NipResult) -> list[Verdict]:
    """Test the statements about the discretisation errors."""
    thesis, graded = data["nip_induced_tension"]
    exact = limit.nip_induced_tension
    missing = 1 - thesis / exact
    order = -np.polyfit(np.log(NODES), np.log(missing), 1)[0]
    # of the thesis's procedure from 100 nodes on, where the matrices dominate
    growth = np.polyfit(np.log(NODES[3:]), np.log(data["time"][0, 3:]), 1)[0]
    best = 100 * np.abs(1 - graded / exact)[1:].max()  # without 25 nodes
    return [
        grows(
            "NIT seems to converge as M grows: smallest step towards the limit",
            thesis,
            "nodes",
            note=f"the limit is {exact:.2f} N/m",
        ),
        verdict(
            "but slowly: order of convergence",
            order,
            at_most(1.0),
            note="fitted exponent of 1/M.  The wound-on condition takes the roll's strain half a "
            "cell before the trailing edge, where the pressure goes like the root of the distance",
        ),
        verdict(
            "M = 200 is a compromise of time and accuracy: NIT is too low by",
            100 * missing.sel(nodes=200),
            at_most(10.0, "%"),
            note=f"the accurate solver is within {best:.2f} % from 50 nodes on",
        ),
        untested(
            "the computing time grows exponentially with M",
            note="the thesis's program and machine are not at hand.  Here the time of its "
            f"procedure grows about like M to the power {growth:.1f}, and ends with the matrices' "
            "solution, M^3",
        ),
    ]


def _widths() -> Verdict:
    """Test if the discretisation error is the same for nips of different width."""
    problem, over = paper_nip(winding_force=0.0), {"nip_load": NIP_WIDTH_LOADS}
    good, rough = (swept(problem, over, solver) for solver in ("accurate", "thesis"))
    errors = 100 * (rough["nip_induced_tension"] / good["nip_induced_tension"] - 1)
    widths = 1e3 * good["nip_width"]
    return verdict(
        "with M = 200 the error varies by less than 5 % between nips 7 and 20 mm wide, so that "
        "trends are not touched",
        np.ptp(errors.values),
        at_most(5.0, "%"),
        note=f"it is {errors[0]:.1f} % at {widths[0]:.1f} mm, {errors[-1]:.1f} % at "
        f"{widths[-1]:.1f} mm",
    )


def _half_plane_error(problem: wo.NipProblem, body: str) -> float:
    """Return the change of NIT if a half-plane replaces the roll or the drum [%]."""
    cylinder = getattr(problem, body)
    flat = wo.HalfPlane(radius=cylinder.radius, material=cylinder.material)
    exact = solved_accurately(problem).nip_induced_tension
    rough = solved_accurately(problem.replace(**{body: flat})).nip_induced_tension
    return 100 * abs(rough / exact - 1)


def _half_planes() -> list[Verdict]:
    """Test the statements about half-planes in place of cylinders."""
    thin = {"roll.radius": 0.05 + 0.05}  # core radius and 5 cm of paper
    roll = [_half_plane_error(paper_nip(nip_load=P, **thin), "roll") for P in ROLL_LOADS]
    thick, growth = {}, []
    for name in ("rubber", "cellular elastomer"):
        for P in COVER_LOADS:
            thick[name, P], thinner = (
                _half_plane_error(covered_nip(*COVERS[name], t, nip_load=P), "drum")
                for t in (0.05, 0.01)
            )
            growth.append(thinner - thick[name, P])
    return [
        verdict(
            "with a rigid drum and 5 cm of paper on the core, the half-plane's NIT is typically "
            "less than 3 % off",
            max(roll),
            at_most(3.0, "%"),
            note="largest of " + ", ".join(f"{P / 1e3:.0f}" for P in ROLL_LOADS) + " kN/m",
        ),
        verdict(
            "on a cover of 5 cm it can be about 15 % off",
            max(thick.values()),
            at_least(15.0, "%"),
            note="covers of Fig. 26: "
            + ", ".join(f"{name} at {P / 1e3:.0f} kN/m {e:.0f} %" for (name, P), e in thick.items())
            + ".  It can be more: what counts is the nip's width over the cover's thickness",
        ),
        verdict(
            "and the error grows fast as the cover gets thinner: smallest growth from 5 to 1 cm",
            min(growth),
            at_least(10.0, "%"),
        ),
    ]


def _terms(limit: wo.NipResult) -> Verdict:
    """Test the statement about the number of Fourier terms."""
    return verdict(
        "15 000 to 35 000 terms of the cylinder's Fourier series are needed",
        limit.series_terms,
        at_least(15e3, "terms"),
        note="the half-plane's share, which decays like 1/n, is summed in closed form here; what "
        f"is left of the series after these terms is below {limit.series_error:.0e} of the whole",
    )


def _panel(data: xr.Dataset) -> Panel:
    """Return the panel of computing time and NIT over the number of nodes."""
    curves = []
    for k in data["accurate"].values.tolist():
        one, name = data.sel(accurate=k), NAMES[k]
        for output, label, line in (
            ("time", f"time, {name}", "solid"),
            ("nip_induced_tension", f"NIT, {name}", "dashed"),
        ):
            values, right = one[output].values, output != "time"
            curve = Curve(
                output, NODES, values, label=label, colour=COLOURS[k], line=line, right=right
            )
            curves.append(curve)
    return Panel(
        "convergence",
        Axis("Number of nodes $M$"),
        Axis("Computing time / dense solve of 398 x 398"),
        right=axis("nip_induced_tension"),
        curves=tuple(curves),
        legend="stacked",
        height=4.4,
    )

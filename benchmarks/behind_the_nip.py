"""The nip alone, the estimate (183) and the wrapped nip, compared in tables.

    python benchmarks/behind_the_nip.py

The page calls the functions below while it is built.  Every number comes from one nip solved two
ways, and is a tension less T_in [N/m]:

    confined   T_out of the nip alone, the web held to the roll at the trailing edge (thesis eq. 97)
    (183)      what that nip asks for half a turn on if the web stuck to the roll from there
    in nip     T_out - T_n between the edges of the nip with the web wrapped on the roll (96)
    NIT        its nip-induced tension, WOT - T_in, up to the end of the wrap
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from math import degrees, exp, inf, pi

import numpy as np
from random_nips import random_nip

import woundon as wo
from woundon.jorkama2001.cases import measured_tensions
from woundon.jorkama2001.estimate import wound_on_tension_estimate

__all__ = [
    "PAPERS", "Compared", "bracket_table", "case_table", "compared", "error_map", "error_table",
    "exponent_table", "friction_table", "light_load_table", "newsprint", "paper", "slope_table",
]  # fmt: skip

LOADS = (200.0, 500.0, 1000.0, 2000.0, 4850.0, 10e3, 20e3)  # 4850: that of thesis sec. 4.5
LIGHT_LOADS = (0.1, 1.0, 10.0, 100.0, 350.0)  # at 0.1 N/m the nip is as wide as the web is thick
FRICTIONS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
STEP = 0.05  # of ln R*, to either side: tensions change by 1 to 5 %, their error is below 0.1 %


def paper(**changes: object) -> wo.NipProblem:
    """Return Table 1 of the thesis in centre winding, T_in = 300 N/m; its 2h is not printed."""
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material="paper"),
        roll=wo.Cylinder(radius=0.3, core_radius=0.05, material="paper"),
        drum=wo.Rigid(radius=0.5),
        roll_friction=0.2, drum_friction=0.4,
        nip_load=1900.0, winding_force=0.0, web_tension=300.0, roll_wrap=0.0,
    ).replace(**changes)  # fmt: skip


def newsprint(**changes: object) -> wo.NipProblem:
    """Return Table 2 of the thesis in centre winding, T_in = 350 N/m."""
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material="newsprint"),
        roll=wo.Cylinder(radius=0.1, core_radius=0.0445, material="newsprint"),
        drum=wo.Rigid(radius=0.0762),
        roll_friction=0.19, drum_friction=0.2,
        nip_load=3502.0, winding_force=0.0, web_tension=350.0, roll_wrap=0.0,
    ).replace(**changes)  # fmt: skip


PAPERS = {"Table 1": paper, "Table 2": newsprint}


@dataclass(frozen=True)
class Compared:
    """One nip alone and wrapped, tensions less T_in [N/m].

    Attributes
    ----------
    web_tension : float
        T_in.
    confined, estimate, in_nip, nip_induced : float
        As above.
    error : float
        Discretisation errors of ``confined`` and ``nip_induced`` as estimated, together.
    slip_angle : float
        How far the web slips behind the wrapped nip [rad].
    """

    web_tension: float
    confined: float
    estimate: float
    in_nip: float
    nip_induced: float
    error: float
    slip_angle: float

    @property
    def tensions(self) -> tuple[float, float, float, float]:
        """Confined, (183), in the nip, NIT."""
        return self.confined, self.estimate, self.in_nip, self.nip_induced

    @property
    def outside(self) -> float:
        """How far the wound-on tension lies outside confined and (183), < 0 between them."""
        low, high = sorted((self.confined, self.estimate))
        return max(low - self.nip_induced, self.nip_induced - high)

    def share(self, tension: float) -> float:
        """Return a difference to the wound-on tension as a share of it."""
        return (tension - self.nip_induced) / (self.web_tension + self.nip_induced)


@cache
def compared(problem: wo.NipProblem, nodes: int = 129) -> Compared:
    """Solve a nip alone and wrapped."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wo.ValidityWarning)
        warnings.simplefilter("ignore", wo.ResolutionWarning)
        alone, wrapped = (
            wo.solve(problem, nodes=nodes),
            wo.solve(problem.replace(roll_wrap=pi), nodes=nodes),
        )
    T_in = problem.web_tension
    return Compared(
        web_tension=T_in,
        confined=alone.outlet_tension - T_in,
        estimate=wound_on_tension_estimate(alone) - T_in,
        in_nip=wrapped.outlet_tension - wrapped.inlet_tension,
        nip_induced=wrapped.nip_induced_tension,
        error=alone.nip_induced_tension_error + wrapped.wound_on_tension_error,
        slip_angle=wrapped.slip_angle,
    )


def lined_up(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts: the first column to the left, the others to the right."""
    table = [tuple(header), *(tuple(row) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in table
    )


def case_table() -> str:
    """Compare single cases: light and heavy friction, a driving drum, newsprint."""
    driving = paper(nip_load=10e3, winding_force=-2000.0, web_tension=2500.0)
    cases = {
        "Table 1, P 1900, F 100, T_in 300": paper(winding_force=100.0),
        "Table 1, P 1900, F 0, T_in 300": paper(),
        "the same, mu+ 0.05": paper(roll_friction=0.05),
        "the same, mu+ 1": paper(roll_friction=1.0),
        "Table 1, P 10 000, F -2000, T_in 2500": driving,
        "Table 2, P 3502, F 0, T_in 350": newsprint(),
    }
    rows = ([name, *(f"{T:.1f}" for T in compared(p).tensions)] for name, p in cases.items())
    return lined_up(("N/m", "confined", "(183)", "in nip", "NIT"), rows)


def friction_table(problem: wo.NipProblem, frictions: Iterable[float] = FRICTIONS) -> str:
    """Compare over mu+; the last column is the confined error as a share of WOT."""
    rows = []
    for mu in frictions:
        c = compared(problem.replace(roll_friction=mu))
        bound = mu * problem.nip_load + problem.winding_force
        tensions = (f"{T:.0f}" for T in (bound, *c.tensions))
        rows.append((f"{mu:4.2f}", *tensions, f"{100 * c.share(c.confined):+.0f} %"))
    return lined_up(("mu+", "mu+ P + F", "confined", "(183)", "in nip", "NIT", "of WOT"), rows)


def error_table(loads: Iterable[float] = LOADS) -> str:
    """Errors in centre winding as shares of what is added to T_in, and of WOT."""
    rows = []
    for name, base in PAPERS.items():
        for P in loads:
            c = compared(base(nip_load=P))
            shares = [
                ((T - c.nip_induced) / c.nip_induced, c.share(T)) for T in (c.confined, c.estimate)
            ]
            texts = (f"{100 * share:+.0f} %" for pair in shares for share in pair)
            rows.append((f"{name}, P {P:6.0f}", *texts))
    header = ("error", "confined: of added", "of WOT", "(183): of added", "of WOT")
    return lined_up(header, rows)


def light_load_table(loads: Iterable[float] = LIGHT_LOADS) -> str:
    """Tensions over mu+ P in centre winding, T_in = P/10: hardly any hoop pressure."""
    rows = []
    for name, base in PAPERS.items():
        for P in loads:
            problem = base(nip_load=P, web_tension=P / 10)
            bound = problem.roll_friction * P
            shares = (f"{T / bound:.3f}" for T in compared(problem).tensions)
            rows.append((f"{name}, P {P:5g}", *shares))
    return lined_up(("over mu+ P", "confined", "(183)", "in nip", "NIT"), rows)


def exponent_table(loads: Iterable[float] = LOADS) -> str:
    """d ln(tension)/d ln R* in centre winding, all radii changed alike."""

    def tensions(problem: wo.NipProblem, factor: float) -> np.ndarray:
        names = ("roll.radius", "roll.core_radius", "drum.radius")
        radii = (problem.roll.radius, problem.roll.core_radius, problem.drum.radius)
        changes = {name: factor * R for name, R in zip(names, radii, strict=True)}
        c = compared(problem.replace(**changes))
        return np.log([c.confined, c.estimate, c.nip_induced])

    rows = []
    for P in loads:
        row = [f"{P:.0f}"]
        for base in PAPERS.values():
            problem = base(nip_load=P)
            powers = (tensions(problem, exp(STEP)) - tensions(problem, exp(-STEP))) / (2 * STEP)
            row += [f"{power:.2f}" for power in powers]
        rows.append(row)
    of_each = ("confined", "(183)", "NIT")
    return lined_up(("P [N/m]", *(f"{name[-1]}: {T}" for name in PAPERS for T in of_each)), rows)


def error_map(base: wo.NipProblem, loads: Sequence[float], shares: Sequence[float]) -> np.ndarray:
    """Return errors over nip load and F/(mu- P), (loads, shares, 4); nan: the web would be slack.

    The last axis: confined and (183) less WOT, over WOT; how far WOT lies outside these two, over
    WOT; the slip behind the nip [deg].
    """
    errors = np.full((len(loads), len(shares), 4), np.nan)
    for i, P in enumerate(loads):
        for j, share in enumerate(shares):
            F = share * base.drum_friction * P
            try:
                c = compared(base.replace(nip_load=P, winding_force=F), nodes=65)
            except wo.NoSteadyState:
                continue
            values = (
                c.share(c.confined),
                c.share(c.estimate),
                c.outside / (c.web_tension + c.nip_induced),
            )
            errors[i, j] = (*values, degrees(c.slip_angle))
    return errors


def bracket_table(count: int = 300) -> str:
    """Ask of random nips whether confined and (183) enclose the wound-on tension."""
    slack, found = 0, []
    for seed in range(count):
        problem = random_nip(seed)
        try:
            c = compared(problem, nodes=65)
        except wo.NoSteadyState:
            slack += 1
            continue
        share = problem.winding_force / (problem.drum_friction * problem.nip_load)
        found.append((share, c.outside > c.error, c.outside / (c.web_tension + c.nip_induced)))
    share, beyond, relative = np.array(found).T
    rows = []
    ranges = {"F < 0": (-inf, 0.0), "F up to 0.4 mu- P": (0.0, 0.4), "F above": (0.4, inf)}
    for name, (low, high) in ranges.items():
        own = (share >= low) & (share < high)
        out = own & (beyond > 0)
        worst = f"{100 * relative[out].max():.1f} % of WOT" if out.any() else "-"
        rows.append((name, f"{own.sum()}", f"{out.sum()}", worst))
    text = lined_up((f"{count} random nips", "solved", "WOT outside", "at most by"), rows)
    return f"{text}\n(the others, {slack}, would leave the web slack in the wrap)"


def slope_table() -> str:
    """What is added over the nip load, on the laboratory winder: 15 measured points, Table 2.

    Measured: mean and standard deviation over the three tensions.  The web leaves the roll after a
    quarter turn.
    """
    points = measured_tensions().to_dict("records")
    rows = []
    for P in sorted({point["nip_load"] for point in points}):
        own = [point for point in points if point["nip_load"] == P]
        added = [point["measured"] - point["web_tension"] for point in own]
        problems = [newsprint(nip_load=P, web_tension=point["web_tension"]) for point in own]
        alone = wo.solve(problems[0])
        wrapped = (wo.solve(problem.replace(roll_wrap=pi / 2)) for problem in problems)
        solved = np.mean(
            [result.wound_on_tension - result.problem.web_tension for result in wrapped]
        )
        confined = alone.nip_induced_tension
        estimate = wound_on_tension_estimate(alone, pi / 2) - problems[0].web_tension
        texts = (f"{T / P:.3f}" for T in (confined, estimate, solved))
        rows.append(
            (f"{P:.0f}", f"{np.mean(added) / P:.3f} ± {np.std(added, ddof=1) / P:.3f}", *texts)
        )
    return lined_up(("P [N/m]", "measured", "confined", "(183)", "solved"), rows)


def main() -> None:
    """Print all tables."""
    for title, text in (
        ("Cases", case_table()),
        ("Errors in centre winding", error_table()),
        ("Over the friction between the layers, Table 1, P = 4897 N/m",
         friction_table(paper(nip_load=4897.0))),
        ("The same, Table 2, P = 3502 N/m", friction_table(newsprint())),
        ("Light load", light_load_table()),
        ("Exponent of the relative radius R*, tables 1 and 2", exponent_table()),
        ("Does the pair enclose the wound-on tension?", bracket_table()),
        ("(WOT - T_in)/P on the laboratory winder", slope_table()),
    ):  # fmt: skip
        print(f"{title}\n{text}\n")


if __name__ == "__main__":
    main()

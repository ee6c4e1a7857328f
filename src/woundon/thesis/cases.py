"""The load cases that the thesis's figures and tables vary, and its measured data."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Any, NamedTuple

from ..bodies import Cylinder, Rigid
from ..materials import Orthotropic, material
from ..problems import NipProblem, Web

__all__ = ["WoundOnTension", "measured_tensions", "newsprint_nip", "paper_nip"]


def paper_nip(**changes: Any) -> NipProblem:
    """Return the nip of the thesis's Table 1: P = 1900 N/m, F = 100 N/m, T_in = 500 N/m, hard drum.

    ``changes`` are fields of :class:`~woundon.problems.NipProblem`, nested ones by dotted name.

    Notes
    -----
    Table 1 gives no web thickness and no core radius.  Fig. 30's tension drop of almost 100 N/m,
    2h (A_rt/A_rr) p_max, asks for 2h of 66 to 71 um; the core radius moves NIT by 0.02 % between
    10 and 200 mm.  66 um and 50 mm are taken.  T_in is not given either and moves nothing (winding
    theorem); 500 N/m keeps the web taut for every winding force of the thesis.
    """
    paper = material("paper")
    return NipProblem(
        web=Web(thickness=66e-6, material=paper),
        roll=Cylinder(radius=0.3, core_radius=0.05, material=paper),
        drum=Rigid(radius=0.5),
        roll_friction=0.2,
        drum_friction=0.4,
        nip_load=1900.0,
        winding_force=100.0,
        web_tension=500.0,
    ).replace(**changes)


def newsprint_nip(*, paper: Orthotropic | None = None, **changes: Any) -> NipProblem:
    """Return the nip of the thesis's Table 2: newsprint on the laboratory winder, centre wound.

    P = 3502 N/m and T_in = 350 N/m, the point to which the thesis fitted A_rr and G.

    Parameters
    ----------
    paper : Orthotropic, optional
        Material of roll and web, which are of one paper; by default that of Table 2.
    **changes
        Fields of :class:`~woundon.problems.NipProblem`, nested ones by dotted name.
    """
    newsprint = paper or material("newsprint")
    return NipProblem(
        web=Web(thickness=66e-6, material=newsprint),
        roll=Cylinder(radius=0.1, core_radius=0.0445, material=newsprint),
        drum=Rigid(radius=0.0762),
        roll_friction=0.19,
        drum_friction=0.2,
        nip_load=3502.0,
        winding_force=0.0,
        web_tension=350.0,
    ).replace(**changes)


class WoundOnTension(NamedTuple):
    """One point of the thesis's Table 3, all in N/m: P, T_in, wound-on tension, its theory."""

    nip_load: float
    web_tension: float
    measured: float
    thesis_theory: float


def measured_tensions() -> tuple[WoundOnTension, ...]:
    """Return the 15 points of the thesis's Table 3, rows put right, by nip load and tension."""
    path = resources.files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return tuple(WoundOnTension(**{name: float(row[name]) for name in row}) for row in rows)

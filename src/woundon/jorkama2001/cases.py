"""Load cases of the figures and tables of the thesis, and its measured data."""

from __future__ import annotations

from importlib import resources
from typing import Any

import pandas as pd

import woundon as wo

__all__ = [
    "COVERS",
    "DRUM_RADIUS",
    "ONE_PAPER",
    "WINDING_FORCES",
    "covered_nip",
    "measured_tensions",
    "newsprint_nip",
    "paper_nip",
]

WINDING_FORCES = (-500.0, -400.0, -200.0, 0.0, 100.0)  # F of sec. 4.3 to 4.5 [N/m]
ONE_PAPER = {"web.material": "roll.material"}  # to tie: web and roll are of one paper
DRUM_RADIUS = 0.5  # of Table 1 [m]
# E [Pa] and nu of the drum covers of Fig. 26, 2 cm thick on a rigid shell
COVERS = {"hard": (211e9, 0.3), "rubber": (1e6, 0.499), "cellular elastomer": (1e6, 0.1)}


def paper_nip(**changes: Any) -> wo.NipProblem:
    """Return the nip of Table 1: P = 1900 N/m, F = 100 N/m, T_in = 500 N/m, rigid drum.

    ``changes`` are fields of ``NipProblem``, nested ones by dotted name.

    Notes
    -----
    Table 1 gives no web thickness and no core radius.  Fig. 30's tension drop of almost 100 N/m,
    2h (A_rt/A_rr) p_max, asks for 2h of 66 to 71 um; the core radius moves NIT by 0.02 % between
    10 and 200 mm.  66 um and 50 mm are taken.  T_in is not given either and moves nothing (winding
    theorem); 500 N/m keeps the web taut for every winding force of the thesis.
    """
    paper = wo.material("paper")
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=paper),
        roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=paper),
        drum=wo.Rigid(radius=DRUM_RADIUS),
        roll_friction=0.2,
        drum_friction=0.4,
        nip_load=1900.0,
        winding_force=100.0,
        web_tension=500.0,
        roll_wrap=0.0,
    ).replace(**changes)


def covered_nip(
    youngs_modulus: float, poissons_ratio: float, thickness: float = 0.02, **changes: Any
) -> wo.NipProblem:
    """Return Table 1's nip with a drum cover of E [Pa], nu and a thickness [m], sec. 4.6."""
    cover = wo.Isotropic(youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)
    core = DRUM_RADIUS - thickness
    drum = wo.Cylinder(radius=DRUM_RADIUS, core_radius=core, material=cover)
    return paper_nip(drum=drum, **changes)


def newsprint_nip(**changes: Any) -> wo.NipProblem:
    """Return the nip of the thesis's Table 2: newsprint on the laboratory winder, centre wound.

    P = 3502 N/m and T_in = 350 N/m, the point to which the thesis fitted A_rr and G.
    ``changes`` are fields of ``NipProblem``, nested ones by dotted name.
    """
    newsprint = wo.material("newsprint")
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=newsprint),
        roll=wo.Cylinder(radius=0.1, core_radius=0.0445, material=newsprint),
        drum=wo.Rigid(radius=0.0762),
        roll_friction=0.19,
        drum_friction=0.2,
        nip_load=3502.0,
        winding_force=0.0,
        web_tension=350.0,
        roll_wrap=0.0,
    ).replace(**changes)


def measured_tensions() -> pd.DataFrame:
    """Return the 15 points of the thesis's Table 3 by nip load and web tension, rows corrected.

    Columns, all in N/m: ``nip_load``, ``web_tension``, and the wound-on tension as ``measured`` and
    by ``thesis_theory``.
    """
    data = resources.files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    with data.open(encoding="utf-8") as file:
        table = pd.read_csv(file, comment="#", dtype=float)
    return table.rename(columns=lambda header: header.removesuffix(" [N/m]"))

"""The load cases of the thesis's Tables 1 and 2, and its measured points, for the tests."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Any

import woundon as wo


def paper_nip(**changes: Any) -> wo.NipProblem:
    """Table 1: P = 1900, F = 100 N/m, hard drum; 2h, core radius and T_in are not printed there."""
    paper = wo.material("paper")
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=paper),
        roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=paper),
        drum=wo.Rigid(radius=0.5),
        roll_friction=0.2, drum_friction=0.4,
        nip_load=1900.0, winding_force=100.0, web_tension=500.0, roll_wrap=0.0,
    ).replace(**changes)  # fmt: skip


def newsprint_nip(**changes: Any) -> wo.NipProblem:
    """Table 2: newsprint on the laboratory winder, P = 3502 and T_in = 350 N/m."""
    return wo.NipProblem.example().replace(roll_wrap=0.0).replace(**changes)


def film_nip(**changes: Any) -> wo.NipProblem:
    """A polyester film with entrained air under a rubber-covered lay-on roll, not of the thesis."""
    film = wo.Isotropic(youngs_modulus=5e9, poissons_ratio=0.3)
    stack = wo.Isotropic(youngs_modulus=100e6, poissons_ratio=0.3)
    rubber = wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48)
    return wo.NipProblem(
        web=wo.Web(thickness=23e-6, material=film),
        roll=wo.HalfPlane(radius=0.2, material=stack),
        drum=wo.HalfPlane(radius=0.1, material=rubber),
        roll_friction=0.25, drum_friction=0.4, nip_load=300.0, web_tension=100.0,
        web_speed=1.0, air=wo.Air(roughness=0.3e-6),
    ).replace(**changes)  # fmt: skip


def measured_tensions() -> list[dict[str, float]]:
    """Table 3, rows put right: nip_load, web_tension, measured, thesis_theory [N/m]."""
    path = resources.files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return [{name.removesuffix(" [N/m]"): float(v) for name, v in row.items()} for row in rows]

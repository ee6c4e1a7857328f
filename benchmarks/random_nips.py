"""Random admissible nips, one a seed, over the range that the program answers for.

Log-uniform: A_rr 2e6 to 2e8, A_tt 3e8 to 1e10, G 1e6 to 2e8 Pa; P 100 to 20 000 N/m; mu+ and mu-
0.05 to 0.8, either the larger; web thickness 10 to 200 um; radii 0.06 to 1 m; covers of 5 to 40 mm;
drums' E 5e5 to 3e9 Pa; web tension 50 to 1000 N/m.  Uniform: A_rt 0 to 0.6 min(A_rr, 40 MPa), F
within +-0.95 mu- P, nu 0 to 0.495, the roll's core 0.1 to 0.9 of its radius.  A third of the drums
is rigid, a third half-planes, a third covers on a rigid core; half of the rolls are half-planes.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import woundon as wo

__all__ = ["flat_fields", "random_nip"]


class _Draw:
    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)

    def log(self, low: float, high: float) -> float:
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def even(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))


def random_nip(seed: int) -> wo.NipProblem:
    """Return the nip that belongs to a seed; always the same one."""
    draw = _Draw(seed)
    A_rr, A_tt, G = draw.log(2e6, 2e8), draw.log(3e8, 1e10), draw.log(1e6, 2e8)
    A_rt = draw.even(0.0, 0.6) * min(A_rr, 4e7)
    paper = wo.Orthotropic(radial=A_rr, tangential=A_tt, cross=A_rt, shear=G)
    P, mu_roll, mu_drum = draw.log(100.0, 20e3), draw.log(0.05, 0.8), draw.log(0.05, 0.8)
    F = draw.even(-0.95, 0.95) * mu_drum * P
    web = wo.Web(thickness=draw.log(10e-6, 200e-6), material=paper)
    R1, R2 = draw.log(0.06, 1.0), draw.log(0.06, 1.0)
    drum = _drum(draw, R2)
    core = draw.even(0.1, 0.9) * R1
    half_plane = draw.random.random() < 0.5
    roll: wo.HalfPlane | wo.Cylinder = wo.HalfPlane(radius=R1, material=paper)
    if not half_plane:
        roll = wo.Cylinder(radius=R1, core_radius=core, material=paper)
    return wo.NipProblem(
        web=web, roll=roll, drum=drum, roll_friction=mu_roll, drum_friction=mu_drum,
        nip_load=P, winding_force=F, web_tension=draw.log(50.0, 1000.0),
    )  # fmt: skip


def _drum(draw: _Draw, radius: float) -> wo.Rigid | wo.HalfPlane | wo.Cylinder:
    """Return one of three kinds; all draw the same numbers, so that seeds stay comparable."""
    kind = draw.random.integers(3)
    thickness = draw.log(5e-3, 40e-3)
    cover = wo.Isotropic(youngs_modulus=draw.log(5e5, 3e9), poissons_ratio=draw.even(0.0, 0.495))
    if kind == 0:
        return wo.Rigid(radius=radius)
    if kind == 1:
        return wo.HalfPlane(radius=radius, material=cover)
    return wo.Cylinder(radius=radius, core_radius=radius - thickness, material=cover)


def flat_fields(record: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield (dotted name, value) of a problem's ``model_dump``."""
    for name, value in record.items():
        if isinstance(value, dict):
            yield from flat_fields(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value

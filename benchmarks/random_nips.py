"""Random admissible nips, one a seed, over the range that the program answers for.

Log-uniform: A_rr 2e6 to 2e8, A_tt 3e8 to 1e10, G 1e6 to 2e8 Pa; P 100 to 20 000 N/m; mu+ and mu-
0.05 to 0.8, either the larger; web thickness 10 to 200 um; radii 0.06 to 1 m; covers of 5 to 40 mm;
drums' E 5e5 to 3e9 Pa; web tension 50 to 1000 N/m.  Uniform: A_rt 0 to 0.6 min(A_rr, 40 MPa), F
within +-0.95 mu- P, nu 0 to 0.495, the roll's core 0.1 to 0.9 of its radius.  A third of the drums
is rigid, a third half-planes, a third covers on a rigid core; half of the rolls are half-planes.

Wrapped nips are these with 1 rad to half a turn on the roll, half of them with 0.2 to 3 rad on the
drum, under at least 300 N/m.  Rollers are their roll and drum: a third driven, a third creeping by
up to what friction takes, a sixth each free and static.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np

import woundon as wo
from woundon.problems.bodies import half_width_guess

__all__ = [
    "flat_fields", "random_neighbours", "random_nip", "random_rollers",
    "random_wrapped_neighbours", "random_wrapped_nip",
]  # fmt: skip


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


def random_neighbours(seed: int) -> list[wo.NipProblem]:
    """Return a seed's nip and three more, load and friction each 1 to 5 % from those before."""
    return _neighbours(seed, random_nip(seed))


def random_wrapped_neighbours(seed: int) -> list[wo.WrappedNipProblem]:
    """Return a seed's wrapped nip and three more, alike."""
    return _neighbours(seed, random_wrapped_nip(seed))


def _neighbours(seed: int, first: Any) -> list[Any]:
    draw, nips = _Draw(3_000_000 + seed), [first]
    load, friction = (1 + draw.even(0.01, 0.05) * draw.random.choice([-1, 1]) for _ in range(2))
    for k in (1, 2, 3):
        at = load**k
        nips.append(
            nips[0].replace(
                nip_load=at * nips[0].nip_load, winding_force=at * nips[0].winding_force,
                roll_friction=friction**k * nips[0].roll_friction,
            )
        )  # fmt: skip
    return nips


def random_wrapped_nip(seed: int) -> wo.WrappedNipProblem:
    """Return the nip of a seed with its wraps."""
    draw, nip = _Draw(4_000_000 + seed), random_nip(seed)
    roll_wrap, drum_wrap = draw.even(1.0, pi), draw.even(0.2, 3.0) * (seed % 2)
    if not drum_wrap:
        return nip.wrapped(roll_wrap=roll_wrap)
    taut = nip.replace(web_tension=max(nip.web_tension, 300.0))
    return taut.wrapped(roll_wrap=roll_wrap, drum_wrap=drum_wrap)


def random_rollers(seed: int) -> wo.RollerProblem:
    """Return the roll and the drum of a seed's nip as two rollers."""
    draw, nip = _Draw(5_000_000 + seed), random_nip(seed)
    friction, P = nip.roll_friction, nip.nip_load
    pull = draw.even(-0.95, 0.95) * friction * P
    creepage = draw.even(-1.5, 1.5) * friction * half_width_guess(P, *nip.bodies)
    creepage /= nip.contact_radius
    which = int(draw.random.integers(6))
    drives: list[dict[str, Any]] = [
        {"tangential_load": pull}, {"creepage": creepage}, {},
        {"motion": "static", "tangential_load": pull},
    ]  # fmt: skip
    drive = drives[(0, 0, 1, 1, 2, 3)[which]]
    return wo.RollerProblem(upper=nip.roll, lower=nip.drum, load=P, friction=friction, **drive)


def flat_fields(record: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield (dotted name, value) of a problem's ``model_dump``."""
    for name, value in record.items():
        if isinstance(value, dict):
            yield from flat_fields(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value

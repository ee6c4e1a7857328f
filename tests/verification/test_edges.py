"""The edges of the admissible range: solved, with every law kept, and reached continuously.

A single grid of 65 nodes throughout, on which NIT is a continuous function of every field.
"""

from __future__ import annotations

import numpy as np
import pytest
from random_nips import random_covered, random_low_friction
from slow_cases import slow_case
from thesis_cases import paper_nip

import woundon as wo


def cover(thickness: float, poissons_ratio: float, youngs_modulus: float = 1e7) -> wo.Cylinder:
    material = wo.Isotropic(youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)
    return wo.Cylinder(radius=0.5, core_radius=0.5 - thickness, material=material)


STIFF = wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.3)
DRUMS = {
    "hard": wo.Rigid(radius=0.5),
    "half-plane": wo.HalfPlane(radius=0.5, material=STIFF),
    "soft cover": cover(0.02, 0.1),
}
drums = pytest.mark.parametrize("drum", DRUMS.values(), ids=DRUMS)


def solved(problem: wo.NipProblem) -> wo.NipResult:
    result = wo.solve(problem, nodes=65)
    assert result.residuals.largest <= 1e-8
    return result


def share(result: wo.NipResult) -> float:
    """Return (NIT - F)/(mu+ P), what the roll's friction is used."""
    problem = result.problem
    roll_side = result.nip_induced_tension - problem.winding_force
    return roll_side / (problem.roll_friction * problem.nip_load)


@drums
@pytest.mark.parametrize("sign", [1, -1])
def test_the_winding_force_may_come_as_near_to_sliding_as_numbers_allow(
    drum: wo.Rigid, sign: int
) -> None:
    limit = 0.4 * 1900.0
    near, nearer, nearest = (
        solved(paper_nip(drum=drum, winding_force=sign * (1 - short) * limit))
        for short in (1e-4, 1e-9, 1e-15)
    )
    # the last node in stick gives way: all the drum slips one way, but for what holds the creep
    assert np.count_nonzero(nearest.drum_zone[1:-1] != sign) <= 1
    assert share(nearer) == pytest.approx(share(near), abs=1e-4)
    assert share(nearest) == pytest.approx(share(nearer), abs=1e-8)
    for beyond in (1.0, 1.0 + 1e-12):
        with pytest.raises(wo.NoSteadyState):
            paper_nip(drum=drum, winding_force=sign * beyond * limit)


@drums
@pytest.mark.parametrize("short", [1e-2, 1e-6, 1e-12])
def test_with_the_whole_roll_side_slipping_nit_is_mu_p_plus_f(drum: wo.Rigid, short: float) -> None:
    result = solved(paper_nip(drum=drum, winding_force=-(1 - short) * 0.4 * 1900.0))
    assert np.all(result.roll_zone == wo.Zone.FORWARD)
    # the load is carried to 3e-9
    assert share(result) == pytest.approx(1.0, abs=4e-9)


@drums
def test_at_vanishing_load_only_the_web_is_left(drum: wo.Rigid) -> None:
    """A nip much narrower than the web is thick: all drums give the same share of mu+ P.

    The drum and the roll still bend the nip's pressure by a relative a/2h, 1.5e-3 at 1e-9 N/m.
    """
    loads = [1.0, 1e-3, 1e-6, 1e-9]
    results = [solved(paper_nip(drum=drum, nip_load=P, winding_force=0.1 * P)) for P in loads]
    widths = [result.half_width for result in results]
    assert np.all(np.diff(widths) < 0)
    # the web's own squeezing: a third root of the load, no longer Hertz's square root
    assert np.log10(widths[2] / widths[3]) == pytest.approx(1.0, abs=0.01)
    assert share(results[3]) == pytest.approx(0.8676, abs=1e-4)


@pytest.mark.parametrize("part", ["web", slow_case("drum"), "roll"])
def test_incompressible_bodies_and_webs_are_the_limit_of_nearly_incompressible_ones(
    part: str,
) -> None:
    """NIT nears that at nu = 0.5 in proportion, down to what the load's tolerance leaves of it."""
    soft = {"roll": cover(0.001, 0.3, 3e6), "drum": cover(0.001, 0.3, 3e6)}

    def at(nu: float) -> float:
        material = wo.Isotropic(youngs_modulus=3e6 if part in soft else 3e9, poissons_ratio=nu)
        return solved(paper_nip(**soft, **{f"{part}.material": material})).nip_induced_tension

    limit = at(0.5)
    away = [abs(at(0.5 - 10.0**-k) / limit - 1) for k in range(3, 17)]
    for k, miss in enumerate(away, start=3):
        assert miss <= 1.2 * away[0] * 10.0 ** (3 - k) + 1e-8


@drums
def test_no_cross_stiffness_is_no_special_case(drum: wo.Rigid) -> None:
    def nip(cross: float) -> wo.NipResult:
        fields = {"roll.material.cross": cross, "web.material.cross": cross}
        return solved(paper_nip(drum=drum, **fields))

    none = nip(0.0)
    assert none.nip_induced_tension == pytest.approx(nip(1.0).nip_induced_tension, rel=1e-5)


@drums
def test_equal_friction_is_no_special_case(drum: wo.Rigid) -> None:
    below, equal, above = (
        solved(paper_nip(drum=drum, roll_friction=0.4 * (1 + change))).nip_induced_tension
        for change in (-1e-8, 0.0, 1e-8)
    )
    # scale: mu+ P = 760 N/m
    assert below == pytest.approx(equal, abs=1e-4)
    assert above == pytest.approx(equal, abs=1e-4)


@drums
@pytest.mark.parametrize("friction", [1e-3, 1e-6, 1e-7])
def test_hardly_any_friction_leaves_slip_everywhere(drum: wo.Rigid, friction: float) -> None:
    """Slips stay as the normal problem makes them, tractions are mu p: NIT/(mu P) has a limit."""
    low = solved(paper_nip(drum=drum, roll_friction=friction, drum_friction=friction,
                           winding_force=0.0))  # fmt: skip
    lower = solved(paper_nip(drum=drum, roll_friction=friction / 10, drum_friction=friction / 10,
                             winding_force=0.0))  # fmt: skip
    assert share(low) == pytest.approx(share(lower), abs=0.02)
    assert abs(share(low)) <= 1.0 + 1e-12


@pytest.mark.parametrize("seed", [70, 30012])
def test_little_friction_on_one_face_hides_no_violation_on_the_other(seed: int) -> None:
    """The slips of a face without friction are 1e6 times those at the zone boundaries."""
    assert wo.solve(random_low_friction(seed)).residuals.slip_direction <= 1e-10


def test_a_web_that_lifts_off_a_soft_drum_is_rejected_on_every_mesh() -> None:
    """p = T kappa is negative where the cover is concave, next to the nip; not on a stiffer one."""
    problem = random_covered(100053)
    for nodes in (41, 81):
        with pytest.raises(wo.InvalidProblem, match="drum: its deformed surface is concave"):
            wo.solve(problem, nodes=nodes)
    material = problem.drum.material
    stiffer = material.replace(youngs_modulus=8 * material.youngs_modulus)
    thicker = problem.drum.radius - 4 * problem.drum.thickness
    for change in (
        {"nip_load": problem.nip_load / 4, "winding_force": problem.winding_force / 4},
        {"drum": problem.drum.replace(material=stiffer)},
        {"drum": problem.drum.replace(core_radius=thicker)},
    ):
        assert solved(problem.replace(**change)).drum_pressure.min() >= 0

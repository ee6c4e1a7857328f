"""The discretisation converges: to which values, how fast, and the error of the default mesh.

The limits were computed by version 0.2 on two kinds of meshes, 1025 nodes graded towards the edges
only and up to 1025 graded towards the zone boundaries and extrapolated; the two agree to 3e-5 on
the scale max(|NIT|, 1 % of mu+ P) by which all errors here are measured.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from random_nips import random_nip, random_rollers, random_wrapped_nip
from slow_cases import campaign_case
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo

PAPER = wo.material("paper")


def cover(material: str | wo.Isotropic, thickness: float = 0.02) -> wo.Cylinder:
    return wo.Cylinder(radius=0.5, core_radius=0.5 - thickness, material=material)


class Nip(NamedTuple):
    problem: wo.NipProblem
    limit: float  # NIT [N/m]

    def error(self, tension: float) -> float:
        floor = 0.01 * self.problem.roll_friction * self.problem.nip_load
        return (tension - self.limit) / max(abs(self.limit), floor)


STIFF_COVER = wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.4)
NIPS = {
    "half-plane roll": Nip(paper_nip(roll=wo.HalfPlane(radius=0.3, material=PAPER)), 134.7535),
    "Table 1": Nip(paper_nip(), 135.3035),
    "Table 1, heavy": Nip(paper_nip(nip_load=4897.0), 212.7806),
    "driven": Nip(paper_nip(nip_load=1910.0, winding_force=-400.0), -37.3250),
    "driven, hardly any stick": Nip(paper_nip(nip_load=1910.0, winding_force=-500.0), -118.0700),
    "driven, light": Nip(paper_nip(nip_load=1000.0, winding_force=-200.0), -15.4743),
    "centre wound": Nip(paper_nip(nip_load=2000.0, winding_force=0.0), 115.5052),
    "newsprint": Nip(newsprint_nip(), 259.0247),
    "newsprint, light": Nip(newsprint_nip(nip_load=350.0), 43.3745),
    "newsprint, heavy": Nip(newsprint_nip(nip_load=5837.0), 364.3190),
    "steel half-plane drum": Nip(
        paper_nip(drum=wo.HalfPlane(radius=0.5, material=wo.material("steel"))), 135.1453
    ),
    "soft cover": Nip(paper_nip(drum=cover("soft-cover")), 32.4856),
    "soft cover, driven": Nip(
        paper_nip(drum=cover("soft-cover"), nip_load=5000.0, winding_force=-200.0), -1.1184
    ),
    "stiff cover": Nip(paper_nip(drum=cover(STIFF_COVER)), 118.6105),
    "rubber cover": Nip(paper_nip(drum=cover("rubber"), nip_load=5000.0), 54.8667),
    "thin rubber cover": Nip(paper_nip(drum=cover("rubber", 0.005), nip_load=5000.0), 196.9914),
    "cellular cover": Nip(paper_nip(drum=cover("cellular-elastomer"), nip_load=5000.0), 10.4725),
    "rigid roll, soft cover": Nip(
        paper_nip(roll=wo.Rigid(radius=0.3), drum=cover("soft-cover")), -16.9511
    ),
    "rough layers": Nip(paper_nip(roll_friction=0.4, drum_friction=0.2), 84.4529),
    "rough layers, driven": Nip(
        paper_nip(roll_friction=0.5, drum_friction=0.2, winding_force=-300.0), -17.1207
    ),
    "equal friction": Nip(paper_nip(roll_friction=0.3, drum_friction=0.3), 115.0613),
}


@cache
def solved(name: str, **options: Any) -> wo.NipResult:
    return wo.solve(NIPS[name].problem, **options)


@pytest.mark.parametrize("name", NIPS)
def test_the_default_meets_its_criterion(name: str) -> None:
    """0.1 % of the wound-on tension and 2 % of NIT; the largest error of NIT measured is 0.6 %."""
    result = solved(name)
    assert abs(NIPS[name].error(result.nip_induced_tension)) <= 1e-2
    miss = abs(result.nip_induced_tension - NIPS[name].limit)
    assert miss <= 1e-3 * abs(result.outlet_tension)


@pytest.mark.parametrize("name", NIPS)
def test_rtol_is_kept(name: str) -> None:
    result = wo.solve(NIPS[name].problem, rtol=1e-4)
    miss = abs(result.nip_induced_tension - NIPS[name].limit)
    # 97 % within 1.5 estimates; the limits are known to 3e-5
    assert miss <= 1.5e-4 * abs(result.outlet_tension) + 1e-4 * abs(NIPS[name].limit)
    assert result.residuals.largest <= 1e-8


@pytest.mark.parametrize("name", NIPS)
def test_the_error_estimate_is_no_promise_but_honest(name: str) -> None:
    """Zone boundaries jump from node to node: the error is not monotone in the mesh.

    The estimate covers 97 % of random nips within 1.5 estimates, all within 4; of the nips here
    one, "newsprint" on 41 nodes, reaches 3.6.
    """
    result = solved(name)
    error = abs(result.nip_induced_tension - NIPS[name].limit)
    assert error <= (4 if name == "newsprint" else 1.5) * result.nip_induced_tension_error


@pytest.mark.parametrize(
    "name",
    ["half-plane roll", "driven", "newsprint", "soft cover", "rubber cover", "rough layers"],
)
def test_the_order_is_two(name: str) -> None:
    """RMS over four neighbouring grids, so that no lucky grid decides.

    Least squares over 17 to 129 nodes; measured 1.82 (soft cover) to 2.09 here, 1.65 (soft cover,
    driven) to 2.8 over all nips.
    """
    nip, sizes = NIPS[name], np.array([17, 33, 65, 129])

    def error(nodes: int) -> float:
        return nip.error(solved(name, nodes=nodes).nip_induced_tension)

    rms = [np.sqrt(np.mean([error(M + k) ** 2 for k in (-2, 0, 1, 3)])) for M in sizes.tolist()]
    assert -np.polyfit(np.log(sizes), np.log(rms), 1)[0] >= 1.5


@pytest.mark.slow
def test_the_order_is_two_for_the_whole_set() -> None:
    """RMS over all nips; measured 2.2 over 17 to 129 nodes."""
    sizes = np.array([17, 33, 65, 129])
    rms = [
        np.sqrt(np.mean([
            nip.error(solved(name, nodes=M).nip_induced_tension) ** 2
            for name, nip in NIPS.items()
        ]))
        for M in sizes.tolist()
    ]  # fmt: skip
    assert -np.polyfit(np.log(sizes), np.log(rms), 1)[0] >= 1.75


def test_the_other_outputs_converge() -> None:
    """Soft cover; limits from 1025 nodes, tolerances twice the error measured at 129."""
    result = wo.solve(NIPS["soft cover"].problem, nodes=129)
    assert result.half_width == pytest.approx(7.4422287e-3, rel=2.2e-5)
    assert result.approach == pytest.approx(0.41238759e-3, rel=3e-6)
    assert result.offset == pytest.approx(0.04824451e-3, rel=3.4e-3)
    assert result.drum_creepage == pytest.approx(-7.0680293e-3, rel=1.2e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("problem", "output"),
    [
        (random_nip(90095), "drum_creepage"),  # the traction of the drum jumps
        (random_nip(92064), "dual"),  # a slip zone at the trailing edge is shorter than a cell
        (random_wrapped_nip(90016), "peak_pressure"),  # the maximum is a cusp at a zone boundary
        (random_wrapped_nip(950043), "peak_pressure"),  # a cusp away from the largest node
        campaign_case(random_wrapped_nip(90023), "dual"),
        (random_wrapped_nip(93027), "drum_creepage"),  # stiff drum: start of its wrap
        (random_rollers(950048), "peak_pressure"),
    ],
)
def test_the_estimates_hold_where_fields_are_not_smooth(
    problem: wo.NipProblem | wo.RollerProblem, output: str
) -> None:
    """Errors relative to Richardson's estimate of order two alone: 7, 16, 10, 26, 26, 6 and 5."""
    result, fine = wo.solve(problem), wo.solve(problem, nodes=385)
    error = abs(getattr(result, output) - getattr(fine, output))
    assert error <= 1.5 * result.error(output)


def test_the_offset_of_a_symmetric_contact_is_known_to_rounding() -> None:
    """On the fine mesh one node slips on one side only, within the tolerance of the solver."""
    result, fine = (wo.solve(random_rollers(1200013), nodes=n) for n in (129, 513))
    assert abs(fine.offset) > 1e-11 * fine.half_width
    assert abs(result.offset - fine.offset) <= 1.5 * result.error("offset")

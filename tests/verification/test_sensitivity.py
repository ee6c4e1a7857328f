"""Exact sensitivities: against central differences of solved nips, known powers, zone changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from random_nips import random_nip
from slow_cases import campaign_case, slow_case
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo


def differences(problem: Any, nodes: int, step: float, names: tuple[str, ...]) -> tuple[Any, ...]:
    """Return sensitivities, central differences, and which fields keep all zones.

    The last Newton step is below 1e-11: differences over 1e-4 are known to 1e-6.
    """
    result = wo.solve(problem, nodes=nodes)
    derivatives = result.sensitivity(*names)
    quotients, kept = [], []
    for name, value in zip(derivatives.parameters, derivatives.fields, strict=True):
        size = abs(value) or problem.nip_load
        body = getattr(problem, name.partition(".")[0])
        if isinstance(body, wo.Cylinder) and name.endswith("radius"):
            size = body.thickness  # the radii of a layer matter by their difference
        ends = [
            wo.solve(
                problem.replace(**{name: float(value) + side * step * size}),
                nodes=nodes, start=result,
            )
            for side in (1, -1)
        ]  # fmt: skip
        values = np.array(
            [[getattr(end, output) for output in derivatives.outputs] for end in ends]
        )
        quotients.append((values[0] - values[1]) / (2 * step * size))
        kept.append(all(
            np.array_equal(getattr(end, zone), getattr(result, zone))
            for end in ends for zone in ("roll_zone", "drum_zone")
        ))  # fmt: skip
    return derivatives, np.array(quotients).T, np.array(kept)


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize(
    "seed", [101, *map(slow_case, (100, 102)), *map(campaign_case, range(103, 108))]
)
def test_derivatives_are_those_of_the_solved_equations(seed: int, wrapped: bool) -> None:
    """Elasticities, those of NIT relative to at least 1 % of mu+ P."""
    problem: Any = random_nip(seed).replace(web_tension=600.0)
    if wrapped:
        problem = problem.replace(roll_wrap=2.0)
    computed, quotients, kept = differences(problem, 41, 1e-5, ())
    assert np.count_nonzero(kept) > 0.75 * kept.size
    least = 0.01 * problem.roll_friction * problem.nip_load
    scale = np.array([
        max(abs(value), least) if "tension" in name else abs(value)
        for name, value in zip(computed.outputs, computed.values, strict=True)
    ])  # fmt: skip
    size = np.where(computed.fields == 0, problem.nip_load, np.abs(computed.fields))
    exact, numerical = (d * size / scale[:, None] for d in (computed.derivatives, quotients))
    miss = np.abs(exact - numerical) / np.maximum(1.0, np.abs(numerical))
    assert miss[:, kept].max() < 1e-3


def test_error_estimates_of_derivatives_hold() -> None:
    problem = newsprint_nip(winding_force=-100.0)
    names = ("nip_load", "roll_friction", "web.thickness", "roll.material.shear")
    coarse, fine = (wo.solve(problem, nodes=n).sensitivity(*names) for n in (65, 513))
    miss = np.abs(coarse.derivatives - fine.derivatives)
    assert np.all(miss <= 4 * (coarse.errors + fine.errors) + 1e-9 * np.abs(fine.derivatives))


@pytest.mark.parametrize("problem", [newsprint_nip(winding_force=-100.0), random_nip(0)])
def test_one_unit_of_stress_or_length_for_another_changes_nothing(problem: wo.NipProblem) -> None:
    """Euler's theorem: tensions have the degree of a line load, widths that of a length.

    All moduli and line loads times c: tensions times c, widths as they were.  All lengths and line
    loads times c: tensions and widths times c.  Creep has no degree.  1e-5: forward differences,
    good to 1e-6 each, some twenty in the sum.
    """
    outputs = ("nip_induced_tension", "half_width", "nip_width", "drum_creepage")
    s = wo.solve(problem, nodes=65).sensitivity(outputs=outputs)
    last = [name.rpartition(".")[2] for name in s.parameters]
    loads = np.isin(last, ["nip_load", "winding_force", "web_tension"])
    moduli = np.isin(last, ["radial", "tangential", "cross", "shear", "youngs_modulus"])
    lengths = np.isin(last, ["radius", "core_radius", "thickness"])
    stress = s.elasticities[:, loads | moduli].sum(axis=1)
    size = s.elasticities[:, loads | lengths].sum(axis=1)
    np.testing.assert_allclose(stress, [1.0, 0.0, 0.0, 0.0], atol=1e-5)
    np.testing.assert_allclose(size, [1.0, 1.0, 1.0, 0.0], atol=1e-5)


def test_the_winding_theorem_web_tension_moves_neither_nit_nor_width() -> None:
    s = wo.solve(newsprint_nip(), nodes=65).sensitivity("web_tension")
    assert s.derivative("nip_induced_tension", "web_tension") == 0.0
    assert s.derivative("half_width", "web_tension") == 0.0
    assert s.derivative("outlet_tension", "web_tension") == pytest.approx(1.0, rel=1e-8)
    # the creep refers to the unstrained web: xi- falls by the strain, c11/(2h) a unit of tension
    assert s.derivative("drum_creepage", "web_tension") < 0.0


def test_where_the_whole_roll_side_slips_nit_is_mu_p_plus_f() -> None:
    result = wo.solve(paper_nip(nip_load=1910.0, winding_force=-520.0))
    assert np.all(result.roll_zone == wo.Zone.FORWARD)
    s = result.sensitivity("roll_friction", "nip_load", "winding_force")
    exact = [1910.0, 0.2, 1.0]
    np.testing.assert_allclose(s.derivatives[0], exact, rtol=1e-6)


def test_what_is_one_number_twice_has_one_slope() -> None:
    """2a is a twice, WOT = T_out is T_in + NIT: so are their derivatives by every other field."""
    s = wo.solve(newsprint_nip(winding_force=50.0), nodes=65).sensitivity()
    WOT, NIT, T_out, a, width, *_ = s.derivatives
    # rounding of central differences
    np.testing.assert_allclose(width, 2 * a, rtol=1e-7, atol=1e-15)
    others = np.array(s.parameters) != "web_tension"
    np.testing.assert_array_equal(WOT, T_out)
    np.testing.assert_allclose(T_out[others], NIT[others], rtol=1e-7)


@pytest.mark.slow
def test_a_zone_change_is_announced_and_its_two_sides_differ() -> None:
    # on a soft cover a node's change is felt; on a hard drum the two slopes are nearly the same
    cover = wo.Cylinder(radius=0.5, core_radius=0.48, material=wo.material("soft-cover"))
    problem, nodes = paper_nip(drum=cover), 33

    def solved(load: float) -> wo.NipResult:
        return wo.solve(problem.replace(nip_load=load), nodes=nodes)

    def zones(result: wo.NipResult) -> bytes:
        return result.roll_zone.tobytes() + result.drum_zone.tobytes()

    low, high = 1900.0, 2500.0
    before = zones(solved(low))
    assert zones(solved(high)) != before
    for _ in range(60):  # to the last digit
        middle = (low + high) / 2
        low, high = (middle, high) if zones(solved(middle)) == before else (low, middle)
    sides = [solved(load).sensitivity("nip_load") for load in (low, high)]
    assert [side.zone_change for side in sides] == ["drum node 23"] * 2
    assert solved(1900.0).sensitivity("nip_load").zone_change == ""
    # the mesh's NIT is continuous there, its slope is not
    NIT = [solved(load).nip_induced_tension for load in (low, high)]
    assert NIT[0] == pytest.approx(NIT[1], 1e-9)
    slopes = [side.derivative("nip_induced_tension", "nip_load") for side in sides]
    assert slopes[0] != pytest.approx(slopes[1], rel=0.1)


def test_elasticities_are_sorted_and_zero_fields_keep_their_derivative() -> None:
    s = wo.solve(newsprint_nip(), nodes=33).sensitivity()
    ordered = s.sorted()
    of_nit = np.abs(ordered.elasticities[0])
    assert np.all(np.diff(of_nit) <= 0)
    assert sorted(ordered.parameters) == sorted(s.parameters)
    for name in s.parameters:
        assert ordered.derivative("half_width", name) == s.derivative("half_width", name)
    # F = 0 has no percent, but moves NIT: by 0.3 to 0.5 N/m per N/m
    assert ordered.elasticities[0][ordered.parameters.index("winding_force")] == 0.0
    assert 0.2 < s.derivative("nip_induced_tension", "winding_force") < 0.6


def test_the_cross_stiffness_of_a_roller_may_be_zero():
    """Its step is relative to the radial modulus of the same body.

    Only values above zero are permitted: both derivatives are differences of order two, over steps
    of 1e-4 and of less of the radial modulus, which agree to the square of the larger one and to
    the rounding of solved equations (1e-11) over it.
    """
    cover = wo.Orthotropic(radial=40e6, tangential=60e6, cross=0.0, shear=15e6)
    upper = wo.Cylinder(radius=0.25, core_radius=0.235, material=cover)
    rollers = wo.RollerProblem.example().replace(upper=upper, load=5e3, tangential_load=500.0)
    result, step = wo.solve(rollers, nodes=41), 1e-4 * cover.radial
    exact = result.sensitivity("upper.material.cross", outputs=("half_width",))
    near, far = (
        wo.solve(rollers.replace(**{"upper.material.cross": k * step}), nodes=41, start=result)
        for k in (1, 2)
    )
    quotient = (4 * near.half_width - far.half_width - 3 * result.half_width) / (2 * step)
    assert exact.derivatives.item() == pytest.approx(quotient, rel=1e-5)


def test_outputs_that_are_evaluated_on_request_have_their_derivatives() -> None:
    """The approach and the slip lengths are left out where others are differentiated."""
    nip = random_nip(3)
    step = 1e-4 * nip.nip_load
    result = wo.solve(nip, nodes=41)
    (mesh,) = result.refinement.meshes[-1:]
    assert "approach" not in mesh.system.outputs(mesh.state, mesh.active, ["half_width"])
    slopes = result.sensitivity("nip_load", outputs=["approach", "dual"])
    below, above = (
        wo.solve(nip.replace(nip_load=nip.nip_load + sign * step), nodes=41, start=result)
        for sign in (-1, 1)
    )
    difference = (above.approach - below.approach) / (2 * step)
    assert slopes.derivative("approach", "nip_load") == pytest.approx(difference, rel=1e-5)

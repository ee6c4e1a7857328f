"""Exact sensitivities: against central differences of solved nips, known powers, zone changes.

The same comparison over 100 cases on 257 nodes: benchmarks/sensitivities.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from random_nips import random_nip
from refusals import refused_in_one_line
from seldom import seldom
from sensitivities import ACCEPTED, MET, compared, of_mesh, own_of_mesh
from thesis_cases import newsprint_nip, paper_nip
from woundon.wrap import solve as wrap_solve

import woundon as wo
from woundon.contact import loop

MAIN = (
    "wound_on_tension", "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width",
    "drum_creep",
)  # fmt: skip


@pytest.mark.parametrize("seed", [*range(100, 105), *map(seldom, range(105, 110))])
def test_derivatives_are_those_of_the_solved_equations(seed: int) -> None:
    """Measured over 100 seeds on 257 nodes: 1e-6 at the worst, as the differences' noise is."""
    row = compared(seed, nodes=65, wide=False)
    assert "failure" not in row, row
    assert row["at_zone_change"] < row["fields"] / 4
    assert row["largest_difference"] <= ACCEPTED, row


@pytest.mark.parametrize("force", [0.0, -100.0])
@pytest.mark.parametrize("wrapped", [False, True])
def test_derivatives_are_those_of_the_tensions_told(
    wrapped: bool, force: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With what borders at rest change by, on a mesh so coarse that this counts.

    The worst of five elasticities was 2e-4 to 1.2e-3 off central differences, those of the mesh's
    own tensions 5e-3 to 2e-2, 12 to 40 times as much.  What is left is what the influence of the
    borders' nodes changes by; the steps' square is 1e-8, and loads met to 1e-10 leave 1e-6.
    """
    monkeypatch.setattr(loop, "FINE", MET)
    monkeypatch.setattr(wrap_solve, "FINE", loop.Tolerance(load=1e-10, balance=1e-10))
    problem = newsprint_nip(winding_force=force)
    if wrapped:
        problem = problem.wrapped(roll_wrap=2.0, drum_wrap=1.5)
    output, step = "wound_on_tension" if wrapped else "nip_induced_tension", 1e-4
    names = ("nip_load", "roll_friction", "web.thickness", "roll.radius", "roll.material.shear")
    result = wo.solve(problem, nodes=33)
    with own_of_mesh():
        own = wo.solve(problem, nodes=33).sensitivity(*names)
    told = result.sensitivity(*names)
    row = told.outputs.index(output)
    ends = [
        [
            getattr(wo.solve(problem.replace(**{name: value * (1 + side)}), nodes=33, start=result),
                    output)
            for side in (step, -step)
        ]
        for name, value in zip(names, told.fields, strict=True)
    ]  # fmt: skip
    differences = -np.diff(np.log(ends)).ravel() / (2 * step)
    assert told.values[row] == getattr(result, output)
    off, by_own = (np.abs(s.elasticities[row] - differences).max() for s in (told, own))
    assert off < 2e-3
    assert off < by_own / 8


@pytest.mark.parametrize("name", ["hard drum", seldom("hybrid"), seldom("20 mm cover")])
def test_derivatives_on_elements_are_those_of_the_continuous_nip(name: str) -> None:
    """On 257 graded nodes they were 1e-4 to 6e-2 off; differences over h leave 1e-8 / h."""
    problem = {
        "hard drum": paper_nip(),
        "hybrid": paper_nip(nip_load=1910.0, winding_force=-400.0),
        "20 mm cover": paper_nip(
            drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=wo.material("soft-cover"))
        ),
    }[name]
    outputs = ("nip_induced_tension", "half_width", "drum_creep", "rig_tension")
    result = wo.solve(problem, rtol=1e-6)
    assert result.scheme == "elements"
    found = result.sensitivity("roll_friction", "web.thickness", outputs=outputs)
    for field, value in zip(found.parameters, found.fields, strict=True):
        h = 5e-4 * value
        more, less = (wo.solve(problem.replace(**{field: value + d}), rtol=1e-7) for d in (h, -h))
        for output in outputs:
            difference = (getattr(more, output) - getattr(less, output)) / (2 * h)
            # an output that hardly moves by a field is known to 1e-7 of itself
            least = 1e-2 * abs(getattr(result, output)) / value
            off = abs(found.derivative(output, field) - difference)
            assert off < 1e-4 * max(abs(difference), least), (output, field)


def test_derivatives_on_elements_are_the_same_of_a_file(tmp_path) -> None:
    result = wo.solve(newsprint_nip(), rtol=1e-6)
    result.save(tmp_path / "nip.nc")
    again = wo.load_result(tmp_path / "nip.nc").sensitivity("nip_load")
    assert again.derivatives == pytest.approx(result.sensitivity("nip_load").derivatives, rel=1e-9)


def test_only_the_named_fields_are_answered_in_their_order() -> None:
    result = wo.solve(newsprint_nip(), nodes=33)
    some = result.sensitivity("nip_load", "roll.material.shear")
    every = result.sensitivity()
    assert some.parameters == ("nip_load", "roll.material.shear")
    for name in some.parameters:
        for output in some.outputs:
            known = every.derivative(output, name)  # but for rounding
            assert some.derivative(output, name) == pytest.approx(known, rel=1e-10, abs=0)
    with pytest.raises(wo.InvalidProblem, match=r"did you mean 'roll\.material\.shear'"):
        result.sensitivity("roll.material.sheer")


def test_only_the_named_outputs_are_answered_in_their_order() -> None:
    """The tension at the load cell of a rig, which costs more, only where it is one of them."""
    result = wo.solve(newsprint_nip(), nodes=33)
    every, outputs = result.sensitivity("nip_load", "roll.radius"), ("rig_tension", "half_width")
    some = result.sensitivity("nip_load", "roll.radius", outputs=outputs)
    assert some.outputs == outputs
    assert "rig_tension" not in every.outputs
    assert some.values.tolist() == [result.rig_tension, result.half_width]
    np.testing.assert_allclose(some.derivatives[1], every.derivatives[2], rtol=1e-10)
    one = result.sensitivity("nip_load", "roll.radius", outputs="rig_tension")
    np.testing.assert_allclose(one.derivatives[0], some.derivatives[0], rtol=1e-10)


@pytest.mark.parametrize("wrapped", [False, True])
def test_an_output_without_derivative_is_refused_by_name(wrapped: bool) -> None:
    problem = newsprint_nip().wrapped() if wrapped else newsprint_nip()
    result = wo.solve(problem, nodes=33)
    told = "outputs: no exact derivative of 'half_widht' is known; did you mean 'half_width'?"
    refused_in_one_line(lambda: result.sensitivity(outputs=("half_widht",)), told)
    known = () if wrapped else ("rig_tension",)
    assert result.sensitivity("nip_load", outputs=known).outputs == (known or MAIN)


@pytest.mark.parametrize("problem", [newsprint_nip(winding_force=-100.0), random_nip(0)])
def test_one_unit_of_stress_or_length_for_another_changes_nothing(problem: wo.NipProblem) -> None:
    """Euler's theorem: tensions have the degree of a line load, widths that of a length.

    All moduli and line loads times c: tensions times c, widths as they were.  All lengths and line
    loads times c: tensions and widths times c.  Creep has no degree.  1e-5: forward differences,
    good to 1e-6 each, some twenty in the sum.
    """
    outputs = ("nip_induced_tension", "half_width", "nip_width", "drum_creep", "rig_tension")
    with own_of_mesh():
        s = wo.solve(problem, nodes=65).sensitivity(outputs=outputs)
    last = [name.rpartition(".")[2] for name in s.parameters]
    loads = np.isin(last, ["nip_load", "winding_force", "web_tension"])
    moduli = np.isin(last, ["radial", "tangential", "cross", "shear", "youngs_modulus"])
    lengths = np.isin(last, ["radius", "core_radius", "thickness"])
    stress = s.elasticities[:, loads | moduli].sum(axis=1)
    size = s.elasticities[:, loads | lengths].sum(axis=1)
    np.testing.assert_allclose(stress, [1.0, 0.0, 0.0, 0.0, 1.0], atol=1e-5)
    np.testing.assert_allclose(size, [1.0, 1.0, 1.0, 0.0, 1.0], atol=1e-5)


def test_the_winding_theorem_web_tension_moves_neither_nit_nor_width() -> None:
    s = wo.solve(newsprint_nip(), nodes=65).sensitivity("web_tension")
    assert s.derivative("nip_induced_tension", "web_tension") == 0.0
    assert s.derivative("half_width", "web_tension") == 0.0
    assert s.derivative("tension_behind_nip", "web_tension") == pytest.approx(1.0, rel=1e-8)
    # the creep refers to the unstrained web: xi- falls by the strain, c11/(2h) a unit of tension
    assert s.derivative("drum_creep", "web_tension") < 0.0


def test_where_the_whole_roll_side_slips_nit_is_mu_p_plus_f() -> None:
    result = wo.solve(paper_nip(nip_load=1910.0, winding_force=-520.0))
    assert np.all(result.roll_zone == wo.Zone.FORWARD)
    s = result.sensitivity("roll_friction", "nip_load", "winding_force")
    exact = [1910.0, 0.2, 1.0]
    np.testing.assert_allclose(s.derivatives[0], exact, rtol=1e-6)


def test_what_is_one_number_twice_has_one_slope() -> None:
    """2a is a twice, T_out is T_in + NIT: so are their derivatives by every other field."""
    with own_of_mesh():
        s = wo.solve(newsprint_nip(winding_force=50.0), nodes=65).sensitivity()
    NIT, T_out, a, width, *_ = s.derivatives
    # rounding, of systems of a condition of 1e4
    np.testing.assert_allclose(width, 2 * a, rtol=1e-10)
    others = np.array(s.parameters) != "web_tension"
    np.testing.assert_allclose(T_out[others], NIT[others], rtol=1e-10)


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
    NIT = [of_mesh(solved(load), "nip_induced_tension") for load in (low, high)]
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

"""Exact sensitivities of wrapped nips: against differences, by change of units, in fits."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from derivatives import check_sensitivity
from hardening_cases import nip, roll
from random_nips import random_nip
from slow_cases import campaign_case, slow_case

import woundon as wo

COVER = wo.Cylinder(radius=0.0762, core_radius=0.06, material=wo.material("soft-cover"))
PAPER: Any = wo.NipProblem.example().replace(roll_wrap=0.0)
HARDENS = nip(roll(shear_exponent=0.3)).replace(roll_wrap=pi / 2, drum_wrap=pi)
# problem, fields (all where none is named), nodes, step of the differences
CASES: dict[str, tuple[Any, list[str], int, float]] = {
    "roll's arc": (PAPER.replace(roll_wrap=pi / 2, wrap_friction=0.3), [], 33, 1e-4),
    "both arcs": (
        PAPER.replace(roll_wrap=2.0, drum_wrap=3.0, drum=COVER, winding_force=50.0), [], 33, 1e-4
    ),
    "no arc": (PAPER.replace(roll_wrap=0.0, drum=COVER), ["roll.radius", "nip_load"], 33, 1e-4),
    "hardening": (HARDENS, ["roll.stack.radial.K2"], 17, 1e-3),
    "hardening, more": (
        HARDENS, ["roll.stack.radial.K1", "roll.stack.shear", "roll.stack.shear_exponent",
                  "roll.pressure", "nip_load", "roll_friction", "web.thickness", "roll.radius"],
        17, 1e-3,
    ),
}  # fmt: skip


LONG = {"roll's arc": slow_case, "both arcs": slow_case, "hardening, more": campaign_case}


@pytest.mark.parametrize("case", [LONG[case](case) if case in LONG else case for case in CASES])
def test_derivatives_are_those_of_the_solved_equations(
    case: str,
) -> None:
    """Central differences leave the step's square, 1e-6, and where a node changes zone within the
    step, which does not happen here, more; the arcs' ends leave 1e-7 of the curvature over the
    step, 1e-3 of what one node of a hundred does; a tangent may be 1e-4 old.
    """
    problem, names, nodes, step = CASES[case]
    result = wo.solve(problem, nodes=nodes)
    outcome = result.sensitivity(*names)
    scale = np.abs(outcome.values)
    scale[1] = max(scale[1], 0.01 * problem.roll_friction * problem.nip_load)
    for k, name in enumerate(outcome.parameters):
        size = abs(outcome.fields[k]) or problem.roll_friction * problem.nip_load
        if isinstance(problem.drum, wo.Cylinder) and name.startswith("drum.") and "radius" in name:
            size = problem.drum.thickness  # of a layer the radii matter by their difference
        less, more = (
            wo.solve(
                problem.replace(**{name: float(outcome.fields[k]) + side * step * size}),
                nodes=nodes, start=result,
            )
            for side in (-1, 1)
        )  # fmt: skip
        for end in (less, more):
            np.testing.assert_array_equal(end.roll_zone, result.roll_zone)
            np.testing.assert_array_equal(end.drum_zone, result.drum_zone)
        ends = [
            np.array([getattr(end, output) for output in outcome.outputs]) for end in (less, more)
        ]
        by_difference = (ends[1] - ends[0]) / (2 * step * scale)
        np.testing.assert_allclose(
            outcome.derivatives[:, k] * size / scale,
            by_difference,
            rtol=1e-3,
            atol=2e-5,
            err_msg=name,
        )


@pytest.mark.parametrize("seed", [1, *map(slow_case, (4, 9))])
def test_random_nips_with_wraps_too(
    seed: int,
) -> None:
    """Measured over 14 seeds: 4e-5 at the worst, by the drum's radius, with which its arc moves."""
    result = wo.solve(random_nip(seed).replace(roll_wrap=2.0, drum_wrap=1.5 * (seed % 2)), nodes=33)
    names = ("nip_load", "roll_friction", "web.thickness", "drum.radius", "web_tension")
    check_sensitivity(result, names, ["wound_on_tension"], step=1e-4, rtol=0.0, atol=1e-4)


@pytest.mark.slow
def test_one_unit_of_stress_or_length_for_another_changes_nothing() -> None:
    """Euler's theorem, of a roll that hardens; K1 and P0 are stresses.  See the plain nips'.

    3e-3: a dozen differences, good to 1e-4 each where the tangent is old, with terms up to 1.
    """
    s = wo.solve(nip(roll()).replace(roll_wrap=pi / 2, drum_wrap=pi), nodes=17).sensitivity()
    last = [name.rpartition(".")[2] for name in s.parameters]
    loads = np.isin(last, ["nip_load", "winding_force", "web_tension"])
    stresses = ["K1", "pressure", "radial", "tangential", "cross", "shear"]
    lengths = np.isin(last, ["radius", "core_radius", "thickness"])
    stress = s.elasticities[:, loads | np.isin(last, stresses)].sum(axis=1)
    size = s.elasticities[:, loads | lengths].sum(axis=1)
    np.testing.assert_allclose(stress, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], atol=3e-3)
    np.testing.assert_allclose(size, [1.0, 1.0, 1.0, 1.0, 1.0, 0.0], atol=3e-3)


def test_a_wrap_that_is_not_there_has_no_derivative() -> None:
    result = wo.solve(PAPER.replace(roll_wrap=pi / 2), nodes=17)
    assert "drum_wrap" not in result.sensitivity().parameters
    with pytest.raises(wo.InvalidProblem, match="drum_wrap: 0 has no derivative: with a wrap the "):
        result.sensitivity("drum_wrap")
    with pytest.raises(wo.InvalidProblem, match="did you mean 'roll_wrap'"):
        result.sensitivity("roll_wrp")

"""Wrapped nips started from a neighbour, near and far: the same answer as from nothing."""

from __future__ import annotations

import math
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slow_cases import slow_case
from thesis_cases import paper_nip

import woundon as wo

MESH = {"nodes": 33}
COVER = wo.Cylinder(
    radius=0.25, core_radius=0.235, material=wo.Isotropic(youngs_modulus=1e7, poissons_ratio=0.4)
)
HARD = paper_nip(web_tension=300.0).replace(roll_wrap=pi)
BASES = {
    "hard": HARD,
    "both wraps": HARD.replace(drum_wrap=1.5),
    "cover": HARD.replace(drum=COVER, drum_wrap=0.7),
}
# ways to be far: each alone would spoil a guess of width, zones, tension or curvature
FAR: dict[str, dict[str, Any]] = {
    "ten times the load": {"nip_load": 10 * HARD.nip_load},
    "a tenth of the load": {"nip_load": 0.1 * HARD.nip_load, "winding_force": 0.0},
    "another roll": {"roll.radius": 0.07},
    "another drum": {"drum.radius": 0.8},
    "other friction": {"roll_friction": 0.06, "drum_friction": 0.8},
    "four times the tension": {"web_tension": 4 * HARD.web_tension},
    "pulled the other way": {"winding_force": -HARD.winding_force},
    "other wraps": {"roll_wrap": 0.5, "drum_wrap": 3.0},
}


@cache
def solved(name: str) -> wo.NipResult:
    return wo.solve(BASES[name], **MESH)


def assert_same(one: wo.NipResult, other: wo.NipResult) -> None:
    """Assert that two results are equal to the tolerance of the solver."""
    top = float(np.max(one.drum_pressure))
    size = one.problem.web_tension + one.problem.roll_friction * one.problem.nip_load
    assert other.tension[-1] == pytest.approx(one.tension[-1], abs=3e-8 * size)
    assert other.half_width == pytest.approx(one.half_width, rel=1e-8)
    np.testing.assert_array_equal(one.roll_zone, other.roll_zone)
    np.testing.assert_array_equal(one.drum_zone, other.drum_zone)
    for name in ("drum_pressure", "roll_pressure", "roll_traction", "drum_traction"):
        np.testing.assert_allclose(getattr(other, name) / top, getattr(one, name) / top,
                                   rtol=0, atol=1e-7, err_msg=name)  # fmt: skip


@pytest.mark.parametrize("far", [far if k < 3 else slow_case(far) for k, far in enumerate(FAR)])
def test_a_start_far_away_does_not_move_the_answer(far: str) -> None:
    problem = BASES["both wraps"].replace(**FAR[far])
    cold = wo.solve(problem, **MESH)
    assert_same(cold, wo.solve(problem, **MESH, start=solved("both wraps")))
    # and not from a case without an arc on the drum, or other bodies
    assert_same(cold, wo.solve(problem, **MESH, start=solved("hard")))
    assert_same(cold, wo.solve(problem, **MESH, start=solved("cover")))


def factors(most: float) -> Any:
    return st.floats(-1.0, 1.0).map(lambda share: most**share)


@pytest.mark.slow
@settings(max_examples=15)
@given(
    name=st.sampled_from(sorted(BASES)), load=factors(10), tension=factors(4), roll=factors(3),
    drum=factors(3), friction=factors(3), force=st.floats(-0.9, 0.9), wrap=st.floats(0.05, pi),
)  # fmt: skip
def test_neighbours_hand_on_a_start_that_does_not_move_the_answer(
    name: str, load: float, tension: float, roll: float, drum: float, friction: float,
    force: float, wrap: float,
) -> None:  # fmt: skip
    base = BASES[name]
    problem = base.replace(
        nip_load=load * base.nip_load, web_tension=tension * base.web_tension,
        roll_friction=friction * base.roll_friction, roll_wrap=wrap,
        winding_force=force * base.drum_friction * base.nip_load * load,
        **{"roll.radius": max(roll * base.roll.radius, 0.06),
           "drum.radius": max(drum, 1.0) * base.drum.radius},
    )  # fmt: skip
    try:
        cold = wo.solve(problem, **MESH)
    except (wo.InvalidProblem, wo.NoSteadyState, wo.NotConverged) as refused:
        with pytest.raises(type(refused)):
            wo.solve(problem, **MESH, start=solved(name))
        return
    assert_same(cold, wo.solve(problem, **MESH, start=solved(name)))


@pytest.mark.parametrize("far", ["", *FAR])
def test_the_last_mesh_alone_has_the_same_solution(far: str) -> None:
    """If the iteration fails from a start that is far away, all meshes are solved."""
    fields = FAR[far] if far else {"nip_load": 1.02 * HARD.nip_load}
    problem = BASES["both wraps"].replace(**fields)
    options: dict[str, Any] = {**MESH, "start": solved("both wraps")}
    alone = wo.solve(problem, **options, errors=False)
    assert_same(wo.solve(problem, **options), alone)
    assert far or np.isnan(alone.error("wound_on_tension"))


def test_error_estimates_are_omitted_only_with_a_start() -> None:
    alone = wo.solve(HARD, **MESH, errors=False)
    assert alone.error("wound_on_tension") > 0
    started = wo.solve(HARD, **MESH, start=wo.solve(HARD, nodes=25), errors=False)
    assert math.isnan(started.error("wound_on_tension"))
    assert started.wound_on_tension == pytest.approx(alone.wound_on_tension, rel=1e-9)


def test_a_solution_of_the_same_problem_keeps_its_last_mesh() -> None:
    known = wo.solve(HARD, **MESH, start=wo.solve(HARD, nodes=25), errors=False)
    estimated = wo.solve(HARD, **MESH, start=known)
    assert estimated.refinement.last is known.refinement.last
    cold = wo.solve(HARD, **MESH).error("wound_on_tension")
    # coarse meshes are solved to 1e-5
    assert estimated.error("wound_on_tension") == pytest.approx(cold, rel=0.05)


def test_the_page_and_studies_start_from_the_case_before() -> None:
    from woundon.studies.model import KindModel

    model = KindModel(HARD, ("wound_on_tension",), {"nodes": 33})
    first = model.run({}, None)
    near = {"nip_load": 1.02 * HARD.nip_load}
    warm, cold = model.run(near, first.state), model.run(near, None)
    assert warm.state.iterations < cold.state.iterations
    assert warm.values == pytest.approx(cold.values, rel=1e-6)

"""Mesh refinement: error estimates, sizes of meshes, where the refinement ends."""

from __future__ import annotations

from math import isnan
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.contact import refinement
from woundon.contact.newton import NewtonFailed
from woundon.contact.refinement import (
    FIRST_SIZES,
    OTHER_SIZES,
    refine,
    richardson_estimates,
    sizes_up_to,
)  # fmt: skip


def estimated(f: Any, sizes: tuple[int, ...] = (20, 40, 80), order: int = 2) -> float:
    return float(richardson_estimates(sizes, [f(n) for n in sizes], order))


@pytest.mark.parametrize("sizes", [(20, 40, 80), (23, 41, 57), (13, 23, 41)])
def test_of_second_order_the_estimate_is_three_times_the_error(sizes: tuple[int, ...]) -> None:
    """Q = 1 + c/n^2: Richardson's extrapolation is exact, times Roache's factor of safety."""
    c = -0.7
    estimate = estimated(lambda n: 1 + c / n**2, sizes)
    assert estimate == pytest.approx(3 * abs(c) / sizes[-1] ** 2, rel=1e-12)


def test_of_first_order_the_estimate_is_three_times_the_error() -> None:
    estimate = estimated(lambda n: 1 - 0.7 / n, order=1)
    assert estimate == pytest.approx(3 * 0.7 / 80, rel=1e-12)


def test_a_change_that_is_small_by_chance_is_not_believed() -> None:
    """The largest of the changes counts, as much as its mesh is coarser than the last one."""
    values = {20: 1.04, 40: 1.01, 80: 1.01}
    estimate = estimated(values.__getitem__)
    assert estimate == pytest.approx(3 * 0.03 / 3 / 4, rel=1e-12)
    older = {10: 1.40, 20: 1.04, 40: 1.01, 80: 1.01}
    estimate = estimated(older.__getitem__, (10, 20, 40, 80))
    assert estimate == pytest.approx(3 * 0.36 / 3 / 16, rel=1e-12)


def test_two_meshes_are_no_estimate_and_no_change_is_the_tolerance_of_the_solver() -> None:
    assert isnan(estimated(float, (20, 40)))
    assert estimated(lambda n: 5.0) == refinement.FINAL_TOLERANCE * 5.0


class Toy:
    """A system without unknown tractions: one unknown ln a, outputs of second order in the size."""

    scales, traction_unknowns, creepage_nodes = np.ones(1), np.zeros(0, dtype=int), ()
    ln_a = load_rows = np.array([0])
    largest_ln_a = np.array([10.0])

    def __init__(self, size: int, fails: tuple[int, ...] = ()) -> None:
        self.size, self.fails = size, fails

    def evaluate(self, u: Any, tolerance: float) -> Any:
        class State:
            pass

        state: Any = State()
        rest = u[:1] - 0.5 / self.size**2 + (np.nan if self.size in self.fails else 0.0)
        state.u, state.equilibrium = u, rest
        state.slip = state.traction = state.bound = np.zeros(0)
        return state

    def jacobian(self, state: Any) -> Any:
        from woundon.contact.newton import Jacobian

        return Jacobian(np.ones((1, 1)), np.zeros((0, 1)), np.zeros((0, 1)))

    def fill_half_width_column(self, jacobian: Any, state: Any) -> None:
        """Do nothing: the derivatives are constant."""

    def initial_guess(self) -> Any:
        return np.zeros(1), np.zeros(0, dtype=np.int8)

    def prolong(self, state: Any, active: Any, coarse: Any) -> Any:
        return state.u.copy(), active

    def main_outputs(self, state: Any) -> dict[str, float]:
        return {"Q": 1 + float(state.u[0])}

    def outputs(self, state: Any, active: Any) -> dict[str, float]:
        return {**self.main_outputs(state), "other": 2.0}


def test_refinement_ends_where_the_tolerance_is_met() -> None:
    tolerance = 3e-4
    found = refine(Toy, tolerances=lambda outputs: {"Q": tolerance})
    sizes = [mesh.size for mesh in found.meshes]
    assert tuple(sizes[:3]) == FIRST_SIZES
    # 3 * 0.5/n^2 <= 3e-4 from n = 71 on, and the prediction aims at 0.6 of it
    assert sizes[-1] in (72, 73, 80, 81, 88, 89, 97)
    assert found.errors()["Q"] <= tolerance < 1.5 / sizes[-2] ** 2
    assert abs(found.last.outputs["Q"] - 1) == pytest.approx(found.errors()["Q"] / 3, rel=1e-6)
    assert found.iterations >= len(sizes)


def test_meshes_before_the_last_are_solved_to_a_hundredth_of_the_tolerance() -> None:
    solved = wo.solve(wo.NipProblem.example(), rtol=1e-2).refinement
    assert solved is not None
    *coarse, last = (mesh.solver.step_size for mesh in solved.meshes)
    assert 1e-5 < max(coarse) < 1e-4
    assert last < 1e-11


def test_a_loose_tolerance_begins_with_coarser_meshes() -> None:
    loose = refine(Toy, tolerances=lambda outputs: {"Q": 1e-2}, rtol=1e-2)
    sizes = [mesh.size for mesh in loose.meshes]
    assert sizes[:3] == [7, 13, 23]
    assert sizes[3] in range(29, 34)  # 1.3 times the last, the least of a further mesh
    assert len(sizes) == 4  # the estimate on 23 nodes, 2.8e-3, meets the tolerance already
    assert loose.errors()["Q"] == pytest.approx(1.5 / sizes[3] ** 2)  # of order two, with factor 3


def test_two_meshes_that_agree_by_chance_do_not_end_the_refinement() -> None:
    """The third last change counts as well; the estimate that decides is the reported one."""

    class Erratic(Toy):
        def main_outputs(self, state: Any) -> dict[str, float]:
            return {"Q": 0.9 if self.size == 13 else 1.08 if self.size < 90 else 1.09}

    tolerance = 1e-2  # the estimate on 81 nodes is 3 * 0.18/2.13 (23/81)^2 = 0.02
    found = refine(Erratic, tolerances=lambda outputs: {"Q": tolerance})
    assert [mesh.size for mesh in found.meshes[:4]] == [13, 23, 41, 81]
    assert found.last.size > 81
    assert found.errors()["Q"] <= tolerance


def test_refinement_ends_at_the_largest_mesh_or_at_the_nodes_requested() -> None:
    never = {"tolerances": lambda outputs: {"Q": 1e-30}}
    assert refine(Toy, most_nodes=129, **never).last.size == 129
    assert [mesh.size for mesh in refine(Toy, nodes=65).meshes] == sizes_up_to(65)
    seen: list[float] = []
    refine(Toy, nodes=65, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_other_first_meshes_are_tried_where_the_iteration_fails() -> None:
    fails = FIRST_SIZES[1:2]
    found = refine(lambda size: Toy(size, fails), nodes=45)
    assert tuple(mesh.size for mesh in found.meshes) == OTHER_SIZES
    with pytest.raises(NewtonFailed):
        refine(lambda size: Toy(size, (*fails, *OTHER_SIZES)), nodes=45)


def test_a_start_that_fails_is_replaced_by_the_initial_guess() -> None:
    class Unguided(Toy):
        def prolong(self, state: Any, active: Any, coarse: Any) -> Any:
            if isinstance(coarse, Unguided):
                return Toy.prolong(self, state, active, coarse)
            return np.full(1, np.nan), active

    start = refine(Toy, nodes=41)
    found = refine(Unguided, nodes=41, start=start)
    assert found.last.outputs["Q"] == pytest.approx(start.last.outputs["Q"], rel=1e-14)

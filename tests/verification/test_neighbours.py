"""Cases from their neighbours: on one mesh, their errors told by how the neighbours scatter.

``benchmarks/error_estimate.py --of neighbours`` asks the same of hundreds of random nips.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from random_nips import random_nip
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon.contact import loop
from woundon.contact.schemes import Graded
from woundon.contact.zones import Runs
from woundon.nip.scatter import by_cells
from woundon.nip.solve import CHOSEN, NipContact

SEEDS = range(50150, 50155)
STEPS = 5


@pytest.fixture
def meshes(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Nodes of every mesh that is solved."""
    seen: list[int] = []
    step = loop.Ladder._step

    def noted(ladder: loop.Ladder, mesh: loop.Mesh, *rest: object) -> None:
        seen.append(mesh.nodes.size)
        step(ladder, mesh, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(loop.Ladder, "_step", noted)
    return seen


def along(
    problem: wo.NipProblem, step: float, steps: int = STEPS, **options: Any
) -> Iterator[wo.NipResult]:
    """Yield the neighbours of a problem, each from the one before, its load a step larger."""
    last = wo.solve_nip(problem, **options)
    for _ in range(steps):
        last = wo.solve_nip(
            last.problem.replace(nip_load=(1 + step) * last.problem.nip_load), start=last, **options
        )
        yield last


def test_seven_of_eight_neighbours_take_one_mesh_and_the_eighth_a_coarser_one(
    meshes: list[int],
) -> None:
    for _ in along(newsprint_nip(), 0.005, steps=9, nodes=65):
        pass
    assert meshes == [17, 33, 65] + [65] * 7 + [65, 33] + [65]


def test_a_mesh_that_is_hardly_enough_is_not_tried_again_and_again(
    meshes: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that then is not costs two others: of 30 nips 1.32 meshes each in place of 1.45."""
    counts = []
    for surely in (loop.SURELY, 1.0):
        monkeypatch.setattr(loop, "SURELY", surely)
        meshes.clear()
        for seed in range(700000, 700012):
            for result in along(random_nip(seed), 0.01, steps=9):
                assert result.certified()
        counts.append(len(meshes))
    assert counts[0] < 0.97 * counts[1]


def test_on_one_mesh_a_neighbour_is_what_it_is_from_the_coarsest_on() -> None:
    for result in along(paper_nip(), 0.02, nodes=65):
        afresh = wo.solve_nip(result.problem, nodes=65)
        # loads are met to 3e-9
        assert result.nip_induced_tension == pytest.approx(afresh.nip_induced_tension, rel=2e-8)
        np.testing.assert_array_equal(result.roll_zone, afresh.roll_zone)
        np.testing.assert_array_equal(result.drum_zone, afresh.drum_zone)


def test_a_zone_that_appears_is_checked_by_a_coarser_mesh() -> None:
    """Where the whole roll face slips NIT is exact; its neighbour with a stick zone is not."""
    results = list(along(random_nip(50144), 0.05))
    kinds = [set(r.roll_zone.tolist()) for r in results]
    first = next(k for k, (one, two) in enumerate(pairwise(kinds), 1) if one != two)
    result = results[first]
    fine = wo.solve_nip(result.problem, nodes=513).nip_induced_tension
    assert abs(result.nip_induced_tension - fine) < 1.5 * result.nip_induced_tension_error
    assert result.widths.unchecked == 0


def test_neighbours_tell_errors_that_hold() -> None:
    true, told = [], []
    for seed in SEEDS:
        for result in along(random_nip(seed), 0.05):
            fine = wo.solve_nip(result.problem, nodes=257).nip_induced_tension
            true.append(abs(result.nip_induced_tension - fine))
            told.append(result.nip_induced_tension_error)
    ratios = np.array(true) / told
    # of hundreds 95 % are within; of 25, five in a row alike, a tenth may not be
    assert np.mean(ratios <= 1.5) >= 0.9
    assert ratios.max() < 5
    # errors many times too large would hold as well; some nips slip all over and are exact
    assert np.median(ratios) > 1 / 30


def test_a_neighbour_begins_on_about_the_mesh_that_the_last_one_needed(meshes: list[int]) -> None:
    result = wo.solve_nip(random_nip(50035))
    assert result.nodes > 129  # most need less
    meshes.clear()
    P = result.problem.nip_load
    near = wo.solve_nip(result.problem.replace(nip_load=1.01 * P), start=result)
    first, needed = (CHOSEN.index(nodes) for nodes in (meshes[0], result.nodes))
    assert abs(first - needed) <= 1
    assert near.nip_induced_tension_error <= 1e-3 * abs(near.nip_induced_tension)


def test_where_a_mesh_is_not_enough_the_next_that_is_follows(meshes: list[int]) -> None:
    """65 nodes tell too much; 81 do, as what is known of the scatter says, and not 129."""
    result = wo.solve_nip(random_nip(50074))
    meshes.clear()
    near = result.problem.replace(nip_load=1.003 * result.problem.nip_load)
    near_result = wo.solve_nip(near, start=result)
    assert meshes == [65, 33, 81]
    assert near_result.nip_induced_tension_error <= 1e-3 * near_result.nip_induced_tension


def test_from_a_mesh_between_it_goes_on_to_the_finest() -> None:
    """97 nodes are not doubled beyond 129; the error there is told by the scatter so far."""
    ladder = loop.Ladder(
        NipContact(newsprint_nip()), Graded(), "nip_induced_tension", scatters=True
    )
    ladder.climb([25, 49, 97])
    scatter, scale = ladder._scatters[ladder.target], abs(ladder.values[ladder.target])
    ladder.double(1e-12, 129)
    assert ladder.level.mesh.nodes.size == 129
    # one change more tells it: Student's t of 5 degrees of freedom for 4 is a tenth less, and what
    # was known of the scatter is known better
    assert 0.7 < ladder.errors[ladder.target] / scatter.error(128, scale) < 1
    fine = wo.solve_nip(newsprint_nip(), nodes=513).nip_induced_tension
    assert abs(ladder.values[ladder.target] - fine) < 1.5 * ladder.errors[ladder.target]


def test_zones_are_found_again_on_their_own_mesh_whichever_cell_they_end_in() -> None:
    """Also where they end in the cells at an edge, as on a hard drum: a start= pivots no more."""
    ends = []
    for load in (1000.0, 1900.0, 2600.0):
        for nodes in (33, 49, 65):
            result = wo.solve_nip(paper_nip(nip_load=load, winding_force=100.0), nodes=nodes)
            x, slip_x = (at[1:-1] / result.half_width for at in (result.x, result.slip_x))
            for zones, runs in zip(
                (result.roll_zone, result.drum_zone), result.widths.runs, strict=True
            ):
                assert np.array_equal(runs.on(x, slip_x), zones[1:-1])
                ends += [int(np.searchsorted(x, place)) for place, _ in runs.borders]
    assert min(ends) <= 1  # in the cell at the edge, or the next one


def test_slip_ratios_are_told_by_the_cells_in_which_zones_end() -> None:
    """A sixth of a cell, as two changes, beside those of the meshes: never much less is told."""
    nodes = np.array([-1.0, -0.5, 0.1, 0.5, 1.0])
    roll = Runs([-1, 0, 1], [(-0.2, 0.0), (0.7, 0.0)])  # in cells of 0.6 and 0.5
    told = by_cells(nodes, [roll, Runs([0], [])])
    sizes = {name: foreseen.size for name, foreseen in told.items()}
    assert sizes == pytest.approx({"leading_roll": 0.048, "trailing_roll": 0.04, "dual": 0.04})
    assert {foreseen.changes for foreseen in told.values()} == {2.0}

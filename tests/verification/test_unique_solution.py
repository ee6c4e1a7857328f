"""Why the discrete stick-slip problem of one face has exactly one solution, checked by enumeration.

Slip grows against the traction, v = c - A q, so the problem |q| <= b, v = 0 in stick, q = b sgn(v)
in slip has one solution for every c and b if and only if A is a P-matrix: all principal minors
positive.  With the collocation point of each node in the cell *before* it, the points interlace
with the nodes, A is a Cauchy matrix and its determinants are known in closed form.  These tests
count: minors, and the states that satisfy every law.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest
from seldom import seldom

from woundon.contact.grid import cosine_grid
from woundon.contact.pivoting import solve_stick_slip
from woundon.contact.stick_slip import Ending, StickSlip

Array = np.ndarray
# against the product of the diagonal's roots; rounding of determinants this small is near 1e-13
POSITIVE = 1e-6


def smallest_minor(A: Array) -> float:
    """Return the smallest principal minor, each measured by its diagonal."""
    scale = np.sqrt(np.abs(np.diag(A)))
    A = A / np.outer(scale, scale)
    sets = (list(s) for r in range(1, len(A) + 1) for s in combinations(range(len(A)), r))
    return min(float(np.linalg.det(A[np.ix_(s, s)])) for s in sets)


def interlaced(n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return n nodes and n collocation points, y_1 < x_1 < y_2 < x_2 < ... inside (-1, 1)."""
    both = np.sort(rng.uniform(-1, 1, 2 * n))
    return both[1::2], both[0::2]


def cauchy(x: Array, y: Array) -> Array:
    """Lumped strain at y against unit tractions at x: 1/(x_k - y_j)."""
    return 1 / (x[None, :] - y[:, None])


def wound_on(x: Array, y: Array) -> Array:
    """The same less the strain at the trailing edge 1, as the wound-on condition has it."""
    return (1 - y[:, None]) / ((x[None, :] - y[:, None]) * (1 - x[None, :]))


def tension(n: int) -> Array:
    """Loss of web stretch: what the tractions from a node on still add behind its point."""
    return np.triu(np.ones((n, n)))


def hats(nodes: int) -> tuple[Array, Array]:
    """The program's own matrices, exact integrals of the hats: drum side, roll side."""
    grid = cosine_grid(nodes)
    drum = -grid.inverse[: grid.unknowns]
    return drum, drum + grid.inverse[-1]


@pytest.mark.parametrize("seed", range(5))
def test_the_wound_on_condition_is_the_difference_of_two_cauchy_rows(seed: int) -> None:
    x, y = interlaced(7, np.random.default_rng(seed))
    edge = cauchy(x, np.array([1.0]))
    np.testing.assert_allclose(wound_on(x, y), cauchy(x, y) - edge, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("matrix", [cauchy, wound_on])
def test_lumped_matrices_have_the_minors_of_cauchys_formula(matrix: Any, seed: int) -> None:
    x, y = interlaced(6, np.random.default_rng(seed))
    A = matrix(x, y)
    for s in (list(s) for r in (1, 2, 3, 6) for s in combinations(range(6), r)):
        xs, ys = x[s], y[s]
        pairs = list(combinations(range(len(s)), 2))
        numerator = np.prod([(xs[i] - xs[j]) * (ys[j] - ys[i]) for i, j in pairs])
        known = numerator / np.prod(xs[None, :] - ys[:, None])
        if matrix is wound_on:
            known *= np.prod((1 - ys) / (1 - xs))
        assert known > 0
        assert np.linalg.det(A[np.ix_(s, s)]) == pytest.approx(known, rel=1e-6)


@pytest.mark.parametrize("stiffness", [0.0, 0.1, 1.0, 10.0, 1e3])
@pytest.mark.parametrize("matrix", [cauchy, wound_on])
def test_lumped_matrices_with_a_web_are_p_matrices(matrix: Any, stiffness: float) -> None:
    x, y = interlaced(9, np.random.default_rng(7))
    assert smallest_minor(matrix(x, y) + stiffness * tension(9)) > POSITIVE


@pytest.mark.parametrize("stiffness", [0.0, 0.1, 1.0, 10.0, 1e3])
@pytest.mark.parametrize("side", [0, 1])
def test_the_programs_matrices_are_p_matrices(side: int, stiffness: float) -> None:
    A = hats(12)[side]
    assert smallest_minor(A + stiffness * tension(10) * cosine_grid(12).weights) > POSITIVE


@pytest.mark.parametrize("nodes", [7, 26, 65, 257])
@pytest.mark.parametrize("side", [0, 1])
def test_row_differences_are_m_matrices_on_any_grid(side: int, nodes: int) -> None:
    # the inverse of `tension` takes the difference of each row and the next one
    A = hats(nodes)[side]
    Z = A - np.vstack([A[1:], np.zeros(A.shape[1])])
    off = Z - np.diag(np.diag(Z))
    assert off.max() <= 0  # no positive entry off the diagonal, ...
    assert np.linalg.inv(Z).min() > 0  # ... and a positive inverse: an M-matrix


# ---- the law itself, by trying every state ----------------------------------------------------


def one_face(A: Array, rng: np.random.Generator) -> StickSlip:
    n = len(A)
    return StickSlip(
        direct=-A,
        through_pressure=np.zeros((n, n)),
        offset=rng.normal(size=n) * np.abs(A).max(),
        pressure=rng.uniform(0.1, 1.0, n),
        pressure_response=np.zeros((n, n)),
        friction=np.full(n, 0.3),
        faces=1,
    )


def solutions(problem: StickSlip) -> list[Array]:
    """Return the tractions of every one of the 3^n states that satisfies all laws."""
    n = problem.friction.size
    states = (np.array(s, dtype=np.int8) for s in product((-1, 0, 1), repeat=n))
    tried = (problem.solve(state) for state in states)
    return [t.traction for t in tried if t.ending is Ending.SOLVED and not t.violated().any()]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("side", [0, 1])
def test_exactly_one_of_all_states_satisfies_every_law(side: int, seed: int) -> None:
    problem = one_face(hats(8)[side], np.random.default_rng(seed))
    found = solutions(problem)
    assert len(found) == 1
    pivoted = solve_stick_slip(problem)
    assert pivoted.ending is Ending.SOLVED
    np.testing.assert_allclose(pivoted.traction, found[0], rtol=0, atol=1e-12)


def test_the_trailing_cell_loses_the_sense_of_rolling() -> None:
    # the same strains, collocated in the cell *after* each node: none or several solutions
    grid = cosine_grid(8)
    trailing = -grid.inverse[1 : grid.unknowns + 1]
    assert np.all(np.diag(trailing) < 0)
    counts = [len(solutions(one_face(trailing, np.random.default_rng(seed)))) for seed in range(8)]
    assert any(count != 1 for count in counts)


def test_tractions_grow_with_the_creep_so_that_one_creep_carries_the_force() -> None:
    A = hats(14)[0]
    problem = one_face(A, np.random.default_rng(3))
    # wide enough for slip everywhere, either way
    creeps = np.linspace(-1, 1, 49) * (np.abs(problem.offset).max() + np.abs(A).sum())
    tractions = [
        solve_stick_slip(replace(problem, offset=problem.offset + creep)).traction
        for creep in creeps
    ]
    steps = np.diff(tractions, axis=0)
    assert steps.min() > -1e-12  # each single traction, not only their sum
    np.testing.assert_allclose(tractions[0], -0.3 * problem.pressure)
    np.testing.assert_allclose(tractions[-1], 0.3 * problem.pressure)


# ---- both faces of the web: found by enumeration, not proved -----------------------------------


def both_faces(nodes: int, web: float, drum: float) -> Array:
    """The nip's stick matrix at given pressure: roll, web and (drum > 0) an elastic drum."""
    on_drum, on_roll = hats(nodes)
    T = web * tension(nodes - 2) * cosine_grid(nodes).weights
    return np.block([[T + on_roll, T], [T, T + drum * on_drum]])


@pytest.mark.parametrize("drum", [0.0, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("web", [0.1, 1.0, 10.0])
def test_both_faces_together_have_positive_minors_too(web: float, drum: float) -> None:
    # Table 1's nip has web = 11; a stiff web makes the minors small, not negative
    assert smallest_minor(both_faces(7, web, drum)) > POSITIVE


@pytest.mark.parametrize("seed", [0, seldom(1), seldom(2)])
@pytest.mark.parametrize("drum", [0.0, 1.0])
def test_exactly_one_state_of_both_faces_carries_the_winding_force(drum: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, n = both_faces(6, 11.0, drum), 4
    on_drum = np.repeat([0.0, 1.0], n)
    weights = on_drum * np.tile(cosine_grid(6).weights, 2)
    problem = replace(
        one_face(A, rng),
        pressure=rng.uniform(0.1, 1.0, n),
        through_pressure=np.zeros((2 * n, n)),
        pressure_response=np.zeros((n, 2 * n)),
        faces=2,
        creep=on_drum,
        resultant=weights,
    )
    bound = float(weights @ problem.bound_offset)
    problem = replace(problem, force=rng.uniform(-0.9, 0.9) * bound)
    found = solutions(problem)
    assert len(found) == 1
    np.testing.assert_allclose(solve_stick_slip(problem).traction, found[0], rtol=0, atol=1e-10)


@pytest.mark.parametrize("web", [0.1, 11.0, 100.0])
@pytest.mark.parametrize("drum", [0.0, 0.1, 10.0])
def test_no_drum_traction_falls_with_the_creep_whatever_sticks(web: float, drum: float) -> None:
    # so that the resultant grows with the creep, on which the bracketing of the creep relies
    rng, A, n = np.random.default_rng(5), both_faces(20, web, drum), 18
    for _ in range(200):
        stuck = np.sort(rng.choice(2 * n, rng.integers(1, 2 * n), replace=False))
        on_drum = stuck >= n
        growth = np.linalg.solve(A[np.ix_(stuck, stuck)], on_drum.astype(float))
        # rounding, by the condition of a stiff web's matrix
        assert growth[on_drum].min(initial=0.0) >= -1e-9 * np.abs(growth).max()


def test_a_start_that_leads_astray_is_let_go() -> None:
    """From all nodes slipping backward single pivots wander for good on this grid."""
    from random_nips import random_nip

    import woundon as wo
    from woundon.contact.schemes import SCHEMES
    from woundon.nip.equations import NipEquations

    result = wo.solve(random_nip(254), nodes=65)
    mesh = SCHEMES["graded"].mesh(65)
    problem = NipEquations.at(result.problem, mesh, result.half_width).stick_slip()
    expected = np.concatenate([result.roll_zone[1:-1], result.drum_zone[1:-1]])
    for state in (-1, 0, 1):
        found = solve_stick_slip(problem, np.full(expected.size, state, dtype=np.int8))
        assert found.ending is Ending.SOLVED
        np.testing.assert_array_equal(found.state, expected)

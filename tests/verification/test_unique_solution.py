"""Why the discrete stick-slip problem of one face has exactly one solution, checked by enumeration.

Slip grows against the traction, v = c - A q, so the problem |q| <= b, v = 0 in stick, q = b sgn(v)
in slip has one solution for every c and b if and only if A is a P-matrix: all principal minors
positive.  With the collocation point of each node in the cell *before* it, the points interlace
with the nodes, A is a Cauchy matrix and its determinants are known in closed form.  These tests
count: minors, and the states that satisfy every law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from slow_cases import slow_case

from woundon.contact.newton import Jacobian, SemismoothNewton
from woundon.elasticity.hat_integrals import singular_integrals
from woundon.elasticity.mesh import Mesh, Wrap, nip_mesh

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


def mesh_of(nodes: int) -> Mesh:
    return nip_mesh(nodes, Wrap(), Wrap())


def inverse(nodes: int) -> Array:
    """Integrals of 1/(y - s) against the hats of the inner nodes, at all points and the edge."""
    mesh = mesh_of(nodes)
    return singular_integrals(np.append(mesh.points, 1.0), mesh.nodes)[0][:, 1:-1]


def hats(nodes: int) -> tuple[Array, Array]:
    """The program's own matrices, exact integrals of the hats: drum side, roll side."""
    drum = -inverse(nodes)[: nodes - 2]
    return drum, drum + inverse(nodes)[-1]


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
    assert smallest_minor(A + stiffness * tension(10) * mesh_of(12).weights[1:-1]) > POSITIVE


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


@dataclass(frozen=True)
class StickSlip:
    """v = offset - A q + creep xi;  |q| <= bound, v = 0 or q = +-bound;  weights q = force.

    A system for the semismooth Newton method: u = (xi, ln a, q); ln a = 0 stands for the half
    width, which such a problem does not have.
    """

    A: Array
    offset: Array
    limit: Array
    creep: Array | None = None  # 1 where the slip contains xi
    weights: Array | None = None
    force: float = 0.0

    ln_a, load_rows, largest_ln_a = np.array([1]), np.array([1]), np.array([1.0])

    @property
    def scales(self) -> Array:
        return np.append([1.0, 1.0], self.limit)

    @property
    def traction_unknowns(self) -> Array:
        return np.arange(2, 2 + self.limit.size)

    @property
    def creepage_nodes(self) -> list[Array]:
        return [] if self.creep is None else [np.flatnonzero(self.creep)]

    def evaluate(self, u: Array, tolerance: float = 0.0) -> Any:
        """Return the state of given unknowns."""
        xi, ln_a, q = u[0], u[1], u[2:]
        slip = self.offset - self.A @ q
        first = xi
        if self.creep is not None and self.weights is not None:
            slip = slip + self.creep * xi
            first = self.weights @ q - self.force
        return SimpleNamespace(
            u=u, equilibrium=np.array([first, ln_a]), slip=slip, traction=q / self.limit,
            bound=np.ones(q.size),
        )  # fmt: skip

    def jacobian(self, _: Any) -> Jacobian:
        """Return the derivatives, which are constant."""
        n = self.limit.size
        rows, slip = np.zeros((2, n + 2)), np.zeros((n, n + 2))
        rows[1, 1] = 1.0
        if self.weights is None:
            rows[0, 0] = 1.0
        else:
            rows[0, 2:] = self.weights
        slip[:, 2:] = -self.A
        if self.creep is not None:
            slip[:, 0] = self.creep
        return Jacobian(rows, slip, np.zeros((n, n + 2)))

    def fill_half_width_column(self, jacobian: Jacobian, state: Any) -> None:
        """Do nothing: the derivatives are constant."""

    def with_active_set(self, active: Array) -> Any:
        """Return the state that has a given active set, None where there is none."""
        jacobian, state = self.jacobian(None), self.evaluate(np.zeros(self.limit.size + 2))
        traction = np.eye(self.limit.size, self.limit.size + 2, 2) / self.limit[:, None]
        matrix = np.vstack([
            jacobian.equilibrium, np.where(active[:, None] == 0, jacobian.slip, traction)
        ])  # fmt: skip
        right = np.append(-state.equilibrium, np.where(active == 0, -state.slip, active))
        if np.linalg.matrix_rank(matrix) < len(matrix):
            return None
        return self.evaluate(np.linalg.solve(matrix, right))


def one_face(A: Array, rng: np.random.Generator) -> StickSlip:
    n = len(A)
    return StickSlip(
        A=A,
        offset=rng.normal(size=n) * np.abs(A).max(),
        limit=0.3 * rng.uniform(0.1, 1.0, n),
    )


def solutions(problem: StickSlip) -> list[Array]:
    """Return the tractions of every one of the 3^n active sets that satisfies all conditions."""
    found = []
    for signs in product((-1, 0, 1), repeat=problem.limit.size):
        active = np.array(signs)
        state = problem.with_active_set(active)
        if state is None:
            continue
        stuck = np.abs(state.traction[active == 0]) <= 1 + 1e-12
        if stuck.all() and (active * state.slip >= -1e-12).all():
            found.append(state.u[2:])
    return found


def newton(problem: StickSlip, active: Array | None = None) -> tuple[Array, Array]:
    """Return tractions and active set of the semismooth Newton method, by default from stick."""
    n = problem.limit.size
    start = np.zeros(n, dtype=np.int8) if active is None else active
    state, last = SemismoothNewton(problem).solve(np.zeros(n + 2), start, 1e-12)
    return state.u[2:], last


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("side", [0, 1])
def test_exactly_one_of_all_states_satisfies_every_law(side: int, seed: int) -> None:
    problem = one_face(hats(8)[side], np.random.default_rng(seed))
    found = solutions(problem)
    assert len(found) == 1
    np.testing.assert_allclose(newton(problem)[0], found[0], rtol=0, atol=1e-12)


def test_the_trailing_cell_loses_the_sense_of_rolling() -> None:
    # the same strains, collocated in the cell *after* each node: none or several solutions
    trailing = -inverse(8)[1:7]
    assert np.all(np.diag(trailing) < 0)
    counts = [len(solutions(one_face(trailing, np.random.default_rng(seed)))) for seed in range(8)]
    assert any(count != 1 for count in counts)


def test_tractions_grow_with_the_creep_so_that_one_creep_carries_the_force() -> None:
    A = hats(14)[0]
    problem = one_face(A, np.random.default_rng(3))
    # wide enough for slip everywhere, either way
    creeps = np.linspace(-1, 1, 49) * (np.abs(problem.offset).max() + np.abs(A).sum())
    tractions = [newton(replace(problem, offset=problem.offset + creep))[0] for creep in creeps]
    steps = np.diff(tractions, axis=0)
    assert steps.min() > -1e-12  # each single traction, not only their sum
    np.testing.assert_allclose(tractions[0], -problem.limit)
    np.testing.assert_allclose(tractions[-1], problem.limit)


# ---- both faces of the web: found by enumeration, not proved -----------------------------------


def both_faces(nodes: int, web: float, drum: float) -> Array:
    """The nip's stick matrix at given pressure: roll, web and (drum > 0) an elastic drum."""
    on_drum, on_roll = hats(nodes)
    T = web * tension(nodes - 2) * mesh_of(nodes).weights[1:-1]
    return np.block([[T + on_roll, T], [T, T + drum * on_drum]])


@pytest.mark.parametrize("drum", [0.0, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("web", [0.1, 1.0, 10.0])
def test_both_faces_together_have_positive_minors_too(web: float, drum: float) -> None:
    # Table 1's nip has web = 11; a stiff web makes the minors small, not negative
    assert smallest_minor(both_faces(7, web, drum)) > POSITIVE


@pytest.mark.parametrize("seed", [0, slow_case(1), slow_case(2)])
@pytest.mark.parametrize("drum", [0.0, 1.0])
def test_exactly_one_state_of_both_faces_carries_the_winding_force(drum: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, n = both_faces(6, 11.0, drum), 4
    on_drum = np.repeat([0.0, 1.0], n)
    weights = on_drum * np.tile(mesh_of(6).weights[1:-1], 2)
    problem = one_face(A, rng)
    limit = np.tile(0.3 * rng.uniform(0.1, 1.0, n), 2)
    force = rng.uniform(-0.9, 0.9) * float(weights @ limit)
    problem = replace(problem, limit=limit, creep=on_drum, weights=weights, force=force)
    found = solutions(problem)
    assert len(found) == 1
    np.testing.assert_allclose(newton(problem)[0], found[0], rtol=0, atol=1e-10)


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


@pytest.mark.parametrize("state", [-1, 0, 1])
def test_the_solution_does_not_depend_on_the_first_active_set(state: int) -> None:
    problem = one_face(hats(40)[0], np.random.default_rng(254))
    expected, zones = newton(problem)
    found, same = newton(problem, np.full(zones.size, state, dtype=np.int8))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(same, zones)

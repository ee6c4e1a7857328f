"""The semismooth Newton method on a small system whose solution is known.

A row of masses on springs is pulled along a base with Coulomb friction: K w + q = f, |q| <= mu p,
with the load p determined by ln a through exp(2 ln a) = P.  No mechanics of nips takes part.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from math import log
from typing import Any

import numpy as np
import pytest

from woundon.contact import newton
from woundon.contact.newton import Jacobian, NewtonFailed, SemismoothNewton

Array = np.ndarray


@dataclass
class Iterate:
    u: Array
    equilibrium: Array
    slip: Array
    traction: Array
    bound: Array


@dataclass
class Row:
    """Unknowns w (k), ln a, q (k): K w + q = f, exp(2 ln a) = P, slip w, bound mu exp(2 ln a)."""

    K: Array
    f: Array
    mu: Array
    P: float = 4.0
    largest_ln_a: Array = field(default_factory=lambda: np.array([10.0]))
    evaluations: int = 0
    creepage_nodes: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.k = k = self.f.size
        self.scales = np.ones(2 * k + 1)
        self.traction_unknowns = np.arange(k + 1, 2 * k + 1)
        self.ln_a = self.load_rows = np.array([k])

    def evaluate(self, u: Array, tolerance: float = 0.0) -> Iterate:
        self.evaluations += 1
        k, load = self.k, np.exp(2 * u[self.k])
        w, q = u[:k], u[k + 1 :]
        rest = np.append(self.K @ w + q - self.f, load / self.P - 1)
        # the base drags the masses back: q is opposite to w, so slip counts against it
        return Iterate(u, rest, w.copy(), q.copy(), self.mu * load)

    def jacobian(self, state: Iterate) -> Jacobian:
        k, n = self.k, 2 * self.k + 1
        equilibrium, slip, bound = np.zeros((k + 1, n)), np.zeros((k, n)), np.zeros((k, n))
        equilibrium[:k, :k], equilibrium[:k, k + 1 :] = self.K, np.eye(k)
        slip[:, :k] = np.eye(k)
        load = np.exp(2 * state.u[k])
        equilibrium[k, k], bound[:, k] = 2 * load / self.P, 2 * self.mu * load
        return Jacobian(equilibrium, slip, bound)

    def fill_half_width_column(self, jacobian: Jacobian, state: Any) -> None:
        for matrix, renewed in zip(jacobian, self.jacobian(state), strict=True):
            matrix[:, self.ln_a] = renewed[:, self.ln_a]


def row(seed: int, k: int = 7, **more: Any) -> Row:
    random = np.random.default_rng(seed)
    K = 3 * np.eye(k) - np.eye(k, k=1) - np.eye(k, k=-1)
    return Row(K, random.normal(0, 2.5, k), random.uniform(0.1, 0.6, k), **more)


def start(system: Row, ln_a: float = 0.3) -> tuple[Array, Array]:
    u = np.zeros(2 * system.k + 1)
    u[system.k] = ln_a
    return u, np.zeros(system.k, dtype=np.int8)


def by_enumeration(system: Row) -> tuple[Array, Array]:
    """Return w and q of the only active set that satisfies the friction law: an independent way."""
    bound, found = system.mu * system.P, []
    for active in product((-1, 0, 1), repeat=system.k):
        s = np.array(active)
        free = s != 0
        q, w = s * bound, np.zeros(system.k)
        w[free] = np.linalg.solve(system.K[np.ix_(free, free)], (system.f - q)[free])
        q = np.where(free, q, system.f - system.K @ w)
        if (np.abs(q) <= bound * (1 + 1e-12)).all() and (s * w >= -1e-12).all():
            found.append((w, q))
    assert len(found) == 1
    return found[0]


@pytest.mark.parametrize("seed", range(8))
def test_it_finds_the_only_active_set(seed: int) -> None:
    system = row(seed, k=6)
    state, active = SemismoothNewton(system).solve(*start(system), 1e-11)
    w, q = by_enumeration(system)
    np.testing.assert_allclose(state.u[:6], w, rtol=0, atol=1e-10)
    np.testing.assert_allclose(state.traction, q, rtol=0, atol=1e-10)
    np.testing.assert_array_equal(active, np.sign(np.where(np.abs(w) > 1e-12, w, 0)))
    assert state.u[system.ln_a] == pytest.approx(log(system.P) / 2, abs=1e-11)


@pytest.mark.parametrize("seed", [1, 5])
def test_the_solution_does_not_depend_on_the_start(seed: int) -> None:
    system = row(seed)
    state, active = SemismoothNewton(system).solve(*start(system), 1e-11)
    random = np.random.default_rng(seed)
    for _ in range(5):
        other, _ = start(system, random.uniform(-2, 2))
        guess = random.integers(-1, 2, system.k).astype(np.int8)
        again, found = SemismoothNewton(system).solve(other, guess, 1e-11)
        np.testing.assert_array_equal(found, active)
        np.testing.assert_allclose(again.u, state.u, rtol=0, atol=1e-10)


def test_from_the_solution_nothing_changes() -> None:
    system = row(3)
    solver = SemismoothNewton(system)
    state, active = solver.solve(*start(system), 1e-11)
    before = solver.counts.iterations, solver.counts.factorisations
    again, same = solver.solve(state.u, active, 1e-9)
    assert again.u is state.u
    assert same is active
    assert solver.counts.iterations == before[0] + 1
    assert solver.counts.factorisations == before[1]  # reused between calls


@pytest.mark.parametrize("seed", [1, 5])
def test_a_neighbouring_factorisation_is_used_as_long_as_the_step_shrinks(seed: int) -> None:
    """The solution is the same; next to the neighbour nothing is factorised, far from it much."""
    system = row(seed)
    neighbour = SemismoothNewton(system)
    state, active = neighbour.solve(*start(system), 1e-11)
    near = SemismoothNewton(system, neighbour)
    again, same = near.solve(state.u + 1e-4, active.copy(), 1e-11)
    assert near.counts.factorisations == 0
    far = SemismoothNewton(system, neighbour)
    third, _ = far.solve(*start(system), 1e-11)
    assert far.counts.factorisations > 0
    np.testing.assert_array_equal(same, active)
    for found in (again, third):
        np.testing.assert_allclose(found.u, state.u, rtol=0, atol=1e-10)


def test_the_half_width_changes_by_limited_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """From far away: each step changes ln a by at most LARGEST_STEP, and it still converges."""
    system = row(4)
    seen: list[float] = []
    evaluate = system.evaluate

    def noted(u: Array, tolerance: float) -> Iterate:
        seen.append(float(u[system.ln_a][0]))
        return evaluate(u)

    monkeypatch.setattr(system, "evaluate", noted)
    state, _ = SemismoothNewton(system).solve(*start(system, -4.0), 1e-11)
    assert state.u[system.ln_a] == pytest.approx(log(2.0), abs=1e-10)
    assert np.abs(np.diff(seen)).max() <= newton.LARGEST_STEP * (1 + 1e-9)


def test_a_half_width_beyond_the_largest_fails() -> None:
    system = row(0, largest_ln_a=np.array([0.5]))  # ln 2 is needed
    with pytest.raises(NewtonFailed, match="half width exceeds the largest"):
        SemismoothNewton(system).solve(*start(system), 1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_a_factorisation_serves_active_sets_that_differ_in_a_few_nodes(seed: int) -> None:
    """Reference: the matrix of the changed active set, factorised itself."""
    system = row(seed, k=30)
    u, active = start(system)
    state = system.evaluate(u + 0.1)
    jacobian = system.jacobian(state)
    changed, right = active.copy(), np.random.default_rng(seed).normal(size=u.size)
    changed[[3, 17, 18]] = 1, -1, 1
    linear = newton._LinearSystem(system, jacobian, state.u[system.ln_a], active)
    assert linear.serves(state, changed)
    linear.set_active(changed)
    expected = newton._LinearSystem(system, jacobian, 0.0, changed).solve(right)
    np.testing.assert_allclose(linear.solve(right), expected, rtol=0, atol=1e-12)
    assert not linear.serves(state, np.ones_like(active))


def test_a_singular_jacobian_and_a_residual_that_is_not_finite_fail() -> None:
    system = row(0)
    system.K = np.zeros_like(system.K)
    u, active = start(system)
    with pytest.raises(NewtonFailed, match="singular"):
        SemismoothNewton(system).solve(u, np.ones_like(active), 1e-11)
    system = row(0)
    system.f[0] = np.nan
    with pytest.raises(NewtonFailed, match="not finite"):
        SemismoothNewton(system).solve(u, active, 1e-11)


def test_too_many_iterations_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newton, "MAX_ITERATIONS", 2)
    system = row(1)
    with pytest.raises(NewtonFailed, match="violate the friction law; the last step is"):
        SemismoothNewton(system).solve(*start(system, -3.0), 1e-11)


CYCLING_STARTS = [[0, 1, 1], [1, 0, 0], [0, 0, 1]]


@pytest.mark.parametrize("pull", [-1.0, 1.0])
@pytest.mark.parametrize("guess", CYCLING_STARTS)
def test_a_cycle_of_active_sets_is_left(
    guess: list[int], pull: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three masses, each dragged by the next: the primal-dual active set method alone cycles.

    The compliance C = I + 2 S, S a cyclic shift, has positive principal minors, so that there is
    one solution; but three masses are enough for a cycle (Ben Gharbia and Gilbert 2012).  All
    masses stick for a pull of -1, and slip for +1.
    """
    compliance, bound = np.eye(3) + 2 * np.roll(np.eye(3), 1, axis=1), 8.0
    f = bound + np.linalg.solve(compliance, np.full(3, pull))  # w = C (bound - q) + pull
    system = Row(np.linalg.inv(compliance), f, np.full(3, bound / 4))
    w, q = by_enumeration(system)
    u, active = start(system, log(2.0))  # the load is known: only the active set is sought
    state, active = SemismoothNewton(system).solve(u, np.array(guess, dtype=np.int8), 1e-11)
    np.testing.assert_allclose(state.u[:3], w, rtol=0, atol=1e-12)
    np.testing.assert_allclose(state.traction, q, rtol=0, atol=1e-12)
    assert (active == (pull > 0)).all()
    # without the rule for cycles
    monkeypatch.setattr(newton, "MOST_VISITS", np.inf)
    with pytest.raises(NewtonFailed, match="violate the friction law"):
        SemismoothNewton(system).solve(u, np.array(guess, dtype=np.int8), 1e-11)


@pytest.mark.parametrize(("noise", "is_solved"), [(1e-9, True), (1e-5, False)])
def test_steps_that_are_due_to_rounding_end_the_iteration(
    noise: float, is_solved: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A residual with an error of 1e-9 leads to a solution as accurate, one of 1e-5 to none."""
    system, evaluate = row(4), row(4).evaluate
    exact, active = SemismoothNewton(system).solve(*start(system), 1e-11)

    def inexact(u: Array, tolerance: float) -> Iterate:
        state, sign = evaluate(u), (-1) ** system.evaluations
        system.evaluations += 1
        state.equilibrium[:-1] += sign * noise
        return state

    monkeypatch.setattr(system, "evaluate", inexact)
    if is_solved:
        state, found = SemismoothNewton(system).solve(*start(system), 1e-11)
        np.testing.assert_array_equal(found, active)
        # |K^-1| <= 1, and the error of the residual changes by two noises between two steps
        np.testing.assert_allclose(state.u, exact.u, rtol=0, atol=3 * noise)
    else:
        with pytest.raises(NewtonFailed, match="the last step is"):
            SemismoothNewton(system).solve(*start(system), 1e-11)


def test_the_creepage_node_that_sticks_is_between_zones_of_opposite_slip() -> None:
    """The zone of slip +1 grows over the last sticking node: its neighbour of slip -1 sticks."""
    system = row(6)
    system.creepage_nodes = [np.arange(system.k)]
    state = system.evaluate(start(system)[0])
    active = np.array([1, 1, 1, 0, -1, -1, -1], dtype=np.int8)
    state.slip[:] = [0.9, 0.5, 0.1, 0.0, -0.2, -0.6, -0.7]  # the smallest is in the other zone
    state.traction[:] = active * state.bound
    state.traction[3] = 2 * state.bound[3]
    new = newton._next_active_set(system, state, active, newton._violates_inequality(state, active))
    np.testing.assert_array_equal(new, [1, 1, 1, 1, 0, -1, -1])


def test_one_creepage_node_keeps_sticking() -> None:
    """If all nodes whose slip contains the creepage slipped, no equation would determine it."""
    system = row(6)
    system.creepage_nodes = [np.arange(system.k)]
    u, active = start(system)
    state = system.evaluate(u)
    state.traction[:] = 10 * state.bound  # all exceed their bounds
    new = newton._next_active_set(system, state, active, newton._violates_inequality(state, active))
    assert np.count_nonzero(new == 0) == 1
    system.creepage_nodes = []
    assert (
        newton._next_active_set(system, state, active, newton._violates_inequality(state, active))
        == 1
    ).all()


@dataclass
class InexactRow(Row):
    """A row whose springs have a relative error of the coefficients that the solver permits."""

    def evaluate(self, u: Array, tolerance: float = 0.0) -> Iterate:
        exact, self.K = self.K, self.K * (1 + tolerance)
        try:
            return super().evaluate(u, tolerance)
        finally:
            self.K = exact


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_solution_with_inexact_coefficients_is_not_accepted(seed: int, tolerance: float) -> None:
    """A large step permits coarse coefficients, with which the next step may happen to be small.

    The error of a solution is that of its coefficients: at most the tolerance, times a condition
    number of about one.
    """
    exact = row(seed)
    inexact = InexactRow(exact.K, exact.f, exact.mu)
    known, _ = SemismoothNewton(exact).solve(*start(exact), 1e-11)
    found, _ = SemismoothNewton(inexact).solve(*start(inexact), tolerance)
    assert np.abs(found.u - known.u).max() < 3 * tolerance


def test_the_step_after_a_large_one_does_not_end_the_iteration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The step before evaluates with coefficients that are too coarse to accept its result."""
    sizes = iter([0.5, 1e-9, 1e-9])
    given: list[float] = []
    system = row(1)
    evaluate = system.evaluate

    def recorded(u: Array, tolerance: float = 0.0) -> Iterate:
        given.append(tolerance)
        return evaluate(u, tolerance)

    monkeypatch.setattr(system, "evaluate", recorded)
    solver = SemismoothNewton(system)
    monkeypatch.setattr(solver, "_step", lambda state, active: (0 * state.u, next(sizes)))
    monkeypatch.setattr(newton, "_violates_inequality", lambda state, active: active != active)
    solver.solve(*start(system), 1e-5)
    assert given == pytest.approx([1e-7, 0.5e-3, 1e-7])  # the last one is accepted

r"""Mesh refinement with Richardson's error estimate.

The system is solved on meshes of N_1 < N_2 < ... nodes, each from the solution on the one before.
The discretisation is of order two on average.  With the changes of an output Q,

    d_k = |Q_k - Q_(k-1)| / ((N_k/N_(k-1))^2 - 1),

the estimated error of the last value Q_m is  3 max_k d_k (N_k/N_m)^2  over the last three changes.
Zone boundaries move through the cells, so convergence is not monotone: one change may be small by
chance, and the factor of safety is that of Roache's grid convergence index.  Refinement ends when
the estimate of the fourth or a further mesh meets its tolerance: two changes that are both small by
chance do not end it.  With a loose tolerance the first meshes are coarser.

The first three meshes are fixed.  Each further one is predicted from the ratio r of the estimate
and the tolerance: N = N_last sqrt(r/0.6), at least 1.3 and at most 2 times the last.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from .newton import NewtonFailed, SemismoothNewton

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = [
    "CHANGES",
    "FINAL_TOLERANCE",
    "FIRST_SIZES",
    "MeshSolution",
    "Refinement",
    "neighbouring_solution",
    "refine",
    "richardson_estimates",
]

Array = np.ndarray
Tolerances = Callable[[Mapping[str, float]], Mapping[str, float]]

FIRST_SIZES = (13, 23, 41)
# First meshes of a loose tolerance, of LOOSE and more of an output: its error on 33 nodes is mostly
# below 0.25 %.
LOOSE_SIZES, LOOSE = (7, 13, 23), 1e-2
# Other first meshes, tried once where the iteration fails: they have other active sets.  Each
# further mesh is then the next but one of SIZES.
OTHER_SIZES = (17, 29, 45)
# Sizes of all further meshes: with few different ones, what depends on the mesh alone is reused,
# and neighbouring problems are solved on the same meshes.
SIZES = (
    33,
    *range(49, 97, 8),
    *range(97, 193, 16),
    *range(193, 385, 32),
    *range(385, 769, 64),
    *range(769, 1026, 128),
)
SAFETY_FACTOR = 3.0
# Changes between meshes: the fewest for an estimate, and those that it uses, because convergence is
# not monotone, and two changes may both be small by chance.
CHANGES, REPORTED = 2, 3
# The predicted error of the next mesh, relative to the tolerance, and the ratio of its size to that
# of the last mesh.
TARGET_SHARE, MIN_GROWTH, MAX_GROWTH = 0.6, 1.3, 2.0
# A mesh of SIZES that is smaller than the predicted one by up to this share is used.
ROUNDED_DOWN = 0.03
# Last Newton step, in the units of the unknowns: while meshes are refined, relative to the smallest
# tolerance of an output, and on the last mesh, near the rounding error of 1e-14.
COARSE_SHARE, FINAL_TOLERANCE = 1e-2, 1e-11
NEIGHBOUR_TOLERANCE = 1e-7  # for differences between problems that are about 1 % apart


@dataclass(eq=False)
class MeshSolution:
    """The solution on one mesh.

    Attributes
    ----------
    size : int
        Nodes of the nip.
    system : System
    state : Iterate
    active : (k,) int array
        The active set.
    solver : SemismoothNewton
    """

    size: int
    system: Any
    state: Any
    active: Array
    solver: SemismoothNewton

    @cached_property
    def main_outputs(self) -> Mapping[str, float]:
        """The outputs that decide where the refinement ends."""
        return dict(self.system.main_outputs(self.state))

    @cached_property
    def outputs(self) -> Mapping[str, float]:
        """All outputs whose error is estimated."""
        return dict(self.system.outputs(self.state, self.active))


@dataclass
class Refinement:
    """The solutions on a sequence of meshes."""

    meshes: list[MeshSolution] = field(default_factory=list)

    @property
    def last(self) -> MeshSolution:
        """The solution on the finest mesh."""
        return self.meshes[-1]

    @property
    def iterations(self) -> int:
        """Newton iterations on all meshes."""
        return sum(mesh.solver.counts.iterations for mesh in self.meshes)

    def errors(self, order: int = 2, of: str = "outputs") -> dict[str, float]:
        """Return the error estimates of all or of the main outputs; nan with fewer than 3 meshes.

        Parameters
        ----------
        order : int
            Order of convergence.
        of : str
            "outputs", or "main_outputs" without evaluating the others.
        """
        meshes = self.meshes[-REPORTED - 1 :]
        names = list(getattr(self.last, of))
        values = [[getattr(mesh, of)[name] for name in names] for mesh in meshes]
        estimates = richardson_estimates([mesh.size for mesh in meshes], values, order)
        return dict(zip(names, estimates.tolist(), strict=True))

    def ratios(self, tolerances: Tolerances) -> dict[str, float]:
        """Return the ratio of error estimate and tolerance of each output that has a tolerance.

        It is inf where there is no estimate.
        """
        errors = self.errors(of="main_outputs")
        permitted = tolerances(self.last.main_outputs)
        ratios = {name: errors[name] / tolerance for name, tolerance in permitted.items()}
        return {name: ratio if isfinite(ratio) else inf for name, ratio in ratios.items()}


def richardson_estimates(sizes: Sequence[int], values: ArrayLike, order: int = 2) -> Array:
    """Return the estimated errors of values on the last of several meshes.

    Parameters
    ----------
    sizes : (meshes,) sequence of int
        Nodes; at least three meshes for an estimate, nan with fewer.
    values : (meshes, ...) array_like
        The same values on every mesh.
    order : int
        Order of convergence.

    Returns
    -------
    (...) array

    Examples
    --------
    >>> richardson_estimates([10, 20, 40], [[1.04], [1.01], [1.0025]]).round(4)
    array([0.0075])
    """
    values = np.asarray(values, dtype=float)
    if len(sizes) <= CHANGES:
        return np.full(values.shape[1:], np.nan)
    largest = FINAL_TOLERANCE * np.abs(values[-1])  # the tolerance of the solver
    for (m, coarse), (n, fine) in pairwise(zip(sizes, values, strict=True)):
        change = np.abs(fine - coarse) / ((n / m) ** order - 1)
        largest = np.fmax(largest, SAFETY_FACTOR * change * (n / sizes[-1]) ** order)
    return np.asarray(largest)


def refine(
    system_of: Callable[[int], Any],
    *,
    nodes: int | None = None,
    tolerances: Tolerances = lambda _: {},
    most_nodes: int = 257,
    rtol: float = 1e-3,
    start: Refinement | None = None,
    errors: bool = True,
    last: MeshSolution | None = None,
    check: Callable[[MeshSolution], None] = lambda _: None,
    progress: Callable[[float], None] | None = None,
) -> Refinement:
    """Solve on a sequence of meshes until the estimated errors are below their tolerances.

    Parameters
    ----------
    system_of : callable
        nodes -> :class:`~woundon.contact.newton.System` with ``initial_guess``, ``prolong``,
        ``main_outputs`` and ``outputs``.
    nodes : int, optional
        Size of the last mesh; by default as many as the tolerances require.
    tolerances : callable
        main outputs -> permitted errors of some of them, by name.
    most_nodes : int
        Largest mesh; there the refinement ends even if the tolerances are not met.
    rtol : float
        The smallest relative tolerance of an output.
    start : Refinement, optional
        Solutions of a neighbouring problem, which replace the initial guess on every mesh.
    errors : bool
        False omits the coarse meshes, which only the error estimates need, if there is a ``start``.
    last : MeshSolution, optional
        The known solution on the last mesh, of ``nodes``.
    check : callable
        Called with the solution on each mesh; it may raise.
    progress : callable, optional
        Called with the fraction of the work that is done, estimated.

    Raises
    ------
    NewtonFailed
        If no first mesh leads to a solution.
    """
    sequence, alternative = (
        sizes_up_to(nodes, first) if nodes else [n for n in first if n <= most_nodes]
        for first in (LOOSE_SIZES if rtol >= LOOSE else FIRST_SIZES, OTHER_SIZES)
    )

    def refine_from(sizes: list[int], start: Refinement | None, larger: int) -> Refinement:
        """Solve on the meshes ``sizes``, then on further ones, with a warm start or without.

        ``larger`` is the number of sizes that are skipped to each further mesh.
        """
        refinement = Refinement()
        while True:
            for size in sizes:
                if last is not None and size == last.size:
                    refinement.meshes.append(last)
                    return refinement
                tolerance = COARSE_SHARE * rtol
                solution = _solve(system_of(size), size, refinement, start, tolerance)
                refinement.meshes.append(solution)
                check(refinement.last)
                if progress:
                    progress(min(size / (nodes or most_nodes), 1.0))
            ratio = max(refinement.ratios(tolerances).values(), default=0.0)
            is_last = len(refinement.meshes) > REPORTED and ratio <= 1
            if nodes or is_last or refinement.last.size >= most_nodes:
                refinement.meshes[-1] = _solve_to_final_tolerance(refinement.last)
                return refinement
            sizes = [min(predicted_size(refinement.last.size, ratio, larger), most_nodes)]

    # first meshes, warm start, and sizes to be skipped of each attempt
    attempts: list[tuple[list[int], Refinement | None, int]]
    attempts = [(sequence, None, 0), (alternative, None, 1)]
    if start is not None:
        attempts.insert(0, (sequence, start, 0))
        if nodes and not errors:
            attempts.insert(0, ([nodes], start, 0))
    failure: ArithmeticError
    for sizes, guess, larger in attempts:
        try:
            return refine_from(sizes, guess, larger)
        except ArithmeticError as stop:  # of the iteration, or of a body under an iterate
            failure = stop
    raise NewtonFailed(str(failure)) from failure


def _solve(
    system: Any, size: int, refinement: Refinement, start: Refinement | None, tolerance: float
) -> MeshSolution:
    """Return the solution on a mesh.

    The initial guess is the solution u on the mesh before, and with that of a neighbouring problem
    u' the sum u_n = u'_n + (u_(n-1) - u'_(n-1)): the difference of two neighbouring solutions
    hardly depends on the mesh.
    """
    if refinement.meshes:
        u, active = _prolong(refinement.last, system)
    elif start is not None:
        u, active = _prolong(_nearest(start, size), system)
    else:
        u, active = system.initial_guess()
    if refinement.meshes and start is not None:
        same_mesh, last_mesh = _nearest(start, size), _nearest(start, refinement.last.size)
        neighbour, zones = _prolong(same_mesh, system)
        u = u + neighbour - _prolong(last_mesh, system)[0]
        # zones of the neighbour on a coarser mesh are no better than those of the mesh before
        active = zones if same_mesh.size >= size else active
    # next to the solution on the mesh before, a factorisation of its own converges faster
    neighbouring_solver = None if refinement.meshes else _solver_on_mesh(start, system, size)
    solver = SemismoothNewton(system, neighbouring_solver)
    state, active = solver.solve(u, active, tolerance)
    return MeshSolution(size, system, state, active, solver)


def _solver_on_mesh(start: Refinement | None, system: Any, size: int) -> SemismoothNewton | None:
    """Return the solver of the neighbouring problem on the same mesh; None if there is none."""
    if start is None:
        return None
    neighbour = _nearest(start, size)
    has_same_unknowns = neighbour.system.scales.size == system.scales.size
    return neighbour.solver if neighbour.size == size and has_same_unknowns else None


def _nearest(start: Refinement, size: int) -> MeshSolution:
    """Return the solution on the mesh of about so many nodes."""
    return min(start.meshes, key=lambda mesh: abs(mesh.size - size))


def _prolong(mesh: MeshSolution, system: Any) -> tuple[Array, Array]:
    """Return the unknowns and the active set of another mesh's solution."""
    prolonged: tuple[Array, Array] = system.prolong(mesh.state, mesh.active, mesh.system)
    return prolonged


def _solve_to_final_tolerance(mesh: MeshSolution) -> MeshSolution:
    """Return the solution after iterating to the final tolerance."""
    state, active = mesh.solver.solve(mesh.state.u, mesh.active, FINAL_TOLERANCE)
    return MeshSolution(mesh.size, mesh.system, state, active, mesh.solver)


def neighbouring_solution(mesh: MeshSolution, problem: Any) -> MeshSolution:
    """Return the solution of a neighbouring problem on the same mesh, from a known one.

    Raises
    ------
    NewtonFailed
    """
    system = mesh.system.for_problem(problem)
    solver = SemismoothNewton(system, mesh.solver)
    state, active = solver.solve(mesh.state.u, mesh.active, NEIGHBOUR_TOLERANCE)
    return MeshSolution(mesh.size, system, state, active, solver)


def sizes_up_to(nodes: int, first: tuple[int, ...] = FIRST_SIZES) -> list[int]:
    """Return a sequence of meshes that ends with a given one, at least three from 13 nodes on.

    ``first`` are the sizes with which it begins.

    Examples
    --------
    >>> sizes_up_to(129)
    [13, 23, 41, 73, 129]
    >>> sizes_up_to(41)
    [13, 23, 41]
    >>> sizes_up_to(17)
    [10, 13, 17]
    """
    sizes = [n for n in first if n * MIN_GROWTH <= nodes]
    if len(sizes) < CHANGES:
        # other first sizes are for a second attempt, which needs other meshes
        growth = MIN_GROWTH if first is FIRST_SIZES else MIN_GROWTH**1.2
        coarse = [round(nodes / growth**k) for k in range(CHANGES, 0, -1)]
        return [*coarse, nodes] if nodes >= FIRST_SIZES[0] else [nodes]
    ratio, steps = nodes / sizes[-1], 1
    while ratio ** (1 / steps) > MAX_GROWTH:
        steps += 1
    return [*sizes, *(round(sizes[-1] * ratio ** (k / steps)) for k in range(1, steps)), nodes]


def predicted_size(last: int, ratio: float, larger: int = 0) -> int:
    """Return the size of the next mesh from the ratio of error estimate and tolerance.

    The error is of order two in 1/N: N = last sqrt(ratio/TARGET_SHARE), within the limits of the
    growth, is rounded to one of SIZES, or to that which follows ``larger`` places later.
    """
    wanted = sqrt(ratio / TARGET_SHARE) if ratio < inf else MAX_GROWTH
    growth = min(max(wanted, MIN_GROWTH), MAX_GROWTH)
    permitted = [size for size in SIZES if size >= (1 - ROUNDED_DOWN) * growth * last]
    return permitted[larger] if larger < len(permitted) else SIZES[-1]

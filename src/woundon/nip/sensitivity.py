r"""Sensitivities of a solved contact by implicit differentiation.

On its last mesh and with its active set, a solution u of a problem with the inputs theta satisfies
R(u, theta) = 0.  For another theta one Newton step from u with the Jacobian J = dR/du,

    u(theta + h) = u - J^-1 R(u, theta + h) + O(h^2),

gives the solution to first order.  The derivative of any output Q(u, theta) follows from the
central difference of Q(u(theta + h), theta + h), with an error of the order h^2.  J is factorised
once; each input needs two residuals and two back-substitutions.  The derivatives on the last three
meshes give the error estimates.

The active set is kept: where a node is about to change its zone, derivatives to both sides differ,
and slip lengths have a kink.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from ..contact.newton import friction_residual, system_matrix
from ..contact.refinement import CHANGES, MeshSolution, error_estimate
from ..errors import InvalidProblem, did_you_mean
from ..parallel import one_thread
from ..quantities import scalar_outputs, value_of, walk
from ..sensitivity import Sensitivity
from .entrained_air import AirFilm, film_of_state

if TYPE_CHECKING:
    from ..problems.nip import NipProblem

__all__ = ["contact_sensitivity", "continuous_fields"]

Array = np.ndarray

# Step relative to the scale of an input: the error of a central difference is its square, rounding
# of residuals (1e-14) over it.
STEP = 1e-4
# Newton steps with the Jacobian of the solution: one leaves the error of the Jacobian (tangents of
# nonlinear bodies and the column by ln a are inexact by up to 1e-2), two leave its square.
STEPS = 2
# Iterations of the friction that an air film leaves: the film depends on the pressure at the inlet,
# which changes by about 1e-2 of the change of the friction.
AIR_ITERATIONS = 4
# Margin of a node's inequality, relative to the largest value, below which its zone may change.
NEAR_CHANGE = 1e-6


def air_outputs() -> tuple[str, ...]:
    """Return the names of the scalar outputs of an air film in a result."""
    return tuple(f"air.{name}" for name in scalar_outputs(AirFilm))


def continuous_fields(problem: Any) -> dict[str, float]:
    """Return every continuous field of a problem by its dotted name."""
    return {place.path: place.value for place in walk(problem) if isinstance(place.value, float)}


def _list_items(problem: Any) -> dict[str, float]:
    """Return the numbers in lists, such as the values of a profile, by dotted name."""
    return {
        f"{place.path}.{k}": item
        for place in walk(problem)
        if isinstance(place.value, tuple)
        for k, item in enumerate(place.value)
        if isinstance(item, float)
    }


@one_thread
def contact_sensitivity(
    result: Any,
    meshes: list[MeshSolution],
    parameters: tuple[str, ...] = (),
    outputs: tuple[str, ...] = (),
    default: Iterable[str] = (),
    excluded: Mapping[str, str] | None = None,
) -> Sensitivity:
    """Return derivatives of the outputs of a contact.

    Parameters
    ----------
    result : Result
    meshes : list of MeshSolution
        Its solutions; derivatives are taken on the last one.
    parameters : tuple of str
        Dotted names; all continuous fields, without the items of lists, if empty.
    outputs : tuple of str
        Names; ``default`` if empty.
    default : iterable of str
    excluded : mapping
        Fields without a derivative, with the reason.

    Raises
    ------
    InvalidProblem
        For a name that is not a continuous field or not an output, and for excluded fields.
    """
    problem, known, excluded = result.problem, continuous_fields(result.problem), excluded or {}
    has_air = getattr(problem, "air", None) is not None
    available = (*meshes[-1].outputs, *(air_outputs() if has_air else ()))
    for name in outputs:
        if name not in available:
            text = f"no derivative of {name!r} is available{did_you_mean(name, available)}"
            raise InvalidProblem.at("outputs", text)
    outputs = outputs or tuple(default)
    if not known.keys() >= set(parameters):
        known |= _list_items(problem)
    for name in parameters:
        if name not in known:
            raise InvalidProblem.at(name, f"not a continuous field{did_you_mean(name, known)}")
        if name in excluded:
            raise InvalidProblem.at(name, excluded[name])
    names = parameters or tuple(name for name in known if name not in excluded)
    history = [
        (mesh.size, _derivatives_on_mesh(mesh, problem, names, known, outputs))
        for mesh in meshes[-CHANGES - 1 :]
    ]
    errors = {key: error_estimate(history, key) for key in history[-1][1]}
    shape = len(outputs), len(names)
    keys = [f"{output}/{name}" for output in outputs for name in names]
    return Sensitivity(
        outputs,
        names,
        np.array([history[-1][1][key] for key in keys]).reshape(shape),
        np.array(
            [
                meshes[-1].outputs[name] if name in meshes[-1].outputs else value_of(result, name)
                for name in outputs
            ]
        ),
        np.array([known[name] for name in names]),
        near_zone_change(meshes[-1]),
        np.array([errors[key] for key in keys]).reshape(shape),
    )


def _derivatives_on_mesh(
    mesh: MeshSolution,
    problem: Any,
    names: tuple[str, ...],
    known: Mapping[str, float],
    outputs: tuple[str, ...],
) -> dict[str, float]:
    """Return the derivatives on one mesh by "output/parameter"."""
    solved = _PerturbedProblems(mesh, outputs)
    derivatives: dict[str, float] = {}
    for name in names:
        derivative = _central_difference(solved, problem, name, known[name])
        derivatives |= {
            f"{output}/{name}": value
            for output, value in zip(outputs, derivative.tolist(), strict=True)
        }
    return derivatives


class _PerturbedProblems:
    """Outputs of perturbed problems on one mesh, by Newton steps from its solution.

    The Jacobian of the solution is factorised once, with its rows scaled to a maximum of one.
    """

    def __init__(self, mesh: MeshSolution, outputs: tuple[str, ...]) -> None:
        self.mesh, self.outputs = mesh, outputs
        system, state, active = mesh.system, mesh.state, mesh.active
        matrix = system_matrix(system, system.jacobian(state), active)
        matrix[:, system.ln_a] = self._half_width_column()
        matrix *= system.scales
        self.row_size = np.abs(matrix).max(axis=1)
        self.factors = lu_factor(matrix / self.row_size[:, None], check_finite=False)
        self.residual = self._residual(state)

    def _half_width_column(self) -> Array:
        """Return the derivatives of all residuals by ln a, by a central difference.

        The column of Newton's method is accurate to a few digits only.
        """
        system, state = self.mesh.system, self.mesh.state
        above, below = state.u.copy(), state.u.copy()
        above[system.ln_a] += STEP
        below[system.ln_a] -= STEP
        change = self._residual(system.evaluate(above)) - self._residual(system.evaluate(below))
        return np.asarray(change / (2 * STEP))

    def _residual(self, state: Any) -> Array:
        """Return the residual of all equations with the active set of the solution."""
        return np.append(state.equilibrium, friction_residual(state, self.mesh.active))

    def __call__(self, problem: Any) -> Array:
        """Return the outputs of a problem that differs slightly from the solved one."""
        has_air = getattr(problem, "air", None) is not None
        if has_air:
            system, u = self._solve_neighbour_with_air(problem)
        else:
            system, u = self._solve_neighbour(problem, self.mesh.state.u)
        state = system.evaluate(u)
        outputs = dict(system.outputs(state, self.mesh.active))
        if has_air:
            film = film_of_state(problem, system, state)
            outputs |= {name: value_of(film, name.partition(".")[2]) for name in air_outputs()}
        return np.array([outputs[name] for name in self.outputs])

    def _solve_neighbour(self, problem: Any, u: Array) -> tuple[Any, Array]:
        """Return the system of a problem and its solution u, by Newton steps from a guess.

        The residual that the solution itself has on this mesh is subtracted.
        """
        scales, system = self.mesh.system.scales, self.mesh.system.for_problem(problem)
        for _ in range(STEPS):
            change = self._residual(system.evaluate(u)) - self.residual
            step = lu_solve(self.factors, change / self.row_size, check_finite=False) * scales
            u = u - step
        return system, u

    def _solve_neighbour_with_air(self, problem: NipProblem) -> tuple[Any, Array]:
        """Return the system and the solution of a problem with air.

        Each iteration updates the friction coefficients by the air film.
        """
        system, u = self.mesh.system, self.mesh.state.u
        for _ in range(AIR_ITERATIONS):
            film = film_of_state(problem, system, system.evaluate(u))
            dry = problem.without_air(film.roll_friction, film.wrap_friction)
            system, u = self._solve_neighbour(dry, u)
        return system, u


def _central_difference(
    outputs_of: Callable[[Any], Array], problem: Any, name: str, value: float
) -> Array:
    """Return the central difference of outputs by a field; one-sided at the end of its range."""
    step = STEP * _step_scale(problem, name, value)

    def outputs_at(steps: int) -> Array | None:
        """Return the outputs at a number of steps from the value; None if it is not permitted."""
        try:
            return outputs_of(problem.replace(**{name: value + steps * step}))
        except InvalidProblem:
            return None

    above, below = outputs_at(1), outputs_at(-1)
    if above is not None and below is not None:
        return (above - below) / (2 * step)
    side = 1 if above is not None else -1
    one_step, two_steps, unshifted = outputs_at(side), outputs_at(2 * side), outputs_at(0)
    if one_step is None or two_steps is None or unshifted is None:
        raise InvalidProblem.at(name, "has no derivative: no neighbouring value is permitted")
    # one-sided difference of order two
    return np.asarray((4 * one_step - two_steps - 3 * unshifted) / (2 * step * side))


def _step_scale(problem: Any, name: str, value: float) -> float:
    """Return the scale of the difference step of a field."""
    head, _, rest = name.partition(".")
    thickness = getattr(getattr(problem, head), "thickness", np.inf)
    if head in problem.pair and rest.endswith("radius") and np.isfinite(thickness):
        return float(thickness)  # radii of a thin layer matter by their difference
    if value != 0:
        return abs(value)
    if name in ("winding_force", "web_tension"):
        return float(problem.drum_friction * problem.nip_load)
    if name in ("tangential_load", "load"):
        return float(problem.friction * problem.load)
    if name == "air.permeance":  # the film that escapes is of the order of the roughness
        return float(problem.air.roughness * problem.web_speed / max(problem.web_tension, 1.0))
    return 1 / problem.web.compliance.c22 if name.endswith("cross") else 1.0


def near_zone_change(mesh: MeshSolution) -> str:
    """Return the names of the traction nodes that are close to a change of their zone."""
    state, active = mesh.state, mesh.active
    if not active.size:  # without friction
        return ""
    slack = (state.bound - np.abs(state.traction)) / np.abs(state.bound).max()
    slip = np.abs(state.slip) / max(np.abs(state.slip).max(), 1e-300)
    nodes = np.nonzero(np.where(active == 0, slack, slip) < NEAR_CHANGE)[0]
    return ", ".join(mesh.system.node_names(nodes))

r"""Sensitivities of a solved contact by implicit differentiation.

On its last mesh and with its active set, a solution u of a problem with the inputs theta satisfies
R(u, theta) = 0, so that

    du/dtheta = -J^-1 dR/dtheta,    dQ/dtheta = dQ/dtheta (u fixed) + dQ/du du/dtheta

for any output Q(u, theta), J = dR/du.  Differences of R and Q by an input at the same u, and along
du/dtheta at the same inputs, are central, with an error of the square of the step.  J is factorised
once for all inputs.  The friction f of a nip with air is F(u, theta) of its air film
(:func:`.solve.solve_with_film`), so that df/dtheta = dF/dtheta + dF/du du/dtheta.  The derivatives
on the last three meshes give the error estimates.

The active set is kept: where a node is about to change its zone, derivatives to both sides differ,
and slip lengths have a kink.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeGuard

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from ..contact.newton import friction_residual, system_matrix
from ..contact.refinement import CHANGES, MeshSolution, richardson_estimates
from ..elasticity.mesh import Face
from ..elasticity.surface import SurfaceResponse
from ..errors import InvalidProblem, did_you_mean
from ..parallel import one_thread
from ..problems.bodies import Body
from ..problems.contact_problem import ContactProblem
from ..problems.nip import NipProblem
from ..problems.paths import get_field
from ..problems.rollers import RollerProblem
from ..quantities import numbers_of, scalar_outputs, value_of, walk
from ..results import Result
from ..sensitivity import Sensitivity
from .entrained_air import AirFilm, film_of_state

__all__ = ["contact_sensitivity"]

Array = np.ndarray

# Step relative to the scale of an input: the error of a central difference is its square, rounding
# of residuals (1e-14) over it.
STEP = 1e-4
# Solutions with the Jacobian, whose tangents of nonlinear bodies are inexact by up to 1e-2: two
# leave its square.
STEPS_NONLINEAR = 2
# Relative error of responses at the half widths next to that of the solution: differences of
# interpolated ones are those of the line.
INTERPOLATION = 1e-7
# Margin of a node's inequality, relative to the largest value, below which its zone may change.
NEAR_CHANGE = 1e-6


def air_outputs() -> tuple[str, ...]:
    """Return the names of the scalar outputs of an air film in a result."""
    return tuple(f"air.{name}" for name in scalar_outputs(AirFilm))


def has_air(problem: ContactProblem) -> TypeGuard[NipProblem]:
    """Return True for a nip with entrained air."""
    return isinstance(problem, NipProblem) and problem.air is not None


def _list_items(problem: ContactProblem) -> dict[str, float]:
    """Return the numbers in lists, such as the values of a profile, by dotted name."""
    return {
        f"{place.path}.{k}": item
        for place in walk(problem)
        if isinstance(place.value, tuple)
        for k, item in enumerate(place.value)
        if isinstance(item, float)
    }


def _inputs_of(
    problem: ContactProblem, parameters: tuple[str, ...], excluded: Mapping[str, str]
) -> dict[str, float]:
    """Return the values of the inputs by which derivatives are taken.

    Parameters
    ----------
    problem : Problem
    parameters : tuple of str
        Dotted names of continuous fields, or of items of lists; if empty, all continuous fields
        that are not excluded.
    excluded : mapping
        Fields without a derivative, with the reason.

    Raises
    ------
    InvalidProblem
        For a name that is not a continuous field, and for an excluded field, with the reason.
    """
    known = numbers_of(problem)
    if not parameters:
        return {name: value for name, value in known.items() if name not in excluded}
    if not known.keys() >= set(parameters):
        known |= _list_items(problem)
    for name in parameters:
        if name not in known:
            raise InvalidProblem.at(name, f"not a continuous field{did_you_mean(name, known)}")
        if name in excluded:
            raise InvalidProblem.at(name, excluded[name])
    return {name: known[name] for name in parameters}


@one_thread
def contact_sensitivity(
    result: Result,
    meshes: list[MeshSolution],
    parameters: tuple[str, ...],
    outputs: tuple[str, ...],
    excluded: Mapping[str, str],
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
        Names.
    excluded : mapping
        Fields without a derivative, with the reason.

    Raises
    ------
    InvalidProblem
        For a name that is not a continuous field or not an output, and for excluded fields.
    """
    problem, last = result.problem, meshes[-1]
    available = (*last.outputs, *(air_outputs() if has_air(problem) else ()))
    for name in outputs:
        if name not in available:
            text = f"no derivative of {name!r} is available{did_you_mean(name, available)}"
            raise InvalidProblem.at("outputs", text)
    inputs = _inputs_of(problem, parameters, excluded)
    # the error estimates need the derivatives on as many meshes
    linearised = [_Linearisation(mesh, problem, outputs) for mesh in meshes[-CHANGES - 1 :]]
    ends = np.cumsum([each.value_count for each in linearised])[:-1]

    def values_on_all_meshes(changed: ContactProblem) -> Array:
        """Return the values of a changed problem on all meshes, one after the other.

        On all of them at once, so that its bodies are tabulated only once.
        """
        return np.concatenate([each.values_of(changed, each.frictions) for each in linearised])

    for name, value in inputs.items():
        difference = _central_difference(values_on_all_meshes, problem, name, value)
        # ``ends`` divides the values by mesh
        for each, column in zip(linearised, np.split(difference, ends), strict=True):
            each.by_input.append(column)
    derivatives = [each.derivatives() for each in linearised]
    return Sensitivity(
        outputs,
        tuple(inputs),
        derivatives[-1],
        np.array([last.outputs.get(name, value_of(result, name)) for name in outputs]),
        np.array(list(inputs.values())),
        near_zone_change(last),
        richardson_estimates([each.mesh.size for each in linearised], derivatives),
    )


def _each_surface_once() -> Callable[[Body, Face, float, float | None], SurfaceResponse]:
    """Return a function that computes the surface of a body once for the same arguments.

    It is no method of the linearisation, which would then lead to itself.
    """
    known: dict[Any, SurfaceResponse] = {}

    def surface_of(body: Body, face: Face, a: float, speed: float | None) -> SurfaceResponse:
        """Return the surface of a body on a face of the half width ``a``."""
        key = body, face.points.tobytes(), a, speed
        if key not in known:
            known[key] = body.surface(face, a, speed)
        return known[key]

    return surface_of


class _Linearisation:
    """Residuals and outputs on one mesh, linearised at its solution.

    All are differentiated together, as one array of *values*

        (residuals of equilibrium and friction law | f_nip, f_wrap | outputs),     (value_count,)

    where f_nip and f_wrap, of a nip with air alone, are the friction coefficients by its air film.

    Parameters
    ----------
    mesh : MeshSolution
    problem : NipProblem or RollerProblem
        With air, if there is any; the equations of ``mesh`` are those without.
    outputs : tuple of str

    Attributes
    ----------
    frictions : (2,) tuple
        The friction coefficients of the equations of a nip with air; empty without air.
    by_input : list of (value_count,) arrays
        Derivatives of the values by each input, at the same u; the caller appends them, because
        those on all meshes are computed together.
    """

    def __init__(
        self, mesh: MeshSolution, problem: ContactProblem, outputs: tuple[str, ...]
    ) -> None:
        self.mesh, self.problem, self.outputs = mesh, problem, outputs
        self.u, self.size = mesh.state.u, mesh.state.u.size
        self.has_air = has_air(problem)
        dry = mesh.system.problem
        self.frictions = (dry.roll_friction, dry.friction_on_wrap) if self.has_air else ()
        self.by_input: list[Array] = []
        self.value_count = self.size + len(self.frictions) + len(outputs)
        self.surface_of = _each_surface_once()
        self.system = self._system(dry)
        # The system keeps the responses at these two half widths, and interpolates those between.
        for sign in (1, -1):
            self.system.evaluate(self._at_ln_a(sign * STEP))
        # columns of ln a by central differences, as the derivatives along du are
        matrix = system_matrix(self.system, self.system.jacobian(mesh.state), mesh.active)
        for column in self.system.ln_a:
            matrix[:, column] = self._along(np.eye(1, self.size, column)[0])[: self.size]
        matrix *= self.system.scales
        self.factors = lu_factor(matrix, check_finite=False)

    def _at_ln_a(self, change: float) -> Array:
        """Return the unknowns, (size,), with every ln a changed."""
        u = self.u.copy()
        u[self.system.ln_a] += change
        return u

    def _system(self, problem: ContactProblem) -> Any:
        """Return the equations of a problem, with the known surfaces of bodies that it shares."""
        system = self.mesh.system.for_problem(problem)
        for contact in getattr(system, "nips", (system,)):
            contact.surfaces.surface_of = self.surface_of
        return system

    def _values(self, system: Any, u: Array, problem: ContactProblem) -> Array:
        """Return the values of a problem at u, (value_count,); ``system`` holds its equations."""
        state, active = system.evaluate(u, INTERPOLATION), self.mesh.active
        residual, frictions = np.append(state.equilibrium, friction_residual(state, active)), []
        found = system.outputs(state, active, self.outputs)
        if has_air(problem):
            film = film_of_state(problem, state)
            found |= {name: value_of(film, name.partition(".")[2]) for name in air_outputs()}
            frictions = [film.roll_friction, film.wrap_friction]
        return np.concatenate([residual, frictions, [found[name] for name in self.outputs]])

    def values_of(self, problem: ContactProblem, frictions: tuple[float, ...]) -> Array:
        """Return the values of a perturbed problem at the same u, (value_count,).

        ``frictions`` are those of its equations without air; empty if it has no air.
        """
        dry = problem.without_air(*frictions) if has_air(problem) else problem
        return self._values(self._system(dry), self.u, problem)

    def derivatives(self) -> Array:
        """Return the total derivatives of the outputs by the inputs, (outputs, inputs).

        With air the frictions f of the equations vary with the inputs, and equal those by the film,
        F(theta, f): df/dtheta = dF/dtheta + dF/df df/dtheta, a linear system for df/dtheta.
        """
        total = np.array([self._with_solution(column) for column in self.by_input])
        if self.has_air:
            by_friction = np.array([self._with_solution(column) for column in self._by_friction()])
            film = slice(self.size, self.size + len(self.frictions))
            matrix = np.eye(len(self.frictions)) - by_friction[:, film].T
            friction_by_input = np.linalg.solve(matrix, total[:, film].T)
            total += friction_by_input.T @ by_friction
        return total[:, -len(self.outputs) :].T

    def _by_friction(self) -> list[Array]:
        """Return the derivatives of the values by each of ``frictions``, at the same u."""
        columns = []
        for step in STEP * np.diag(self.frictions):  # changes of both frictions; one is zero
            after, before = (
                self.values_of(self.problem, tuple(self.frictions + sign * step))
                for sign in (1, -1)
            )
            columns.append((after - before) / (2 * step.sum()))
        return columns

    def _with_solution(self, by_input: Array) -> Array:
        """Return the total derivatives of the values by an input, (value_count,).

        To those at the same u, ``by_input``, those along du = -J^-1 dR/dtheta are added: with du
        the residuals stay zero.
        """
        du, total = np.zeros(self.size), by_input
        for _ in range(1 if self.problem.linear else STEPS_NONLINEAR):
            step = lu_solve(self.factors, total[: self.size], check_finite=False)
            du -= step * self.system.scales
            total = by_input + self._along(du)
        return total

    def _along(self, direction: Array) -> Array:
        """Return the derivatives of the values, (value_count,), along a direction of u, (size,)."""
        largest = np.abs(direction / self.system.scales).max()
        step = STEP / max(largest, 1e-300)
        after, before = (
            self._values(self.system, self.u + sign * step * direction, self.problem)
            for sign in (1, -1)
        )
        return np.asarray((after - before) / (2 * step))


def _central_difference(
    values_of: Callable[[ContactProblem], Array], problem: ContactProblem, name: str, value: float
) -> Array:
    """Return the derivative of ``values_of(problem)``, (n,), by the field ``name``, (n,).

    ``value`` is that of the field in the problem.  It is a central difference quotient, one-sided
    at the end of the permitted range of the field.
    """
    step = STEP * _step_scale(problem, name, value)

    def values_at(steps: int) -> Array | None:
        """Return the values at a number of steps from the field's; None if it is not permitted."""
        try:
            return values_of(problem.replace(**{name: value + steps * step}))
        except InvalidProblem:
            return None

    above, below = values_at(1), values_at(-1)
    if above is not None and below is not None:
        return (above - below) / (2 * step)
    side = 1 if above is not None else -1
    one_step, two_steps, unshifted = values_at(side), values_at(2 * side), values_at(0)
    if one_step is None or two_steps is None or unshifted is None:
        raise InvalidProblem.at(name, "has no derivative: no neighbouring value is permitted")
    # one-sided difference of order two
    return np.asarray((4 * one_step - two_steps - 3 * unshifted) / (2 * step * side))


def _step_scale(problem: ContactProblem, name: str, value: float) -> float:
    """Return the size of a field, to which its difference step is relative, in its unit.

    It is the value; for a field at zero that of a quantity on which the result depends as strongly.
    """
    head, _, rest = name.partition(".")
    thickness = getattr(getattr(problem, head), "thickness", np.inf)
    if head in problem.pair and rest.endswith("radius") and np.isfinite(thickness):
        return float(thickness)  # radii of a thin layer matter by their difference
    if value != 0:
        return abs(value)
    if isinstance(problem, NipProblem):
        return _step_scale_of_nip(problem, name)
    if isinstance(problem, RollerProblem) and name in ("tangential_load", "load"):
        return problem.friction * problem.load
    if name.endswith("cross"):  # A_rt of 0 is compared with the radial modulus of the same body
        return float(get_field(problem, f"{name.removesuffix('cross')}radial"))
    return 1.0


def _step_scale_of_nip(problem: NipProblem, name: str) -> float:
    """Return the size of a field of a nip that is zero, as of :func:`_step_scale`."""
    if name in ("winding_force", "web_tension"):
        return problem.drum_friction * problem.nip_load
    # the film that escapes in a turn, 2 pi k T/V, is of the order of the roughness; 1 N/m stands
    # for the tension of a web without any
    if name == "air.permeance":
        assert problem.air is not None
        assert problem.web_speed is not None
        return problem.air.roughness * problem.web_speed / max(problem.web_tension, 1.0)
    # A_rt of 0 is compared with the radial modulus of the web: that of a roll may be a law
    if name.endswith("cross"):
        return float(1 / problem.web.compliance.c22)
    return 1.0


def near_zone_change(mesh: MeshSolution) -> str:
    """Return the names of the traction nodes that are close to a change of their zone."""
    state, active = mesh.state, mesh.active
    if not active.size:  # without friction
        return ""
    slack = (state.bound - np.abs(state.traction)) / np.abs(state.bound).max()
    slip = np.abs(state.slip) / max(np.abs(state.slip).max(), 1e-300)
    nodes = np.nonzero(np.where(active == 0, slack, slip) < NEAR_CHANGE)[0]
    return ", ".join(mesh.system.node_names(nodes))

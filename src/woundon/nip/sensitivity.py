r"""Exact sensitivities of a solved nip, by implicit differentiation of its equations.

In a given state of stick and slip the converged nip is a root of R(u, theta) = 0 with the unknowns
u = (p, Delta/R*, q, xi, ln a):

      p           shift   q                xi     ln a
    [ slope_p     1       slope_q          0      dR/dln a ]    indentation        N
    [ S           0       D                e      dR/dln a ]    sticking nodes    2n
    [ -s mu       0       1                0      0        ]    slipping nodes
    [ 0           0       w-               0      F        ]    winding force      1
    [ w           0       0                0      P        ]    nip load           1

An output J(u, theta) then changes by dJ/dtheta = J_theta - lambda . R_theta with lambda from
R_u^T lambda = J_u: one factorisation and one back-substitution an output serve all parameters.
R_theta is the equations' own change at fixed u, a difference of assembled matrices of which only
the changed body's are made anew; nothing is solved again.

The matrices are :class:`~.equations.NipMatrices`, those of the solution and of its certificate.
What is the same for a nip with its wraps is :class:`~.differential.Differential`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import kinds
from ..contact.levels import Level
from ..contact.response import Response, Tractions
from ..contact.resting import Resting
from ..contact.schemes import ELEMENTS
from ..errors import InvalidProblem, did_you_mean
from ..problems.nip import NipProblem
from ..quantities import walk
from ..results import ReadOnly
from ..threads import one_thread
from ..two_bodies import Matrices, mesh_of
from .border_sensitivity import BorderDifferential
from .differential import Differential
from .equations import NipEquations, NipMatrices
from .laws import NipLaws
from .result import RIG_ANGLE, NipResult
from .roll_surface import Rise
from .scatter import resting

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["Sensitivity", "continuous_fields", "differentiated", "nip_sensitivity"]

Array = np.ndarray
MOST_TOLD = 3  # parameters in one line


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(ReadOnly):
    """First derivatives of a nip's outputs at one problem.

    Of tensions corrected for where borders of stick lie within their cells (``extrapolation``) they
    are those of the corrected ones, but for what the influence of a border's nodes itself changes
    by: about the correction's share of the tension.

    Attributes
    ----------
    outputs : tuple of str
        Those asked for; else ``nip_induced_tension``, ``tension_behind_nip``, ``half_width``,
        ``nip_width``, ``drum_creep``, and before them ``wound_on_tension`` of a wrapped nip.
    parameters : tuple of str
        Dotted names of the fields.
    derivatives : (outputs, parameters) array
        SI units of output per SI unit of field.
    values, fields : (outputs,), (parameters,) arrays
        Where they were taken; values are those of which they are the derivatives.
    zone_change : str
        Empty, or the nodes that are about to change between stick and slip: there the
        derivatives to both sides differ.
    errors : (outputs, parameters) array
        Estimated discretisation errors of the derivatives; nan where they are not known.
    """

    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    derivatives: Array
    values: Array
    fields: Array
    zone_change: str = ""
    errors: Array | None = None

    def derivative(self, output: str, parameter: str) -> float:
        """Return d output / d parameter."""
        at = self.outputs.index(output), self.parameters.index(parameter)
        return float(self.derivatives[at])

    @property
    def elasticities(self) -> Array:
        """Percent of output per percent of field, (outputs, parameters); 0 for a field at 0.

        nan for an output that is 0.
        """
        values = np.where(self.values == 0, np.nan, self.values)
        return self.derivatives * self.fields / values[:, None]

    def to_xarray(self) -> xarray.Dataset:
        """Return derivatives [SI] and elasticities along ``output`` and ``parameter``."""
        import xarray

        dims = ("output", "parameter")
        tables = {
            "derivative": (dims, self.derivatives, {"long_name": "d output / d parameter, SI"}),
            "elasticity": (dims, self.elasticities, {"units": "1"}),
        }
        told = {"value": ("output", self.values), "field": ("parameter", self.fields)}
        places = {"output": list(self.outputs), "parameter": list(self.parameters)}
        return xarray.Dataset(tables, places | told, {"zone_change": self.zone_change})

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter: its value [SI] and the outputs' elasticities [1]."""
        import pandas as pd

        columns = {"value": self.fields, **dict(zip(self.outputs, self.elasticities, strict=True))}
        return pd.DataFrame(columns, index=pd.Index(self.parameters, name="parameter"))

    def __str__(self) -> str:
        text: str = kinds.fetch("woundon.show.report:sensitivity_text")(self)
        return text

    def __repr__(self) -> str:
        first = self.sorted()
        told = [f"{name} {value:+.2f}" for name, value in
                zip(first.parameters[:MOST_TOLD], first.elasticities[0], strict=False)]  # fmt: skip
        return (f"Sensitivity({self.outputs[0]}: {', '.join(told)} of {len(self.parameters)} "
                f"parameters; {len(self.outputs)} outputs)")  # fmt: skip

    def _repr_html_(self) -> str:
        head = "Elasticities: percent of output per percent of parameter"
        remarks = [f"At a zone change: {self.zone_change}"] if self.zone_change else []
        html: str = kinds.fetch("woundon.show.html:table_html")(
            head, self.sorted().to_dataframe(), remarks
        )
        return html

    def sorted(self) -> Sensitivity:
        """Return the same, the parameters of the largest elasticity of the first output first."""
        order = np.argsort(-np.abs(np.nan_to_num(self.elasticities[0])), kind="stable")
        return replace(
            self,
            parameters=tuple(self.parameters[k] for k in order),
            derivatives=self.derivatives[:, order],
            fields=self.fields[order],
            errors=None if self.errors is None else self.errors[:, order],
        )


def continuous_fields(problem: Any) -> dict[str, float]:
    """Return every continuous field of a description by its dotted name."""
    return {place.path: place.value for place in walk(problem) if isinstance(place.value, float)}


def _items(problem: Any) -> dict[str, float]:
    """Return the numbers of all lists, as a profile's values, by dotted name."""
    return {
        f"{place.path}.{k}": item
        for place in walk(problem) if isinstance(place.value, tuple)
        for k, item in enumerate(place.value) if isinstance(item, float)
    }  # fmt: skip


@one_thread
def nip_sensitivity(
    result: NipResult, parameters: tuple[str, ...], outputs: tuple[str, ...] = ()
) -> Sensitivity:
    """Return derivatives of a nip's outputs; see :class:`Sensitivity`.

    Parameters
    ----------
    result : NipResult
        Of :func:`solve_nip`; on its own mesh, in its own state, or between borders that move.
    parameters : tuple of str
        Dotted names; all continuous fields if empty, without the items of lists.
    outputs : tuple of str
        The main ones if empty; ``rig_tension`` beside them.

    Raises
    ------
    InvalidProblem
        For a name that is not a continuous field, or not one of these outputs.
    """
    made = BorderDifferential if result.scheme == ELEMENTS.name else _NipDifferential
    return differentiated(made, result, parameters, outputs, continuous_fields(result.problem))


def differentiated(
    made: type[Differential],
    result: Any,
    parameters: tuple[str, ...],
    outputs: tuple[str, ...],
    known: dict[str, float],
) -> Sensitivity:
    """Return a result's derivatives by named fields, all ``known`` ones if none is named."""
    told = made.outputs if set(outputs) <= set(made.outputs) else made.outputs + made.more
    for name in outputs:
        if name not in told:
            text = f"no exact derivative of {name!r} is known{did_you_mean(name, told)}"
            raise InvalidProblem.at("outputs", text)
    names = parameters or tuple(known)
    if not known.keys() >= set(names):
        known = known | _items(result.problem)
    for name in names:
        if name not in known:
            raise InvalidProblem.at(name, f"not a continuous field{did_you_mean(name, known)}")
    equations = made(result, told)
    # (unknowns, outputs); rows of one size, for they are of different units
    jacobian = equations.jacobian()
    size = np.max(np.abs(jacobian), axis=1, keepdims=True)
    adjoint = np.linalg.solve((jacobian / size).T, equations.output_gradients().T) / size
    derivatives = np.empty((len(told), len(names)))
    for k, name in enumerate(names):
        change, explicit = equations.changes(name, known[name])
        derivatives[:, k] = explicit - adjoint.T @ change
    outputs = outputs or told
    fields = np.array([known[name] for name in names])
    asked = [told.index(name) for name in outputs]
    values = equations.outputs_here[asked]
    if equations.resting is not None:  # what a result tells is found with factors a little older
        values = np.array([getattr(result, name) for name in outputs])
    return Sensitivity(
        outputs, names, derivatives[asked], values, fields, equations.near_zone_change()
    )


@dataclass(frozen=True, eq=False)
class _Unknowns:
    """A converged state: u of the module's text, and the states of the nodes."""

    pressure: Array
    shift: float
    traction: Array
    creep: float
    zones: Array


class _NipDifferential(Differential):
    """R and J of a nip alone."""

    outputs = (
        "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width", "drum_creep",
    )  # fmt: skip
    more = ("rig_tension",)

    def __init__(self, result: NipResult, told: tuple[str, ...]) -> None:
        super().__init__(result, told)
        problem, a, inside = result.problem, result.half_width, slice(1, -1)
        self.mesh = mesh_of(result)
        self.n = self.mesh.unknowns
        traction = np.concatenate([result.roll_traction[inside], result.drum_traction[inside]])
        self.about = NipMatrices.loads(result.pressure[inside], traction)
        self.here = NipMatrices.at(problem, self.mesh, a, self.about)
        named = zip(problem.pair, problem.bodies, self.here.responses, self.about, strict=True)
        self.bodies = {
            name: _once(response, load, problem.linear, body.rigid)
            for name, body, response, load in named
        }
        whole = float(self.here.weights @ (traction[: self.n] + traction[self.n :]))
        c11 = problem.web.compliance.c11
        creep = result.drum_creep + c11 / problem.web.thickness * (problem.web_tension + whole)
        shift = result.offset / problem.contact_radius
        zones = np.concatenate([result.roll_zone[inside], result.drum_zone[inside]])
        self.u = _Unknowns(result.pressure[inside], shift, traction, creep, zones)
        self.nodes = slice(0, 2 * self.n)
        self.rest = self.residual(problem, self.assembled(problem, a, ""))
        self.resting = self._resting()

    def _resting(self) -> Resting | None:
        """Return what NIT changes by as borders come to rest; None of a result without."""
        equations = NipEquations(self.problem, self.mesh, self.here)
        told = self.mesh.regardless and self.result.extrapolation
        if not told or equations.joint is None:
            return None
        state = equations.state(equations.joint.solve(self.u.zones))
        # NIT does not ask for the power, as widths do
        level = Level(self.mesh, equations, state, self.problem.nip_load, 2.0)
        return resting(self.problem, level)

    def residual(self, problem: NipProblem, made: Matrices | NipLaws) -> Array:
        """Return R at the fixed unknowns, of another problem or half width."""
        u, n = self.u, self.n
        p, q = u.pressure, u.traction
        miss, slip = self.laws(made)
        law = np.where(u.zones == 0, slip, q - u.zones * self._bounds(problem))
        force = float(made.weights @ q[n:]) - problem.winding_force
        load = float(made.weights @ p) - problem.nip_load
        return np.concatenate([miss, law, [force, load]])

    def laws_of(self, made: Matrices | NipLaws) -> tuple[Array, Array]:
        """Return what is left of the indentation, and slips."""
        u = self.u
        miss, slips = made.laws(u.pressure, u.traction, u.shift, u.creep)
        return miss, slips[self.nodes]

    def _bounds(self, problem: NipProblem) -> Array:
        """Return what friction can hold, (2n,)."""
        friction = np.repeat([problem.roll_friction, problem.drum_friction], self.n)
        return np.asarray(friction * np.tile(self.u.pressure, 2))

    def jacobian(self) -> Array:
        """Return R_u, (3n + 3, 3n + 3)."""
        n, made, u, problem = self.n, self.here, self.u, self.problem
        size = 3 * n + 3
        J = np.zeros((size, size))
        rows, p, q = slice(0, n + 1), slice(0, n), slice(n + 1, 3 * n + 1)
        J[rows, p], J[rows, n], J[rows, q] = made.slope_p, 1.0, made.slope_q
        stuck = u.zones == 0
        friction = np.repeat([problem.roll_friction, problem.drum_friction], n)
        law = np.zeros((2 * n, size))
        law[:, p] = np.where(
            stuck[:, None], made.through_pressure[self.nodes],
            -(u.zones * friction)[:, None] * np.tile(np.eye(n), (2, 1)),
        )  # fmt: skip
        law[:, q] = np.where(stuck[:, None], made.direct[self.nodes], np.eye(2 * n))
        law[n:, 3 * n + 1] = stuck[n:]
        J[n + 1 : 3 * n + 1] = law
        J[3 * n + 1, 2 * n + 1 : 3 * n + 1] = made.weights
        J[3 * n + 2, p] = made.weights
        J[:, -1], _ = self._by_width
        return J

    def output_gradients(self) -> Array:
        """Return J_u of the outputs, (outputs, unknowns)."""
        n, w, u = self.n, self.here.weights, self.u
        NIT, width, creep = np.zeros((3, 3 * n + 3))
        NIT[n + 1 : 3 * n + 1] = np.tile(w, 2)
        NIT[-1] = float(w @ (u.traction[:n] + u.traction[n:]))
        width[-1] = self.half_width
        # xi- = xi - c11 T_out/(2h)
        stretch = self.problem.web.compliance.c11 / self.problem.web.thickness
        creep[:] = -stretch * NIT
        creep[3 * n + 1] = 1.0
        if self.resting is not None:
            NIT[:-1] += self.resting.gradients[0]
            NIT[-1] = self._by_width[1][0]
        told = [NIT, NIT, width, 2 * width, creep]
        if "rig_tension" in self.told:  # T_rig = T_out + 2h/c11 [eps1(rig) - eps1(a)]
            rise_p, rise_q, wider = self._rise.gradients(self.step)
            rig = NIT.copy()
            rig[:n] += rise_p / stretch
            rig[n + 1 : 2 * n + 1] += rise_q / stretch
            rig[-1] += wider / stretch
            told.append(rig)
        return np.array(told)

    @cached_property
    def _by_width(self) -> tuple[Array, Array]:
        return self.by_width()

    @cached_property
    def _rise(self) -> Rise:
        return Rise(self.problem, self.mesh.grid, self.half_width, RIG_ANGLE, self.about[0])

    def output_values(self, problem: NipProblem, made: Matrices | NipLaws) -> Array:
        """Return the outputs of another problem or half width at the fixed unknowns."""
        w, u, n, a = made.weights, self.u, self.n, made.half_width
        NIT = float(w @ (u.traction[:n] + u.traction[n:]))
        T_out = problem.web_tension + NIT
        creep = u.creep - problem.web.compliance.c11 / problem.web.thickness * T_out
        if self.resting is not None:
            _, slip = self.laws(made)
            rest = self.resting.under(slip, u.traction, self._bounds(problem))
            NIT += float(rest[0]) * (a / self.half_width)  # as the integral of given tractions
            T_out = problem.web_tension + NIT
        told = [NIT, T_out, a, 2 * a, creep]
        if "rig_tension" in self.told:
            stretch = problem.web.compliance.c11 / problem.web.thickness
            told.append(T_out + self._rise.of(problem, a) / stretch)
        return np.array(told)

    def assembled(self, problem: NipProblem, a: float, part: str) -> Matrices | NipLaws:
        """Assemble for a half width and a problem of which only one part is another ('' none).

        Of linear bodies without matrices.
        """
        if a != self.half_width:
            if problem.linear:
                return NipLaws.at(problem, self.mesh, a)
            return NipMatrices.at(problem, self.mesh, a, self.about)
        bodies = self.bodies
        if part in bodies:
            loads = self.about[problem.pair.index(part)]
            body = getattr(problem, part)
            bodies = bodies | {part: problem.respond(body, self.mesh, a, loads)}
        elif part == problem.speed_field:
            bodies = bodies | {
                name: problem.respond(body, self.mesh, a)
                for name, body in zip(problem.pair, problem.bodies, strict=True)
                if body.viscoelastic
            }
        one, two = bodies.values()
        if problem.linear:
            return NipLaws(problem, self.mesh, a, (one, two))
        return NipMatrices.of(problem, self.mesh, a, one, two, self.about)

    def bounds(self) -> Iterator[tuple[str, Array, Array]]:
        """Yield each face by name, the nodes of its tractions, and what friction can hold there."""
        nodes = np.arange(1, self.n + 1)
        for face, friction in (
            ("roll", self.problem.roll_friction), ("drum", self.problem.drum_friction),
        ):  # fmt: skip
            yield face, nodes, friction * self.u.pressure


def _once(response: Response, load: Tractions, linear: bool, rigid: bool) -> Response:
    """Return a response that is integrated once for all fields; the loads are the same for all."""
    if not linear:
        return Response(response.gradients, slope=response.slope, strain=response.strain)
    if rigid:
        return response
    known = response.act(*load)
    return Response(lambda: response.gradients, act=lambda: lambda *_: known)

"""The finished roll: equations of a problem, changes after winding, and the arrays of a result.

After winding, temperature and moisture change, and the core shrinks by the strain eps_c.  Without
stress the layers would be strained by e_t(r) along the web and by e_r(r) through the stack, the
core by e_c.  Compatibility (:mod:`.equations`) contains D e_t + e_t - e_r, so that the stresses are
those of a stage with C and T_c changed by

    dC = E_t (e_t - e_r + r e_t'),        dT_c = E_t (e_c - e_t(r_c) - eps_c).

The core may be removed or shrink away from the roll, and layers may part (:mod:`.separation`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import NotConverged
from ..problems.schedules import Profile
from .equations import (
    CellSource,
    StageData,
    StageEquations,
    StageSolution,
    interpolate_pressure,
)
from .roll_fields import RollFields
from .separation import (
    ContactZones,
    NotSeparatedError,
    contact_zones,
    solve_on_core,
    with_open_layers,
)
from .stage_nodes import cell_source, evaluate_in_cells, kinks_of, nodes_between

if TYPE_CHECKING:
    from ..problems.roll import RollProblem
    from .growth import Growth

__all__ = [
    "FEWEST_CELLS",
    "ROUNDING",
    "FinalChanges",
    "core_gap",
    "equations_of",
    "finished_arrays",
    "finished_zones",
    "opening",
    "surface_layer_depth",
    "with_nodes",
]

Array = np.ndarray

# Largest E_t/E_c that is distinguished from an infinite one: the pressure on the core is then about
# 1e-5 of the largest.  The nodes are E_c/E_t apart there; closer ones differ by rounding in ln r.
SOFTEST_CORE = 1e7
SAME = 1e-9  # of ln r: nodes closer together are one
FEWEST_CELLS = 23  # of a stage, and of a zone between open layers
# Pressure below zero, relative to the largest one, that is a rounding error: layers in contact.
ROUNDING = 1e-9


def equations_of(problem: RollProblem) -> StageEquations:
    """Return the boundary-value problem of the stages of a roll, with its stack and core.

    The core condition is Q = b P - T_c with b = E_t/E_c - 1 + nu, E_c the stiffness of the core.
    With a web speed and a density they are those of the running roll.
    """
    stack, E_c = problem.stack, problem.core.effective_stiffness
    E_t, law = stack.tangential, stack.radial
    core = min(E_t / E_c, SOFTEST_CORE) - 1 + stack.poissons_ratio
    return StageEquations(
        law.strain_at,
        law.modulus,
        law.modulus_slope,
        E_t,
        core,
        centrifugal=problem.centrifugal_stress,
        poissons_ratio=stack.poissons_ratio,
    )


def surface_layer_depth(problem: RollProblem) -> float:
    """Return the depth, in ln r, of the layer below the surface in which the pressure rises.

    It is not a layer of the web.  The modulus doubles in it; if the modulus is nearly constant,
    solutions of the incremental equation decay in it.
    """
    law, E = problem.stack.radial, float(problem.stack.radial.modulus(0.0))
    T = float(problem.tension_curve.at(np.array(problem.core.radius))) - problem.centrifugal_stress
    return min(law.pressure_at_modulus(2 * E) / T, (E / problem.stack.tangential) ** 0.5, 0.3)


class FinalChanges:
    """The changes of the source C and of T_c of the core condition after winding.

    They are those by free strains of layers and core, and by the shrinkage of the core.

    Parameters
    ----------
    problem : RollProblem

    Attributes
    ----------
    core : float
        dT_c [Pa].
    kinks : (k,) array
        ln r at which the slope of a free strain jumps.
    """

    def __init__(self, problem: RollProblem) -> None:
        self.strains, self.tangential = problem.free_strains, problem.stack.tangential
        r_c = np.array([problem.core.radius])
        core = sum((s.core - s.along) * float(s.change.at(r_c)[0]) for s in self.strains)
        self.core = self.tangential * (core - problem.core_shrinkage)
        profiles = [s.change for s in self.strains if isinstance(s.change.schedule, Profile)]
        kinks = [change.kinks for change in profiles]
        self.kinks = np.log(np.unique(np.concatenate(kinks))) if kinks else np.zeros(0)

    def along(self, r: Array) -> Array:
        """Return the free strain e_t along the web at radii [1]."""
        return np.asarray(sum(s.along * s.change.at(r) for s in self.strains))

    def through(self, r: Array) -> Array:
        """Return the free strain e_r through the stack at radii [1]."""
        return np.asarray(sum(s.through * s.change.at(r) for s in self.strains))

    def source(self, x: Array, side: int | Array = 1) -> Array:
        """Return dC at ln r = x [Pa]; at a kink, that of its inner (-1) or outer (1) side."""
        r = np.exp(x)
        slope = sum(s.along * s.change.slope(r, side) for s in self.strains)
        return np.asarray(self.tangential * (self.along(r) - self.through(r) + r * slope))

    def added_to(self, source: CellSource, x: Array) -> CellSource:
        """Return a source in cells with the nodes ln r = x after the changes [Pa]."""
        change = evaluate_in_cells(x, self.source)
        return CellSource(*(C + dC for C, dC in zip(source, change, strict=True)))


def core_gap(result: RollFields) -> float:
    """Return the gap between core and roll of a roll result [m], zero if they touch.

    It follows from the core condition: (b P - T_c - Q) r_c/E_t, with P = 0.  Nan for a core that is
    removed.
    """
    problem, P, Q = result.problem, result.pressure[0], result.pressure_gradient[0]
    if problem.core_removed:
        return float("nan")
    if P != 0:
        return 0.0
    r_c = problem.core.radius
    T_c = float(problem.tension_curve.at(np.array([r_c]))[0]) + FinalChanges(problem).core
    return float(-(T_c + Q) * r_c / problem.stack.tangential)


def opening(result: RollFields) -> Array:
    """Return the radial strain by gaps between open layers of a roll result, (M,) [1].

    It is C/E_t, and zero where the layers are in contact.
    """
    is_open = (result.pressure == 0) & (result.pressure_gradient == 0)
    return np.where(is_open, result.source / result.problem.stack.tangential, 0.0)


def finished_arrays(
    problem: RollProblem, x: Array, growth: Growth, solved: StageSolution
) -> dict[str, Any]:
    """Return the arrays of a roll result at rest, after the changes of the finished roll.

    Parameters
    ----------
    problem : RollProblem
    x : (M,) array
        ln r of the nodes.
    growth : Growth
        Kappa at the stages of the build-up, from which the source follows.
    solved : StageSolution
        Pressure as wound, the initial guess of that at rest after the changes.

    Returns
    -------
    dict
        Fields of :class:`~woundon.RollResult` by name.

    Raises
    ------
    NotConverged
        If no equilibrium exists after the changes.
    """
    equations, curve, stack = equations_of(problem).at_rest, problem.tension_curve, problem.stack
    x, P, Q = _finished_state(problem, equations, x, growth, solved)
    r = np.exp(x)
    r[0], r[-1] = problem.core.radius, problem.radius  # without the rounding error of exp(ln r)
    T, changes = curve.at(r), FinalChanges(problem)
    source = changes.added_to(cell_source(curve, growth, x), x)
    E_t = stack.tangential
    hoop = -(P + Q)
    strain = (hoop + stack.poissons_ratio * P) / E_t
    strain = strain + changes.along(r)
    return {
        "radius": r,
        "pressure": P,
        "hoop_stress": hoop,
        # since the layer was wound with the strain T/E_t
        "displacement": r * (strain - T / E_t),
        "layer_strain": strain,
        "radial_modulus": stack.radial.modulus(P),
        # at a kink, the source of its outer side
        "source": np.append(source.left, source.right[-1]),
        "pressure_gradient": Q,
        "stage_radius": np.exp(growth.x),
        "growth": growth.kappa,
        "stage_order": growth.point_counts,
        # nan until layers of a finite thickness are computed (ThinLayerRoll.with_finite_layers)
        "layer_growth": np.full_like(growth.kappa, np.nan),
        # -r P' = T - c at the surface of the roll as wound, except for the discretisation error
        "surface_slope": float(-solved.Q[-1] / (T[-1] - problem.centrifugal_stress) - 1),
        "steps": equations.steps,
    }


def _finished_state(
    problem: RollProblem,
    equations: StageEquations,
    x: Array,
    growth: Growth,
    wound: StageSolution,
) -> tuple[Array, Array, Array]:
    """Return nodes ln r, P and Q of the finished roll, (M,) arrays [Pa].

    The nodes differ from those of the roll as wound if layers have parted, and by the kinks of the
    changes.

    Parameters
    ----------
    problem : RollProblem
    equations : StageEquations
        Of thin layers.
    x : (n + 1,) array
        ln r of the nodes as wound.
    growth : Growth
    wound : StageSolution
        As wound.

    Raises
    ------
    NotConverged
        If no equilibrium exists after the changes.
    """
    curve, removed = problem.tension_curve, problem.core_removed
    changes = FinalChanges(problem)
    T_c = float(curve.at(np.array([problem.core.radius]))[0]) + changes.core

    def source_at(nodes: Array) -> CellSource:
        """Return the source in the cells between nodes, after the changes [Pa]."""
        return changes.added_to(cell_source(curve, growth, nodes), nodes)

    def nodes_of_zone(inner: float, outer: float) -> Array:
        """Return as many nodes between two ends as the roll has, dense at both."""
        kinks, jumps = kinks_of(curve, growth, outer)
        of_changes = changes.kinks[changes.kinks < outer]
        kinks = np.append(kinks, of_changes)
        jumps = np.append(jumps, np.zeros(of_changes.size))  # only their places count
        order = np.argsort(kinks)
        cells = max(x.size - 1 - curve.kinks.size, FEWEST_CELLS)
        depth = surface_layer_depth(problem)
        layer = equations.core_layer
        return nodes_between(inner, outer, cells, depth, kinks[order], jumps[order], layer)

    P, Q = wound.P, wound.Q
    if changes.kinks.size:
        with_kinks = with_nodes(x, changes.kinks)
        P, Q = interpolate_pressure(x, P, Q, with_kinks)
        x, wound = with_kinks, wound._replace(P=P, Q=Q)
    data = StageData(x, source_at(x), T_c)
    final = solve_on_core(equations, data, P, Q, removed)
    if final is None:
        raise NotConverged("no equilibrium after the changes of the finished roll")
    (P, Q, _), off_core = final
    if np.min(P) < -ROUNDING * np.max(np.abs(P)):
        try:
            return with_open_layers(equations, source_at, nodes_of_zone, T_c, (x, wound.P), removed)
        except NotSeparatedError as fault:
            text = f"after the changes of the finished roll {fault}"
            raise NotConverged(text) from None
    if off_core[0]:
        P[0] = 0.0  # without rounding: it marks a roll off its core
    return x, P, Q


def with_nodes(x: Array, kinks: Array) -> Array:
    """Return nodes ln r with those of kinks added; nodes next to a kink are replaced by it."""
    nearest = np.min(np.abs(x[1:-1, None] - kinks), axis=1)
    inner = x[1:-1][nearest > SAME]
    return np.concatenate([x[:1], np.union1d(inner, kinks), x[-1:]])


def finished_zones(problem: RollProblem, P: Array, Q: Array) -> ContactZones:
    """Return the zones of a finished roll whose layers are in contact.

    Parameters
    ----------
    problem : RollProblem
    P, Q : (M,) arrays
        Pressure and Q = r dP/dr of the result [Pa].
    """
    return contact_zones(P, Q, problem.core_removed or bool(P[0] == 0))

"""The finished roll: equations of a problem, changes after winding, and the arrays of a result.

After winding, temperature and moisture change, and the core shrinks by the strain eps_c.  Without
stress the layers would be strained by e_t(r) along the web and by e_r(r) through the stack, the
core by e_c.  Compatibility (:mod:`.equations`) contains D e_t + e_t - e_r, so that the stresses are
those of a stage with C and T_c changed by

    dC = E_t (e_t - e_r + r e_t'),        dT_c = E_t (e_c - e_t(r_c) - eps_c).

The core may be removed or shrink away from the roll, and layers may part (:mod:`.separation`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import NotConverged
from ..problems.schedules import Profile
from .build_up import Layers
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
from .stage_nodes import (
    cell_source,
    evaluate_in_cells,
    kinks_of,
    nodes_between,
    radii_of_nodes,
)

if TYPE_CHECKING:
    from ..problems.roll import RollProblem
    from ..problems.stack import Stack
    from .growth import Growth

__all__ = [
    "FEWEST_CELLS",
    "ROUNDING",
    "FinalChanges",
    "LayerStrains",
    "additional_pressure",
    "bore_displacement",
    "core_gap",
    "equations_of",
    "finished_arrays",
    "finished_zones",
    "layers_of",
    "middle_of_layers",
    "opening",
    "strains_of_layers",
    "surface_layer_depth",
    "surface_layer_of_stack",
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


def layers_of(problem: RollProblem) -> Layers:
    """Return the layers of a roll as they are wound."""
    h = float(problem.web_thickness)
    return Layers(equations_of(problem), problem.tension_curve, h, problem.centrifugal_stress)


def surface_layer_depth(problem: RollProblem) -> float:
    """Return the depth, in ln r, of the layer below the surface in which the pressure rises.

    It is not a layer of the web.  The modulus doubles in it; if the modulus is nearly constant,
    solutions of the incremental equation decay in it.
    """
    T = float(problem.tension_curve.at(np.array(problem.core.radius))) - problem.centrifugal_stress
    return surface_layer_of_stack(problem.stack, T)


def surface_layer_of_stack(stack: Stack, tension: float) -> float:
    """Return :func:`surface_layer_depth` for a wound-on stress less rho V^2 [Pa]."""
    law, E = stack.radial, float(stack.radial.modulus(0.0))
    return min(law.pressure_at_modulus(2 * E) / tension, (E / stack.tangential) ** 0.5, 0.3)


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

    It follows from the core condition: (b P - T_c - Q) r_c/E_t without contact.  Nan for a core
    that is removed.
    """
    problem, equations = result.problem, equations_of(result.problem)
    if problem.core_removed:
        return float("nan")
    if result.pressure[0] != 0:
        return 0.0
    r_c = problem.core.radius
    T_c = float(problem.tension_curve.at(np.array([r_c]))[0]) + FinalChanges(problem).core
    P, Q = (values[0] for values in additional_pressure(result))
    return float((equations.core * P - T_c - Q) * r_c / problem.stack.tangential)


def additional_pressure(result: RollFields) -> tuple[Array, Array]:
    """Return P and Q, the unknowns of :mod:`.equations`, at the nodes of a roll result [Pa].

    P is the pressure in addition to that under which the layers were wound.
    """
    return layers_of(result.problem).additional(
        np.log(result.radius), result.pressure, result.pressure_gradient
    )


def bore_displacement(result: RollFields) -> float:
    """Return the outward displacement of the inner face of a roll since its first layer [m].

    It is r_c times the strain of the layers at the core since they were wound under p,
    ((nu - 1) P - Q - T_c)/E_t, plus p/E_c: the first layer was laid on the core with 2 p.  On the
    core it is -r_c (P - p)/E_c, the total pressure less 2 p, by the core condition.  Half of the
    gap between the first two open layers counts for the first one.
    """
    problem, stack, r_c = result.problem, result.problem.stack, result.radius[:1]
    P, Q = (values[:1] for values in additional_pressure(result))
    p = layers_of(problem).own_pressure(np.log(r_c))
    strain = ((stack.poissons_ratio - 1) * P - Q - problem.tension_curve.at(r_c)) / stack.tangential
    strain += p / problem.core.effective_stiffness + FinalChanges(problem).along(r_c)
    half_gap = float(opening(result)[0]) * float(problem.web_thickness) / 2
    return float((r_c * strain)[0]) + half_gap


def opening(result: RollFields) -> Array:
    """Return the radial strain by gaps between open layers of a roll result, (M,) [1].

    It is C/E_t less the compression of the layers as wound, zero where they are in contact.
    """
    is_open = (result.pressure == 0) & (result.pressure_gradient == 0)
    layers, E_t = layers_of(result.problem), result.problem.stack.tangential
    wound = layers.equations.strain(layers.own_pressure(np.log(result.radius)))
    return np.where(is_open, result.source / E_t - wound, 0.0)


class LayerStrains(NamedTuple):
    """Hoop stress [Pa] of the layers of a finished roll, strain [1] and displacement [m], (M,)."""

    hoop_stress: Array
    displacement: Array
    layer_strain: Array


def strains_of_layers(problem: RollProblem, r: Array, P: Array, Q: Array) -> LayerStrains:
    """Return the hoop stress of a finished roll, and what follows from it by the law of the stack.

    The displacement is that since the layer was wound, with the hoop stress T under the mean
    pressure p.

    Parameters
    ----------
    problem : RollProblem
    r, P, Q : (M,) arrays
        Nodes [m], total pressure and r times its gradient [Pa].
    """
    stack, layers = problem.stack, layers_of(problem)
    x = np.log(middle_of_layers(r, r, layers.thickness))
    P, Q = interpolate_pressure(np.log(r), P, Q, x)
    E_t, nu, hoop = stack.tangential, stack.poissons_ratio, -(P + Q)
    strain = (hoop + nu * P) / E_t + FinalChanges(problem).along(r)
    wound = (problem.tension_curve.at(r) + nu * layers.own_pressure(x)) / E_t
    return LayerStrains(hoop, r * (strain - wound), strain)


def middle_of_layers(r: Array, radius: Array, thickness: float) -> Array:
    """Return radii at which the hoop stress is that of the layers at r, (k,) each [m].

    -(P + r P') is the mean hoop stress of the layer with its middle at r.  The innermost and the
    outermost layer of a roll, ``radius`` from core to surface, have it at all radii within them.
    """
    middle = (radius[0] + radius[-1]) / 2
    inner, outer = min(radius[0] + thickness / 2, middle), max(radius[-1] - thickness / 2, middle)
    return np.clip(r, inner, outer)


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
        As wound, the initial guess of that at rest after the changes.

    Returns
    -------
    dict
        Fields of :class:`~woundon.RollResult` by name.

    Raises
    ------
    NotConverged
        If no equilibrium exists after the changes.
    """
    layers, curve, stack = layers_of(problem).at_rest, problem.tension_curve, problem.stack
    x, P, Q = _finished_state(problem, layers, x, growth, solved)
    r = radii_of_nodes(x, problem.core.radius, problem.radius)
    T, changes = curve.at(r), FinalChanges(problem)
    source = changes.added_to(cell_source(curve, growth, x), x)
    strains = strains_of_layers(problem, r, P, Q)
    return {
        "radius": r,
        "pressure": P,
        **strains._asdict(),
        "radial_modulus": stack.radial.modulus(P),
        # at a kink, the source of its outer side
        "source": np.append(source.left, source.right[-1]),
        "pressure_gradient": Q,
        "stage_radius": np.exp(growth.x),
        "growth": growth.kappa,
        "stage_order": growth.point_counts,
        # nan until the limit of thin layers is computed (WoundRoll.certified)
        "thin_layer_growth": np.full_like(growth.kappa, np.nan),
        # -r P' = T - c at the surface of the roll as wound, except for the discretisation error
        "surface_slope": float(-solved.Q[-1] / (T[-1] - problem.centrifugal_stress) - 1),
        "steps": layers.equations.steps,
    }


def _finished_state(
    problem: RollProblem,
    layers: Layers,
    x: Array,
    growth: Growth,
    wound: StageSolution,
) -> tuple[Array, Array, Array]:
    """Return nodes ln r, total pressure and r times its gradient in the finished roll, (M,) [Pa].

    The nodes differ from those of the roll as wound if layers have parted, and by the kinks of the
    changes.

    Parameters
    ----------
    problem : RollProblem
    layers : Layers
        Of the roll at rest.
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
        layer = layers.equations.core_layer
        return nodes_between(inner, outer, cells, depth, kinks[order], jumps[order], layer)

    P, Q = wound.P, wound.Q
    if changes.kinks.size:
        with_kinks = with_nodes(x, changes.kinks)
        P, Q = interpolate_pressure(x, P, Q, with_kinks)
        x, wound = with_kinks, wound._replace(P=P, Q=Q)
    own = layers.own_pressure(x)
    data = StageData(x, source_at(x), T_c, -own[-1], own=layers.own(x))
    final = solve_on_core(layers.equations, data, P, Q, removed)
    if final is None:
        raise NotConverged("no equilibrium after the changes of the finished roll")
    solved, off_core = final
    P, Q = layers.total(x, solved.P, solved.Q)
    if np.min(P) < -ROUNDING * np.max(np.abs(P)):
        try:
            guess = x, wound.P + own
            return with_open_layers(layers, source_at, nodes_of_zone, T_c, guess, removed)
        except NotSeparatedError as fault:
            text = f"after the changes of the finished roll {fault}"
            raise NotConverged(text) from None
    P[-1] = 0.0  # without rounding
    if off_core[0]:
        P[0] = 0.0  # it marks a roll off its core
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

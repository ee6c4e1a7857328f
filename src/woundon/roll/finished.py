"""The finished roll: equations of a problem, changes after winding, and the arrays of a result.

After winding, the temperature changes by dT and the core shrinks by the strain eps_c.  The stresses
are those of the equations of a stage (:mod:`.equations`) with C and T_c changed by

    dC = E_t (alpha_t - alpha_r) dT,        dT_c = E_t ((alpha_c - alpha_t) dT - eps_c).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import NotConverged
from .equations import CellSource, StageData, StageEquations, StageSolution
from .stage_nodes import cell_source

if TYPE_CHECKING:
    from ..problems.roll import RollProblem
    from .growth import Growth

__all__ = [
    "add_constant",
    "equations_of",
    "final_changes",
    "finished_arrays",
    "surface_layer_depth",
]

Array = np.ndarray

# Largest E_t/E_c that is distinguished from an infinite one: the pressure on the core is then about
# 1e-5 of the largest.  The nodes are E_c/E_t apart there; closer ones differ by rounding in ln r.
SOFTEST_CORE = 1e7


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


def final_changes(problem: RollProblem) -> tuple[float, float]:
    """Return the changes of the source C and of T_c of the core condition after winding [Pa].

    They are those by the temperature change and the shrinkage of the core.
    """
    E_t, dT = problem.stack.tangential, problem.temperature_change
    alpha_t = problem.tangential_expansion
    source = E_t * (alpha_t - problem.radial_expansion) * dT
    core = E_t * ((problem.core_expansion - alpha_t) * dT - problem.core_shrinkage)
    return source, core


def add_constant(source: CellSource, constant: float) -> CellSource:
    """Return a source with a constant [Pa] added in every cell."""
    return CellSource(*(part + constant for part in source))


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
    r = np.exp(x)
    T = curve.at(r)
    r[0], r[-1] = problem.core.radius, problem.radius  # without the rounding error of exp(ln r)
    source_change, core_change = final_changes(problem)
    source = add_constant(cell_source(curve, growth, x), source_change)
    final = equations.solve(StageData(x, source, float(T[0]) + core_change), solved.P, solved.Q)
    if final is None:
        raise NotConverged("no equilibrium after the change of temperature or core")
    P, Q, E_t = final.P, final.Q, stack.tangential
    hoop = -(P + Q)
    strain = (hoop + stack.poissons_ratio * P) / E_t
    strain = strain + problem.tangential_expansion * problem.temperature_change
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

"""The certificate of a wound roll: residuals of all equations on the reported arrays."""

from __future__ import annotations

from math import inf

import numpy as np

from ..results import Residuals, largest
from .finished import (
    FinalChanges,
    additional_pressure,
    core_gap,
    finished_zones,
    layers_of,
    opening,
    strains_of_layers,
)
from .roll_fields import RollFields
from .stage_nodes import cell_source

__all__ = ["certificate"]


def certificate(result: RollFields) -> Residuals:
    """Return the residuals of a result; stresses are relative to the wound-on stress at the core.

    equilibrium
        The collocated equations of :mod:`.equations` on the nodes of layers in contact.
    core_condition, free_surface
        The boundary conditions of the layers in contact; a core may not penetrate the roll.
    open_layers
        Largest overlap of open layers, which must have a gap; only with open layers.
    frozen_source
        The source equals that of the layers as wound plus the changes after winding.
    roll
        The radii of core and surface; infinite unless the stages are valid.
    hoop_stress, displacement, layer_strain, radial_modulus
        The values that follow from P and r P' by the law of the stack.
    positive_pressure
        Largest negative pressure, relative to the largest pressure.
    """
    problem, stack = result.problem, result.problem.stack
    curve, E_t, layers = problem.tension_curve, stack.tangential, layers_of(problem).at_rest
    r, P, Q = result.radius, result.pressure, result.pressure_gradient
    x, T = np.log(r), curve.at(r)
    unit, changes = float(T[0]), FinalChanges(problem)
    source = changes.added_to(cell_source(curve, result.kappa, x), x)
    radii = [problem.core.radius, result.stage_radius[-1]]
    zones = finished_zones(problem, P, Q)
    stage = zones.stage(layers, x, source, unit + changes.core)
    added, added_Q = (values[zones.nodes] for values in additional_pressure(result))
    residual, _ = layers.equations.residual(stage, added, added_Q)
    ends = np.append(2 * stage.firsts, 2 * stage.lasts + 1)  # the other rows are of cells
    strains = strains_of_layers(problem, r, P, Q)
    expected = np.append(source.left, source.right[-1])  # at the nodes, as reported
    # a core that is not removed may not penetrate the roll
    overlap = 0.0 if problem.core_removed else float(-core_gap(result)) * E_t / r[0]
    is_open = (P == 0) & (Q == 0)
    return Residuals(
        equilibrium=largest(np.abs(np.delete(residual, ends))) / unit,
        core_condition=max(abs(float(residual[0])), overlap) / unit,
        free_surface=largest(np.abs(residual[ends[1:]])) / unit,
        **({"open_layers": largest(-opening(result)) * E_t / unit} if is_open.any() else {}),
        frozen_source=largest(np.abs(result.source - expected)) / largest(np.abs(expected)),
        hoop_stress=largest(np.abs(result.hoop_stress - strains.hoop_stress)) / unit,
        layer_strain=largest(np.abs(result.layer_strain - strains.layer_strain)) * E_t / unit,
        displacement=largest(np.abs(result.displacement - strains.displacement) / r) * E_t / unit,
        radial_modulus=largest(np.abs(result.radial_modulus / stack.radial.modulus(P) - 1)),
        positive_pressure=largest(-P) / max(float(np.max(np.abs(P))), 1e-300),
        roll=largest(np.abs(r[[0, -1]] / radii - 1)) if _stages_are_valid(result) else inf,
    )


def _stages_are_valid(result: RollFields) -> bool:
    """Return True if the stages increase from the core, and their kappa are finite.

    A single stage near the core hardly affects the source, so that its residual does not show it.
    """
    s = result.stage_radius
    starts = result.stage_order[0] == 1 and abs(s[0] / result.problem.core.radius - 1) < 1e-9
    return bool(starts and (np.diff(s) > 0).all() and np.isfinite(result.growth).all())

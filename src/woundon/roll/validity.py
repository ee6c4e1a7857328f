"""Validity checks of a wound roll: strains of the web, and the range of the stack law.

In the texts of the warnings {} stands for the ratio that exceeds its limit, {0} and {1} for the
further arguments (:func:`woundon.validity.limit_warning`).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..problems.radial_laws import Constant
from ..problems.roll import RollProblem
from ..validity import LENGTH, PRESSURE, STIFFNESS, TENSION, limit_warning
from .collapse import collapse_loads
from .finished import opening
from .roll_fields import RollFields

__all__ = ["roll_warnings", "yield_warnings"]


def roll_warnings(result: RollFields) -> tuple[str, ...]:
    """Return the warnings of a wound roll outside the validity limits."""
    return (
        *_strain_warnings(result),
        *_stack_warnings(result),
        *_separation_warnings(result),
    )


def _separation_warnings(result: RollFields) -> Iterator[str]:
    """Yield warnings about layers that are open, and about inner layers that collapse."""
    gaps = opening(result)
    is_open = (gaps > 0).astype(int)
    if is_open.any():
        r, steps = result.radius, np.diff(is_open, prepend=0, append=0)
        zones = zip(r[np.flatnonzero(steps > 0)], r[np.flatnonzero(steps < 0) - 1], strict=True)
        radii = " and ".join(
            f"from {1e3 * first:.4g} to {LENGTH.stored_text(last)} radius" for first, last in zones
        )
        yield (
            f"the layers have separated {radii}: the changes after winding leave gaps of up to "
            f"{100 * gaps.max():.3g}% of their thickness"
        )
    if (load := collapse_loads(result).bonded) > 1:
        yield (
            "the inner layers collapse into the bore: the pressure on them is "
            f"{load:.3g} times the one at which a ring of bonded layers "
            "buckles"
        )


def _strain_warnings(result: RollFields) -> Iterator[str]:
    """Yield warnings about the strains of the web as it is wound, and in the finished roll."""
    problem = result.problem
    T = problem.tension_curve.at(result.radius)
    k = int(np.argmax(T))
    yield from limit_warning(
        "web strain",
        float(T[k]) / problem.stack.tangential,
        "the web is wound at a strain of {}, by a tension of {0}",
        TENSION.stored_text(T[k] * problem.web_thickness),
    )
    k = int(np.abs(result.layer_strain).argmax())
    if abs(result.layer_strain[k]) > T.max() / problem.stack.tangential:
        yield from limit_warning(
            "web strain",
            float(result.layer_strain[k]),
            "the strain of the layers is {} at the radius {0}",
            LENGTH.stored_text(result.radius[k]),
        )
    yield from limit_warning(
        "bending strain",
        problem.bending_strain(problem.core.radius),
        "the web is bent to a strain of {} on the core of {0} radius",
        LENGTH.stored_text(problem.core.radius),
    )


def _stack_warnings(result: RollFields) -> Iterator[str]:
    """Yield warnings about pressures beyond the range of the stack law."""
    stack = result.problem.stack
    law, k = stack.radial, int(np.argmax(result.pressure))
    P = float(result.pressure[k])
    yield from limit_warning(
        "layer compression",
        float(law.strain_at(P)),
        "the layers are compressed by {} at the pressure {0}",
        PRESSURE.stored_text(P),
    )
    if not isinstance(law, Constant):
        yield from limit_warning(
            "stack modulus",
            float(law.modulus(P)) / stack.tangential,
            "the stack law gives a radial modulus of {0} at the pressure {1}, {} of the modulus "
            "along the web",
            STIFFNESS.stored_text(law.modulus(P)),
            PRESSURE.stored_text(P),
        )


def yield_warnings(problem: RollProblem, yield_strain: float | None) -> tuple[str, ...]:
    """Return a warning if the web yields where it is bent on the core, under its tension.

    Parameters
    ----------
    problem : RollProblem
    yield_strain : float, optional
        Of the web, if it is known [1].
    """
    core = problem.core.radius
    bending = problem.bending_strain(core)
    wound = float(problem.tension_curve.at(np.array(core))) / problem.stack.tangential
    if yield_strain is None or wound + bending <= yield_strain:
        return ()
    return (
        f"the web yields where it is bent on the core of {LENGTH.stored_text(core)} radius: its "
        f"strain of {100 * wound:.3g}% by the tension and {100 * bending:.3g}% by bending exceeds "
        f"the yield strain of {100 * yield_strain:.3g}%",
    )

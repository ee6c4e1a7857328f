"""Nips and roll of a winding agree as requested, and the error estimates cover their causes.

Evidence: consistency of independent outputs; response to a change of the input by its own estimated
error.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from slow_cases import campaign_case, slow_case

import woundon as wo

CASE = wo.WindingProblem.example().replace(radius=0.12)
HARD = CASE.replace(roll_body="linear", nip_load=5000.0, web_tension=200.0)
pytestmark = pytest.mark.filterwarnings("ignore::woundon.ResolutionWarning")


# ---- agreement of nips and roll ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tension", "load", "friction", "shear", "radius"),
    [
        slow_case(207.85659124613983, 1578.5119236247078, 0.2884195401345401, 2.8116e6, 0.1086),
        campaign_case(214.6296494010098, 1387.0781981489881, 0.34015974081464495, 1.1488e7, 0.3684),
    ],
)
def test_nips_and_roll_agree_to_the_requested_tolerance(
    tension: float, load: float, friction: float, shear: float, radius: float
) -> None:
    """The wound-on tension at each nip is the nip's own, to the tolerance of the caller."""
    problem = CASE.replace(
        web_tension=tension, nip_load=load, roll_friction=friction, drum_friction=0.4,
        radius=radius, **{"stack.shear": shear},
    )  # fmt: skip
    run = wo.solve(problem, nodes=33, rtol=5e-3, coupling_rtol=1e-8)
    wound_on = np.interp(run.nip_radius, run.radius, run.wound_on_tension)
    assert np.max(np.abs(wound_on / run.nip_wound_on_tension - 1)) <= 1e-8
    assert run.coupling_rtol == 1e-8


def test_a_winding_that_agrees_less_well_is_not_certified() -> None:
    """The residual is relative to the requested tolerance, and no other can have been requested."""
    run = wo.solve(CASE.replace(roll_body="linear"), nodes=25, rtol=5e-2, coupling_rtol=1e-7)
    assert run.certified().largest <= 1e-8
    off = run.replace(nip_wound_on_tension=run.nip_wound_on_tension * (1 + 5e-7))
    assert off.certified().coupling == pytest.approx(5e-8, rel=1e-3)
    for tolerance in (0.02, float("inf"), -1e-3):
        assert not off.replace(coupling_rtol=tolerance).certified().largest <= 1e-8


# ---- error estimates -----------------------------------------------------------------------------


@cache
def wound(nodes: int, rtol: float) -> wo.WindingResult:
    return wo.solve(HARD, nodes=nodes, rtol=rtol)


def rewound(run: wo.WindingResult, factor: Callable[[Any], Any]) -> Any:
    """Wind the roll of a winding with its wound-on tension times a factor over the radius."""
    r, problem = run.radius, run.roll.problem
    stress = run.wound_on_tension / run.problem.web.thickness * factor(r)
    tension = wo.Profile(radius=r, value=stress * problem.web_thickness)
    return wo.solve(problem.replace(wound_on_tension=tension), rtol=1e-3)


def relative(run: wo.WindingResult, name: str) -> float:
    return float(run.errors[name] / getattr(run, name))


def test_a_winding_is_no_more_accurate_than_its_nips() -> None:
    run = wound(41, 1e-3)  # an error estimate takes three meshes
    nips = float(np.max(run.nip_error / run.nip_wound_on_tension))
    assert nips > 3 * run.interpolation_error
    assert relative(run, "mean_wound_on_tension") >= nips


def test_the_pressure_error_covers_that_of_the_tension() -> None:
    """The pressure of a plateau varies as the square of the tension."""
    run = wound(41, 1e-3)  # an error estimate takes three meshes
    off = relative(run, "mean_wound_on_tension")
    unchanged, more = rewound(run, np.ones_like), rewound(run, lambda r: 1 + off + 0 * r)
    for name in ("mid_pressure", "core_pressure"):
        own = run.roll.errors[name] / getattr(run, name)
        moved = getattr(more, name) / getattr(unchanged, name) - 1
        assert moved > 1.5 * off
        assert own + moved <= relative(run, name)


@pytest.mark.slow
def test_the_core_pressure_error_covers_that_of_the_tension_near_the_core() -> None:
    """Near the core, up to 5 % of its radius, the interpolation is less exact."""
    run = wound(65, 5e-2)
    core = run.problem.core.radius
    off, near = relative(run, "mean_wound_on_tension"), run.core_interpolation_error
    assert near > 5e-3
    unchanged = rewound(run, np.ones_like)
    more = rewound(run, lambda r: (1 + off) * np.where(r <= 1.0501 * core, 1 + near, 1.0))
    own = run.roll.errors["core_pressure"] / run.core_pressure
    moved = more.core_pressure / unchanged.core_pressure - 1
    assert own + moved <= relative(run, "core_pressure")

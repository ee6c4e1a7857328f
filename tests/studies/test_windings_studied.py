"""Studies of windings: fits to what a roll shows.

Rolls of a few millimetres and coarse nips: the studies are looked at here, not the digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rejections import assert_rejected

import woundon as wo

CASE = wo.WindingProblem.example().replace(radius=0.055, web_tension=350.0, roll_body="linear")
COARSE: dict[str, Any] = {"nodes": 33, "rtol": 2e-2}
LOADS = [800.0, 2500.0]
K2, MU = 40.0, 0.19


def data(problem: wo.WindingProblem, *outputs: str) -> dict[str, list[float]]:
    runs = [wo.solve(problem.replace(nip_load=load), **COARSE) for load in LOADS]
    return {"nip_load": LOADS} | {name: [getattr(run, name) for run in runs] for name in outputs}


@pytest.mark.campaign
def test_a_stack_is_fitted_to_core_pressures():
    found = wo.fit(
        CASE.replace(**{"stack.radial.K2": 60.0}), data(CASE, "core_pressure"),
        {"stack.radial.K2": (15.0, 100.0)}, starts=1, profiles=False,
        nodes=33, options={"rtol": 2e-2},
    )  # fmt: skip
    # what the roll's own tolerance, 2e-2 of its pressure, leaves in differences of it
    assert found.estimates[0] == pytest.approx(K2, rel=2e-3)


@pytest.mark.slow
def test_friction_and_stack_are_distinguished_by_two_pressures():
    case = CASE.replace(tension_law="friction")
    found = wo.fit(
        case.replace(roll_friction=0.3, **{"stack.radial.K2": 60.0}),
        data(case, "core_pressure", "mid_pressure"),
        {"roll_friction": (0.1, 0.5), "stack.radial.K2": (15.0, 100.0)},
        starts=1, profiles=False, options={"rtol": 2e-2},
    )  # fmt: skip
    np.testing.assert_allclose(found.estimates, [MU, K2], rtol=2e-3)


def test_pressures_over_the_radius_are_no_outputs_of_a_fit():
    measured = {"nip_load": LOADS, "pressure": [4e5, 6e5]}
    assert_rejected(
        lambda: wo.fit(CASE, measured, {"stack.radial.K2": (15.0, 100.0)}),
        "measured: pressure: no such output: it is the roll's, result.roll.pressure; numbers ",
    )

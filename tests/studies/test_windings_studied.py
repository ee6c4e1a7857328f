"""Studies of windings: a sweep that is killed and resumed, and fits to what a roll shows.

Rolls of a few millimetres and coarse nips: the studies are looked at here, not the digits.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import study_models as models
from rejections import assert_rejected

import woundon as wo

CASE = wo.WindingProblem.example().replace(radius=0.055, web_tension=350.0, roll_body="linear")
COARSE: dict[str, Any] = {"nodes": 33, "rtol": 2e-2}
SWEPT = """
import numpy as np
import woundon as wo
case = wo.WindingProblem.example().replace(radius=0.055, web_tension=350.0, roll_body="linear")
table = wo.sweep(case, {"nip_load": [1000.0, 1500.0, 2000.0, 2500.0]},
         ["core_pressure", "mean_wound_on_tension"], out=OUT, chunk=2, workers=1, resume=RESUME,
         nodes=25, rtol=5e-2)
np.save(OUT + ".npy", np.array([table.core_pressure, table.mean_wound_on_tension]))
"""
LOADS = [800.0, 2500.0]
K2, MU = 40.0, 0.19


def swept(out: Path, *, resume: bool) -> subprocess.Popen[bytes]:
    script = SWEPT.replace("OUT", repr(str(out))).replace("RESUME", str(resume))
    return subprocess.Popen([sys.executable, "-W", "ignore", "-c", script])


@pytest.mark.campaign
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="nothing is killed like that there")
def test_a_sweep_killed_and_resumed_gives_bit_for_bit_the_same(tmp_path: Path):
    """Windings start from each other, within a chunk only: what was lost with it is wound again."""
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    assert swept(whole, resume=False).wait() == 0
    worker = swept(cut, resume=False)
    while worker.poll() is None and not models.stored(cut):
        time.sleep(0.05)
    os.kill(worker.pid, signal.SIGKILL)
    assert worker.wait() == -signal.SIGKILL
    assert swept(cut, resume=True).wait() == 0
    one, two = (np.load(f"{out}.npy") for out in (whole, cut))
    assert np.isfinite(one).all()
    np.testing.assert_array_equal(one, two)


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

"""NumPy's error settings of the user do not change an answer: one case of every kind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from random_nips import (
    random_air,
    random_covered,
    random_hardening,
    random_layered,
    random_viscoelastic,
)
from slow_cases import slow_case

import woundon as wo

NIP = wo.NipProblem.example()
COARSE = {"nodes": 17}


@pytest.mark.parametrize(
    ("problem", "options"),
    [
        pytest.param(NIP.replace(roll_wrap=0.0), COARSE, id="plain"),
        pytest.param(NIP.replace(drum_wrap=1.0), COARSE, id="wrapped"),
        pytest.param(random_covered(1), COARSE, id="covered"),
        pytest.param(random_layered(2), COARSE, id="layered"),
        pytest.param(random_viscoelastic(0), COARSE, id="viscoelastic"),
        pytest.param(random_viscoelastic(2), COARSE, id="viscoelastic rollers"),
        pytest.param(random_air(2), COARSE, id="air"),
        pytest.param(wo.RollerProblem.example(), COARSE, id="rollers"),
        pytest.param(wo.RollProblem.example(), {}, id="roll"),
        slow_case(random_hardening(0), COARSE, id="hardening"),
        slow_case(wo.WindingProblem.example().replace(roll_body="linear"), {}, id="winding"),
    ],
)
@pytest.mark.filterwarnings("ignore::woundon.ValidityWarning", "ignore::woundon.ResolutionWarning")
def test_answers_do_not_depend_on_the_settings(problem: Any, options: dict[str, int]) -> None:
    """Errors are raised for every underflow, overflow, division by zero and invalid operation."""
    with np.errstate(all="raise"):  # first, because influence functions are kept
        # the report evaluates outputs that the solver does not
        strict = str(wo.solve(problem, **options))
    assert strict == str(wo.solve(problem, **options))

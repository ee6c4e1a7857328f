"""Two similar rollers against closed forms: Carter (rolling) and Cattaneo and Mindlin (static).

The closed forms themselves are verified in test_theories.py.  Material flows along +x, so the
stick zone of rolling starts at the leading edge x = -a.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon import theories

STEEL = wo.HalfPlane(radius=0.25, material=wo.material("steel"))


def pair(**fields: Any) -> wo.RollerProblem:
    given: dict[str, Any] = {"load": 89e3, "friction": 0.5, "tangential_load": 8.4e3}
    return wo.RollerProblem(upper=STEEL, lower=STEEL, **(given | fields))


def traction_error(result: wo.RollerResult, exact: theories.PartialSlip) -> float:
    """Return the relative L2 error of the nodal tractions, each by its share of the width."""
    x, q = result.x, exact.traction(result.x)
    share = np.gradient(x) * np.where((x == x[0]) | (x == x[-1]), 0.5, 1.0)
    return float(np.sqrt(np.sum(share * (result.traction - q) ** 2) / np.sum(share * q**2)))


# ---- Carter: rolling ---------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.05, 0.19, -0.19, 0.45, 0.9])
def test_carter_creepage_and_width(share: float) -> None:
    problem = pair(tangential_load=share * 0.5 * 89e3)
    result, exact = wo.solve(problem), theories.carter(problem)
    assert result.creepage == pytest.approx(exact.creepage, rel=1e-3)  # measured: 1.5e-4
    assert result.half_width == pytest.approx(exact.half_width, rel=1e-4)


@pytest.mark.parametrize("motion", ["rolling", "static"])
@pytest.mark.parametrize("load", [8.4e3, 20e3, 40e3])
def test_the_estimated_error_of_the_traction(motion: str, load: float) -> None:
    problem = pair(tangential_load=load, motion=motion)
    exact = theories.carter(problem) if motion == "rolling" else theories.cattaneo(problem)
    for nodes in (50, 100, 200, 400):
        result = wo.solve(problem, nodes=nodes)
        # zone boundaries move through the cells, so that the errors of two meshes differ at random
        assert traction_error(result, exact) < 1.5 * result.traction_error


def test_creepage_given_is_the_inverse_of_load_given() -> None:
    by_load = wo.solve(pair())
    by_creepage = wo.solve(pair(tangential_load=None, creepage=by_load.creepage))
    # the two may end on different meshes: equal to the discretisation error
    assert by_creepage.tangential_load == pytest.approx(8.4e3, rel=1e-4)
    assert by_creepage.half_width == pytest.approx(by_load.half_width, rel=1e-5)


def test_beyond_full_creepage_everything_slips() -> None:
    result = wo.solve(pair(tangential_load=None, creepage=-0.01))
    assert result.tangential_load == pytest.approx(-0.5 * 89e3, rel=1e-10)
    assert set(result.zone) == {wo.Zone.BACKWARD}


# ---- Cattaneo and Mindlin: static --------------------------------------------------------------


def test_cattaneo_sticks_in_the_middle() -> None:
    problem = pair(motion="static")
    result, exact = wo.solve(problem), theories.cattaneo(problem)
    stick = result.x[result.zone == wo.Zone.STICK]
    cell = 0.02 * exact.half_width  # of 101 nodes
    assert stick[-1] == pytest.approx(exact.stick_half_width, abs=cell)
    assert stick[0] == pytest.approx(-exact.stick_half_width, abs=cell)

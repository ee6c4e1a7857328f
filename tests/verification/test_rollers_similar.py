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


def order(nodes: list[int], errors: list[float]) -> float:
    return float(-np.polyfit(np.log(nodes), np.log(np.abs(errors)), 1)[0])


# ---- Carter: rolling ---------------------------------------------------------------------------


def test_carter_reference_values() -> None:
    """Steel, R = 0.25 m both, mu = 0.5, P = 89 kN/m, Q = 8.4 kN/m: published to 6 digits."""
    result = wo.solve(pair())  # the default number of nodes
    a = result.half_width
    assert a == pytest.approx(0.353759e-3, rel=1e-3)
    assert result.creepage == pytest.approx(1.4053224e-4, rel=1e-3)
    assert np.interp(0, result.x, result.pressure) == pytest.approx(160.1633e6, rel=1e-3)
    slips = result.x[np.nonzero(result.zone == wo.Zone.STICK)[0][-1]]
    # the border lies in the cell behind the last node in stick
    cell = np.max(np.diff(result.x[result.x >= slips][:3]))
    assert (a - slips) / (2 * a) == pytest.approx(0.0993136, abs=cell / (2 * a))
    assert result.residuals.largest <= 1e-8


@pytest.mark.parametrize("share", [0.05, 0.19, -0.19, 0.45, 0.9])
def test_carter_creepage_and_width(share: float) -> None:
    problem = pair(tangential_load=share * 0.5 * 89e3)
    result, exact = wo.solve(problem), theories.carter(problem)
    assert result.creepage == pytest.approx(exact.creepage, rel=1e-4)  # asked: 1e-3
    assert result.half_width == pytest.approx(exact.half_width, rel=1e-4)


@pytest.mark.parametrize("load", [8.4e3, -8.4e3, 20e3, 40e3])
def test_carter_traction_at_200_nodes(load: float) -> None:
    problem = pair(tangential_load=load)
    result = wo.solve(problem, nodes=200)
    assert traction_error(result, theories.carter(problem)) < 2e-4  # measured: 0.8e-4 to 1.84e-4


@pytest.mark.parametrize("motion", ["rolling", "static"])
@pytest.mark.parametrize("load", [8.4e3, 20e3, 40e3])
def test_the_traction_error_is_told(motion: str, load: float) -> None:
    problem = pair(tangential_load=load, motion=motion)
    exact = theories.carter(problem) if motion == "rolling" else theories.cattaneo(problem)
    for nodes in (50, 100, 200, 400):
        result = wo.solve(problem, nodes=nodes)
        ratio = result.traction_error / traction_error(result, exact)
        assert 0.7 < ratio < 3  # measured: 0.95 to 1.9


@pytest.mark.parametrize("rtol", [1e-3, 2e-4])
def test_rtol_is_kept(rtol: float) -> None:
    problem = pair()
    result = wo.solve(problem, rtol=rtol)
    assert result.traction_error <= rtol
    # the estimate is that of the two finest grids; see above how true it is
    assert traction_error(result, theories.carter(problem)) <= 1.5 * rtol
    with pytest.raises(wo.InvalidProblem, match="rtol"):
        wo.solve(problem, rtol=-rtol)


@pytest.mark.parametrize("load", [8.4e3, 40e3])
def test_carter_converges_at_its_order(load: float) -> None:
    problem, nodes = pair(tangential_load=load), [25, 50, 100, 200, 400]
    exact = theories.carter(problem)
    results = [wo.solve(problem, nodes=n) for n in nodes]
    # measured: 2.0; at the border the traction leaves the bound like a root
    assert order(nodes, [traction_error(r, exact) for r in results]) >= 1.5
    # measured: 2.9 and 3.0
    assert order(nodes, [r.creepage - exact.creepage for r in results]) >= 2
    assert order(nodes, [r.half_width - exact.half_width for r in results]) >= 2


def test_creepage_given_is_the_inverse_of_load_given() -> None:
    by_load = wo.solve(pair())
    by_creepage = wo.solve(pair(tangential_load=None, creepage=by_load.creepage))
    # the two fit their grids to zone borders found on the way: equal to discretisation error
    assert by_creepage.tangential_load == pytest.approx(8.4e3, rel=1e-4)
    assert by_creepage.half_width == pytest.approx(by_load.half_width, rel=1e-8)


def test_beyond_full_creepage_everything_slips() -> None:
    result = wo.solve(pair(tangential_load=None, creepage=-0.01))
    assert result.tangential_load == pytest.approx(-0.5 * 89e3, rel=1e-10)
    assert set(result.zone) == {wo.Zone.BACKWARD}


# ---- Cattaneo and Mindlin: static --------------------------------------------------------------


@pytest.mark.parametrize("load", [8.4e3, -8.4e3, 20e3, 40e3])
def test_cattaneo_traction_at_200_nodes(load: float) -> None:
    problem = pair(motion="static", tangential_load=load)
    result = wo.solve(problem, nodes=200)
    exact = theories.cattaneo(problem)
    assert traction_error(result, exact) < 1e-3  # measured: 1.6e-4 to 3.5e-4
    assert result.half_width == pytest.approx(exact.half_width, rel=1e-4)
    assert np.isnan(result.creepage)
    assert result.residuals.largest <= 1e-8


@pytest.mark.parametrize("load", [8.4e3, 40e3])
def test_cattaneo_converges_at_its_order(load: float) -> None:
    problem, nodes = pair(motion="static", tangential_load=load), [25, 50, 100, 200, 400]
    exact = theories.cattaneo(problem)
    errors = [traction_error(wo.solve(problem, nodes=n), exact) for n in nodes]
    assert order(nodes, errors) >= 1.5  # measured: 2.0


def test_cattaneo_sticks_in_the_middle() -> None:
    problem = pair(motion="static")
    result, exact = wo.solve(problem), theories.cattaneo(problem)
    stick = result.x[result.zone == wo.Zone.STICK]
    cell = 0.02 * exact.half_width  # of 101 nodes
    assert stick[-1] == pytest.approx(exact.stick_half_width, abs=cell)
    assert stick[0] == pytest.approx(-exact.stick_half_width, abs=cell)

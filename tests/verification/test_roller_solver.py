"""Two rollers on the semismooth Newton solver.

Closed forms: Carter (rolling), Cattaneo and Mindlin (static), verified in test_theories.py.
Numerical properties: number of iterations, order of convergence, warm starts.
Validation: the largest admissible load.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from random_nips import random_rollers
from roller_cases import STEEL, steel_pair

import woundon as wo
from woundon import theories

NEWSPRINT = wo.Orthotropic(radial=20e6, tangential=3e9, cross=5e6, shear=10e6)
ROLL = wo.Cylinder(radius=0.1, core_radius=0.05, material=NEWSPRINT)
COVER = wo.Cylinder(radius=0.2, core_radius=0.18, material="soft-cover")
ORDER_MESHES = [33, 65, 129, 257]


def soft(**fields: Any) -> wo.RollerProblem:
    given: dict[str, Any] = {"load": 2e3, "friction": 0.2, "tangential_load": 100.0}
    return wo.RollerProblem(**({"upper": ROLL, "lower": COVER} | given | fields))


def order(nodes: list[int], errors: list[float]) -> float:
    return float(-np.polyfit(np.log(nodes), np.log(np.abs(errors)), 1)[0])


def traction_error(result: wo.RollerResult, exact: theories.PartialSlip) -> float:
    """Return the relative L2 error of the nodal tractions, each by its share of the width."""
    x, q = result.x, exact.traction(result.x)
    share = np.gradient(x) * np.where((x == x[0]) | (x == x[-1]), 0.5, 1.0)
    return float(np.sqrt(np.sum(share * (result.traction - q) ** 2) / np.sum(share * q**2)))


# ---- closed forms ------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.05, 0.19, -0.19, 0.45, -0.6, 0.9])
def test_carter_with_the_default_criterion(share: float) -> None:
    """The closed form itself has the published values (test_theories.py)."""
    problem = steel_pair(tangential_load=share * 0.5 * 89e3)
    result, exact = wo.solve(problem), theories.carter(problem)
    assert result.half_width == pytest.approx(exact.half_width, rel=1e-4)
    assert result.creepage == pytest.approx(exact.creepage, rel=1e-3)  # measured: 1.5e-4
    assert result.peak_pressure == pytest.approx(exact.peak_pressure, rel=1e-3)
    slip = 1 - exact.stick_half_width / exact.half_width
    assert result.slip_share == pytest.approx(slip, abs=0.02)
    for name in ("creepage", "peak_pressure"):
        assert abs(getattr(result, name) - getattr(exact, name)) <= result.errors[name]


@pytest.mark.parametrize("load", [8.4e3, 20e3, 40e3])
def test_the_estimated_error_of_the_traction(load: float) -> None:
    problem = steel_pair(tangential_load=load)
    exact = theories.carter(problem)
    for nodes in (50, 100, 200, 400):
        result = wo.solve(problem, nodes=nodes)
        # zone boundaries move through the cells, so that the errors of two meshes differ at random
        assert traction_error(result, exact) < 1.5 * result.traction_error


def test_creepage_given_is_the_inverse_of_load_given() -> None:
    by_load = wo.solve(steel_pair())
    by_creepage = wo.solve(steel_pair(tangential_load=None, creepage=by_load.creepage))
    # the two may end on different meshes: equal to the discretisation error
    assert by_creepage.tangential_load == pytest.approx(8.4e3, rel=1e-4)
    assert by_creepage.half_width == pytest.approx(by_load.half_width, rel=1e-5)


def test_beyond_full_creepage_everything_slips() -> None:
    result = wo.solve(steel_pair(tangential_load=None, creepage=-0.01))
    assert result.tangential_load == pytest.approx(-0.5 * 89e3, rel=1e-10)
    assert set(result.zone) == {wo.Zone.BACKWARD}


@pytest.mark.parametrize("load", [8.4e3, -8.4e3, 40e3])
def test_order_of_convergence_against_steel_pair(load: float) -> None:
    problem = steel_pair(tangential_load=load)
    exact = theories.carter(problem)
    results = [wo.solve(problem, nodes=n) for n in ORDER_MESHES]
    half_width = order(ORDER_MESHES, [r.half_width - exact.half_width for r in results])
    peak = order(ORDER_MESHES, [r.peak_pressure - 160.1633e6 for r in results])
    creepage = [abs(r.creepage / exact.creepage - 1) for r in results]
    assert half_width >= 2.8  # measured: 3.0
    assert peak >= 1.8  # measured: 2.0
    # zone boundaries move through the cells, so that the convergence is not monotonic
    assert max(e * n**2 for e, n in zip(creepage, ORDER_MESHES, strict=True)) < 5.0


@pytest.mark.parametrize("load", [8.4e3, -20e3, 40e3])
def test_order_of_convergence_against_cattaneo(load: float) -> None:
    problem = steel_pair(motion="static", tangential_load=load)
    exact = theories.cattaneo(problem)
    results = [wo.solve(problem, nodes=n) for n in ORDER_MESHES]
    assert order(ORDER_MESHES, [r.half_width - exact.half_width for r in results]) >= 2.8
    errors = [traction_error(result, exact) for result in results]
    assert all(e <= 1.5 * r.traction_error for e, r in zip(errors, results, strict=True))
    stick = results[-1].x[results[-1].zone == wo.Zone.STICK]
    cell = np.diff(results[-1].x).max()
    assert stick[[0, -1]] == pytest.approx(
        [-exact.stick_half_width, exact.stick_half_width], abs=cell
    )
    # next to a zone boundary the traction has an infinite slope
    assert order(ORDER_MESHES, errors) >= 0.9
    for other, result in zip(results[1:-1], results, strict=False):
        assert abs(result.shift - results[-1].shift) > abs(other.shift - results[-1].shift)


@pytest.mark.parametrize(("load", "shift"), [(100.0, 3.50471e-5), (-300.0, -1.042259e-4)])
def test_the_rigid_displacement_of_a_static_contact(load: float, shift: float) -> None:
    """Values of version 0.2, which integrates the influence functions of u, with 401 nodes."""
    result = wo.solve(soft(motion="static", tangential_load=load), nodes=129)
    assert result.shift == pytest.approx(shift, rel=1e-4)
    sticks = result.zone == wo.Zone.STICK
    assert np.abs(result.slip[sticks]).max() < 1e-8 * np.abs(result.slip).max()


# ---- the solver --------------------------------------------------------------------------------


def test_the_number_of_iterations() -> None:
    """An error in the Jacobian leaves results correct and shows in the iterations alone."""
    iterations = np.array([
        [mesh.solver.counts.iterations for mesh in wo.solve(problem, nodes=73).refinement.meshes]
        for problem in map(random_rollers, range(20))
    ])  # fmt: skip
    assert np.median(iterations, axis=0).max() <= 8  # measured: 7, 3, 3, 5
    assert iterations.max() <= 20  # measured: 13


@pytest.mark.parametrize("motion", ["rolling", "static"])
def test_a_warm_start_does_not_change_the_result(motion: str) -> None:
    neighbour = wo.solve(soft(motion=motion, tangential_load=-250.0, load=3e3))
    problem = soft(motion=motion)
    for options in ({"nodes": 65}, {}):
        cold = wo.solve(problem, **options)
        warm = wo.solve(problem, start=neighbour, **options)
        assert warm.nodes == cold.nodes
        peak = cold.peak_pressure
        np.testing.assert_allclose(warm.pressure, cold.pressure, rtol=0, atol=1e-7 * peak)
        np.testing.assert_allclose(warm.traction, cold.traction, rtol=0, atol=1e-7 * peak)
        assert np.array_equal(warm.zone, cold.zone)
        assert warm.half_width == pytest.approx(cold.half_width, rel=1e-7)
        assert warm.errors["half_width"] == pytest.approx(cold.errors["half_width"], rel=0.1)
    alone = wo.solve(problem, start=wo.solve(neighbour.problem, nodes=65), nodes=65, errors=False)
    assert alone.half_width == pytest.approx(wo.solve(problem, nodes=65).half_width, rel=1e-7)
    assert np.isnan(alone.errors["half_width"])


def test_any_result_may_be_the_start() -> None:
    """A start of another kind of contact supplies what the two have in common."""
    problem = soft()
    cold = wo.solve(problem, nodes=41)
    others = [
        soft(motion="static"), soft(friction=0.0, tangential_load=None), steel_pair(),
        soft(tangential_load=None, creepage=-1e-3),
    ]  # fmt: skip
    for other in others:
        for one, two in ((problem, other), (other, problem)):
            warm = wo.solve(two, nodes=41, start=wo.solve(one, nodes=41))
            assert warm.half_width == pytest.approx(
                (cold if two is problem else wo.solve(two, nodes=41)).half_width, rel=1e-8
            )
    assert wo.solve(problem, nodes=41, start=cold.replace(refinement=None)) == cold


def test_rtol_is_kept_or_the_best_result_is_carried() -> None:
    result = wo.solve(steel_pair(), rtol=1e-4)
    exact = theories.carter(steel_pair())
    for name in ("half_width", "creepage"):
        assert result.errors[name] <= 1e-4 * abs(getattr(result, name))
        assert abs(getattr(result, name) / getattr(exact, name) - 1) < 1e-4
    with pytest.raises(wo.NotConverged, match="rtol") as error:
        wo.solve(random_rollers(116), rtol=1e-5)
    assert error.value.best.residuals.largest <= 1e-8


# ---- the largest load --------------------------------------------------------------------------


@pytest.mark.parametrize("body", [
    wo.HalfPlane(radius=0.1, material=wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.3)),
    wo.Cylinder(
        radius=0.1, core_radius=0.099,
        material=wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.3),
    ),
])  # fmt: skip
def test_a_load_that_no_contact_carries_is_rejected_with_the_largest_one(body: wo.Body) -> None:
    problem = wo.RollerProblem(
        upper=wo.Rigid(radius=0.1), lower=body, load=1.0, friction=0.2, tangential_load=0.0
    )
    with pytest.raises(wo.InvalidProblem, match=r"^load: 1e\+09 is out of range; must be <= ") as e:
        wo.solve(problem.replace(load=1e9))
    largest = float(str(e.value).split("<= ")[1].split(" ")[0])
    assert wo.solve(problem.replace(load=0.9 * largest)).residuals.largest <= 1e-8
    with pytest.raises(wo.InvalidProblem, match=r"^load: "):
        wo.solve(problem.replace(load=1.1 * largest))


def test_a_tube_that_bends_is_rejected() -> None:
    steel = wo.Isotropic(youngs_modulus=2e11, poissons_ratio=0.3)
    tube = wo.Layered(radius=0.2, layers=[{"thickness": 1e-3, "material": steel}], core="free")
    problem = wo.RollerProblem(upper=STEEL, lower=tube, load=1e6, friction=0.2)
    with pytest.raises(wo.InvalidProblem, match=r"^load: .* is a tube"):
        wo.solve(problem)

"""What need not be made or solved again is not: equal rollers, kept matrices, widths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from thesis_cases import paper_nip
from viscoelastic_cases import cover, rubber

import woundon as wo
from woundon.contact import one_mesh
from woundon.contact.normal import solve_normal
from woundon.contact.pivoting import solve_stick_slip
from woundon.contact.schemes import Graded
from woundon.contact.stick_slip import StickSlip
from woundon.elasticity.fourier import HarmonicSums
from woundon.wrap.solve import WrapContact


@pytest.fixture
def apart() -> StickSlip:
    """Seven nodes whose tractions leave the pressure alone, with a resultant."""
    random = np.random.default_rng(3)
    n = 7
    return StickSlip(
        random.normal(size=(n, n)) + 5 * np.eye(n), np.zeros((n, n)), random.normal(size=n),
        random.uniform(1, 2, size=n), np.zeros((n, n)), np.full(n, 0.3), faces=1,
        creep=np.ones(n), resultant=random.uniform(1, 2, size=n), force=0.2,
    )  # fmt: skip


@pytest.mark.parametrize("state", [[0] * 7, [1, 1, 0, 0, -1, 0, 1], [1, -1, 1, 0, 1, 1, -1]])
def test_known_slipping_tractions_leave_the_same_system(apart: StickSlip, state: Any) -> None:
    state = np.array(state, dtype=np.int8)
    assert apart.apart
    matrix, right = apart.system(state)
    whole = np.linalg.solve(matrix, right)
    found = apart.solve(state)
    np.testing.assert_allclose(found.traction, whole[:7], rtol=1e-12)
    assert found.creep == pytest.approx(apart.scale * whole[7], rel=1e-12)


def test_equal_bodies_tractions_leave_the_pressure_alone() -> None:
    random = np.random.default_rng(4)
    slope_p, gap = random.normal(size=(5, 4)), random.normal(size=5)
    solved = solve_normal(slope_p, gap, np.zeros((5, 3)))
    assert solved.shape == (5, 4)
    assert not solved[:, 1:].any()
    np.testing.assert_allclose(slope_p @ solved[:-1, 0] + solved[-1, 0], gap, rtol=1e-12)


def test_kernels_are_integrated_by_their_own_parts_alone() -> None:
    steel = wo.HalfPlane(radius=0.25, material=wo.material("steel"))
    grid = Graded().mesh(43).grid
    kernels = steel.kernels()
    grid.integrate_together(kernels.gradients, kernels.smooth, 1e-3)
    assert {"inverse", "value"} <= vars(grid).keys()
    assert not {"log", "sign"} & vars(grid).keys()


def test_linear_bodies_are_assembled_once_for_a_half_width() -> None:
    problem = paper_nip(web_tension=300.0).wrapped()
    contact, mesh = WrapContact(problem, 12, 17), Graded().mesh(17)
    about = contact.about(mesh, 2e-3, None)
    one = contact.equations(mesh, 2e-3, about)
    solution = solve_stick_slip(one.stick_slip())
    two = contact.equations(mesh, 2e-3, one.state(solution).known, one)
    assert two.roll is one.roll
    fresh = contact.equations(mesh, 2e-3, two.about)
    for kept, made in zip(two.normal, fresh.normal, strict=True):
        np.testing.assert_array_equal(kept, made)
    assert contact.equations(mesh, 2.1e-3, two.about, two).roll is not one.roll


def test_one_width_is_enough_near_a_neighbour(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the neighbour's zones the width is followed to the load, on the last mesh alone."""
    problem = paper_nip(web_tension=300.0).wrapped()
    before, tried, at = wo.solve(problem, nodes=65), [], one_mesh._Step.at

    def noted(step: one_mesh._Step, a: float) -> object:
        tried.append(step.mesh.nodes.size)
        return at(step, a)

    monkeypatch.setattr(one_mesh._Step, "at", noted)
    wo.solve(problem.replace(nip_load=1.02 * problem.nip_load), nodes=65, start=before)
    assert tried == [65]


def test_slipping_everywhere_nothing_holds_the_creep(apart: StickSlip) -> None:
    assert not apart.solve(np.ones(7, dtype=np.int8)).finite


@pytest.mark.parametrize("speed", [1.3, None], ids=["rolling", "relaxed"])
def test_one_kernel_of_a_cover_has_its_values_from_the_table_of_all(
    speed: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    once = HarmonicSums._rest_on_circle

    def counted(sums: HarmonicSums, size: int) -> Any:
        made.append(size)
        return once(sums, size)

    monkeypatch.setattr(HarmonicSums, "_rest_on_circle", counted)
    body = cover(rubber([(4e6, 0.017)])).replace(core_radius=0.2351)  # met nowhere else
    kernels, t = body.kernels(speed), np.linspace(-0.01, 0.01, 7)
    assert kernels.smooth is not None
    together = kernels.smooth(t)
    for kernel, values in zip(kernels.gradients, together, strict=True):
        assert kernel.smooth is not None
        np.testing.assert_array_equal(kernel.smooth(t), values)
    assert len(made) == 1


def test_lags_of_which_none_is_a_sum_of_others_are_their_own_parts() -> None:
    gradients = cover(rubber([(4e6, 0.017), (2e6, 0.3), (1e6, 3.0)])).kernels(1.3).lag
    assert gradients is not None
    np.testing.assert_array_equal(gradients.shares, np.eye(4))

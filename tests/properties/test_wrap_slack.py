"""Wrapped nips whose web becomes slack, or nearly so."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from random_nips import random_low_friction, random_wrapped_nip
from slow_cases import slow_case

import woundon as wo
from woundon.nip import solve as nip_solve


def test_a_web_that_never_settles_at_a_wrong_width_is_reported_to_be_slack():
    """Within a percent of the load its tensions went on to and fro, all of them far below zero."""
    with pytest.raises(wo.NoSteadyState, match="leaves the web slack downstream of the nip"):
        wo.solve(random_wrapped_nip(306))


@pytest.mark.parametrize("seed", [1017081, slow_case(1019501)])
def test_a_slack_web_whose_load_jumps_with_the_width_is_reported_to_be_slack(seed: int) -> None:
    """From one width to the next by a tenth, about the load asked: two of 20 000 random nips."""
    with pytest.raises(wo.NoSteadyState, match="leaves the web slack downstream of the nip"):
        wo.solve(random_wrapped_nip(seed))


def test_a_web_that_is_slack_at_a_wrong_load_only_is_not_rejected():
    """A percent beyond the load asked it is; 0.25 % more web tension would do there too."""
    hardly = random_wrapped_nip(139).replace(web_tension=2385.0)
    result = wo.solve(hardly)
    assert result.tension.min() > 0
    assert result.residuals.largest < 1e-8


def test_a_web_that_the_winding_force_leaves_slack_at_any_width_is_rejected_without_a_mesh():
    """T_in + F + mu+ (P + |F|) < 0: no iteration converges on this very soft drum."""
    problem = random_low_friction(1100847)
    taut = -problem.winding_force - problem.roll_friction * problem.nip_load
    with pytest.raises(wo.NoSteadyState, match="downstream of the nip") as fault:
        wo.solve(problem)
    needed = float(str(fault.value).split("; about ")[1].split()[0])
    assert needed == pytest.approx(taut, rel=0.01)  # mu+ |F| is 0.8 % of it


# ---- the web of a fast machine carries its centrifugal force ------------------------------------

RUNNING = wo.NipProblem.example().replace(density=700.0, web_speed=30.0)
FORCE = RUNNING.centrifugal_tension  # about 42 N/m


@pytest.fixture
def on_meshes(monkeypatch):
    """Return meshes (nodes, least tension on the roll wrap); the largest tension is 1 kN/m."""
    monkeypatch.setattr(
        nip_solve, "_tensions_on_wraps", lambda _, mesh: [("downstream", mesh.least, 1e3)]
    )
    return lambda *meshes: [SimpleNamespace(size=size, least=least) for size, least in meshes]


@pytest.mark.parametrize(("least", "is_slack"), [(FORCE - 1, True), (FORCE + 1, False)])
def test_a_web_below_its_centrifugal_force_is_slack(on_meshes, least: float, is_slack: bool):
    """Also where the mesh is refined in vain: the errors, 0.01 N/m, are smaller than 1 N/m."""
    meshes = on_meshes((17, least + 0.04), (33, least + 0.01), (65, least))
    if not is_slack:
        nip_solve._check_slack_beyond_errors(RUNNING, meshes)
        nip_solve._check_taut(RUNNING, meshes[-1])
        return
    for check in (
        lambda: nip_solve._check_slack_beyond_errors(RUNNING, meshes),
        lambda: nip_solve._check_taut(RUNNING, meshes[-1]),
    ):
        with pytest.raises(wo.NoSteadyState, match=r"downstream .* below its centrifugal force"):
            check()


@pytest.mark.parametrize(
    "further",
    [
        # a second attempt begins with coarse meshes, on which the web is slack by their errors
        [(17, FORCE - 99), (33, FORCE - 30)],
        [(65, FORCE - 9)],
    ],
)
def test_meshes_of_a_second_attempt_that_are_no_finer_are_not_judged(on_meshes, further):
    first = [(17, FORCE + 1.04), (33, FORCE + 1.01), (65, FORCE + 1)]
    nip_solve._check_slack_beyond_errors(RUNNING, on_meshes(*first, *further))
    with pytest.raises(wo.NoSteadyState):
        nip_solve._check_slack_beyond_errors(
            RUNNING, on_meshes(*first, *further, (129, FORCE - 1), (257, FORCE - 1))
        )


def test_few_meshes_or_large_errors_do_not_prove_a_slack_web(on_meshes):
    for meshes in ([], [(17, -50.0)], [(17, -50.0), (33, -50.0)],
                   [(17, FORCE + 60), (33, FORCE + 30), (65, FORCE - 1)]):  # fmt: skip
        nip_solve._check_slack_beyond_errors(RUNNING, on_meshes(*meshes))


def test_a_winding_force_that_leaves_less_than_the_centrifugal_force_is_rejected_without_a_mesh():
    """T_in + F + mu+ (P + |F|) = 45 N/m or 40 N/m."""
    for web_tension, is_slack in ((FORCE + 2, False), (FORCE - 2, True)):
        problem = RUNNING.replace(
            web_tension=web_tension, winding_force=-10.0, nip_load=90.0, roll_friction=0.1,
            drum_wrap=0.0,
        )  # fmt: skip
        if not is_slack:
            nip_solve._check_force(problem)
            continue
        with pytest.raises(wo.NoSteadyState, match="below its centrifugal force"):
            nip_solve._check_force(problem)

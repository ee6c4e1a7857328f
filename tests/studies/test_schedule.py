"""Schedules optimised under margins, against brute force; what cannot be kept is reported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import woundon as wo

TAPER, START = "wound_on_tension.taper", "wound_on_tension.start"
OVER = {TAPER: (0.0, 0.6), START: ("200 N/m", "500 N/m")}
LIMITS = wo.Limits(
    layer_friction=0.19, torque_share=0.2, compression=150e3, core_pressure=500e3,
    blocking_pressure=350e3, slack_tension=100.0,
)  # fmt: skip
COARSE = {"rtol": 3e-3}


@pytest.fixture(scope="module")
def problem() -> wo.RollProblem:
    return wo.RollProblem.example().replace(
        wound_on_tension=wo.Taper(start=350.0, taper=0.0, law="hyperbolic"),
        **{"stack.radial": 8e6},  # does not harden: quickly solved
    )


@pytest.fixture(scope="module")
def best(problem: wo.RollProblem) -> wo.OptimisedSchedule:
    return wo.optimise_schedule(
        problem, OVER, limits=LIMITS, maximise="mid_pressure", options=COARSE
    )


@pytest.fixture(scope="module")
def grid(problem: wo.RollProblem) -> list[tuple[float, float]]:
    """Return the smallest reserve and the pressure half-way, brute force."""
    found = []
    for taper in np.linspace(0, 0.6, 7):
        for start in np.linspace(200, 500, 4):
            roll = wo.solve(problem.replace(**{TAPER: taper, START: start}), **COARSE)
            least = wo.margins(roll, LIMITS).least
            assert least is not None
            found.append((least.reserve, roll.mid_pressure))
    return found


@pytest.mark.slow
def test_the_best_schedule_is_no_worse_than_brute_force(
    best: wo.OptimisedSchedule, grid: list[tuple[float, float]]
) -> None:
    feasible = [pressure for reserve, pressure in grid if reserve >= 0]
    assert 0 < len(feasible) < len(grid)  # the limits cut through the grid
    assert best.after.mid_pressure > max(feasible)
    # and no better than it can be: between the grid's steps of 100 N/m, P is proportional to T
    assert best.after.mid_pressure < (1 + 100 / 300) * max(feasible)


def test_an_active_constraint_is_met_and_named(best: wo.OptimisedSchedule) -> None:
    assert best.feasible
    assert best.margins_before.violated != ()
    assert best.margins_after.violated == ()
    assert set(best.binding) == {"compression", "blocking"}  # as many as there are fields
    for name in best.binding:
        assert 0 <= best.margins_after[name].reserve < 0.01
    assert "compression" in str(best)
    assert "binds" in str(best)
    assert f"{START} {best.values[1]:.4g} N/m" in repr(best)
    # what is reported is what it is: wound again
    again = wo.solve(best.problem, **COARSE)
    assert again.mid_pressure == best.after.mid_pressure
    assert tuple(best.values) == (
        again.problem.wound_on_tension.taper,
        again.problem.wound_on_tension.start,
    )


@pytest.mark.slow
def test_without_a_goal_the_smallest_reserve_is_the_largest(
    problem: wo.RollProblem, grid: list[tuple[float, float]]
) -> None:
    found = wo.optimise_schedule(problem, OVER, limits=LIMITS, options=COARSE)
    least = found.margins_after.least
    assert least is not None
    assert found.ended == "converged"
    coarse = max(reserve for reserve, _ in grid)
    assert coarse < least.reserve < coarse + 0.4  # slack: a step of 100 N/m, tapered, of 100
    assert least.reserve == pytest.approx(np.nanmax(found.reserves))
    assert set(found.binding) == {"blocking", "slack"}  # too much tension, and too little


def test_limits_that_nothing_keeps_are_reported_with_what_binds(problem: wo.RollProblem) -> None:
    hard = LIMITS.replace(compression=1e3, torque_share=0.01)
    found = wo.optimise_schedule(problem, OVER, limits=hard, evaluations=25, options=COARSE)
    assert not found.feasible
    assert found.binding
    assert set(found.binding) <= set(found.margins_after.violated)
    assert str(found).startswith("NO schedule keeps all limits")
    assert "VIOLATED" in str(found)


def test_it_stops_after_so_many_windings_and_tells_each(problem: wo.RollProblem) -> None:
    computed: list[tuple[int, int]] = []
    found = wo.optimise_schedule(
        problem, OVER, limits=LIMITS, evaluations=6, options=COARSE,
        progress=lambda done, size: computed.append((done, size)),
    )  # fmt: skip
    assert found.ended == "stopped after 6 windings"
    assert len(found.tried) == 6
    assert computed[-1] == (6, 6)


def test_an_interruption_gives_the_best_so_far(problem: wo.RollProblem) -> None:
    def interrupt(done: int, size: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    found = wo.optimise_schedule(problem, OVER, limits=LIMITS, options=COARSE, progress=interrupt)
    assert found.ended == "interrupted"
    assert len(found.tried) == 4


def test_schedules_that_cannot_be_wound_are_put_aside(problem: wo.RollProblem) -> None:
    """A core as large as the roll has no layers: the search goes on without such schedules."""
    found = wo.optimise_schedule(
        problem.replace(**{"core.radius": 0.12}),
        {"core.radius": (0.05, 0.14), "radius": (0.125, 0.2)},
        limits=wo.Limits(compression=300e3), minimise="mid_pressure", options=COARSE,
    )  # fmt: skip
    assert np.isnan(found.reserves).any()
    assert found.feasible
    assert found.values[0] < found.values[1]


def test_a_range_beyond_that_of_the_field_is_rejected(problem: wo.RollProblem) -> None:
    with pytest.raises(wo.InvalidProblem, match=r"start: -400 is out of range; must be > 0"):
        wo.optimise_schedule(problem, {START: (-400.0, 450.0)}, limits=LIMITS)


def test_a_schedule_is_drawn_before_and_after(best: wo.OptimisedSchedule, tmp_path: Path) -> None:
    figure = best.plot(tmp_path / "schedule.png")
    assert (tmp_path / "schedule.png").stat().st_size > 10_000
    bars = figure.axes[-1]
    assert [label.get_text() for label in bars.get_yticklabels()] == [
        margin.title for margin in best.margins_after if margin.checked
    ]

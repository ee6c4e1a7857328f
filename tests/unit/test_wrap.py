"""The wrapped nip as its user meets it: refusals, fields of the problem, what its nodes are.

Files, figures, reports and commands of it are tested with those of every kind.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from thesis_cases import paper_nip

import woundon as wo

PAPER = paper_nip(web_tension=300.0)
QUICK = {"nodes": 25}


@pytest.fixture(scope="module")
def result() -> wo.WrappedNipResult:
    return wo.solve(PAPER.wrapped(drum_wrap=pi / 2), **QUICK)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"roll_wrap": -0.1}, "roll_wrap: -0.1 is out of range; must be >= 0 and <= 3.14159 [rad]"),
        ({"roll_wrap": 180.0}, "(plain numbers are SI: 180 deg is 3.14159)"),
        ({"roll_wrap": 3.2}, "must be >= 0 and <= 3.14159 [rad]"),
        (
            {"roll_wrap": "pi"},
            "roll_wrap: 'pi' is not a number with a unit; expected a value in rad",
        ),
        ({"roll_wrap": float("nan")}, "roll_wrap: nan is not a finite number; must be >= 0"),
        ({"drum_wrap": 3.5}, "drum_wrap: 3.5 is out of range"),
        ({"drum_wrap": True}, "drum_wrap: True is not a number; must be >= 0"),
        ({"wrap_friction": 0.0}, "wrap_friction: 0 is out of range"),
        ({"winding_force": "all"}, "winding_force: 'all' is not a number with a unit"),
    ],
)
def test_bad_wraps_are_named(options, said):
    with pytest.raises(wo.InvalidProblem) as fault:
        PAPER.wrapped(**options)
    assert said in str(fault.value)


def test_wraps_are_fields_of_the_problem():
    options = {"roll_wrap": 2.0, "drum_wrap": 0.5, "wrap_friction": 0.3, "winding_force": 50.0}
    wrapped = PAPER.wrapped(**options)
    assert {name: getattr(wrapped, name) for name in options} == options
    assert wrapped.confined() == PAPER.replace(winding_force=50.0)
    # a force that the nip alone cannot carry is the wrap's, and cannot be confined
    carried = wrapped.replace(winding_force=790.0)
    with pytest.raises(wo.NoSteadyState, match="winding_force: 790 is out of range"):
        carried.confined()


def test_a_slack_web_is_refused():
    slack = PAPER.replace(web_tension=0.0)
    with pytest.raises(wo.InvalidProblem, match=r"web_tension: 0 is .*must be taut"):
        wo.solve(slack.wrapped(drum_wrap=1.0))
    pulled = PAPER.replace(winding_force=-700.0).wrapped()  # NIT is about -320 N/m there
    with pytest.raises(wo.NoSteadyState, match="slack downstream of the nip") as fault:
        wo.solve(pulled)
    needed = float(str(fault.value).split("; about ")[1].split()[0])
    wo.solve(pulled.replace(web_tension=needed + 40), **QUICK)


def test_forces_that_slide_the_drum_are_refused():
    with pytest.raises(wo.NoSteadyState, match="winding_force: 770 is out of range"):
        wo.solve(PAPER.wrapped(winding_force=770.0))
    assert wo.solve(PAPER.wrapped(winding_force=770.0, drum_wrap=1.0), **QUICK)


def test_the_nip_of_a_wrapped_result_is_its_nodes_in_nip(result):
    nip, x = result.in_nip, result.x
    assert (x[nip][0], x[nip][-1]) == (-result.half_width, result.half_width)
    assert result.nodes == x[nip].size == 25
    T, T_in = result.web_tension[nip], result.problem.web_tension
    assert result.tension_behind_nip == T[-1]
    assert result.nip_induced_tension == result.tension_behind_nip - result.tension_before_nip
    # on the drum's arc the web has gained the drum's traction there, F less the nip's part
    force = np.trapezoid(result.drum_traction[nip], x[nip])
    assert force == pytest.approx(100 - (T[0] - T_in), rel=1e-9)
    assert result.drum_wrap_traction == pytest.approx(T[0] - T_in, rel=1e-3)
    assert result.wound_on_tension == pytest.approx(
        result.tension_behind_nip + result.roll_wrap_traction
    )
    assert np.isnan(result.roll_slip[: nip.start]).all()
    assert np.isnan(result.drum_slip[nip.stop :]).all()
    assert np.isnan(result.roll_strain[: nip.start]).all()
    assert np.isfinite(result.roll_strain[nip.start :]).all()


def test_the_confined_nip_is_the_plain_problem(result):
    nip = result.confined(nodes=25)
    assert type(nip) is wo.NipResult
    assert nip == wo.solve(PAPER, nodes=25)
    # plain answer and estimate bracket the wrapped one (theory page: wrap)
    unwrapped = wo.solve(PAPER.wrapped(), **QUICK)
    ends = sorted([nip.tension_behind_nip, nip.wound_on_tension_estimate()])
    assert ends[0] < unwrapped.wound_on_tension < ends[1]


@pytest.mark.parametrize(
    ("name", "instead"),
    [("nip", "in_nip"), ("rig_tension", "wound_on_tension"),
     ("wound_on_tension_estimate", "solved, not estimated")],
)  # fmt: skip
def test_names_looked_for_in_vain_are_told(result, name, instead):
    assert not hasattr(result, name)
    assert instead in result.REPLACED[name]

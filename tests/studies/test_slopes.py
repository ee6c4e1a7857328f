"""Derivatives of all kinds: by sensitivities of the result, and by differences."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import numpy as np
import pytest
from registered_kinds import registered
from thesis_cases import film_nip, paper_nip

import woundon as wo
from woundon.studies.model import model_of
from woundon.studies.observations import Observable
from woundon.studies.slopes import slopes

RUBBER = wo.Isotropic(
    youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3), (2e6, 1e-2)]
)  # fmt: skip
COVER = wo.Cylinder(radius=0.25, core_radius=0.235, material=RUBBER)


@pytest.fixture(scope="module")
def rollers() -> wo.RollerResult:
    pair = wo.RollerProblem(
        upper=wo.Rigid(radius=0.2), lower=COVER, load=2e3, friction=0.3, tangential_load=300.0,
        speed=5.0,
    )  # fmt: skip
    return wo.solve(pair, nodes=65)


def test_rollers_over_speed_and_relaxation_time(rollers: wo.RollerResult) -> None:
    names = "speed", "lower.material.prony.1.time"
    slopes = wo.derivatives(rollers, *names)
    # speeds and times count by their products only: V d/dV = sum tau_k d/dtau_k
    both = wo.derivatives(rollers, "lower.material.prony.0.time")
    for output in ("half_width", "rolling_resistance", "creepage"):
        by_speed = rollers.problem.speed * slopes.derivative(output, "speed")
        by_times = 1e-2 * slopes.derivative(output, names[1])
        by_times += 1e-3 * both.derivative(output, "lower.material.prony.0.time")
        assert by_speed == pytest.approx(by_times, rel=1e-4, abs=1e-9), output
        assert by_speed != 0
    assert slopes.derivative("half_width", "speed") < 0  # stiffer


def test_a_nip_with_air() -> None:
    """Exact derivatives against central differences of solves on the same mesh."""
    result = wo.solve(film_nip(), nodes=33)
    names = "web_speed", "air.roughness", "nip_load"
    exact, near = wo.derivatives(result, *names), wo.derivatives(result, *names, nodes=33)
    for output in ("wound_on_tension", "outlet_tension", "half_width", "drum_creepage"):
        for name in names:
            slope = near.derivative(output, name)
            assert exact.derivative(output, name) == pytest.approx(slope, rel=1e-3, abs=1e-8)


def test_the_film_over_speed_and_load() -> None:
    outputs = "air.film", "air.friction_share"
    over = {"web_speed": [1.0, 1.1], "nip_load": [300.0, 330.0]}
    data = wo.sweep(film_nip(), over, outputs, nodes=33, workers=1)
    film, share = data["air.film"], data["air.friction_share"]
    assert float(film[0, 1]) < float(film[0, 0]) < float(film[1, 0])
    assert float(share[1, 0]) < float(share[0, 0])
    # the film varies as V^0.6, and more because compressed air expands downstream of the nip
    power = np.log(float(film[1, 0] / film[0, 0])) / np.log(1.1)
    assert 0.55 < power < 0.75


def test_exact_ones_are_the_results_own() -> None:
    nip = wo.NipProblem.example().replace(roll_wrap=0.0).replace(drum=COVER, web_speed=5.0)
    result = wo.solve(nip, nodes=33)
    exact = result.sensitivity("web_speed")
    assert (wo.derivatives(result, "web_speed").derivatives == exact.derivatives).all()
    near = wo.derivatives(result, "web_speed", nodes=33)
    for output in ("half_width", "drum_creepage"):  # differences
        assert near.derivative(output, "web_speed") == pytest.approx(
            exact.derivative(output, "web_speed"), rel=1e-3
        )
    # zone boundaries keep their nodes: on 33 the slope of the tension is 10 % off that on 513
    fine = -0.5282
    slopes = [d.derivative("nip_induced_tension", "web_speed") for d in (exact, near)]
    assert slopes == [pytest.approx(fine, rel=0.12)] * 2


# ---- differences --------------------------------------------------------------------------------


@pytest.fixture
def curves() -> Iterator[ModuleType]:
    """The kind of closed-form curves, registered for the time of a test."""
    with registered("curve_problem") as module:
        yield module


def test_differences_of_a_nip_with_tied_fields_are_the_exact_derivatives() -> None:
    tie = {"web.material": "roll.material"}
    names, outputs = ["roll.material.shear", "roll_friction"], ["outlet_tension", "half_width"]
    model = model_of(paper_nip(), outputs, tie, {"nodes": 33})
    result = model.run({}, None).state
    observables = [Observable(output) for output in outputs]
    exact = slopes(model, result, observables, names)
    near = slopes(model, result, observables, names, exact=False)
    # kinks where a node changes its zone within the step
    assert near == pytest.approx(exact, rel=0.02)


def test_tied_fields_are_summed_and_one_output_without_derivative_leaves_differences() -> None:
    """Closed form: the row of two springs ends at 2 F/k."""
    parts, k = [{"stiffness": 160.0}, {"stiffness": 160.0}], "springs.0.stiffness"
    with registered("spring_problem") as springs:
        row = springs.SpringsProblem(springs=parts, force=3.0)
        for outputs, tolerance in ((["end"], 1e-12), (["end", "extension"], 1e-5)):
            model = model_of(row, outputs, {"springs.1.stiffness": k}, {})
            found = slopes(model, model.run({}, None).state, [Observable(o) for o in outputs], [k])
            # a central difference is off by the square of its step, 3e-3
            assert found == pytest.approx(np.full(found.shape, -6.0 / 160.0**2), rel=tolerance)


def test_a_difference_is_one_sided_at_a_limit(curves: ModuleType) -> None:
    """At the end of the permitted range of a line, and next to a limit of existence."""
    end = wo.solve(curves.CurveProblem(position=10.0))
    assert wo.derivatives(end, "position").derivatives == pytest.approx(1.0, rel=1e-12)
    x = curves.LIMIT - 1e-6  # sqrt(LIMIT - x): one step of 0.3 % downwards
    near = wo.solve(curves.CurveProblem(position=x, shape="limit"))
    step = 3e-3 * x
    expected = (np.sqrt(1e-6) - np.sqrt(1e-6 + step)) / step
    assert wo.derivatives(near, "position").derivatives == pytest.approx(expected, rel=1e-6)


def test_a_derivative_without_a_solution_on_both_sides_is_an_error_or_nan(
    curves: ModuleType,
) -> None:
    problem = curves.CurveProblem(position=2.0)
    model = model_of(problem.replace(shape="nowhere"), "height", None, {})
    height, names = [Observable("height")], ["position"]
    base = wo.solve(problem)
    with pytest.raises(wo.NoSteadyState, match="there is no steady state"):
        slopes(model, base, height, names)
    assert np.isnan(slopes(model, base, height, names, nan_if_unsolved=True)).all()


def test_all_numbers_are_the_default() -> None:
    """Of every kind, as those of nips; fields of 0 have no scale for a difference."""
    roll = wo.solve(wo.RollProblem.example())
    every = wo.derivatives(roll)
    assert {"radius", "core.stiffness", "stack.radial.K2"} < set(every.parameters)
    assert "core_shrinkage" not in every.parameters  # is 0
    named = wo.derivatives(roll, *every.parameters[:2])
    assert (every.derivatives[:, :2] == named.derivatives).all()


def test_fields_that_have_no_derivative_are_rejected() -> None:
    roll = wo.solve(wo.RollProblem.example())
    for result in (roll, wo.solve(wo.NipProblem.example(), nodes=13)):
        with pytest.raises(wo.InvalidProblem, match=r"parameters: \['core'\] is out of place"):
            wo.derivatives(result, ["core"])
    with pytest.raises(
        wo.InvalidProblem, match=r"stack: .* is not a number, so it cannot be varied"
    ):
        wo.derivatives(roll, "stack")
    with pytest.raises(wo.InvalidProblem, match="core_shrinkage: is 0, which has no scale"):
        wo.derivatives(roll, "core_shrinkage")

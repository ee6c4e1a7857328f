"""Derivatives of all kinds: by sensitivities of the result, and by differences."""

from __future__ import annotations

import numpy as np
import pytest
from thesis_cases import film_nip

import woundon as wo

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
        # differences over 1e-3, each off by a third of its square times the third derivative
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

"""Sensitivities of a nip with entrained air, against differences of solutions (independent method).

Each solution iterates friction and film to 1e-10; the sensitivity differentiates the last mesh.
"""

from __future__ import annotations

import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.quantities import value_of

FILM = wo.Isotropic(youngs_modulus=5e9, poissons_ratio=0.3)
ROLL = wo.Isotropic(youngs_modulus=100e6, poissons_ratio=0.3)
RUBBER = wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48)
NIP = wo.NipProblem(
    web=wo.Web(thickness=23e-6, material=FILM),
    roll=wo.HalfPlane(radius=0.2, material=ROLL),
    drum=wo.HalfPlane(radius=0.1, material=RUBBER),
    roll_friction=0.25,
    drum_friction=0.4,
    nip_load=300.0,
    web_tension=100.0,
    roll_wrap=3.0,
    web_speed=1.0,
    air=wo.Air(roughness=0.3e-6),
)
STEP = 2e-4  # relative; the error of the central difference is its square


@pytest.fixture(scope="module")
def result() -> wo.NipResult:
    return wo.solve(NIP, nodes=65)


@pytest.mark.parametrize(
    "name",
    ["web_speed", "air.roughness", *map(slow_case, ("roll_friction", "nip_load", "drum.radius"))],
)
def test_sensitivities_include_the_change_of_the_film(result: wo.NipResult, name: str) -> None:
    sensitivity = result.sensitivity(name, outputs=("wound_on_tension", "half_width", "air.film"))
    value = float(sensitivity.fields[0])
    above, below = (
        wo.solve(NIP.replace(**{name: value * (1 + step)}), nodes=65, start=result)
        for step in (STEP, -STEP)
    )
    for k, output in enumerate(sensitivity.outputs):
        difference = (value_of(above, output) - value_of(below, output)) / (2 * STEP)
        # a change of the active set within the step would differ by about 1e-4 of the output
        scale = 1e-5 * abs(value_of(result, output))
        assert value * sensitivity.derivatives[k, 0] == pytest.approx(difference, abs=scale)

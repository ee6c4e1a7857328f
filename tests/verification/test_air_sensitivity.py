"""Sensitivities of a nip with entrained air, against differences of solutions (independent method).

Each solution iterates friction and film to 1e-10; the sensitivity differentiates the last mesh.
"""

from __future__ import annotations

import pytest
from derivatives import check_sensitivity
from slow_cases import slow_case
from thesis_cases import film_nip

import woundon as wo

NIP = film_nip(roll_wrap=3.0)


@pytest.fixture(scope="module")
def result() -> wo.NipResult:
    return wo.solve(NIP, nodes=65)


@pytest.mark.parametrize(
    "name",
    ["web_speed", "air.roughness", *map(slow_case, ("roll_friction", "nip_load", "drum.radius"))],
)
def test_sensitivities_include_the_change_of_the_film(result: wo.NipResult, name: str) -> None:
    outputs = ("wound_on_tension", "half_width", "air.film")
    # a change of the active set within the step would differ by about 1e-4 of the output
    check_sensitivity(result, [name], outputs, step=2e-4, rtol=0.0, atol=1e-5)

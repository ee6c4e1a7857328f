"""The effective linear roll of a winding against direct nips on the same hardening roll."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo
from woundon.winding.bodies import hardening_roll

pytestmark = [
    pytest.mark.campaign,
    pytest.mark.filterwarnings("ignore::woundon.ResolutionWarning"),
]
CASE = wo.WindingProblem.example()
COVER = wo.Cylinder(
    radius=0.25, core_radius=0.235, material=wo.Isotropic(youngs_modulus=20e6, poissons_ratio=0.4)
)
FILM = wo.WindingProblem(
    web=wo.Web(
        thickness=25e-6,
        material=wo.Orthotropic(radial=200e6, tangential=4.5e9, cross=20e6, shear=100e6),
    ),
    stack=wo.Stack(
        radial=wo.Pfeiffer(K1=5e3, K2=150.0), tangential=4.5e9, poissons_ratio=0.01, shear=30e6
    ),
    core=wo.Core(radius=0.0762, stiffness=5e9), drum=COVER.replace(radius=0.1, core_radius=0.085),
    radius=0.3, roll_friction=0.3, drum_friction=0.5,
    web_tension=wo.Taper(start=150.0, taper=0.25), nip_load=400.0, density=1390.0,
)  # fmt: skip
# largest deviation of the tension at three radii, rounded up (docs/theory/winding.md)
CASES = {
    "2 kN/m": (CASE, 0.04),
    "4 kN/m": (CASE.replace(nip_load=4000.0), 0.05),
    "0.7 kN/m": (CASE.replace(nip_load=700.0), 0.02),
    "soft stack": (CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=1e3, K2=80.0)}), 0.04),
    "stiff stack": (CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=100e3, K2=40.0)}), 0.02),
    "K2 = 150": (CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=10e3, K2=150.0)}), 0.05),
    "covered drum": (CASE.replace(drum=COVER), 0.07),
    "film": (FILM, 0.05),
    "surface winding": (CASE.replace(torque_split=1.0), 0.05),
}


@pytest.mark.parametrize("name", CASES)
def test_the_wound_on_tension_of_the_effective_roll_is_that_of_direct_nips(name: str) -> None:
    problem, bound = CASES[name]
    run = wo.solve(problem, rtol=1e-2, coupling_rtol=1e-4)
    radii = run.nip_radius[run.nip_radius >= 1.0499 * problem.core.radius]
    for r in radii[[1, radii.size // 2, -1]].tolist():
        nip = wo.solve(problem.nip(r, hardening_roll(problem, run.roll.at(r))), nodes=65)
        tension = np.interp(r, run.radius, run.wound_on_tension)
        assert tension == pytest.approx(nip.roll_wound_on_tension, rel=bound)

"""The web under pressure alone stretches by eps_x = nu (1 + nu) p/E (isotropic, plane strain)."""

from __future__ import annotations

import numpy as np

import woundon as wo


def test_in_the_nip_without_friction_the_web_runs_ahead_where_it_is_pressed() -> None:
    """Between a rigid drum and a roll, hardly any friction: v- = eps + xi-, T = T_in.

    So the web's slip on the drum varies by nu (1 + nu) p/E from point to point.
    """
    E, nu = 1e9, 0.3
    web = wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
    problem = wo.NipProblem(
        web=wo.Web(thickness=100e-6, material=web),
        roll=wo.HalfPlane(radius=0.3, material=wo.material("paper")),
        drum=wo.Rigid(radius=0.5),
        roll_friction=1e-8,
        drum_friction=1e-8,
        nip_load=2000.0,
        web_tension=300.0,
        roll_wrap=0.0,
    )
    result = wo.solve(problem)
    a, M = result.half_width, result.nodes
    # node k's slip is that of the collocation point before it, in the middle of its theta cell
    k = np.arange(1, M - 1)
    points = -a * np.cos(np.pi * (k - 0.5) / (M - 1))
    slip, pressure = result.drum_slip[1:-1], np.interp(points, result.x, result.drum_pressure)
    strain = nu * (1 + nu) / E * pressure
    difference = (slip - slip[0]) - (strain - strain[0])
    # friction bends the strain by about 1e-8 P/(2h E) = 2e-10
    assert np.max(np.abs(difference)) < 1e-9
    assert np.max(strain) > 1e-4

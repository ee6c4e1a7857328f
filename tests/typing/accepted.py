"""Programs of users that type checkers must accept; test_typing.py checks this file with mypy."""

from typing import assert_type

import woundon as wo

newsprint = wo.Orthotropic(radial="27 MPa", tangential="3.38 GPa", cross="5 MPa", shear=10e6)
problem = wo.NipProblem(
    web=wo.Web(thickness="66 um", material=newsprint),
    roll=wo.Cylinder(diameter="200 mm", core_diameter='3.5"', material="newsprint"),
    drum=wo.Rigid(diameter=0.1524),
    roll_friction="19 %",
    drum_friction=0.2,
    nip_load="20 pli",
    web_tension="350 N/m",
    wrap_friction=None,
)
assert_type(problem.nip_load, float)
assert_type(problem.wrap_friction, float | None)
assert_type(problem.roll, wo.Body)
assert_type(problem.air, wo.Air | None)
assert_type(problem.replace(nip_load="3 kN/m"), wo.NipProblem)

wo.NipProblem(
    grade="newsprint",
    roll={"diameter": "1 m", "core_diameter": "100 mm"},
    drum={"radius": 0.25},
    nip_load="3.6 kN",
    web_tension="10 MPa",
    width="1.2 m",
    air={"roughness": "3 um"},
    web_speed="1000 m/min",
)
wo.Web(thickness="45 gsm", density="680 kg/m^3", material="newsprint")
wo.WindingProblem(
    grade=wo.grade("lwc"),
    core=wo.Core(diameter="100 mm", stiffness="1 GPa"),
    drum=wo.Rigid(radius="250 mm"),
    diameter="1.2 m",
    nip_load=wo.Profile(radius=["50 mm", 0.6], value=["1 kN/m", "2 kN/m"]),
    web_tension=wo.Taper(start="400 N/m", taper="30 %"),
    torque_split=None,
    limits={"blocking_pressure": "1 MPa"},
)
wo.WindingProblem(
    grade="newsprint",
    core={"diameter": "100 mm", "stiffness": "1 GPa"},
    drum={"radius": 0.3},
    radius=0.6,
    web_tension=300.0,
    torque_split=0.5,
    winder=wo.TwoDrums(
        front_drum=wo.Rigid(diameter="500 mm"),
        gap="20 mm",
        rider_load=wo.Taper(start="2.5 kN/m", taper="20 %"),
        rider={"kind": "rigid", "radius": "150 mm"},
        core_torque=0.0,
        front_friction=None,
    ),
)
wo.RollProblem(
    core={"radius": 0.05, "stiffness": 1e9},
    radius=0.5,
    stack=wo.Stack(
        radial=wo.Pfeiffer(K1="10 kPa", K2=40), tangential=3.4e9, poissons_ratio=0.01, shear=10e6
    ),
    web_thickness="66 um",
    wound_on_tension="350 N/m",
)
wo.RollerProblem(
    upper=wo.HalfPlane(radius=0.25, material="steel"),
    lower=wo.Rigid(radius="10 in"),
    load="89 kN/m",
    friction=0.5,
    creepage=None,
)
wo.Isotropic(youngs_modulus="10 MPa", poissons_ratio=0.4, prony=[("2 MPa", "1 ms")])

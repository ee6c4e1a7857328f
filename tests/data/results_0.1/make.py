"""How the files here were made: with woundon 0.1.  It does not run with later versions.

They are what people have kept; ``tests/unit/test_result_files.py`` loads them.
"""

from math import pi
from pathlib import Path

from woundon.casefile import save_result

import woundon as wo

HERE = Path(__file__).parent

newsprint = wo.NipProblem(
    web=wo.Web(thickness=66e-6, material="newsprint"),
    roll=wo.Cylinder(radius=0.1, core_radius=0.0445, material="newsprint"),
    drum=wo.Rigid(radius=0.0762),
    roll_friction=0.19, drum_friction=0.2, nip_load=3502.0, web_tension=350.0,
)  # fmt: skip
covered = newsprint.replace(
    drum=wo.Cylinder(radius=0.0762, core_radius=0.0562, material="soft-cover"),
    winding_force=-200.0,
)
steel = wo.HalfPlane(radius=0.25, material="steel")
pair = wo.RollerProblem(upper=steel, lower=steel, load=89e3, tangential_load=8.4e3, friction=0.5)
rubber = wo.Cylinder(radius=0.1, core_radius=0.08, material="rubber")
unlike = wo.RollerProblem(
    upper=rubber, lower=wo.Rigid(radius=0.2), load=2e3, creepage=-0.004, friction=0.3
)

results = {
    "nip": wo.solve_nip(newsprint, nodes=33),
    "nip_covered": wo.solve_nip(covered, nodes=33),
    "nip_thesis": wo.solve_nip(newsprint, scheme="thesis", nodes=33),
    "nip_printed": wo.solve_nip(
        newsprint, scheme="thesis-printed", nodes=33, algorithm="panagiotopoulos"
    ),
    "nip_rtol": wo.solve_nip(newsprint, rtol=1e-4),
    "wrapped": wo.solve_wrapped_nip(newsprint, nodes=17),
    "wrapped_drum": wo.solve_wrapped_nip(
        newsprint,
        roll_wrap=2.0,
        drum_wrap=pi / 2,
        wrap_friction=0.25,
        winding_force=-60.0,
        nodes=17,
    ),
    "wrapped_drum_only": wo.solve_wrapped_nip(covered, roll_wrap=0.0, drum_wrap=pi / 3, nodes=17),
    "rollers": wo.solve_rollers(pair, nodes=33),
    "rollers_static": wo.solve_rollers(pair.replace(motion="static"), nodes=33),
    "rollers_unlike": wo.solve_rollers(unlike, nodes=33),
    "rollers_free": wo.solve_rollers(pair.replace(tangential_load=0.0), nodes=33),
}
for name, result in results.items():
    for ending in (
        ("json", "nc") if name in ("nip", "wrapped_drum", "rollers_static") else ("json",)
    ):
        save_result(result, HERE / f"{name}.{ending}")

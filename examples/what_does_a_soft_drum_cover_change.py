"""What does a soft drum cover change?

The newsprint case on a bare drum and on drums with a 20 mm cover of decreasing stiffness: the nip
gets wider, the pressure lower, and the roll keeps less tension.
"""

from pathlib import Path

import woundon as wo

case = wo.load_case(Path(__file__).parent / "newsprint_table2.toml")
radius = case.drum.radius

print("cover          nip width   peak pressure   wound-on tension")
for modulus in (None, 1000e6, 100e6, 30e6, 10e6):
    if modulus is None:
        drum = case.drum
    else:
        cover = wo.Isotropic(youngs_modulus=modulus, poissons_ratio=0.1)
        drum = wo.Cylinder(radius=radius, core_radius=radius - 20e-3, material=cover)
    result = wo.solve(case.replace(drum=drum))
    name = "none" if modulus is None else f"E = {modulus / 1e6:.0f} MPa"
    print(
        f"{name:14s} {1e3 * result.nip_width:6.2f} mm {1e-3 * result.peak_pressure:11.0f} kPa"
        f" {result.wound_on_tension:14.1f} N/m"
    )

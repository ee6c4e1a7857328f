"""Thesis Fig. 27, sec. 4.6: NIT and nip width against the thickness of the drum cover."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .cases import COVERS, DRUM_RADIUS, covered_nip
from .exhibits import Exhibit
from .nips import swept
from .panels import curve_panels
from .verdicts import Verdict, at_least, at_most, falls, verdict

__all__ = ["exhibits"]

THICKNESSES = np.linspace(0.005, 0.05, 19)
# The covers of equal E, in the order of the curves in data and legend.
SOFT = ("cellular elastomer", "rubber")


def exhibits(solver: str) -> list[Exhibit]:
    """Solve both soft covers over their thickness; return Fig. 27."""
    ratios = [COVERS[name][1] for name in SOFT]
    over = {"poissons_ratio": ratios, "cover_core_radius": DRUM_RADIUS - THICKNESSES}
    data = swept(covered_nip(*COVERS["rubber"], nip_load=5000.0), over, solver)
    # the dimension of the core radii gets the thicknesses in their place
    data = data.rename(cover_core_radius="cover_thickness")
    data["cover_thickness"] = ("cover_thickness", THICKNESSES, {"units": "m"})
    names = [f"{name}, $nu2$ = {nu:g}" for name, nu in zip(SOFT, ratios, strict=True)]
    axes = (("nip_induced_tension", "nip_width"), "cover_thickness", "poissons_ratio")
    return [
        Exhibit("fig27", data, _verdicts(data), curve_panels(data, *axes, names=names, legend=2.4))
    ]


def _verdicts(data: xr.Dataset) -> list[Verdict]:
    """Test the statements about the thickness of the covers."""
    cellular, rubber = data["nip_induced_tension"]
    slope = -rubber.differentiate("cover_thickness") / 1e3  # [N/m per mm]
    thin, thick = slope.sel(cover_thickness=[0.01, 0.03], method="nearest").values
    return [
        verdict(
            "the thickness of the cellular cover hardly matters for NIT, in N/m",
            np.ptp(cellular.values),
            at_most(20.0, "N/m"),
            note=f"its range from 5 to 50 mm; the rubber's is {np.ptp(rubber.values):.0f} N/m",
        ),
        falls("a thicker rubber cover gives less NIT", rubber, "cover_thickness"),
        verdict(
            "thickness matters most where the rubber is thin, about 10 mm: fall at 10 mm over "
            "that at 30 mm",
            thin / thick,
            at_least(3.0),
            note=f"{thin:.1f} and {thick:.1f} N/m per mm",
        ),
    ]

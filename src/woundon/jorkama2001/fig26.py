"""Thesis Fig. 26, sec. 4.6: NIT and nip width against the nip load for three drum covers."""

from __future__ import annotations

import numpy as np
import xarray as xr

import woundon as wo

from .cases import COVERS, DRUM_RADIUS, covered_nip
from .exhibits import Exhibit
from .fig16_18 import NIP_LOADS
from .nips import swept
from .panels import curve_panels
from .verdicts import Verdict, at_most, grows, verdict

__all__ = ["exhibits"]


def exhibits(solver: str) -> list[Exhibit]:
    """Solve Table 1's nip with three covers over the nip load; return Fig. 26."""
    over = {"nip_load": NIP_LOADS}
    covers = [swept(covered_nip(*cover), over, solver) for cover in COVERS.values()]
    data = xr.concat(covers, xr.DataArray(list(COVERS), dims="cover", name="cover"))
    moduli, ratios = zip(*COVERS.values(), strict=True)
    data["youngs_modulus"] = ("cover", list(moduli), {"units": "Pa"})
    data["poissons_ratio"] = ("cover", list(ratios), {"units": "1"})
    names = [f"{name}, {_modulus(E)}, $nu2$ = {nu:g}" for name, (E, nu) in COVERS.items()]
    shown = ("nip_induced_tension", "nip_width")
    panels = curve_panels(data, shown, "nip_load", "cover", names=names, legend=2.7)
    return [Exhibit("fig26", data, _verdicts(data, _without_shell(solver)), panels)]


def _without_shell(solver: str) -> xr.DataArray:
    """Return NIT on a half-plane of rubber at 2, 5 and 11 kN/m [N/m]."""
    E, nu = COVERS["rubber"]
    rubber = wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
    problem = covered_nip(E, nu).replace(drum=wo.HalfPlane(radius=DRUM_RADIUS, material=rubber))
    return swept(problem, {"nip_load": [2e3, 5e3, 11e3]}, solver)["nip_induced_tension"]


def _verdicts(data: xr.Dataset, without: xr.DataArray) -> list[Verdict]:
    """Test the statements about the three covers."""
    hard, rubber, cellular = data["nip_induced_tension"]
    slopes = np.diff(rubber) / np.diff(NIP_LOADS)
    width = 1e3 * data["nip_width"].sel(cover="rubber")
    return [
        verdict(
            "the cellular cover's NIT is very small",
            100 * (cellular / hard).max(),
            at_most(10.0, "%"),
            note=f"of the hard drum's; at most {cellular.max():.1f} N/m",
        ),
        verdict(
            "and practically independent of the load",
            np.ptp(cellular.values),
            at_most(5.0, "N/m"),
            note=f"its range; the hard drum's is {np.ptp(hard.values):.0f} N/m",
        ),
        verdict(
            "the rubber cover's NIT is lower than the hard drum's too",
            100 * (rubber / hard).max(),
            at_most(50.0, "%"),
            note="largest share",
        ),
        grows("it grows with the load", rubber, "nip_load"),
        verdict(
            "ever more slowly",
            slopes[-1] / slopes[0],
            at_most(1.0),
            note="slope at the heaviest load over that at the lightest.  It grows, as Peters found "
            "and the text denies: rubber cannot change its volume, so that the cover stiffens as "
            f"the nip, {width[0]:.0f} to {width[-1]:.0f} mm wide, outgrows its "
            "20 mm, and comes nearer to a hard drum.  On a half-plane of rubber NIT would be "
            f"{without[0]:.1f}, {without[1]:.1f} and {without[2]:.1f} N/m at 2, 5 and 11 kN/m",
        ),
    ]


def _modulus(E: float) -> str:
    """Return a modulus [Pa] as text."""
    return f"{E / 1e9:g} GPa" if E >= 1e9 else f"{E / 1e6:g} MPa"

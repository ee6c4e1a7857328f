"""Thesis Figs. 23 and 24, sec. 4.6: NIT and nip width against the drum cover's elasticity."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .cases import covered_nip
from .exhibits import Exhibit
from .nips import swept
from .panels import curve_panels
from .verdicts import Verdict, at_least, at_most, grows, verdict

__all__ = ["exhibits"]

NIP_LOADS = (2000.0, 5000.0)
MODULI = np.logspace(6, 12, 19)
RATIOS = (0.1, 0.2, 0.3, 0.4, 0.499)


def exhibits(solver: str) -> list[Exhibit]:
    """Solve a cover of 2 cm over E, nu and both loads; return Figs. 23 and 24."""
    over = {"nip_load": NIP_LOADS, "poissons_ratio": RATIOS, "youngs_modulus": MODULI}
    # the dimensions are in this order: load, nu, E
    data = swept(covered_nip(MODULI[0], RATIOS[0]), over, solver)
    NIT, width = data["nip_induced_tension"], data["nip_width"]
    axes = ("youngs_modulus", "poissons_ratio")
    tensions, widths = (
        curve_panels(data, [str(shown.name)], *axes, panels="nip_load") for shown in (NIT, width)
    )
    return [
        Exhibit("fig23", data, _tension(NIT), tensions),
        Exhibit("fig24", data, _width(width, NIT), widths),
    ]


def _variation(values: xr.DataArray, lowest: float) -> float:
    """Return the largest relative range over nu and E >= lowest, of both loads [%]."""
    stiff = values.sel(youngs_modulus=slice(lowest * (1 - 1e-9), None))
    both = ("poissons_ratio", "youngs_modulus")
    return 100 * float((1 - stiff.min(both) / stiff.max(both)).max())


def _tension(NIT: xr.DataArray) -> list[Verdict]:
    """Test the statements about the nip-induced tension over the modulus of the cover.

    Dimensions: nip load, nu, E.
    """
    soft = NIT.sel(youngs_modulus=slice(None, 1.01e10))
    E = soft["youngs_modulus"]
    fits = xr.corr(soft, E.copy(data=np.log(E.values)), "youngs_modulus") ** 2
    by_ratio = NIT.sel(youngs_modulus=slice(None, 0.99e10))
    steps = by_ratio.diff("poissons_ratio")
    first, last = steps[:, 0].mean(), steps[:, -1].mean()  # from nu = 0.1 to 0.2, 0.4 to 0.499
    return [
        verdict(
            "from 1 MPa to 10 GPa NIT grows about with the logarithm of E: R^2 of the worst curve",
            fits.min(),
            at_least(0.9),
            note="straight line by ln E",
        ),
        verdict(
            "above 10 GPa it depends neither on E nor on nu",
            _variation(NIT, 1e10),
            at_most(5.0, "%"),
            note="largest range",
        ),
        grows(
            "below, it grows with nu",
            by_ratio,
            "poissons_ratio",
            note="smallest step between neighbouring nu",
        ),
        verdict(
            "little at low nu, much as the cover becomes incompressible",
            last / first,
            at_least(4.0),
            note=f"average step from 0.4 to 0.499 over that from 0.1 to 0.2: {last:.1f} and "
            f"{first:.1f} N/m",
        ),
        verdict(
            "the picture is the same at both loads",
            xr.corr(*NIT),  # both loads
            at_least(0.95),
            note="correlation of the panels",
        ),
    ]


def _width(width: xr.DataArray, NIT: xr.DataArray) -> list[Verdict]:
    """Test the statements about the nip width.  Dimensions: nip load, nu, E."""

    def influence(values: xr.DataArray) -> float:
        """Return the largest range over nu relative to the mean."""
        along = "poissons_ratio"
        return float(((values.max(along) - values.min(along)) / values.mean(along)).max())

    return [
        verdict(
            "the nip is narrower for a higher nu",
            1e3 * width.diff("poissons_ratio")[..., 0].max(),
            at_most(0.0, "mm"),
            note="largest step between neighbouring nu at 1 MPa",
        ),
        verdict(
            "nu acts less on it than on NIT",
            influence(width) / influence(NIT),
            at_most(1.0),
            note="ratio of the largest relative ranges over nu, "
            f"{influence(width):.2f} and {influence(NIT):.2f}",
        ),
        verdict(
            "above 1 GPa it hardly depends on E and nu",
            _variation(width, 1e9),
            at_most(2.0, "%"),
            note="largest range",
        ),
        verdict(
            "so that it settles earlier than NIT does",
            _variation(width, 1e9) / _variation(NIT, 1e9),
            at_most(0.5),
            note="ratio of the ranges above 1 GPa",
        ),
    ]

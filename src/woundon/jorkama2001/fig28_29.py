"""Thesis Figs. 28 and 29, sec. 4.7: NIT and dual slip ratio against the paper's moduli."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..report.panels import Panel
from .cases import paper_nip
from .exhibits import Exhibit
from .nips import swept
from .panels import axis, curves, named
from .verdicts import Verdict, at_least, at_most, falls, grows, verdict

__all__ = ["exhibits"]

SHEAR = (1e6, 20e6, 100e6)  # G: rows of panels (a), (b), (c) [Pa]
CROSS = (0.1e6, 1e6, 40e6)  # A_rt: columns of panels 1, 2, 3
RADIAL = (4e6, 20e6, 100e6)  # A_rr: curves
TANGENTIAL = 1e9 * np.array([0.5, 0.55, 0.6, 0.7, 0.85, 1, 1.5, 2, 3, 4, 5, 6, 7])  # A_tt: x axis


def exhibits(solver: str) -> list[Exhibit]:
    """Solve the nip at 5 kN/m over the four moduli; return Figs. 28 and 29."""
    over = {"shear": SHEAR, "cross": CROSS, "radial": RADIAL, "tangential": TANGENTIAL}
    data = swept(paper_nip(nip_load=5000.0), over, solver)
    tension, dual_slip = "nip_induced_tension", "dual_slip"
    return [
        Exhibit("fig28", data, _tension(data[tension]), _panels(data, tension), lettered=False),
        Exhibit(
            "fig29",
            data,
            _dual_slip(data[dual_slip], solver),
            _panels(data, dual_slip),
            lettered=False,
        ),
    ]


def _where(flagged: np.ndarray) -> str:
    """Describe the moduli at which the flagged steps of A_rr lie.

    ``flagged`` are booleans by G, A_rt, step of A_rr and A_tt, (3, 3, 2, 13).
    """
    places = [
        f"G {SHEAR[i] / 1e6:g}, A_rt {CROSS[j] / 1e6:g}, A_rr {RADIAL[k] / 1e6:g} to "
        f"{RADIAL[k + 1] / 1e6:g} MPa at A_tt {TANGENTIAL[flagged[i, j, k]].min() / 1e9:g} to "
        f"{TANGENTIAL[flagged[i, j, k]].max() / 1e9:g} GPa"
        for i, j, k in np.argwhere(flagged.any(axis=3))
    ]
    return "; ".join(places) or "nowhere"


def _tension(NIT: xr.DataArray) -> list[Verdict]:
    """Test the statements about the nip-induced tension over the moduli of the roll.

    Dimensions: G, A_rt, A_rr, A_tt.
    """
    steps = NIT.diff("radial").values
    rising = steps > 0
    exception = np.zeros_like(rising)
    exception[-1, -1][:, TANGENTIAL <= 0.61e9] = True  # G = 100 MPa, A_rt = 40 MPa
    # change from A_rt = 0.1 to 1 MPa, without these coordinates, which differ
    small = 100 * np.abs(NIT[:, 1].drop_vars("cross") / NIT[:, 0].drop_vars("cross") - 1)
    return [
        grows("NIT grows with A_tt", NIT, "tangential"),
        verdict(
            "usually it falls as A_rr grows",
            100 * np.mean(~rising),
            at_least(80.0, "% of the steps"),
            note="the text says usually",
        ),
        verdict(
            "except for A_tt from 0.5 to 0.6 GPa, A_rt = 40 MPa and G = 100 MPa: there it grows",
            steps[exception].max(),
            at_least(0.0, "N/m"),
            note="largest step",
        ),
        verdict(
            "and nowhere else",
            np.sum(rising & ~exception),
            at_most(0),
            note=f"steps that grow elsewhere.  All: {_where(rising)}.  A_rt^2 comes near A_rr A_tt "
            "there, and a soft roll loses more tension to Poisson's effect than it gains by being "
            "soft.  No web thickness from 20 to 100 um confines it to what the text says",
        ),
        grows("it grows with G", NIT, "shear"),
        verdict(
            "up to A_rt = 1 MPa it does not depend on A_rt",
            small.max(),
            at_most(5.0, "%"),
            note="largest change from 0.1 to 1 MPa",
        ),
        falls(
            "beyond, it falls as A_rt grows",
            NIT[:, 1:],
            "cross",
            note="largest change from 1 to 40 MPa",
        ),
    ]


def _dual_slip(dual: xr.DataArray, solver: str) -> list[Verdict]:
    """Test the statements about the dual slip zone over the moduli of the roll."""
    # a ratio may fall by this much through the discretisation alone: one of the 200 cells of the
    # thesis, and a fifth of that where the position of a boundary is interpolated
    scatter = {"accurate": 0.001, "thesis": 0.005}[solver]

    def steps_up(statement: str, along: str, note: str = "") -> Verdict:
        """Test if the ratio grows along a modulus, except for the scatter."""
        steps = dual.diff(along)
        said = f"steps from {steps.min():.3f} to {steps.max():.3f}{note}"
        share = 100 * (steps > -scatter).mean()
        return verdict(statement, share, at_least(95.0, "% of the steps"), note=said)

    stiff = dual.diff("cross").sel(tangential=slice(3.5e9, None))
    return [
        steps_up("the dual slip ratio grows with A_tt", "tangential"),
        steps_up(
            "with A_rr",
            "radial",
            ".  It falls, as NIT does; the text likens it to NIT in the same sentence, so that "
            "this may be a slip of the pen",
        ),
        steps_up("with G", "shear"),
        steps_up(
            "and, unlike NIT, with A_rt",
            "cross",
            f".  It does in {100 * (stiff > -scatter).mean():.0f} % of the steps with A_tt of "
            "4 GPa or more, as in Fig. 30; where A_tt is small, A_rt^2 comes near A_rr A_tt and it "
            "falls",
        ),
    ]


def _panels(data: xr.Dataset, shown: str) -> list[Panel]:
    """Return the panels of an output over A_tt: rows of one G, columns of one A_rt."""
    panels = []
    for row, G in zip("abc", SHEAR, strict=True):
        for column, A_rt in enumerate(CROSS):
            part = data.sel(shear=G, cross=A_rt)
            panels.append(
                Panel(
                    f"{row}{column + 1}",
                    axis("tangential"),
                    axis(shown),
                    curves=curves(part, "tangential", shown, "radial"),
                    heading=f"({row}{column + 1})  {named('shear', G)}, {named('cross', A_rt)}",
                    column=str(column),
                    width=3.2,
                    height=2.8,
                    legend="figure below",
                )
            )
    return panels

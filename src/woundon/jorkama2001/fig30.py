"""Thesis Fig. 30, sec. 4.7: the web's tension along the nip for a large and a small A_rt."""

from __future__ import annotations

import woundon as wo

from .cases import paper_nip
from .exhibits import Exhibit
from .fig15 import gain_in_dual_slip, squeezed
from .nips import FINE, Nip, along_nip, joined, solved
from .panels import curve_panels
from .verdicts import Range, Verdict, at_least, at_most, verdict
from .zones import zone_lengths

__all__ = ["exhibits"]

CROSS = (40e6, 1e6)


def exhibits(solver: str) -> list[Exhibit]:
    """Solve A_tt = 7 GPa, A_rr = 20 MPa, G = 100 MPa with both A_rt; return Fig. 30."""
    nips = {rt: solved(_problem(rt), solver, FINE) for rt in CROSS}
    data = joined("cross [Pa]", {rt: along_nip(r) for rt, r in nips.items()})
    panels = curve_panels(data, ["tension_increase"], "x", "cross")
    return [Exhibit("fig30", data, _verdicts(*nips.values()), panels)]


def _problem(cross: float) -> wo.NipProblem:
    """Return the nip of web and roll with A_rt = ``cross`` [Pa]."""
    paper = wo.Orthotropic(radial=20e6, tangential=7e9, cross=cross, shear=100e6)
    return paper_nip(nip_load=5000.0, **{"web.material": paper, "roll.material": paper})


def _fall(r: Nip) -> float:
    """Return the largest decrease of the tension below the inlet tension [N/m]."""
    return float(r.problem.web_tension - r.tension.min())


def _off(r: Nip) -> float:
    """Return the deviation of eq. (173) from NIT [%]."""
    alone = wo.theories.dual_slip(r.problem, zone_lengths(r).dual)
    return 100 * abs(float(alone) / r.nip_induced_tension - 1)


def _verdicts(large: Nip, small: Nip) -> list[Verdict]:
    """Test the statements about the cross stiffness."""
    share, slipped = squeezed(large)
    gains = gain_in_dual_slip(large), gain_in_dual_slip(small)
    NIT = large.nip_induced_tension, small.nip_induced_tension
    return [
        verdict(
            "with A_rt = 40 MPa the tension falls by almost 100 N/m before the dual slip zone",
            _fall(large),
            Range(85.0, 100.0, "N/m"),
        ),
        verdict(
            "by Poisson's effect: its fall over 2h (A_rt/A_rr) times the rise of p, from where the "
            "web sticks to the drum to the lowest tension",
            share,
            Range(0.98, 1.02),
            note=f"before, on {100 * slipped:.1f} % of the width, the web is squeezed out backward "
            "and slips, which spares it a part of the fall",
        ),
        verdict(
            "with A_rt = 1 MPa it stays constant",
            _fall(small),
            at_most(5.0, "N/m"),
            note="its fall",
        ),
        verdict(
            "the dual slip zone adds more for the larger A_rt",
            gains[0] - gains[1],
            at_least(0.0, "N/m"),
            note=f"{gains[0]:.0f} against {gains[1]:.0f} N/m",
        ),
        verdict(
            "but the whole nip less",
            NIT[0] - NIT[1],
            at_most(0.0, "N/m"),
            note=f"NIT {NIT[0]:.0f} against {NIT[1]:.0f} N/m",
        ),
        verdict(
            "eq. (173), NIT by the dual slip ratio alone, does not apply to the larger A_rt: it is "
            "off by",
            _off(large),
            at_least(10.0, "%"),
        ),
        verdict("but does to the smaller one: it is off by", _off(small), at_most(10.0, "%")),
    ]

"""Thesis Fig. 30, sec. 4.7: the web's tension along the nip for a large and a small A_rt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..results import NipResult
from ..theories import dual_slip
from .fig28_29 import constants_nip
from .frame import Figure, Scheme, Table, Verdict
from .profiles import profiles, squeezed
from .slip_zones import zone_lengths
from .sweep import FINE, solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

CROSS = (40e6, 1e6)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve A_tt = 7 GPa, A_rr = 20 MPa, G = 100 MPa with both A_rt; return Fig. 30."""
    nips = [
        solved(constants_nip(radial=20e6, tangential=7e9, cross=rt, shear=100e6), scheme, FINE)
        for rt in CROSS
    ]
    table = profiles([({"cross [Pa]": rt}, r) for rt, r in zip(CROSS, nips, strict=True)])
    title = "Web tension along the nip for two cross stiffnesses"
    return (Figure("fig30", title, scheme, table, _verdicts(*nips), lambda: _draw(table)),)


def _fall(r: NipResult) -> float:
    """Return how far the tension falls below that of the incoming web [N/m]."""
    return float(r.problem.web_tension - r.web_tension.min())


def _gain(r: NipResult) -> float:
    """Return what the dual slip zone adds [N/m]."""
    C = r.half_width * (1 - 2 * zone_lengths(r).dual)
    k = np.flatnonzero(r.x < C)[-2]
    return float(r.web_tension[-1] - r.web_tension[k])


def _off(r: NipResult) -> float:
    """Return by how much eq. (173) misses NIT [%]."""
    return 100 * abs(float(dual_slip(r.problem, zone_lengths(r).dual)) / r.nip_induced_tension - 1)


def _verdicts(large: NipResult, small: NipResult) -> tuple[Verdict, ...]:
    share, slipped = squeezed(large)
    return (
        Verdict(
            "with A_rt = 40 MPa the tension falls by almost 100 N/m before the dual slip zone",
            _fall(large), 85.0, 100.0, "N/m",
        ),
        Verdict(
            "by Poisson's effect: its fall over 2h (A_rt/A_rr) times the rise of p, from where the "
            "web sticks to the drum to the lowest tension", share, 0.98, 1.02,
            note=f"before, on {100 * slipped:.1f} % of the width, the web is squeezed out backward "
            "and slips, which spares it a part of the fall",
        ),
        Verdict(
            "with A_rt = 1 MPa it stays constant", _fall(small), high=5.0, unit="N/m",
            note="its fall",
        ),
        Verdict(
            "the dual slip zone adds more for the larger A_rt", _gain(large) - _gain(small), 0.0,
            unit="N/m", note=f"{_gain(large):.0f} against {_gain(small):.0f} N/m",
        ),
        Verdict(
            "but the whole nip less", large.nip_induced_tension - small.nip_induced_tension,
            high=0.0, unit="N/m",
            note=f"NIT {large.nip_induced_tension:.0f} against {small.nip_induced_tension:.0f} N/m",
        ),
        Verdict(
            "eq. (173), NIT by the dual slip ratio alone, does not apply to the larger A_rt: it is "
            "off by", _off(large), 10.0, unit="%",
        ),
        Verdict(
            "but does to the smaller one: it is off by", _off(small), high=10.0, unit="%",
        ),
    )  # fmt: skip


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 1, (6.0, 4.0))
    lines = [
        drawing.Curve(k, rf"$A_{{r\theta}}$ = {rt / 1e6:g} MPa", cross=rt)
        for k, rt in enumerate(CROSS)
    ]
    drawing.curves(
        figure.axes[0], table, lines, ("x", "Position along the nip $x$ [mm]", 1e3),
        ("tension_increase", r"Web tension $T - T_\mathrm{in}$ [N/m]", 1.0),
    )  # fmt: skip
    drawing.shared_legend(figure, 2)
    return figure

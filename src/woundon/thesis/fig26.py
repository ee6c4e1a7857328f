"""Thesis Fig. 26, sec. 4.6: NIT and nip width against the nip load for three drum covers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bodies import HalfPlane
from .covers import covered_nip
from .fig16_18 import NIP_LOADS
from .frame import Figure, Scheme, Table, Verdict
from .sweep import solved, sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["COVERS", "figures"]

Array = np.ndarray

# E [Pa] and nu of the covers, 2 cm thick
COVERS = {"hard": (211e9, 0.3), "rubber": (1e6, 0.499), "cellular elastomer": (1e6, 0.1)}


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve Table 1's nip with three covers over the nip load; return Fig. 26."""
    cases = (
        (
            {"youngs_modulus": E, "poissons_ratio": nu, "nip_load": P},
            covered_nip(E, nu, nip_load=float(P)),
        )
        for E, nu in COVERS.values()
        for P in NIP_LOADS
    )
    table = sweep(cases, scheme)
    title = "NIT and nip width against the nip load for three drum covers"
    verdicts = _verdicts(table, _without_shell(scheme))
    return (Figure("fig26", title, scheme, table, verdicts, lambda: _draw(table)),)


def _without_shell(scheme: Scheme) -> list[float]:
    """Return NIT on a half-plane of rubber at 2, 5 and 11 kN/m [N/m]."""
    covered = covered_nip(*COVERS["rubber"])
    drum = HalfPlane(radius=covered.drum.radius, material=covered.drum.material)  # type: ignore[union-attr]
    return [
        solved(covered.replace(drum=drum, nip_load=P), scheme).nip_induced_tension
        for P in (2000.0, 5000.0, 11000.0)
    ]


def _verdicts(table: Table, without: list[float]) -> tuple[Verdict, ...]:
    NIT = table["nip_induced_tension"].reshape(len(COVERS), -1)
    width = table["nip_width"].reshape(len(COVERS), -1)
    hard, rubber, cellular = NIT
    slopes = np.diff(rubber) / np.diff(NIP_LOADS)
    return (
        Verdict(
            "the cellular cover's NIT is very small", 100 * float(np.max(cellular / hard)),
            high=10.0, unit="%", note=f"of the hard drum's; at most {cellular.max():.1f} N/m",
        ),
        Verdict(
            "and practically independent of the load", float(np.ptp(cellular)), high=5.0,
            unit="N/m", note=f"its range; the hard drum's is {np.ptp(hard):.0f} N/m",
        ),
        Verdict(
            "the rubber cover's NIT is lower than the hard drum's too",
            100 * float(np.max(rubber / hard)), high=50.0, unit="%", note="largest share",
        ),
        Verdict(
            "it grows with the load", float(np.min(np.diff(rubber))), 0.0, unit="N/m",
            note="smallest step",
        ),
        Verdict(
            "ever more slowly", float(slopes[-1] / slopes[0]), high=1.0,
            note="slope at the heaviest load over that at the lightest.  It grows, as Peters found "
            "and the text denies: rubber cannot change its volume, so that the cover stiffens as "
            f"the nip, {1e3 * width[1, 0]:.0f} to {1e3 * width[1, -1]:.0f} mm wide, outgrows its "
            "20 mm, and comes nearer to a hard drum.  On a half-plane of rubber NIT would be "
            f"{without[0]:.1f}, {without[1]:.1f} and {without[2]:.1f} N/m at 2, 5 and 11 kN/m",
        ),
    )  # fmt: skip


def _modulus(E: float) -> str:
    return f"{E / 1e9:g} GPa" if E >= 1e9 else f"{E / 1e6:g} MPa"


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    lines = [
        drawing.Curve(k, f"{name}, {_modulus(E)}, $\\nu_2$ = {nu:g}",
                      youngs_modulus=E, poissons_ratio=nu)
        for k, (name, (E, nu)) in enumerate(COVERS.items())
    ]  # fmt: skip
    load = ("nip_load", "Nip load $P$ [kN/m]", 1e-3)
    a, b = figure.axes
    drawing.curves(a, table, lines, load, ("nip_induced_tension", "NIT [N/m]", 1.0))
    drawing.curves(b, table, lines, load, ("nip_width", "Nip width $2a$ [mm]", 1e3))
    drawing.shared_legend(figure, 3)
    return figure

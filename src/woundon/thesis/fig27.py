"""Thesis Fig. 27, sec. 4.6: NIT and nip width against the thickness of the drum cover."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .covers import covered_nip
from .fig26 import COVERS
from .frame import Figure, Scheme, Table, Verdict
from .sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

NIP_LOAD = 5000.0
THICKNESSES = np.linspace(0.005, 0.05, 19)
SOFT = ("cellular elastomer", "rubber")


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve both soft covers over their thickness; return Fig. 27."""
    cases = (
        (
            {"poissons_ratio": COVERS[name][1], "cover_thickness": thickness},
            covered_nip(*COVERS[name], float(thickness), nip_load=NIP_LOAD),
        )
        for name in SOFT
        for thickness in THICKNESSES
    )
    table = sweep(cases, scheme)
    title = "NIT and nip width against the thickness of the drum cover"
    return (Figure("fig27", title, scheme, table, _verdicts(table), lambda: _draw(table)),)


def _verdicts(table: Table) -> tuple[Verdict, ...]:
    cellular, rubber = table["nip_induced_tension"].reshape(len(SOFT), -1)
    slope = -np.gradient(rubber, THICKNESSES * 1e3)
    thin, thick = (float(slope[np.argmin(np.abs(THICKNESSES - t))]) for t in (0.01, 0.03))
    return (
        Verdict(
            "the thickness of the cellular cover hardly matters for NIT, in N/m",
            float(np.ptp(cellular)), high=20.0, unit="N/m",
            note=f"its range from 5 to 50 mm; the rubber's is {np.ptp(rubber):.0f} N/m",
        ),
        Verdict(
            "a thicker rubber cover gives less NIT", float(np.max(np.diff(rubber))), high=0.0,
            unit="N/m", note="largest step",
        ),
        Verdict(
            "thickness matters most where the rubber is thin, about 10 mm: fall at 10 mm over "
            "that at 30 mm", thin / thick, 3.0, note=f"{thin:.1f} and {thick:.1f} N/m per mm",
        ),
    )  # fmt: skip


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    lines = [
        drawing.Curve(k, rf"{name}, $\nu_2$ = {COVERS[name][1]:g}", poissons_ratio=COVERS[name][1])
        for k, name in enumerate(SOFT)
    ]
    thickness = ("cover_thickness", r"Cover thickness $\Delta R_2$ [mm]", 1e3)
    a, b = figure.axes
    drawing.curves(a, table, lines, thickness, ("nip_induced_tension", "NIT [N/m]", 1.0))
    drawing.curves(b, table, lines, thickness, ("nip_width", "Nip width $2a$ [mm]", 1e3))
    drawing.shared_legend(figure, 2)
    return figure

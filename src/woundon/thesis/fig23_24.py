"""Thesis Figs. 23 and 24, sec. 4.6: NIT and nip width against the drum cover's elasticity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .covers import covered_nip
from .frame import Figure, Scheme, Table, Verdict
from .sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

NIP_LOADS = (2000.0, 5000.0)
MODULI = np.logspace(6, 12, 19)
RATIOS = (0.1, 0.2, 0.3, 0.4, 0.499)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve a cover of 2 cm over E, nu and both loads; return Figs. 23 and 24."""
    cases = (
        (
            {"nip_load": P, "poissons_ratio": nu, "youngs_modulus": E},
            covered_nip(float(E), nu, nip_load=P),
        )
        for P in NIP_LOADS
        for nu in RATIOS
        for E in MODULI
    )
    table = sweep(cases, scheme)
    tension, width = (_by_load(table, name) for name in ("nip_induced_tension", "nip_width"))
    return (
        Figure(
            "fig23", "NIT against the modulus of the drum cover", scheme, table,
            _tension_verdicts(tension), lambda: _draw(table, "nip_induced_tension"),
        ),
        Figure(
            "fig24", "Nip width against the modulus of the drum cover", scheme, table,
            _width_verdicts(width, tension), lambda: _draw(table, "nip_width"),
        ),
    )  # fmt: skip


def _by_load(table: Table, name: str) -> Array:
    """Return an output as (load, nu, E)."""
    return table[name].reshape(len(NIP_LOADS), len(RATIOS), MODULI.size)


def _variation(values: Array, lowest: float) -> float:
    """Return the largest relative range over nu and E >= lowest, of both loads [%]."""
    stiff = values[..., lowest * (1 - 1e-9) <= MODULI].reshape(len(NIP_LOADS), -1)
    return 100 * float(np.max(np.ptp(stiff, axis=1) / stiff.max(axis=1)))


def _tension_verdicts(NIT: Array) -> tuple[Verdict, ...]:
    soft = MODULI < 1.01e10
    fits = [
        np.corrcoef(np.log(MODULI[soft]), curve[soft])[0, 1] ** 2
        for panel in NIT
        for curve in panel
    ]
    by_ratio = np.diff(NIT[..., MODULI < 0.99e10], axis=1)
    few, many = by_ratio[:, 0].mean(), by_ratio[:, -1].mean()
    return (
        Verdict(
            "from 1 MPa to 10 GPa NIT grows about with the logarithm of E: R^2 of the worst curve",
            float(min(fits)), 0.9, note="straight line by ln E",
        ),
        Verdict(
            "above 10 GPa it depends neither on E nor on nu",
            _variation(NIT, 1e10), high=5.0, unit="%", note="largest range",
        ),
        Verdict(
            "below, it grows with nu", float(by_ratio.min()), 0.0, unit="N/m",
            note="smallest step between neighbouring nu",
        ),
        Verdict(
            "little at low nu, much as the cover becomes incompressible", float(many / few), 4.0,
            note=f"average step from 0.4 to 0.499 over that from 0.1 to 0.2: {many:.1f} and "
            f"{few:.1f} N/m",
        ),
        Verdict(
            "the picture is the same at both loads",
            float(np.corrcoef(NIT[0].ravel(), NIT[1].ravel())[0, 1]), 0.95,
            note="correlation of the panels",
        ),
    )  # fmt: skip


def _width_verdicts(width: Array, NIT: Array) -> tuple[Verdict, ...]:
    falls = np.diff(width, axis=1)

    def influence(values: Array) -> float:
        return float(np.max(np.ptp(values, axis=1) / values.mean(axis=1)))

    return (
        Verdict(
            "the nip is narrower for a higher nu", 1e3 * float(falls[..., 0].max()), high=0.0,
            unit="mm", note="largest step between neighbouring nu at 1 MPa",
        ),
        Verdict(
            "nu acts less on it than on NIT", influence(width) / influence(NIT), high=1.0,
            note="ratio of the largest relative ranges over nu, "
            f"{influence(width):.2f} and {influence(NIT):.2f}",
        ),
        Verdict(
            "above 1 GPa it hardly depends on E and nu", _variation(width, 1e9), high=2.0,
            unit="%", note="largest range",
        ),
        Verdict(
            "so that it settles earlier than NIT does",
            _variation(width, 1e9) / _variation(NIT, 1e9), high=0.5,
            note="ratio of the ranges above 1 GPa",
        ),
    )  # fmt: skip


def _draw(table: Table, name: str) -> Drawing:
    from . import drawing

    shown = {
        "nip_induced_tension": (name, "NIT [N/m]", 1.0),
        "nip_width": (name, "Nip width $2a$ [mm]", 1e3),
    }
    figure = drawing.blank()
    lines = [
        drawing.Curve(k, rf"$\nu_2 = {nu:g}$", poissons_ratio=nu) for k, nu in enumerate(RATIOS)
    ]
    for axes, P in zip(figure.axes, NIP_LOADS, strict=True):
        modulus = ("youngs_modulus", "Cover modulus $E_2$ [Pa]", 1.0)
        drawing.curves(axes, table.where(nip_load=P), lines, modulus, shown[name])
        axes.set_xscale("log")
        axes.set_title(f"$P = {P:.0f}$ N/m", fontsize=9)
    drawing.shared_legend(figure)
    return figure

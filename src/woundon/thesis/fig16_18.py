"""Thesis Figs. 16 to 18, sec. 4.3: NIT, nip width, slip zones against nip load, winding force."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..results import NipResult
from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict
from .slip_zones import zone_lengths
from .sweep import WINDING_FORCES, solved, sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

# from just above the load that F = -500 N/m needs (|F| < mu- P) to a nip 20 mm wide
NIP_LOADS = np.geomspace(1300.0, 11200.0, 25)
LIGHT_LOAD, HEAVY_LOAD = 1.0, 1e5  # far outside the figures, for what the text says of limits [N/m]

_LOAD = ("nip_load", "Nip load $P$ [kN/m]", 1e-3)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve Table 1's nip over nip load and winding force; return Figs. 16, 17 and 18."""
    table, heavy = _sweep(NIP_LOADS, scheme), _sweep([HEAVY_LOAD], scheme)
    light = solved(paper_nip(winding_force=0.0, nip_load=LIGHT_LOAD), scheme)
    return (
        Figure(
            "fig16", "NIT and nip width against the nip load", scheme, table,
            _fig16_verdicts(table, light), lambda: _fig16(table),
        ),
        Figure(
            "fig17", "Leading and trailing slip at the roll against the nip load", scheme, table,
            _fig17_verdicts(table), lambda: _fig17(table),
        ),
        Figure(
            "fig18", "Dual slip ratio against the nip load", scheme, table,
            _fig18_verdicts(table, heavy), lambda: _fig18(table),
        ),
    )  # fmt: skip


def _sweep(nip_loads: Iterable[float], scheme: Scheme) -> Table:
    cases = (
        ({"winding_force": F, "nip_load": P}, paper_nip(winding_force=F, nip_load=float(P)))
        for F in WINDING_FORCES
        for P in nip_loads
    )
    return sweep(cases, scheme)


def _by_force(table: Table, name: str) -> Array:
    """Return an output as (forces, loads)."""
    return table[name].reshape(len(WINDING_FORCES), -1)


def _spread(values: Array) -> Array:
    """Return the range over the winding forces at every load."""
    return np.asarray(np.ptp(values, axis=0))


def _fig16_verdicts(table: Table, light: NipResult) -> tuple[Verdict, ...]:
    friction = light.nip_induced_tension / (light.problem.roll_friction * LIGHT_LOAD)
    backward = -zone_lengths(light).leading_roll
    NIT, width, approach = (
        _by_force(table, name) for name in ("nip_induced_tension", "nip_width", "approach")
    )
    slopes = np.diff(NIT[3:], axis=1) / np.diff(NIP_LOADS)  # centre winding and F = 100 N/m
    return (
        Verdict(
            "a higher winding force gives a higher NIT at every nip load",
            float(np.min(np.diff(NIT, axis=0))), 0.0, unit="N/m",
            note="smallest step between neighbouring forces",
        ),
        Verdict(
            "the winding force acts more on NIT where the load is light",
            float(np.max(np.diff(_spread(NIT)))), high=0.0, unit="N/m",
            note=f"largest step of the curves' spread, which falls from {_spread(NIT)[0]:.0f} to "
            f"{_spread(NIT)[-1]:.0f} N/m",
        ),
        Verdict(
            "the nip width does not depend on the winding force",
            100 * float(np.max(_spread(width) / width[-1])), high=1.0, unit="%",
            note="largest spread between the forces",
        ),
        Verdict(
            "nor does the approach of the centres, so that no theory can be right in which NIT is "
            "a function of the approach alone",
            100 * float(np.max(_spread(approach) / approach[-1])), high=1.0, unit="%",
            note="largest spread between the forces",
        ),
        Verdict(
            "the curves flatten as the load grows (ch. 6)",
            float(np.max(np.diff(slopes, axis=1))), high=0.0,
            note="largest change of slope [N/m per N/m] between neighbouring loads, F >= 0",
        ),
        Verdict(
            "at a very light load NIT is about mu+ P (ch. 6)", friction, 0.9, 1.0,
            note=f"NIT/(mu+ P), centre winding at P = {LIGHT_LOAD:.0f} N/m.  Even there the web "
            f"slips backward on {100 * backward:.0f} % of the roll's face, which takes friction "
            "off; as P goes to zero the ratio tends to 0.87",
        ),
    )  # fmt: skip


def _fig17_verdicts(table: Table) -> tuple[Verdict, ...]:
    leading, trailing = (
        _by_force(table, name) for name in ("leading_roll_slip", "trailing_roll_slip")
    )
    fall = _spread(trailing)[0] - _spread(trailing)[-1]
    return (
        Verdict(
            "at the lightest load and lowest force the web slips on the whole roll: s_r1 = 0",
            float(leading[0, 0]), 0.0, 0.0,
        ),
        Verdict("and s_r2 = 1", float(trailing[0, 0]), 1.0, 1.0),
        Verdict(
            "at the leading edge the roll is ahead of the web",
            float(np.max(leading)), high=0.0, note="largest s_r1, negative: web slower",
        ),
        Verdict(
            "at the trailing edge the web is ahead of the roll",
            float(np.min(trailing)), 0.0, note="smallest s_r2, positive: web faster",
        ),
        Verdict(
            "the winding force acts more on the slip lengths where the load is light",
            float(fall), 0.0,
            note=f"the spread of s_r2 falls from {_spread(trailing)[0]:.2f} to "
            f"{_spread(trailing)[-1]:.2f}",
        ),
        Verdict(
            "for F = 100 N/m s_r1 hardly depends on the load",
            float(np.ptp(leading[-1])), high=0.05, note="its range over the loads",
        ),
        Verdict(
            "for F = 100 N/m s_r2 hardly depends on the load",
            float(np.ptp(trailing[-1])), high=0.1,
            note="its range over the loads",
        ),
        Verdict(
            "for lower winding forces the load matters much more: smallest range of s_r2 for "
            "F <= -200 N/m, over that for F = 100 N/m",
            float(np.min(np.ptp(trailing[:3], axis=1)) / np.ptp(trailing[-1])), 2.0,
        ),
    )  # fmt: skip


def _fig18_verdicts(table: Table, heavy: Table) -> tuple[Verdict, ...]:
    dual, NIT = _by_force(table, "dual_slip"), _by_force(table, "nip_induced_tension")
    agree = np.mean(np.sign(dual) == np.sign(NIT))
    steps = np.diff(dual, axis=1)
    return (
        Verdict(
            "the dual slip ratio has the sign of NIT",
            100 * float(agree), 95.0, unit="% of the points",
        ),
        Verdict(
            "it falls with the load for F >= 0", float(dual[3:, -1].max() - dual[3:, 0].min()),
            high=0.0, note="change from the lightest to the heaviest load",
        ),
        Verdict(
            "it rises with the load for F <= -200 N/m",
            float(np.min(dual[:3, -1] - dual[:3, 0])), 0.0,
            note=f"smallest change over the range; the largest fall between neighbouring loads is "
            f"{-steps[:3].min():.3f}",
        ),
        Verdict(
            "at heavy loads the winding force loses its influence",
            float(_spread(dual)[-1] / _spread(dual)[0]), high=0.1,
            note="spread of the curves at the heaviest load, over that at the lightest",
        ),
        Verdict(
            "all curves come to about 0.1", float(np.mean(dual[:, -1])), 0.08, 0.12,
            note=f"average at the heaviest load; from {dual[:, -1].min():.3f} to "
            f"{dual[:, -1].max():.3f}",
        ),
        Verdict(
            "which is a limit, independent of the load",
            100 * float(np.mean(heavy["dual_slip"]) / np.mean(dual[:, -1]) - 1), -10.0, 10.0, "%",
            note=f"change to P = {HEAVY_LOAD / 1e3:.0f} kN/m, where all five are near "
            f"{np.mean(heavy['dual_slip']):.3f}.  The ratio would be constant if the half width "
            "were the only length; but the web has one of its own, its stiffness 2h A_tt over that "
            "of the roll, and the nip goes on outgrowing it",
        ),
    )  # fmt: skip


def _fig16(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    a, b = figure.axes
    lines = drawing.force_curves()
    drawing.curves(a, table, lines, _LOAD, ("nip_induced_tension", "NIT [N/m]", 1.0))
    drawing.curves(b, table, lines, _LOAD, ("nip_width", "Nip width $2a$ [mm]", 1e3))
    drawing.shared_legend(figure)
    return figure


def _fig17(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    a, b = figure.axes
    lines = drawing.force_curves()
    drawing.curves(a, table, lines, _LOAD, ("leading_roll_slip", "Leading edge $s_{r1}$", 1.0))
    drawing.curves(b, table, lines, _LOAD, ("trailing_roll_slip", "Trailing edge $s_{r2}$", 1.0))
    drawing.shared_legend(figure)
    return figure


def _fig18(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 1, (6.0, 4.0))
    (axes,) = figure.axes
    lines = drawing.force_curves()
    drawing.curves(axes, table, lines, _LOAD, ("dual_slip", "Dual slip ratio $s_d$", 1.0))
    drawing.shared_legend(figure, 3)
    return figure

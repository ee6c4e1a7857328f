"""Thesis Figs. 16 to 18, sec. 4.3: NIT, nip width, slip zones against nip load, winding force."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from .cases import WINDING_FORCES, paper_nip
from .exhibits import Exhibit
from .nips import Nip, solved, swept
from .panels import curve_panels
from .verdicts import Range, Verdict, at_least, at_most, exactly, falls, grows, verdict
from .zones import zone_lengths

__all__ = ["NIP_LOADS", "exhibits"]

# from just above the load that F = -500 N/m needs (|F| < mu- P) to a nip 20 mm wide
NIP_LOADS = np.geomspace(1300.0, 11200.0, 25)
LIGHT_LOAD, HEAVY_LOAD = 1.0, 1e5  # far outside the figures, for what the text says of limits [N/m]


def exhibits(solver: str) -> list[Exhibit]:
    """Solve Table 1's nip over nip load and winding force; return Figs. 16, 17 and 18."""
    data, heavy = _swept(NIP_LOADS, solver), _swept([HEAVY_LOAD], solver)
    light = solved(paper_nip(winding_force=0.0, nip_load=LIGHT_LOAD), solver)
    slips, over = ("leading_roll_slip", "trailing_roll_slip"), "nip_load"
    tensions = curve_panels(data, ("nip_induced_tension", "nip_width"), over)
    return [
        Exhibit("fig16", data, _tension(data, light), tensions),
        Exhibit("fig17", data, _slip(data), curve_panels(data, slips, over)),
        Exhibit("fig18", data, _dual_slip(data, heavy), curve_panels(data, ("dual_slip",), over)),
    ]


def _swept(nip_loads: Sequence[float] | np.ndarray, solver: str) -> xr.Dataset:
    """Solve the nip; dimensions: the five winding forces from -500 to 100 N/m, nip load."""
    return swept(paper_nip(), {"winding_force": WINDING_FORCES, "nip_load": nip_loads}, solver)


def _spread(values: xr.DataArray) -> xr.DataArray:
    """Return the range over the winding forces at every load."""
    return values.max("winding_force") - values.min("winding_force")


def _range(values: xr.DataArray) -> xr.DataArray:
    """Return the range over the loads."""
    return values.max("nip_load") - values.min("nip_load")


def _tension(data: xr.Dataset, light: Nip) -> list[Verdict]:
    """Test the statements about the nip-induced tension."""
    friction = light.nip_induced_tension / (light.problem.roll_friction * LIGHT_LOAD)
    backward = -zone_lengths(light).leading_roll  # s_r1 is negative: the web is slower
    NIT, width, approach = data["nip_induced_tension"], data["nip_width"], data["approach"]
    spread = _spread(NIT)
    free = NIT.sel(winding_force=slice(0, None))  # centre winding and F = 100 N/m
    return [
        grows(
            "a higher winding force gives a higher NIT at every nip load",
            NIT,
            "winding_force",
            note="smallest step between neighbouring forces",
        ),
        falls(
            "the winding force acts more on NIT where the load is light",
            spread,
            "nip_load",
            note=f"largest step of the curves' spread, which falls from {spread[0]:.0f} to "
            f"{spread[-1]:.0f} N/m",
        ),
        verdict(
            "the nip width does not depend on the winding force",
            100 * (_spread(width) / width[-1]).max(),
            at_most(1.0, "%"),
            note="largest spread between the forces",
        ),
        verdict(
            "nor does the approach of the centres, so that no theory can be right in which NIT is "
            "a function of the approach alone",
            100 * (_spread(approach) / approach[-1]).max(),
            at_most(1.0, "%"),
            note="largest spread between the forces",
        ),
        verdict(
            "the curves flatten as the load grows (ch. 6)",
            np.diff(np.diff(free) / np.diff(NIP_LOADS)).max(),
            at_most(0.0),
            note="largest change of slope [N/m per N/m] between neighbouring loads, F >= 0",
        ),
        verdict(
            "at a very light load NIT is about mu+ P (ch. 6)",
            friction,
            Range(0.9, 1.0),
            note=f"NIT/(mu+ P), centre winding at P = {LIGHT_LOAD:.0f} N/m.  Even there the web "
            f"slips backward on {100 * backward:.0f} % of the roll's face, which takes friction "
            "off; as P goes to zero the ratio tends to 0.87",
        ),
    ]


def _slip(data: xr.Dataset) -> list[Verdict]:
    """Test the statements about the slip zones on the roll; dimensions: winding force, nip load."""
    leading, trailing = data["leading_roll_slip"], data["trailing_roll_slip"]
    spread, over_loads = _spread(trailing), _range(trailing)
    return [
        verdict(
            "at the lightest load and lowest force the web slips on the whole roll: s_r1 = 0",
            leading[0, 0],
            exactly(0.0),
        ),
        verdict("and s_r2 = 1", trailing[0, 0], exactly(1.0)),
        verdict(
            "at the leading edge the roll is ahead of the web",
            leading.max(),
            at_most(0.0),
            note="largest s_r1, negative: web slower",
        ),
        verdict(
            "at the trailing edge the web is ahead of the roll",
            trailing.min(),
            at_least(0.0),
            note="smallest s_r2, positive: web faster",
        ),
        verdict(
            "the winding force acts more on the slip lengths where the load is light",
            spread[0] - spread[-1],
            at_least(0.0),
            note=f"the spread of s_r2 falls from {spread[0]:.2f} to {spread[-1]:.2f}",
        ),
        verdict(
            "for F = 100 N/m s_r1 hardly depends on the load",
            _range(leading)[-1],
            at_most(0.05),
            note="its range over the loads",
        ),
        verdict(
            "for F = 100 N/m s_r2 hardly depends on the load",
            over_loads[-1],
            at_most(0.1),
            note="its range over the loads",
        ),
        verdict(
            "for lower winding forces the load matters much more: smallest range of s_r2 for "
            "F <= -200 N/m, over that for F = 100 N/m",
            over_loads[:3].min() / over_loads[-1],
            at_least(2.0),
        ),
    ]


def _dual_slip(data: xr.Dataset, heavy: xr.Dataset) -> list[Verdict]:
    """Test the statements about the dual slip zone.

    ``heavy`` is the nip at HEAVY_LOAD.  Dimensions: winding force, of which [:3] are < 0 and [3:]
    are >= 0, and nip load, ascending.
    """
    dual, spread = data["dual_slip"], _spread(data["dual_slip"])
    agree = (np.sign(dual) == np.sign(data["nip_induced_tension"])).mean()
    last, limit = dual[:, -1], heavy["dual_slip"].mean()
    return [
        verdict(
            "the dual slip ratio has the sign of NIT",
            100 * agree,
            at_least(95.0, "% of the points"),
        ),
        verdict(
            "it falls with the load for F >= 0",
            dual[3:, -1].max() - dual[3:, 0].min(),
            at_most(0.0),
            note="change from the lightest to the heaviest load",
        ),
        verdict(
            "it rises with the load for F <= -200 N/m",
            (dual[:3, -1] - dual[:3, 0]).min(),
            at_least(0.0),
            note=f"smallest change over the range; the largest fall between neighbouring loads is "
            f"{-dual[:3].diff('nip_load').min():.3f}",
        ),
        verdict(
            "at heavy loads the winding force loses its influence",
            spread[-1] / spread[0],
            at_most(0.1),
            note="spread of the curves at the heaviest load, over that at the lightest",
        ),
        verdict(
            "all curves come to about 0.1",
            last.mean(),
            Range(0.08, 0.12),
            note=f"average at the heaviest load; from {last.min():.3f} to {last.max():.3f}",
        ),
        verdict(
            "which is a limit, independent of the load",
            100 * (limit / last.mean() - 1),
            Range(-10.0, 10.0, "%"),
            note=f"change to P = {HEAVY_LOAD / 1e3:.0f} kN/m, where all five are near "
            f"{limit:.3f}.  The ratio would be constant if the half width "
            "were the only length; but the web has one of its own, its stiffness 2h A_tt over that "
            "of the roll, and the nip goes on outgrowing it",
        ),
    ]

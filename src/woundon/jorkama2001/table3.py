"""Thesis Table 3: measured wound-on tension of newsprint, its theory, and fits of it.

The laboratory winder leads the web off the roll a quarter turn downstream of the nip, to a load
cell, so the theory is eq. (183).  By the winding theorem it is T_in plus a function of the nip
load alone: five solved nips stand for the fifteen points.

The thesis chose A_rr and G so that theory and measurement meet at one point.  One point fixes one
number: here either of the two is fitted, the other held at the thesis's value, and the fourteen
other points are predicted.  Fitted to all fifteen points together they come close to the floor, far
along a valley in which they trade off; that fit is ours, and always accurate.  The
printed thickness of 66 um does not give the printed theory; 57 um does.  Both are computed.
"""

from __future__ import annotations

from math import nan

import pandas as pd

from .cases import measured_tensions
from .exhibits import Exhibit
from .laboratory import FITTED_POINT, MODULI, THICKNESSES, Theory, rms, theories, theory
from .nips import dataset
from .table4 import added_tensions, as_text, best_rms
from .verdicts import Range, Verdict, accurate, at_least, at_most, verdict

__all__ = ["exhibits", "report"]


def exhibits(solver: str) -> list[Exhibit]:
    """Compute theory and fits; return Table 3."""
    points = measured_tensions()
    columns = {name: points[name] for name in points}
    columns |= {one.name: one.tension(points) for one in theories(solver)}
    data = dataset("point", {f"{name} [N/m]": values for name, values in columns.items()})
    return [Exhibit("table3", data, _verdicts(solver), text=report(solver))]


def _printed(points: pd.DataFrame) -> pd.DataFrame:
    """Return the printed theory less T_in, nip loads by web tensions [N/m]."""
    added = points.assign(added=points["thesis_theory"] - points["web_tension"])
    return added.pivot(index="nip_load", columns="web_tension", values="added")


def _verdicts(solver: str) -> list[Verdict]:
    """Test the statements of chapter 5 about the table, with the printed thickness."""
    thickness, thinner = THICKNESSES
    printed, thin = theory(solver, thickness), theory(solver, thinner)
    by_shear, by_radial = (theory(solver, thickness, fitted=(name,)) for name in MODULI)
    points = measured_tensions()
    said = _printed(points)
    measured = points.set_index(["nip_load", "web_tension"])["measured"][FITTED_POINT]
    P, T_in = FITTED_POINT
    distance = [one.added[P] + T_in - measured for one in (printed, thin)]
    off = 100 * (printed.added / said.mean(axis=1) - 1)
    return [
        verdict(
            "by the winding theorem the theory adds the same tension at every T_in: spread of the "
            "printed theory less T_in",
            (said.max(axis=1) - said.min(axis=1)).max(),
            at_most(1.0, "N/m"),
            note="largest over the loads; whole N/m are printed",
        ),
        verdict(
            "with A_rr = 27 MPa, G = 10 MPa and 2h = 66 um theory and experiment coincide at "
            "P = 3502, T_in = 350 N/m: distance",
            distance[0],
            Range(-7.0, 7.0, "N/m"),
            note="1 % of the tension is allowed.  With 57 um the distance is "
            f"{distance[1]:.1f} N/m: see the documentation, A discrepancy that stays",
        ),
        verdict(
            "these parameters give the printed theory: largest distance",
            off.abs().max(),
            at_most(1.0, "%"),
            note=f"of the added tension; {', '.join(f'{value:.1f}' for value in off)} % by load",
        ),
        verdict(
            "fitted to that point, the theory agrees well with the other experiments: RMS over the "
            "14 predicted points, the worse of the two one-point fits",
            max(by_shear.rms_predicted, by_radial.rms_predicted),
            at_most(0.05 * float(points["measured"].mean()), "N/m"),
            note="5 % of the average tension is allowed; the printed theory has "
            f"{_thesis_rms(points):.1f} N/m, and no theory without influence of T_in can have less "
            f"than {best_rms():.1f} N/m",
        ),
        *accurate(_tuned(theory(solver, thickness, MODULI))),
    ]


def _tuned(full: Theory) -> list[Verdict]:
    """Test the statements about fitting both moduli to all points."""
    assert full.fit is not None
    return [
        verdict(
            "A_rr and G can be used as tuning parameters to get a close fit: RMS of both fitted to "
            "all points, over the floor",
            full.rms / best_rms(),
            at_most(1.25),
            note=f"{full.rms:.1f} N/m at {_moduli(full)}",
        ),
        verdict(
            "a higher A_rr undoes a higher G: how many times better the data determine the one "
            "combination of them than the other",
            full.fit.condition,
            at_least(10.0),
            note="so that no fit to data like these can tell the two moduli apart: the best pair "
            "is many times the thesis's, and predicts nearly the same tensions",
        ),
    ]


def _thesis_rms(points: pd.DataFrame) -> float:
    """Return the RMS of printed theory less measurement [N/m]."""
    return rms((points["thesis_theory"] - points["measured"]).to_numpy())


def _moduli(full: Theory) -> str:
    """Return the fitted moduli as text."""
    G, A_rr = (full.fitted[name] / 1e6 for name in ("shear", "radial"))
    return f"G = {G:.0f} and A_rr = {A_rr:.0f} MPa"


def report(solver: str = "accurate") -> str:
    """Return Table 3 as text."""
    points, computed = measured_tensions(), theories(solver)
    by_shear = theory(solver, THICKNESSES[0], fitted=("shear",))
    rows = {
        "measured, average over T_in": added_tensions().mean(axis=1),
        "theory as printed": _printed(points).mean(axis=1),
        **{one.name: one.added for one in computed},
    }
    added = pd.DataFrame(rows).T
    # in the order of the rows: the best model without T_in, the printed theory, those computed
    added["RMS"] = [best_rms(), _thesis_rms(points), *(one.rms for one in computed)]
    added["of 14"] = [nan, nan, *(one.rms_predicted for one in computed)]
    three = points[["measured", "thesis_theory"]].assign(here=by_shear.tension(points))
    points["cell"] = three.round().astype(int).astype(str).agg(" / ".join, axis=1)
    return "\n".join(
        [
            "Wound-on tension less T_in by nip load [N/m], thesis eq. (183); RMS of the distances",
            "from the 15 measured points, and from the 14 other than P = 3502, T_in = 350 N/m",
            as_text(added),
            "",
            "Wound-on tension by nip load and T_in [N/m]: experiment / theory as printed / here, G",
            "fitted to one point",
            as_text(points.pivot(index="nip_load", columns="web_tension", values="cell")),
        ]
    )

"""Thesis sec. 4.9 and ch. 5 with the solved wrap: error of a web held at the trailing edge.

The thesis confines its solution to the nip: the web is held to the roll from the trailing edge on
(97).  Here that is compared with the web wrapped on the roll and held half a turn away (96), over
nip load and winding force, and on the laboratory winder, where the web leaves the roll after a
quarter turn.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import nan, pi

import pandas as pd

import woundon as wo

from .cases import measured_tensions, newsprint_nip, paper_nip
from .estimate import wound_on_tension_estimate
from .laboratory import rms
from .nips import solved

__all__ = ["CASES", "error_map", "pinning_error", "rig_misses", "rig_table", "trailing_edge"]

NODES = 65


def pinning_error(problem: wo.NipProblem) -> dict[str, float]:
    """Compare the nip alone with the wrapped one.

    Returns
    -------
    dict
        ``nip_load``, ``winding_force``; NIT ``alone``; with the roll wrap, the increase of tension
        ``in_nip`` and the one up to the end of the wrap, ``added`` [N/m], and ``slip_angle``
        [rad]; the relative ``error`` of the wound-on tension, > 0 if the nip alone overestimates.
    """
    alone, wrapped = (solved(one, nodes=NODES) for one in (problem, problem.replace(roll_wrap=pi)))
    T_in, WOT = problem.web_tension, wrapped.wound_on_tension
    return {
        "nip_load": problem.nip_load,
        "winding_force": problem.winding_force,
        "alone": alone.nip_induced_tension,
        "in_nip": wrapped.outlet_tension - wrapped.inlet_tension,
        "added": WOT - T_in,
        "slip_angle": wrapped.slip_angle,
        "error": (T_in + alone.nip_induced_tension) / WOT - 1,
    }


def error_map(base: wo.NipProblem, loads: Iterable[float], shares: Iterable[float]) -> pd.DataFrame:
    """Return :func:`pinning_error` over nip loads and winding forces, load by load.

    Parameters
    ----------
    base : NipProblem
    loads : iterable of float
        P [N/m].
    shares : iterable of float
        F/(mu- P).  Where it leaves the web slack, all but P and F is nan.
    """
    shares, rows = tuple(shares), []
    for P in loads:
        for share in shares:
            F = share * base.drum_friction * P
            try:
                rows.append(pinning_error(base.replace(nip_load=P, winding_force=F)))
            except wo.NoSteadyState:
                rows.append({"nip_load": P, "winding_force": F, "error": nan})
    return pd.DataFrame(rows)


def rig_table(thickness: float = 66e-6, angle: float = pi / 2) -> pd.DataFrame:
    """Compare the load cell of the laboratory winder with the theories, 15 rows.

    Columns, all in N/m: P, T_in, and WOT - T_in as ``measured``, by the ``estimate`` (183) on the
    nip alone and by the ``solved`` model, the web on half a turn of the drum and led off the roll
    at ``angle``.
    """
    rows = []
    for point in measured_tensions().itertuples():
        T_in = point.web_tension
        problem = newsprint_nip(
            nip_load=point.nip_load, web_tension=T_in, **{"web.thickness": thickness}
        )
        wrapped = solved(problem.replace(roll_wrap=angle, drum_wrap=pi), nodes=NODES)
        estimate = wound_on_tension_estimate(solved(problem, nodes=NODES), angle)
        values = (point.measured, estimate, wrapped.wound_on_tension)
        rows.append((point.nip_load, T_in, *(value - T_in for value in values)))
    names = ("nip_load", "web_tension", "measured", "estimate", "solved")
    return pd.DataFrame(rows, columns=names)


def rig_misses(table: pd.DataFrame) -> tuple[float, float]:
    """Return the RMS of estimate and solved model against the measurements [N/m]."""
    estimate, solved = (table[name] - table["measured"] for name in ("estimate", "solved"))
    return rms(estimate.to_numpy()), rms(solved.to_numpy())


def trailing_edge(result: wo.NipResult) -> tuple[float, float]:
    """Return v+ and the roll's strain (far side subtracted) next to the trailing edge."""
    k = result.in_nip.stop
    return float(result.roll_slip[k]), float(result.roll_strain[k] - result.roll_strain[-1])


# sec. 4.9 tells four cases by the signs of v+ and of the roll's strain at the trailing edge, the
# latter less that on the far side; the first, both negative, is missing: no nip was found to be so
CASES = {
    "2: web faster, roll compressed": paper_nip(),
    "3: web slower, roll stretched": paper_nip(winding_force=456.0, **{"roll.material.shear": 1e6}),
    "4: web faster, roll stretched": paper_nip(
        nip_load=5000.0, winding_force=1800.0, roll_friction=0.1, **{"roll.material.shear": 2e6}
    ),
    "web sticks at once": paper_nip(
        nip_load=5000.0, winding_force=1800.0, roll_friction=0.1, **{"roll.material.shear": 1e6}
    ),
}

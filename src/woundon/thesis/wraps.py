"""Thesis sec. 4.9 and ch. 5 on the solved wrap: what holding the web at the trailing edge errs by.

The thesis confines its solution to the nip: the web is held to the roll from the trailing edge on
(97).  Here that is compared with the web wrapped on the roll and held half a turn away (96), over
nip load and winding force, and on the laboratory winder, where the web leaves the roll after a
quarter turn.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from math import pi

import numpy as np

from ..errors import NoSteadyState, ValidityWarning
from ..nip import solve_nip
from ..problems import NipProblem
from ..surface import rig_tension
from ..wrap import WrappedNipResult, solve_wrapped_nip
from .cases import measured_tensions, newsprint_nip, paper_nip
from .frame import Table
from .table4 import rms

__all__ = ["CASES", "error_map", "pinning_error", "rig_misses", "rig_table", "trailing_edge"]

NODES = 65


def pinning_error(problem: NipProblem) -> Table:
    """Compare the nip alone with the wrapped one, one row.

    Columns: P, F, NIT alone, NIT and WOT - T_in wrapped [N/m], slip angle [rad], and the relative
    error of the wound-on tension, > 0 where the nip alone gives too much.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        alone = solve_nip(problem, nodes=NODES)
        wrapped = solve_wrapped_nip(problem, nodes=NODES)
    return Table.of(
        {
            "nip_load [N/m]": [problem.nip_load],
            "winding_force [N/m]": [problem.winding_force],
            "alone [N/m]": [alone.nip_induced_tension],
            "nip_induced_tension [N/m]": [wrapped.nip_induced_tension],
            "added [N/m]": [wrapped.wound_on_tension - problem.web_tension],
            "slip_angle [rad]": [wrapped.slip_angle],
            "error [1]": [alone.wound_on_tension / wrapped.wound_on_tension - 1],
        }
    )


def error_map(base: NipProblem, loads: Iterable[float], shares: Iterable[float]) -> Table:
    """Return :func:`pinning_error` over nip loads and winding forces, load by load.

    Parameters
    ----------
    base : NipProblem
    loads : iterable of float
        P [N/m].
    shares : iterable of float
        F/(mu- P).  Where it leaves the web slack, all but P and F is nan.
    """
    shares = tuple(shares)
    rows: list[Table] = []
    for P in loads:
        for share in shares:
            F = share * base.drum_friction * P
            problem = base.replace(nip_load=P, winding_force=F)
            try:
                made = pinning_error(problem)
            except NoSteadyState:
                nan = [float("nan")] * (len(rows[0].header) - 2)
                made = Table(rows[0].header, np.array([[P, F, *nan]]))
            rows.append(made)
    return Table(rows[0].header, np.vstack([row.rows for row in rows]))


def rig_table(thickness: float = 66e-6, angle: float = pi / 2) -> Table:
    """Compare the load cell of the laboratory winder with the theories, 15 rows.

    Columns, all in N/m: P, T_in, and WOT - T_in as measured, by the estimate (183) on the nip alone
    and by the solved model, the web on half a turn of the drum and led off the roll at ``angle``.
    """
    rows = []
    for point in measured_tensions():
        P, T_in = point.nip_load, point.web_tension
        changes = {"nip_load": P, "web_tension": T_in, "web.thickness": thickness}
        problem = newsprint_nip().replace(**changes)
        wrapped = solve_wrapped_nip(problem, roll_wrap=angle, drum_wrap=pi, nodes=NODES)
        estimate = rig_tension(solve_nip(problem, nodes=NODES), angle)
        values = (point.measured, estimate, wrapped.wound_on_tension)
        rows.append([P, T_in, *(value - T_in for value in values)])
    names = ("nip_load", "web_tension", "measured", "estimate", "solved")
    return Table(tuple(f"{name} [N/m]" for name in names), np.array(rows))


def rig_misses(table: Table) -> tuple[float, float]:
    """Return the RMS of estimate and solved model against the measurements [N/m]."""
    measured = table["measured"]
    return rms(table["estimate"] - measured), rms(table["solved"] - measured)


def trailing_edge(result: WrappedNipResult) -> tuple[float, float]:
    """Return v+ and the roll's strain less that on the far side, just behind the trailing edge."""
    k = result.in_nip.stop
    return float(result.roll_slip[k]), float(result.roll_strain[k] - result.roll_strain[-1])


# sec. 4.9 tells four cases by the signs of v+ and of the roll's strain at the trailing edge, the
# latter less that on the far side; the first, both negative, is missing: no nip was found to be so
CASES = {
    "2: web faster, roll compressed": paper_nip(),
    "3: web slower, roll stretched": paper_nip(winding_force=456.0, **{"roll.material.shear": 1e6}),
    "4: web faster, roll stretched": paper_nip(
        nip_load=5000.0,
        winding_force=1800.0,
        roll_friction=0.1,
        **{"roll.material.shear": 2e6},
    ),
    "web sticks at once": paper_nip(
        nip_load=5000.0,
        winding_force=1800.0,
        roll_friction=0.1,
        **{"roll.material.shear": 1e6},
    ),
}

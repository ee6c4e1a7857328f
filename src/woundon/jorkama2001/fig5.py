"""Thesis Fig. 5, sec. 1.2: tangential traction of two similar cylinders, rolling and static.

The text drives a cylinder of 0.5 m diameter by 21 000 Nm/m.  That is a tangential load of 84 kN/m
and more than friction holds; it is read as a tangential load of 21 kN/m.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import xarray as xr

import woundon as wo

from .exhibits import Exhibit
from .nips import dataset, joined
from .panels import curve_panels
from .verdicts import Range, Verdict, at_least, at_most, verdict, whether
from .zones import Run, runs

__all__ = ["exhibits"]

LOAD, FRICTION, RADIUS = 89e3, 0.5, 0.25  # [N/m], [1], [m]
TORQUE, TANGENTIAL_LOAD = 21e3, 21e3  # as printed [Nm/m], as read [N/m]
# The traction leaves the zone boundary with a vertical tangent: its error is of the order h^(1/2).
NODES = 1001


def exhibits(solver: str) -> list[Exhibit]:
    """Solve both contacts; return Fig. 5.  The thesis's procedure is for winding nips only."""
    rolling, static = _pair("rolling"), _pair("static")
    data = joined("rolling [1]", {1.0: _along(rolling), 0.0: _along(static)})
    verdicts = [*_pattern(rolling, static), *_difference(rolling, static), *_basics()]
    names = ("rolling (Carter)", "static (Cattaneo)")
    shown = curve_panels(data, ["traction"], "x", "rolling", names=names)
    return [Exhibit("fig5", data, verdicts, shown, one_solver=True)]


def _pair(motion: Literal["rolling", "static"]) -> wo.RollerResult:
    """Solve two cylinders of steel."""
    steel = wo.HalfPlane(radius=RADIUS, material=wo.material("steel"))
    problem = wo.RollerProblem(
        upper=steel,
        lower=steel,
        load=LOAD,
        friction=FRICTION,
        tangential_load=TANGENTIAL_LOAD,
        motion=motion,
    )
    return wo.solve(problem, nodes=NODES)


def _along(r: wo.RollerResult) -> xr.Dataset:
    """Return the arrays along the contact as a dataset."""
    columns = {
        "x [m]": r.x,
        "pressure [Pa]": r.pressure,
        "traction [Pa]": r.traction,
        "zone [1]": r.zone,
    }
    return dataset("node", columns)


def _slips(r: wo.RollerResult) -> list[bool]:
    """Return for each zone, from the leading edge, whether it slips."""
    return [run.zone != 0 for run in runs(r.x, r.zone)]


def _stick(r: wo.RollerResult) -> Run:
    """Return the first stick zone."""
    return next(run for run in runs(r.x, r.zone) if run.zone == 0)


def _pattern(rolling: wo.RollerResult, static: wo.RollerResult) -> list[Verdict]:
    """Test the statements about the stick and slip zones."""
    q, width = static.traction, 2 * static.half_width
    mirrored = np.interp(-static.x, static.x, q)
    held, stick = _stick(static), _stick(rolling)
    peaks = [static.x[half][np.argmax(q[half])] for half in (static.x < 0, static.x > 0)]
    top = rolling.x[np.argmax(rolling.traction)]
    return [
        verdict(
            "the static traction is symmetric",
            100 * np.max(np.abs(q - mirrored)) / q.max(),
            at_most(1.0, "%"),
            note="largest difference of both halves, over the peak",
        ),
        whether(
            "with slip at the leading and at the trailing edge, stick between",
            _slips(static) == [True, False, True],
        ),
        verdict(
            "where it sticks between the two maxima: distance of its boundaries from them",
            100 * max(abs(held.left - peaks[0]), abs(held.right - peaks[1])) / width,
            at_most(1.0, "% of the width"),
            note=f"stick over {100 * held.length / width:.0f} %",
        ),
        whether(
            "rolling, it sticks from the leading edge on and slips downstream",
            _slips(rolling) == [False, True],
        ),
        verdict(
            "up to the maximum of the traction: distance from the end of stick",
            100 * abs(stick.right - top) / width,
            at_most(1.0, "% of the width"),
        ),
        verdict(
            "and that over a wide range",
            100 * stick.length / width,
            at_least(50.0, "% of the width"),
        ),
    ]


def _difference(rolling: wo.RollerResult, static: wo.RollerResult) -> list[Verdict]:
    """Test the statements about rolling and static contact."""
    x, peak = rolling.x, rolling.traction.max()
    apart = np.abs(rolling.traction - np.interp(x, static.x, static.traction))
    alike = x[-1] - x[np.flatnonzero(apart >= 0.01 * peak)[-1]]  # length up to the trailing edge
    exact = [
        np.max(np.abs(r.traction - theory.traction(r.x))) / r.traction.max()
        for r, theory in (
            (rolling, wo.theories.carter(rolling.problem)),
            (static, wo.theories.cattaneo(static.problem)),
        )
    ]
    return [
        verdict(
            "both tractions are the same on a short stretch at the trailing edge",
            100 * alike / (2 * rolling.half_width),
            Range(1.0, 30.0, "% of the width"),
            note="within 1 % of the peak",
        ),
        verdict(
            "elsewhere they are strikingly different",
            100 * apart.max() / peak,
            at_least(25.0, "%"),
            note="largest difference over the peak",
        ),
        verdict(
            "they are Carter's and Cattaneo's",
            100 * max(exact),
            at_most(1.0, "%"),
            note="largest difference from the closed forms over the peak, at the boundaries of the "
            "stick zone, where the traction has a vertical tangent",
        ),
        verdict(
            "the torque of 21 000 Nm/m can be carried: tangential load over mu P",
            TORQUE / RADIUS / (FRICTION * LOAD),
            at_most(1.0),
            note="by the radius of 0.25 m it is 84 kN/m; here 21 kN/m are taken.  2100 Nm/m, which "
            "is 8.4 kN/m, would show the same pattern with nine tenths of the width in stick",
        ),
    ]


def _basics() -> list[Verdict]:
    """Test what the section says of free rolling, with a steel cylinder on a rigid one."""
    steel = wo.HalfPlane(radius=RADIUS, material=wo.material("steel"))
    rigid = wo.Rigid(radius=RADIUS)
    problem = wo.RollerProblem(upper=steel, lower=rigid, load=LOAD, friction=0.1)
    free = wo.solve(problem, nodes=NODES)
    contact = wo.theories.hertz(free.problem)
    ellipse = contact.peak_pressure * np.sqrt(np.maximum(0, 1 - (free.x / contact.half_width) ** 2))
    apart = np.trapezoid((free.pressure - ellipse) ** 2, free.x)
    wider = 100 * (free.half_width / contact.half_width - 1)
    return [
        whether(
            "a rigid and a deformable cylinder in free rolling slip at some points and stick at "
            "others",
            set(_slips(free)) == {False, True},
            note="steel on rigid, mu = 0.1",
        ),
        verdict(
            "and differ in speed (creep): creepage over Bentall and Johnson's for mu -> 0",
            free.creepage / wo.theories.bentall_johnson_frictionless(free.problem),
            Range(0.5, 1.0),
            note="friction takes some of it away",
        ),
        verdict(
            "tractions act little on the pressure, which stays nearly Hertz's: root mean square "
            "of the difference over that of the pressure",
            100 * np.sqrt(apart / np.trapezoid(ellipse**2, free.x)),
            at_most(5.0, "%"),
            note=f"in that free rolling; the half width differs by {wider:.1f} %",
        ),
    ]

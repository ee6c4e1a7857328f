"""Thesis Fig. 5, sec. 1.2: tangential traction of two similar cylinders, rolling and static.

The text drives a cylinder of 0.5 m diameter by 21 000 Nm/m.  That is a tangential load of 84 kN/m
and more than friction holds; it is read as a tangential load of 21 kN/m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ..bodies import HalfPlane, Rigid
from ..materials import material
from ..problems import RollerProblem
from ..results import RollerResult
from ..rollers import solve_rollers
from ..theories import bentall_johnson_frictionless, carter, cattaneo, hertz
from ..zones import zone_runs
from .frame import Figure, Scheme, Table, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

LOAD, FRICTION, RADIUS = 89e3, 0.5, 0.25  # [N/m], [1], [m]
TORQUE, TANGENTIAL_LOAD = 21e3, 21e3  # as printed [Nm/m], as read [N/m]
NODES = 201


def _steel_pair(motion: Literal["rolling", "static"]) -> RollerProblem:
    steel = HalfPlane(radius=RADIUS, material=material("steel"))
    return RollerProblem(
        upper=steel, lower=steel, load=LOAD, friction=FRICTION,
        tangential_load=TANGENTIAL_LOAD, motion=motion,
    )  # fmt: skip


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve both contacts; return Fig. 5.  The thesis's scheme is for winding nips only."""
    rolling = solve_rollers(_steel_pair("rolling"), nodes=NODES)
    static = solve_rollers(_steel_pair("static"), nodes=NODES)
    table = _data(rolling, static)
    verdicts = (*_pattern(rolling, static), *_difference(rolling, static), *_basics())
    title = "Tangential traction of two similar cylinders, rolling and static"
    draw = lambda: _draw(rolling, static)  # noqa: E731
    return (Figure("fig5", title, scheme, table, verdicts, draw, one_scheme=True),)


def _data(rolling: RollerResult, static: RollerResult) -> Table:
    blocks = [
        Table.of(
            {
                "rolling [1]": np.full(r.x.size, float(moves)),
                "x [m]": r.x,
                "pressure [Pa]": r.pressure,
                "traction [Pa]": r.traction,
                "zone [1]": r.zone,
            }
        )
        for r, moves in ((rolling, True), (static, False))
    ]
    return blocks[0].stacked(blocks[1])


def _zones(r: RollerResult) -> list[int]:
    return [int(zone != 0) for zone, *_ in zone_runs(r.x, r.zone)]


def _sticks(r: RollerResult) -> tuple[float, float]:
    """Return from where to where it sticks [m]."""
    return next((left, right) for zone, left, right in zone_runs(r.x, r.zone) if zone == 0)


def _pattern(rolling: RollerResult, static: RollerResult) -> tuple[Verdict, ...]:
    q, width = static.traction, 2 * static.half_width
    mirrored = np.interp(-static.x, static.x, q)
    left, right = _sticks(static)
    peaks = [float(static.x[half][np.argmax(q[half])]) for half in (static.x < 0, static.x > 0)]
    stick = _sticks(rolling)
    top = float(rolling.x[np.argmax(rolling.traction)])
    return (
        Verdict(
            "the static traction is symmetric", 100 * float(np.max(np.abs(q - mirrored)) / q.max()),
            high=1.0, unit="%", note="largest difference of both halves, over the peak",
        ),
        Verdict.whether(
            "with slip at the leading and at the trailing edge, stick between",
            _zones(static) == [1, 0, 1],
        ),
        Verdict(
            "where it sticks between the two maxima: distance of its borders from them",
            100 * max(abs(left - peaks[0]), abs(right - peaks[1])) / width, high=1.0,
            unit="% of the width", note=f"stick over {100 * (right - left) / width:.0f} %",
        ),
        Verdict.whether(
            "rolling, it sticks from the leading edge on and slips behind",
            _zones(rolling) == [0, 1],
        ),
        Verdict(
            "up to the maximum of the traction: distance from the end of stick",
            100 * abs(stick[1] - top) / width, high=1.0, unit="% of the width",
        ),
        Verdict(
            "and that over a wide range", 100 * (stick[1] - stick[0]) / width, 50.0,
            unit="% of the width",
        ),
    )  # fmt: skip


def _difference(rolling: RollerResult, static: RollerResult) -> tuple[Verdict, ...]:
    x = rolling.x
    apart = np.abs(rolling.traction - np.interp(x, static.x, static.traction))
    same = apart < 0.01 * rolling.traction.max()
    alike = x[-1] - x[np.flatnonzero(~same)[-1]]
    exact = [
        float(np.max(np.abs(r.traction - theory.traction(r.x))) / r.traction.max())
        for r, theory in ((rolling, carter(rolling.problem)), (static, cattaneo(static.problem)))
    ]
    return (
        Verdict(
            "both tractions are the same on a short stretch at the trailing edge",
            100 * float(alike) / (2 * rolling.half_width), 1.0, 30.0, "% of the width",
            "within 1 % of the peak",
        ),
        Verdict(
            "elsewhere they are strikingly different",
            100 * float(apart.max() / rolling.traction.max()), 25.0, unit="%",
            note="largest difference over the peak",
        ),
        Verdict(
            "they are Carter's and Cattaneo's", 100 * max(exact), high=1.0, unit="%",
            note="largest difference from the closed forms over the peak, at the stick's borders, "
            "where the traction has a vertical tangent",
        ),
        Verdict(
            "the torque of 21 000 Nm/m can be carried: tangential load over mu P",
            TORQUE / RADIUS / (FRICTION * LOAD), high=1.0,
            note="by the radius of 0.25 m it is 84 kN/m; here 21 kN/m are taken.  2100 Nm/m, which "
            "is 8.4 kN/m, would show the same pattern with nine tenths of the width in stick",
        ),
    )  # fmt: skip


def _basics() -> tuple[Verdict, ...]:
    """Test what the section says of free rolling, with a steel cylinder on a rigid one."""
    steel = HalfPlane(radius=RADIUS, material=material("steel"))
    free = solve_rollers(
        RollerProblem(upper=steel, lower=Rigid(radius=RADIUS), load=LOAD, friction=0.1), nodes=NODES
    )
    contact = hertz(free.problem)
    ellipse = contact.peak_pressure * np.sqrt(np.maximum(0, 1 - (free.x / contact.half_width) ** 2))
    apart = np.trapezoid((free.pressure - ellipse) ** 2, free.x)
    off = float(np.sqrt(apart / np.trapezoid(ellipse**2, free.x)))
    wider = 100 * (free.half_width / contact.half_width - 1)
    creep = float(free.creepage / bentall_johnson_frictionless(free.problem))
    return (
        Verdict.whether(
            "a rigid and a deformable cylinder in free rolling slip at some points and stick at "
            "others", set(_zones(free)) == {0, 1}, "steel on rigid, mu = 0.1",
        ),
        Verdict(
            "and differ in speed (creep): creepage over Bentall and Johnson's for mu -> 0",
            creep, 0.5, 1.0, note="friction takes some of it away",
        ),
        Verdict(
            "tractions act little on the pressure, which stays nearly Hertz's: root mean square "
            "of the difference over that of the pressure", 100 * off, high=5.0, unit="%",
            note=f"in that free rolling; the half width differs by {wider:.1f} %",
        ),
    )  # fmt: skip


def _draw(rolling: RollerResult, static: RollerResult) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 1, (6.0, 4.0))
    (axes,) = figure.axes
    drawing.plain(axes, rolling.x * 1e3, rolling.traction / 1e6, 0, "rolling (Carter)")
    drawing.plain(axes, static.x * 1e3, static.traction / 1e6, 1, "static (Cattaneo)")
    axes.set_xlabel("Position along the nip $x$ [mm]")
    axes.set_ylabel("Tangential traction $q$ [MPa]")
    drawing.shared_legend(figure, 2)
    return figure

"""The contact drawn to scale: both bodies with the web, and the nip enlarged.

Between the edges of the nip the surfaces lie on each other, as round as the stiffer body; outside,
the gap is that of Hertz.  The directions are those of the page: the web runs to the right, between
the roll above and the drum below.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from ..nip.result import NipResult
from ..nip.roller_result import RollerResult
from ..problems.bodies import Body
from ..problems.nip import NipProblem
from ..problems.paths import quantity_of_field
from ..problems.rollers import RollerProblem
from ..quantities import Quantity
from ..results import Result, zone_runs
from .figures import Picture, style, text_of, zone_look
from .panels import round_at_most
from .report_parts import quantity_of, zone_strips

__all__ = ["scale_drawing"]

Array = np.ndarray
Contact = NipResult | RollerResult

NAMES = {"roll": "wound roll", "drum": "winding drum", "upper": "upper", "lower": "lower"}
FILL = ("#DCEBF5", "#FBE6D8")  # of the upper and the lower body
LINE, WEB = "#555555", "#222222"
WIDTH, HEIGHT, WHOLE = 7.3, 1.75, 2.2  # inches; the last is the width of the whole bodies
REACH = 1.25  # half widths of the nip that the enlarged part shows
BAND = 0.055  # height of a zone, of the width of the enlarged part
LEAST_WEB = 0.012  # a thinner web is drawn as thick as this, of the same width
ARC = 60  # points of the web on a body


def scale_drawing(result: Result) -> Figure | None:
    """Return the drawing of the contact of two bodies; None for other kinds of results."""
    if not isinstance(result, NipResult | RollerResult):
        return None
    with style():
        figure = Picture.new((WIDTH, HEIGHT), registered=False)
        ratios = (WHOLE, WIDTH - WHOLE)
        whole, nip = figure.subplots(1, 2, gridspec_kw={"width_ratios": ratios})
        for axes in (whole, nip):
            axes.set_aspect("equal")
            axes.axis("off")
        _draw_bodies(whole, result)
        _draw_nip(nip, result)
    return figure


# ---- both bodies --------------------------------------------------------------------------------


def _draw_bodies(axes: Axes, result: Contact) -> None:
    """Draw both bodies with their layers and cores, and the web on them."""
    problem = result.problem
    upper, lower = problem.bodies
    for name, body, side, fill in zip(problem.pair, problem.bodies, (1, -1), FILL, strict=True):
        centre = (0.0, side * body.radius)
        for radius in _radii(body):
            axes.add_patch(_circle(centre, radius, fill, hatch="//////" if body.rigid else ""))
        if core := _core_radius(body):
            axes.add_patch(_circle(centre, core, "white"))
        axes.plot(*centre, "+", color=LINE, markersize=5, markeredgewidth=0.7)
        size = text_of(quantity_of_field(problem, f"{name}.radius"), body.radius)
        text = f"{NAMES[name]}\n$R$ {size}{', rigid' * body.rigid}"
        axes.annotate(text, (1.1 * body.radius, centre[1]), va="center", fontsize=7)
    if isinstance(problem, NipProblem):
        axes.plot(*_web_path(upper.radius, lower.radius, problem), color=WEB, linewidth=1.3)
    widest = max(upper.radius, lower.radius)
    # the contact is at the origin; on the right there is room for the texts
    axes.set_xlim(-1.5 * widest, 2.6 * widest)
    axes.set_ylim(-2.06 * lower.radius, 2.06 * upper.radius)


def _circle(centre: tuple[float, float], radius: float, fill: str, hatch: str = "") -> Circle:
    """Return a circle with an outline, filled with a colour and a hatch."""
    return Circle(centre, radius, facecolor=fill, edgecolor=LINE, linewidth=0.7, hatch=hatch)


def _radii(body: Body) -> list[float]:
    """Return the outer radii of a body's layers, the outermost first."""
    thicknesses = [layer.thickness for layer in getattr(body, "layers", ())]
    # the innermost layer ends at the core
    return list(body.radius - np.concatenate([[0.0], np.cumsum(thicknesses[:-1])]))


def _core_radius(body: Body) -> float:
    """Return the inner radius of the elastic part of a body; 0 if it has none."""
    return 0.0 if body.rigid else max(0.0, float(body.radius - body.thickness))


def _web_path(roll: float, drum: float, problem: NipProblem) -> tuple[Array, Array]:
    """Return x and y of the web's path: straight onto the drum, through the nip, around the roll.

    Two (n,) arrays [m]; ``roll`` and ``drum`` are radii [m], and the nip is at the origin.
    """
    on_drum = np.linspace(problem.drum_wrap, 0.0, ARC)
    on_roll = np.linspace(0.0, problem.roll_wrap, ARC)
    x = np.concatenate([-drum * np.sin(on_drum), roll * np.sin(on_roll)])
    y = np.concatenate([-drum * (1 - np.cos(on_drum)), roll * (1 - np.cos(on_roll))])
    length = 1.4 * max(roll, drum) - drum * np.sin(min(problem.drum_wrap, pi / 2))
    start = problem.drum_wrap  # the straight web is tangential to the drum there
    x = np.concatenate([[x[0] - length * np.cos(start)], x])
    y = np.concatenate([[y[0] - length * np.sin(start)], y])
    if not problem.roll_wrap:  # the web runs on straight
        x, y = np.append(x, 1.4 * roll), np.append(y, 0.0)
    return x, y


# ---- the nip ------------------------------------------------------------------------------------


def _draw_nip(axes: Axes, result: Contact) -> None:
    """Draw the nip with its zones, its width and a scale bar."""
    problem = result.problem
    upper, lower = problem.bodies
    a = float(result.half_width)
    reach = REACH * a
    height = reach * HEIGHT / (WIDTH - WHOLE)  # half of it
    web = problem.web.thickness if isinstance(problem, NipProblem) else 0.0
    # thickness in the drawing
    drawn = max(web, LEAST_WEB * 2 * reach) if web else 0.0
    x = np.linspace(-reach, reach, 201)
    above, below = _surfaces(x, a, problem, drawn)
    for surface, side, body, fill in ((above, 1, upper, FILL[0]), (below, -1, lower, FILL[1])):
        outline = np.column_stack([x, surface])
        corners = [[reach, side * height], [-reach, side * height]]
        hatch = "////" if body.rigid else ""
        face = Polygon([*outline, *corners], facecolor=fill, edgecolor="none", hatch=hatch)
        axes.add_patch(face)
        axes.plot(x, surface, color=LINE, linewidth=0.7)
    if web:
        axes.fill_between(x, below, above, color=WEB, linewidth=0)
    _draw_zones(axes, result, x, above, below, BAND * 2 * reach)
    _draw_dimensions(axes, quantity_of(result, "nip_width"), a, reach, height)
    if web:
        thicker = " (drawn thicker)" if drawn > web else ""
        text = f"web {text_of(quantity_of_field(problem, 'web.thickness'), web)}{thicker}"
        axes.annotate(text, (-0.97 * reach, -0.93 * height), fontsize=7)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-height, height)


def _surfaces(
    x: Array, a: float, problem: NipProblem | RollerProblem, web: float
) -> tuple[Array, Array]:
    """Return the heights of the upper and the lower surface at the positions x, (n,) each [m].

    ``a`` is the half width of the nip, ``web`` the thickness with which the web is drawn [m].
    """
    upper, lower = problem.bodies
    curvatures = [1 / body.radius for body in (upper, lower)]
    # 1 where the rigid upper body keeps its roundness, 0 where it is flattened to the lower one
    share = 0.5 if upper.rigid == lower.rigid else float(upper.rigid)
    contact = (share * curvatures[0] - (1 - share) * curvatures[1]) * x**2 / 2
    t = np.maximum(np.abs(x) / a, 1.0)  # Hertz's gap outside the contact; zero inside, where t = 1
    gap = a * a * sum(curvatures) / 2 * (t * np.sqrt(t * t - 1) - np.arccosh(t))
    return contact + (1 - share) * gap + web / 2, contact - share * gap - web / 2


def _draw_zones(
    axes: Axes, result: Contact, x: Array, above: Array, below: Array, band: float
) -> None:
    """Draw the zones of each face as a band along its surface.

    Parameters
    ----------
    axes : Axes
    result : NipResult or RollerResult
    x, above, below : (n,) arrays
        Positions, and heights of the upper and the lower surface [m].
    band : float
        Height of a band [m].
    """
    strips = zone_strips(result)
    assert strips is not None
    faces: Sequence[tuple[Array, int]] = ((above, 1), (below, -1))
    # rollers have one face, which is drawn on the upper one
    for (surface, side), zones in zip(faces, strips.faces.values(), strict=False):
        for zone, first, last in zone_runs(strips.x, zones):
            ends = np.linspace(first, last, 9)
            inner = np.interp(ends, x, surface)
            outline = [*zip(ends, inner, strict=True)]
            outline += [*zip(ends[::-1], inner[::-1] + side * band, strict=True)]
            axes.add_patch(Polygon(outline, **zone_look(zone), linewidth=0.5))


def _draw_dimensions(axes: Axes, width: Quantity, a: float, reach: float, height: float) -> None:
    """Draw the width of the nip, and a bar of a round length in the same unit.

    Parameters
    ----------
    axes : Axes
    width : Quantity
        Of the width of the nip: its unit is that of both lengths.
    a, reach, height : float
        Half widths of the nip and of the drawing, half height of the drawing [m].
    """
    arrow = {"arrowstyle": "<->", "color": LINE, "linewidth": 0.7, "shrinkA": 0, "shrinkB": 0}
    level = 0.62 * height
    axes.annotate("", (-a, level), (a, level), arrowprops=arrow)
    axes.vlines([-a, a], 0.3 * height, 0.75 * height, color=LINE, linewidth=0.5)
    centred: Any = {"ha": "center", "fontsize": 7, "textcoords": "offset points"}
    text = f"$2a$ = {text_of(width, 2 * a)}"
    axes.annotate(text, (0, level), (0, 2), va="bottom", **centred)
    length = round_at_most(0.4 * width.shown(reach)) / width.shown(1.0)
    end, level = 0.95 * reach, -0.72 * height
    axes.plot([end - length, end], [level, level], "|-", color=LINE, linewidth=0.8)
    at = (end - length / 2, level)
    axes.annotate(text_of(width, length), at, (0, -3), va="top", **centred)

"""The panels of a result that the page draws: curves, bounds, zones and marks as plain data.

They correspond to the panels of the figures, but the page draws them while a slider moves.  For
kinds that are not named below, arrays are drawn over the first one.

A panel is a dict of

- ``name``, ``column`` (panels of one column share their x axis), ``x``, ``y``, ``right``: the
  axes, each ``{"label", "quantity"}``; x also ``log`` and ``range``, y also ``floor``
- ``curves``: ``{"name", "symbol", "label", "role", "dash", "side", "x", "y"}``
- ``areas``: ``{"label", "shade", "x", "low", "high"}``, shaded behind them
- ``marks``: ``{"along", "value", "label"}``, straight lines parallel to the axis ``along``, at
  ``value`` of the other axis
- ``strips``: ``{"label", "runs": [[zone, from, to], ...]}`` in place of curves, and ``words``

Numbers are in SI units; None stands for nan and infinity.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import kinds, quantities
from ..problems.paths import field_quantity
from ..quantities import Quantity
from ..report.report_parts import friction_bounds, zone_strips
from ..results import Result, zone_runs
from .input_forms import quantity_schema

__all__ = ["panels_of"]

Array = np.ndarray
Panel = dict[str, Any]
DIGITS = 8  # significant ones: a curve is drawn, the outputs are exact
POINTS = 241  # of a curve that is known between its nodes too


def panels_of(result: Result) -> list[Panel]:
    """Return the panels of a result of any kind."""
    panels = _PANELS.get(kinds.of(result).name, _any_panels)(result)
    for panel in panels:
        for axis in filter(None, (panel["x"], panel["y"], panel.get("right"))):
            axis["quantity"] = dict(quantity_schema(axis["quantity"]))
    return panels


def _numbers(values: Array) -> list[float | None]:
    """Return rounded values; None where not finite."""
    v = np.asarray(values, dtype=float)
    finite = np.isfinite(v)
    size = np.where(finite & (np.abs(v) > 1e-290), np.abs(v), 1.0)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(size)))
    rounded = (np.round(np.where(finite, v, 0.0) * scale) / scale).tolist()
    return [value if ok else None for value, ok in zip(rounded, finite.tolist(), strict=True)]


def _quantity(result: Any, name: str) -> Quantity:
    """Return the quantity of an output."""
    place = quantities.output(result, name)
    assert place is not None
    assert place.quantity is not None
    return place.quantity


def _curve(
    result: Any,
    name: str,
    label: str,
    role: str,
    *,
    x: Array,
    part: slice = slice(None),
    dash: str = "solid",
    side: str = "left",
    y: Array | None = None,
) -> dict[str, Any]:
    """Return a curve of an output, or of values ``y`` instead."""
    values = getattr(result, name)[part] if y is None else y
    return {
        "name": name,
        "symbol": _quantity(result, name).symbol,
        "label": label,
        "role": role,
        "dash": dash,
        "side": side,
        "x": _numbers(x),
        "y": _numbers(values),
    }


def _axis(label: str, quantity: Quantity, **settings: Any) -> dict[str, Any]:
    return {"label": label, "quantity": quantity, **settings}


def _panel(name: str, column: str, x: Any, y: Any, curves: list[Any], **settings: Any) -> Panel:
    return {"name": name, "column": column, "x": x, "y": y, "curves": curves} | settings


# ---- the nip ------------------------------------------------------------------------------------


def _nip_panels(result: Any) -> list[Panel]:
    """Return the panels of a nip, with those of its air film and its wraps."""
    panels = _panels_in_nip(result)
    if result.air is not None:
        panels.append(_film_panel(result))
    return panels + (_wrap_panels(result) if result.problem.is_wrapped else [])


def _panels_in_nip(result: Any) -> list[Panel]:
    """Return the panels of tractions, zones, slips and pressure in the nip."""
    nip = result.in_nip
    x, slip_x = result.x[nip], result.slip_x[nip]

    def axis(label: str, name: str, **settings: Any) -> dict[str, Any]:
        return _axis(label, _quantity(result, name), **settings)

    tractions = [
        _curve(result, "roll_traction", "on the roll", "roll", x=x, part=nip),
        _curve(result, "drum_traction", "on the drum", "drum", x=x, part=nip, dash="dashed"),
    ]
    slips = [
        _curve(result, "roll_slip", "at the roll", "roll", x=slip_x, part=nip),
        _curve(result, "drum_slip", "at the drum", "drum", x=slip_x, part=nip, dash="dashed"),
        _curve(
            result, "tension", "web tension", "web", x=x, part=nip, dash="dashdot", side="right"
        ),
    ]
    return [
        _panel(
            "tractions",
            "nip",
            _along_the_nip(result),
            axis("Tangential traction", "roll_traction"),
            tractions,
            areas=_bounds(result, nip),
        ),
        _zones(result, _along_the_nip(result), axis("", "roll_zone")),
        _panel(
            "slips",
            "nip",
            _along_the_nip(result),
            axis("Relative slip speed", "roll_slip"),
            slips,
            right=axis("Web tension", "tension"),
        ),
        _panel(
            "pressure",
            "nip",
            _along_the_nip(result),
            axis("Pressure", "drum_pressure", floor=0),
            _pressures(result, x, nip),
        ),
    ]


def _along_the_nip(result: Any) -> dict[str, Any]:
    edge = 1.03 * result.half_width
    return _axis("Position along the nip", _quantity(result, "x"), range=[-edge, edge])


def _film_panel(result: Any) -> Panel:
    """Return the panel of the entrained air between web and roll."""
    film = _curve(
        result,
        "air.thickness",
        "between web and roll",
        "roll",
        x=result.x[result.in_nip],
        y=result.air.thickness,
    )
    return _panel(
        "air_film",
        "nip",
        _along_the_nip(result),
        _axis("Air film", _quantity(result, "air.thickness"), floor=0),
        [film],
    )


def _pressures(result: Any, x: Array, nip: slice) -> list[Any]:
    """Return the curves of the pressure in the nip, on roll and drum."""
    if not result.problem.is_wrapped:
        return [_curve(result, "drum_pressure", "in the nip", "web", x=x, part=nip)]
    return [
        _curve(result, "roll_pressure", "on the roll", "roll", x=x, part=nip),
        _curve(result, "drum_pressure", "on the drum", "drum", x=x, part=nip, dash="dashed"),
    ]


def _bounds(result: Any, nip: slice = slice(None)) -> list[dict[str, Any]]:
    """Return the friction bounds, the wider one first."""
    labels = {"roll_traction": "mu+ p", "drum_traction": "mu- p", "traction": "mu p"}
    bounds = [(labels[name], values[nip]) for name, values in friction_bounds(result).items()]
    bounds.sort(key=lambda bound: -float(np.max(bound[1])))
    return [
        {
            "label": label,
            "shade": shade,
            "x": _numbers(result.x[nip]),
            "low": _numbers(-values),
            "high": _numbers(values),
        }
        for shade, (label, values) in enumerate(bounds)
    ]


def _zones(result: Any, x: Any, y: Any) -> Panel:
    """Return the panel of the stick and slip zones as bars."""
    strips = zone_strips(result)
    assert strips is not None
    runs = [
        {
            "label": face,
            "runs": [
                [zone, *_numbers(np.array(ends))] for zone, *ends in zone_runs(strips.x, zones)
            ],
        }
        for face, zones in strips.faces.items()
    ]
    words = [strips.slower, "stick", strips.faster]
    return _panel("zones", "nip", x, y, [], strips=runs, words=words)


def _wrap_panels(result: Any) -> list[Panel]:
    """Return the panels of tension and pressure on the wraps, over the angle from the nip."""
    problem = result.without_air
    a, nip, angle = result.half_width, result.in_nip, _quantity(result, "slip_angle")
    tensions, pressures = [], []
    faces = [
        (
            "roll",
            slice(nip.stop, None),
            result.x - a,
            result.roll_pressure,
            problem.friction_on_wrap,
        ),
        ("drum", slice(0, nip.start), -a - result.x, result.drum_pressure, problem.drum_friction),
    ]
    for face, part, distance, pressure, mu in faces:
        if not getattr(problem, f"{face}_wrap"):
            continue
        dash = "dashdot" if face == "roll" else "dotted"
        line = "solid" if face == "roll" else "dashed"
        theta = distance[part] / getattr(problem, face).radius
        name = "roll_pressure" if face == "roll" else "drum_pressure"
        friction_pressure = np.abs(getattr(result, f"{face}_traction")[part]) / mu
        tensions.append(
            _curve(result, "tension", f"on the {face}", "web", x=theta, part=part, dash=dash)
        )
        pressures += [
            _curve(result, name, f"on the {face}", face, x=theta, y=pressure[part], dash=line),
            _curve(
                result,
                f"{face}_traction",
                f"from friction on the {face}",
                face,
                x=theta,
                y=friction_pressure,
                dash="dotted",
            ),
        ]
    words = "Angle from the edge of the nip"
    panels = [
        ("wrap_tension", "Web tension", "tension", tensions, _wrap_marks(result)),
        ("wrap_pressure", "Pressure", "drum_pressure", pressures, []),
    ]
    return [
        _panel(
            name,
            "wraps",
            _axis(words, angle, log=True),
            _axis(label, _quantity(result, output)),
            curves,
            marks=marks,
        )
        for name, label, output, curves, marks in panels
    ]


def _wrap_marks(result: Any) -> list[dict[str, Any]]:
    """Return the marks at the wound-on tension and at the end of the slip zone."""
    if not result.problem.roll_wrap:
        return []
    marks = [{"along": "x", "value": result.wound_on_tension, "label": "wound-on tension"}]
    if result.slip_angle:
        marks.append({"along": "y", "value": result.slip_angle, "label": "end of slip"})
    return marks


# ---- rollers, rolls, other kinds -------------------------------------------------------------


def _roller_panels(result: Any) -> list[Panel]:
    """Return the panels of tractions, zones and slip of two rollers."""
    x, slip_x, edge = result.x, result.slip_x, 1.03 * result.half_width
    rolling = result.problem.motion == "rolling"

    def along() -> dict[str, Any]:
        return _axis("Position along the contact", _quantity(result, "x"), range=[-edge, edge])

    pressure = _quantity(result, "pressure")
    return [
        _panel(
            "tractions",
            "nip",
            _along_the_nip(result),
            _axis("Pressure, traction", pressure),
            [
                _curve(result, "pressure", "pressure", "web", x=x, dash="dashdot"),
                _curve(result, "traction", "on the upper roller", "roll", x=x),
            ],
            areas=_bounds(result),
        ),
        _zones(result, _along_the_nip(result), _axis("", _quantity(result, "zone"))),
        _panel(
            "slip",
            "nip",
            _along_the_nip(result),
            _axis("Relative slip speed" if rolling else "Slip", _quantity(result, "slip")),
            [_curve(result, "slip", "lower surface faster", "roll", x=slip_x)],
        ),
    ]


def _roll_panels(result: Any) -> list[Panel]:
    """Return the panels of a wound roll over the radius."""
    radius, curve = _quantity(result, "radius"), result.problem.tension_curve
    r = np.linspace(result.radius[0], result.radius[-1], POINTS)
    values = result.at_radius(r)
    stages = np.unique(np.concatenate([result.stage_radius, curve.kinks]))
    wound_on_tension = field_quantity(result.problem, "wound_on_tension")
    assert wound_on_tension is not None
    tension = {
        "name": "wound_on_tension",
        "symbol": wound_on_tension.symbol,
        "label": "",
        "role": "web",
        "dash": "solid",
        "side": "left",
        "x": _numbers(stages),
        "y": _numbers(curve.at(stages) * result.problem.web_thickness),
    }
    rows = [
        (
            "pressure",
            "Pressure",
            {"floor": 0},
            _curve(result, "pressure", "", "roll", x=r, y=values["pressure"]),
        ),
        (
            "hoop_stress",
            "Hoop stress",
            {},
            _curve(result, "hoop_stress", "", "drum", x=r, y=values["hoop_stress"]),
        ),
        (
            "radial_modulus",
            "Hardness",
            {"floor": 0},
            _curve(result, "radial_modulus", "", "roll", x=result.radius),
        ),
    ]
    panels = [
        _panel(
            name,
            "radius",
            _axis("Radius", radius),
            _axis(label, _quantity(result, name), **settings),
            [line],
        )
        for name, label, settings, line in rows
    ]
    panels[2:2] = _compression(result, r, values["hoop_stress"])
    y_axis = _axis("Wound-on tension", wound_on_tension, floor=0)
    return [*panels, _panel("tension", "radius", _axis("Radius", radius), y_axis, [tension])]


def _compression(result: Any, r: Array, hoop_stress: Array) -> list[Panel]:
    """Return the panel of the hoop stress where it is compressive, enlarged.

    The web has its wound-on stress at both ends of the roll, many times the compression inside.
    """
    (compressed,) = np.nonzero(hoop_stress < 0)
    if compressed.size < 2:
        return []
    part = slice(compressed[0], compressed[-1] + 1)
    ends = [float(r[part][0]), float(r[part][-1])]
    x_axis = _axis("Radius", _quantity(result, "radius"), range=ends)
    stress = _curve(result, "hoop_stress", "", "drum", x=r[part], y=hoop_stress[part])
    # a column of its own: its part of the radius is not that of the other panels
    return [
        _panel(
            "compression",
            "compression",
            x_axis,
            _axis("Hoop stress", _quantity(result, "hoop_stress")),
            [stress],
        )
    ]


def _winding_panels(result: Any) -> list[Panel]:
    """Return the schedules and the wound-on tension, then the roll's panels."""

    def over_radius(name: str, label: str, names: dict[str, tuple[str, str, str]]) -> Panel:
        """Return a panel of several outputs over the radius."""
        first = next(iter(names))
        curves = [
            _curve(result, output, words, role, x=result.radius, dash=dash)
            for output, (words, role, dash) in names.items()
        ]
        return _panel(
            name,
            "radius",
            _axis("Radius", _quantity(result, "radius")),
            _axis(label, _quantity(result, first)),
            curves,
        )

    tensions = {
        "web_tension": ("upstream of the nip", "web", "dashdot"),
        "wound_on_tension": ("wound on", "roll", "solid"),
    }
    loads = {
        "nip_load": ("nip load", "drum", "solid"),
        "winding_force": ("winding force", "web", "dashed"),
    }
    pressure, *stresses, hardness, _ = _roll_panels(result.roll)
    return [
        over_radius("tension", "Tension", tensions),
        pressure,
        *stresses,
        over_radius("loads", "Nip load, winding force", loads),
        hardness,
    ]


def _any_panels(result: Any) -> list[Panel]:
    """Return a panel for every array, over the one that it runs along."""
    arrays = {
        place.path: (place.quantity, np.asarray(place.value, dtype=float))
        for place in quantities.walk(result)
        if place.quantity is not None and np.ndim(place.value) == 1 and np.size(place.value) > 1
    }
    panels, first = [], next(iter(arrays), "")
    for name, (quantity, _) in arrays.items():
        over = result.ALONG.get(name, first)
        if name in (over, *result.ALONG.values()):
            continue
        x = arrays[over]
        panels.append(
            _panel(
                name,
                over,
                _axis(x[0].meaning, x[0]),
                _axis(quantity.meaning, quantity),
                [_curve(result, name, "", "roll", x=x[1])],
            )
        )
    return panels


_PANELS: dict[str, Callable[[Any], list[Panel]]] = {
    "nip": _nip_panels,
    "rollers": _roller_panels,
    "roll": _roll_panels,
    "winding": _winding_panels,
}

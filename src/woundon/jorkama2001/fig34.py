"""Thesis Fig. 34, sec. 4.9: strain rates of web and roll under a web that slips everywhere."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import xarray as xr

import woundon as wo

from ..report.panels import Curve, Panel
from .cases import paper_nip
from .exhibits import Exhibit
from .influence import surface_strain
from .nips import dataset
from .panels import axis
from .verdicts import Verdict, at_least, verdict

__all__ = ["exhibits", "web_rate"]

FRICTION = 0.5
TENSION = 500.0  # T_0 [N/m]; the ratio of the rates does not depend on it
CELLS = 720  # a quarter of a degree each
AWAY = 5.0  # [deg] from either end of the load, where strains are singular


def exhibits(solver: str) -> list[Exhibit]:
    """Load the roll of Table 1 by eq. (181) with mu+ = 0.5; return Fig. 34."""
    data = _rates()
    return [Exhibit("fig34", data, _verdicts(data), [_panel(data)], one_solver=True)]


def web_rate(web: wo.Web, tension: float, friction: float, theta: np.ndarray) -> np.ndarray:
    """Return d eps/d theta of a web that slips on an undeformed roll from a tension on [1/rad]."""
    return web.compliance.c11 / web.thickness * tension * friction * np.exp(friction * theta)


@cache
def _rates() -> xr.Dataset:
    """Return the rates of the strains of roll and slipping web over the angle."""
    problem = paper_nip()
    assert isinstance(problem.roll, wo.Cylinder)
    theta = np.linspace(0.0, pi, CELLS + 1)
    middle = (theta[1:] + theta[:-1]) / 2
    # eq. (181): the web slips everywhere, its tension grows as exp(mu theta)
    pressure = TENSION / problem.roll.radius * np.exp(FRICTION * theta)
    R = problem.roll.radius
    strain = surface_strain(problem.roll, R * theta, pressure, FRICTION * pressure, R * middle)
    return dataset(
        "point",
        {
            "angle [rad]": theta[1:-1],
            "roll_rate [1/rad]": np.diff(strain) / np.diff(middle),
            "web_rate [1/rad]": web_rate(problem.web, TENSION, FRICTION, theta[1:-1]),
        },
    )


def _verdicts(data: xr.Dataset) -> list[Verdict]:
    """Test the statements about the strain rates."""
    angle = np.degrees(data["angle"])
    away = (angle > AWAY) & (angle < 180 - AWAY)
    ratio = (data["web_rate"] / np.abs(data["roll_rate"]))[away]
    return [
        verdict(
            "the rates of web and roll differ by several decades: median of their ratio",
            ratio.median(),
            at_least(100.0),
            note=f"between {AWAY:g} and {180 - AWAY:g} degrees; the smallest is "
            f"{ratio.min():.0f}, at the end, where the load stops and the roll's strain is "
            "singular",
        ),
        verdict(
            "so a slipping web does not stick again: its strain outgrows the roll's everywhere",
            ratio.min(),
            at_least(1.0),
            note="smallest ratio",
        ),
    ]


def _panel(data: xr.Dataset) -> Panel:
    """Return the panel of the strain rates of roll and web over the angle."""
    angle = data["angle"].values
    return Panel(
        "rates",
        replace(axis("angle"), label="Angle downstream of the start of slip $theta$"),
        axis("roll_rate"),
        curves=tuple(
            Curve(
                f"{body}_rate",
                angle,
                np.abs(data[f"{body}_rate"].values),
                label=body,
                colour=colour,
                line=line,
            )
            for body, colour, line in (("roll", "roll", "solid"), ("web", "drum", "dashed"))
        ),
    )

"""A plug-in: a body, an output, a kind of problem, a command and a figure.

A package that has this as a module names it in its entry points, and woundon imports it by itself:

    [project.entry-points."woundon.plugins"]
    mattress = "mattress"
"""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from math import exp, pi
from typing import Annotated, ClassVar

import click
import numpy as np
from pydantic import Field

import woundon as wo
from woundon.elasticity.mesh import Face
from woundon.elasticity.surface import Deformation, SurfaceTangent
from woundon.problems.description import Description
from woundon.problems.fields import Number
from woundon.quantities import angle, length, line_load, pure, stress

Array = np.ndarray


# [body]
class MattressLayer(Description):
    """A layer that yields straight below its load."""

    thickness: Annotated[Number, length("h", "thickness of the layer"), Field(gt=0, le=1)]
    modulus: Annotated[
        Number, stress("M", "modulus in one-dimensional compression", "MPa"), Field(gt=0)
    ]


class Mattress(wo.Body):
    """A Winkler foundation on a rigid core: a point moves by the pressure at that point alone.

    w = c K1 ln(1 + p/K1) with c the layers' compliance sum(h/M); w = c p where K1 is not given.

    Parameters
    ----------
    radius : float
        R [m].
    layers : tuple of MattressLayer
        Outermost first.
    hardening_pressure : float, optional
        K1 [Pa].
    """

    layers: Annotated[tuple[MattressLayer, ...], Field(min_length=1)]
    hardening_pressure: Annotated[
        Number | None, stress("K1", "pressure at which the layers are twice as stiff"),
        Field(default=None, gt=0),
    ]  # fmt: skip

    linear: ClassVar[bool] = False

    @property
    def c(self) -> float:
        """Compliance [m/Pa]."""
        return sum(layer.thickness / layer.modulus for layer in self.layers)

    @property
    def thickness(self) -> float:
        """Thickness of all layers [m]."""
        return sum(layer.thickness for layer in self.layers)

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> MattressSurface:
        """Return the response on a face."""
        return MattressSurface(self, face, half_width)


class MattressSurface:
    """v = -w(p) at every node, u = 0."""

    rigid = False

    def __init__(self, body: Mattress, face: Face, a: float) -> None:
        self.body, self.derivative, self.hats = body, face.derivative / a, face.hats
        self.edge = face.last  # node at the trailing edge of the nip

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the slope v' = -dw/dx and the strain u' + v/R = -w/R."""
        w = self._depth(p)[0]
        return Deformation(-self.derivative @ w, -self.hats @ w * self.body.curvature)

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the derivatives of ``deform``."""
        by_p = self._depth(p)[1]
        slope_p = -self.derivative * by_p
        none = np.zeros_like(slope_p)
        return SurfaceTangent(slope_p, none, -self.hats * (by_p * self.body.curvature), none)

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip."""
        return -float(self._depth(p)[0][self.edge])

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of v at the trailing edge of the nip."""
        by_p = np.zeros(p.size)
        by_p[self.edge] = -self._depth(p)[1][self.edge]
        return by_p, np.zeros(p.size)

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u = 0."""
        return 0.0

    def _depth(self, p: Array) -> tuple[Array, Array]:
        """Return w(p) and w'(p)."""
        c, K1 = self.body.c, self.body.hardening_pressure
        if K1 is None:
            return c * p, np.full(p.shape, c)
        p = np.maximum(p, -0.5 * K1)  # iterates of Newton's method may be tensile
        return c * K1 * np.log1p(p / K1), c / (1 + p / K1)


# [body end]


# [output]
def mean_pressure(result: wo.NipResult) -> Annotated[float, stress("p_m", "mean pressure")]:
    """Return P/(2a) [Pa]."""
    return float(result.problem.nip_load / result.nip_width)


wo.plugins.register_output("nip", mean_pressure)
# [output end]


# [kind]
class CapstanProblem(wo.Problem):
    """A web that slips over a bar, all of the wrap one way."""

    web_tension: Annotated[Number, line_load("T1", "web tension before the bar"), Field(gt=0)]
    friction: Annotated[Number, pure("mu", "friction between web and bar"), Field(ge=0, le=10)]
    wrap: Annotated[Number, angle("theta", "angle of wrap"), Field(gt=0, le=4 * pi)]
    radius: Annotated[Number, length("R", "radius of the bar"), Field(gt=0)]

    @classmethod
    def example(cls) -> CapstanProblem:
        """Return a quarter turn of a smooth bar."""
        return cls(web_tension=200.0, friction=0.2, wrap=pi / 2, radius=0.05)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CapstanResult(wo.Result):
    """Web tension and pressure along the wrap."""

    at: Annotated[Array, angle("s", "angle from where the web meets the bar")]
    tension: Annotated[Array, line_load("T", "web tension")]
    pressure: Annotated[Array, stress("p", "pressure of the web on the bar")]

    @property
    def tension_behind_bar(self) -> Annotated[float, line_load("T2", "web tension behind the bar")]:
        """T2 [N/m]."""
        return float(self.tension[-1])

    def certified(self) -> wo.Residuals:
        """Return how far dT = mu T ds and p = T/R are from being kept."""
        mu, R, T = self.problem.friction, self.problem.radius, self.tension
        # over a step ds: T2 - T1 = tanh(mu ds/2) (T1 + T2), exactly
        grown = np.diff(T) - np.tanh(mu * np.diff(self.at) / 2) * (T[1:] + T[:-1])
        return wo.Residuals(
            capstan=float(np.max(np.abs(grown)) / T.max()),
            wire=float(np.max(np.abs(self.pressure - T / R)) * R / T.max()),
        )


def solve_capstan(problem: CapstanProblem, *, nodes: int = 33) -> CapstanResult:
    """Solve by Euler and Eytelwein's closed form."""
    at = np.linspace(0.0, problem.wrap, nodes)
    tension = problem.web_tension * np.array([exp(problem.friction * s) for s in at])
    result = CapstanResult(
        problem=problem, at=at, tension=tension, pressure=tension / problem.radius,
        residuals=wo.Residuals(),
    )  # fmt: skip
    return result.replace(residuals=result.certified()).checked().warned()


about = "A web that slips over a bar, all of the wrap one way."
wo.kinds.register(CapstanProblem, solve_capstan, CapstanResult, about=about)
# [kind end]


# [command]
@click.command("capstan-table", help="Print the tension ratios of a capstan.")
@click.option("--friction", type=float, default=0.2, show_default=True)
def capstan_table(friction: float) -> None:
    """Print T2/T1 over the angle of wrap."""
    for degrees in (45, 90, 180):
        click.echo(f"{degrees} deg  {exp(friction * degrees * pi / 180):.3f}")


wo.plugins.register_command(capstan_table)
# [command end]


# [figure]
def list_figures() -> list[dict[str, str]]:
    """Return name, label and title of the figures."""
    return [{"name": "capstan", "label": "Capstan", "title": "tension ratio over the wrap"}]


def draw_figure(name: str) -> bytes:
    """Return a figure as SVG."""
    from matplotlib.figure import Figure

    figure, wrap = Figure(), np.linspace(0.0, pi)
    figure.subplots().plot(wrap, np.exp(0.2 * wrap))
    file = BytesIO()
    figure.savefig(file, format="svg")
    return file.getvalue()


wo.plugins.register_figures(list_figures, draw_figure)
# [figure end]

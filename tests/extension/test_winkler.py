"""A body with an unusual compliance, defined and tested as docs/extending.md describes."""

# [body]
from typing import Annotated

import numpy as np
import pytest
from pydantic import Field

import woundon as wo
from woundon.elasticity.mesh import Face, Wrap, nip_mesh
from woundon.elasticity.surface import LinearSurface, SurfaceTangent
from woundon.problems.fields import Number
from woundon.quantities import Quantity


class Winkler(wo.Body, abstract=True):  # not registered: other tests list the known bodies
    """A Winkler foundation on a rigid core: v = -c p at every point of the surface, and u = 0.

    Parameters
    ----------
    radius : float
        R [m].
    foundation_compliance : float
        c [m/Pa].
    """

    foundation_compliance: Annotated[
        Number, Quantity("c", "m/Pa", "compliance of the foundation"), Field(gt=0, le=1e-3)
    ]

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> LinearSurface:
        """Return the response dv/dx = -c dp/dx and the strain v/R on a face."""
        c = self.foundation_compliance
        slope_p, strain_p = -c * face.derivative / half_width, -c * face.hats * self.curvature
        none = np.zeros_like(slope_p)
        end = np.zeros((2, face.nodes.size))
        end[0, face.last] = -c
        return LinearSurface(SurfaceTangent(slope_p, none, strain_p, none), end)


# [body end]
# [test]
def test_pressure_of_a_rigid_roller_is_a_parabola() -> None:
    """Closed form: c p = (a^2 - x^2)/(2 R*), P = 2 a^3/(3 R* c) (Johnson 1985, section 4.3)."""
    R, c, P = 0.5, 1e-8, 2e3
    foundation = Winkler(radius=2 * R, foundation_compliance=c)
    problem = wo.RollerProblem(upper=wo.Rigid(radius=2 * R), lower=foundation, load=P, friction=0)
    result = wo.solve(problem, nodes=129)
    a = (1.5 * R * c * P) ** (1 / 3)
    assert result.half_width == pytest.approx(a, rel=2e-4)
    assert result.peak_pressure == pytest.approx(a**2 / (2 * R * c), rel=4e-4)
    assert result.residuals.largest < 1e-8


# [test end]
def test_displacement_at_the_end_is_that_of_the_trailing_edge_of_the_nip() -> None:
    """Closed form: on a face with a roll wrap v = -c p at every node."""
    a, c, foundation = 1e-3, 1e-8, Winkler(radius=0.1, foundation_compliance=1e-8)
    face = nip_mesh(41, Wrap(), Wrap(length=40.0, radius=100.0)).roll_face
    p, q = np.linspace(1e5, 2e5, face.nodes.size), np.zeros(face.nodes.size)
    surface = foundation.surface(face, a)
    slope, end = surface.deform(p, q).slope, surface.end_displacement(p, q)
    np.testing.assert_allclose(face.displacement_at_nodes(slope, end, a), -c * p, rtol=1e-12)


@pytest.mark.parametrize("roll_wrap", [0.0, 0.5, np.pi])
def test_a_web_is_wound_on_a_foundation(roll_wrap: float) -> None:
    """The elastic drum makes the tractions unique where the web sticks to both bodies."""
    given = wo.NipProblem.example()
    drum = wo.Cylinder(radius=0.08, core_radius=0.03, material=wo.material("newsprint"))
    roll = Winkler(radius=0.1, foundation_compliance=1e-10)
    result = wo.solve(given.replace(roll=roll, drum=drum, roll_wrap=roll_wrap))
    assert result.residuals.largest < 1e-8
    assert result.wound_on_tension > given.web_tension

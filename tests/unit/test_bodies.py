"""Bodies: their responses, their construction from tables, and their agreement in common limits."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh

STEEL = wo.material("steel")
FACE = nip_mesh(17, Wrap(), Wrap()).roll_face


def test_a_rigid_body_has_a_radius_and_does_not_deform() -> None:
    body = wo.Rigid(radius=0.3)
    assert body.rigid
    assert (body.radius, body.compliance, body.surface_material) == (0.3, 0.0, None)
    surface, p = body.surface(FACE, 0.01), np.linspace(0.0, 1e6, FACE.nodes.size)
    assert surface.rigid
    for part in (*surface.deform(p, -p), *surface.tangent(p, -p), *surface.end_tangent(p, -p)):
        assert not part.any()
    assert [part.shape for part in surface.tangent(p, p)] == [(p.size + 1, p.size)] * 4
    assert surface.end_displacement(p, -p) == surface.end_tangential_displacement(p, -p) == 0.0


def test_a_half_planes_strain_has_no_curvature_and_its_answer_no_radius() -> None:
    near, far = (wo.HalfPlane(radius=R, material=STEEL) for R in (0.1, 5.0))
    assert near.curvature == far.curvature == 0.0
    assert near.kernels() == far.kernels()
    # Hertz: slope C/pi of ln|t| with C = 2 (1 - nu^2)/E
    C = 2 * (1 - 0.3**2) / 206e9
    assert near.kernels().slope_p.inverse == pytest.approx(C / pi, rel=1e-14)
    assert near.kernels().normal_p.log == pytest.approx(C / pi, rel=1e-14)


def test_the_thinnest_layer_is_the_1_in_2000th() -> None:
    wo.Cylinder(radius=1.0, core_radius=0.9995, material="steel")
    with pytest.raises(wo.InvalidProblem, match=r"core_radius: 0\.99951 is out of range"):
        wo.Cylinder(radius=1.0, core_radius=0.99951, material="steel")


@pytest.mark.parametrize("share", [1.0, 1 - 1e-12, 1 + 1e-12])
def test_layers_as_thick_as_the_radius_are_rejected(share: float):
    with pytest.raises(wo.InvalidProblem, match=r"layers: a total thickness of .* is out"):
        wo.Layered(radius=0.2, layers=[wo.Layer(thickness=0.2 * share, material="rubber")])

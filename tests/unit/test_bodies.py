"""Bodies: their responses, their construction from tables, and their agreement in common limits."""

from __future__ import annotations

import subprocess
import sys
from math import pi
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.problems.bodies import AnyBody

STEEL = wo.material("steel")
FACE = nip_mesh(17, Wrap(), Wrap()).roll_face
made = TypeAdapter(AnyBody).validate_python

KERNELS = [f"{q}_{load}" for q in ("normal", "tangent", "slope", "strain") for load in "pq"]


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


def test_a_cylinder_is_a_half_plane_up_close() -> None:
    cylinder = wo.Cylinder(radius=0.3, core_radius=0.05, material="paper")
    half_plane = wo.HalfPlane(radius=0.3, material="paper")
    assert cylinder.curvature == pytest.approx(1 / 0.3)
    assert cylinder.thickness == pytest.approx(0.25)
    near, limit = cylinder.kernels(), half_plane.kernels()
    assert near.terms > 0
    assert near.truncation_error < 1e-9
    for name in KERNELS:
        k, h = getattr(near, name), getattr(limit, name)
        # the singular parts of the leading order are those of the half-plane, others are absent
        assert k.inverse == pytest.approx(h.inverse, rel=1e-12, abs=1e-25)
        assert k.delta == pytest.approx(h.delta, rel=1e-12, abs=1e-25)
        if h.log or h.sign:
            assert k.log == pytest.approx(h.log, rel=1e-12, abs=1e-25)
            assert k.sign == pytest.approx(h.sign, rel=1e-12, abs=1e-25)


def test_slope_and_strain_are_what_the_displacements_say() -> None:
    # dv/dx and v/R + du/dx by central differences: their error is h^2 f'''/6 ~ (h/t)^2/3 relative
    body = wo.Cylinder(radius=0.3, core_radius=0.05, material="paper")
    kernels = body.kernels()

    def value(name: str, t: np.ndarray) -> np.ndarray:
        k = getattr(kernels, name)
        return k.inverse / t + k.log * np.log(np.abs(t)) + k.sign * np.sign(t) + k.smooth(t)

    t, h = np.array([-0.04, -0.01, -0.002, 0.003, 0.02, 0.05]), 1e-6
    for load in "pq":
        slope = (value(f"normal_{load}", t + h) - value(f"normal_{load}", t - h)) / (2 * h)
        strain = (value(f"tangent_{load}", t + h) - value(f"tangent_{load}", t - h)) / (2 * h)
        strain += body.curvature * value(f"normal_{load}", t)
        for name, differenced in ((f"slope_{load}", slope), (f"strain_{load}", strain)):
            exact = value(name, t)
            np.testing.assert_allclose(differenced, exact, rtol=1e-6, atol=1e-6 * abs(exact).max())


def test_the_shell_of_a_cover_is_the_core() -> None:
    cover = wo.Cylinder(radius=0.5, core_radius=0.48, material="soft-cover")
    assert cover.thickness == pytest.approx(0.02)
    # a thin layer on its shell moves less than a thick one
    thick = wo.Cylinder(radius=0.5, core_radius=0.3, material="soft-cover")
    t = np.array([1e-3])
    thin_moves, thick_moves = (
        float((b.kernels().normal_p.log * np.log(t) + b.kernels().normal_p.smooth(t))[0])
        for b in (cover, thick)
    )
    assert thick_moves < thin_moves < 0  # inwards under pressure


TABLES: list[tuple[dict[str, Any], type]] = [
    ({"radius": 0.3}, wo.Rigid),
    ({"kind": "rigid", "radius": 0.3}, wo.Rigid),
    ({"radius": 0.3, "material": "steel"}, wo.HalfPlane),
    ({"kind": "half_plane", "radius": 0.3, "material": "steel"}, wo.HalfPlane),
    ({"radius": 0.3, "core_radius": 0.1, "material": "steel"}, wo.Cylinder),
    ({"kind": "cylinder", "radius": 0.3, "core_radius": 0.1, "material": "paper"}, wo.Cylinder),
]


@pytest.mark.parametrize(("table", "kind"), TABLES)
def test_a_table_tells_its_kind_by_its_fields(table: dict[str, Any], kind: type) -> None:
    body = made(table)
    assert type(body) is kind
    assert made(body) is body
    assert made(body.model_dump()) == body


@pytest.mark.parametrize(
    "material",
    [
        "steel",
        STEEL,
        {"youngs_modulus": 206e9, "poissons_ratio": 0.3},
        {"kind": "isotropic", "youngs_modulus": 206e9, "poissons_ratio": 0.3},
    ],
    ids=["name", "itself", "table", "table of a kind"],
)
def test_a_material_is_given_by_itself_a_name_or_a_table(material: Any) -> None:
    for body in (
        wo.HalfPlane(radius=0.3, material=material),
        wo.Cylinder(radius=0.3, core_radius=0.1, material=material),
        wo.Web(thickness=66e-6, material=material),
    ):
        assert body.material == STEEL


def test_the_thinnest_layer_is_the_1_in_2000th() -> None:
    wo.Cylinder(radius=1.0, core_radius=0.9995, material="steel")
    with pytest.raises(wo.InvalidProblem, match=r"core_radius: 0\.99951 is out of range"):
        wo.Cylinder(radius=1.0, core_radius=0.99951, material="steel")


def test_describing_needs_no_scipy() -> None:
    # a command that only checks a case, or lists materials, starts without the heavy libraries
    code = (
        "import sys, woundon as wo;"
        "wo.Cylinder(radius=1, core_radius=.5, material='steel');"
        "wo.NipProblem; wo.RollerProblem;"
        "sys.exit(any(m in sys.modules for m in ('scipy', 'matplotlib', 'pint', 'xarray')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_gradients_smooth_parts_come_together() -> None:
    from dataclasses import replace

    kernels = wo.Cylinder(radius=0.3, core_radius=0.1, material=wo.material("paper")).kernels()
    t = np.linspace(-0.02, 0.02, 7)
    assert kernels.smooth is not None
    one_by_one = replace(kernels, together=None).smooth
    assert one_by_one is not None
    np.testing.assert_allclose(kernels.smooth(t), one_by_one(t), rtol=1e-13)
    flat = wo.HalfPlane(radius=0.3, material=wo.material("paper")).kernels()
    assert flat.smooth is None

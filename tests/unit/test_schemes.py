"""Schemes and meshes: what each row of their matrices is, and that all sorts of mesh agree."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import woundon as wo
from woundon.contact.grid import Grid, cosine_grid, segmented_grid
from woundon.contact.meshes import GradedMesh, Mesh
from woundon.contact.panagiotopoulos import panagiotopoulos
from woundon.contact.response import Response, Tractions, on_columns, padded
from woundon.contact.schemes import SCHEMES, scheme_of
from woundon.contact.stick_slip import StickSlip
from woundon.elasticity import half_plane
from woundon.problems.bodies import KernelBody
from woundon.wrap.face import FaceGrid
from woundon.wrap.grid import GRADING, OVERLAP, STEP, Arc, wrap_grid

Array = np.ndarray
PAPER = wo.material("paper")
BODIES: dict[str, KernelBody] = {
    "half-plane": wo.HalfPlane(radius=0.3, material=PAPER),
    "roll": wo.Cylinder(radius=0.3, core_radius=0.05, material=PAPER),
    "thin cover": wo.Cylinder(radius=0.3, core_radius=0.297, material="soft-cover"),
}
UNEVEN = Grid(
    np.array([-1.0, -0.8, -0.3, 0.1, 0.6, 1.0]), np.array([-0.95, -0.5, 0.0, 0.3, 0.9, 1.0])
)
a = 4e-3  # half width [m]


def meshes() -> dict[str, Mesh]:
    fitted = GradedMesh(segmented_grid(np.array([-0.4, 0.3]), 41))
    return {name: scheme.mesh(41) for name, scheme in SCHEMES.items()} | {
        "uneven": GradedMesh(UNEVEN), "fitted": fitted,
    }  # fmt: skip


MESHES = meshes()
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
each_body = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)


# ---- what a mesh is -----------------------------------------------------------------------------


@each_mesh
def test_a_mesh_has_a_point_in_each_cell_and_the_trailing_edge(mesh: Mesh) -> None:
    n = mesh.unknowns
    assert mesh.nodes.shape == (n + 2,)
    np.testing.assert_array_equal(mesh.columns, mesh.nodes[1:-1])
    np.testing.assert_array_equal(mesh.points, np.append(mesh.middle, 1.0))
    assert np.all((mesh.nodes[:-1] < mesh.middle) & (mesh.middle < mesh.nodes[1:]))
    for matrix in (mesh.value, mesh.slope):
        assert matrix.shape == (n + 2, n)
    for matrix in (mesh.upstream, mesh.behind):
        assert matrix.shape == (n + 1, n)


@each_mesh
def test_rows_are_value_and_slope_of_the_piecewise_linear_traction(mesh: Mesh) -> None:
    nodal = np.random.default_rng(2).normal(size=mesh.unknowns)
    whole = padded(nodal)
    np.testing.assert_allclose(
        mesh.value @ nodal, np.interp(mesh.points, mesh.nodes, whole), rtol=0, atol=1e-14
    )
    steps = np.diff(whole) / np.diff(mesh.nodes)
    # the trailing edge has the slope of the last cell; 40 cells of 1e-3: rounding times 1e3
    np.testing.assert_allclose(mesh.slope @ nodal, np.append(steps, steps[-1]), rtol=1e-11)
    assert (mesh.value[-1] == 0).all()  # the traction vanishes at the edge


@pytest.mark.parametrize("scheme", SCHEMES)
def test_cells_see_the_integral_of_the_traction(scheme: str) -> None:
    mesh = SCHEMES[scheme].mesh(41)
    p, middle = 1 - mesh.columns**2, mesh.middle
    known = middle - middle**3 / 3 + 2 / 3
    # lumping and (121) are second order, 3 h^2 with the largest cell
    h = mesh.grid.cells.max()
    np.testing.assert_allclose(mesh.upstream @ p, known, atol=(3 * h) ** 2)
    np.testing.assert_allclose(mesh.behind @ p, known - 4 / 3, atol=(3 * h) ** 2)
    assert mesh.upstream[-1] @ p == pytest.approx(4 / 3, abs=(3 * h) ** 2)
    assert mesh.upstream[0] @ p == 0.0 or scheme == "thesis-printed"


def test_the_printed_tension_weights_sum_to_the_lumped_ones() -> None:
    lumped, printed = (SCHEMES[s].mesh(11).upstream for s in ("thesis", "thesis-printed"))
    shifted = printed - lumped
    # eq. (121) gives 1/6 of a hat to the cell before its node and takes it from the one behind
    assert np.allclose(shifted.sum(axis=0), 0.0)
    weight = SCHEMES["thesis"].mesh(11).grid.weights[0]
    assert np.allclose(np.diag(shifted)[:9], weight / 6)
    assert np.allclose(np.diag(shifted[1:])[:9], -weight / 6)


def test_schemes_are_known_by_name_or_given() -> None:
    assert {s.name for s in SCHEMES.values()} == {"graded", "thesis", "thesis-printed"}
    assert scheme_of("graded") == wo.Graded()
    assert scheme_of("thesis-printed") == wo.Thesis(printed=True)
    own = wo.Thesis()
    assert scheme_of(own) is own
    with pytest.raises(wo.InvalidProblem, match=r"'thesys' is unknown; did you mean 'thesis'\?"):
        scheme_of("thesys")
    with pytest.raises(wo.InvalidProblem, match="scheme: 3 is unknown"):
        scheme_of(3)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_mesh_is_restored_from_its_nodes(scheme: str) -> None:
    mesh = SCHEMES[scheme].mesh(33)
    # as a file has them: metres, divided by the half width again
    again = SCHEMES[scheme].restored(mesh.nodes * a / a, mesh.points * a / a)
    assert type(again) is type(mesh)
    np.testing.assert_allclose(again.points, mesh.points, rtol=0, atol=4e-16)
    for name in ("value", "slope", "upstream"):
        np.testing.assert_allclose(
            getattr(again, name), getattr(mesh, name), rtol=1e-11, atol=1e-14
        )


# ---- what a body answers on it ------------------------------------------------------------------


@each_mesh
@each_body
def test_a_response_has_a_row_for_each_point_a_column_for_each_node(
    mesh: Mesh, body: KernelBody
) -> None:
    response = body.respond(mesh, a)
    for part in response.gradients:
        assert part.shape == (mesh.points.size, mesh.columns.size)
    slope_p = response.gradients[0]
    # both ways round one and the same matrix; rounding of two orders of summation
    cells = response.pressure_slope()
    assert cells.shape == (mesh.points.size - 1, mesh.columns.size)
    np.testing.assert_allclose(cells, slope_p[:-1], rtol=0, atol=1e-13 * np.abs(slope_p).max())
    assert (response.slope, response.strain) == (0.0, 0.0)  # linear: nothing without tractions
    for displaced in (response.normal, response.tangent):
        at_edge, elsewhere = displaced(), displaced(np.array([-1.0, 0.2, 1.0]))
        for edge, three in zip(at_edge, elsewhere, strict=True):
            assert edge.shape == (1, mesh.columns.size)
            assert three.shape == (3, mesh.columns.size)
            np.testing.assert_allclose(three[-1:], edge, rtol=0, atol=1e-12 * np.abs(three).max())
    assert response.terms == body.kernels().terms


def test_a_response_without_pressure_slope_takes_the_gradients() -> None:
    gradients = tuple(np.arange(6.0).reshape(3, 2) + k for k in range(4))
    response = Response(gradients)  # type: ignore[arg-type]
    np.testing.assert_array_equal(response.pressure_slope(), gradients[0][:-1])
    np.testing.assert_array_equal(response.normal(np.zeros(5))[0], np.zeros((5, 2)))
    asked = []

    def make() -> tuple[Array, Array, Array, Array]:
        asked.append(1)
        return gradients  # type: ignore[return-value]

    late = Response(make)
    assert not asked  # nothing is integrated before it is wanted
    assert late.gradients is gradients
    assert asked == [1]


@each_body
def test_slopes_and_strains_are_those_of_the_displacements(body: KernelBody) -> None:
    # central differences of v and u at the points themselves: an independent sum of kernels
    mesh = SCHEMES["graded"].mesh(65)
    p = np.sqrt(1 - mesh.columns**2)
    response = body.respond(mesh, a)
    # away from the edges, where the difference's own error, h^2 over a cell squared, is small;
    # 1e-4: what 24 interpolation points leave of the kinks of the smooth parts
    inner = np.abs(mesh.middle) < 0.8
    y, h = mesh.middle[inner], 1e-4
    before, behind = response.normal(y - h), response.normal(y + h)
    left, right = response.tangent(y - h), response.tangent(y + h)
    here = response.normal(y)
    slope_p, slope_q, strain_p, strain_q = (part[:-1][inner] @ p for part in response.gradients)
    for k, (slope, strain) in enumerate(((slope_p, strain_p), (slope_q, strain_q))):
        rise = (behind[k] - before[k]) @ p / (2 * h * a)
        stretch = (right[k] - left[k]) @ p / (2 * h * a) + body.curvature * (here[k] @ p)
        np.testing.assert_allclose(rise, slope, rtol=0, atol=1e-4 * np.abs(slope).max())
        np.testing.assert_allclose(stretch, strain, rtol=0, atol=1e-4 * np.abs(strain).max())


@pytest.mark.parametrize("name", ["roll", "thin cover"])
def test_even_nodes_integrate_kernels_exactly(name: str) -> None:
    """Kernels have a kink where node and hat meet, which interpolation between few points loses."""
    body, mesh = BODIES[name], SCHEMES["thesis"].mesh(101)
    kernels, cells = body.kernels(), a * mesh.grid.cells[:, None]
    # 600 points, the most there are, lose 2e-4 of it, 24 up to a tenth
    v_p, v_q, u_p, u_q = (
        mesh.grid.integrate(kernel, a, rank=600)
        for kernel in (kernels.normal_p, kernels.normal_q, kernels.tangent_p, kernels.tangent_q)
    )
    expected = (
        *(np.diff(v, axis=0) / cells for v in (v_p, v_q)),
        *(np.diff(u, axis=0) / cells + body.curvature * v[1:] for u, v in ((u_p, v_p), (u_q, v_q))),
    )
    for found, asked in zip(body.respond(mesh, a).gradients, expected, strict=True):
        np.testing.assert_allclose(found[:-1], asked, rtol=0, atol=5e-4 * np.abs(asked).max())
        np.testing.assert_array_equal(found[-1], found[-2])


@each_body
def test_even_nodes_act_by_convolutions(body: KernelBody) -> None:
    mesh = SCHEMES["thesis"].mesh(41)
    response = body.respond(mesh, a)
    p, q = np.random.default_rng(3).random((2, mesh.columns.size))
    slope_p, slope_q, strain_p, strain_q = response.gradients
    slope, strain = response.act(p, q)
    # other orders of summation: rounding alone
    np.testing.assert_allclose(slope, slope_p @ p + slope_q @ q, rtol=0, atol=1e-12 * slope.max())
    np.testing.assert_allclose(
        strain, strain_p @ p + strain_q @ q, rtol=0, atol=1e-12 * slope.max()
    )
    assert response.acts


@each_body
@pytest.mark.parametrize("arcs", ["no arc", "behind", "before"])
def test_a_face_of_a_wrap_has_the_nips_matrices_inside_it(body: KernelBody, arcs: str) -> None:
    """Points and hats inside the nip: of plain mesh and face one and the same numbers."""
    mesh = SCHEMES["graded"].mesh(65)
    arc = 0.0 if arcs == "no arc" else 0.9 * pi * body.radius / a
    drum, roll = (arc, 0.0) if arcs == "before" else (0.0, arc)
    grid = wrap_grid(mesh.grid, drum, 24, roll, 24)
    if arcs == "before":
        face = FaceGrid(grid, 0, grid.last, grid.first)
    else:
        face = FaceGrid(grid, grid.first, grid.size - 1, grid.last)
    first = face.trailing - mesh.nodes.size + 1
    inside, cells = slice(first + 1, face.trailing), slice(first, face.trailing)
    np.testing.assert_array_equal(face.columns[inside], mesh.columns)
    np.testing.assert_array_equal(face.points[cells], mesh.middle)
    np.testing.assert_allclose(face.value[cells, inside], mesh.value[:-1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(face.slope[cells, inside], mesh.slope[:-1], rtol=1e-10)
    own, plain = body.respond(face, a), body.respond(mesh, a)
    for wide, narrow in zip(own.gradients, plain.gradients, strict=True):
        # the same integrals of the same kernels: rounding alone
        close = 1e-14 * np.abs(narrow).max()
        np.testing.assert_allclose(wide[cells, inside], narrow[:-1], rtol=0, atol=close)
    if arcs != "behind":  # the face ends at the nip's trailing edge
        p = np.sqrt(1 - mesh.columns**2)
        for wide, narrow in zip(own.normal(), plain.normal(), strict=True):
            # beside an arc by Gauss's points, else by interpolation, whose 24 points leave 2e-5 of
            # the coupling's kink at t = 0
            np.testing.assert_allclose(wide[:, inside] @ p, narrow @ p, rtol=5e-5)


@pytest.mark.parametrize("scheme", ["graded", "thesis"])
def test_hertz_on_a_half_plane(scheme: str) -> None:
    # slope C x/(...) straight, strain -A p under pressure, -B times a straight line under traction
    A, B, C = half_plane.coefficients(20e6, 3e9, 5e6, 10e6)
    mesh = SCHEMES[scheme].mesh(401)
    slope_p, slope_q, strain_p, strain_q = BODIES["half-plane"].respond(mesh, a).gradients
    e = np.sqrt(1 - mesh.columns**2)
    y = mesh.middle
    # uneven: backward differences of the root at the edge; 1/sqrt(400) there
    inner = np.abs(y) < 0.9
    tol = 5e-3
    np.testing.assert_allclose((slope_p[:-1] @ e)[inner], (C * y)[inner], atol=tol * C)
    np.testing.assert_allclose((strain_q[:-1] @ e)[inner], (-B * y)[inner], atol=tol * B)
    root = np.sqrt(1 - y**2)
    np.testing.assert_allclose((slope_q[:-1] @ e)[inner], (-A * root)[inner], atol=tol * A)
    np.testing.assert_allclose((strain_p[:-1] @ e)[inner], (-A * root)[inner], atol=tol * A)
    edge = float(strain_q[-1] @ e)
    # at the trailing edge: exact in the graded scheme, half a cell inside in the thesis's
    # (first order there: 3.65/401/pi = 2.9e-3)
    assert edge == pytest.approx(-B, rel=4e-3 if scheme == "graded" else 0.1)


# ---- between meshes -----------------------------------------------------------------------------


def test_loads_are_carried_over_linearly_and_vanish_at_the_ends() -> None:
    old, new = cosine_grid(33).nodes[1:-1], cosine_grid(21).nodes[1:-1]
    loads = Tractions(1 - np.abs(old), 0.5 * (1 - np.abs(old)))  # linear but at a node
    carried = on_columns(old, new, loads)
    np.testing.assert_allclose(carried.pressure, 1 - np.abs(new), atol=1e-14)
    np.testing.assert_allclose(carried.traction, 0.5 * (1 - np.abs(new)), atol=1e-14)
    np.testing.assert_array_equal(padded(np.ones(2)), [0.0, 1.0, 1.0, 0.0])


@pytest.mark.parametrize("cells", [12, 24, 96])
@pytest.mark.parametrize("steps", [40, 85, 112])
def test_cells_of_an_arc_grow_from_the_nip_to_its_far_side(steps: int, cells: int) -> None:
    length = np.exp(steps * STEP)  # one of those that shape cells: none is moved
    arc = Arc.of(length, cells, False)
    assert (arc.rows.size, arc.rows[-1]) == (2 * cells + 1, length)

    def counted(distance: Array) -> Array:
        fine, power, evenness, _ = GRADING
        u = (distance / fine) ** (1 / power)
        return np.asarray(power * np.log1p(u) + evenness * fine / length * u**power)

    # Newton's method stops at 1e-14 of the largest u, which is 1e-10 of a count or less
    total = counted(np.array([length]))[0]
    share = np.arange(2 * cells + 1) / (2 * cells)
    np.testing.assert_allclose(counted(arc.rows), total * share, atol=1e-10)


@pytest.mark.parametrize("entry", [False, True])
def test_what_shapes_an_arc_is_rounded_and_only_its_far_side_moves(entry: bool) -> None:
    length = np.exp(85 * STEP)
    arc = Arc.of(length, 32, entry)
    near, beyond = (Arc.of(length * np.exp(by), 32, entry) for by in (0.4 * STEP, 0.6 * STEP))
    kept = slice(0, 2 * arc.kept + 1)
    assert 32 > arc.kept >= 16
    np.testing.assert_array_equal(near.rows[kept], arc.rows[kept])
    assert near.rows[-1] == length * np.exp(0.4 * STEP)
    assert (np.diff(near.rows) > 0).all()
    assert (near.shape, near.kept) == (arc.shape, arc.kept)
    assert beyond.shape > arc.shape
    # a grid that is followed across the border goes on a little: a width on it settles
    border = length * np.exp(STEP / 2)
    assert Arc.of(border * (1 + OVERLAP / 2), 32, entry, arc.shape).shape == arc.shape
    assert Arc.of(border * (1 + 2 * OVERLAP), 32, entry, arc.shape).shape == beyond.shape


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_published_process_settles_tractions_of_one_sign(sign: float) -> None:
    """All stuck, (1 + S K) q = -(c0 + S p0): the pressure, and q with it, settles step by step."""
    own = np.eye(3)
    problem = StickSlip(
        own, -0.2 * own, sign * np.array([0.7, 0.5, 0.6]), np.ones(3), sign * 0.4 * own,
        friction=np.full(3, 10.0), faces=1,
    )  # fmt: skip
    found = panagiotopoulos(problem)
    exact = -(problem.offset - 0.2) / (1 - sign * 0.08)
    assert (np.sign(exact) == -sign).all()
    # the process stops at changes of 1e-12; each step is 0.08 of the one before
    np.testing.assert_allclose(found.traction, exact, rtol=1e-11)

"""Meshes of a nip and its wraps: geometry, and quadrature and differences against closed forms."""

from __future__ import annotations

from itertools import pairwise
from math import log, pi, sqrt

import numpy as np
import pytest

from woundon.elasticity.mesh import END_SHARE, GRADED_LENGTH, Mesh, Wrap, cosine_nodes, nip_mesh

NONE = Wrap()
ROLL = Wrap(length=0.8 * pi * 40.0, radius=40.0)  # in half widths
DRUM = Wrap(length=1.0 * 30.0, radius=30.0, graded_end=True)
MESHES = {
    "nip": nip_mesh(33, NONE, NONE),
    "roll wrap": nip_mesh(33, NONE, ROLL),
    "both wraps": nip_mesh(33, DRUM, ROLL),
}
each_mesh = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)


@pytest.mark.parametrize("size", [7, 8, 64, 65])
def test_cosine_nodes_are_antisymmetric_and_interlace(size: int) -> None:
    x = cosine_nodes(size)
    assert x.size == 2 * size - 1
    assert (x[0], x[-1]) == (-1.0, 1.0)
    np.testing.assert_array_equal(x, -x[::-1])  # to the last bit
    assert (np.diff(x) > 0).all()
    np.testing.assert_allclose(x[::2], -np.cos(np.linspace(0, pi, size)), rtol=0, atol=1e-15)


@each_mesh
def test_a_mesh_has_one_point_in_each_cell(mesh: Mesh) -> None:
    assert mesh.points.size == mesh.nodes.size - 1 == mesh.cells.size
    assert ((mesh.nodes[:-1] < mesh.points) & (mesh.points < mesh.nodes[1:])).all()
    assert (mesh.nodes[mesh.first], mesh.nodes[mesh.last]) == (-1.0, 1.0)
    # the nip has the same nodes with and without wraps
    np.testing.assert_array_equal(mesh.nodes[mesh.nip_nodes], cosine_nodes(33)[::2])
    np.testing.assert_array_equal(mesh.points[mesh.nip_cells], cosine_nodes(33)[1::2])


def test_wraps_have_their_length_and_their_largest_cell() -> None:
    mesh = MESHES["both wraps"]
    assert -1 - mesh.nodes[0] == pytest.approx(DRUM.length, rel=1e-12)
    assert mesh.nodes[-1] - 1 == pytest.approx(ROLL.length, rel=1e-12)
    behind, before = mesh.cells[mesh.last :], mesh.cells[: mesh.first]
    # distances are sampled with even steps, over which cells grow
    step = pi / 32 / sqrt(2 * GRADED_LENGTH)  # of the grading, and largest cell in rad
    assert behind.max() <= 1.1 * step * ROLL.radius
    assert before.max() <= 1.1 * step * DRUM.radius
    assert (np.diff(behind[: behind.size // 2]) > -1e-9).all()  # graded from the nip on
    assert before[0] < before.max()  # and to the far end where the web arrives
    # cells on both sides of an edge have the same size: the mesh is graded alike
    assert 0.5 < behind[0] / mesh.cells[mesh.last - 1] < 2


@pytest.mark.parametrize("size", [33, 129])
def test_all_cells_shrink_with_those_of_the_nip(size: int) -> None:
    """Twice as many cells in the nip: every cell of the wraps becomes two, near the nip and far."""
    coarse, fine = (nip_mesh(n, DRUM, ROLL) for n in (size, 2 * size - 1))
    for wrap in (slice(0, coarse.first), slice(coarse.last, None)):
        cells = coarse.cells[wrap]
        middle = (coarse.nodes[:-1] + coarse.nodes[1:])[wrap] / 2
        halves = fine.cells[np.searchsorted(fine.nodes, middle) - 1]
        # the first cell of quadratic growth becomes a quarter and three quarters
        assert (halves / cells).min() > 0.2
        assert (halves / cells).max() < 0.8


@each_mesh
def test_linear_functions_are_integrated_and_interpolated_exactly(mesh: Mesh) -> None:
    x, y = mesh.nodes, mesh.points
    f = 3.0 - 0.2 * x
    primitive = 3.0 * x - 0.1 * x**2
    size = np.abs(primitive).max()
    assert mesh.weights @ f == pytest.approx(primitive[-1] - primitive[0], rel=1e-12)
    np.testing.assert_allclose(
        mesh.integral_to_nodes @ np.ones(x.size), x - x[0], rtol=0, atol=1e-13 * (x[-1] - x[0])
    )
    np.testing.assert_allclose(mesh.at_points(f), 3.0 - 0.2 * y, rtol=1e-13)
    np.testing.assert_allclose(mesh.hats @ f, mesh.at_points(f), rtol=1e-13, atol=1e-13 * size)


def test_integrals_of_a_parabola_are_of_second_order() -> None:
    """Lumped hats to the points and trapezoids to the nodes: closed form, convergence order."""
    for matrix, at in (("integral_to_points", "points"), ("integral_to_nodes", "nodes")):
        errors = []
        for size in (17, 33, 65):
            mesh = nip_mesh(size, NONE, NONE)
            to = getattr(mesh, at)
            known = to - to**3 / 3 + 2 / 3
            errors.append(np.abs(getattr(mesh, matrix) @ (1 - mesh.nodes**2) - known).max())
        orders = [log(a / b) / log(2) for a, b in pairwise(errors)]
        assert min(orders) > 1.7, (matrix, orders)


@each_mesh
def test_a_node_moves_only_points_downstream_by_lumped_integrals(mesh: Mesh) -> None:
    """The triangular form on which the uniqueness of the stick-slip problem rests."""
    matrix = mesh.integral_to_points
    assert (matrix >= 0).all()
    np.testing.assert_array_equal(matrix, np.tril(matrix))
    assert (np.diff(matrix, axis=0) >= 0).all()


@each_mesh
@pytest.mark.parametrize("name", ["roll_face", "drum_face"])
def test_faces_are_parts_of_the_mesh(mesh: Mesh, name: str) -> None:
    face = getattr(mesh, name)
    start = mesh.first if name == "roll_face" else 0
    stop = mesh.nodes.size - 1 if name == "roll_face" else mesh.last
    np.testing.assert_array_equal(face.nodes, mesh.nodes[start : stop + 1])
    np.testing.assert_array_equal(face.points[:-2], mesh.points[start:stop])
    assert (face.nodes[face.first], face.nodes[face.last]) == (-1.0, 1.0)
    assert face.extends_downstream == (stop > mesh.last)
    assert face.is_nip == (face.nodes.size == 33)
    # one-sided points: just downstream of the edge, just upstream of the end
    assert face.points[-2] == pytest.approx(1.0, abs=1e-8)
    assert face.points[-1] == pytest.approx(face.nodes[-1], abs=1e-6)
    f = 2.0 + 0.5 * face.nodes
    # the last two rows are one-sided limits; rounding of slopes over cells of 1e-3
    np.testing.assert_allclose(face.hats @ f, 2.0 + 0.5 * face.points, rtol=1e-8)
    np.testing.assert_allclose(face.derivative @ f, 0.5, rtol=1e-9)


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_displacements_and_curvatures_of_a_parabola_are_exact(mesh: Mesh) -> None:
    """v = c x^2/2: v from slopes at the points, and -v'' from their differences."""
    a, c = 2e-3, 7.0
    face = mesh.roll_face
    slope = c * a * face.points
    v = c / 2 * (a * face.nodes) ** 2
    found = face.displacement_at_nodes(slope, v[face.last], a)
    # the midpoint rule is exact where points lie in the middle; graded cells have them off it
    np.testing.assert_allclose(found, v, rtol=0, atol=2e-2 * np.abs(v).max())
    np.testing.assert_allclose(face.curvature_change(slope, a), -c, rtol=1e-6)


def test_the_curvature_is_constant_before_the_end_of_the_roll_wrap() -> None:
    """v = c x^3/6: -v'' = -c x up to the last tenth, in which it is constant."""
    a, c = 2e-3, 7.0
    face = MESHES["roll wrap"].roll_face
    found = face.curvature_change(c * (a * face.points) ** 2 / 2, a)
    x = face.nodes
    start = x[-1] - END_SHARE * ROLL.length
    inside = slice(face.last + 1, np.searchsorted(x, start) - 1)
    # exact where points lie in the middle of cells; they grow by up to a tenth
    np.testing.assert_allclose(found[inside], -c * a * x[inside], rtol=0.05)
    np.testing.assert_allclose(found[x > start], -c * a * start, rtol=0.05)
    assert np.ptp(found[x > start]) == 0.0

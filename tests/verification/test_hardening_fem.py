"""The hardening ring against other finite elements: triangles, another mesh, another assembly.

The other program's body is linear along the web and hardens straight through it, without Poisson's
ratio: P = (K1 + P0) exp(-K2 e_r) - K1, s_t = E_t e_t, tau = G gamma.  Its strains are its own, with
no exact part: the tractions are smooth, so that they need none.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from skfem import (
    Basis,
    BilinearForm,
    ElementTriP2,
    ElementVector,
    LinearForm,
    MeshTri,
    condense,
    solve,
)
from skfem.helpers import grad

from woundon.elasticity import cylinder
from woundon.elasticity.hardening import HardeningLaw
from woundon.elasticity.hardening_surface import HardeningSurface
from woundon.elasticity.influence import InfluenceSurface
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.elasticity.ring_equilibrium import RingPair
from woundon.problems.radial_laws import Pfeiffer

Array = np.ndarray

R, R0, A = 0.1, 0.07, 2.5e-3
K1, K2, P0, E_T, G = 10e3, 100.0, 90e3, 2e9, 8e6
PEAK = 0.6e6


def pressure(x: Array) -> Array:
    return PEAK * np.maximum(1 - (x / A) ** 2, 0.0) ** 2


def traction(x: Array) -> Array:
    return 0.15 * pressure(x) * np.sin(2 * x / A)


# ---- the other program --------------------------------------------------------------------------


def triangles() -> MeshTri:
    """Return the ring cut open, (x, r), finer towards the load."""
    far = pi * R
    near = np.linspace(0, 1.25 * A, 45)
    side = np.concatenate([near, near[-1] + (far - near[-1]) * np.linspace(0, 1, 22)[1:] ** 3.4])
    depth = (R - R0) * np.linspace(0, 1, 24) ** 3
    return MeshTri.init_tensor(np.concatenate([-side[:0:-1], side]), R - depth[::-1])


def strains(u: Any, r: Array) -> tuple[Array, Array, Array]:
    g = grad(u)
    return g[0, 1], R / r * g[1, 0] + u[0] / r, R / r * g[0, 0] + g[1, 1] - u[1] / r


@BilinearForm
def tangent(u: Any, v: Any, w: Any) -> Array:
    r = w.x[1]
    e_r, _, _ = strains(w.old, r)
    (a, b, c), (a2, b2, c2) = strains(u, r), strains(v, r)
    hard = K2 * (K1 + P0) * np.exp(-K2 * e_r)
    return (hard * a * a2 + E_T * b * b2 + G * c * c2) * r / R


@LinearForm
def inside(v: Any, w: Any) -> Array:
    r = w.x[1]
    e_r, e_t, gamma = strains(w.old, r)
    a, b, c = strains(v, r)
    s_r = (K1 + P0) * (1 - np.exp(-K2 * e_r))
    return (s_r * a + E_T * e_t * b + G * gamma * c) * r / R


@LinearForm
def outside(v: Any, w: Any) -> Array:
    return -pressure(w.x[0]) * v[0] + traction(w.x[0]) * v[1]


def other_strain() -> tuple[Array, Array]:
    """Return places and the surface's strain v/R + du/dx there; the loads are raised in steps."""
    mesh = triangles()
    basis = Basis(mesh, ElementVector(ElementTriP2()), intorder=4)
    top = basis.boundary(
        mesh.facets_satisfying(lambda x: np.isclose(x[1], R), boundaries_only=True)
    )
    load = outside.assemble(top)
    x, r = basis.doflocs
    held = np.nonzero(np.isclose(r, R0) | np.isclose(np.abs(x), pi * R))[0]  # nothing moves there
    u = np.zeros(basis.N)
    for share in (0.04, 0.12, 0.3, 0.6, 1.0):
        for _ in range(30):
            old = basis.interpolate(u)
            rest = share * load - inside.assemble(basis, old=old)
            rest[held] = 0
            if np.max(np.abs(rest)) < 1e-9 * np.sum(np.abs(load)):
                break
            u = u + solve(*condense(tangent.assemble(basis, old=old), rest, D=held))
        else:
            raise AssertionError("the other program did not converge")
    v_of, u_of = (np.nonzero(np.isclose(r, R))[0][k::2] for k in (0, 1))
    order = np.argsort(x[v_of])
    places, v, along = x[v_of][order], u[v_of][order], u[u_of][order]
    # parabolas through corners and middles; their slopes in the elements' middles
    middle = places[1:-1:2]
    slope = (along[2::2] - along[:-2:2]) / (places[2::2] - places[:-2:2])
    under = np.abs(middle) < A
    return middle[under], (slope + v[1:-1:2] / R)[under]


# ---- compared -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_strains_under_given_tractions_are_those_of_other_elements() -> None:
    """To 0.3 % of the largest; those of the linear cylinder of the wound roll are far off."""
    law = HardeningLaw(Pfeiffer(K1=K1, K2=K2), E_T, 0.0, G)
    ring = RingPair(R, R0, law, lambda r: np.full(np.shape(r), P0))
    places, other = other_strain()
    face = nip_mesh(129, Wrap(), Wrap()).roll_face
    kernels = cylinder.surface_kernels(R, R0, *law.stiffness(P0))
    linear = InfluenceSurface(kernels, R, True, face, A)
    surface = HardeningSurface(ring, linear, face, A, np.inf)
    p, q = pressure(A * face.nodes), traction(A * face.nodes)
    x = A * face.points[:-2]
    strain, soft = (
        np.interp(places, x, body.deform(p, q).strain[:-2]) for body in (surface, linear)
    )
    inside = (places > x[0]) & (places < x[-1])
    largest = np.max(np.abs(other))
    assert np.max(np.abs(strain - other)[inside]) < 3e-3 * largest
    assert np.max(np.abs(soft - other)[inside]) > 0.5 * largest

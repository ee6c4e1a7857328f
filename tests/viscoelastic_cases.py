"""A rubber, a cover of it, and what it dissipates by harmonics: apart from the solver's kernels."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

import woundon as wo
from woundon.elasticity import cylinder
from woundon.elasticity.layers import RelaxingModuli, stacked_compliance
from woundon.elasticity.mesh import Face, Wrap, nip_mesh
from woundon.elasticity.relaxation import modulus_ratio

Array = np.ndarray

RUBBER = [(3e6, 1e-3), (2e6, 1e-2)]  # E_k, tau_k


def rubber(prony: Any = RUBBER, E: float = 5e6) -> wo.Isotropic:
    return wo.Isotropic(youngs_modulus=E, poissons_ratio=0.45, prony=prony)


def cover(material: wo.Material) -> wo.Cylinder:
    return wo.Cylinder(radius=0.25, core_radius=0.235, material=material)


def compliance(body: Any, speed: float, n: Array) -> Array:
    """Y_n of a rolling body, harmonic by harmonic, from the layers with complex moduli."""
    if isinstance(body, wo.Cylinder):
        depth = cylinder.depth(body.radius, body.core_radius)
        layers, materials = ((depth, *body.material.stiffness),), (body.material,)
    else:
        layers, materials = body._stack, body.materials
    relaxed = [m.relaxation(speed) for m in materials]
    moduli = RelaxingModuli(
        lambda n: np.array([modulus_ratio(r, n / body.radius) for r in relaxed]),
        tuple(m.bulk_is_constant for m in materials),
    )
    is_open = getattr(body, "core", "rigid") == "free"
    return stacked_compliance(n, layers, open_bore=is_open, moduli=moduli)


def compliance_far(body: Any, speed: float, n: Array) -> Array:
    """Y_n up to where it is that of the surface alone, n Y_n being constant from there on."""
    known = compliance(body, speed, n[:1000])
    material = body.material if isinstance(body, wo.Cylinder) else body.materials[0]
    relaxation = material.relaxation(speed)
    tail = cylinder.asymptotic_compliance(6, *material.stiffness)
    far = sum(tail[j][..., None] / n[1000:] ** j for j in range(7))
    far = far / modulus_ratio(relaxation, n[1000:] / body.radius)
    return np.concatenate([known, far], axis=-1)


def fourier(x: Array, values: Array, k: Array) -> Array:
    """Fourier integrals of piecewise linear values that may end with jumps, at k > 0."""
    bends = np.diff(np.diff(values) / np.diff(x), prepend=0.0, append=0.0)
    ends = np.exp(-1j * np.outer(k, x[[0, -1]])) @ (values[[0, -1]] * [1, -1])
    return ends / (1j * k) - (np.exp(-1j * np.outer(k, x)) @ bends) / k**2


def lost_by_harmonics(x: Array, p: Array, q: Array, body: Any, speed: float) -> float:
    """What a body dissipates, by the harmonics of its tractions, per length rolled [N/m]."""
    R, n = body.radius, np.arange(1.0, 20_001.0)
    Y = compliance_far(body, speed, n)
    P, Q = (fourier(x, values, n / R) for values in (p, q))
    # V int (-p v' + q u') dx of p = Re P e^{in theta}, ...: sums over n of n Im of a form in Y
    form = (
        Y[0, 0] * np.abs(P) ** 2
        + Y[1, 1] * np.abs(Q) ** 2
        - 1j * Y[0, 1] * (P.conj() * Q - P * Q.conj())
    )
    return float(-(n * form.imag).sum() / (pi * R))


def nip_face(nodes: int) -> Face:
    return nip_mesh(nodes, Wrap(), Wrap()).roll_face


def gradients(body: wo.Body, face: Face, a: float, speed: float) -> tuple[Array, ...]:
    """Return slopes and strains at the points of the cells by unit inner pressures, tractions."""
    none = np.zeros(face.nodes.size)
    return tuple(part[:-2, 1:-1] for part in body.surface(face, a, speed).tangent(none, none))

"""A hardening stack's law and the ring made of it: one potential, tangents that are derivatives."""

from __future__ import annotations

from math import log1p, pi

import numpy as np
import pytest

import woundon as wo
from woundon.elasticity.hardening import HardeningLaw
from woundon.elasticity.ring_elements import Fineness, RingMesh
from woundon.elasticity.ring_equilibrium import RingPair
from woundon.problems.radial_laws import Constant

Array = np.ndarray

PFEIFFER = wo.Pfeiffer(K1=10e3, K2=127.0)
LAWS = {
    "Pfeiffer": HardeningLaw(PFEIFFER, 3.38e9, 0.185, 10e6),
    "shear hardens": HardeningLaw(PFEIFFER, 3.38e9, 0.185, 10e6, 0.5),
    "polynomial": HardeningLaw(
        wo.Polynomial(coefficients=(1e6, 40.0, 1e-5)), 1e9, 0.1, 5e6, 0.9
    ),
    "power": HardeningLaw(wo.PowerLaw(E0=1e6, k=10e6, m=0.7), 3e9, 0.01, 5e6, 0.7),
    "constant": HardeningLaw(Constant(youngs_modulus=27e6), 3.38e9, 0.185, 10e6),
}  # fmt: skip


def states(n: int = 40) -> tuple[Array, Array]:
    """Return strains of a few per cent, mostly pressed, and wound pressures."""
    rng = np.random.default_rng(3)
    e_r = rng.uniform(-0.02, 0.002, n)
    strain = np.stack([e_r, rng.uniform(-3e-4, 3e-4, n), rng.uniform(-0.02, 0.02, n)], axis=-1)
    return strain, rng.uniform(20e3, 200e3, n)


@pytest.mark.parametrize("name", LAWS)
def test_the_tangent_is_the_derivative_of_the_stress(name: str) -> None:
    law, (strain, P0) = LAWS[name], states()
    tangent = law.stress_state(strain, P0).tangent
    assert np.array_equal(tangent, np.swapaxes(tangent, -1, -2))
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-6
        # central differences of fourth order leave 1e-10 of a modulus here
        near, far = (
            (
                law.stress_state(strain + m * step, P0).stress
                - law.stress_state(strain - m * step, P0).stress
            )
            / (2 * m * step[k])
            for m in (1, 2)
        )
        size = np.max(np.abs(tangent), axis=(-1, -2))[:, None]
        assert np.max(np.abs((4 * near - far) / 3 - tangent[..., k]) / size) < 1e-8


@pytest.mark.parametrize("name", LAWS)
def test_strains_follow_from_the_stresses_by_the_complementary_energy(name: str) -> None:
    """e = dW*/d sigma, differenced; W* written here once more, from the radial law alone."""
    law, (strain, P0) = LAWS[name], states()
    sigma = law.stress_state(strain, P0).stress
    F, E_t, nu = law.radial.strain_at, law.tangential, law.poissons_ratio
    x, w = np.polynomial.legendre.leggauss(40)

    def energy(s: Array) -> Array:
        r, t, tau = np.moveaxis(s, -1, 0)
        P = P0 - r
        half = (P - P0) / 2
        Phi = sum(
            wi * half * (F(P0 + half * (1 + xi)) - F(P0)) for xi, wi in zip(x, w, strict=True)
        )
        ratio = law.radial.modulus(P) / law.radial.modulus(P0)
        G = law.shear * ratio**law.shear_exponent
        return Phi - nu / E_t * r * t + t**2 / (2 * E_t) + tau**2 / (2 * G)

    for k in range(3):
        step = np.zeros(3)
        step[k] = 20.0
        computed = (energy(sigma + step) - energy(sigma - step)) / 40.0
        assert np.max(np.abs(computed - strain[:, k])) < 1e-7 * np.max(np.abs(strain))


def test_a_constant_law_is_linear() -> None:
    law, (strain, P0) = LAWS["constant"], states()
    A_rr, A_tt, A_rt, G = law.stiffness(50e3)
    C = np.array([[A_rr, A_rt, 0], [A_rt, A_tt, 0], [0, 0, G]])
    assert law.stress_state(strain, P0).stress == pytest.approx(strain @ C, rel=1e-11)
    assert A_rt**2 / A_rr == pytest.approx(A_tt - law.tangential)


@pytest.mark.parametrize("gamma", [0.0, 0.01, 0.03])
def test_trial_states_beyond_the_law_have_stresses(gamma: float) -> None:
    """Torn apart or pressed beyond the law's end: finite, rising without a step, definite."""
    measured = np.geomspace(1e3, 400e3, 9)
    test = wo.StackTest(pressure=measured, strain=np.log1p(measured / 10e3) / 127.0)
    for law in (HardeningLaw(radial, 3.38e9, 0.185, 10e6, 0.5) for radial in (PFEIFFER, test)):
        e_r = np.linspace(-0.2, 0.1, 20_001)
        strain = np.stack([e_r, np.zeros(e_r.size), np.full(e_r.size, gamma)], axis=-1)
        found = law.stress_state(strain, np.full(e_r.size, 90e3))
        assert np.all(np.isfinite(found.stress))
        assert found.pressure.max() > law.limit
        # shear presses a stack together whose shear modulus hardens
        assert found.pressure.min() < (law.min_pressure if gamma < 0.02 else 0.0)
        rise = np.diff(found.stress[:, 0])
        assert np.all(rise > 0)
        most = np.maximum(found.tangent[1:, 0, 0], found.tangent[:-1, 0, 0]) * np.diff(e_r)
        assert np.all(rise < 1.5 * most)  # no step
        assert np.all(np.linalg.eigvalsh(found.tangent) > 0)


# ---- the ring -----------------------------------------------------------------------------------

A = 2e-3
COARSE = Fineness(8, 8, 6)


def test_hats_carry_the_load_and_its_moment() -> None:
    mesh = RingMesh(0.1, 0.0445, COARSE, A)
    x = np.linspace(-0.7 * A, 1.7 * A, 12)
    hats = mesh.hat_forces(x)
    size = np.diff(x)[0]
    assert hats.sum(axis=0)[1:-1] == pytest.approx(size, rel=1e-12)
    assert (mesh.nodes @ hats)[1:-1] == pytest.approx(size * x[1:-1], abs=1e-15)
    # once round the roll is where it began
    assert mesh.hat_forces(x + 2 * pi * 0.1) == pytest.approx(hats, abs=1e-15)


def test_the_compliance_is_symmetric() -> None:
    pair = RingPair(0.1, 0.0445, LAWS["shear hardens"], lambda r: np.full(np.shape(r), 90e3))
    mesh = pair.mesh(COARSE, A)
    x = np.linspace(-A, A, 33)
    p, hats = 1e6 * (1 - (x / A) ** 2), mesh.hat_forces(x)
    state = pair.equilibrium(mesh, np.stack([-hats @ p, hats @ (0.1 * p * np.sin(2 * x / A))]))
    Y = mesh.stiffness(state.stress_state.tangent).compliance
    flat = Y.reshape(2 * mesh.nodes.size, -1)
    assert np.max(np.abs(flat - flat.T)) < 1e-8 * np.max(np.abs(flat))


def test_uniform_pressure_strains_by_the_law() -> None:
    """A stack pressed straight: P = (K1 + P0) exp(K2 e) - K1 where nu = 0."""
    law = HardeningLaw(PFEIFFER, 3e9, 0.0, 1e7)
    e = np.array([-0.01, 0.0, 0.002])
    strain = np.stack([e, 0 * e, 0 * e], axis=-1)
    P = law.stress_state(strain, np.full(3, 90e3)).pressure
    assert list(P) == pytest.approx(list(100e3 * np.exp(-127.0 * e) - 10e3))
    assert PFEIFFER.strain_at(90e3) == pytest.approx(log1p(9.0) / 127.0)

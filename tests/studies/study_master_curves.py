"""Master curves of random known rubbers: errors of shifts and moduli.

    python tests/studies/study_master_curves.py --cases 100 --seed 0

Four isotherms over three decades with a scatter of 3 %.  The rubber has a glass transition: a
log-normal spectrum of relaxation times over a plateau, and shifts by the law of Williams, Landel
and Ferry.
"""

from __future__ import annotations

import argparse
from typing import Any, NamedTuple

import numpy as np

import woundon as wo
from woundon.elasticity.prony_fit import complex_modulus, fit_dynamic_moduli

Array = np.ndarray

SCATTER = 0.03
FREQUENCIES = np.logspace(-1, 2, 31)


class Rubber(NamedTuple):
    """A material whose moduli are known at every frequency and temperature."""

    plateau: float
    time: Array
    weight: Array
    C1: float
    C2: float
    reference: float

    @classmethod
    def random(cls, random: np.random.Generator) -> Rubber:
        """Return a rubber with tan delta of 0.05 to 0.5 in a nip at 40 degC."""
        time = np.logspace(-12, 2, 141)
        centre, width = random.uniform(-6, -4), random.uniform(1.0, 2.0)
        weight = np.exp(-0.5 * ((np.log10(time) - centre) / width) ** 2)
        strength = 10 ** random.uniform(0.7, 1.7)
        plateau = 10 ** random.uniform(6, 7)
        weight *= strength * plateau / weight.sum()
        # a shift of about 1.5 to 3 decades from 20 to 60 degC
        return cls(plateau, time, weight, random.uniform(5, 9), random.uniform(80, 140), 40.0)

    def shift(self, temperature: Array) -> Array:
        """Return log10 a."""
        d = np.asarray(temperature) - self.reference
        return np.asarray(-self.C1 * d / (self.C2 + d))

    def modulus(self, frequency: Array) -> Array:
        """Return E at the reference temperature, complex."""
        w = 2j * np.pi * np.asarray(frequency)[:, None] * self.time
        return np.asarray(self.plateau + (w / (1 + w)) @ self.weight)

    def isotherm(self, temperature: float, random: np.random.Generator) -> dict[str, Array]:
        """Return a measured isotherm with the scatter."""
        E = self.modulus(10 ** float(self.shift(np.array(temperature))) * FREQUENCIES)
        scatter = 1 + SCATTER * random.normal(size=(2, E.size))
        return {
            "frequency": FREQUENCIES,
            "storage_modulus": E.real * scatter[0],
            "loss_modulus": E.imag * scatter[1],
        }


class Errors(NamedTuple):
    """Errors of a master curve.

    Attributes
    ----------
    shift : float
        Largest error of log10 a [decades].
    modulus : float
        Largest relative error of E' and E'' of the fitted series at V/2a.
    in_errors : float
        Largest error of a shift in units of its standard error.
    """

    shift: float
    modulus: float
    in_errors: float


def errors_of(rubber: Rubber, random: np.random.Generator, shifts: Any) -> Errors:
    """Shift four isotherms and compare with the known rubber at V/2a, 300 to 3000 Hz."""
    T = np.array([10.0, 25.0, 40.0, 55.0])
    isotherms = {float(t): rubber.isotherm(float(t), random) for t in T}
    curve = wo.master_curve(isotherms, rubber.reference, shifts=shifts)
    fit = fit_dynamic_moduli(curve.frequency, curve.storage_modulus, curve.loss_modulus)
    f = np.array([300.0, 1000.0, 3000.0])
    found, exact = complex_modulus(fit, f), rubber.modulus(f)
    modulus = np.abs([found.real / exact.real - 1, found.imag / exact.imag - 1]).max()
    wrong = np.abs(curve.shifts - rubber.shift(T))
    is_free = ~np.isclose(T, rubber.reference)  # at the reference the shift is 0
    in_errors = float((wrong[is_free] / curve.errors[is_free]).max())
    return Errors(float(wrong.max()), float(modulus), in_errors)


def campaign(cases: int, seed: int, shifts: Any) -> list[Errors]:
    """Return the errors of the master curves of random rubbers."""
    random = np.random.default_rng(seed)
    return [errors_of(Rubber.random(random), random, shifts) for _ in range(cases)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    for kind in ("free", "wlf"):
        table = np.array(campaign(options.cases, options.seed, kind))
        for name, values in zip(Errors._fields, table.T, strict=True):
            quantiles = np.quantile(values, [0.5, 0.9, 1.0])
            print(kind, name, "median, 90 %, largest:", *(f"{q:.3g}" for q in quantiles))

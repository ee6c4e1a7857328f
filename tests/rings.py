"""Independent program for wound rolls: rings of finite thickness, laid one by one."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

import woundon as wo


def _values(schedule: float | wo.Profile, r: np.ndarray) -> np.ndarray:
    """Return the values of a number or of straight lines at radii."""
    if isinstance(schedule, wo.Profile):
        return np.interp(r, schedule.radius, schedule.value)
    return np.full(r.shape, schedule)


class Rings:
    """A roll of rings; ``parts`` of them are a lap.

    Unknown are the pressures P at the inner faces.  Equilibrium gives a ring's hoop stress, that
    its strain, and thus how far its middle has moved; between two middles the stack is as thick as
    its law says of the pressure at the face between them.

    While a lap is laid at the web speed V, a ring of the radius r has the acceleration V^2 r/s^2,
    s the radius of the middle of this lap; after the last one the roll stops.
    """

    def __init__(self, problem: wo.RollProblem, parts: int) -> None:
        stack, h = problem.stack, problem.web_thickness
        laps = round((problem.radius - problem.core.radius) / h)
        count, self.d, self.parts = laps * parts, h / parts, parts
        self.law, self.E, self.nu = stack.radial, stack.tangential, stack.poissons_ratio
        self.E_c = problem.core.effective_stiffness
        self.r = problem.core.radius + self.d * np.arange(count + 1)
        self.middle = (self.r[1:] + self.r[:-1]) / 2
        under = np.repeat(self.r[:-1:parts], parts)  # of the lap
        self.T = problem.tension_curve.at(under)
        self.c = (problem.density or 0.0) * (problem.web_speed or 0.0) ** 2
        self.turn = 0.0  # c/s^2
        # in a lap just laid, of even tension: T h/s at its inner face, zero at the outer one, both
        # less the centrifugal force of what is outside
        T = self.T - self.c
        self.inner = T * (under + h - self.r[:-1]) / self.r[:-1]
        outer = T * (under + h - self.r[1:]) / self.r[1:]
        self.own = (self.inner + outer) / 2
        # strains without stress, after winding: along the rings, through the stack at their faces
        self.grown, self.core_grown = np.zeros((2, count)), 0.0
        self.below = np.zeros(count)  # of the ring below, when a lap was laid: moved, strained
        P = np.zeros(1)
        for k in range(0, count, parts):
            self.turn = self.c / (self.r[k] + h / 2) ** 2
            if k:
                P = self.pressed(P, k, self.inner[k])
                hoop, moved = self.state(P, k)
                strain = self.nu / self.E * self.d * (hoop[-1] - self.T[k - 1]) / 2
                self.below[k] = moved[-1] - strain
            P = np.concatenate([P[:k], self.inner[k : k + parts], [0.0]])
        if self.c:
            running = self.pressed(P, count, 0.0)
            self.running_hoop = self.state(running, count)[0].reshape(laps, parts).mean(axis=1)
            self.running_P = running[::parts]
        self.turn = 0.0
        for schedule, along, through, of_core in (
            (problem.temperature_change, problem.tangential_expansion, problem.radial_expansion,
             problem.core_expansion),
            (problem.moisture_change, problem.tangential_swelling, problem.radial_swelling,
             problem.core_swelling),
        ):  # fmt: skip
            self.grown[0] += along * _values(schedule, self.middle)
            self.grown[1] += through * _values(schedule, self.r[:-1])
            self.core_grown += of_core * float(_values(schedule, self.r[:1])[0])
        self.core_grown -= problem.core_shrinkage
        self.removed, self.open = problem.core_removed, np.zeros(count, dtype=bool)
        P = self.pressed(P, count, 0.0, finished=True)
        hoop, moved = self.state(P, count)
        # of the innermost face: half a ring is thinner by its compression and by its tension
        strain = self.law.strain_at(P[0]) - self.law.strain_at(self.inner[0]) - self.grown[1, 0]
        self.bore_moved = moved[0] + self.d / 2 * (
            strain + self.nu / self.E * (hoop[0] - self.T[0])
        )
        hoop = hoop.reshape(laps, parts)
        self.mean_hoop = hoop.mean(axis=1)
        self.P, self.r = P[::parts], self.r[::parts]
        if parts > 1:  # extrapolated to the faces of each lap
            inner, outer = 1.5 * hoop[:, 0] - hoop[:, 1] / 2, 1.5 * hoop[:, -1] - hoop[:, -2] / 2
            self.face_hoop = np.array([inner, outer])

    def state(self, P: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return hoop stress of the first k rings, and how far they have moved since laid."""
        hoop = -(self.r[1 : k + 1] * P[1:] - self.r[:k] * P[:-1]) / self.d
        hoop = hoop + self.turn * self.middle[:k] ** 2
        since = hoop - self.T[:k] + self.nu * ((P[1:] + P[:-1]) / 2 - self.own[:k])
        return hoop, self.middle[:k] * (since / self.E + self.grown[0, :k])

    def pressed(self, P: np.ndarray, k: int, top: float, finished: bool = False) -> np.ndarray:
        """Return the pressures of k rings under a pressure on the last, by Newton's method.

        In the finished roll a lap may leave the one below it, or the core: pressure and gap are
        both at least zero, and one of them is zero.  A core that is removed has left the first.
        """
        P = np.append(P[:k], top)
        share, half = self.nu / self.E * self.d / 2, np.append(0.5, np.ones(k - 1))
        r, middle = self.r[: k + 1], self.middle[:k] / self.E
        by_in, by_out = (
            middle * (r[:-1] / self.d + self.nu / 2),
            middle * (self.nu / 2 - r[1:] / self.d),
        )
        hoop_in, hoop_out = share * r[:-1] / self.d, -share * r[1:] / self.d
        self.largest = np.max(P)
        for _ in range(50):
            hoop, moved = self.state(P, k)
            miss = (
                moved
                + share * (hoop - self.T[:k])
                + half * self.d * (self.law.strain_at(P[:k]) - self.law.strain_at(self.inner[:k]))
            )
            miss -= half * self.d * self.grown[1, :k]
            miss[0] += self.r[0] * ((P[0] - self.inner[0]) / self.E_c - self.core_grown)
            miss[1:] -= moved[:-1] - share * (hoop[:-1] - self.T[: k - 1]) - self.below[1:k]
            diagonal = by_in + hoop_in + half * self.d / self.law.modulus(P[:k])
            diagonal[0] += self.r[0] / self.E_c
            diagonal[1:] -= by_out[:-1] - hoop_out[:-1]
            low, high = hoop_in[:-1] - by_in[:-1], (by_out + hoop_out)[:-1]
            if finished:
                faces = np.arange(k) % self.parts == 0  # within a lap nothing parts
                self.open = faces & (P[:k] * diagonal < miss)  # at P = 0, miss is the gap
                self.open[0] |= self.removed
                diagonal, miss = (
                    np.where(self.open, 1.0, diagonal),
                    np.where(self.open, P[:k], miss),
                )
                low, high = np.where(self.open[1:], 0.0, low), np.where(self.open[:-1], 0.0, high)
            if k == 1:
                change = miss / diagonal
            else:
                *_, change, _ = lapack.dgtsv(low, diagonal, high, miss, 1, 1, 1, 1)
            P[:k] -= change
            if np.max(np.abs(change)) <= 1e-9 * (self.largest if finished else np.max(P)):
                return P
        raise AssertionError("the rings find no equilibrium")

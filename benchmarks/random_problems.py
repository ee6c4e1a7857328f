"""Random problems of every kind, from the typical range to the limits of all fields.

``wide_nip``, ``wide_wrapped_nip`` and ``wide_rollers`` draw every field log-uniformly; the seed
also determines how far the range extends from the typical values (``typical`` of a field) to all
admissible ones.  ``random_roll`` and ``random_winding`` draw paper, film, foil and board with every
schedule, radial law and core.  ``ending`` says how the solution of a problem ends.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, expm1, log, pi, sqrt
from typing import Any

import numpy as np

import woundon as wo
from woundon.problems.paths import find_places
from woundon.problems.permitted import bounds

__all__ = ["RANDOM", "ending", "estimate_ratio", "random_roll", "random_winding"]

LAWS = ("Pfeiffer", "Polynomial", "PowerLaw", "StackTest", "constant")
SCHEDULES = ("constant", "linear", "hyperbolic", "constant_torque", "profile", "smooth")


class _Draw:
    """Random values between the typical and the admissible range of a field."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.wide = float(self.random.uniform())

    def even(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))

    def log(self, low: float, high: float) -> float:
        return exp(self.even(log(low), log(high)))

    def field(self, of: type[Any], path: str) -> float:
        place = find_places(of, path)[0]
        assert place.quantity is not None
        assert place.quantity.typical is not None
        limits = [bound for _, bound in bounds(place.field)]
        least, most = max(min(limits), 1e-12), max(limits)  # a logarithm needs a positive argument
        ends = zip(place.quantity.typical, (least, most), strict=True)
        low, high = (usual * (limit / usual) ** self.wide for usual, limit in ends)
        return min(max(self.log(low, high), least * (1 + 1e-9)), most * (1 - 1e-9))

    def isotropic(self) -> wo.Isotropic:
        nu = self.even(0.0, 0.5)
        if self.random.random() < 0.3:
            nu = 0.5 - 10 ** self.even(-16, -1)
        E = self.field(wo.Isotropic, "youngs_modulus")
        return wo.Isotropic(youngs_modulus=E, poissons_ratio=min(nu, 0.5 - 1e-16))

    def paper(self) -> wo.Orthotropic:
        rr, tt, shear = (
            self.field(wo.Orthotropic, name) for name in ("radial", "tangential", "shear")
        )
        cross = self.even(0.0, 0.95) * sqrt(rr * tt) * 10 ** self.even(-3, 0)
        return wo.Orthotropic(radial=rr, tangential=tt, cross=min(cross, 1e14), shear=shear)

    def body(self, material: Any, rigid: bool) -> Any:
        radius, kind = self.field(wo.Rigid, "radius"), self.random.integers(3 if rigid else 2)
        core = radius * (1 - min(self.log(1 / 2000, 1), 0.999))
        if kind == 0:
            return wo.Cylinder(radius=radius, core_radius=core, material=material)
        if kind == 1:
            return wo.HalfPlane(radius=radius, material=material)
        return wo.Rigid(radius=radius)

    def nip_fields(self) -> dict[str, Any]:
        paper = self.paper()
        return {
            "web": wo.Web(thickness=self.field(wo.Web, "thickness"), material=paper),
            "roll": self.body(paper, rigid=False),
            "drum": self.body(self.isotropic(), rigid=True),
            "roll_friction": self.field(wo.NipProblem, "roll_friction"),
            "drum_friction": self.field(wo.NipProblem, "drum_friction"),
            "nip_load": self.field(wo.NipProblem, "nip_load"),
            "web_tension": self.field(wo.NipProblem, "web_tension"),
        }


def wide_nip(seed: int) -> wo.NipProblem:
    """Return the nip that belongs to a seed; always the same one."""
    draw = _Draw(seed)
    fields = draw.nip_fields()
    most = fields["drum_friction"] * fields["nip_load"]
    return wo.NipProblem(
        **fields, winding_force=draw.even(-0.99, 0.99) * min(most, 1e7), roll_wrap=0.0
    )


def wide_wrapped_nip(seed: int) -> wo.NipProblem:
    """Return the wrapped nip that belongs to a seed; always the same one."""
    draw = _Draw(seed)
    fields = draw.nip_fields()
    P, T, mu = fields["nip_load"], fields["web_tension"], fields["drum_friction"]
    drum_wrap = draw.even(0.0, pi) if draw.random.random() < 0.7 else 0.0
    most = min(mu * P + T * expm1(mu * drum_wrap), 1e7)
    least = -min(mu * P - T * expm1(-mu * drum_wrap), 1e7)
    return wo.NipProblem(
        **fields, winding_force=draw.even(0.99 * least, 0.99 * most), drum_wrap=drum_wrap,
        roll_wrap=draw.even(0.0, pi) if draw.random.random() < 0.7 else pi,
    )  # fmt: skip


def wide_rollers(seed: int) -> wo.RollerProblem:
    """Return the pair of rollers that belongs to a seed; always the same one."""
    draw = _Draw(seed)
    P = draw.field(wo.RollerProblem, "load")
    mu = max(draw.field(wo.RollerProblem, "friction"), 1e-8)
    how = draw.random.integers(3)
    loads = {"tangential_load": draw.even(-0.99, 0.99) * mu * P}
    if how == 1:
        loads = {"creepage": float(draw.random.choice([-1, 1])) * draw.log(1e-8, 0.1)}
    upper = draw.body(draw.isotropic(), rigid=False)
    return wo.RollerProblem(
        upper=upper, lower=draw.body(draw.isotropic(), rigid=True), load=P,
        friction=mu, motion="static" if how == 2 else "rolling", **loads,
    )  # fmt: skip


# ---- wound rolls --------------------------------------------------------------------------------


def random_roll(seed: int, number: int) -> wo.RollProblem:
    """Return a wound roll: every radial law, schedule and core; hot, cold, on shrinking cores."""
    rng = np.random.default_rng([seed, number])
    law, schedule = LAWS[number % len(LAWS)], str(rng.choice(SCHEDULES))
    return _roll(rng, law, schedule)


def _log(rng: Any, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _roll(rng: Any, law: str, schedule: str) -> wo.RollProblem:
    core, h = _log(rng, 0.01, 0.2), _log(rng, 8e-6, 5e-4)
    radius = core * _log(rng, 1.1, 15)
    tangential, nu = _log(rng, 0.2e9, 80e9), rng.uniform(0, 0.05)
    stress = tangential * _log(rng, 1e-4, 1e-2)  # admissible strains of a web
    tube = rng.random() < 0.3
    more: dict[str, Any] = {}
    if rng.random() < 0.3:
        more = {"temperature_change": rng.uniform(-40, 40),
                "tangential_expansion": _log(rng, 1e-6, 5e-5),
                "radial_expansion": _log(rng, 1e-6, 2e-4), "core_expansion": 1.2e-5}  # fmt: skip
    if rng.random() < 0.2:
        more["core_shrinkage"] = rng.uniform(-1e-3, 1e-3)
    return wo.RollProblem(
        core=wo.Core(radius=core, inner_radius=core * rng.uniform(0, 0.95),
                     material=wo.Isotropic(youngs_modulus=_log(rng, 0.3e9, 200e9),
                                           poissons_ratio=0.3))
        if tube else wo.Core(radius=core, stiffness=_log(rng, 3e7, 1e11)),
        radius=radius, web_thickness=h, density=_log(rng, 400, 3000),
        stack=wo.Stack(radial=_law(rng, law), tangential=tangential, poissons_ratio=nu, shear=1e7),
        wound_on_tension=_tension(rng, schedule, stress * h, core, radius), **more,
    )  # fmt: skip


def _law(rng: Any, law: str) -> Any:
    K1, K2 = _log(rng, 1e3, 2e5), _log(rng, 10, 400)
    if law == "Polynomial":
        return wo.Polynomial(coefficients=[K1 * K2, K2, rng.uniform(-1, 1) * K2 / 5e6])
    if law == "PowerLaw":
        return wo.PowerLaw(E0=_log(rng, 1e4, 1e6), k=_log(rng, 1e6, 5e7), m=rng.uniform(0.2, 1.5))
    if law == "StackTest":
        P = np.concatenate([[0.0], np.geomspace(1e3, 3e6, 25)])
        return wo.StackTest(pressure=P, strain=np.log1p(P / K1) / K2)
    return _log(rng, 1e6, 3e9) if law == "constant" else wo.Pfeiffer(K1=K1, K2=K2)


def _tension(rng: Any, schedule: str, T: float, core: float, radius: float) -> Any:
    if schedule == "constant":
        return T
    if schedule in ("profile", "smooth"):
        r = np.sort(rng.uniform(core, radius, int(rng.integers(1, 12))))
        r = np.unique([core, *r, radius])
        value = T * np.exp(rng.normal(0, 0.2, r.size))
        return wo.Profile(
            radius=r, value=value, between="smooth" if schedule == "smooth" else "lines"
        )
    taper = 0.0 if schedule == "constant_torque" else rng.uniform(-0.3, 0.8)
    return wo.Taper(start=T, taper=taper, law=schedule)


def estimate_ratio(problem: wo.RollProblem) -> float:
    """Return the true error of the pressure, by a solution to rtol 1e-6, over its estimate."""
    result, fine = wo.solve(problem), wo.solve(problem, rtol=1e-6)
    r = np.union1d(np.linspace(problem.core.radius, problem.radius, 400), result.radius)
    error = np.abs(result.at_radius(r)["pressure"] - fine.at_radius(r)["pressure"]).max()
    return float(
        error / (result.errors["peak_pressure"] - np.abs(result.finite_layer_change).max())
    )


# ---- windings -----------------------------------------------------------------------------------


def random_winding(seed: int) -> wo.WindingProblem:
    """Return a winding of paper or film, with any schedule, body and law of the tension."""
    rng = np.random.default_rng(seed)
    core = _log(rng, 0.02, 0.15)
    radius = core * _log(rng, 1.3, 12)
    T, P = _log(rng, 40, 900), _log(rng, 150, 8000)
    tension: Any = T
    if rng.random() < 0.6:
        law = str(rng.choice(["linear", "hyperbolic", "constant_torque"]))
        taper = 0.0 if law == "constant_torque" else rng.uniform(-0.2, 0.6)
        tension = wo.Taper(start=T, taper=taper, law=law)
    load: Any = P
    if rng.random() < 0.3:
        middle = rng.uniform(core, radius)
        load = wo.Profile(radius=[core, middle, radius], value=[P, P * _log(rng, 0.5, 2), P])
    material = wo.Orthotropic(
        radial=_log(rng, 1e7, 3e8), tangential=_log(rng, 2e9, 8e9), cross=5e6,
        shear=_log(rng, 5e6, 1e8),
    )  # fmt: skip
    drum = _log(rng, 0.06, 0.7)
    return wo.WindingProblem(
        web=wo.Web(thickness=_log(rng, 15e-6, 200e-6), material=material),
        stack=wo.Stack(radial=wo.Pfeiffer(K1=_log(rng, 2e3, 2e5), K2=_log(rng, 20, 200)),
                       tangential=material.tangential, poissons_ratio=0.01,
                       shear=_log(rng, 5e6, 4e7)),
        core=wo.Core(radius=core, stiffness=_log(rng, 1e8, 3e10)), radius=radius,
        drum=wo.Rigid(radius=drum) if rng.random() < 0.6 else wo.Cylinder(
            radius=drum, core_radius=0.93 * drum,
            material=wo.Isotropic(youngs_modulus=_log(rng, 5e6, 1e8), poissons_ratio=0.4)),
        roll_friction=_log(rng, 0.1, 0.6), drum_friction=_log(rng, 0.1, 0.7), web_tension=tension,
        nip_load=load, drum_wrap=float(rng.choice([0.0, 1.0])),
        torque_split=None if rng.random() < 0.5 else float(rng.uniform(0, 1)),
        roll_body=str(rng.choice(["effective", "effective", "linear"])),
        tension_law=str(rng.choice(["nip", "nip", "nip", "friction"])),
    )  # fmt: skip


# ---- endings ------------------------------------------------------------------------------------

RANDOM: dict[str, Callable[[int], Any]] = {
    "nip": wide_nip, "wrapped-nip": wide_wrapped_nip, "rollers": wide_rollers,
    "roll": lambda seed: random_roll(1, seed), "winding": random_winding,
}  # fmt: skip


def ending(problem: Callable[[], Any], **options: Any) -> str:
    """Return "solved", "not certified", or type and text of the exception."""
    try:
        residuals = wo.solve(problem(), **options).certified()
    except Exception as fault:  # every kind of exception is an ending
        return f"{type(fault).__name__}: {fault}"
    return "solved" if residuals.largest <= 1e-8 else f"not certified: {residuals}"

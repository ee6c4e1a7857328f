"""Random questions for ``wo.find`` near limits of existence, and scans to check the answers.

A scan solves every point without a neighbour's solution, on a grid that is finer than that of
``find``, and bisects every limit of existence by itself.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import woundon as wo

__all__ = ["KINDS", "Question", "Scan", "random_question"]

Array = np.ndarray
BISECTIONS = 26  # to 1.5e-8 of the distance of two points: a square root is known to 1e-4
SEARCHED = 12  # points of a golden-section search of an extreme value: 0.3 % of three points
GOLDEN = (5**0.5 - 1) / 2

# Field -> factors or, for a field that may be 0, values of its range.
NIP = {
    "nip_load": (0.05, 8.0), "winding_force": (-3e3, 3e3), "web_tension": (1e-3, 10.0),
    "drum_friction": (0.05, 5.0), "roll_wrap": (0.0, 3.14),
    "web.thickness": (0.02, 140.0),
    "roll.material.radial": (0.01, 50.0),
}  # fmt: skip
ROLLERS = {
    "load": (0.01, 300.0), "tangential_load": (-8e4, 8e4), "friction": (0.02, 3.0),
    "upper.layers.0.thickness": (0.003, 12.0), "upper.core_radius": (0.2, 1.5),
}  # fmt: skip
ROLL = {
    "core_shrinkage": (-0.02, 0.02), "temperature_change": (-900.0, 900.0),
    "wound_on_tension": (0.02, 30.0), "core.stiffness": (0.01, 10.0), "core.radius": (0.3, 6.0),
    "radius": (0.3, 4.0), "web_thickness": (0.1, 90.0), "stack.poissons_ratio": (0.0, 1.0),
    "wound_on_tension.taper": (-3.0, 1.0), "radial_expansion": (-3e-4, 3e-4),
}  # fmt: skip
WINDING = {
    "nip_induced_tension": (-20.0, 20.0), "radius": (0.1, 3.0), "core.radius": (0.3, 9.0),
    "stack.poissons_ratio": (0.1, 80.0),
}  # fmt: skip
OUTPUTS = {
    "nip": ("wound_on_tension", "nip_induced_tension", "half_width", "peak_pressure",
            "drum_creepage", "outlet_tension", "offset"),
    "rollers": ("half_width", "peak_pressure", "creepage", "slip_share"),
    "roll": ("core_pressure", "mid_pressure", "peak_pressure", "length", "least_hoop_stress"),
    "winding": ("core_pressure", "mid_pressure", "largest_tension", "mean_wound_on_tension"),
}  # fmt: skip
FIELDS = {"nip": NIP, "rollers": ROLLERS, "roll": ROLL, "winding": WINDING}
OPTIONS: dict[str, dict[str, Any]] = {
    "nip": {"nodes": 33}, "rollers": {"nodes": 33}, "roll": {"rtol": 1e-2},
    "winding": {"rtol": 1e-2},
}  # fmt: skip
KINDS = tuple(FIELDS)


def _nip(random: np.random.Generator) -> wo.NipProblem:
    problem = wo.NipProblem.example()
    load, friction = problem.nip_load * 10 ** random.uniform(-1, 0.3), random.uniform(0.1, 0.5)
    return problem.replace(
        nip_load=load, roll_wrap=float(random.choice([0.0, 0.5, np.pi])),
        web_tension=350 * 10 ** random.uniform(-0.5, 0.5), drum_friction=friction,
        roll_friction=random.uniform(0.1, 0.5),
        winding_force=random.uniform(-0.9, 0.9) * friction * load,
    )  # fmt: skip


def _rollers(random: np.random.Generator) -> wo.RollerProblem:
    if random.random() < 0.4:
        return wo.RollerProblem.example().replace(friction=random.uniform(0.1, 0.6))
    rubber = wo.Isotropic(youngs_modulus=10 ** random.uniform(6.3, 7.5), poissons_ratio=0.45)
    if random.random() < 0.5:
        upper: Any = wo.Cylinder(radius=0.2, core_radius=0.15, material=rubber)
    else:
        upper = wo.Layered(radius=0.2, layers=[{"thickness": 0.02, "material": rubber}])
    return wo.RollerProblem(
        upper=upper, lower=wo.HalfPlane(radius=0.2, material="steel"),
        load=10 ** random.uniform(3, 4), friction=random.uniform(0.2, 0.8), tangential_load=100.0,
    )  # fmt: skip


def _roll(random: np.random.Generator) -> wo.RollProblem:
    example = wo.RollProblem.example()
    changes = {"tangential_expansion": 1e-5, "radial_expansion": 10 ** random.uniform(-5, -4)}
    if random.random() < 0.4:  # a coil of steel strip on a mandrel
        stack = wo.Stack(
            radial=10 ** random.uniform(9, 9.6), tangential=206e9, poissons_ratio=0.01, shear=1e9
        )
        core = wo.Core(diameter="508 mm", stiffness=10 ** random.uniform(10, 11.3))
        problem = wo.RollProblem(core=core, diameter="1500 mm", stack=stack, web_thickness="1 mm",
                                 wound_on_tension="30 MPa")  # fmt: skip
        return problem.replace(**changes)
    tension = {"start": 350.0, "taper": random.uniform(-0.5, 0.6)}
    if random.random() < 0.4:
        law = wo.Polynomial(coefficients=[0.5e6, 40.0, -(10 ** random.uniform(-5, -4.4))])
        stack = wo.Stack(radial=law, tangential=4e9, poissons_ratio=0.01, shear=1e7)
        example = example.replace(stack=stack)
    return example.replace(wound_on_tension=tension, **changes)


def _winding(random: np.random.Generator) -> wo.WindingProblem:
    """Return a winding with a given nip-induced tension, which solves no nips."""
    taper = {"start": 350.0, "taper": random.uniform(0, 0.6)}
    return wo.WindingProblem.example().replace(
        tension_law="fixed", nip_induced_tension=random.uniform(50, 300), web_tension=taper,
        radius=0.3,
    )  # fmt: skip


PROBLEMS = {"nip": _nip, "rollers": _rollers, "roll": _roll, "winding": _winding}


@dataclass
class Scan:
    """The output over a field: a grid with the limits of existence and the extreme values."""

    problem: Any
    name: str
    output: str
    options: dict[str, Any]
    points: dict[float, float] = field(default_factory=dict)
    errors: dict[float, float] = field(default_factory=dict)
    solves: int = 0

    def at(self, value: float) -> float:
        """Return the output; nan where no solution exists."""
        if value not in self.points:
            self.solves += 1
            try:
                result = wo.solve(self.problem.replace(**{self.name: value}), **self.options)
                self.points[value] = float(getattr(result, self.output))
                self.errors[value] = float(result.errors.get(self.output, 0.0))
            except (wo.InvalidProblem, wo.NotConverged):
                self.points[value] = np.nan
        return self.points[value]

    @property
    def curve(self) -> tuple[Array, Array]:
        """The points in ascending order."""
        x = np.array(sorted(self.points))
        return x, np.array([self.points[value] for value in x])

    def over(self, low: float, high: float, count: int) -> Scan:
        """Solve the points of a range, and bisect its limits of existence."""
        space = np.geomspace if low > 0 and high / low >= 10 else np.linspace
        for value in space(low, high, count).tolist():
            self.at(value)
        x, y = self.curve
        for k in np.nonzero(np.isfinite(y[1:]) != np.isfinite(y[:-1]))[0]:
            inside, outside = (x[k], x[k + 1]) if np.isfinite(y[k]) else (x[k + 1], x[k])
            for _ in range(BISECTIONS):
                middle = (inside + outside) / 2
                if np.isfinite(self.at(middle)):
                    inside = middle
                else:
                    outside = middle
        return self

    def extremes(self) -> tuple[float, float]:
        """Return the smallest and the largest output, refined by golden section."""
        for sign in (1, -1):
            x, y = self.curve
            k = int(np.nanargmin(sign * y))
            if 0 < k < x.size - 1 and np.isfinite(y[[k - 1, k + 1]]).all():
                a, b = x[k - 1], x[k + 1]
                for _ in range(SEARCHED):
                    left, right = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
                    if not sign * self.at(left) > sign * self.at(right):
                        b = right
                    else:
                        a = left
        y = self.curve[1]
        return float(np.nanmin(y)), float(np.nanmax(y))

    @property
    def limits(self) -> list[int]:
        """The indices of points at a limit of existence, with a solved neighbour inside."""
        y = np.isfinite(self.curve[1])
        return [
            k
            for k in range(1, y.size - 1)
            if y[k] and (y[k - 1] != y[k + 1])
        ]  # fmt: skip


@dataclass(frozen=True)
class Question:
    """A question to ``wo.find`` whose target lies near or beyond the range of an output."""

    problem: Any
    name: str
    output: str
    target: float
    between: tuple[float, float] | None
    scan: Scan

    def ask(self, **options: Any) -> Any:
        """Return the answer, or the error without a solution."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                return wo.find(self.problem, self.name, between=self.between, **options,
                               **self.scan.options, **{self.output: self.target})  # fmt: skip
            except wo.NoSolution as fault:
                return fault


def random_question(kind: str, seed: int, count: int = 33) -> Question | None:
    """Return a question; None if the range that was drawn has no limit of existence."""
    random = np.random.default_rng([seed, KINDS.index(kind)])
    problem = PROBLEMS[kind](random)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        while True:
            name = str(random.choice(list(FIELDS[kind])))
            base = _number(problem, name)
            if base is not None:
                break
        low, high = FIELDS[kind][name]
        if not (base == 0 or low < 0 or low == 0):
            low, high = base * low, base * high
        share = random.uniform(0.0, 0.3, 2)
        ends = low + share[0] * (base - low), high + share[1] * (base - high)
        between = float(ends[0]), float(ends[1])
        is_default = random.random() < 0.3 and between[0] < base < between[1]
        output = str(random.choice(OUTPUTS[kind]))
        scan = Scan(problem, name, output, OPTIONS[kind]).over(*between, count)
        if not scan.limits:
            return None
        smallest, largest = scan.extremes()
        if largest - smallest < 1e-3 * max(abs(largest), abs(smallest)):
            return None  # the output does not depend on the field
        y = scan.curve[1]
        if random.random() < 0.4:  # beyond the range
            excess = (largest - smallest) * 10 ** random.uniform(-2, 0) + 5e-3 * abs(largest)
            target = largest + excess if random.random() < 0.5 else smallest - excess
        else:  # between the limit and one of the points of its bisection or of the grid
            k = int(random.choice(scan.limits))
            solved = np.nonzero(np.isfinite(y))[0]
            inside = int(random.choice(solved[np.abs(solved - k) <= BISECTIONS]))
            target = y[k] + (y[inside] - y[k]) * 10 ** random.uniform(-3, 0)
    return Question(problem, name, output, float(target), None if is_default else between, scan)


def _number(problem: Any, name: str) -> float | None:
    """Return the value of a field; None if the problem has no such number."""
    value = problem
    for part in name.split("."):
        if isinstance(value, tuple):
            value = value[int(part)] if part.isdigit() and int(part) < len(value) else None
        else:
            value = getattr(value, part, None)
    return float(value) if isinstance(value, float) else None

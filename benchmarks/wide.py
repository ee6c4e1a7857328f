"""Random problems over all that is admissible: solved and certified, or told what to change.

    python benchmarks/wide.py --kind nip --cases 1000

Each seed draws how wide it looks: from the range that is met in practice (a field's ``typical``) to
all that is admissible, in logarithms; then every field from its range.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import warnings
from collections import Counter
from collections.abc import Callable
from math import exp, expm1, log, pi, sqrt
from typing import Any

import numpy as np

import woundon as wo
from woundon.problems.permitted import bounds
from woundon.quantities import find

__all__ = ["ending", "wide_nip", "wide_rollers", "wide_wrapped_nip"]


class _Draw:
    """Draws from a field's range, between what is usual and all that is admissible."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.wide = float(self.random.uniform())

    def even(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))

    def log(self, low: float, high: float) -> float:
        return exp(self.even(log(low), log(high)))

    def field(self, of: type[Any], path: str) -> float:
        place = find(of, path)[0]
        assert place.quantity is not None
        assert place.quantity.typical is not None
        limits = [bound for _, bound in bounds(place.field)]
        least, most = max(min(limits), 1e-12), max(limits)  # a logarithm takes no nil
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


WIDE: dict[str, Callable[[int], Any]] = {
    "nip": wide_nip, "wrapped-nip": wide_wrapped_nip, "rollers": wide_rollers,
}  # fmt: skip


def ending(problem: Any, **options: Any) -> str:
    """Return "solved", or the type and text of what was raised."""
    try:
        result = wo.solve(problem, **options)
    except Exception as fault:
        return f"{type(fault).__name__}: {fault}"
    return "solved" if result.residuals.largest <= 1e-8 else "not certified"


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kind", choices=WIDE, default="nip")
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    told: Counter[str] = Counter()
    first: dict[str, int] = {}
    for seed in range(asked.first, asked.first + asked.cases):
        text = re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", ending(WIDE[asked.kind](seed)))
        told[text] += 1
        first.setdefault(text, seed)
    for text, count in told.most_common():
        print(f"{count:6d}  {text}  (first: seed {first[text]})")


if __name__ == "__main__":
    main()

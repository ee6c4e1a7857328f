"""The laboratory winder's wound-on tension by the theory, and fits of it to the measured points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from math import exp, log
from typing import Literal

import numpy as np

from ..materials import Orthotropic, material
from ..results import NipResult
from ..surface import rig_tension
from .cases import WoundOnTension, measured_tensions, newsprint_nip
from .frame import Scheme
from .sweep import solved
from .table4 import best_rms, rms, table4

__all__ = [
    "FITTED_POINT",
    "NIP_LOADS",
    "THICKNESSES",
    "Fit",
    "FullFit",
    "Table3",
    "Theory",
    "fit",
    "full_fit",
    "table3",
    "theory",
]

NIP_LOADS = (350.0, 876.0, 1751.0, 3502.0, 5837.0)
THICKNESSES = (66e-6, 57e-6)
NODES = 129  # NIT then is known to 0.01 %, and the fits are smooth in what they vary
SEARCH_NODES = 65  # of the full fit's search: NIT to 0.1 %, far below the scatter of the data
FITTED_POINT = (3502.0, 350.0)  # P, T_in [N/m]

Modulus = Literal["shear", "radial"]
_RANGES: dict[str, tuple[float, float]] = {"shear": (1e6, 1e8), "radial": (5e6, 5e8)}


@dataclass(frozen=True)
class Theory:
    """The tension that the theory lets the load cell measure.

    Attributes
    ----------
    thickness : float
        2h [m].
    added : tuple of float
        Wound-on tension by eq. (183) less T_in at each of ``NIP_LOADS`` [N/m].
    """

    thickness: float
    added: tuple[float, ...]

    def at(self, point: WoundOnTension) -> float:
        """Return the wound-on tension at a measured point [N/m]."""
        return point.web_tension + self.added[NIP_LOADS.index(point.nip_load)]

    def misses(self, *, without: tuple[float, float] | None = None) -> tuple[float, ...]:
        """Return theory less measurement at the points, all or ``without`` one (P, T_in) [N/m]."""
        points = measured_tensions()
        return tuple(self.at(p) - p.measured for p in points if p[:2] != without)

    @property
    def rms(self) -> float:
        """RMS over the fifteen points [N/m]."""
        return rms(self.misses())


@dataclass(frozen=True)
class Fit:
    """One modulus fitted to the point (P, T_in) = (3502, 350) N/m, the other held.

    Attributes
    ----------
    modulus : {"shear", "radial"}
    value : float
        What it came to [Pa].
    theory : Theory
    """

    modulus: Modulus
    value: float
    theory: Theory

    @property
    def rms(self) -> float:
        """RMS over the fifteen points, the fitted one (which is met) among them [N/m]."""
        return self.theory.rms

    @property
    def rms_predicted(self) -> float:
        """RMS over the fourteen predicted points [N/m]."""
        return rms(self.theory.misses(without=FITTED_POINT))


@dataclass(frozen=True)
class FullFit:
    """Both moduli fitted to the fifteen points.

    Attributes
    ----------
    shear, radial : float
        What they came to [Pa].
    trade_off : float
        How many times better the best determined combination of ln G and ln A_rr is known than the
        worst: the ratio of the singular values of the residuals' derivatives.
    theory : Theory
    """

    shear: float
    radial: float
    trade_off: float
    theory: Theory


@dataclass(frozen=True)
class Table3:
    """Measurement, theory and fits.

    Attributes
    ----------
    theories : tuple of Theory
        With the thesis's moduli, for each of ``THICKNESSES``.
    fits : tuple of Fit
        Shear and radial modulus, for each of ``THICKNESSES``.
    full_fits : tuple of FullFit
        For each of ``THICKNESSES``.
    thesis_rms : float
        RMS of the thesis's printed theory over the fifteen points [N/m].
    best_rms : float
        RMS of the best model without influence of T_in: the floor [N/m].
    """

    theories: tuple[Theory, ...]
    fits: tuple[Fit, ...]
    full_fits: tuple[FullFit, ...]
    thesis_rms: float
    best_rms: float


class _Rig:
    """The tension that the load cell would measure, for one paper after another."""

    def __init__(self, thickness: float, scheme: Scheme, nodes: int = NODES) -> None:
        self.thickness, self.scheme, self.nodes = thickness, scheme, nodes
        self.last: dict[float, NipResult] = {}  # where the next solution at a load starts

    def added(self, nip_load: float, paper: Orthotropic | None = None) -> float:
        """Return the wound-on tension by eq. (183) less T_in [N/m]."""
        changes = {"nip_load": nip_load, "web.thickness": self.thickness}
        problem = newsprint_nip(paper=paper, **changes)
        result = solved(problem, self.scheme, self.nodes, self.last.get(nip_load))
        self.last[nip_load] = result
        return rig_tension(result) - problem.web_tension

    def theory(self, paper: Orthotropic | None = None) -> Theory:
        """Return the theory's column for a paper, by default Table 2's."""
        return Theory(self.thickness, tuple(self.added(load, paper) for load in NIP_LOADS))


def theory(thickness: float, paper: Orthotropic | None = None, scheme: Scheme = "graded") -> Theory:
    """Compute the theory's column for a web thickness [m] and a paper, Table 2's by default."""
    return _Rig(thickness, scheme).theory(paper)


def _newsprint() -> Orthotropic:
    base = material("newsprint")
    assert isinstance(base, Orthotropic)
    return base


def fit(modulus: Modulus, thickness: float, scheme: Scheme = "graded") -> Fit:
    """Fit one modulus of roll and web to the one point, the other moduli as in Table 2.

    Parameters
    ----------
    modulus : {"shear", "radial"}
    thickness : float
        2h [m].
    scheme : {"graded", "thesis"}
    """
    from scipy.optimize import brentq

    base, rig = _newsprint(), _Rig(thickness, scheme)
    P, T_in = FITTED_POINT
    target = next(p.measured for p in measured_tensions() if p[:2] == FITTED_POINT) - T_in

    def paper(value: float) -> Orthotropic:
        return base.replace(**{modulus: value})

    def miss(logarithm: float) -> float:
        return rig.added(P, paper(exp(logarithm))) - target

    low, high = _RANGES[modulus]
    value = exp(brentq(miss, log(low), log(high), xtol=1e-9))
    return Fit(modulus, value, rig.theory(paper(value)))


def full_fit(thickness: float, scheme: Scheme = "graded") -> FullFit:
    """Fit G and A_rr of roll and web together to the fifteen points, by least squares.

    A model that does not depend on T_in meets the points best where it is nearest to the averages
    over T_in, so that five residuals stand for the fifteen.

    Parameters
    ----------
    thickness : float
        2h [m].
    scheme : {"graded", "thesis"}
    """
    from scipy.optimize import least_squares

    base, rig = _newsprint(), _Rig(thickness, scheme, SEARCH_NODES)
    averages = [row.average for row in table4()]

    def paper(logarithms: Iterable[float]) -> Orthotropic:
        G, A_rr = (exp(value) for value in logarithms)
        return base.replace(shear=G, radial=A_rr)

    def misses(logarithms: np.ndarray) -> np.ndarray:
        return np.subtract(rig.theory(paper(logarithms)).added, averages)

    # steps of 1 %: the valley is so flat that the grid's error shows in smaller ones
    start = [log(base.shear), log(base.radial)]
    bounds = ([log(1e6), log(5e6)], [log(1e9), log(5e9)])
    found = least_squares(misses, start, bounds=bounds, diff_step=[1e-2, 1e-2])
    values = np.linalg.svd(np.asarray(found.jac), compute_uv=False)
    G, A_rr = (exp(value) for value in found.x)
    return FullFit(
        G, A_rr, float(values[0] / values[-1]), theory(thickness, paper(found.x), scheme)
    )


def table3(scheme: Scheme = "graded") -> Table3:
    """Compute Table 3: theory for both thicknesses, and the fits to one point and to all."""
    return _table3(scheme)


@cache
def _table3(scheme: Scheme) -> Table3:
    points = measured_tensions()
    moduli: tuple[Modulus, ...] = ("shear", "radial")
    return Table3(
        theories=tuple(theory(thickness, scheme=scheme) for thickness in THICKNESSES),
        fits=tuple(fit(m, thickness, scheme) for thickness in THICKNESSES for m in moduli),
        full_fits=tuple(full_fit(thickness, scheme) for thickness in THICKNESSES),
        thesis_rms=rms(p.thesis_theory - p.measured for p in points),
        best_rms=best_rms(),
    )

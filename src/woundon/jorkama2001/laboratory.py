"""The laboratory winder's wound-on tension by the theory, and fits of it to the measured points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import exp, log

import numpy as np
import pandas as pd
from scipy.optimize import root_scalar

import woundon as wo

from .cases import ONE_PAPER, measured_tensions, newsprint_nip
from .nips import NODES, swept

__all__ = [
    "FITTED_POINT",
    "MODULI",
    "NIP_LOADS",
    "THICKNESSES",
    "Theory",
    "rms",
    "theories",
    "theory",
]

NIP_LOADS = (350.0, 876.0, 1751.0, 3502.0, 5837.0)
THICKNESSES = (66e-6, 57e-6)  # 2h [m], printed, and with which the printed theory follows
SEARCH_NODES = 65  # of the fit to all points: NIT to 0.1 %, far below the scatter of the data
FITTED_POINT = (3502.0, 350.0)  # P, T_in [N/m]

_SYMBOLS = {"shear": "G", "radial": "A_rr"}
MODULI = tuple(_SYMBOLS)  # that are fitted
# bounds of a modulus fitted alone to the one point, and of both fitted to all [Pa]
_BOUNDS_TO_ONE = {"shear": (1e6, 1e8), "radial": (5e6, 5e8)}
_BOUNDS_TO_ALL = {"shear": (1e6, 1e9), "radial": (5e6, 5e9)}


@dataclass(frozen=True, eq=False)
class Theory:
    """Tension at the load cell as the theory predicts it.

    Attributes
    ----------
    thickness : float
        2h [m].
    added : Series
        Wound-on tension by eq. (183) less T_in, by nip load [N/m].
    fitted : mapping
        Fitted moduli [Pa], ``shear``, ``radial``; none by default.
    fit : FitResult, optional
        The fit by ``wo.fit``, where it was made so.
    """

    thickness: float
    added: pd.Series
    fitted: Mapping[str, float] = field(default_factory=dict)
    fit: wo.FitResult | None = None

    @property
    def name(self) -> str:
        """Name of the theory as a column heading."""
        moduli = [f"{_SYMBOLS[name]} = {E / 1e6:.2f} MPa" for name, E in self.fitted.items()]
        return ", ".join([*(moduli or ["theory"]), f"2h = {self.thickness * 1e6:.0f} um"])

    def tension(self, points: pd.DataFrame) -> np.ndarray:
        """Return the wound-on tension at measured points [N/m]."""
        return (points["web_tension"] + points["nip_load"].map(self.added)).to_numpy()

    @property
    def rms(self) -> float:
        """RMS of theory less measurement over the fifteen points [N/m]."""
        return self._rms(measured_tensions())

    @property
    def rms_predicted(self) -> float:
        """The same over the fourteen points other than the one that the thesis fitted [N/m]."""
        points = measured_tensions()
        return self._rms(points[~_is_fitted(points)])

    def _rms(self, points: pd.DataFrame) -> float:
        """Return the RMS of theory less measurement at points [N/m]."""
        return rms(self.tension(points) - points["measured"].to_numpy())


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def _is_fitted(points: pd.DataFrame) -> pd.Series:
    """Return True for the point that the thesis fitted."""
    P, T_in = FITTED_POINT
    return (points["nip_load"] == P) & (points["web_tension"] == T_in)


def _winder(thickness: float) -> wo.NipProblem:
    """Return the laboratory winder's nip with a web thickness [m]."""
    return newsprint_nip(**{"web.thickness": thickness})


@cache
def theory(solver: str, thickness: float, fitted: tuple[str, ...] = ()) -> Theory:
    """Return the theory with the thesis's moduli, or with some of them fitted.

    Parameters
    ----------
    solver : {"accurate", "thesis"}
        Fits of both moduli are always accurate, because the thesis made no such fit.
    thickness : float
        2h [m].
    fitted : tuple of str
        ``("shear",)`` or ``("radial",)``, fitted to the thesis's point; both, to all points.
    """
    if not fitted:
        return _theory(_winder(thickness), solver)
    if fitted == MODULI:
        return _fitted_to_all(thickness)
    if solver == "accurate":
        points = measured_tensions()
        bounds = {fitted[0]: _BOUNDS_TO_ONE[fitted[0]]}
        return _fitted(bounds, points[_is_fitted(points)], thickness, NODES)
    return _fitted_by_procedure(fitted[0], thickness)


def theories(solver: str) -> tuple[Theory, ...]:
    """Return the theories that Table 3 compares, in its order."""
    return (
        *(theory(solver, thickness) for thickness in THICKNESSES),
        *(theory(solver, thickness, (name,)) for thickness in THICKNESSES for name in MODULI),
        *(theory(solver, thickness, MODULI) for thickness in THICKNESSES),
    )


def _theory(
    problem: wo.NipProblem,
    solver: str,
    fitted: Mapping[str, float] | None = None,
    fit: wo.FitResult | None = None,
) -> Theory:
    """Compute the tensions at all nip loads with the moduli of a problem.

    ``fitted`` are the fitted moduli among them [Pa], ``fit`` the fit that gave them.
    """
    tension = swept(problem, {"nip_load": NIP_LOADS}, solver, ["rig_tension"])["rig_tension"]
    added = tension.to_series() - problem.web_tension
    return Theory(problem.web.thickness, added, fitted or {}, fit)


@cache
def _fitted_to_all(thickness: float) -> Theory:
    """Fit both moduli to all fifteen points."""
    return _fitted(_BOUNDS_TO_ALL, measured_tensions(), thickness, SEARCH_NODES)


def _fitted(
    bounds: Mapping[str, tuple[float, float]], points: pd.DataFrame, thickness: float, nodes: int
) -> Theory:
    """Fit moduli of roll and web, within bounds [Pa], to measured points by least squares.

    ``thickness`` is that of the web [m]; the nips of the fit have ``nodes`` nodes.
    """
    data = {
        "nip_load": points["nip_load"],
        "web_tension": points["web_tension"],
        "rig_tension": points["measured"],
    }
    fit = wo.fit(
        _winder(thickness),
        data,
        {f"roll.material.{modulus}": ends for modulus, ends in bounds.items()},
        tie=ONE_PAPER,
        starts=1,
        profiles=False,
        nodes=nodes,
    )
    values = dict(zip(bounds, fit.estimates.tolist(), strict=True))
    return _theory(fit.problem, "accurate", values, fit)


def _fitted_by_procedure(modulus: str, thickness: float) -> Theory:
    """Fit one modulus to the thesis's point by the procedure of the thesis."""
    points, nip = measured_tensions(), _winder(thickness)
    measured = points["measured"][_is_fitted(points)].item()
    paper = wo.material("newsprint")

    def residual(logarithm: float) -> float:
        """Return theory less measurement for ln of the modulus [N/m]."""
        over = {modulus: [exp(logarithm)]}
        return swept(nip, over, "thesis", ["rig_tension"])["rig_tension"].item() - measured

    start = log(getattr(paper, modulus))
    solution = root_scalar(residual, x0=start, x1=start + 0.05, xtol=1e-7)  # secant method
    if not solution.converged:
        raise wo.NotConverged(f"{modulus} fitted to one point: {solution.flag}")
    value = exp(solution.root)
    paper = paper.replace(**{modulus: value})
    refitted = nip.replace(**{"roll.material": paper, "web.material": paper})
    return _theory(refitted, "thesis", {modulus: value})

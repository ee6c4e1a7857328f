r"""Least squares on measured data, and what the data can tell of the parameters.

    residual r_i = (predicted_i - measured_i) / deviation_i,    S = sum r_i^2

Started from several points, because S may have several minima.  With J = dr/du at the best one and
s^2 = S/(m - p), or 1 where the deviations are known:

    covariance        s^2 (J^T J)^-1
    profile           S_j(u_j) = min of S over the other parameters; the 95 % interval is where
                      S_j - S <= s^2 F(1, m - p): it holds for bent and open valleys too
    identifiability   J = U diag(lambda) V^T: the last column of V is the change of parameters
                      that the data see least, lambda how much they see of it
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..quantities import Quantity
from ..results import Presented, ReadOnly
from . import fitreport
from .descent import COARSE, FINE, End, descend
from .predict import Parameter, Predictor
from .profiles import ProfileLikelihood, profile_of, threshold

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["FitResult", "fit_parameters"]

Array = np.ndarray
SAME_MINIMUM = 1e-3  # relative difference of S, or what descents may leave of it


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(Presented, ReadOnly):
    """A fit and its evidence; m measured values, p parameters.

    Attributes
    ----------
    names : tuple of str
    estimates, standard_errors : (p,) arrays
        SI.
    covariance, correlation : (p, p) arrays
    rms : float
        Root mean square of the residuals, in the outputs' unit, or in deviations if ``weighted``.
    profiles : tuple of ProfileLikelihood
        With the 95 % intervals; empty if not asked for.
    direction : (p,) array
        The change of parameters that the data see least: of ln(value), or of value / range where
        a bound is not positive; the largest entry is 1.
    condition : float
        Ratio of the largest to the smallest singular value of the scaled Jacobian.
    effects : (p,) array
        RMS change of the predictions for +10 % of each parameter alone (10 % of the range).
    joint_effect : float
        The same for ``direction`` at +-10 % of its largest entry.
    minima : tuple of (S, estimates)
        Where the starts ended, best first.
    reached : int
        How many of ``starts`` starts ended in the best minimum.
    measured, fitted : (m,) arrays
    row_outputs, row_numbers : tuples
        Output and row of each measured value.
    quantities : mapping of str to Quantity
        Of parameters and outputs.
    problem : object
        The base problem with the estimates put in.
    """

    names: tuple[str, ...]
    estimates: Array
    standard_errors: Array
    covariance: Array
    correlation: Array
    rms: float
    direction: Array
    condition: float
    effects: Array
    joint_effect: float
    at_bound: tuple[str, ...]
    minima: tuple[tuple[float, tuple[float, ...]], ...]
    reached: int
    starts: int
    solves: int
    measured: Array
    fitted: Array
    row_outputs: tuple[str, ...]
    row_numbers: tuple[int, ...]
    weighted: bool
    profiles: tuple[ProfileLikelihood, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    problem: Any = None

    @property
    def degrees_of_freedom(self) -> int:
        """m - p."""
        return self.measured.size - len(self.names)

    def estimate(self, name: str) -> float:
        """Return the estimate of one parameter."""
        return float(self.estimates[self.names.index(name)])

    def lines(self) -> list[str]:
        """Return the fit as lines of text."""
        return fitreport.lines(self)

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def __repr__(self) -> str:
        return fitreport.line(self)

    def _repr_html_(self) -> str:
        head, *_ = self.lines()
        return self._html_of_table(head, self.to_dataframe(), fitreport.remarks(self))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter: estimate, standard error, 95 % interval, unit [SI]."""
        return fitreport.to_frame(self)

    def to_xarray(self) -> xarray.Dataset:
        """Return parameters along ``parameter`` and measured values along ``measurement`` [SI]."""
        return fitreport.to_dataset(self)

    def to_json(self) -> str:
        """Return the fit as JSON."""
        return fitreport.to_json(self)

    def plot(self, path: Any = None, ax: Any = None, panels: Any = None) -> Any:
        """Draw fitted against measured values ("agreement"), and the profile of each parameter.

        Parameters
        ----------
        path, ax
            As of :func:`woundon.plot`.
        panels : str or sequence of str, optional
            Which to draw: "agreement", names of parameters.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax, panels)


def fit_parameters(
    predictor: Predictor, *, starts: int, seed: int, profiles: Collection[str],
    quantities: Mapping[str, Quantity],
) -> FitResult:  # fmt: skip
    """Fit the predictor's parameters.

    Parameters
    ----------
    predictor : Predictor
    starts : int
        Number of starting points: the base value, the others by Latin hypercube.
    seed : int
    profiles : collection of str
        Parameters whose profile-likelihood intervals are found.
    quantities : mapping of str to Quantity
        Of parameters and outputs.

    Raises
    ------
    InvalidProblem
        If there are fewer measured values than parameters.
    NotConverged
        If no start leads anywhere.
    """
    parameters, m = predictor.parameters, predictor.measured.size
    if m < len(parameters):
        text = f"{len(parameters)} parameters cannot be fitted to {m} measured values"
        raise InvalidProblem.at("vary", text)
    found = sorted(_minima(predictor, _starting_points(parameters, starts, seed)),
                   key=lambda end: end.S)  # fmt: skip
    if not found:
        raise NotConverged(f"no start of the fit could be solved: {predictor.fault}")
    made: tuple[ProfileLikelihood, ...] = ()
    for _ in range(3):
        S, J = found[0].S, found[0].J
        limit = threshold(S, m - len(parameters), predictor.weighted)
        if not profiles or not np.isfinite(limit):
            break
        made = tuple(
            profile_of(predictor, j, found[0], limit, spread)
            for j, spread in enumerate(_spreads(predictor, J, S))
            if parameters[j].name in profiles
        )
        lower, there = min((profile.best for profile in made), key=lambda best: best[0])
        if lower >= S * (1 - _alike(predictor)):
            break
        # a profile walked into a deeper valley that no start had found
        deeper = descend(predictor, there, FINE)
        found = found if deeper is None else sorted([*found, deeper], key=lambda end: end.S)
    return _result(predictor, found, starts, made, quantities)


def _starting_points(parameters: Sequence[Parameter], starts: int, seed: int) -> list[Array]:
    from scipy.stats import qmc

    low, high = np.transpose([p.ends for p in parameters])
    base = np.array([p.start for p in parameters])
    drawn = qmc.LatinHypercube(len(parameters), rng=seed).random(max(starts - 1, 0))
    return [base, *(low + drawn * (high - low))]


def _minima(predictor: Predictor, starts: Sequence[Array]) -> list[End]:
    """Return where each start ends that can be solved; on few nodes as long as they are apart."""
    coarse = predictor.coarse
    if coarse is None:
        return _descents(predictor, starts, FINE)
    found: list[End] = []
    ends: dict[int, End | None] = {}
    for end in _descents(coarse, starts, COARSE):
        if id(end) not in ends:
            known = [fine for fine in ends.values() if fine is not None]
            ends[id(end)] = descend(predictor, end.u, FINE, known)
        fine = ends[id(end)]
        found += [] if fine is None else [fine]
    predictor.solves += coarse.solves
    return found or _descents(predictor, starts, FINE)


def _descents(predictor: Predictor, starts: Sequence[Array], tolerance: float) -> list[End]:
    """Return where each start ends that can be solved."""
    found: list[End] = []
    for start in starts:
        end = descend(predictor, start, tolerance, found)
        found += [] if end is None else [end]
    return found


def _spreads(predictor: Predictor, J: Array, S: float) -> Array:
    """Return the standard errors of u, kept within what a profile can walk."""
    low, high = predictor.low, predictor.high
    error = np.sqrt(np.diag(_covariance(predictor, J, S)))
    width = high - low
    return np.clip(np.nan_to_num(error, nan=np.inf), 1e-4 * width, 0.1 * width)


def _covariance(predictor: Predictor, J: Array, S: float) -> Array:
    """Return s^2 (J^T J)^-1; inf where the data say nothing."""
    m, p = J.shape
    s2 = 1.0 if predictor.weighted else S / (m - p) if m > p else np.nan
    _, values, V = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        return np.asarray((V.T / values**2) @ V * s2)


def _result(
    predictor: Predictor, found: list[End], starts: int,
    profiles: tuple[ProfileLikelihood, ...], quantities: Mapping[str, Quantity],
) -> FitResult:  # fmt: skip
    u, r, J = found[0]
    S, parameters = found[0].S, predictor.parameters
    slope = np.array([p.slope(float(v)) for p, v in zip(parameters, u, strict=True)])
    covariance = slope[:, None] * _covariance(predictor, J, S) * slope
    error = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(error, error)
    # identifiability in relative changes: of the value, or of the range
    unit = np.array([1.0 if p.logarithmic else p.high - p.low for p in parameters])
    _, singular, V = np.linalg.svd(J * unit, full_matrices=False)
    direction = V[-1] / V[-1][np.argmax(np.abs(V[-1]))]
    m, tenth = predictor.measured.size, np.log(1.1)
    rounding = 1e-12 * float(np.sum((predictor.measured / predictor.deviation) ** 2))
    return FitResult(
        names=tuple(p.name for p in parameters),
        estimates=np.array(list(predictor.inputs(u).values())),
        standard_errors=error, covariance=covariance, correlation=correlation,
        rms=float(np.sqrt(S / m)), direction=direction,
        condition=float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf"),
        effects=tenth * np.linalg.norm(J * unit, axis=0) / np.sqrt(m),
        joint_effect=float(tenth * np.linalg.norm(J @ (unit * direction)) / np.sqrt(m)),
        at_bound=tuple(_at_bound(parameters, u)),
        minima=tuple((end.S, tuple(predictor.inputs(end.u).values())) for end in found),
        reached=sum(S * (1 + _alike(predictor)) + rounding >= end.S for end in found),
        starts=starts,
        solves=predictor.solves, measured=predictor.measured,
        fitted=predictor.measured + predictor.deviation * r,
        row_outputs=predictor.row_outputs, row_numbers=predictor.row_numbers,
        weighted=predictor.weighted, profiles=profiles, quantities=quantities,
    )  # fmt: skip


def _alike(predictor: Predictor) -> float:
    """Return the relative difference of S within which minima are the same."""
    freedom = predictor.measured.size - len(predictor.parameters)
    return max(SAME_MINIMUM, COARSE**2 / max(freedom, 1))


def _at_bound(parameters: Sequence[Parameter], u: Array) -> list[str]:
    found = []
    for parameter, value in zip(parameters, u, strict=True):
        low, high = parameter.ends
        if min(value - low, high - value) < 1e-4 * (high - low):
            found.append(parameter.name)
    return found

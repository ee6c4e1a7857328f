"""The result of an operating window: probability, binding margins, operating points, simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import check_arguments, whole_number
from ..errors import InvalidProblem
from ..problems.paths import number_in_si
from ..problems.permitted import is_within
from ..problems.winding import WindingProblem
from ..quantities import Quantity, pure
from .outcome import Outcome
from .progress import Progress
from .run import Workers
from .window_cases import CaseSolver, WindowModel
from .window_map import NEGLIGIBLE, MarginMap, SetPoints, grid, standard_normal

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["LEVELS", "MOST_SAMPLES", "OperatingPoint", "OperatingWindow"]

Array = np.ndarray
MOST_SAMPLES = 100_000  # draws from the distributions
RESERVE = pure("m", "reserve of a margin")
LEVELS = (0.5, 0.9, 0.99)  # of the contours
SIMULATED_TOGETHER = 5  # draws that one worker simulates in a row, each from the one before


class OperatingPoint(NamedTuple):
    """One point of an operating window.

    Attributes
    ----------
    values : mapping of str to float
        Set points by the names of their fields, of schedules at the core, SI units.
    probability : float
        That all margins hold.
    binding : str
        The margin that is nearest to its limit, in its standard deviations.
    margins : mapping of str to (float, float)
        Each reserve with median inputs and its standard deviation, as a share of the limit.
    contributions : mapping of str to float
        Share of the variance of the binding margin that each uncertain input causes, largest first.

    Examples
    --------
    >>> import woundon as wo
    >>> point = wo.OperatingPoint(
    ...     values={"web_tension": 300.0, "nip_load": 2000.0}, probability=0.98,
    ...     binding="blocking", margins={"blocking": (0.2, 0.1), "strength": (0.5, 0.1)},
    ...     contributions={"stack.radial.K2": 0.7, "roll_friction": 0.3},
    ... )
    >>> reserve, deviation = point.margins[point.binding]
    >>> reserve / deviation
    2.0
    """

    values: Mapping[str, float]
    probability: float
    binding: str
    margins: Mapping[str, tuple[float, float]]
    contributions: Mapping[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class OperatingWindow(Outcome):
    """The probability that all margins of a winding hold, over its set points.

    Attributes
    ----------
    problem : WindingProblem
    names : tuple of str
        Dotted names of the fields that are set points: usually ``web_tension``, ``nip_load``
        (``winder.rider_load`` of a two-drum winder) and, if it is varied, ``torque_split``.
    ranges : (d, 2) array
        Values, of schedules at the core, SI units.
    margins : tuple of str
        The margins that have limits.
    uncertain : mapping of str to float
        Relative standard deviations by dotted name.
    axes : tuple of (n,) arrays
        Values of the map along each name, SI units.
    probability : (n, n[, n]) array
        That all margins hold; nan where no steady state exists.
    index : (n, n[, n], margins) array
        Mean distance of each margin from its limit, in its standard deviations.
    points : (p, d) array
        The operating points at which the margins are interpolated, SI units.
    values : (p, margins) array
        The reserves there with median inputs; nan where the winding failed.
    failures : tuple of (point, reason)
        Set points [SI] at which a winding failed, with the reasons.
    errors : mapping of str to float
        Estimated error of the probability, the largest of the map, from ``interpolation``,
        ``expansion`` in the uncertain inputs, and ``sampling``; nan if unknown.
    interpolation, expansion : (margins,) arrays
        Root mean square difference of each mapped margin from windings at other set points, with
        median inputs and with inputs one standard deviation off, as a share of its limit near it.
    windings : int
        Windings whose nips were solved.
    is_coarse : bool
        True for the preview of 3 x 3 points.
    quantities : mapping of str to Quantity
    map : MarginMap
        The margins as functions of set point and inputs.
    model : WindowModel
        The problem whose outputs are the margins.

    Examples
    --------
    >>> import woundon as wo
    >>> board = wo.WindingProblem.example().replace(
    ...     stack=wo.Stack(radial=27e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6),
    ...     radius=0.08, tension_law="friction", limits=wo.Limits(blocking_pressure="200 kPa"),
    ...     **{"web.thickness": "500 um"},
    ... )
    >>> window = wo.operating_window(
    ...     board, web_tension=(200, 500), nip_load=(1e3, 4e3),
    ...     uncertain={"roll_friction": 0.3}, samples=128, workers=1,
    ... )
    >>> window.probability.shape, window.margins
    ((33, 33), ('slip', 'blocking'))
    >>> point = window.at("300 N/m", "2 kN/m")
    >>> print(f"{point.probability:.1f}, limited by {point.binding}")
    0.7, limited by blocking
    """

    problem: WindingProblem
    names: tuple[str, ...]
    ranges: Array
    margins: tuple[str, ...]
    uncertain: Mapping[str, float]
    axes: tuple[Array, ...]
    probability: Array
    index: Array
    points: Array
    values: Array
    failures: tuple[tuple[tuple[float, ...], str], ...]
    errors: Mapping[str, float]
    interpolation: Array
    expansion: Array
    windings: int
    is_coarse: bool
    quantities: Mapping[str, Quantity]
    map: MarginMap
    model: WindowModel

    @property
    def set_points(self) -> SetPoints:
        """The coordinates of the map."""
        return SetPoints(self.names, self.ranges)

    @property
    def binding(self) -> Array:
        """Number of the binding margin over the map; -1 where no steady state exists."""
        return np.where(np.isnan(self.probability), -1, np.argmin(self.index, axis=-1))

    @property
    def dominant(self) -> Array:
        """Number of the input that contributes most to the variance of the binding margin.

        Over the map; -1 where no steady state exists or no input matters.
        """
        x = self.set_points.coordinates(grid(*self.axes))
        binding = self.binding.ravel()
        variances = self.map.variances(x)[np.arange(len(x)), binding]
        known = (binding >= 0) & (variances.sum(axis=-1) > NEGLIGIBLE**2)
        numbers = np.full(len(x), -1)
        if known.any():
            numbers[known] = np.argmax(variances[known], axis=-1)
        return numbers.reshape(self.probability.shape)

    @property
    def best(self) -> OperatingPoint:
        """The point of the map with the highest probability.

        Among equal probabilities, that with the largest distance of the binding margin from its
        limit, in standard deviations.
        """
        highest = np.nanmax(self.probability)
        smallest = self.index.min(axis=-1)
        candidates = np.where(self.probability >= highest - 1e-12, smallest, -np.inf)
        indices = np.unravel_index(int(np.argmax(candidates)), candidates.shape)
        return self.at(*(axis[k] for axis, k in zip(self.axes, indices, strict=True)))

    def at(self, *values: float | str) -> OperatingPoint:
        """Return a point of the window.

        Parameters
        ----------
        *values : float or str
            Of the set points, in the order of ``names``, of schedules at the core; SI or texts with
            units.

        Raises
        ------
        InvalidProblem
            For values outside the ranges of the map.
        """
        point = self._in_si(values)
        x = self.set_points.coordinates(point[None])
        k = int(np.argmin(self.map.distances(x)[0]))
        reserves, deviations = (part[0].tolist() for part in self.map.reserves(x))
        variances = self.map.variances(x)[0, k]
        shares = variances / max(float(variances.sum()), NEGLIGIBLE**2)
        ranked = sorted(zip(self.uncertain, shares.tolist(), strict=True), key=lambda p: -p[1])
        return OperatingPoint(
            values=dict(zip(self.names, point.tolist(), strict=True)),
            probability=float(self.map.probability(x)[0]),
            binding=self.margins[k],
            margins=dict(zip(self.margins, zip(reserves, deviations, strict=True), strict=True)),
            contributions=dict(ranked),
        )

    def _in_si(self, values: tuple[float | str, ...]) -> Array:
        """Return a set point as numbers within the ranges of the map, (d,)."""
        if len(values) != len(self.names):
            text = f"{len(values)} values are given; must be {', '.join(self.names)}"
            raise InvalidProblem.at("values", text)
        given = zip(self.names, values, strict=True)
        point = np.array([number_in_si(self.problem, name, value) for name, value in given])
        for name, value, (low, high) in zip(self.names, point, self.ranges, strict=True):
            if not is_within(value, low, high):  # the ends after rounding too
                must = f"must be >= {low:g} and <= {high:g}, the range of the map"
                raise InvalidProblem.at(name, f"{value:g} is out of range; {must}")
        return point

    def __repr__(self) -> str:
        best = self.best
        return f"OperatingWindow({self._text(best)}: probability {best.probability:.2f})"

    def _text(self, point: OperatingPoint) -> str:
        """Return the set points of a point with units as text."""
        texts = []
        for name, value in point.values.items():
            texts.append(f"{name} {self.quantities[name].text(value)}")
        return ", ".join(texts)

    def answer(self) -> list[str]:
        """Return the point with the highest probability as lines of text."""
        return self._point_lines("highest probability", self.best)

    def remarks(self) -> list[str]:
        """Return the safe share of the map, the errors and the windings, as lines of text."""
        rows = []
        for level in LEVELS:
            share = 100 * np.mean(self.probability >= level)
            rows.append(f"share of the map with a probability of at least {level:g}: {share:.0f} %")
        known = [f"{name} {value:.2f}" for name, value in self.errors.items() if isfinite(value)]
        rows.append(f"estimated errors of the probability, at most: {', '.join(known)}")
        if np.isnan(self.probability).any():
            share = 100 * np.mean(np.isnan(self.probability))
            rows.append(f"no steady state, or not solved: {share:.0f} % of the map")
        preview = " (preview)" if self.is_coarse else ""
        rows.append(f"{self.windings} windings, {len(self.failures)} failed{preview}")
        return rows

    def lines(self, *points: OperatingPoint) -> list[str]:
        """Return the best point, then other points, and the remarks as lines of text."""
        others = [line for point in points for line in self._point_lines("probability", point)]
        return [*self.answer(), *others, *self.remarks()]

    def _point_lines(self, head: str, point: OperatingPoint) -> list[str]:
        """Return lines on a point: probability, margins, contributions to the variance."""
        rows = [f"{head} {point.probability:.2f} at {self._text(point)}"]
        for name, (mean, deviation) in point.margins.items():
            mark = "  binding" if name == point.binding else ""
            rows.append(f"  {name:<14}{RESERVE.text(mean, '+8.2f', error=deviation)}{mark}")
        largest = list(point.contributions.items())[:3]
        shares = [f"{name} {100 * share:.0f} %" for name, share in largest if share > 0.005]
        return [*rows, f"  variance of {point.binding}: {', '.join(shares) or 'none'}"]

    def to_dataframe(self) -> pd.DataFrame:
        """Return the map as a table, SI units.

        A row for each point: the set points, the probability, the binding margin, and of each
        margin the reserve with median inputs and its standard deviation.
        """
        import pandas as pd

        mesh = grid(*self.axes)
        reserve, deviation = self.map.reserves(self.set_points.coordinates(mesh))
        columns: dict[str, Any] = dict(zip(self.names, mesh.T, strict=True))
        columns["probability"] = self.probability.ravel()
        words = np.array([*self.margins, ""], dtype=object)  # the last one, -1, if none is binding
        columns["binding"] = words[self.binding.ravel()]
        unknown = np.isnan(self.probability.ravel())
        for k, name in enumerate(self.margins):
            columns[f"margins.{name}"] = np.where(unknown, np.nan, reserve[:, k])
            columns[f"margins.{name} +-"] = np.where(unknown, np.nan, deviation[:, k])
        return pd.DataFrame(columns)

    def table_for_display(self) -> pd.DataFrame:
        """Return a row for each margin at the best point: reserve and standard deviation."""
        import pandas as pd

        columns = ["reserve", "standard deviation"]
        return pd.DataFrame.from_dict(dict(self.best.margins), "index", columns=columns)

    def _record(self) -> dict[str, Any]:
        return {
            "best": self.best._asdict(),
            "errors": self.errors,
            "uncertain": self.uncertain,
            "windings": self.windings,
            "failures": self.failures,
        }

    def simulate(
        self,
        *values: float | str,
        samples: int = 100,
        seed: int = 1,
        workers: int | None = None,
        scheduler: str | None = None,
        progress: bool | Progress = False,
    ) -> float:
        """Return the probability by Monte Carlo simulation with windings.

        Independent of the interpolation and of the expansion in the inputs: each sample is a
        winding whose nips are solved.

        Parameters
        ----------
        *values : float or str
            As of :meth:`at`.
        samples, seed : int
            Number of draws, and their seed, which differs from that of the map by default.
        workers, scheduler, progress
            As of :func:`~woundon.operating_window`.

        Returns
        -------
        float
            Share of the windings that keep all limits; one without a solution keeps none.

        Raises
        ------
        InvalidProblem
            As of :meth:`at`, and for an invalid number of samples or seed.
        """
        whole_number("samples", samples, 1, MOST_SAMPLES)
        check_arguments(seed=seed)
        x = self.set_points.coordinates(self._in_si(values)[None]).repeat(samples, axis=0)
        z = standard_normal(len(self.uncertain), samples, seed)
        solver = CaseSolver(
            self.model,
            self.set_points,
            self.uncertain,
            Workers(workers, scheduler),
            chunk=SIMULATED_TOGETHER,
        )
        # the stage names a folder, and nothing is stored
        margins = solver.solve("", x, z, progress=progress).margins
        return float(np.mean((margins >= 0).all(axis=1)))

"""Thesis Table 4: the winding theorem on measured tensions.

In centre winding the nip adds the same tension whatever the web brings along (the winding
theorem), so measured wound-on tension less T_in should depend on the nip load alone.  What is left
of it between the tensions is scatter that no model of this kind can follow.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import fsum, sqrt
from statistics import fmean, stdev

import numpy as np

from .cases import WoundOnTension, measured_tensions
from .frame import Figure, Scheme, Table, Verdict

__all__ = ["AddedTension", "best_rms", "figures", "report", "rms", "table4"]

# averages and standard deviations by nip load, rows put right [N/m]
PRINTED_AVERAGES = (72.0, 142.0, 230.0, 345.0, 459.0)
PRINTED_DEVIATIONS = (17.0, 10.0, 13.0, 9.0, 7.0)


@dataclass(frozen=True)
class AddedTension:
    """What the nip adds at one load: measured wound-on tension less T_in.

    Attributes
    ----------
    nip_load : float
        [N/m].
    values : tuple of float
        One for each web tension, in increasing order [N/m].
    """

    nip_load: float
    values: tuple[float, ...]

    @property
    def average(self) -> float:
        """Average over the web tensions [N/m]."""
        return fmean(self.values)

    @property
    def deviation(self) -> float:
        """Standard deviation between the web tensions, of a sample [N/m]."""
        return stdev(self.values)


def rms(values: Iterable[float]) -> float:
    """Return the root of the mean square."""
    squares = [v * v for v in values]
    return sqrt(fsum(squares) / len(squares))


def table4() -> tuple[AddedTension, ...]:
    """Return the measured tension that the nip added, by nip load."""
    by_load: dict[float, list[WoundOnTension]] = {}
    for point in measured_tensions():
        by_load.setdefault(point.nip_load, []).append(point)
    return tuple(
        AddedTension(load, tuple(p.measured - p.web_tension for p in points))
        for load, points in by_load.items()
    )


def best_rms() -> float:
    """Return the RMS that the best model without influence of T_in leaves in the data [N/m]."""
    return rms(value - row.average for row in table4() for value in row.values)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Return Table 4; measured data, the scheme plays no part."""
    rows = table4()
    columns = {
        "nip_load [N/m]": [row.nip_load for row in rows],
        **{f"added at T_in {T} N/m [N/m]": [row.values[k] for row in rows]
           for k, T in enumerate((175, 263, 350))},
        "average [N/m]": [row.average for row in rows],
        "deviation [N/m]": [row.deviation for row in rows],
    }  # fmt: skip
    title = "The winding theorem on measured tensions of newsprint"
    table, text = Table.of(columns), report()
    return (Figure("table4", title, scheme, table, _verdicts(rows), text=text, one_scheme=True),)


def _verdicts(rows: tuple[AddedTension, ...]) -> tuple[Verdict, ...]:
    relative = [100 * row.deviation / row.average for row in rows]
    averages = np.subtract([row.average for row in rows], PRINTED_AVERAGES)
    deviations = np.subtract([row.deviation for row in rows], PRINTED_DEVIATIONS)
    chance, columns = _influence_of_tension(rows)
    return (
        Verdict(
            "apart from very low nip loads the added tension does not depend on T_in, to a good "
            "relative accuracy: standard deviation between the T_in over the average",
            max(relative[1:]), high=10.0, unit="%",
            note="largest from 876 N/m on; by load "
            + ", ".join(f"{value:.0f}" for value in relative) + " %",
        ),
        Verdict(
            "at the lowest nip load it does", relative[0], 10.0, unit="%",
            note="the same ratio at 350 N/m",
        ),
        Verdict(
            "T_in has no systematic influence: chance that scatter alone makes the averages over "
            "the loads differ as they do", chance, 0.05,
            note="analysis of variance, load and T_in as factors; the averages at T_in = 175, 263 "
            "and 350 N/m are " + ", ".join(f"{value:.0f}" for value in columns) + " N/m.  The "
            "thesis did not test this; fifteen points could not show less than some 20 N/m",
        ),
        Verdict(
            "the printed averages follow from Table 3: largest distance",
            float(np.max(np.abs(averages))), high=0.7, unit="N/m", note="whole N/m are printed",
        ),
        Verdict(
            "and the printed standard deviations", float(np.max(np.abs(deviations))), high=0.7,
            unit="N/m", note="of a sample of three",
        ),
    )  # fmt: skip


def _influence_of_tension(rows: tuple[AddedTension, ...]) -> tuple[float, np.ndarray]:
    """Return the p-value of T_in in a two-way analysis of variance, and the averages by T_in."""
    from scipy.special import fdtrc

    added = np.array([row.values for row in rows])
    loads, tensions = added.shape
    by_tension, whole = added.mean(axis=0), added.mean()
    left = added - added.mean(axis=1, keepdims=True) - by_tension + whole
    between = loads * np.sum((by_tension - whole) ** 2) / (tensions - 1)
    freedom = (loads - 1) * (tensions - 1)
    F = between / (np.sum(left**2) / freedom)
    return float(fdtrc(tensions - 1, freedom, F)), by_tension


def report() -> str:
    """Return Table 4 as text."""
    lines = ["Winding theorem on measured data: wound-on tension less T_in [N/m]",
             "nip load   T_in 175   263   350   average   deviation"]  # fmt: skip
    for row in table4():
        values = " ".join(f"{v:5.0f}" for v in row.values)
        average = f"{row.average:7.1f}   {row.deviation:9.1f}"
        lines.append(f"{row.nip_load:8.0f}      {values}   {average}")
    lines.append(f"RMS of the best model without T_in: {best_rms():.1f} N/m")
    return "\n".join(lines)

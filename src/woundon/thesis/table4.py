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

from .cases import WoundOnTension, measured_tensions

__all__ = ["AddedTension", "best_rms", "report", "rms", "table4"]


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


if __name__ == "__main__":
    print(report())

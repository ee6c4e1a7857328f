"""The thickness of a web across its width, as a scanner measures it, and its lanes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, length, pure, share, thickness_of_web
from .description import Description
from .fields import (
    Number,
    Numbers,
    OptionalNested,
    OptionalNumbers,
    check_equal_lengths,
    check_rising,
    check_within,
    default,
)
from .messages import quote
from .permitted import SearchedWithin
from .units import parse

__all__ = [
    "Lanes",
    "OptionalThicknessProfile",
    "Oscillation",
    "ThicknessProfile",
    "faults_across",
    "means_between",
    "warnings_across",
]

Array = np.ndarray

# Relative to the mean.  Webs vary by a few per cent; other values are errors of the table.
THINNEST, THICKEST = 0.5, 1.5
# Of a thickness, in a search.  A roll with a lane that is 35 % thicker than the others takes a
# minute: nearly all lanes are slack, and become so within short stages.
USUAL_CHANGE = 0.04
THICKEST_WEB = 0.1  # [m]; a larger thickness is relative
ROUNDING = 1e-12  # relative thickness
MOST_LANES = 10_000  # as many as a profile has positions at most
MOST_MOVED = 10.0  # amplitude of an oscillation [m]
NARROW_LANES = 2000  # on which the extremes of an oscillating profile are found
MOST_SLACK = 0.1  # of the length: more would not run straight
MOST_DIFFERENT = 0.02  # of the width of a problem: a scanner does not measure the last millimetres
# Relative difference between the mean of a profile and the web thickness that needs a warning.
CALIPERS_DIFFER = 0.1

# Field of rolls and windings.
Oscillation = Annotated[
    Number,
    length("a_o", "amplitude of the oscillation of the web across the roll", typical=(0.0, 0.1)),
    Field(ge=0, le=MOST_MOVED),
]


class Lanes(NamedTuple):
    """The lanes of a web.

    Attributes
    ----------
    position : (L,) array
        Centre of each lane across the web [m].
    share : (L,) array
        w, fraction of the width; the sum is 1.
    excess : (L,) array
        d, additional thickness relative to the mean [1]; the sum of w d is 0.
    slack : (L,) array
        b, additional length relative to the web [1].
    """

    position: Array
    share: Array
    excess: Array
    slack: Array


class ThicknessProfile(Description):
    """The thickness of the web across its width, linear between the positions.

    Only its variation relative to the mean matters: the mean is the thickness of the web of the
    problem.  The width is that from the first to the last position.

    Parameters
    ----------
    position : sequence of float
        Positions across the web [m], rising.
    thickness : sequence of float
        Thickness there, > 0: absolute [m], as text with a unit ("66 um", "45 gsm" if the density of
        the web is given), or relative to the mean (0.99, 1.01).
    variation : float
        Factor of the deviations of the thickness from its mean, 1 for the profile as measured; 0.5
        halves a band.  Studies vary it.
    slack : sequence of float, optional
        b, additional length of a baggy lane relative to the rest of the web [1], >= 0; by default
        the web has the same length everywhere.
    spread : sequence of float, optional
        Sample standard deviation of the thickness between several scans, in the unit of
        ``thickness``; it is reported only.

    Raises
    ------
    InvalidProblem
        For lists of different lengths, positions that do not rise, a thickness outside of half to
        one and a half of the mean, or a missing value.

    Examples
    --------
    >>> import woundon as wo
    >>> band = wo.ThicknessProfile(
    ...     position=["0 m", "0.9 m", "0.95 m", "1.05 m", "1.1 m", "2 m"],
    ...     thickness=["66 um", "66 um", "66.5 um", "66.5 um", "66 um", "66 um"])
    >>> f"{100 * band.lanes(50).excess.max():.2f} %"
    '0.70 %'
    """

    position: Annotated[
        Numbers,
        length("y", "positions across the web"),
        Field(min_length=2, max_length=10_000),
    ] = Field(...)
    thickness: Annotated[
        Numbers,
        Quantity("h_y", "m", "thickness at these positions", "um", other_form="basis weight"),
        SearchedWithin(USUAL_CHANGE),
        Field(min_length=2, max_length=10_000),
    ] = Field(...)
    variation: Annotated[
        Number,
        pure("k_h", "factor of the variation of the thickness", (0.0, 2.0)),
        SearchedWithin(1.0),
        Field(ge=0, le=10),
    ] = default(1.0)
    slack: Annotated[
        OptionalNumbers,
        share("b", "additional length of the lanes there"),
        SearchedWithin(1.0),
        Field(min_length=2, max_length=10_000),
    ] = default(None)
    spread: Annotated[
        OptionalNumbers,
        Quantity("s_h", "m", "standard deviation of the thickness between scans", "um"),
        Field(min_length=2, max_length=10_000),
    ] = default(None)

    @model_validator(mode="after")
    def _check_columns(self) -> Self:
        """Reject positions that do not rise, and values that are no variation of one thickness."""
        check_equal_lengths(self, "position", "thickness")
        check_rising(self, "position")
        for k, h in enumerate(self.thickness):
            if h <= 0:
                raise InvalidProblem.at(
                    f"thickness.{k}", f"{quote(h)} is out of range; must be > 0 [m]"
                )
        mean, unit = self.mean, "" if self.is_relative else " [m]"
        for k, h in enumerate(self.thickness):
            if not THINNEST * mean <= h <= THICKEST * mean:
                text = f"{quote(h)} is out of range; must be >= {THINNEST * mean:.4g} and <= "
                text += f"{THICKEST * mean:.4g}{unit}, {THINNEST:g} to {THICKEST:g} of the mean"
                raise InvalidProblem.at(f"thickness.{k}", text)
        largest = max(abs(h / mean - 1) for h in self.thickness)
        if self.variation * largest > THICKEST - 1:
            text = f"{quote(self.variation)} is out of range; must be >= 0 and <= "
            text += f"{(THICKEST - 1) / largest:.4g}, for a thickness of {THINNEST:g} to "
            raise InvalidProblem.at("variation", f"{text}{THICKEST:g} of the mean")
        if self.slack is not None:
            check_equal_lengths(self, "position", "slack")
            check_within(self, "slack", 0.0, MOST_SLACK)
        if self.spread is not None:
            check_equal_lengths(self, "position", "spread")
            for k, s in enumerate(self.spread):
                if not 0 <= s <= mean:
                    text = f"{quote(s)} is out of range; must be >= 0 and <= {mean:.4g}{unit}"
                    raise InvalidProblem.at(f"spread.{k}", text)
        return self

    @property
    def width(self) -> float:
        """Distance of the last position from the first [m]."""
        return self.position[-1] - self.position[0]

    @cached_property
    def mean(self) -> float:
        """Mean thickness over the width, in the unit of ``thickness``."""
        return float(np.trapezoid(self.thickness, self.position)) / self.width

    @property
    def is_relative(self) -> bool:
        """Whether ``thickness`` is relative to a mean of about 1 or 100, not in metres."""
        return self.mean > THICKEST_WEB

    def lanes(self, count: int, oscillation: float | str = 0.0) -> Lanes:
        """Return the mean thickness and slack of equally wide lanes.

        An oscillating web moves across the roll to and fro at a constant speed, so that a place of
        the roll receives all parts of the web within the amplitude alike.  At an edge the profile
        is continued by its mirror image.  Both means are exact: the volume of the web is conserved.

        Parameters
        ----------
        count : int
            L, number of lanes, 1 to 10000.
        oscillation : float or str
            Amplitude [m], 0 to 10: the web moves by as much to either side.

        Raises
        ------
        InvalidProblem
            For a number of lanes or an amplitude out of range.
        """
        is_count = isinstance(count, (int, np.integer)) and not isinstance(count, bool)
        if not is_count or not 1 <= count <= MOST_LANES:
            text = f"{quote(count)} is out of range; must be a whole number, 1 to {MOST_LANES}"
            raise InvalidProblem.at("count", text)
        oscillation = _amplitude(oscillation)
        ends = np.linspace(self.position[0], self.position[-1], count + 1)
        thickness = means_between(self.position, self.thickness, ends, oscillation)
        slack = np.zeros(count)
        if self.slack is not None:
            slack = means_between(self.position, self.slack, ends, oscillation)
        excess = self.variation * (thickness / np.mean(thickness) - 1)
        excess[np.abs(excess) < ROUNDING] = 0.0  # an even web is even
        middle, shares = (ends[1:] + ends[:-1]) / 2, np.full(count, 1 / count)
        return Lanes(middle, shares, excess - np.mean(excess), slack)

    def extremes(self, oscillation: float | str = 0.0, further: Iterable[float] = ()) -> Lanes:
        """Return lanes without a share of the width at the extreme places of the profile.

        They are the thickest and the thinnest place, and those of the largest and the smallest
        slack.

        Parameters
        ----------
        oscillation : float or str
            Amplitude [m].
        further : iterable of float
            Positions of further lanes [m].
        """
        oscillation = _amplitude(oscillation)
        places = np.asarray(self.position)
        if oscillation:  # the mean over all shifts, on narrow lanes
            fine = self.lanes(NARROW_LANES, oscillation)
            places, d, b = fine.position, fine.excess, fine.slack
        else:
            d = self.variation * (np.asarray(self.thickness) / self.mean - 1)
            b = np.zeros(places.size) if self.slack is None else np.asarray(self.slack)
        chosen = [np.argmax(d), np.argmin(d), np.argmax(b), np.argmin(b)][: 2 if not b.any() else 4]
        y = np.append(places[chosen], list(further))
        return Lanes(y, np.zeros(y.size), np.interp(y, places, d), np.interp(y, places, b))


# Field of rolls and windings.
OptionalThicknessProfile = Annotated[
    OptionalNested[ThicknessProfile], Field(description="thickness of the web across its width")
]


def _amplitude(oscillation: float | str) -> float:
    """Return the amplitude of an oscillation in SI; reject one out of range, and nan."""
    value = oscillation.item() if isinstance(oscillation, np.generic) else oscillation
    amplitude = parse(value, "m", "oscillation")
    if not 0 <= amplitude <= MOST_MOVED:
        text = f"{quote(oscillation)} is out of range; must be >= 0 and <= {MOST_MOVED:g} [m]"
        raise InvalidProblem.at("oscillation", text)
    return amplitude


def means_between(
    position: Iterable[float], values: Iterable[float], ends: Array, moved: float = 0.0
) -> Array:
    """Return the means of a piecewise linear function between ``ends``, and over all shifts of it.

    Parameters
    ----------
    position, values : sequences of float
        The function from the first to the last position; beyond, it is mirrored.
    ends : (L + 1,) array
        Of L intervals.
    moved : float
        Shifts from -moved to moved are averaged.
    """
    from scipy.interpolate import make_interp_spline

    y, v = np.asarray(position, dtype=float), np.asarray(values, dtype=float)
    width = y[-1] - y[0]
    copies = int(np.ceil(moved / width))
    pieces_y, pieces_v = [y], [v]
    for k in range(1, copies + 1):  # mirrored at the ends, again and again
        flipped_y, flipped_v = (y, v) if k % 2 == 0 else (y[0] + y[-1] - y[::-1], v[::-1])
        pieces_y = [flipped_y[:-1] - k * width, *pieces_y, flipped_y[1:] + k * width]
        pieces_v = [flipped_v[:-1], *pieces_v, flipped_v[1:]]
    function = make_interp_spline(np.concatenate(pieces_y), np.concatenate(pieces_v), k=1)
    if not moved:
        integral = function.antiderivative()(ends)
        return np.asarray(np.diff(integral) / np.diff(ends))
    twice = function.antiderivative(2)
    integral = (twice(ends + moved) - twice(ends - moved)) / (2 * moved)
    return np.asarray(np.diff(integral) / np.diff(ends))


def faults_across(problem: Any, width: float | None = None) -> Iterator[tuple[str, str]]:
    """Yield (field, message) for a profile that contradicts other fields of a roll or a winding.

    Parameters
    ----------
    problem : RollProblem or WindingProblem
    width : float, optional
        Of the web [m], if the problem states it.
    """
    profile = problem.thickness_profile
    if profile is None:
        return
    if problem.gauge_excess:
        text = f"{quote(problem.gauge_excess)} is given together with thickness_profile; must be "
        yield "gauge_excess", f"{text}one of the two"
    if problem.oscillation > profile.width / 2:
        text = f"{quote(problem.oscillation)} is out of range; must be >= 0 and <= "
        yield "oscillation", f"{text}{profile.width / 2:.4g} [m], half the width of the profile"
    if width is not None and abs(profile.width / width - 1) > MOST_DIFFERENT:
        low, high = ((1 + side * MOST_DIFFERENT) * width for side in (-1, 1))
        text = f"covers a width of {profile.width:.6g} [m]; must be >= {low:.6g} and <= {high:.6g}"
        yield "thickness_profile.position", f"{text} [m], the width of the web"


def warnings_across(problem: Any, web_thickness: float) -> Iterator[str]:
    """Yield warnings about the thickness across the width.

    For an oscillation without a profile, and for a profile in metres whose mean is not the
    thickness of the web: relative thicknesses have a mean of about 1 or 100.
    """
    profile = problem.thickness_profile
    if profile is None and problem.oscillation:
        yield f"oscillation = {problem.oscillation:.6g} m is not used: there is no profile"
    if profile is None or profile.is_relative:
        return
    if abs(profile.mean / web_thickness - 1) > CALIPERS_DIFFER:
        mean, web = map(thickness_of_web().stored_text, (profile.mean, web_thickness))
        yield (
            f"thickness_profile.thickness: the mean is {mean} and the web is {web} thick; only the "
            "variation about the mean is used"
        )

r"""Simply supported beams across a web, on the elastic foundation of a nip.

A drum of the bending stiffness EI and the shear stiffness S = kappa G A bends away from the roll by
w(y) under the load P(y) (Timoshenko beam; S infinite: Euler and Bernoulli),

    w' = psi - Q/S,    EI psi' = M,    M' = Q,    Q' = P,

with w = M = 0 at the bearings, a distance beyond the edges of the web.  In a lane of the web P is
constant, and the equations have the exact solution

    Q + P x,    M + Q x + P x^2/2,    psi + (M x + Q x^2/2 + P x^3/6)/EI,
    w + psi x + (M x^2/2 + Q x^3/6 + P x^4/24)/EI - (Q x + P x^2/2)/S

at the distance x from its left edge.  The values (w, psi, M, Q) at the edges of all lanes are the
unknowns of one banded matrix, lane after lane, so that no number of lanes is ill-conditioned as it
would be with the fourth differences of w alone.  Lengths are relative to the width W of the web,
and M, Q and P to EI: the unknowns are w and its derivatives as far as it bends, z = (w, W psi,
W^2 M/EI, W^3 Q/EI), all lengths.

On a foundation the load decreases with the mean deflection w_j of a lane, P_j = p_j - k_j w_j.
Several beams may be connected by the foundation: k_j is a matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_banded

__all__ = ["Beam", "BeamsAcross"]

Array = np.ndarray
VALUES = 4  # unknowns of a beam at an edge of a lane: w, W psi, W^2 M/EI, W^3 Q/EI


class Beam(NamedTuple):
    """A beam between two bearings.

    Attributes
    ----------
    flexural_rigidity : float
        EI [N m^2].
    bearing_distance : float
        From each edge of the web to the bearing [m].
    shear_rigidity : float
        kappa G A [N].
    """

    flexural_rigidity: float
    bearing_distance: float = 0.0
    shear_rigidity: float = inf


class _Solution(NamedTuple):
    """The solution in a lane as a linear function of the values z at its left edge and its load.

    Attributes
    ----------
    by_values : (n, 4, 4) or (n, 4) array
        At n distances, or of n lanes: all values z, or the deflection w alone, by z at the left
        edge.
    by_load : (n, 4) or (n,) array
        The same by the load in units of EI/W^4.
    """

    by_values: Array
    by_load: Array


def _at(x: Array, shear: float) -> _Solution:
    """Return z = (w, W psi, W^2 M/EI, W^3 Q/EI) at distances x (n,) from the left edge of a lane.

    They are the solutions in the docstring of the module.  x and w are relative to the width W of
    the web, ``shear`` is EI/(S W^2).
    """
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = [
        [one, x, x**2 / 2, x**3 / 6 - shear * x],
        [zero, one, x, x**2 / 2],
        [zero, zero, one, x],
        [zero, zero, zero, one],
    ]
    loads = [x**4 / 24 - shear * x**2 / 2, x**3 / 6, x**2 / 2, x]
    return _Solution(np.moveaxis(np.array(rows), 2, 0), np.array(loads).T)


def _mean(x: Array, shear: float) -> _Solution:
    """Return the mean deflection w over lanes of the widths x (n,), both relative to W.

    ``shear`` is EI/(S W^2).
    """
    by_values = np.array([np.ones_like(x), x / 2, x**2 / 6, x**3 / 24 - shear * x / 2])
    return _Solution(by_values.T, x**4 / 120 - shear * x**2 / 6)


class BeamsAcross:
    """Beams across the lanes of a web.

    Parameters
    ----------
    beams : sequence of Beam
    widths : (L,) array
        Of the lanes, from one edge of the web to the other [m].
    places : (E,) array
        Further places at which the deflection is wanted, from the left edge of the web [m].

    Attributes
    ----------
    count, lanes : int
        B and L.
    """

    def __init__(self, beams: Sequence[Beam], widths: Array, places: Array) -> None:
        self.count, self.lanes = len(beams), widths.size
        width, x = float(widths.sum()), widths / float(widths.sum())
        left = np.concatenate([[0.0], np.cumsum(x)[:-1]])
        # the lane of each place; the right edge of the web belongs to the last one
        self.lane_of_place = np.clip(
            np.searchsorted(left, places / width, side="right") - 1, 0, self.lanes - 1
        )
        offset = places / width - left[self.lane_of_place]
        # parts of the unknowns at one edge that belong to each beam
        self.parts = [slice(VALUES * b, VALUES * (b + 1)) for b in range(self.count)]
        self.unit = np.array([width**4 / beam.flexural_rigidity for beam in beams])
        self.to_next, self.mean, self.of_places = [], [], []
        self.bearings: list[tuple[Array, Array]] = []  # conditions at the left and right edge
        for beam in beams:
            shear = beam.flexural_rigidity / (beam.shear_rigidity * width**2)
            self.to_next.append(_at(x, shear))
            self.mean.append(_mean(x, shear))
            at_places = _at(offset, shear)
            self.of_places.append(_Solution(at_places.by_values[:, 0], at_places.by_load[:, 0]))
            # w and M, the values 0 and 2, are zero at the bearings beyond the edges of the web
            beyond = beam.bearing_distance / width
            left_end, right_end = _at(np.array([-beyond, beyond]), shear).by_values[:, [0, 2]]
            self.bearings.append((left_end, right_end))

    def deflection(self, load: Array) -> Array:
        """Return the deflection of the beams under loads.

        Parameters
        ----------
        load : (L, B, R) array
            Of the lanes on each of B beams, R loads at once [N/m].

        Returns
        -------
        (L + E, B, R) array
            Mean over each lane, and at the further places [m].
        """
        lanes = load.shape[0]
        return self.on_foundation(np.zeros((lanes, self.count, self.count)), load)

    def on_foundation(self, stiffness: Array, load: Array) -> Array:
        """Return the deflection of beams on a foundation, P = load - stiffness w.

        Parameters
        ----------
        stiffness : (L, B, B) array
            k of the lanes [N/m^2].
        load : (L, B, R) array
            p of the lanes, R loads at once [N/m].

        Returns
        -------
        (L + E, B, R) array
            Mean over each lane, and at the further places [m].

        Raises
        ------
        numpy.linalg.LinAlgError
            For a singular matrix.
        """
        lanes, count, loads = load.shape
        values = VALUES * count
        by_values, by_load = np.zeros((lanes, count, values)), np.zeros((lanes, count))
        forward, push = np.zeros((lanes, values, values)), np.zeros((lanes, values, count))
        for b, part in enumerate(self.parts):
            by_values[:, b, part], by_load[:, b] = self.mean[b]
            forward[:, part, part] = self.to_next[b].by_values
            push[:, part, b] = self.to_next[b].by_load * self.unit[b]
        # from P = load - stiffness w with the mean w = by_values z + by_load unit P of each lane
        # follows own P = load - stiffness by_values z, that is P = fixed - yielding z
        own = np.eye(count) + stiffness * (by_load * self.unit)[:, None, :]
        right = np.concatenate([load, stiffness @ by_values], axis=2)
        fixed, yielding = np.split(np.linalg.solve(own, right), [loads], axis=2)
        z = self._at_edges(forward - push @ yielding, push @ fixed)
        P = fixed - yielding @ z[:-1]
        mean = by_values @ z[:-1] + (by_load * self.unit)[:, :, None] * P
        of_places = [
            np.einsum("ev,evr->er", self.of_places[b].by_values, z[self.lane_of_place][:, part])
            + self.of_places[b].by_load[:, None] * self.unit[b] * P[self.lane_of_place, b]
            for b, part in enumerate(self.parts)
        ]
        return np.concatenate([mean, np.stack(of_places, axis=1)])

    def _at_edges(self, forward: Array, constant: Array) -> Array:
        """Return the values z at the edges of all lanes, (L + 1, 4 B, R).

        They satisfy z_(j+1) = forward_j z_j + constant_j, and the conditions at the bearings.

        Parameters
        ----------
        forward : (L, 4 B, 4 B) array
        constant : (L, 4 B, R) array
        """
        lanes, values, loads = constant.shape
        conditions = 2 * self.count  # at each end
        size = values * (lanes + 1)
        below, above = values + conditions - 1, values - 1
        matrix, right = np.zeros((below + above + 1, size)), np.zeros((size, loads))

        def put(row: Array, column: Array, entries: Array) -> None:
            """Write entries of the matrix, as ``solve_banded`` stores them."""
            matrix[above + row - column, column] = entries

        # the rows are: conditions at the left bearings, z_(j+1) - forward_j z_j of the lanes j,
        # conditions at the right bearings
        first, at_values = np.arange(lanes)[:, None, None], np.arange(values)
        rows = conditions + values * first + at_values[:, None]
        put(rows, values * first + at_values, -forward)
        diagonal = conditions + values * np.arange(lanes)[:, None] + at_values
        put(diagonal, diagonal - conditions + values, np.ones(()))
        right[conditions : conditions + values * lanes] = constant.reshape(-1, loads)
        for b, (part, ends) in enumerate(zip(self.parts, self.bearings, strict=True)):
            own = np.arange(values)[part]
            for end, row, column in (
                (ends[0], 2 * b, 0),
                (ends[1], conditions + values * lanes + 2 * b, values * lanes),
            ):
                put(row + np.arange(2)[:, None], column + own, end)
        z = solve_banded((below, above), matrix, right, overwrite_ab=True, overwrite_b=True)
        return np.asarray(z).reshape(lanes + 1, values, loads)

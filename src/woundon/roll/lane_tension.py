r"""The tension of the lanes across a web, from the radii of their surfaces.

Lane j has the share w_j of the width, the thickness h_j = h (1 + d_j) and the slack b_j, the length
that it has in excess of the web.  Its surface is at s_j = s (1 + rho_j), s = sum w_j s_j.  The web
has one unstrained length per revolution, and a straight nip one approach:

    web       sigma_j = E_t max(0, e0 + rho_j - b_j),    sum w_j h_j sigma_j = T_in
    nip       P_j = P(delta0 + s rho_j) >= 0,            sum w_j P_j = N
    wound on  T_j h_j = sigma_j h_j + A(P_j)

P(delta) is the load-approach curve of the nip and A(P) the tension that it adds; without a nip A is
a given part of the tension, the same for all lanes.  The unknowns are e0, delta0 and the tension
theta_j = T_j/T relative to that of the mean web, T = WOT/h.  At one stage of the build-up

    rho_j = c_j - mu_j theta_j,    mu_j > 0,

because a lane that is wound tighter is compressed more (:mod:`.lanes`).  Every equation is monotone
in its unknown, so that there is one solution.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ..problems.thickness_profile import Lanes

__all__ = ["NipAcross", "TensionOfLanes", "tension_in_nip", "tension_of_web"]

Array = np.ndarray
WEB_STEPS = 1001  # one lane at least becomes slack in each step, and there are at most 1000
ROUNDING = 1e-14  # relative error of the balances of tension and nip load
NEWTON_STEPS, HALVINGS = 100, 30
# Of a solution in the nip: rounding errors left at most 4e-14 in random rolls.
LARGEST_RESIDUAL = 1e-12


class NipAcross(Protocol):
    """A nip at one radius as a function of its load."""

    @property
    def load(self) -> float:
        """N, mean over the width [N/m]."""
        ...

    def load_at(self, approach: Array) -> tuple[Array, Array]:
        """Return P [N/m] and dP/d delta [N/m^2] at approaches [m]; zero at negative ones."""
        ...

    @property
    def approach(self) -> float:
        """Approach under this load [m]."""
        ...

    def added(self, load: Array) -> tuple[Array, Array]:
        """Return A(P) [N/m] and dA/dP [1] at loads [N/m]."""
        ...


class TensionOfLanes(NamedTuple):
    """The tension of the lanes at one radius.

    Attributes
    ----------
    wound_on : (L,) array
        theta = T_j/T [1].
    web : (L,) array
        h sigma_j/T_in, the stress of the web upstream of the nip relative to its mean [1].
    load : (L,) array
        P_j/N, load of the nip relative to its mean [1]; 1 without a nip.
    """

    wound_on: Array
    web: Array
    load: Array


def tension_of_web(
    lanes: Lanes, c: Array, mu: Array, strain: float, added: float = 0.0
) -> TensionOfLanes:
    """Return the tension of the lanes without a nip.

    With the strain tau = T/E_t of the mean web and a = ``added``/(1 + d) of a lane,

        theta - a = max(0, e0 + c - mu a - b)/(tau + mu),    sum w (1 + d) (theta - a) = 1 - added

    is piecewise linear in e0 and convex: Newton's method converges monotonically, in at most as
    many steps as there are lanes, from the e0 at which all of them were taut.

    Parameters
    ----------
    lanes : Lanes
    c, mu : (L,) arrays
        Of rho = c - mu theta.
    strain : float
        tau, > 0.
    added : float
        Part of the tension WOT that the nip adds to all lanes alike, < 1.
    """
    of_nip = added / (1 + lanes.excess)
    weight, level = lanes.share * (1 + lanes.excess), c - mu * of_nip - lanes.slack
    stiffness = weight / (strain + mu)
    # with all lanes taut the sum is too small for lanes that are slack: e0 is an upper bound
    e0 = (1 - added - stiffness @ level) / stiffness.sum()
    for _ in range(WEB_STEPS):
        taut = e0 + level > 0
        previous, e0 = e0, (1 - added - (stiffness * level)[taut].sum()) / stiffness[taut].sum()
        if abs(e0 - previous) <= ROUNDING * (abs(e0) + strain):
            break
    web = np.maximum(0.0, e0 + level) / (strain + mu)
    return TensionOfLanes(web + of_nip, web / (1 - added), np.ones(c.size))


def tension_in_nip(
    lanes: Lanes,
    c: Array,
    mu: Array,
    strain: float,
    nip: NipAcross,
    surface: float,
    wound_on: float,
    web_tension: float,
    guess: Array,
) -> TensionOfLanes | None:
    """Return the tension of the lanes downstream of a nip, by Newton's method; None if it fails.

    theta is eliminated: the equation of a lane depends on its own theta only.  Newton's method
    fails if no lane touches the nip or none is taut, if no step reduces the residuals, or after
    NEWTON_STEPS steps: the guess is too far from the solution, or there is none.

    Parameters
    ----------
    lanes, c, mu, strain
        As of :func:`tension_of_web`.
    nip : NipAcross
    surface : float
        s, mean radius of the surface [m].
    wound_on, web_tension : float
        WOT and T_in of the mean web [N/m].
    guess : (L,) array
        Initial theta.
    """
    weight, thickness = lanes.share * (1 + lanes.excess), 1 + lanes.excess
    theta = guess.astype(float)
    delta0 = nip.approach
    e0 = strain * web_tension / wound_on

    def state(theta: Array, e0: float, delta0: float) -> tuple[Array, ...]:
        """Return residuals, web stress and load of the lanes, and their derivatives."""
        rho = c - mu * theta
        load, stiffness = nip.load_at(delta0 + surface * rho)
        added, slope = nip.added(load)
        web_strain = e0 + rho - lanes.slack
        web = np.maximum(0.0, web_strain) / strain
        web_slope = np.where(web_strain > 0, 1 / strain, 0.0)
        residual = theta - web - added / (wound_on * thickness)
        added_slope = slope * stiffness / (wound_on * thickness)
        return residual, web, load, web_slope, stiffness, added_slope

    def balance(web: Array, load: Array) -> Array:
        """Return the relative residuals of both balances."""
        return np.array(
            [weight @ web * wound_on / web_tension - 1, lanes.share @ load / nip.load - 1]
        )

    def size_of(residual: Array, web: Array, load: Array) -> float:
        """Return the largest residual of the lanes and the balances."""
        return float(max(np.max(np.abs(residual)), np.max(np.abs(balance(web, load)))))

    for _ in range(NEWTON_STEPS):
        residual, web, load, web_slope, stiffness, added_slope = state(theta, e0, delta0)
        own = 1 + mu * (web_slope + surface * added_slope)
        # theta changes by -residual/own + (web_slope de0 + added_slope ddelta)/own
        free = -residual / own
        by_e0, by_delta = web_slope / own, added_slope / own
        web_change = -web_slope * mu
        load_change = -stiffness * surface * mu
        matrix = np.array(
            [
                [
                    weight @ (web_slope + web_change * by_e0) * wound_on / web_tension,
                    weight @ (web_change * by_delta) * wound_on / web_tension,
                ],
                [
                    lanes.share @ (load_change * by_e0) / nip.load,
                    lanes.share @ (stiffness + load_change * by_delta) / nip.load,
                ],
            ]
        )
        right = -balance(web + web_change * free, load + load_change * free)
        try:
            de0, ddelta = np.linalg.solve(matrix, right).tolist()
        except np.linalg.LinAlgError:  # no lane touches the nip, or none is taut
            return None
        step = free + by_e0 * de0 + by_delta * ddelta
        size = size_of(residual, web, load)
        fraction = 1.0
        for _ in range(HALVINGS):  # lanes lose contact or become slack within a long step
            trial = theta + fraction * step, e0 + fraction * de0, delta0 + fraction * ddelta
            residual, web, load, *_ = state(*trial)
            if size_of(residual, web, load) <= size:
                break
            fraction /= 2
        else:  # only rounding errors are left, or Newton's method is stuck: see below
            break
        theta, e0, delta0 = trial
        converged = np.max(np.abs(step)) <= 100 * ROUNDING
        if converged and np.max(np.abs(balance(web, load))) <= 20 * ROUNDING:
            break
    residual, web, load, *_ = state(theta, e0, delta0)
    if not size_of(residual, web, load) <= LARGEST_RESIDUAL:  # also if it is nan
        return None
    return TensionOfLanes(theta, web * wound_on / web_tension, load / nip.load)

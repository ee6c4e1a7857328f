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
    equations = _NipEquations(lanes, c, mu, strain, nip, surface, wound_on, web_tension)
    state = equations.state(guess.astype(float), strain * web_tension / wound_on, nip.approach)
    for _ in range(NEWTON_STEPS):
        try:
            dtheta, de0, ddelta0 = equations.newton_step(state)
        except np.linalg.LinAlgError:  # no lane touches the nip, or none is taut
            return None
        fraction = 1.0
        for _ in range(HALVINGS):  # lanes lose contact or become slack within a long step
            trial = equations.state(
                state.theta + fraction * dtheta,
                state.e0 + fraction * de0,
                state.delta0 + fraction * ddelta0,
            )
            if trial.largest_residual <= state.largest_residual:
                break
            fraction /= 2
        else:  # only rounding errors are left, or Newton's method is stuck: see below
            break
        state = trial
        converged = np.max(np.abs(dtheta)) <= 100 * ROUNDING
        if converged and np.max(np.abs(state.balances)) <= 20 * ROUNDING:
            break
    if not state.largest_residual <= LARGEST_RESIDUAL:  # also if it is nan
        return None
    return TensionOfLanes(state.theta, state.web * wound_on / web_tension, state.load / nip.load)


class _NipState(NamedTuple):
    """An iterate of the lanes in a nip.

    Attributes
    ----------
    theta : (L,) array
    e0, delta0 : float
        Strain of the web [1] and approach of the nip [m].
    residual : (L,) array
        theta minus the tension of the web and that which the nip adds.
    balances : (2,) array
        Relative residuals of the balances of the web tension and the nip load.
    web, load : (L,) arrays
        sigma_j/T, and P_j [N/m].
    web_slope, load_slope : (L,) arrays
        Their derivatives by the strain, and by the approach [N/m^2].
    added_slope : (L,) array
        Derivative of the added tension, relative to that of the mean web, by the approach [1/m].
    """

    theta: Array
    e0: float
    delta0: float
    residual: Array
    balances: Array
    web: Array
    load: Array
    web_slope: Array
    load_slope: Array
    added_slope: Array

    @property
    def largest_residual(self) -> float:
        """The largest residual of the lanes and the balances."""
        return float(max(np.max(np.abs(self.residual)), np.max(np.abs(self.balances))))


class _NipEquations(NamedTuple):
    """The equations of the lanes in a nip; arguments as of :func:`tension_in_nip`."""

    lanes: Lanes
    c: Array
    mu: Array
    strain: float
    nip: NipAcross
    surface: float
    wound_on: float
    web_tension: float

    def state(self, theta: Array, e0: float, delta0: float) -> _NipState:
        """Return residuals, stress of the web, load, and their derivatives."""
        rho = self.c - self.mu * theta
        load, load_slope = self.nip.load_at(delta0 + self.surface * rho)
        added, slope = self.nip.added(load)
        of_lane = self.wound_on * (1 + self.lanes.excess)
        web_strain = e0 + rho - self.lanes.slack
        web = np.maximum(0.0, web_strain) / self.strain
        return _NipState(
            theta,
            e0,
            delta0,
            residual=theta - web - added / of_lane,
            balances=self.sums(web, load) - 1,
            web=web,
            load=load,
            web_slope=np.where(web_strain > 0, 1 / self.strain, 0.0),
            load_slope=load_slope,
            added_slope=slope * load_slope / of_lane,
        )

    def sums(self, web: Array, load: Array) -> Array:
        """Return the sums of web stress and load over the width, relative to T_in and N, (2,)."""
        weight = self.lanes.share * (1 + self.lanes.excess)
        of_web = weight @ web * self.wound_on / self.web_tension
        return np.array([of_web, self.lanes.share @ load / self.nip.load])

    def newton_step(self, state: _NipState) -> tuple[Array, float, float]:
        """Return the Newton step of theta, e0 and delta0.

        theta of each lane is eliminated, which leaves the two balances for e0 and delta0.

        Raises
        ------
        numpy.linalg.LinAlgError
            If no lane touches the nip, or none is taut.
        """
        own = 1 + self.mu * (state.web_slope + self.surface * state.added_slope)
        # theta changes by free + by_e0 de0 + by_delta0 ddelta0
        free = -state.residual / own
        by_e0, by_delta0 = state.web_slope / own, state.added_slope / own
        # derivatives of web stress and load by theta
        web_by_theta = -state.web_slope * self.mu
        load_by_theta = -state.load_slope * self.surface * self.mu
        matrix = np.column_stack(
            [
                self.sums(state.web_slope + web_by_theta * by_e0, load_by_theta * by_e0),
                self.sums(web_by_theta * by_delta0, state.load_slope + load_by_theta * by_delta0),
            ]
        )
        right = -state.balances - self.sums(web_by_theta * free, load_by_theta * free)
        de0, ddelta0 = np.linalg.solve(matrix, right).tolist()
        return free + by_e0 * de0 + by_delta0 * ddelta0, de0, ddelta0

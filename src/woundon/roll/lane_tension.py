r"""The tension of the lanes across a web, from the radii of their surfaces.

Lane j has the share w_j of the width, the thickness h_j = h (1 + d_j) and the slack b_j, the length
that it has in excess of the web.  Its surface is at s_j = s (1 + rho_j), s = sum w_j s_j.  The web
has one unstrained length per revolution, and each drum k one approach:

    web       sigma_j = E_t max(0, e0 + rho_j - b_j),                  sum w_j h_j sigma_j = T_in
    nip k     P_kj = P_k(delta_k + s rho_j + c_kj - w_kj) >= 0,        sum w_j P_kj = N_k
    beams     w_kj = sum of the deflections of beams under the load P_kj
    wound on  T_j h_j = sigma_j h_j + sum_k A_k(P_kj)

P_k(delta) is the load-approach curve of a nip and A_k(P) the tension that it adds; without a nip A
is a given part of the tension, the same for all lanes.  A drum has the crown c_kj, and drum and
core bend as beams (:mod:`~woundon.elasticity.beam`); c = w = 0 of straight ones.  The unknowns are
e0, delta_k, w_kj and the tension theta_j = T_j/T relative to that of the mean web, T = WOT/h.  At
one stage of the build-up

    rho_j = c_j - mu_j theta_j,    mu_j > 0,

because a lane that is wound tighter is compressed more (:mod:`.lanes`).  Every equation is monotone
in its unknown, so that there is one solution.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..elasticity.beam import BeamsAcross
from ..problems.thickness_profile import Lanes

__all__ = ["DrumsAcross", "NipAcross", "TensionOfLanes", "tension_in_nips", "tension_of_web"]

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


class DrumsAcross(NamedTuple):
    """The drums across the width: their crowns, and the beams that bend under their loads.

    The lanes without a share of the width are the last ones.

    Attributes
    ----------
    crown : (K, L) array
        Height of the surface of each drum over its mean over the width [m].
    beams : BeamsAcross, optional
        B beams across the lanes with a share; their further places are the lanes without one.
    loaded_by : (K, B) array
        1 where nip k loads beam b, else 0.
    """

    crown: Array
    beams: BeamsAcross | None
    loaded_by: Array

    @classmethod
    def straight(cls, nips: int, lanes: int) -> DrumsAcross:
        """Return straight drums."""
        return cls(np.zeros((nips, lanes)), None, np.zeros((nips, 0)))

    def deflection(self, load: Array) -> Array:
        """Return the deflection of the beams (B, L, ...) under nip loads (K, L, ...) [m]."""
        if self.beams is None:
            return np.zeros((0, *load.shape[1:]))
        of_beams = np.tensordot(self.loaded_by.T, load, axes=1)[:, : self.beams.lanes]
        columns = of_beams.reshape(*of_beams.shape[:2], -1).swapaxes(0, 1)
        deflection = self.beams.deflection(columns).swapaxes(0, 1)
        return deflection.reshape(len(of_beams), *load.shape[1:])

    def on_foundation(self, stiffness: Array, load: Array) -> Array:
        """Return the deflection of the beams on nips whose loads decrease with it.

        Parameters
        ----------
        stiffness : (K, K, L) array
            Derivatives of the loads by the approaches [N/m^2].
        load : (K, L, R) array
            Loads without deflection, R at once [N/m].

        Returns
        -------
        (B, L, R) array
            [m].

        Raises
        ------
        numpy.linalg.LinAlgError
        """
        if self.beams is None:
            return np.zeros((0, *load.shape[1:]))
        lanes = self.beams.lanes
        k = np.einsum("kb,kml,mc->lbc", self.loaded_by, stiffness[:, :, :lanes], self.loaded_by)
        of_beams = np.einsum("kb,klr->lbr", self.loaded_by, load[:, :lanes])
        return self.beams.on_foundation(k, of_beams).swapaxes(0, 1)


class TensionOfLanes(NamedTuple):
    """The tension of the lanes at one radius.

    Attributes
    ----------
    wound_on : (L,) array
        theta = T_j/T [1].
    web : (L,) array
        h sigma_j/T_in, the stress of the web upstream of the nip relative to its mean [1].
    load : (K, L) array
        P_kj/N_k, load of each nip relative to its mean [1]; one row of ones without a nip.
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
    return TensionOfLanes(web + of_nip, web / (1 - added), np.ones((1, c.size)))


def tension_in_nips(
    lanes: Lanes,
    c: Array,
    mu: Array,
    strain: float,
    nips: Sequence[NipAcross],
    surface: float,
    wound_on: float,
    web_tension: float,
    guess: Array,
    drums: DrumsAcross | None = None,
) -> TensionOfLanes | None:
    """Return the tension of the lanes downstream of all nips, by Newton's method; None if it fails.

    theta is eliminated: the equation of a lane depends on its own theta only; then the deflections,
    with one banded matrix.  Newton's method
    fails if no lane touches a nip or none is taut, if no step reduces the residuals, or after
    NEWTON_STEPS steps: the guess is too far from the solution, or there is none.

    Parameters
    ----------
    lanes, c, mu, strain
        As of :func:`tension_of_web`.
    nips : sequence of NipAcross
        In the direction of travel.
    surface : float
        s, mean radius of the surface [m].
    wound_on, web_tension : float
        WOT and T_in of the mean web [N/m].
    guess : (L,) array
        Initial theta.
    drums : DrumsAcross, optional
        By default straight.
    """
    drums = drums or DrumsAcross.straight(len(nips), c.size)
    equations = _NipEquations(lanes, c, mu, strain, nips, surface, wound_on, web_tension, drums)
    state = equations.even_state(guess.astype(float))
    for _ in range(NEWTON_STEPS):
        try:
            dtheta, de0, ddelta, dw = equations.newton_step(state)
        except np.linalg.LinAlgError:  # no lane touches a nip, or none is taut
            return None
        fraction = 1.0
        for _ in range(HALVINGS):  # lanes lose contact or become slack within a long step
            trial = equations.state(
                state.theta + fraction * dtheta,
                state.e0 + fraction * de0,
                state.delta + fraction * ddelta,
                state.deflection + fraction * dw,
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
    means = np.array([nip.load for nip in nips])[:, None]
    return TensionOfLanes(state.theta, state.web * wound_on / web_tension, state.load / means)


class _NipState(NamedTuple):
    """An iterate of the lanes in the nips.

    Attributes
    ----------
    theta : (L,) array
    e0 : float
        Strain of the web [1].
    delta : (K,) array
        Approach of a lane of mean height in each nip [m].
    deflection : (B, L) array
        Of the beams [m].
    residual : (L,) array
        theta minus the tension of the web and that which the nips add.
    bending : (B, L) array
        Deflection minus that under the present loads, relative to the largest deflection.
    balances : (1 + K,) array
        Relative residuals of the balances of the web tension and the nip loads.
    web : (L,) array
        sigma_j/T.
    load : (K, L) array
        P_kj [N/m].
    web_slope : (L,) array
        Derivative of ``web`` by the strain.
    load_slope, added_slope : (K, L) arrays
        Derivatives by the approach, of the load [N/m^2], and of the added tension relative to that
        of the mean web [1/m].
    """

    theta: Array
    e0: float
    delta: Array
    deflection: Array
    residual: Array
    bending: Array
    balances: Array
    web: Array
    load: Array
    web_slope: Array
    load_slope: Array
    added_slope: Array

    @property
    def largest_residual(self) -> float:
        """The largest residual of the lanes, the beams and the balances."""
        residuals = self.residual, self.balances, self.bending.ravel()
        return float(np.max(np.abs(np.concatenate(residuals))))


class _NipEquations(NamedTuple):
    """The equations of the lanes in the nips; arguments as of :func:`tension_in_nips`."""

    lanes: Lanes
    c: Array
    mu: Array
    strain: float
    nips: Sequence[NipAcross]
    surface: float
    wound_on: float
    web_tension: float
    drums: DrumsAcross

    @property
    def means(self) -> Array:
        """N_k, (K,) [N/m]."""
        return np.array([nip.load for nip in self.nips])

    def even_state(self, theta: Array) -> _NipState:
        """Return the state of given theta in which every nip loads all lanes alike.

        A lane of mean height then has the approach of the mean load.
        """
        deflection = self.drums.deflection(np.tile(self.means[:, None], self.c.size))
        approach = np.array([nip.approach for nip in self.nips])
        delta = approach + self.drums.loaded_by @ (deflection @ self.lanes.share)
        return self.state(theta, self.strain * self.web_tension / self.wound_on, delta, deflection)

    def state(self, theta: Array, e0: float, delta: Array, deflection: Array) -> _NipState:
        """Return residuals, stress of the web, loads, and their derivatives."""
        rho = self.c - self.mu * theta
        height = self.surface * rho + self.drums.crown - self.drums.loaded_by @ deflection
        loads = [
            nip.load_at(approach)
            for nip, approach in zip(self.nips, delta[:, None] + height, strict=True)
        ]
        load, load_slope = np.array(loads).swapaxes(0, 1)
        added = [nip.added(own) for nip, own in zip(self.nips, load, strict=True)]
        tension, slope = np.array(added).swapaxes(0, 1)
        of_lane = self.wound_on * (1 + self.lanes.excess)
        web_strain = e0 + rho - self.lanes.slack
        web = np.maximum(0.0, web_strain) / self.strain
        return _NipState(
            theta,
            e0,
            delta,
            deflection,
            residual=theta - web - tension.sum(axis=0) / of_lane,
            bending=self._bending(deflection, load),
            balances=self.sums(web, load) - 1,
            web=web,
            load=load,
            web_slope=np.where(web_strain > 0, 1 / self.strain, 0.0),
            load_slope=load_slope,
            added_slope=slope * load_slope / of_lane,
        )

    def _bending(self, deflection: Array, load: Array) -> Array:
        """Return the residual of the beams, relative to approaches and deflections, (B, L)."""
        approach = max(nip.approach for nip in self.nips)
        largest = np.max(np.abs(deflection), initial=approach)
        return np.asarray((deflection - self.drums.deflection(load)) / largest)

    def sums(self, web: Array, load: Array) -> Array:
        """Return the sums of web stress and loads over the width, relative to T_in and N_k.

        Parameters
        ----------
        web : (L, ...) array
        load : (K, L, ...) array

        Returns
        -------
        (1 + K, ...) array
        """
        weight = self.lanes.share * (1 + self.lanes.excess)
        of_web = np.tensordot(weight, web, axes=1) * self.wound_on / self.web_tension
        of_nips = [
            np.tensordot(self.lanes.share, own, axes=1) / mean
            for own, mean in zip(load, self.means, strict=True)
        ]
        return np.array([of_web, *of_nips])

    def newton_step(self, state: _NipState) -> tuple[Array, float, Array, Array]:
        """Return the Newton step of theta, e0, delta and the deflections.

        theta of each lane is eliminated, then the deflections, which leaves the balances.  All
        changes are linear in the factors (1, de0, d delta_1, ..., d delta_K); the last axis of the
        arrays (..., 2 + K) belongs to these.

        Raises
        ------
        numpy.linalg.LinAlgError
            If no lane touches a nip, or none is taut.
        """
        drums, nips = self.drums, len(self.nips)
        own = 1 + self.mu * (state.web_slope + self.surface * state.added_slope.sum(axis=0))
        by_approach = state.added_slope / own  # d theta/d approach, (K, L)
        theta = np.zeros((self.c.size, 2 + nips))
        theta[:, 0], theta[:, 1] = -state.residual / own, state.web_slope / own
        approach = np.zeros((nips, self.c.size, 2 + nips))
        approach[np.arange(nips), :, 2 + np.arange(nips)] = 1.0
        deflection = np.zeros((len(state.deflection), self.c.size, 2 + nips))
        if drums.beams is not None:
            # derivatives of the loads by the approaches, at the theta that they cause
            stiffness = -self.surface * self.mu * state.load_slope[:, None] * by_approach
            stiffness[np.arange(nips), np.arange(nips)] += state.load_slope
            # loads at the present deflection; they are linear in it
            load = -state.load_slope[..., None] * self.surface * self.mu[:, None] * theta
            load = load + np.einsum("kml,mlc->klc", stiffness, approach)
            present = drums.loaded_by @ state.deflection
            load[..., 0] += state.load + np.einsum("kml,ml->kl", stiffness, present)
            deflection = drums.on_foundation(stiffness, load)
            deflection[..., 0] -= state.deflection
            approach = approach - np.tensordot(drums.loaded_by, deflection, axes=1)
        theta = theta + np.einsum("kl,klc->lc", by_approach, approach)
        web = -(state.web_slope * self.mu)[:, None] * theta
        web[:, 1] += state.web_slope
        load = state.load_slope[..., None] * (approach - self.surface * self.mu[:, None] * theta)
        sums = self.sums(web, load)
        step = np.linalg.solve(sums[:, 1:], -state.balances - sums[:, 0])
        factors = np.append(1.0, step)
        return theta @ factors, float(step[0]), step[1:], deflection @ factors

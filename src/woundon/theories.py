"""Closed forms and other theories, for comparison with the solved contact.

Pure functions of a problem; none of them solves anything.  All bodies are taken as half-planes of
their material (a :class:`~woundon.Cylinder` loses its core, a :class:`~woundon.Rigid` has no
compliance at all), and the web between roll and drum is left out unless a formula names it.

With the half-plane's coefficients A, B, C of thesis eq. (30) summed over the two bodies, the
surfaces under the pressure p(x) and the traction q(x) on the upper body (-q(x) on the lower) obey::

    (C/pi) int p(s)/(x-s) ds - D q(x) = x/R        gap closed: 1/R = 1/R1 + 1/R2
    (B/pi) int q(s)/(x-s) ds + D p(x) = -xi        stick; xi > 0: the lower surface is the faster

where C = C1 + C2 = 2/E*, B = B1 + B2 and D = A1 - A2.  Each closed form below solves these two
equations: Hertz with q = 0, Carter and Cattaneo with D = 0, Bentall and Johnson with D only.
Material flows along +x, so x = -a is the leading edge.

Examples
--------
>>> import woundon as wo
>>> contact = wo.theories.hertz(wo.NipProblem.example())
>>> contact.half_width > 0
True
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atanh, copysign, cosh, exp, nan, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .arguments import check_type
from .elasticity import half_plane
from .errors import InvalidProblem
from .problems.bodies import Body
from .problems.nip import NipProblem
from .problems.radial_laws import Pfeiffer
from .problems.rollers import RollerProblem
from .problems.stack import Stack
from .roll.gauge_band import GaugeBand, band_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


__all__ = [
    "FullStick",
    "GaugeBand",
    "Hertz",
    "PartialSlip",
    "bentall_johnson_frictionless",
    "bentall_johnson_stick",
    "capstan",
    "carter",
    "cattaneo",
    "dual_slip",
    "friction_limit",
    "gauge_band",
    "hertz",
    "jalkanen",
]

Array = np.ndarray

MOST_EXCESS = 0.1  # relative additional thickness of a lane; mills hold the profile within 0.02


class _Pair(NamedTuple):
    """Two half-planes: B and C summed, D = A1 - A2 [1/Pa], relative radius R [m]."""

    B: float
    C: float
    D: float
    R: float


def _compliance(body: Body, name: str) -> half_plane.Coefficients:
    """Return the coefficients A, B, C of a body as a half-plane; zero for a rigid body."""
    if body.rigid:
        return half_plane.Coefficients(0.0, 0.0, 0.0)
    if body.surface_material is None:
        text = f"this theory needs a linear elastic material, and a {type(body).__name__} has none"
        raise InvalidProblem.at(name, text)
    return half_plane.coefficients(*body.surface_material.stiffness)


def _pair(problem: NipProblem | RollerProblem) -> _Pair:
    """Return the combined coefficients of both bodies and the relative radius R.

    Body 1 is the roll or the upper roller.
    """
    check_type("problem", problem, NipProblem, RollerProblem)
    K1, K2 = map(_compliance, problem.bodies, problem.pair)
    return _Pair(K1.B + K2.B, K1.C + K2.C, K1.A - K2.A, problem.contact_radius)


def _ellipse(x: ArrayLike, centre: float, half_width: float) -> Array:
    """Return sqrt(1 - (x - centre)^2/half_width^2), zero outside; zero for no width."""
    if half_width <= 0:
        return np.zeros_like(np.asarray(x, dtype=float))
    t = (np.asarray(x, dtype=float) - centre) / half_width
    return np.sqrt(np.maximum((1 - t) * (1 + t), 0.0))


@dataclass(frozen=True, slots=True)
class Hertz:
    """Frictionless contact of two orthotropic half-planes.

    Attributes
    ----------
    half_width : float
        a [m].
    peak_pressure : float
        p0 = p(0) [Pa].
    modulus : float
        E* [Pa], plane strain, 1/E* = 1/E1 + 1/E2.
    radius : float
        R [m], 1/R = 1/R1 + 1/R2.
    """

    half_width: float
    peak_pressure: float
    modulus: float
    radius: float

    def pressure(self, x: ArrayLike) -> Array:
        """Return p(x) = p0 sqrt(1 - x^2/a^2) [Pa] at x [m]; zero outside the contact."""
        return self.peak_pressure * _ellipse(x, 0.0, self.half_width)


def hertz(problem: NipProblem | RollerProblem) -> Hertz:
    """Return the frictionless, orthotropic Hertz contact of the two bodies::

        a = 2 sqrt(P R/(pi E*)),   p(x) = 2P/(pi a^2) sqrt(a^2 - x^2),   E_i = 2/C_i

    Valid for a much smaller than the radii and than the thickness of any cover; neglects the
    web's own compression and the tractions' effect on the pressure.

    Source: thesis eqs. (102)-(105); (104) is printed with E* in place of a^2.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example()
    >>> print(f"{1e3 * wo.theories.hertz(problem).half_width:.3f} mm")
    2.461 mm
    """
    (_, C, _, R), P = _pair(problem), _load(problem)
    E = 2 / C
    a = 2 * sqrt(P * R / (pi * E))
    return Hertz(half_width=a, peak_pressure=2 * P / (pi * a), modulus=E, radius=R)


def _load(problem: NipProblem | RollerProblem) -> float:
    """Return the normal load P [N/m]."""
    return problem.nip_load if isinstance(problem, NipProblem) else problem.load


def friction_limit(problem: NipProblem) -> float:
    """Return NIT = mu+ P + F [N/m], the value when the web slips forward on the whole roll.

    In centre winding (F = 0) this is the early theory NIT = mu P.  Since Q+ <= mu+ P and Q- = F
    whatever the contact does, it is an upper bound of NIT at any load.  It is reached exactly only
    if the whole roll side slips: light nip load with F well below zero.  Measured on newsprint
    (mu+ = 0.19, F = 0) it is fair below about 1 kN/m and too high above.

    Source: thesis eqs. (4)-(6), after Good; sec. 4.3.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example()
    >>> round(wo.theories.friction_limit(problem), 1)
    665.4
    """
    check_type("problem", problem, NipProblem)
    mu, P, F = problem.roll_friction, problem.nip_load, problem.winding_force
    return mu * P + F


def jalkanen(problem: NipProblem, approach: float) -> float:
    """Return Jalkanen's kinematic NIT = E_t t delta/R [N/m].

    Assumes that the web takes the drum's speed up to the contact's centre and the roll's after it,
    so that the strain delta/R stays in the web.  Blind to friction and to the winding force, on
    which the approach does not depend though NIT does (thesis sec. 4.3): no range of validity is
    known.

    Parameters
    ----------
    problem : NipProblem
        Gives t = 2h, the roll's radius R and the web's modulus E_t = 1/c11, plane strain with the
        faces free.
    approach : float
        delta, indentation in the middle of the nip, > 0 [m].

    Source: thesis eq. (9).

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example()
    >>> round(wo.theories.jalkanen(problem, approach=0.28e-3), 1)
    624.5
    """
    check_type("problem", problem, NipProblem)
    t, R = problem.web.thickness, problem.roll.radius
    E_t = 1 / problem.web.compliance.c11
    return E_t * t * approach / R


def dual_slip(problem: NipProblem, dual_slip_ratio: ArrayLike) -> Array:
    """Return NIT [N/m] as the friction of both faces over the dual-slip zone, Hertzian pressure::

        NIT(s_d) = (mu+ + mu-) int_y^a p dx,   y = a (1 - 2 |s_d|)
                 = (mu+ + mu-) P/(2 pi) [pi - 4 (1-2s) sqrt(s (1-s)) - 2 arcsin(1-2s)],  s = |s_d|

    with the sign of s_d.  It grows with s_d from 0 to (mu+ + mu-) P.  Valid on a hard drum where
    the web's tension does not change before the dual-slip zone, that is for A_rt well below
    A_rr; otherwise it misses the tension drop 2h (A_rt/A_rr) p.

    Parameters
    ----------
    problem : NipProblem
    dual_slip_ratio : array_like
        s_d, length of the trailing zone where both faces slip over the nip width, |s_d| <= 1.

    Source: thesis eq. (173).

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.NipProblem.example()
    >>> wo.theories.dual_slip(problem, [0.0, 0.25, 1.0]).round(1).tolist()
    [0.0, 267.0, 1365.8]
    """
    check_type("problem", problem, NipProblem)
    mu, P = problem.roll_friction + problem.drum_friction, problem.nip_load
    s_d = np.asarray(dual_slip_ratio, dtype=float)
    s = np.abs(s_d)
    if np.any(s > 1) or np.any(np.isnan(s)):
        text = f"{dual_slip_ratio!r} is out of range; must be in [-1, 1] [1]"
        raise InvalidProblem.at("dual_slip_ratio", text)
    # arccos(1-2s) = 2 arcsin(sqrt s) keeps the small-s limit accurate
    load_share = (2 * np.arcsin(np.sqrt(s)) - 2 * (1 - 2 * s) * np.sqrt(s * (1 - s))) / pi
    return np.copysign(mu * P * load_share, s_d)


def capstan(tension: float, friction: float, angle: float) -> float:
    """Return T2 = T1 exp(mu theta) [N/m], the tension that a slipping wrap of angle theta holds.

    ``friction`` [1] and ``angle`` [rad]; a negative angle gives the smaller tension.  Valid for a
    perfectly flexible web slipping one way over the whole angle on a round, undeformed roll.

    Source: thesis eq. (179), leading term.

    Examples
    --------
    >>> import woundon as wo
    >>> round(wo.theories.capstan(300.0, 0.2, 3.0), 1)
    546.6
    """
    return tension * exp(friction * angle)


@dataclass(frozen=True, slots=True)
class PartialSlip:
    """Stick and slip of two elastically similar rollers: Carter (rolling), Cattaneo (static).

    Attributes
    ----------
    half_width, peak_pressure : float
        a [m] and p0 [Pa], those of :func:`hertz`.
    stick_half_width : float
        c [m]; the stick zone is [stick_centre - c, stick_centre + c].
    stick_centre : float
        -(a - c) in rolling (stick starts at the leading edge x = -a), 0 in static contact [m].
    creepage : float
        xi [1], the lower surface's speed less the upper's over the speed, before strain; it has
        the sign of the tangential load.  nan in static contact.
    friction, tangential_load : float
        mu [1] and Q [N/m], the traction on the upper roller along +x, integrated.
    """

    half_width: float
    peak_pressure: float
    stick_half_width: float
    stick_centre: float
    creepage: float
    friction: float
    tangential_load: float

    def pressure(self, x: ArrayLike) -> Array:
        """Return p(x) [Pa] at x [m]; zero outside the contact."""
        return self.peak_pressure * _ellipse(x, 0.0, self.half_width)

    def traction(self, x: ArrayLike) -> Array:
        """Return q(x) [Pa] on the upper roller along +x: mu p less an ellipse over the stick."""
        a, c, d = self.half_width, self.stick_half_width, self.stick_centre
        bound = copysign(self.friction * self.peak_pressure, self.tangential_load)
        return bound * (_ellipse(x, 0.0, a) - c / a * _ellipse(x, d, c))


def carter(problem: RollerProblem) -> PartialSlip:
    """Return Carter's tractive rolling of two elastically similar rollers::

        c/a = sqrt(1 - |Q|/(mu P)),   |xi| = (B/C) mu (a - c)/R
        q = mu p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x + a - c)^2/c^2)]

    second term in the stick zone [-a, -a + 2c] only.  Exact where the bodies are similar, D = 0;
    B = C for isotropic ones.  A given creepage of mu a/R or more means sliding, c = 0.

    Raises
    ------
    InvalidProblem
        If the bodies are not similar (A1 = A2), without friction, or if the contact is static.

    Source: Carter 1926; Johnson, Contact Mechanics, sec. 8.3.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.RollerProblem.example()
    >>> print(f"{wo.theories.carter(problem).creepage:.3e}")
    1.405e-04
    """
    check_type("problem", problem, RollerProblem)
    if problem.motion != "rolling":
        raise InvalidProblem.at("motion", "Carter's theory is of rolling; use cattaneo")
    (B, C, _, R), contact = _similar(problem), hertz(problem)
    mu, P, a = problem.friction, problem.load, contact.half_width
    full = B / C * mu * a / R  # creepage at which the last stick is lost
    if problem.creepage is None:
        Q = problem.tangential_load or 0.0
        c = a * sqrt(1 - abs(Q) / (mu * P))
        xi = copysign(full * (1 - c / a), Q)
    else:
        xi = problem.creepage
        c = a * max(0.0, 1 - abs(xi) / full)
        Q = copysign(mu * P * (1 - (c / a) ** 2), xi)
    return PartialSlip(a, contact.peak_pressure, c, -(a - c), xi, mu, Q)


def cattaneo(problem: RollerProblem) -> PartialSlip:
    """Return the static contact of two similar rollers under a growing tangential load.

    As :func:`carter` with the stick zone [-c, c] in the middle and no creepage.

    Raises
    ------
    InvalidProblem
        If the bodies are not similar (A1 = A2), without friction, or if the contact is rolling.

    Source: Cattaneo 1938, Mindlin 1949; Johnson, Contact Mechanics, sec. 7.2.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.RollerProblem.example().replace(motion="static")
    >>> contact = wo.theories.cattaneo(problem)
    >>> round(contact.stick_half_width / contact.half_width, 3)
    0.901
    """
    check_type("problem", problem, RollerProblem)
    if problem.motion != "static":
        raise InvalidProblem.at("motion", "Cattaneo's theory is of static contact; use carter")
    _similar(problem)
    contact, mu, Q = hertz(problem), problem.friction, problem.tangential_load or 0.0
    a = contact.half_width
    c = a * sqrt(1 - abs(Q) / (mu * problem.load))
    return PartialSlip(a, contact.peak_pressure, c, 0.0, nan, mu, Q)


def _similar(problem: RollerProblem) -> _Pair:
    """Return the combined coefficients of elastically similar rollers; reject others."""
    pair = _pair(problem)
    if abs(pair.D) > 1e-9 * pair.C:
        mismatch = f"(A1 - A2)/(C1 + C2) = {pair.D / pair.C:.3g}; must be 0"
        raise InvalidProblem.at("lower", f"is not elastically similar to upper, {mismatch}")
    if not problem.friction:
        text = "0 is out of range; must be > 0: nothing sticks, use hertz"
        raise InvalidProblem.at("friction", text)
    return pair


# Dottie's number w = cos(w), and the share of p0 at the slip reversal that halves the load:
# with x = a sin(phi), 2 phi + sin(2 phi) = pi/2 is solved by 2 phi = pi/2 - w
_DOTTIE = 0.7390851332151607
_REVERSAL = sqrt((1 + sqrt(1 - _DOTTIE**2)) / 2)


def bentall_johnson_frictionless(problem: RollerProblem) -> float:
    """Return the creepage xi [1] of free rolling (Q = 0) of dissimilar rollers as mu -> 0::

        xi = -0.914772 D p0 = -0.457386 kappa a/R,   kappa = 2 D/C

    The pressure alone strains the surfaces, by -A_i p; slip is one way inside |x| < 0.40397 a and
    the other way outside, so that the vanishing tractions balance.  kappa/2 is Dundurs' constant
    for isotropic bodies.  xi > 0: the lower surface is the faster one before strain, so a soft
    upper roller (D > 0) has xi < 0.

    Source: Bentall and Johnson 1967, re-derived with the number in closed form.

    Examples
    --------
    >>> import woundon as wo
    >>> rubber = wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.3)
    >>> lower = wo.HalfPlane(radius=0.25, material=rubber)
    >>> problem = wo.RollerProblem.example().replace(lower=lower, tangential_load=None)
    >>> print(f"{wo.theories.bentall_johnson_frictionless(problem):.3e}")
    7.452e-03
    """
    check_type("problem", problem, RollerProblem)
    return -_pair(problem).D * _REVERSAL * hertz(problem).peak_pressure


@dataclass(frozen=True, slots=True)
class FullStick:
    """Free rolling of dissimilar rollers without any slip (mu -> infinity).

    Attributes
    ----------
    half_width : float
        a [m].
    creepage : float
        xi [1], the lower surface's speed less the upper's, over the speed, before strain.
    oscillation : float
        eta = artanh(beta)/pi, beta = D/sqrt(B C) [1].
    amplitude : float
        K = cosh(pi eta)/(R C) [Pa/m].
    anisotropy : float
        sqrt(C/B) [1]; 1 for isotropic bodies.
    """

    half_width: float
    creepage: float
    oscillation: float
    amplitude: float
    anisotropy: float

    def pressure(self, x: ArrayLike) -> Array:
        """Return p(x) [Pa] at x [m]; zero outside the contact."""
        return self._tractions(x).real

    def traction(self, x: ArrayLike) -> Array:
        """Return q(x) [Pa] on the upper roller along +x; zero outside the contact."""
        return self.anisotropy * self._tractions(x).imag

    def _tractions(self, x: ArrayLike) -> Any:
        """Return p + i q/sqrt(C/B) at x; zero outside the contact."""
        a, t = self.half_width, np.asarray(x, dtype=float) / self.half_width
        inside = np.abs(t) < 1
        t = np.where(inside, t, 0.0)
        ellipse = self.amplitude * a * np.sqrt((1 - t) * (1 + t))
        phase = self.oscillation * (np.log1p(t) - np.log1p(-t))
        return np.where(inside, ellipse * np.exp(1j * phase), 0.0)


def bentall_johnson_stick(problem: RollerProblem) -> FullStick:
    """Return the free rolling (Q = 0) of dissimilar rollers that stick everywhere::

        p + i sqrt(B/C) q = K sqrt(a^2 - x^2) ((a+x)/(a-x))^(i eta)
        K = cosh(pi eta)/(R C),  a^2 = 2 P R C/(pi (1 + 4 eta^2)),  xi = -2 eta sqrt(B/C) a/R

    with tanh(pi eta) = D/sqrt(B C).  The limit of much friction: q/p = tan(eta ln((a+x)/(a-x)))
    is unbounded at the edges, so that any finite friction slips there, over a length that is
    minute for small D.

    Source: Bentall and Johnson 1967; the exact inversion by the Hilbert transform, re-derived.

    Examples
    --------
    >>> import woundon as wo
    >>> rubber = wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.3)
    >>> lower = wo.HalfPlane(radius=0.25, material=rubber)
    >>> problem = wo.RollerProblem.example().replace(lower=lower, tangential_load=None)
    >>> print(f"{wo.theories.bentall_johnson_stick(problem).creepage:.3e}")
    5.243e-03
    """
    check_type("problem", problem, RollerProblem)
    B, C, D, R = _pair(problem)
    eta = atanh(D / sqrt(B * C)) / pi
    a = sqrt(2 * problem.load * R * C / (pi * (1 + 4 * eta**2)))
    return FullStick(
        half_width=a,
        creepage=-2 * eta * sqrt(B / C) * a / R,
        oscillation=eta,
        amplitude=cosh(pi * eta) / (R * C),
        anisotropy=sqrt(C / B),
    )


def gauge_band(
    *,
    thickness: float,
    tension: float,
    excess: float,
    K1: float | None = None,
    K2: float | None = None,
    tangential: float | None = None,
    stack: Stack | None = None,
) -> GaugeBand:
    """Return a lane that is thicker than the rest of the web, in the plateau of a long roll::

        T^2 K2/(2 E_t) = P - K1 ln(1 + P/K1)      plateau of the mean roll, T = tension/thickness
        T_b^2 K2/(2 E_t) = P_b - K1 ln(1 + P_b/K1)
        lead = (T_b - T)/E_t                      excess of the lane's radius, relative to the mean
        (K1 + P_b)/(K1 + P) = ((1 + d)/(1 + lead))^K2

    The larger radius takes up the part lead of the additional thickness d, and compression the
    rest.  For another law of the stack: T^2/(2 E_t) = int P d eps, and the compressive strain of
    the lane is larger by ln((1 + d)/(1 + lead)).  Valid in a roll of many thin layers, far from
    core and surface, for a lane that is a small part of the width; shear between the lanes is
    neglected, which makes the lane's tension too large.

    Parameters
    ----------
    thickness : float
        h of the web [m].
    tension : float
        Wound-on tension of the mean roll [N/m].
    excess : float
        d, additional thickness of the lane over h [1]; < 0 for a thin lane, which may be slack.
    K1, K2 : float
        Of Pfeiffer's law [Pa], [1].
    tangential : float
        E_t along the web [Pa].
    stack : Stack, optional
        In place of K1, K2 and tangential.

    Returns
    -------
    GaugeBand
        ``tension`` [N/m] and ``pressure`` [Pa] of the lane, ``lead`` [1], ``mean_pressure`` [Pa] of
        the rest of the roll, and ``strain`` [1] of the lane along the web.

    Raises
    ------
    InvalidProblem
        For values out of range, or a law of the stack that ends below a pressure.

    Source: derived from the plateau relation of :meth:`woundon.Stack.plateau_pressure`.

    Examples
    --------
    >>> import woundon as wo
    >>> band = wo.theories.gauge_band(K1=10e3, K2=40.0, tangential=3.38e9, thickness=66e-6,
    ...                               tension=350.0, excess=0.01)
    >>> print(f"{band.tension:.1f} N/m, {band.pressure / 1e3:.0f} kPa, {band.lead:.3%}")
    436.6 N/m, 293 kPa, 0.039%
    """
    law = {"K1": K1, "K2": K2, "tangential": tangential}
    if stack is None:
        if K1 is None or K2 is None or tangential is None:
            missing = [name for name, value in law.items() if value is None]
            raise InvalidProblem([(name, "missing; must be given, or stack") for name in missing])
        # neither Poisson's ratio nor the shear modulus enters
        stack = Stack(
            radial=Pfeiffer(K1=K1, K2=K2), tangential=tangential, poissons_ratio=0.0, shear=1e6
        )
    elif given := [name for name, value in law.items() if value is not None]:
        raise InvalidProblem.at(given[0], "is given together with a stack; must be one of the two")
    check_type("stack", stack, Stack)
    for name, value in (("thickness", thickness), ("tension", tension)):
        if not 0 < value < float("inf"):
            raise InvalidProblem.at(name, f"{value!r} is out of range; must be > 0")
    strongest = stack.tangential * thickness
    if not tension < strongest:
        text = f"{tension!r} is out of range; must be > 0 and < E_t h = {strongest:.4g} [N/m]"
        raise InvalidProblem.at("tension", text)
    if not abs(excess) <= MOST_EXCESS:
        text = f"{excess!r} is out of range; must be >= -{MOST_EXCESS} and <= {MOST_EXCESS} [1]"
        raise InvalidProblem.at("excess", text)
    return band_of(stack, thickness, tension, excess)

r"""Margins of a wound roll against known defects.

    slip         M / (2 pi r^2 mu P)     torque on a cylinder of layers / their friction capacity,
                 M = T s + (pi/2) rho (s^4 - r^4) a/s    s surface, T core torque / s
    compression  max of -sigma_t         starring and buckling need compression along the web
    blocking     max of P                adhesion between layers
    core         P at the core           against E/(4 (1 - nu^2)) (t/r)^3, collapse of a thin tube
    strength     max of WOT, h sigma_t   against the strength of the web
    slack        min of T_in, WOT        against a minimum tension
    drum_slip    |F|/(mu P) of each drum of a two-drum winder, at most 1
    gauge_band   max of WOT_b/(h E_t)    strain of the thickest lane, against the yield strain
    bending      max of T/E_t + h/2r     strain at a face of the web, against the yield strain
    collapse     pressure on the inner layers of a roll off its core / buckling of bonded layers
    sliding_collapse                     the same of layers that slide freely on each other

In strength, gauge_band and bending the tension is the larger one of that with which a layer is
wound and of h sigma_t of the finished roll, in bending also its compression.  Of a two-drum winder
strength and slack contain the tensions between the nips.  Each margin is evaluated over the radius
of the finished roll and, except blocking, which takes time, of stages of the build-up; with
centrifugal force of each stage while it runs and at rest.
Sources: docs/theory/margins.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import isclose, isinf, isnan, nan
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np

from ..arguments import check_type
from ..errors import InvalidProblem, one_of
from ..nip.air_films import friction_between
from ..problems.grades import Grade, source_of_limit
from ..problems.limits import Limits
from ..problems.messages import quote
from ..problems.roll import Core, RollProblem
from ..quantities import Quantity, length, line_load, rounded_text, share, strain, stress
from ..results import Presented
from ..roll.collapse import BONDED, SLIDING
from ..roll.gauge_band import gauge_band_over, lane_strain
from ..roll.lane_roll import POSITION
from ..roll.result import RollResult
from ..roll.stages import Stage, stages_at, wound_stage
from ..validity import LENGTH, PRESSURE
from .criteria import (
    coil_set,
    collapse_pressure,
    sliding_layers_buckling_stress,
    torque_carried,
    torque_share,
)
from .winding_fields import WindingFields

if TYPE_CHECKING:
    import xarray

__all__ = ["Margin", "Margins", "WindingTorque", "WithMargins", "margins"]

Array = np.ndarray
RUNNING, AT_REST = "running", "at rest"
STAGES = 16  # stages of the build-up that are evaluated, including the finished roll
PLACES = 400  # radii of each stage
# The outermost layers carry the torque by their tension instead of friction.  With P = WOT/r per
# layer the share of the n-th layer is 1/(2 pi mu n), below 2 % at the fiftieth.
TAIL_LAYERS = 50
# Names that winder operators use.
TITLES = {
    "slip": "interlayer slip and telescoping",
    "compression": "starring (hoop compression)",
    "blocking": "blocking",
    "core": "core collapse",
    "strength": "web break",
    "slack": "slack web",
    "gauge_band": "gauge band (baggy lane)",
    "bending": "yield by bending (coil set)",
    "drum_slip": "slip of a drum",
    "collapse": "collapse of the inner layers",
    "sliding_collapse": "collapse of the inner layers without friction",
}
SMALL = 0.25  # reserve below which reports give advice
FIELDS = {
    "compression": "compression",
    "blocking": "blocking_pressure",
    "core": "core_pressure",
    "strength": "web_strength",
    "slack": "slack_tension",
    "gauge_band": "yield_strain",
    "bending": "yield_strain",
}
HINTS = {
    "slip": "let a drum carry more of the torque, accelerate more slowly, or wind tighter",
    "compression": "wind tighter at the core and taper less steeply, or use a stiffer core",
    "blocking": "reduce web tension or nip load, or taper them towards the surface",
    "core": "reduce the wound-on tension at the core, or use a stronger core",
    "strength": "reduce web tension or nip load",
    "slack": "increase the web tension",
    "gauge_band": "reduce the wound-on tension, even out the thickness, or oscillate the web",
    "bending": "use a larger core, a thinner web, or less tension at the core",
    "drum_slip": "let the other drum carry more of the torque, or increase the rider load",
    "collapse": "leave the core in the roll, use a smaller core, or reduce the wound-on tension",
    "sliding_collapse": "leave the core in the roll, use a smaller core, or reduce the wound-on "
    "tension",
}
# In place of these, of a winding without a nip.
HINTS_WITHOUT_NIP = {
    "slip": "accelerate more slowly, wind tighter, or use a nip",
    "blocking": "reduce the web tension, or taper it towards the surface",
    "strength": "reduce the web tension",
}
ALIKE = 1e-3  # relative difference below which stages count as equal: their default error


@dataclass(frozen=True)
class Margin:
    """One margin of a roll.

    Attributes
    ----------
    name : str
        "slip", "compression", "blocking", "core", "strength", "slack", "gauge_band", "bending"; of
        a two-drum winder "drum_slip"; of a roll off its core "collapse" and "sliding_collapse".
    value : float
        Worst value in the roll; SI, nan if it is unknown.
    limit : float
        Maximum (for "slack": minimum) permitted value; nan if no limit is given.
    radius : float
        Radius of the worst value [m].
    scale : float
        Reference value of the reserve: the limit, or the wound-on stress if the limit is 0.
    quantity : Quantity
        Unit and description of value and limit.
    left_out : str
        Effects that the criterion neglects.
    note : str
        Stage of the worst value, source of the limit, or reason why there is none.
    over_radius, values : (K,) arrays
        Radii [m], and the worst value at each over all evaluated stages.
    hint : str
        Advice to enlarge the margin.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.WindingProblem.example().replace(radius=0.12, tension_law="friction")
    >>> winding = wo.solve(problem, rtol=0.01)
    >>> blocking = wo.margins(winding, wo.Limits(blocking_pressure="2 MPa"))["blocking"]
    >>> blocking.verdict, blocking.limit
    ('holds', 2000000.0)
    """

    name: str
    value: float
    limit: float
    radius: float
    scale: float
    quantity: Quantity
    left_out: str
    note: str = ""
    over_radius: Array = field(default_factory=lambda: np.zeros(0), compare=False, repr=False)
    values: Array = field(default_factory=lambda: np.zeros(0), compare=False, repr=False)
    hint: str = ""

    @property
    def checked(self) -> bool:
        """True if value and limit are known."""
        return not (isnan(self.value) or isnan(self.limit))

    @property
    def reserve(self) -> float:
        """Distance from the limit, relative to it; < 0 if violated, nan if not checked."""
        return float(self.reserve_of(self.value))

    @property
    def title(self) -> str:
        """The name used in practice, e.g. "interlayer slip and telescoping"."""
        return TITLES.get(self.name, self.name)

    @property
    def distance(self) -> str:
        """The distance from the limit as text, in percent; from a limit 0 in its unit.

        In words where layers without friction have no finite distance.
        """
        if isinf(self.value):  # of the slip margin only
            return NO_FRICTION
        if self.limit == 0:
            return f"{abs(self.quantity.shown(self.value)):.4g} {self.quantity.display}"
        return f"{rounded_text(100 * abs(self.reserve), 3)} %"

    def reserve_of(self, value: float | Array) -> float | Array:
        """Compute the reserve of other values [1], with their shape."""
        room = value - self.limit if self.name == "slack" else self.limit - value
        return room / self.scale

    @property
    def ok(self) -> bool | None:
        """True if the limit is satisfied; None if it was not checked."""
        return self.reserve >= 0 if self.checked else None

    @property
    def verdict(self) -> str:
        """State of the margin: "holds", "VIOLATED" or "not checked"."""
        return {True: "holds", False: "VIOLATED", None: "not checked"}[self.ok]


class Margins(Presented, tuple[Margin, ...]):
    """All margins of a roll, including those without a limit; indexed by number or name.

    The attributes ``slip``, ``compression``, ``blocking``, ``core``, ``strength``, ``slack``,
    ``gauge_band``, ``bending``, ``drum_slip``, ``collapse`` and ``sliding_collapse`` are the
    reserves, outputs of a winding: ``"margins.blocking"`` in studies.  That of a margin which a
    roll does not have, or which is not checked, is nan.

    >>> import woundon as wo
    >>> problem = wo.WindingProblem.example().replace(radius=0.12, tension_law="friction")
    >>> found = wo.margins(wo.solve(problem, rtol=0.01), wo.Limits(blocking_pressure=2e6))
    >>> found.blocking == found["blocking"].reserve
    True
    """

    __slots__ = ()
    part_of_result: ClassVar[bool] = True

    @property
    def verdict(self) -> str:
        """Sentence on the state of the roll and the margin with the smallest reserve."""
        least, violated = self.least, self.violated
        if least is None:
            return "No margin of the roll is checked: give limits, or a grade."
        unchecked = sum(not margin.checked for margin in self)
        rest = f" ({unchecked} of {len(self)} margins not checked)" if unchecked else ""
        if not violated:
            so_far = " as far as it is checked" if unchecked else ""
            return (
                f"The roll holds{so_far}; smallest reserve: {least.title}, {least.distance}{rest}."
            )
        if isinf(least.value):
            return f"The roll does not hold: {least.title}, because {least.distance}{rest}."
        word = "falls below" if least.name == "slack" else "exceeds"
        return f"The roll does not hold: {least.title} {word} its limit by {least.distance}{rest}."

    @property
    def advice(self) -> str:
        """Advice if the smallest reserve is below 25 %, and other violated margins."""
        least = self.least
        if least is None or least.reserve >= SMALL:
            return ""
        others = [self[name].title for name in self.violated if name != least.name]
        also = f" Also violated: {', '.join(others)}." if others else ""
        return f"To increase this reserve: {least.hint}.{also}"

    @property
    def slip(
        self,
    ) -> Annotated[float, share("m_s", "margin against interlayer slip and telescoping")]:
        """Reserve of interlayer slip and telescoping, as a share of the limit [1]."""
        return self._reserve("slip")

    @property
    def compression(
        self,
    ) -> Annotated[float, share("m_c", "margin against starring (hoop compression)")]:
        """Reserve of starring (hoop compression), as a share of the limit [1]."""
        return self._reserve("compression")

    @property
    def blocking(self) -> Annotated[float, share("m_b", "margin against blocking")]:
        """Reserve of blocking, as a share of the limit [1]."""
        return self._reserve("blocking")

    @property
    def core(self) -> Annotated[float, share("m_cc", "margin against core collapse")]:
        """Reserve of core collapse, as a share of the limit [1]."""
        return self._reserve("core")

    @property
    def strength(self) -> Annotated[float, share("m_t", "margin against web break")]:
        """Reserve of web break, as a share of the limit [1]."""
        return self._reserve("strength")

    @property
    def slack(self) -> Annotated[float, share("m_0", "margin against slack web")]:
        """Reserve of slack web, as a share of the limit [1]."""
        return self._reserve("slack")

    @property
    def gauge_band(
        self,
    ) -> Annotated[float, share("m_g", "margin against gauge band (baggy lane)")]:
        """Reserve of gauge band (baggy lane), as a share of the limit [1]."""
        return self._reserve("gauge_band")

    @property
    def bending(
        self,
    ) -> Annotated[float, share("m_y", "margin against yield by bending (coil set)")]:
        """Reserve of yield by bending (coil set), as a share of the limit [1]."""
        return self._reserve("bending")

    @property
    def drum_slip(self) -> Annotated[float, share("m_d", "margin against slip of a drum")]:
        """Reserve of the friction of both drums, as a share of it [1]; nan without a winder."""
        return self._reserve("drum_slip")

    @property
    def collapse(
        self,
    ) -> Annotated[float, share("m_k", "margin against collapse of the inner layers")]:
        """Reserve of the inner layers, bonded, of a roll off its core [1]; nan on its core."""
        return self._reserve("collapse")

    @property
    def sliding_collapse(
        self,
    ) -> Annotated[
        float, share("m_ks", "margin against collapse of the inner layers without friction")
    ]:
        """Reserve of freely sliding inner layers of a roll off its core [1]; nan on its core."""
        return self._reserve("sliding_collapse")

    def _reserve(self, name: str) -> float:
        """Return the reserve of a margin; nan for one that this winding does not have."""
        return next((float(margin.reserve) for margin in self if margin.name == name), nan)

    def __getitem__(self, key: Any) -> Any:
        """Return a margin by its number or name."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        for margin in self:
            if margin.name == key:
                return margin
        raise KeyError(f"no margin {key!r}; known: {', '.join(margin.name for margin in self)}")

    @property
    def violated(self) -> tuple[str, ...]:
        """Names of the margins whose limit is violated."""
        return tuple(margin.name for margin in self if margin.ok is False)

    @property
    def least(self) -> Margin | None:
        """Margin with the smallest reserve; None if none was checked."""
        return min((m for m in self if m.checked), key=lambda m: m.reserve, default=None)


# ---- torque of a winding ------------------------------------------------------------------------


@dataclass(frozen=True)
class WindingTorque:
    """Quantities of a winding for the margins that the wound roll does not contain.

    Attributes
    ----------
    friction : float, optional
        Coefficient of friction between web and roll; None if unknown.
    radius : (K,) array
        [m].
    core : (K,) array
        Tension from the core torque [N/m].
    web_tension : (K,) array
        Web tension upstream of the nip [N/m]; empty if unknown.
    on_arcs : dict of str to (n,) arrays
        Radii [m] and, of a two-drum winder, the smallest and largest tension of the web before a
        nip [N/m], by the name of its drum.
    assumed : str
        Description of the assumptions.
    friction_ratio : callable
        Friction at a pressure P with air between the layers, relative to that without air [1].
    """

    friction: float | None
    radius: Array
    core: Array
    web_tension: Array
    on_arcs: Mapping[str, tuple[Array, Array, Array]] = field(default_factory=dict)
    assumed: str = ""
    friction_ratio: Callable[[Array], Array] = np.ones_like

    @property
    def has_air(self) -> bool:
        """True if air between the layers reduces their friction."""
        return self.friction_ratio is not np.ones_like

    @classmethod
    def of(cls, result: WindingFields | RollResult) -> WindingTorque:
        """Return the quantities of a winding; a roll alone is taken as centre-wound."""
        if not isinstance(result, RollResult):
            problem, r = result.problem, result.radius
            # moment balance of the roll about its axis: core torque / r = T_in + F, with the forces
            # of all drums
            core_tension = result.web_tension + result.winding_force
            if problem.winder is not None:
                core_tension = problem.at("winder.core_torque", r) / r
            on_arcs = {
                name: (result.nip_radius, nips.arc_least_tension, nips.arc_largest_tension)
                for name, nips in (("front drum", result.front), ("rider", result.rider))
                if nips is not None
            }
            data = cls(problem.roll_friction, r, core_tension, result.web_tension, on_arcs)
            if problem.air is None:
                return data
            ratio = partial(friction_between, result.air_film, air=problem.air)
            return replace(data, friction_ratio=ratio)
        r, unknown = result.radius, np.zeros(0)
        tension = result.problem.web_thickness * result.problem.tension_curve.at(r)
        assumed = "taken as centre-wound without a nip"
        return cls(friction=None, radius=r, core=tension, web_tension=unknown, assumed=assumed)


class _State(NamedTuple):
    """Stresses in the roll at a stage of its build-up.

    Attributes
    ----------
    surface : float
        Radius of the roll at this stage [m].
    motion : str
        "running" or "at rest" of a web whose centrifugal force is known; otherwise empty.
    r : (k,) array
        Radii from the core to the surface [m].
    P, hoop : (k,) arrays
        Pressure between the layers, and hoop stress (> 0 tension) there [Pa].
    """

    surface: float
    motion: str
    r: Array
    P: Array
    hoop: Array


def _states(roll: RollResult, motion: str | None) -> list[_State]:
    """Return the stresses at stages with even surface radii, the finished roll at rest last.

    Stages of fewer than 100 layers are left out.  A roll with centrifugal force is evaluated at
    each stage while it runs and, as it may be stopped, at rest; with ``motion`` in one state.
    """
    core, radius = float(roll.radius[0]), float(roll.radius[-1])
    # smaller rolls would have few layers below the excluded outermost ones
    smallest = core + 2 * TAIL_LAYERS * roll.problem.web_thickness
    surfaces = np.linspace(core, radius, STAGES + 1)[1:-1]
    surfaces = np.append(surfaces[surfaces >= smallest], radius)
    motions = {"": True}  # name of the motion: True if at rest
    if roll.problem.centrifugal_stress:
        motions = {RUNNING: False, AT_REST: True}
    return [
        _state(stage, name)
        for name, at_rest in motions.items()
        if motion in (None, name) or not name
        for stage in stages_at(roll, surfaces.tolist(), roll.radius.size - 1, at_rest=at_rest)
    ]


def _state(stage: Stage, motion: str) -> _State:
    """Return the stresses at a stage, at its nodes and at PLACES even radii.

    ``motion`` is the name of :class:`_State`.
    """
    r = np.unique([*stage.radius, *np.linspace(stage.radius[0], stage.radius[-1], PLACES)])
    return _State(float(stage.radius[-1]), motion, r, *stage.stresses_at(r))


# ---- the margins --------------------------------------------------------------------------------

# of outputs, by whose names their units are chosen
SHARE = share("M/M_c", "torque / interlayer slip capacity").named("torque_share")
COMPRESSION = stress("S", "largest hoop (MD) compression").named("largest_compression")
BLOCKING = stress("P_max", "largest pressure between layers").named("peak_pressure")
CORE = stress("P_c,max", "largest pressure on the core").named("largest_core_pressure")
STRENGTH = line_load("T_max", "largest tension of the web").named("largest_tension")
SLACK = line_load("T_min", "minimum web tension upstream and downstream of the nip").named(
    "least_tension"
)
DRUMS = share("F/mu P", "largest winding force of a drum / its friction").named(
    "drum_friction_used"
)
BAND = strain("eps_b", "largest strain of the thickest lane (gauge band)").named("band_strain")
FACE = strain("eps_f", "largest strain at a face, with bending").named("face_strain")
EVEN = "of a web of even thickness"
RIDGE = length("dR", "height of the ridge over the thickest lane", "um").named("ridge_height")
# where the torque meets no capacity at all: the margin is infinite
NO_FRICTION = "friction between the layers carries nothing"
AIR_LEFT_OUT = "air between layers, "  # of the slip, unless the problem has air
MOISTURE_LEFT_OUT = "moisture, "  # of the compression, unless the roll changes its moisture
LEFT_OUT = {
    "slip": f"{AIR_LEFT_OUT}friction that falls once they slide, the slip under the nip, the "
    f"outermost {TAIL_LAYERS} layers, the drum's help at a start or stop, impacts",
    "compression": "how far friction between layers keeps them from buckling: stars need "
    "compression, but supported layers bear some of it; impacts, "
    f"{MOISTURE_LEFT_OUT}uneven thickness",
    "blocking": "time, temperature, moisture and the chemistry of the surfaces; ridges across the "
    "width, where the pressure is higher",
    "core": "the core's own strength and creep, a tube of paper's layers, the roll's support "
    "against collapse, chucks, notches and ends",
    "strength": "flaws, splices, cut edges, bending and shear in the nip, tension that is uneven "
    "across the width, creep",
    "gauge_band": "shear between lanes, by which the neighbours take part of the load, the "
    "curvature of the layers, creep, how long the lane stays at its strain",
    "bending": "hardening and creep of the web, strain by the pressure of nip and roll, rollers of "
    "smaller radius upstream, tension that is uneven across the width",
    "slack": "baggy lanes and tension that is uneven across the width or in time, flutter",
    "drum_slip": "torques at a start or stop, rolling resistance of covers and rider, worn drums",
    "collapse": "the layers outside, which hold the ring where it moves outwards; the shear of the "
    "stack, imperfections and uneven thickness, by which it buckles earlier",
    "sliding_collapse": "friction between the layers; the layers outside, which hold the ring "
    "where it moves outwards; imperfections and uneven thickness",
}
# of the gauge band of a roll that is changed after winding
LANE_CHANGE = "the change of the lane's own tension after winding, "
NO_LIMIT = "no limit given"


def margins(
    result: WindingFields | RollResult,
    limits: Limits | None = None,
    *,
    motion: Literal["running", "at rest"] | None = None,
) -> Margins:
    """Compute the margins of a roll against known defects.

    Parameters
    ----------
    result : WindingResult or RollResult
        A roll alone is taken as centre-wound, with the friction ``limits.layer_friction`` between
        the layers.
    limits : Limits, optional
        By default those of the winding's problem.
    motion : "running" or "at rest", optional
        State of a roll whose problem has a web speed and a density; by default each margin is the
        worse of both.  Without centrifugal force both are the same.

    Returns
    -------
    Margins
        All margins, including those without a limit.

    Raises
    ------
    InvalidProblem
        For anything else than a roll, an acceleration of a web without density, or another motion.

    Examples
    --------
    >>> import woundon as wo
    >>> roll = wo.solve(wo.RollProblem.example(), rtol=0.01)
    >>> found = wo.margins(roll, wo.Limits(blocking_pressure="1 kPa", layer_friction=0.3))
    >>> found.violated
    ('blocking',)
    """
    roll = getattr(result, "roll", None)
    if not isinstance(roll, RollResult):
        names = one_of(("WindingResult", "RollResult"))
        raise InvalidProblem.at(
            "result", f"{type(result).__name__} is out of place; must be a {names}"
        )
    if limits is not None:
        check_type("limits", limits, Limits)
    limits = limits or getattr(result.problem, "limits", None) or Limits()
    if limits.acceleration and roll.problem.density is None:
        text = (
            f"{limits.acceleration:g} is given, but the web has no density, which its inertia needs"
        )
        raise InvalidProblem.at("limits.acceleration", text)
    if motion not in (None, RUNNING, AT_REST):
        must = f"must be {one_of((repr(RUNNING), repr(AT_REST)))}, or left out"
        raise InvalidProblem.at("motion", f"{quote(motion)} is out of range; {must}")
    torque_data, states = WindingTorque.of(result), _states(roll, motion)
    on_core = states
    if roll.is_off_core:  # it neither presses on the core nor passes a torque to it
        last = states[-1].motion  # of the finished roll, which is replaced by the roll as wound
        as_wound = wound_stage(roll, at_rest=last != RUNNING)
        on_core = [*states[:-1], _state(as_wound, last)]
    worst: tuple[Margin, ...] = (
        _slip(on_core, roll, limits, torque_data),
        _compression(states, roll, limits),
        _blocking(states[-1], limits),
        _core(on_core, roll.problem.core, limits),
        _strength(states[-1], roll, limits, torque_data),
        _slack(roll, limits, torque_data),
        _gauge_band(roll, limits),
        _bending(roll, limits, result.lanes),
        *_drum_slip(result),
        *_collapse(roll),
    )
    if (lanes := result.lanes) is not None:
        worst = tuple(_of_worst_lane(margin, lanes, roll.problem) for margin in worst)
    if not getattr(result.problem, "has_nip", True):
        worst = tuple(map(_without_nip, worst))
    named_grade = result.problem.named_grade
    return Margins(_with_source(margin, roll.problem, named_grade) for margin in worst)


def _wound_and_finished(lanes: xarray.Dataset, name: str) -> tuple[Array, Array]:
    """Return a variable of the lanes as wound and of the finished roll, (M, L) each.

    Both are the same if nothing changes after winding.
    """
    finished = lanes[name].values
    as_wound = lanes.get(f"{name}_as_wound")
    return (finished if as_wound is None else as_wound.values), finished


def _largest_strain(wound: Array, hoop: Array, problem: RollProblem) -> Array:
    """Return the largest strain along the web of layers by their tension, T/E_t or sigma_t/E_t [1].

    The tension is that of winding, or that of the finished roll if changes after winding, which
    strain the layers against each other, have increased it.  A free strain itself is without
    stress, so that it does not count.

    Parameters
    ----------
    wound, hoop : arrays of one shape
        Strain T/E_t as wound [1], hoop stress of the finished roll [Pa].
    problem : RollProblem
    """
    if not problem.is_changed:  # a layer only loses tension as further ones are wound on it
        return wound
    return np.maximum(wound, hoop / problem.stack.tangential)


def _largest_strain_of_lanes(lanes: xarray.Dataset, problem: RollProblem) -> Array:
    """Return the largest strain of the layers of each lane by their tension, (M, L) [1]."""
    return _largest_strain(lanes.band_strain.values, lanes.hoop_stress.values, problem)


def _largest_tension_of_lanes(lanes: xarray.Dataset, problem: RollProblem) -> Array:
    """Return the largest tension of each lane, of the web and of its layers, (M, L) [N/m]."""
    tension = np.maximum(lanes.wound_on_tension, lanes.web_tension).values
    if not problem.is_changed:
        return np.asarray(tension)
    thickness = problem.web_thickness * (1 + lanes.thickness_excess.values)
    return np.maximum(tension, thickness * lanes.hoop_stress.values)


# Values of a margin in the lanes, (M, L) over radius and position; the worst is the largest, or the
# smallest of "slack".
LANE_VALUES: dict[str, Callable[[xarray.Dataset, RollProblem], Array]] = {
    "compression": lambda lanes, _: -np.minimum(*_wound_and_finished(lanes, "hoop_stress")),
    "blocking": lambda lanes, _: lanes.pressure.values,
    "core": lambda lanes, _: np.maximum(*_wound_and_finished(lanes, "pressure"))[:1],
    "strength": _largest_tension_of_lanes,
    "slack": lambda lanes, _: np.minimum(lanes.wound_on_tension, lanes.web_tension).values,
    "gauge_band": _largest_strain_of_lanes,
}
# What the criterion neglects in a roll of lanes, in place of the variation across the width.
LANES_LEFT_OUT = {
    "compression": (", uneven thickness", ", shear between lanes"),
    "blocking": (
        "ridges across the width, where the pressure is higher",
        "shear between lanes, which levels ridges",
    ),
    "core": ("chucks, notches and ends", "chucks, notches and ends; shear between lanes"),
    "strength": ("tension that is uneven across the width, creep", "creep"),
    "slack": (
        "baggy lanes and tension that is uneven across the width or in time",
        "tension that is uneven in time",
    ),
    "gauge_band": ("the curvature of the layers, ", ""),
    "bending": (", tension that is uneven across the width", ", shear between lanes"),
}


def _of_worst_lane(margin: Margin, lanes: xarray.Dataset, problem: RollProblem) -> Margin:
    """Return a margin with the value of the worst lane, as wound or in the finished roll.

    Parameters
    ----------
    margin : Margin
        Of the mean web, at all stages of the build-up.
    lanes : xarray.Dataset
        See :attr:`RollResult.lanes`.
    problem : RollProblem
        Of their roll.
    """
    if margin.name not in LANES_LEFT_OUT:  # the torque is carried by the whole width
        return margin
    left_out = margin.left_out.replace(*LANES_LEFT_OUT[margin.name])
    margin = replace(margin, left_out=left_out)
    if margin.name not in LANE_VALUES:  # bending, of the worst lane already
        return margin
    values = LANE_VALUES[margin.name](lanes, problem)
    least = margin.name == "slack"
    radius, lane = np.unravel_index(np.argmin(values) if least else np.argmax(values), values.shape)
    worst = float(values[radius, lane])
    if margin.name != "gauge_band" and (worst >= margin.value if least else worst <= margin.value):
        return margin
    place = _place_of_lane(lanes, int(lane))
    note = margin.note.replace(EVEN, "").strip("; ")
    return replace(
        margin,
        value=worst,
        radius=float(lanes.radius[radius]),
        over_radius=lanes.radius.values[: values.shape[0]],
        values=values.min(axis=1) if least else values.max(axis=1),
        note="; ".join(filter(None, (place, note))),
    )


def _place_of_lane(lanes: xarray.Dataset, lane: int) -> str:
    """Return the place of a lane across the web and its thickness, as text."""
    excess, position = float(lanes.thickness_excess[lane]), float(lanes.position[lane])
    thickness = "as thick as the mean"
    if excess:
        word = "thicker" if excess > 0 else "thinner"
        thickness = f"{abs(100 * excess):.2g} % {word} than the mean"
    return f"in the lane at {POSITION.stored_text(position, '.4g')} across the web, {thickness}"


# Phrases on the nip in what the criteria neglect, and their replacements without a nip.
NIP_LEFT_OUT = {
    "slip": (", the slip under the nip", ""),
    "strength": ("bending and shear in the nip, ", ""),
    "bending": ("pressure of nip and roll", "pressure of the roll"),
}


def _without_nip(margin: Margin) -> Margin:
    """Return a margin of a winding without a nip, whose texts do not mention one."""
    left_out = margin.left_out.replace(*NIP_LEFT_OUT.get(margin.name, ("", "")))
    left_out = left_out.replace(", the drum's help at a start or stop", "")
    quantity = margin.quantity
    if margin.name == "slack":
        quantity = replace(quantity, meaning="minimum web tension")
    hint = HINTS_WITHOUT_NIP.get(margin.name, margin.hint)
    return replace(margin, left_out=left_out, quantity=quantity, hint=hint)


def _with_source(margin: Margin, problem: RollProblem, named_grade: Grade | None) -> Margin:
    """Add the source grade of the limit to the note of a margin."""
    field = FIELDS.get(margin.name)
    if field is None or not margin.checked:
        return margin
    thickness, modulus = float(problem.web_thickness), float(problem.stack.tangential)
    source = source_of_limit(field, margin.limit, thickness, modulus, named_grade)
    if not source:
        return margin
    return replace(margin, note="; ".join(filter(None, (f"limit of the {source}", margin.note))))


class _WorstValue(NamedTuple):
    """The worst value of a margin in all stages, and the worst values over the radius.

    Attributes
    ----------
    value, radius : float
        In the SI unit of the margin, nan if it is unknown; where it occurs [m].
    occasion : str
        The stage of the build-up at which it occurs, or the place in the winder, as text; empty for
        the finished roll.
    r, values : (k,) arrays
        Radii [m], and the worst value at each over all stages.
    """

    value: float
    radius: float
    occasion: str
    r: Array
    values: Array


UNKNOWN = _WorstValue(value=nan, radius=nan, occasion="", r=np.zeros(0), values=np.zeros(0))


def _margin(
    name: str,
    worst: _WorstValue,
    limit: float | None,
    quantity: Quantity,
    note: str = "",
    scale: float = nan,
) -> Margin:
    """Return the margin of a worst value.

    Parameters
    ----------
    name : str
        "slip", "compression", ...
    worst : _WorstValue
        In all stages of the build-up.
    limit : float, optional
        Permitted value, in the unit of ``quantity``; None if none is given.
    quantity : Quantity
        Of value and limit.
    note : str
        Remark on the limit or the value.
    scale : float
        Reference value of the reserve if the limit is 0; otherwise it is the limit.
    """
    bound = nan if limit is None else limit
    remark = note or (NO_LIMIT if limit is None else "")
    return Margin(
        name=name,
        value=worst.value,
        limit=bound,
        radius=worst.radius,
        scale=bound or scale,
        quantity=quantity,
        left_out=LEFT_OUT[name],
        note="; ".join(filter(None, (worst.occasion, remark))),
        hint=HINTS[name],
        over_radius=worst.r,
        values=worst.values,
    )


def _worst(states: list[_State], values: list[Array]) -> _WorstValue:
    """Return the largest value over all stages, and the largest at each radius.

    Parameters
    ----------
    states : list of _State
        The finished roll last.
    values : list of arrays
        Values of each stage at its first radii, (k,) with k at most the number of its radii.
    """
    state, values_of_worst = max(zip(states, values, strict=True), key=lambda pair: pair[1].max())
    final, last, largest = states[-1], values[-1], float(values_of_worst.max())
    # If the finished roll has the same value up to the error, its radius is reported, but not its
    # value, which would make the margin discontinuous.  Values may be infinite: layers on air.
    if isclose(largest, last.max(), rel_tol=ALIKE):
        state, values_of_worst = final, last
    k = int(np.argmax(values_of_worst))
    if state is final:
        stage = ""
    elif state.surface == final.surface:
        stage = "of the running roll"
    else:
        stage = f"when the radius of the roll was {LENGTH.stored_text(state.surface)}"
        stage += f", {state.motion}" if state.motion else ""
    # at radii of the finished roll; -inf beyond the surface of a stage, where it has no layers
    over_radius = [
        np.interp(final.r[: last.size], state.r[: v.size], v, right=-np.inf)
        for state, v in zip(states, values, strict=True)
    ]
    return _WorstValue(
        largest, float(state.r[k]), stage, final.r[: last.size], np.max(over_radius, axis=0)
    )


def _slip(
    states: list[_State], roll: RollResult, limits: Limits, torque_data: WindingTorque
) -> Margin:
    """Return the margin of the torque over the friction capacity, at all stages.

    Parameters
    ----------
    states : list of _State
        Stresses at the stages of the build-up, the finished roll last.
    roll : RollResult
    limits : Limits
        Its ``layer_friction`` has precedence over the friction of the winding.
    torque_data : WindingTorque
        Friction, core torque and the effect of air of the winding.
    """
    friction = limits.layer_friction or torque_data.friction
    if friction is None:
        note = "the friction between layers is not given"
        return _margin("slip", UNKNOWN, nan, SHARE, note=note)
    # Each stage is evaluated below the surface of the preceding one (the first at the core, the
    # finished roll without its tail), because the outermost layers are held by their own tension.
    tail, core = TAIL_LAYERS * float(roll.problem.web_thickness), float(roll.radius[0])
    surfaces = sorted({state.surface for state in states})
    R = surfaces[-1]
    ends = [core, *surfaces[:-2], R - min(tail, (R - core) / 2)]
    # if the finished roll is the only stage, its end is the last of two
    evaluated_up_to = dict(zip(surfaces, ends[-len(surfaces) :], strict=True))
    shares = []
    for state in states:
        surface, r, P = state.surface, state.r, state.P
        tension = float(np.interp(surface, torque_data.radius, torque_data.core))
        density = roll.problem.density or 0
        torque = torque_carried(r, surface, tension, density, limits.acceleration)
        mu = friction * torque_data.friction_ratio(np.maximum(P, 0))
        shares.append(torque_share(r, P, mu, torque)[r <= evaluated_up_to[surface]])
    worst = _worst(states, shares)
    slides = NO_FRICTION if isinf(worst.value) else ""
    note = "; ".join(filter(None, (torque_data.assumed, slides)))
    margin = _margin("slip", worst, limits.torque_share, SHARE, note=note)
    if torque_data.has_air:
        return replace(margin, left_out=margin.left_out.removeprefix(AIR_LEFT_OUT))
    return margin


def _compression(states: list[_State], roll: RollResult, limits: Limits) -> Margin:
    """Return the margin of the hoop compression, with a note on buckling, at all stages."""
    worst = _worst(states, [-state.hoop for state in states])
    wound_on = float(np.max(roll.problem.tension_curve.at(roll.radius)))
    missing = NO_LIMIT if limits.compression is None else ""
    note = "; ".join(filter(None, (missing, _buckling_note(states[-1], roll))))
    margin = _margin(
        "compression", worst, limits.compression, COMPRESSION, note=note, scale=wound_on
    )
    if roll.problem.moisture_change:
        margin = replace(margin, left_out=margin.left_out.replace(MOISTURE_LEFT_OUT, ""))
    # off the core the inner layers move inwards
    if roll.is_off_core and margin.radius == roll.problem.core.radius:
        margin = replace(margin, hint=HINTS["sliding_collapse"])
    return margin


def _buckling_note(final: _State, roll: RollResult) -> str:
    """Return a note with the buckling stress of frictionless layers, if any is compressed."""
    pressed, stack = final.hoop < 0, roll.problem.stack
    if pressed.sum() < 2:  # a single radius has no depth
        return ""
    r, E_r = final.r[pressed], stack.radial.modulus(np.maximum(final.P[pressed], 0))
    depth = float(r[-1] - r[0])
    mean = float(np.trapezoid(E_r, r)) / depth
    limit = sliding_layers_buckling_stress(
        mean, stack.tangential, float(roll.problem.web_thickness), depth
    )
    about = PRESSURE.stored_text(limit, ".3g")
    return f"layers that slid freely would buckle at about {about} (estimate)"


def _blocking(final: _State, limits: Limits) -> Margin:
    """Return the margin of the pressure in the finished roll."""
    return _margin("blocking", _worst([final], [final.P]), limits.blocking_pressure, BLOCKING)


def _core(states: list[_State], core: Core, limits: Limits) -> Margin:
    """Return the margin of the core pressure, by default against elastic collapse."""
    worst = _worst(states, [state.P[:1] for state in states])
    limit, note, collapse = limits.core_pressure, "", collapse_pressure(core)
    if limit is None and not isnan(collapse):
        limit, note = collapse, "its limit is the elastic collapse of a thin tube"
    elif limit is None:
        note = NO_LIMIT + ", and the core is not a thin tube"
    return _margin("core", worst, limit, CORE, note=note)


def _strength(
    final: _State, roll: RollResult, limits: Limits, torque_data: WindingTorque
) -> Margin:
    """Return the margin of the largest tension: web, wound-on and residual."""
    # at the surface the hoop stress equals the wound-on stress up to the discretisation error,
    # unless it is changed after winding
    nodes = final.r.size if roll.problem.is_changed else -1
    hoop = roll.problem.web_thickness * final.hoop[:nodes]
    on_arcs = [
        _OverRadius(f"before the {name}", r, largest)
        for name, (r, _, largest) in torque_data.on_arcs.items()
    ]
    in_roll = _OverRadius("", final.r[:nodes], hoop)
    worst = _extreme(np.argmax, *_tensions(roll, torque_data), in_roll, *on_arcs)
    return _margin("strength", worst, limits.web_strength, STRENGTH)


def _slack(roll: RollResult, limits: Limits, torque_data: WindingTorque) -> Margin:
    """Return the margin of the smallest tension, upstream and downstream of the nip."""
    on_arcs = [
        _OverRadius(f"before the {name}", r, least)
        for name, (r, least, _) in torque_data.on_arcs.items()
    ]
    worst = _extreme(np.argmin, *_tensions(roll, torque_data), *on_arcs)
    return _margin("slack", worst, limits.slack_tension, SLACK)


def _drum_slip(result: WindingFields | RollResult) -> list[Margin]:
    """Return the margin of the friction between the drums of a two-drum winder and the web."""
    if isinstance(result, RollResult) or result.problem.winder is None:
        return []
    problem = result.problem
    r = result.radius
    used = problem.friction_used(r)
    words = {"drum": "of the rear drum", "winder.front_drum": "of the front drum"}
    drums = [_OverRadius(words[name], r, values) for name, values in used.items()]
    return [_margin("drum_slip", _extreme(np.argmax, *drums), 1.0, DRUMS)]


def _collapse(roll: RollResult) -> list[Margin]:
    """Return the margins of the inner layers of a roll off its core, bonded and freely sliding.

    Layers collapse without slip if the load of bonded layers exceeds 1, and do not collapse if that
    of freely sliding layers is below 1.  Above 1 friction decides, which has no known limit.
    """
    if not roll.is_off_core:
        return []
    bonded, sliding = roll.bonded_collapse_load, roll.sliding_collapse_load
    of_bonded = "its limit is the buckling of a ring of bonded layers (Levy 1884)"
    of_sliding = "its limit is the buckling of rings that slide freely (Levy 1884)"
    if sliding > 1:
        of_sliding = "friction between the layers must hold them; its limit is not known"
    limits = (
        ("collapse", bonded, 1.0, BONDED, of_bonded),
        ("sliding_collapse", sliding, None if sliding > 1 else 1.0, SLIDING, of_sliding),
    )
    bore = roll.radius[:1]
    return [
        _margin(
            name,
            _WorstValue(value, float(bore[0]), "", r=bore, values=np.array([value])),
            limit,
            quantity,
            note,
        )
        for name, value, limit, quantity, note in limits
    ]


def _gauge_band(roll: RollResult, limits: Limits) -> Margin:
    """Return the margin of the strain of the thickest lane, with a note on its ridge.

    A lone thick lane does not change the roll, and its own change after winding is not known: its
    strain is that as wound, or that of the mean web after the changes if this is larger.  Units in
    the note are converted where it is displayed.
    """
    excess, note = roll.problem.gauge_excess, EVEN
    try:
        strains = lane_strain(roll.problem, roll.radius)
    except InvalidProblem as fault:  # the law of the stack ends
        return _margin("gauge_band", UNKNOWN, nan, BAND, note=str(fault))
    strains = _largest_strain(strains, roll.hoop_stress, roll.problem)
    k = int(np.argmax(strains))
    worst = _WorstValue(
        float(strains[k]), float(roll.radius[k]), occasion="", r=roll.radius, values=strains
    )
    if excess:
        ridge = RIDGE.stored_text(ridge_height(roll), ".3g")
        note = f"the lane is {100 * excess:.3g} % thicker, with a ridge of {ridge}"
    missing = NO_LIMIT if limits.yield_strain is None else ""
    note = "; ".join(filter(None, (note, missing)))
    margin = _margin("gauge_band", worst, limits.yield_strain, BAND, note=note)
    if excess and roll.problem.is_changed:
        return replace(margin, left_out=f"{LANE_CHANGE}{margin.left_out}")
    return margin


def _bending(roll: RollResult, limits: Limits, lanes: xarray.Dataset | None) -> Margin:
    """Return the margin of the strain at a face of the web, with a note on its coil set.

    Tension adds to the strain of the outer face, compression to that of the inner one.  With
    ``lanes``, see :attr:`RollResult.lanes`, it is that of the lane with the largest strain.
    """
    r, bent, limit, place = roll.radius, roll.bending_strain, limits.yield_strain, ""
    problem, E_t = roll.problem, roll.problem.stack.tangential
    if lanes is None:
        wound = problem.tension_curve.at(r) / E_t
        tension = _largest_strain(wound, roll.hoop_stress, problem)
        even = np.maximum(tension, -roll.hoop_stress / E_t)
        strains = even + bent
    else:
        r = lanes.radius.values
        bent = problem.bending_strain(r)
        tension = _largest_strain_of_lanes(lanes, problem)
        of_lanes = np.maximum(tension, -lanes.hoop_stress.values / E_t)  # radius and position
        lane = int(np.argmax((of_lanes + bent[:, None]).max(axis=0)))
        tension, even = tension[:, lane], of_lanes[:, lane]
        strains = of_lanes.max(axis=1) + bent
        place = _place_of_lane(lanes, lane)
    k = int(np.argmax(strains))
    worst = _WorstValue(float(strains[k]), float(r[k]), occasion=place, r=r, values=strains)
    if limit is None:
        note = NO_LIMIT
    elif even[k] >= limit:
        note = f"the {'tension' if tension[k] == even[k] else 'compression'} alone exceeds it"
    elif kept := coil_set(float(even[k]), float(bent[k]), limit):
        curl = POSITION.stored_text(float(r[k]) / kept, ".3g")
        note = f"there the web keeps a curl of {curl} radius"
        if bent[k] > 2 * limit:
            note += ", and it yields again when it is straightened"
    else:
        note = ""
    return _margin("bending", worst, limit, FACE, note=note)


def ridge_height(roll: RollResult) -> float:
    """Return the height of the ridge over the thickest lane of the finished roll [m].

    Raises
    ------
    InvalidProblem
        If the law of the stack ends below the pressure of the lane.
    """
    if roll.problem.gauge_excess == 0:
        return 0.0
    return float((gauge_band_over(roll.problem, roll.radius[-1:]).lead * roll.radius[-1:])[0])


class _OverRadius(NamedTuple):
    """A function of the radius: a text for where in the winder it is, radii [m], values, (k,)."""

    place: str
    r: Array
    values: Array


def _tensions(roll: RollResult, torque_data: WindingTorque) -> list[_OverRadius]:
    """Return the web tensions over the radius [N/m].

    The first is the wound-on tension, the second that upstream of the nip, if it is known.
    """
    wound_on = roll.problem.web_thickness * roll.problem.tension_curve.at(roll.radius)
    upstream = (
        [_OverRadius("", torque_data.radius, torque_data.web_tension)]
        if torque_data.web_tension.size
        else []
    )
    return [_OverRadius("", roll.radius, wound_on), *upstream]


def _extreme(argextreme: Callable[..., Any], first: _OverRadius, *more: _OverRadius) -> _WorstValue:
    """Return the maximum or minimum of several functions of the radius, with its place.

    Parameters
    ----------
    argextreme : callable
        ``np.argmax`` or ``np.argmin``.
    first, more : _OverRadius
        The functions ``more`` are interpolated at the radii of the first one.
    """
    r, functions = first.r, (first, *more)
    values = np.array([np.interp(r, each.r, each.values) for each in functions])
    row, k = np.unravel_index(argextreme(values), values.shape)
    over_radius = values[argextreme(values, axis=0), np.arange(r.size)]
    place = functions[row].place
    return _WorstValue(float(values[row, k]), float(r[k]), place, r=r, values=over_radius)


class WithMargins(WindingFields):
    """Base class of a result that has the margins of a winding as outputs."""

    @cached_property
    def margins(self) -> Margins:
        """All margins, with the limits of the problem; see :func:`margins`."""
        return margins(self)

    @property
    def torque_share(self) -> Annotated[float, SHARE]:
        """Largest ratio of the torque to the friction capacity between layers [1]."""
        return float(self.margins["slip"].value)

    @property
    def largest_compression(self) -> Annotated[float, COMPRESSION]:
        """Largest -sigma_t at any stage [Pa]; < 0 where there is none."""
        return float(self.margins["compression"].value)

    @property
    def largest_core_pressure(self) -> Annotated[float, CORE]:
        """Largest P at the core at any stage [Pa]."""
        return float(self.margins["core"].value)

    @property
    def largest_tension(self) -> Annotated[float, STRENGTH]:
        """Largest tension of the web, in the span, as wound on and in the roll [N/m]."""
        return float(self.margins["strength"].value)

    @property
    def least_tension(self) -> Annotated[float, SLACK]:
        """Smallest tension of the web upstream and downstream of the nip [N/m]."""
        return float(self.margins["slack"].value)

    @property
    def drum_friction_used(self) -> Annotated[float, DRUMS]:
        """Largest winding force of a drum of a two-drum winder over its friction capacity [1].

        nan without a winder.
        """
        return next((m.value for m in self.margins if m.name == "drum_slip"), nan)

    @property
    def band_strain(self) -> Annotated[float, BAND]:
        """Largest strain along the web of the thickest lane [1]; nan if it is unknown."""
        return float(self.margins["gauge_band"].value)

    @property
    def face_strain(self) -> Annotated[float, FACE]:
        """Largest strain at a face of the web, by tension or compression and bending [1]."""
        return float(self.margins["bending"].value)

    @property
    def ridge_height(self) -> Annotated[float, RIDGE]:
        """Height of the ridge over the thickest lane [m]; nan if unknown."""
        if self.worst_lane is not None:
            return float(self.worst_lane.ridge_height)
        try:
            return ridge_height(self.roll)
        except InvalidProblem:
            return nan

    @property
    def least_reserve(self) -> Annotated[float, share("m", "smallest of all margins")]:
        """Smallest reserve of the margins that have a limit, as a share of it [1]."""
        least = self.margins.least
        return least.reserve if least is not None else nan

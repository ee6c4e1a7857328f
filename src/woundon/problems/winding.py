"""The winding of a roll through a nip, with schedules over the radius."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import InitVar
from math import inf, pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from ..errors import InvalidProblem, NoSteadyState
from ..quantities import line_load, pure, tension
from .air import Air, with_film
from .assumptions import of_winding
from .bending import Bending, DrumBending, bends, faults_of_bending, too_soft
from .bodies import Body, OptionalBody, Rigid
from .consistency import different_moduli
from .contact_problem import unused_speed
from .fields import Nested, OptionalNested, default
from .finished_roll import (
    OF_FINISHED_ROLL,
    CoreExpansion,
    CoreRemoved,
    CoreShrinkage,
    CoreSwelling,
    FinishedRollProblem,
    MoistureChange,
    RadialExpansion,
    RadialSwelling,
    TangentialExpansion,
    TangentialSwelling,
    TemperatureChange,
)
from .free_strains import OF_WEB
from .inertia import Inertia
from .limits import Limits
from .materials import Material, material
from .messages import not_one_of, out_of_range, quote
from .next_nip import NextNip
from .nip import (
    WRAP_TABLE,
    DrumWrap,
    NipProblem,
    OptionalDrumFriction,
    RollFriction,
    RollWrap,
    Width,
    WrapFriction,
    friction_capacity,
    slack_on_drum,
)
from .paths import field_or_none, quantity_of_field
from .permitted import Conditional, in_brackets, is_within
from .problem import only_in
from .radii import radii_on_roll
from .roll import FEWEST_LAYERS, Core, FinishedRadius, GaugeExcess, RollProblem
from .schedules import (
    AnySchedule,
    Curve,
    OptionalWindingSchedule,
    Profile,
    Steps,
    Taper,
    WindingSchedule,
    as_schedule,
    misfits_on_roll,
    unused_in_tapers,
    values_of,
)
from .stack import EXAMPLE, AnyStack
from .thickness_profile import (
    OptionalThicknessProfile,
    Oscillation,
    faults_across,
    warnings_across,
)
from .two_drums import DrumLoads, TwoDrums, balanced_loads, roll_weight
from .web import CaliperPressure, Web, WebDensity, WebSpeed, centrifugal_stress

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .fields import CoercedField
    from .grades import Grade

__all__ = ["SCHEDULES", "WindingProblem", "schedule_limits"]

Array = np.ndarray
LAWS = ("nip", "friction", "fixed")
# Schedules over the radius with their smallest and largest permitted values.
SCHEDULES: dict[str, tuple[float, float]] = {
    "web_tension": (1e-6, 1e6),
    "nip_load": (1e-12, 1e7),
    "winding_force": (-1e7, 1e7),
    "torque_split": (0.0, 1.0),
    "nip_induced_tension": (-1e6, 1e6),
    "tension_law": (1e-6, 1e6),
    "winder.rider_load": (0.0, 1e7),
    "winder.core_torque": (-1e7, 1e7),
}
WITH_WINDER = {"torque_split": (-10.0, 10.0)}  # a drum may drive more than the web pulls, or brake
LOADS = ("nip_load", "winding_force", "web_tension")
# Fields of the nip that do not depend on the radius.
NIP_FIELDS = frozenset({"web", "drum", "roll_friction", "drum_friction", *WRAP_TABLE["wrap"]})
# Parts of a winding whose only effect is that of its solved nips.
OF_NIP = ("web.material", *WRAP_TABLE["wrap"], "roll_body")
# on two drums friction on the wraps is a part of the loads, and of full slip
OF_NIP_ALONE = ("web.material", "roll_wrap", "roll_body")
HELD = 0.8  # largest part of the arc from the last nip to the rear drum that is the roll wrap
CHECKED_RADII = 257  # radii, in addition to all kinks, at which a steady state must exist


def schedule_limits(name: str, *, has_winder: bool) -> tuple[float, float]:
    """Return the smallest and the largest permitted value of a schedule, SI units.

    >>> schedule_limits("torque_split", has_winder=False)
    (0.0, 1.0)
    """
    limits = SCHEDULES | WITH_WINDER if has_winder else SCHEDULES
    return limits[name]


def _law(value: Any, info: ValidationInfo) -> Any:
    """Return the name of a law, or a profile of the wound-on tension; reject other values."""
    value = as_schedule(value, info.field_name, Profile)
    if isinstance(value, str) and value not in LAWS:
        raise InvalidProblem(f"{not_one_of(value, LAWS)}, or a Profile of the wound-on tension")
    if not isinstance(value, str | Profile):
        text = "must be 'nip', 'friction', 'fixed' or a Profile of the wound-on tension"
        raise InvalidProblem(f"{quote(value)} is out of place; {text}")
    return value


if TYPE_CHECKING:
    TensionLaw = CoercedField[
        Literal["nip", "friction", "fixed"] | Profile, str | Profile | Mapping[str, Any]
    ]
else:
    TensionLaw = Annotated[Literal["nip", "friction", "fixed"] | Profile, BeforeValidator(_law)]


class WindingProblem(FinishedRollProblem):
    """The winding of a roll: nip and roll coupled over the radius.

    Parameters
    ----------
    web : Web
    stack : Stack
        The web's layers in the roll.
    core : Core
    drum : Rigid, HalfPlane, Cylinder or another Body, optional
        On which the web arrives; of a two-drum winder the rear drum.  Without it ``nip_load`` is 0.
    radius : float
        R of the finished roll [m].
    roll_friction, drum_friction, roll_wrap, drum_wrap, wrap_friction
        As of :class:`~woundon.NipProblem`.
    web_tension, nip_load, winding_force : float, Taper, Steps or Profile
        T_in, P and F over the radius [N/m]; F = 0: centre winding.  P = 0: winding without a nip,
        WOT = T_in, with air the film of a foil bearing.  With a ``winder`` P and F follow from it
        and the torque split.
    torque_split : float, Taper, Steps or Profile, optional
        Fraction of the web tension carried by the drum, F = -torque_split T_in, instead of F: 0 is
        centre winding, 1 surface winding.  Of a two-drum winder, that of the rear drum.
    winder : TwoDrums, optional
        Front drum and rider roll of a two-drum winder; needs the density and the torque split.
    roll_body : "effective", "direct" or "linear"
        Model of the roll in the nip.  "effective": a linear cylinder with E_r at the pressure of
        wound roll and nip, an estimate.  "direct": the hardening roll with its wound-in pressure.
        "linear": a cylinder with the moduli of the web.
    tension_law : "nip", "friction", "fixed" or Profile
        Model of the wound-on tension.  "nip": the solved wrapped nip.  "friction":
        T_in + F + roll_friction P, full slip in the nip.  "fixed": T_in +
        nip_induced_tension.  A Profile is the wound-on tension itself [N/m].
    nip_induced_tension : float, Taper, Steps or Profile, optional
        WOT - T_in [N/m], with tension_law "fixed" only.
    caliper_pressure : float, optional
        Pressure under which the web thickness was measured [Pa], as of
        :class:`~woundon.RollProblem`.
    density : float, optional
        Density [kg/m^3] or basis weight, "45 gsm", of the web; with it the result contains the mass
        of the roll.
    gauge_excess : float
        d, relative additional thickness of a lone thick lane across the width [1], in closed form,
        for the margin ``gauge_band`` and the ridge height.
    thickness_profile : ThicknessProfile, optional
        Thickness across the width, instead of ``gauge_excess``: the result then has ``lanes``.
    oscillation : float
        Amplitude by which the web moves to and fro across the roll [m]: the profile is averaged.
    drum_bending : DrumBending, optional
        Bending and crown of the drum across the width; with a thickness profile, which may be even,
        and tension_law "nip".  By default the drum is straight.
    core_bending : Bending, optional
        Bending of the core, with the roll on it, under the nip load; as ``drum_bending``, without a
        winder.
    temperature_change, moisture_change : float or Profile
        Changes of the finished roll, as of :class:`~woundon.RollProblem`: dT [K] and dm [1], over
        the radius.  None of these changes affects nips and wound-on tension.
    tangential_expansion, radial_expansion, core_expansion : float
        Thermal expansion along the web, through the stack, and of the core [1/K].
    tangential_swelling, radial_swelling, core_swelling : float
        Strains by a moisture content of 1 [1].
    core_shrinkage : float
        Relative shrinkage of the unloaded core of the finished roll [1].
    core_removed : bool
        True for a roll that is taken off its core or mandrel after winding.
    web_speed : float, optional
        V [m/s], needed with air or a viscoelastic drum, and for torque and power of the drives.
        With the density the web carries its centrifugal force m V^2 in nips and roll; the finished
        roll is at rest.
    air : Air, optional
        Entrained air reduces the friction in the nip and softens the roll; with tension_law "nip".
    limits : Limits
        Limits to which the margins refer.
    width : float, optional
        Of the web [m]. With it, loads and tensions may be entered as totals, "3.6 kN"; they are
        held per metre of width.  With width and ``web_speed`` the result contains torque and power
        of the drives, see :class:`~woundon.winding.drives.Drive`.
    inertia : Inertia, optional
        Moments of inertia of core and drums, for the torque of their drives; by default 0.

    Raises
    ------
    InvalidProblem
        Naming every invalid field with its value and permitted range, and the radius.
    NoSteadyState
        If the drum slips at some radius.

    Examples
    --------
    >>> import woundon as wo
    >>> winding = wo.WindingProblem.example().replace(nip_load="2.5 kN/m")
    >>> winding.nip_load, winding.web_tension.start
    (2500.0, 350.0)
    """

    tables: ClassVar[Mapping[str, tuple[str, ...]]] = WRAP_TABLE
    graded: ClassVar[tuple[str, ...]] = (
        "web",
        "stack",
        "roll_friction",
        "drum_friction",
        "density",
        "limits",
        *OF_WEB,
    )
    counterparts: ClassVar[Mapping[str, str]] = {
        "roll": "give core, radius and stack",
        "web_thickness": "give web.thickness",
        "wound_on_tension": "give it as tension_law, a Profile",
        "tangential_load": "give winding_force or torque_split",
        "lower": "give drum",
        "next_nips": "give winder, whose drums are further nips",
        **only_in("RollerProblem", "upper", "creepage", "motion"),
    }

    # Fields that the grade supplies are required without one; type checkers must accept both.
    if TYPE_CHECKING:
        grade: InitVar[Grade | str | Mapping[str, Any]] = Field(...)
        diameter: InitVar[float | str] = Field(...)
    web: Annotated[Nested[Web], Field(description="the paper or film")] = Field(...)
    stack: AnyStack = Field(...)
    core: Nested[Core]
    drum: Annotated[
        OptionalBody,
        Field(description="the winding drum"),
        Conditional("required unless nip_load = 0"),
    ] = default(None)
    radius: FinishedRadius = Field(...)
    roll_friction: RollFriction = Field(...)
    drum_friction: Annotated[OptionalDrumFriction, Conditional("required unless nip_load = 0")] = (
        default(None)
    )
    web_tension: Annotated[
        WindingSchedule, tension("T_in", "web tension upstream of the nip", (50.0, 1000.0))
    ]
    nip_load: Annotated[
        OptionalWindingSchedule,
        line_load("P", "nip load", (500.0, 10e3)),
        Conditional("required without winder, not allowed with one"),
    ] = default(None)
    winding_force: Annotated[
        WindingSchedule,
        line_load("F", "winding force (drum traction resultant), F = -M2/R2", (-500.0, 500.0)),
    ] = default(0.0)
    torque_split: Annotated[
        OptionalWindingSchedule,
        pure("s_F", "fraction of the web tension carried by the drum, -F/T_in", (0.0, 1.0)),
        Conditional("required with a winder"),
    ] = default(None)
    winder: Annotated[
        OptionalNested[TwoDrums], Field(description="front drum and rider of a two-drum winder")
    ] = default(None)
    roll_wrap: RollWrap = default(pi)
    drum_wrap: DrumWrap = default(0.0)
    wrap_friction: WrapFriction = default(None)
    roll_body: Annotated[
        Literal["effective", "direct", "linear"],
        Field(description="model of the roll in the nip"),
    ] = "effective"
    tension_law: Annotated[TensionLaw, tension("WOT", "wound-on tension model", (50.0, 1500.0))] = (
        default("nip")
    )
    nip_induced_tension: Annotated[
        OptionalWindingSchedule,
        tension("NIT", "prescribed nip-induced tension, WOT - T_in", (0.0, 500.0)),
        Conditional('required with tension_law = "fixed", not allowed otherwise'),
    ] = default(None)
    caliper_pressure: CaliperPressure = default(None)
    density: Annotated[
        WebDensity, Conditional("required with limits.acceleration and with a winder")
    ] = default(None)
    gauge_excess: GaugeExcess = default(0.0)
    thickness_profile: OptionalThicknessProfile = default(None)
    oscillation: Oscillation = default(0.0)
    drum_bending: Annotated[
        OptionalNested[DrumBending],
        Field(description="bending and crown of the drum"),
        Conditional("only with thickness_profile"),
    ] = default(None)
    core_bending: Annotated[
        OptionalNested[Bending],
        Field(description="bending of the core with the roll"),
        Conditional("only with thickness_profile"),
    ] = default(None)
    temperature_change: TemperatureChange = default(0.0)
    tangential_expansion: TangentialExpansion = default(0.0)
    radial_expansion: RadialExpansion = default(0.0)
    core_expansion: CoreExpansion = default(0.0)
    moisture_change: MoistureChange = default(0.0)
    tangential_swelling: TangentialSwelling = default(0.0)
    radial_swelling: RadialSwelling = default(0.0)
    core_swelling: CoreSwelling = default(0.0)
    core_shrinkage: CoreShrinkage = default(0.0)
    core_removed: CoreRemoved = default(False)
    limits: Annotated[Nested[Limits], Field(description="limits of web, roll and core")] = default(
        Limits()
    )

    web_speed: Annotated[WebSpeed, Conditional("required with air or a viscoelastic drum")] = (
        default(None)
    )
    air: Annotated[OptionalNested[Air], Field(description="entrained air")] = default(None)
    width: Width = default(None)
    inertia: Annotated[
        OptionalNested[Inertia], Field(description="moments of inertia of core and drums")
    ] = default(None)

    @model_validator(mode="after")
    def _check_winding(self) -> Self:
        """Check the roll, the schedules and their combination."""
        try:  # checks core, number of layers and density; with any tension
            self.wound_roll(wound_on_tension=1.0, rotates=False)
        except InvalidProblem as fault:
            own_names = {"web_thickness": "web.thickness"}  # by the name of the field of a roll
            faults = [(own_names.get(field, field), text) for field, text in fault.faults]
            raise InvalidProblem(faults) from None
        faults = [fault for name in SCHEDULES for fault in self._faults_of(name)]
        faults += self._contradictions()
        faults += faults_across(self, self.width)
        faults += faults_of_bending(self)
        if self.winder is not None:
            faults += self._contradictions_of_winder(self.winder)
        if faults:
            raise InvalidProblem(faults)
        if self.winder is not None:
            self._check_drum_loads(self.winder)
        if faults := list(self._beams_too_soft()):
            raise InvalidProblem(faults)
        if self.tension_law in ("nip", "friction") and self.has_nip:
            self._check_steady_state()
        return self

    def _contradictions(self) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for combinations of fields that are not permitted."""
        fixed = self.tension_law == "fixed"
        if fixed != (self.nip_induced_tension is not None):
            law = quote(self.tension_law) if isinstance(self.tension_law, str) else "a table"
            yield (
                "nip_induced_tension",
                "missing; must be given [N/m] with tension_law = 'fixed'"
                if fixed
                else f"is given together with tension_law = {law}; must be left out",
            )
        if self.nip_load is None and self.winder is None:
            yield "nip_load", "missing; must be given [N/m], 0 without a nip, or a winder"
        for name in ("drum", "drum_friction"):
            if getattr(self, name) is None and self.nip_load and self.winder is None:
                yield name, "missing; must be given, unless nip_load = 0: winding without a nip"
        if not self.has_nip:
            yield from self._forces_without_nip()
        if self.torque_split is not None and self.winding_force != 0.0:
            yield ("torque_split", "is given together with winding_force; must be one of the two")
        if self.roll_body == "linear" and not isinstance(self.web.material, Material):
            yield "roll_body", "'linear' needs the moduli of a web that does not harden"
        if self.limits.acceleration and self.density is None:
            text = f"{quote(self.limits.acceleration)} is given without the web's density"
            yield "limits.acceleration", f"{text}; must be 0, or density be given [kg/m^3]"
        if self.air is not None and self.web_speed is None:
            yield "web_speed", "missing; must be given with air"
        for name in self._viscoelastic_drums[:1]:
            if not self.web_speed:
                wrong = "missing" if self.web_speed is None else "0 is out of range"
                yield (
                    "web_speed",
                    f"{wrong}; must be > 0 [m/s], as {name} is of a viscoelastic material",
                )
        if self.air is not None:
            for field, text in self.air.too_rough(self.web.thickness):
                yield f"air.{field}", text
        if self.air is not None and self.tension_law != "nip":
            yield "air", "needs tension_law = 'nip', which computes the entrained air"

    def _forces_without_nip(self) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for the force of a drum that does not touch the roll."""
        for name in ("winding_force", "torque_split"):
            value = getattr(self, name)
            if value is not None and value != 0.0:
                text = f"{quote(value)} is given with nip_load = 0; must be 0 or left out"
                yield name, f"{text}: without a nip no drum drives the roll"

    def _contradictions_of_winder(self, winder: TwoDrums) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for fields that do not fit to a two-drum winder."""
        for name in ("drum", "drum_friction"):
            if getattr(self, name) is None:
                yield name, "missing; must be given with a winder, of its rear drum"
        if self.nip_load is not None:
            text = "is given together with winder; must be left out"
            yield "nip_load", f"{text}: it follows from the weight of the roll and the rider load"
        if self.winding_force != 0.0:
            text = "is given together with winder; must be left out"
            yield "winding_force", f"{text}: it follows from the torque split"
        if self.torque_split is None:
            text = "missing; must be given with a winder"
            yield "torque_split", f"{text}: the share of the web tension that the rear drum drives"
        if self.density is None:
            yield "density", "missing; must be given [kg/m^3] with a winder, for the roll's weight"
        if self.tension_law == "nip" and self.roll_wrap == 0:
            yield "roll_wrap", "0 is out of range; must be > 0 and <= 3.14159 [rad] with a winder"
        if self.drum is not None:
            yield from winder.geometry_faults(self.drum.radius, *self.ends)

    @property
    def has_nip(self) -> bool:
        """True unless the roll is wound without a nip, ``nip_load`` = 0."""
        return self.winder is not None or self.nip_load != 0.0

    @property
    def solves_nips(self) -> bool:
        """True if the wound-on tension is that of solved nips."""
        return self.tension_law == "nip" and self.has_nip

    @property
    def drum_radius(self) -> float:
        """Radius of the winding drum, of a two-drum winder of the rear drum [m]."""
        assert self.drum is not None  # required with a nip
        return self.drum.radius

    @property
    def drums(self) -> dict[str, Body]:
        """The drums of the nips by dotted name: winding drum; front drum and rider of a winder."""
        if not self.has_nip or self.drum is None:
            return {}
        bodies = {"drum": self.drum}
        if self.winder is not None:
            bodies["winder.front_drum"] = self.winder.front_drum
            if self.winder.rider is not None:
                bodies["winder.rider"] = self.winder.rider
        return bodies

    @property
    def centrifugal_tension(self) -> float:
        """m V^2 of the web [N/m]; 0 without web speed or density."""
        return centrifugal_stress(self.density, self.web_speed) * self.web.thickness

    @property
    def _speed_has_effect(self) -> bool:
        """True with a density, entrained air or a viscoelastic drum."""
        return self.density is not None or self.air is not None or bool(self._viscoelastic_drums)

    @property
    def _uses_speed(self) -> bool:
        """True if the speed affects the roll or, with the width, the powers of the drives."""
        return self._speed_has_effect or self.width is not None

    @property
    def _viscoelastic_drums(self) -> list[str]:
        """Dotted names of the drums that are viscoelastic."""
        return [name for name, drum in self.drums.items() if drum.viscoelastic]

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        texts = [
            *super().input_warnings,
            *different_moduli(self.web, "stack", self.stack),
            *self._warnings_of_changes(),
            *self.stack.input_warnings("stack"),
            *warnings_across(self, self.web.thickness),
        ]
        if self.web_speed is not None and not self._uses_speed:
            texts.append(unused_speed("web_speed", self.web_speed))
        if self.drum is not None and not self.has_nip:
            texts.append("drum is not used, as nip_load = 0")
        if self.inertia is not None:
            texts += self._warnings_of_inertia(self.inertia)
        return tuple(texts)

    def _faults_of(self, name: str) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for a schedule out of range, or a profile that is too short.

        The numbers of the schedule are checked, and the value that a taper leaves at the surface.
        """
        schedule = field_or_none(self, name)
        if schedule is None or isinstance(schedule, str):
            return
        low, high = schedule_limits(name, has_winder=self.winder is not None)
        unit, must = quantity_of_field(self, name).unit, "must be"
        if name == "nip_load" and not isinstance(schedule, Profile | Taper | Steps):
            if schedule == 0.0:  # without a nip
                return
            must = "must be 0, or"
        wrong = [
            (f"{name}{part}", out_of_range(value, low, high, unit).replace("must be", must))
            for part, value in values_of(schedule).items()
            if not low <= value <= high
        ]
        wrong += misfits_on_roll(name, schedule, *self.ends)
        yield from wrong
        if isinstance(schedule, Taper) and not wrong:
            value = float(self.curve(name).at(np.array(self.radius)))
            if not low <= value <= high:
                at = f"at the radius {self.radius:.6g} [m]"
                given = quote(getattr(schedule, schedule.field_of_law))
                left = f"{quote(value)}{in_brackets(unit)} {at}"
                must = f"must be >= {low:g} and <= {high:g}{in_brackets(unit)}"
                text = f"{given} is out of range; leaves {left}; {must}"
                yield f"{name}.{schedule.field_of_law}", text

    def _check_steady_state(self) -> None:
        """Reject a slack web on the drum wrap, and a winding force that exceeds the friction."""
        r = self.radii(CHECKED_RADII)
        P, T, F = (self.at(name, r) for name in ("nip_load", "web_tension", "winding_force"))
        least, force = int(np.argmin(T)), self.centrifugal_tension
        if self.drum_wrap > 0 and T[least] <= force:
            raise slack_on_drum(float(T[least]), force, f" at the radius {r[least]:.6g} [m]")
        low, high = map(np.asarray, self._friction_capacity(P, T))
        slides = ~((low < F) & (high > F))
        if slides.any():
            k = int(np.argmax(slides))
            name, means = "winding_force", ""
            if self.torque_split is not None:
                name, means = "torque_split", f" means a winding force of {F[k]:.6g} [N/m], which"
            value = float(self.curve(name).at(r[k]))
            raise NoSteadyState.at(
                name,
                f"{quote(value)} at the radius {r[k]:.6g} [m]{means} is out of range; must be > "
                f"{low[k]:.6g} and < {high[k]:.6g} [N/m] there, the friction capacity; "
                "otherwise the drum slips",
            )

    def _check_drum_loads(self, winder: TwoDrums) -> None:
        """Reject a roll that is not pressed onto a drum or the rider, or a front drum that slips.

        The friction of the rear drum is that of the nip, see :meth:`_check_steady_state`.
        """
        r = self.radii(CHECKED_RADII)
        loads = self.drum_loads(r)
        # balance of forces on the drums: how much more rider load makes each load positive
        arc = np.sin(loads.front_arc)
        for name, load, share in (
            ("rear", loads.rear_load, np.sin(loads.front_angle) / arc),
            ("front", loads.front_load, np.sin(loads.rear_angle) / arc),
        ):
            if (load <= 0).any():
                k = int(np.argmin(load))
                least = loads.rider_load[k] - load[k] / share[k]
                raise InvalidProblem.at(
                    "winder.rider_load",
                    f"{quote(float(loads.rider_load[k]))} at the radius {r[k]:.6g} [m] is out of "
                    f"range; must be > {least:.6g} [N/m] there, or the roll lifts off the {name} "
                    "drum",
                )
        if winder.rider is not None and (loads.rider_load <= 0).any():
            k = int(np.argmin(loads.rider_load))
            raise InvalidProblem.at(
                "winder.rider_load",
                f"{quote(float(loads.rider_load[k]))} at the radius {r[k]:.6g} [m] is out of "
                "range; must be > 0 [N/m] with a rider, or the rider lifts off the roll",
            )
        capacity = self.front_friction * loads.front_load
        slides = np.abs(loads.front_force) >= capacity
        if self.tension_law in ("nip", "friction") and slides.any():
            k = int(np.argmax(slides))
            split = float(self.curve("torque_split").at(r[k]))
            raise NoSteadyState.at(
                "torque_split",
                f"{quote(split)} at the radius {r[k]:.6g} [m] means a winding force of the front "
                f"drum of {loads.front_force[k]:.6g} [N/m], which is out of range; must be > "
                f"{-capacity[k]:.6g} and < {capacity[k]:.6g} [N/m] there, the friction capacity; "
                "otherwise the front drum slips",
            )

    def _beams_too_soft(self) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for drums and a core that bend too far under their nip loads."""
        if self.thickness_profile is None or not bends(self):
            return
        r = self.radii(CHECKED_RADII)
        loads = dict.fromkeys(("drum_bending", "core_bending"), self.at("nip_load", r))
        if self.winder is not None:
            of_drums = self.drum_loads(r)
            loads["winder.front_bending"] = of_drums.front_load
            loads["winder.rider_bending"] = of_drums.rider_load
        for name, load in loads.items():
            bending = field_or_none(self, name)
            if bending is not None:
                largest, width = float(np.max(load)), self.thickness_profile.width
                for field, text in too_soft(bending, largest, width):
                    yield f"{name}.{field}", text

    def _friction_capacity(self, P: Array, T: Array) -> tuple[float | Array, float | Array]:
        """Return the limits of the winding force under P and T_in, (k,) arrays [N/m]."""
        assert self.drum_friction is not None  # required with a nip
        hoop_tension = T - self.centrifugal_tension
        return friction_capacity(P, hoop_tension, self.drum_friction, self.drum_wrap)

    @property
    def front_friction(self) -> float:
        """mu- of the front drum of a two-drum winder."""
        friction = None if self.winder is None else self.winder.front_friction
        return self._or_drum_friction(friction)

    @property
    def rider_friction(self) -> float:
        """mu- of the rider roll of a two-drum winder."""
        friction = None if self.winder is None else self.winder.rider_friction
        return self._or_drum_friction(friction)

    def _or_drum_friction(self, friction: float | None) -> float:
        """Return a coefficient of friction, by default that of the winding drum."""
        chosen = self.drum_friction if friction is None else friction
        assert chosen is not None  # required with a nip
        return chosen

    # ---- schedules ------------------------------------------------------------------------------

    @property
    def ends(self) -> tuple[float, float]:
        """Radii of core and finished roll [m]."""
        return self.core.radius, self.radius

    def curve(self, name: str) -> Curve:
        """Return the schedule of a field over the radius."""
        return Curve(field_or_none(self, name), *self.ends)

    def at(self, name: str, r: ArrayLike) -> Array:
        """Return the values of a schedule at radii [m].

        F may be given by the torque split, P by the balance of a two-drum winder.
        """
        r = np.asarray(r, dtype=float)
        if name == "nip_load" and self.winder is not None:
            return self.drum_loads(r).rear_load
        if name == "winding_force" and self.torque_split is not None:
            return -self.curve("torque_split").at(r) * self.curve("web_tension").at(r)
        return self.curve(name).at(r)

    def drum_loads(self, r: ArrayLike) -> DrumLoads:
        """Return loads, forces and angles of a two-drum winder at radii of the roll [m].

        Raises
        ------
        InvalidProblem
            Without a winder, or for a radius that the roll does not have.

        Examples
        --------
        >>> import woundon as wo
        >>> winder = wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0)
        >>> problem = wo.WindingProblem.example().replace(
        ...     winder=winder, nip_load=None, torque_split=1.0
        ... )
        >>> float(problem.drum_loads(0.4).front_force)
        0.0
        """
        if self.winder is None:
            raise InvalidProblem.at("winder", "missing; must be given for the loads of its drums")
        r = radii_on_roll(r, self.core.radius, self.radius, "r")
        assert self.density is not None  # required with a winder
        return balanced_loads(
            r,
            (self.drum_radius, self.winder.front_drum.radius),
            self.winder.gap,
            roll_weight(r, self.core.radius, self.density, self.winder.core_mass),
            self.at("winder.rider_load", r),
            self.at("web_tension", r),
            self.centrifugal_tension,
            self.at("winding_force", r),
            self.at("winder.core_torque", r) / r,
        )

    def friction_used(self, r: ArrayLike) -> dict[str, Array]:
        """Return |F| of each drum over its friction capacity at radii [m], by dotted name [1].

        The capacity is that of the nip, and of the drum wrap.  A rider idles.  Without a nip there
        is none.
        """
        if not self.has_nip:
            return {}
        r = np.asarray(r, dtype=float)
        P, T, F = (self.at(name, r) for name in ("nip_load", "web_tension", "winding_force"))
        low, high = self._friction_capacity(P, T)
        used = {"drum": F / np.where(F < 0, low, high)}
        if self.winder is not None:
            loads = self.drum_loads(r)
            capacity = self.front_friction * loads.front_load
            used["winder.front_drum"] = np.abs(loads.front_force) / capacity
        return used

    @property
    def kinks(self) -> dict[float, float]:
        """Radii of the kinks of all schedules [m], with their sharpness r |d slope|/value."""
        sharpness: dict[float, float] = {}
        for name in SCHEDULES:
            schedule = field_or_none(self, name)
            if isinstance(schedule, Profile | Steps):
                curve = self.curve(name)
                sharp = np.nan_to_num(curve.bends, nan=0.0, posinf=1e9)
                # of the winder's inputs, which may be zero, relative to what they change
                if name == "winder.rider_load":
                    sharp = curve.kinks * curve.jumps / np.abs(self.at("nip_load", curve.kinks))
                elif name == "winder.core_torque":
                    sharp = curve.jumps / self.at("web_tension", curve.kinks)
                for r, bend in zip(curve.kinks.tolist(), sharp.tolist(), strict=True):
                    sharpness[r] = max(sharpness.get(r, 0.0), bend)
        return dict(sorted(sharpness.items()))

    def radii(self, count: int) -> Array:
        """Return ``count`` equidistant radii from core to surface and those of all kinks [m]."""
        return np.union1d(np.linspace(*self.ends, count), list(self.kinks))

    # ---- nip and roll ---------------------------------------------------------------------------

    def nip(self, radius: float, roll: Body) -> NipProblem:
        """Return the nip, with the air, at a radius of the roll [m]; ``roll`` is its body."""
        fields: dict[str, Any] = {
            name: getattr(self, name) for name in NipProblem.model_fields if name in NIP_FIELDS
        }
        fields |= {name: float(self.at(name, radius)) for name in LOADS}
        if self.winder is not None:
            fields |= self._next_nips(self.winder, radius)
        if self._speed_has_effect:  # else a warning that it has no effect
            fields |= {"web_speed": self.web_speed, "air": self.air}
        if self.web_speed is not None:
            fields["density"] = self.density
        return NipProblem(**fields, roll=roll)

    def _next_nips(self, winder: TwoDrums, radius: float) -> dict[str, Any]:
        """Return the fields of a nip for the front drum and the rider at a radius of the roll [m].

        The web is held to the roll ``roll_wrap`` downstream of the last nip, but not beyond HELD of
        the arc on to the rear drum, next to which the roll is deformed by its nip.
        """
        loads = self.drum_loads(radius)
        nips = [
            NextNip(
                angle=float(loads.front_arc),
                drum=winder.front_drum,
                nip_load=float(loads.front_load),
                winding_force=float(loads.front_force),
                drum_friction=self.front_friction,
            )
        ]
        to_rear_drum = float(loads.rider_arc + loads.returning_arc)
        if winder.rider is not None:
            nips.append(
                NextNip(
                    angle=float(loads.rider_arc),
                    drum=winder.rider,
                    nip_load=float(loads.rider_load),
                    drum_friction=self.rider_friction,
                )
            )
            to_rear_drum = float(loads.returning_arc)
        last_arc = min(self.roll_wrap, HELD * to_rear_drum)
        return {"next_nips": nips, "roll_wrap": sum(nip.angle for nip in nips) + last_arc}

    def wound_roll(
        self,
        wound_on_tension: AnySchedule,
        film: float = 0.0,
        *,
        rotates: bool = True,
        changes: bool = True,
    ) -> RollProblem:
        """Return the roll for a wound-on tension [N/m] and an air film [m] between its layers.

        It carries the centrifugal force of the web, if that is known, unless ``rotates`` is False,
        and has the changes after winding unless ``changes`` is False.
        """
        after_winding = {name: getattr(self, name) for name in OF_FINISHED_ROLL} if changes else {}
        roll = RollProblem(
            core=self.core,
            radius=self.radius,
            stack=self.stack,
            web_thickness=self.web.thickness,
            wound_on_tension=wound_on_tension,
            caliper_pressure=self.caliper_pressure,
            density=self.density,
            web_speed=self.web_speed if rotates and self.density is not None else None,
            gauge_excess=self.gauge_excess,
            **after_winding,
        )
        if self.air is None:
            return roll
        smallest = self.core.radius + FEWEST_LAYERS * (self.web.thickness + film)
        if not is_within(self.radius, smallest, inf):
            text = f"{quote(self.radius)} is out of range; must be >= {smallest:.6g} [m]"
            layers = f"{FEWEST_LAYERS} layers with the entrained air between them"
            raise InvalidProblem.at("radius", f"{text}: {layers}")
        return with_film(roll, film, self.air)

    @property
    def unused(self) -> tuple[str, ...]:
        """See :attr:`.Problem.unused`."""
        solves_nips, has_winder = self.solves_nips, self.winder is not None
        unused = [
            "web.material.shear_exponent",  # the shear modulus of the web has no effect in a nip
            *self._unused_changes,
            *unused_in_tapers(self, SCHEDULES),
        ]
        if not (solves_nips and self.roll_body == "direct"):  # no other body hardens
            unused.append("stack.shear_exponent")
        if self.torque_split is not None:  # it gives the winding force
            unused.append("winding_force")
        if not self.has_nip:
            unused += ["winding_force", "torque_split", "drum_friction"]
        if not solves_nips:
            unused += OF_NIP_ALONE if has_winder else OF_NIP
        if not (solves_nips or has_winder):  # two drums carry the roll also without solved nips
            unused.append("drum")
        if self.thickness_profile is None:  # it is the profile that oscillates
            unused.append("oscillation")
        if not self._uses_speed:
            unused.append("web_speed")
        return (*unused, *self._unused_inertia)

    @property
    def _unused_inertia(self) -> tuple[str, ...]:
        """Moments of inertia on which no drive depends in this case."""
        if self.width is None or not self.web_speed:
            return ("inertia",)
        if not self.has_nip:
            return "inertia.drum", "inertia.front_drum", "inertia.rider"
        if self.winder is None:
            return "inertia.front_drum", "inertia.rider"
        return () if self.winder.rider is not None else ("inertia.rider",)

    def _warnings_of_inertia(self, inertia: Inertia) -> Iterator[str]:
        """Yield a warning for each moment of inertia that is given without effect."""
        if self.width is None or not self.web_speed:
            yield "inertia is not used: torques of the drives need width and web_speed > 0"
            return
        for name in self._unused_inertia:
            if getattr(inertia, name.removeprefix("inertia.")):
                yield f"{name} is not used, as the winding has no such drum"

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return of_winding(self)

    @classmethod
    def example(cls) -> Self:
        """Return newsprint of the thesis's Table 2 on a hard drum; K1 and K2 are illustrative."""
        return cls(
            web=Web(thickness=66e-6, material=material("newsprint")),
            stack=EXAMPLE,
            core=Core(radius=0.05, stiffness=1e9),
            drum=Rigid(radius=0.25),
            radius=0.6,
            roll_friction=0.19,
            drum_friction=0.2,
            web_tension=Taper(start=350.0, taper=0.3),
            nip_load=2000.0,
            density=680.0,
        )

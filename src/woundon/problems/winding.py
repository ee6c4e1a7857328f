"""The winding of a roll through a nip, with schedules over the radius."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import InitVar
from math import pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from ..errors import InvalidProblem, NoSteadyState
from ..quantities import length, line_load, pure, tension, velocity
from .air import Air, with_film
from .assumptions import of_winding
from .bodies import AnyBody, Body, Rigid
from .consistency import different_moduli
from .contact_problem import unused_speed
from .fields import Nested, Number, OptionalNested, OptionalNumber, default
from .limits import Limits
from .materials import Material, material
from .messages import not_one_of, quote
from .nip import (
    WRAP_TABLE,
    DrumFriction,
    DrumWrap,
    NipProblem,
    RollFriction,
    RollWrap,
    Width,
    WrapFriction,
    friction_capacity,
)
from .permitted import Conditional
from .problem import OF_FINISHED_ROLL, Problem, only_in
from .radial_laws import Pfeiffer
from .roll import Core, GaugeExcess, RollProblem
from .schedules import (
    Curve,
    OptionalWindingSchedule,
    Profile,
    Taper,
    WindingSchedule,
    as_schedule,
    uncovered_ends,
    unused_in_tapers,
    values_of,
)
from .stack import AnyStack, Stack
from .thickness_profile import Oscillation, ThicknessProfile, faults_across, warnings_across
from .web import CaliperPressure, Web, WebDensity

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .fields import CoercedField
    from .grades import Grade

__all__ = ["WindingProblem"]

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
}
LOADS = ("nip_load", "winding_force", "web_tension")
# Fields of the nip that do not depend on the radius.
NIP_FIELDS = frozenset({"web", "drum", "roll_friction", "drum_friction", *WRAP_TABLE["wrap"]})
# Parts of a winding whose only effect is that of its nips.
OF_NIP = ("web.material", "drum", *WRAP_TABLE["wrap"], "roll_body")
CHECKED_RADII = 257  # radii, in addition to all kinks, at which a steady state must exist


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


class WindingProblem(Problem):
    """The winding of a roll: nip and roll coupled over the radius.

    Parameters
    ----------
    web : Web
    stack : Stack
        The web's layers in the roll.
    core : Core
    drum : Rigid, HalfPlane, Cylinder or another Body
    radius : float
        R of the finished roll [m].
    roll_friction, drum_friction, roll_wrap, drum_wrap, wrap_friction
        As of :class:`~woundon.NipProblem`.
    web_tension, nip_load, winding_force : float, Taper or Profile
        T_in, P and F over the radius [N/m]; F = 0: centre winding.
    torque_split : float, Taper or Profile, optional
        Fraction of the web tension carried by the drum, F = -torque_split T_in, instead of F: 0 is
        centre winding, 1 surface winding.
    roll_body : "effective", "direct" or "linear"
        Model of the roll in the nip.  "effective": a linear cylinder with E_r at the pressure of
        wound roll and nip, an estimate.  "direct": the hardening roll with its wound-in pressure.
        "linear": a cylinder with the moduli of the web.
    tension_law : "nip", "friction", "fixed" or Profile
        Model of the wound-on tension.  "nip": the solved wrapped nip.  "friction":
        T_in + F + roll_friction P, full slip in the nip.  "fixed": T_in +
        nip_induced_tension.  A Profile is the wound-on tension itself [N/m].
    nip_induced_tension : float, Taper or Profile, optional
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
    web_speed : float, optional
        V [m/s], needed with air or a viscoelastic drum.
    air : Air, optional
        Entrained air reduces the friction in the nip and softens the roll; with tension_law "nip".
    limits : Limits
        Limits to which the margins refer.
    width : float, optional
        Of the web [m]. With it, loads and tensions may be entered as totals, "3.6 kN"; they are
        held per metre of width.

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
    )
    counterparts: ClassVar[Mapping[str, str]] = {
        "roll": "give core, radius and stack",
        "web_thickness": "give web.thickness",
        "wound_on_tension": "give it as tension_law, a Profile",
        "tangential_load": "give winding_force or torque_split",
        "lower": "give drum",
        **only_in("RollProblem", *OF_FINISHED_ROLL),
        **only_in("RollerProblem", "upper", "creepage", "motion"),
    }

    # Fields that the grade supplies are required without one; type checkers must accept both.
    if TYPE_CHECKING:
        grade: InitVar[Grade | str | Mapping[str, Any]] = Field(...)
        diameter: InitVar[float | str] = Field(...)
    web: Annotated[Nested[Web], Field(description="the paper or film")] = Field(...)
    stack: AnyStack = Field(...)
    core: Nested[Core]
    drum: Annotated[AnyBody, Field(description="the winding drum")]
    radius: Annotated[
        Number,
        length("R", "radius of the finished roll", typical=(0.1, 0.75)),
        Field(gt=0, le=100),
    ] = Field(...)
    roll_friction: RollFriction = Field(...)
    drum_friction: DrumFriction = Field(...)
    web_tension: Annotated[
        WindingSchedule, tension("T_in", "web tension upstream of the nip", (50.0, 1000.0))
    ]
    nip_load: Annotated[WindingSchedule, line_load("P", "nip load", (500.0, 10e3))]
    winding_force: Annotated[
        WindingSchedule,
        line_load("F", "winding force (drum traction resultant), F = -M2/R2", (-500.0, 500.0)),
    ] = default(0.0)
    torque_split: Annotated[
        OptionalWindingSchedule,
        pure("s_F", "fraction of the web tension carried by the drum, -F/T_in", (0.0, 1.0)),
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
    density: Annotated[WebDensity, Conditional("required with limits.acceleration")] = default(None)
    gauge_excess: GaugeExcess = default(0.0)
    thickness_profile: OptionalNested[ThicknessProfile] = default(None)
    oscillation: Oscillation = default(0.0)
    limits: Annotated[Nested[Limits], Field(description="limits of web, roll and core")] = default(
        Limits()
    )

    web_speed: Annotated[
        OptionalNumber,
        velocity("V", "web speed", (1.0, 50.0)),
        Field(ge=0, le=200),
        Conditional("required with air or a viscoelastic drum"),
    ] = default(None)
    air: OptionalNested[Air] = default(None)
    width: Width = default(None)

    @model_validator(mode="after")
    def _check_winding(self) -> Self:
        """Check the roll, the schedules and their combination."""
        try:  # checks core, number of layers and density; with any tension
            self.wound_roll(wound_on_tension=1.0)
        except InvalidProblem as fault:
            own_names = {"web_thickness": "web.thickness"}  # by the name of the field of a roll
            faults = [(own_names.get(field, field), text) for field, text in fault.faults]
            raise InvalidProblem(faults) from None
        faults = [fault for name in SCHEDULES for fault in self._faults_of(name)]
        faults += self._contradictions()
        faults += faults_across(self, self.width)
        if faults:
            raise InvalidProblem(faults)
        if self.tension_law in ("nip", "friction"):
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
        if self.torque_split is not None and self.winding_force != 0.0:
            yield ("torque_split", "is given together with winding_force; must be one of the two")
        if self.roll_body == "linear" and not isinstance(self.web.material, Material):
            yield "roll_body", "'linear' needs the moduli of a web that does not harden"
        if self.limits.acceleration and self.density is None:
            text = f"{quote(self.limits.acceleration)} is given without the web's density"
            yield "limits.acceleration", f"{text}; must be 0, or density be given [kg/m^3]"
        if self.air is not None and self.web_speed is None:
            yield "web_speed", "missing; must be given with air"
        if self.drum.viscoelastic:
            if self.web_speed is None:
                yield (
                    "web_speed",
                    "missing; must be > 0 [m/s], as drum is of a viscoelastic material",
                )
            elif self.web_speed == 0:
                text = "0 is out of range; must be > 0 [m/s], as drum is of a viscoelastic material"
                yield "web_speed", text
        if self.air is not None:
            for field, text in self.air.too_rough(self.web.thickness):
                yield f"air.{field}", text
        if self.air is not None and self.tension_law != "nip":
            yield "air", "needs tension_law = 'nip', which computes the entrained air"

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        texts = [
            *super().input_warnings,
            *different_moduli(self.web, "stack", self.stack),
            *self.stack.input_warnings("stack"),
            *warnings_across(self, self.web.thickness),
        ]
        if self.web_speed is not None and self.air is None and not self.drum.viscoelastic:
            texts.append(unused_speed("web_speed", self.web_speed))
        return tuple(texts)

    def _faults_of(self, name: str) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for a schedule out of range, or a profile that is too short.

        The numbers of the schedule are checked, and the value that a taper leaves at the surface.
        """
        schedule = getattr(self, name)
        if schedule is None or isinstance(schedule, str):
            return
        low, high = SCHEDULES[name]
        unit = "" if name == "torque_split" else " [N/m]"
        must = f"must be >= {low:g} and <= {high:g}{unit}"
        wrong = [
            (f"{name}{part}", f"{quote(value)} is out of range; {must}")
            for part, value in values_of(schedule).items()
            if not low <= value <= high
        ]
        if isinstance(schedule, Profile):
            wrong += uncovered_ends(name, schedule, *self.ends)
        yield from wrong
        if isinstance(schedule, Taper) and not wrong:
            value = float(self.curve(name).at(np.array(self.radius)))
            if not low <= value <= high:
                at = f"at the radius {self.radius:.6g} [m]"
                text = f"{quote(schedule.taper)} is out of range; leaves {quote(value)}{unit} {at}"
                yield f"{name}.taper", f"{text}, {must}"

    def _check_steady_state(self) -> None:
        """Reject a winding force that the friction of nip and drum wrap cannot transmit."""
        r = self.radii(CHECKED_RADII)
        P, T, F = (self.at(name, r) for name in ("nip_load", "web_tension", "winding_force"))
        low, high = map(np.asarray, friction_capacity(P, T, self.drum_friction, self.drum_wrap))
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

    # ---- schedules ------------------------------------------------------------------------------

    @property
    def ends(self) -> tuple[float, float]:
        """Radii of core and finished roll [m]."""
        return self.core.radius, self.radius

    def curve(self, name: str) -> Curve:
        """Return the schedule of a field over the radius."""
        return Curve(getattr(self, name), *self.ends)

    def at(self, name: str, r: ArrayLike) -> Array:
        """Return the values of a schedule at radii [m]; F may be given by the torque split."""
        r = np.asarray(r, dtype=float)
        if name == "winding_force" and self.torque_split is not None:
            return -self.curve("torque_split").at(r) * self.curve("web_tension").at(r)
        return self.curve(name).at(r)

    @property
    def kinks(self) -> dict[float, float]:
        """Radii of the kinks of all schedules [m], with their sharpness r |d slope|/value."""
        sharpness: dict[float, float] = {}
        for name in SCHEDULES:
            schedule = getattr(self, name)
            if isinstance(schedule, Profile):
                curve = self.curve(name)
                # a value of zero at a kink: infinitely sharp, or no kink if the slope does not jump
                with np.errstate(divide="ignore", invalid="ignore"):
                    sharp = np.nan_to_num(curve.bends, nan=0.0, posinf=1e9)
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
        if self.drum.viscoelastic or self.air is not None:  # else a warning that it has no effect
            fields |= {"web_speed": self.web_speed, "air": self.air}
        return NipProblem(**fields, roll=roll)

    def wound_roll(
        self, wound_on_tension: float | Taper | Profile, film: float = 0.0
    ) -> RollProblem:
        """Return the roll for a wound-on tension [N/m] and an air film [m] between its layers."""
        roll = RollProblem(
            core=self.core,
            radius=self.radius,
            stack=self.stack,
            web_thickness=self.web.thickness,
            wound_on_tension=wound_on_tension,
            caliper_pressure=self.caliper_pressure,
            density=self.density,
            gauge_excess=self.gauge_excess,
        )
        return roll if self.air is None else with_film(roll, film, self.air)

    @property
    def unused(self) -> tuple[str, ...]:
        """See :attr:`.Problem.unused`."""
        solves_nips = self.tension_law == "nip"
        hardens = solves_nips and self.roll_body == "direct"
        return (
            "web.material.shear_exponent",
            *unused_in_tapers(self, SCHEDULES),
            *(() if hardens else ("stack.shear_exponent",)),
            *(() if self.torque_split is None else ("winding_force",)),
            *(() if solves_nips else OF_NIP),
            *(("oscillation",) if self.thickness_profile is None else ()),
        )

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return of_winding(self)

    @classmethod
    def example(cls) -> Self:
        """Return newsprint of the thesis's Table 2 on a hard drum; K1 and K2 are illustrative."""
        stack = Stack(
            radial=Pfeiffer(K1=10e3, K2=40.0), tangential=3.38e9, poissons_ratio=0.01, shear=10e6
        )
        return cls(
            web=Web(thickness=66e-6, material=material("newsprint")),
            stack=stack,
            core=Core(radius=0.05, stiffness=1e9),
            drum=Rigid(radius=0.25),
            radius=0.6,
            roll_friction=0.19,
            drum_friction=0.2,
            web_tension=Taper(start=350.0, taper=0.3),
            nip_load=2000.0,
            density=680.0,
        )

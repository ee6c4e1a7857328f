"""The wound roll: core, web, stack and wound-on tension."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import InitVar
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Values, length, share, stress, tension, thickness_of_web
from .air_law import AirBetween
from .assumptions import of_roll
from .description import Description
from .fields import Nested, Number, OptionalNumber, default
from .finished_roll import (
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
from .materials import Isotropic, OptionalMaterial
from .messages import quote
from .permitted import Conditional, is_within
from .problem import only_in
from .radial_laws import RadialLaw
from .schedules import (
    Curve,
    Profile,
    Taper,
    WindingSchedule,
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
from .web import CaliperPressure, WebDensity, WebSpeed, centrifugal_stress

if TYPE_CHECKING:
    from .grades import Grade

__all__ = ["Core", "FinishedRadius", "GaugeExcess", "RollProblem"]

# The layers are a continuum, which needs many of them; above a million the web is no paper or film.
FEWEST_LAYERS, MOST_LAYERS = 10, 1e6
MOST_COMPRESSED = 0.5  # strain under the caliper pressure; small strains end far below

# Fields of rolls and windings.
FinishedRadius = Annotated[
    Number, length("R", "radius of the finished roll", typical=(0.1, 0.75)), Field(gt=0, le=100)
]
GaugeExcess = Annotated[
    Number,
    share("d", "gauge excess: relative additional thickness of the thickest lane"),
    Field(ge=0, le=0.1),
]


class Core(Description):
    """The core of a roll: its stiffness, or a tube.

    Parameters
    ----------
    radius : float
        Outer radius r_c [m].
    stiffness : float, optional
        E_c [Pa]: the radius decreases by r_c P/E_c under the pressure P.
    inner_radius : float, optional
        Inner radius of a tube [m], instead of the stiffness.
    material : Isotropic, optional
        Material of the tube, in plane strain.

    Raises
    ------
    InvalidProblem
        Unless either a stiffness or a tube is given.

    Examples
    --------
    >>> import woundon as wo
    >>> core = wo.Core(diameter="100 mm", inner_diameter="80 mm", material="steel")
    >>> f"{core.effective_stiffness / 1e9:.1f} GPa"
    '54.9 GPa'
    """

    radius: Annotated[
        Number,
        length("r_c", "outer radius of the core", typical=(0.02, 0.3)),
        Field(gt=0, le=100),
    ] = Field(...)
    stiffness: Annotated[
        OptionalNumber,
        stress("E_c", "stiffness of the core", "MPa", (1e8, 1e11)),
        Field(gt=0, le=1e18),
        Conditional("required unless inner_radius and material define a tube"),
    ] = default(None)
    inner_radius: Annotated[
        OptionalNumber,
        length("r_i", "inner radius of a tube"),
        Field(ge=0),
        Conditional("required with material, without stiffness"),
    ] = default(None)
    material: Annotated[
        OptionalMaterial, Conditional("required with inner_radius, without stiffness")
    ] = default(None)
    if TYPE_CHECKING:
        diameter: InitVar[float | str] = Field(...)
        inner_diameter: InitVar[float | str] = Field(...)

    @model_validator(mode="after")
    def _check_stiffness(self) -> Self:
        """Reject a core without stiffness, or with a stiffness and a tube."""
        tube = self.inner_radius is not None or self.material is not None
        if (self.stiffness is not None) == tube:
            raise InvalidProblem.at(
                "stiffness",
                "is given together with a tube; must be one of the two"
                if tube
                else "missing; must be > 0 [Pa], unless inner_radius and material define a tube",
            )
        if not tube:
            return self
        if self.inner_radius is None or not isinstance(self.material, Isotropic):
            text = "missing; a tube needs an inner radius and an isotropic material"
            raise InvalidProblem.at(
                "inner_radius" if self.inner_radius is None else "material", text
            )
        if self.inner_radius >= self.radius:
            raise InvalidProblem.at(
                "inner_radius",
                f"{quote(self.inner_radius)} is out of range; must be >= 0 and < radius = "
                f"{self.radius:.6g} [m]",
            )
        return self

    @property
    def effective_stiffness(self) -> float:
        """E_c [Pa]: as given, or of a thick tube in plane strain (Lame)."""
        if self.stiffness is not None:
            return self.stiffness
        assert isinstance(self.material, Isotropic)
        assert self.inner_radius is not None
        E, nu = self.material.youngs_modulus, self.material.poissons_ratio
        s = (self.inner_radius / self.radius) ** 2
        return E / ((1 + nu) * ((1 + s) / (1 - s) - nu * 2 / (1 - s)))


class RollProblem(FinishedRollProblem):
    """The stresses in a roll that is wound layer by layer with a given wound-on tension.

    The layers are thin relative to the radius, in plane strain, and obey the law of the stack.

    Parameters
    ----------
    core : Core
    radius : float
        R of the finished roll [m].
    stack : Stack
    web_thickness : float
        2h [m].
    wound_on_tension : float, Taper, Steps or Profile
        WOT over the radius [N/m], > 0.
    caliper_pressure : float, optional
        Pressure under which web_thickness was measured [Pa], 100 kPa in ISO 534.  Without it
        web_thickness is that of the web without pressure.  Length, number of layers, mass and
        density depend on it, pressures and stresses do not.
    density : float, optional
        Density of the web [kg/m^3]; with it the result contains the mass of the roll.
    web_speed : float, optional
        V [m/s].  With the density the web carries its centrifugal force m V^2: it presses with
        WOT - m V^2, and the layers carry the body force of a roll that runs at this surface speed.
        The finished roll is at rest.
    gauge_excess : float
        d, relative additional thickness of a lone thick lane across the width [1], in closed form.
        It affects only the margin and the ridge height of that lane.
    thickness_profile : ThicknessProfile, optional
        Thickness across the width, instead of ``gauge_excess``: the result then has ``lanes``.
    oscillation : float
        Amplitude by which the web moves to and fro across the roll [m]: the profile is averaged.
    temperature_change, moisture_change : float or Profile
        Change of the temperature [K] and of the moisture content, mass of water over mass of dry
        web [1], of the finished roll including its core; over the radius if it has not evened out,
        as in a roll that dries from its surface.
    tangential_expansion, radial_expansion, core_expansion : float
        Coefficients of thermal expansion along the web, through the stack, of the core [1/K].
    tangential_swelling, radial_swelling, core_swelling : float
        Strains along the web, through the stack and of the core by a change of the moisture content
        of 1 [1]: 0.02 is 0.02 % per percent of moisture.
    core_shrinkage : float
        Relative shrinkage of the unloaded core of the finished roll [1].
    core_removed : bool
        True for a roll that is taken off its core or mandrel after winding.

    Raises
    ------
    InvalidProblem
        Naming every invalid field with its value and permitted range.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollProblem.example())
    >>> result.pressure.shape == result.radius.shape
    True
    """

    graded: ClassVar[tuple[str, ...]] = ("stack", "web_thickness", "density", *OF_WEB)
    counterparts: ClassVar[Mapping[str, str]] = {
        "web": "give web_thickness and stack",
        "roll": "give core, radius and stack",
        "web_tension": "give wound_on_tension, web tension plus nip-induced tension",
        "nip_induced_tension": "give wound_on_tension, web tension plus nip-induced tension",
        "tension_law": "give wound_on_tension",
        "limits": "give them to woundon.margins; a WindingProblem has it",
        **only_in("WindingProblem", "drum", "roll_friction", "drum_friction", "nip_load"),
        **only_in("WindingProblem", "winding_force", "torque_split", "roll_wrap", "drum_wrap"),
        **only_in("NipProblem", "next_nips"),
        **only_in("WindingProblem", "winder", "wrap_friction", "roll_body", "air", "width"),
        **only_in("WindingProblem", "drum_bending", "core_bending", "inertia"),
        **only_in("RollerProblem", "upper", "lower", "load", "friction", "tangential_load"),
        **only_in("RollerProblem", "creepage", "motion", "speed"),
    }

    # Fields that the grade supplies are required without one; type checkers must accept both.
    if TYPE_CHECKING:
        grade: InitVar[Grade | str | Mapping[str, Any]] = Field(...)
        diameter: InitVar[float | str] = Field(...)
    core: Nested[Core]
    radius: FinishedRadius = Field(...)
    stack: AnyStack = Field(...)
    web_thickness: Annotated[Number, thickness_of_web((1e-5, 5e-4)), Field(gt=0, le=0.1)] = Field(
        ...
    )
    wound_on_tension: Annotated[WindingSchedule, tension("WOT", "wound-on tension", (50.0, 1500.0))]
    caliper_pressure: CaliperPressure = default(None)
    density: WebDensity = default(None)
    web_speed: WebSpeed = default(None)
    temperature_change: TemperatureChange = default(0.0)
    tangential_expansion: TangentialExpansion = default(0.0)
    radial_expansion: RadialExpansion = default(0.0)
    core_expansion: CoreExpansion = default(0.0)
    moisture_change: MoistureChange = default(0.0)
    tangential_swelling: TangentialSwelling = default(0.0)
    radial_swelling: RadialSwelling = default(0.0)
    core_swelling: CoreSwelling = default(0.0)
    gauge_excess: GaugeExcess = default(0.0)
    thickness_profile: OptionalThicknessProfile = default(None)
    oscillation: Oscillation = default(0.0)
    core_shrinkage: CoreShrinkage = default(0.0)
    core_removed: CoreRemoved = default(False)

    @model_validator(mode="after")
    def _check_build_up(self) -> Self:
        """Reject a core that is larger than the roll, and a web too thick or too thin."""
        core, radius = self.core.radius, self.radius
        if core >= radius:
            raise InvalidProblem.at(
                "core.radius",
                f"{quote(core)} is out of range; must be > 0 and < radius = {radius:.6g} [m]",
            )
        thinnest, thickest = ((radius - core) / layers for layers in (MOST_LAYERS, FEWEST_LAYERS))
        if not is_within(self.web_thickness, thinnest, thickest):
            raise InvalidProblem.at(
                "web_thickness",
                f"{quote(self.web_thickness)} is out of range; must be >= {thinnest:.4g} and <= "
                f"{thickest:.4g} [m]: {FEWEST_LAYERS} to {MOST_LAYERS:.0e} layers",
            )
        self._check_tension()
        if faults := [*self._faults_of_changes(), *faults_across(self)]:
            raise InvalidProblem(faults)
        highest = self._law_of_web.max_pressure
        # 1e7 Pa is the largest caliper pressure that its field admits
        if float(self._law_of_web.strain_at(1e7)) > MOST_COMPRESSED:
            highest = min(highest, float(self._law_of_web.pressure_at(MOST_COMPRESSED)))
        if (self.caliper_pressure or 0.0) > highest:
            raise InvalidProblem.at(
                "caliper_pressure",
                f"{quote(self.caliper_pressure)} is out of range; must be >= 0 and <= "
                f"{highest:.4g} [Pa], where the stack's law ends or its strain is "
                f"{MOST_COMPRESSED:g}",
            )
        return self

    def _check_tension(self) -> None:
        """Reject a tension that is not positive from the core to the surface."""
        schedule = self.wound_on_tension
        ends = self.core.radius, self.radius
        if misfits := list(misfits_on_roll("wound_on_tension", schedule, *ends)):
            raise InvalidProblem(misfits)
        for name, value in values_of(schedule).items():
            if not 0 < value <= 1e6:
                text = f"{quote(value)} is out of range; must be > 0 and <= 1e+06 [N/m]"
                raise InvalidProblem.at(f"wound_on_tension{name}", text)
        if isinstance(schedule, Profile) and schedule.between == "smooth":
            between = schedule.at(np.linspace(self.core.radius, self.radius, 2001))
            if not (between > 0).all():
                text = f"the smooth curve falls to {quote(float(between.min()))} between its values"
                raise InvalidProblem.at(
                    "wound_on_tension.value",
                    f"{text}; must be > 0 [N/m]: give more values, or between = 'lines'",
                )
        if isinstance(schedule, Taper) and not self.tension_curve.at(np.array(self.radius)) > 0:
            name = schedule.field_of_law
            raise InvalidProblem.at(
                f"wound_on_tension.{name}",
                f"{quote(getattr(schedule, name))} is out of range; the tension at the surface "
                "must be > 0 [N/m]",
            )
        self._check_centrifugal_force()

    def _check_centrifugal_force(self) -> None:
        """Reject a tension that does not hold the running web on the roll."""
        force = self.centrifugal_tension
        if not force:
            return
        curve = self.tension_curve
        r = np.union1d(np.linspace(self.core.radius, self.radius, 2001), curve.kinks)
        tension = curve.at(r) * self.web_thickness
        k = int(np.argmin(tension))
        if tension[k] <= force:
            raise InvalidProblem.at(
                "wound_on_tension",
                f"{quote(float(tension[k]))} at the radius {r[k]:.6g} [m] is out of range; must be "
                f"> {force:.6g} [N/m], the centrifugal force density * web_thickness * "
                "web_speed^2, or the web lifts off the roll",
            )

    @property
    def tension_curve(self) -> Curve:
        """The wound-on stress T = WOT/2h over the radius [Pa]."""
        return Curve(self.wound_on_tension, self.core.radius, self.radius, 1 / self.web_thickness)

    def bending_strain(self, radius: Values) -> Values:
        """Return h/2r, the strain at the faces of a straight web that is bent to a radius [m]."""
        strain: Any = self.web_thickness / (2 * radius)
        return strain

    @property
    def centrifugal_stress(self) -> float:
        """rho V^2 of the running web [Pa]; 0 without web speed or density."""
        return centrifugal_stress(self.density, self.web_speed)

    @property
    def centrifugal_tension(self) -> float:
        """m V^2 of the running web [N/m]; 0 without web speed or density."""
        return self.centrifugal_stress * self.web_thickness

    @property
    def unused(self) -> tuple[str, ...]:
        """See :attr:`.Problem.unused`."""
        return (
            "stack.shear_exponent",  # an axisymmetric roll is not sheared
            *self._unused_changes,
            *unused_in_tapers(self, ("wound_on_tension",)),
            *(("oscillation",) if self.thickness_profile is None else ()),
            *(("web_speed",) if self.density is None else ()),
        )

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        return (
            *super().input_warnings,
            *self._warnings_of_speed(),
            *self._warnings_of_changes(),
            *self.stack.input_warnings("stack"),
            *warnings_across(self, self.web_thickness),
        )

    def _warnings_of_speed(self) -> Iterator[str]:
        """Yield a warning about a speed that changes nothing."""
        if self.web_speed and self.density is None:
            text = f"web_speed = {self.web_speed:.6g} m/s is not used"
            yield f"{text}: without density the centrifugal force of the web is neglected"

    @property
    def _law_of_web(self) -> RadialLaw:
        """The law of the stack without air."""
        law = self.stack.radial
        return law.law if isinstance(law, AirBetween) else law

    @property
    def unloaded_thickness(self) -> float:
        """Thickness of a layer without pressure [m]: h_0 = h/(1 - F(p_c)), and the air film."""
        law = self.stack.radial
        film = law.film if isinstance(law, AirBetween) else 0.0
        strain = float(self._law_of_web.strain_at(self.caliper_pressure or 0.0))
        return (self.web_thickness - film) / (1 - strain) + film

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions of the model for this case, as sentences."""
        return of_roll(self)

    @classmethod
    def example(cls) -> Self:
        """Return a newsprint roll of Table 2's web; the stack's K1 and K2 are illustrative."""
        return cls(
            core=Core(radius=0.0445, stiffness=1e9),
            radius=0.15,
            stack=EXAMPLE,
            web_thickness=66e-6,
            wound_on_tension=350.0,
            density=680.0,
        )

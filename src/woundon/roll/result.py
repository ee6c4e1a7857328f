"""The result of a wound roll: pressure and stresses over the radius."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import nan, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from ..arguments import check_type
from ..problems.web import CENTRIFUGAL_TENSION
from ..quantities import Quantity, length, line_load, pure, share, strain, stress
from ..results import Residuals
from .certificate import certificate
from .collapse import BONDED, SLIDING, collapse_loads
from .density import density_during_winding, finished_density, volume, wound_length, wound_mass
from .finished import bore_displacement, core_gap, opening
from .finite_layers import finite_layer_errors, finite_layer_stresses
from .lane_roll import LANES, LaneRoll
from .roll_fields import RollFields
from .solve_lanes import build_up_of, solve_lanes
from .stages import Stage, stage_arrays, stresses_between, wound_stage
from .validity import roll_warnings
from .weight import flat_width, weight_of_layers, weight_share

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["RollResult", "WithRoll"]

Array = np.ndarray
SAMPLES = 1001  # radii at which the sign of the hoop stress is evaluated


class WithRoll:
    """Outputs of the wound roll, of a result that is one or has wound one."""

    @property
    def roll(self) -> RollResult:
        """The finished roll."""
        raise NotImplementedError

    @property
    def core_pressure(self) -> Annotated[float, stress("P_c", "pressure on the core")]:
        """P at the core [Pa]."""
        return float(self.roll.pressure[0])

    @property
    def peak_pressure(self) -> Annotated[float, stress("P_max", "largest pressure in the roll")]:
        """Largest P [Pa]."""
        return float(np.max(self.roll.pressure))

    @property
    def mid_pressure(self) -> Annotated[float, stress("P_mid", "pressure halfway to the surface")]:
        """P half-way between core and surface [Pa]."""
        r = self.roll.radius
        return float(self.roll.at_radius((r[0] + r[-1]) / 2)["pressure"])

    @property
    def least_hoop_stress(
        self,
    ) -> Annotated[float, stress("sigma_min", "minimum hoop (MD) stress, < 0: compression")]:
        """Smallest sigma_t [Pa]."""
        return float(np.min(self.roll.hoop_stress))

    @property
    def bore_hoop_stress(
        self,
    ) -> Annotated[float, stress("sigma_b", "hoop (MD) stress at the bore, > 0: tension")]:
        """sigma_t of the innermost layer [Pa]."""
        return float(self.roll.hoop_stress[0])

    @property
    def bore_displacement(
        self,
    ) -> Annotated[float, length("u_b", "change of the radius of the bore since winding", "um")]:
        """Outward displacement of the inner face since the innermost layer was wound [m].

        Winding, the changes after it and the release from the core move it.
        """
        return bore_displacement(self.roll)

    @property
    def core_gap(
        self,
    ) -> Annotated[float, length("g_c", "gap between the core and the roll", "um")]:
        """Radial gap between core and roll, zero if they touch [m]; nan if the core is removed."""
        return core_gap(self.roll)

    @property
    def separation_radius(
        self,
    ) -> Annotated[float, length("r_s", "outer radius of the open layers")]:
        """Largest radius at which the layers have separated [m]; nan if none have."""
        is_open = self.roll.opening > 0
        return float(self.roll.radius[is_open][-1]) if is_open.any() else float("nan")

    @property
    def sliding_collapse_load(self) -> Annotated[float, SLIDING]:
        """Pressure on the inner layers over their buckling pressure, if they slide freely [1].

        Below 1 they do not collapse; nan on a core, which supports them.
        """
        return collapse_loads(self.roll).sliding

    @property
    def bonded_collapse_load(self) -> Annotated[float, BONDED]:
        """Pressure on the inner layers over their buckling pressure, if they stick together [1].

        Above 1 they collapse even without slip; nan on a core, which supports them.
        """
        return collapse_loads(self.roll).bonded

    @property
    def length(
        self,
    ) -> Annotated[float, length("L", "length of web, counted in layers without pressure", "m")]:
        """Area of the end face divided by the thickness of the web without pressure [m]."""
        roll = self.roll
        R, core = float(roll.radius[-1]), float(roll.radius[0])
        return pi * (R**2 - core**2) / roll.problem.unloaded_thickness

    @property
    def wound_length(
        self,
    ) -> Annotated[float, length("L_w", "length of web, its layers compressed as wound", "m")]:
        """Length of web without stress whose layers, compressed as wound, fill the roll [m]."""
        return float(wound_length(self.roll))

    @property
    def mass(
        self,
    ) -> Annotated[float, Quantity("m", "kg/m", "mass of the web, per width")]:
        """Mass of ``length`` of the web [kg/m]; nan without its density."""
        problem = self.roll.problem
        if problem.density is None:
            return nan
        return self.length * float(problem.web_thickness) * float(problem.density)

    @property
    def running_core_pressure(
        self,
    ) -> Annotated[float, stress("P_c,V", "pressure of the running roll on the core")]:
        """P of the running roll at the core [Pa]; nan without centrifugal force."""
        P = self.roll.running_pressure
        return float(P[0]) if P.size else nan

    @property
    def centrifugal_tension(self) -> Annotated[float, CENTRIFUGAL_TENSION]:
        """m V^2, by which the running web presses less [N/m]; nan without speed or density."""
        return self.roll.problem.centrifugal_tension or nan


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollResult(WithRoll, RollFields):
    """The stresses in a wound roll, over its radius.

    Attributes
    ----------
    problem : RollProblem
    radius : (M,) array
        Radii of the nodes, from the core to the surface [m].
    pressure : (M,) array
        P between the layers of the roll at rest [Pa]; ``running_pressure`` while it runs.
    hoop_stress : (M,) array
        sigma_t along the web, > 0 tension [Pa].
    displacement : (M,) array
        Outward displacement of a layer since it was wound [m].
    layer_strain : (M,) array
        eps_t of the layers along the web, 0 without stress [1].
    radial_modulus : (M,) array
        E_r(P), the radial modulus of the stack [Pa].
    source : (M,) array
        C = r^2 P'' + 3 r P' + P - E_t F(P) at rest, constant since the layer at r was wound [Pa].
    pressure_gradient : (M,) array
        r P' [Pa].
    stage_radius, growth : (J,) arrays
        Surface radii of the stages of the build-up [m], and kappa of these stages: the relative
        change with ln r, at the surface, of the pressure increment by a further layer [1].  With
        centrifugal force it is the number for which a further layer of the thickness h moves the
        surface inwards by (1 + kappa) h T/E_t.
    stage_order : (J,) int array
        Number of stages interpolated by the polynomial of kappa that ends at each stage.
    thin_layer_growth : (J,) array
        Kappa in the limit of thin layers, for the error by the layer thickness.
    surface_slope : float
        -r P'/T - 1 at the surface as wound, 0 except for the discretisation error [1]; of a running
        roll T is less the centrifugal stress.
    steps : int
        Number of linear systems solved.
    lane_count : int
        Number of lanes across the width; 0 without a thickness profile.
    lane_roll : LaneRoll, optional
        The lanes, if the problem has a thickness profile; recomputed for a loaded result.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollProblem.example())
    >>> bool(result.peak_pressure == result.pressure.max())
    True
    """

    MAIN: ClassVar[tuple[str, ...]] = ("core_pressure", "mid_pressure", "least_hoop_stress")
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "wound_on_tension": "it is an input: result.problem.wound_on_tension",
        }
    )
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset()
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(("growth", "stage_order", "thin_layer_growth"), "stage_radius")
    )
    ESTIMATES: ClassVar[frozenset[str]] = frozenset({"thin_layer_growth", "steps", "surface_slope"})

    def recompute_lanes(self) -> LaneRoll:
        """Solve for the lanes again, with the default tolerance of the solver."""
        count = self.lane_count or LANES
        lanes = solve_lanes(self, build_up_of(self), self.problem, count=count)
        of_layers = finite_layer_errors(self)["peak_pressure"]
        return lanes.with_layer_error(of_layers / self.peak_pressure)

    @property
    def roll(self) -> RollResult:
        """The result itself, as ``roll`` of a winding."""
        return self

    @property
    def is_changed(self) -> bool:
        """True if the finished roll differs from the roll as wound."""
        return self.problem.is_changed

    @cached_property
    def as_wound(self) -> Stage:
        """The roll as wound, before the changes of the finished roll."""
        return wound_stage(self)

    @property
    def opening(
        self,
    ) -> Annotated[Array, strain("eps_g", "gaps between the layers, per thickness of the layers")]:
        """Radial strain by gaps between open layers, C/E_t; zero where they are in contact [1]."""
        return opening(self)

    @property
    def compressed_share(
        self,
    ) -> Annotated[float, share("s_c", "fraction of the build-up with hoop compression")]:
        """Fraction of the radial build-up in which sigma_t < 0 [1]."""
        r = np.linspace(self.radius[0], self.radius[-1], SAMPLES)
        return float(np.mean(self.at_radius(r)["hoop_stress"] < 0))

    @property
    def running_pressure(
        self,
    ) -> Annotated[Array, stress("P_V", "pressure between the layers of the running roll")]:
        """P of the finished roll while it still runs [Pa]; length 0 without centrifugal force."""
        return self.as_wound.pressure if self.problem.centrifugal_stress else np.zeros(0)

    @property
    def running_hoop_stress(
        self,
    ) -> Annotated[Array, stress("sigma_V", "hoop (MD) stress of the running roll, > 0: tension")]:
        """sigma_t of the finished roll while it still runs [Pa]; length 0 as running_pressure."""
        if not self.problem.centrifugal_stress:
            return np.zeros(0)
        return self.as_wound.stresses_at(self.radius)[1]

    @property
    def finite_layer_change(
        self,
    ) -> Annotated[Array, stress("P_h", "pressure added by layers of finite thickness")]:
        """Part of P by the thickness of the layers, relative to the limit of thin layers [Pa]."""
        return finite_layer_stresses(self)[0]

    @property
    def finite_layer_effect(
        self,
    ) -> Annotated[float, share("e_h", "change of the pressure by layers of finite thickness")]:
        """``finite_layer_change`` of largest size over the peak pressure [1]."""
        change = self.finite_layer_change
        return float(change[np.argmax(np.abs(change))]) / self.peak_pressure

    @property
    def layer_count(self) -> Annotated[float, pure("n", "layers on the roll")]:
        """Build-up divided by the thickness of the web without pressure [1]."""
        return float(self.radius[-1] - self.radius[0]) / self.problem.unloaded_thickness

    @property
    def bending_strain(
        self,
    ) -> Annotated[Array, strain("eps_b", "bending strain at the faces of the layers")]:
        """h/2r, the strain at the faces of a straight web that is bent to the radius r [1]."""
        return np.asarray(self.problem.bending_strain(self.radius))

    @property
    def weight_pressure(
        self,
    ) -> Annotated[float, stress("p_W", "mean pressure on the core by the weight of the roll")]:
        """W/(2 r_c), the weight over the projected core [Pa]; nan without density or core."""
        weight = weight_of_layers(self, self.radius[:1])[0]
        return float("nan") if self.is_off_core else float(weight / (2 * self.radius[0]))

    @property
    def weight_share(
        self,
    ) -> Annotated[float, pure("s_W", "change of the pressure by the weight / pressure")]:
        """Largest change of the pressure by the weight, without friction, over the pressure [1].

        Above 1 the layers, or core and roll, separate below the core.  Nan as ``weight_pressure``.
        """
        return weight_share(self)

    @property
    def flat_width(
        self,
    ) -> Annotated[float, length("w_f", "flattened width of the roll on a floor (estimate)", "mm")]:
        """Width of the contact of the roll with a rigid floor [m], an estimate; nan as ``mass``."""
        return flat_width(self)

    @property
    def residual_tension(
        self,
    ) -> Annotated[Array, line_load("T_r", "residual tension in the layers")]:
        """Web thickness times sigma_t, > 0 tension [N/m]."""
        return np.asarray(self.hoop_stress * self.problem.web_thickness)

    @property
    def density(
        self,
    ) -> Annotated[Array, Quantity("rho_r", "kg/m^3", "density of the wound layers")]:
        """Density of the finished roll at the nodes [kg/m^3]; nan as ``mass``."""
        return np.asarray(finished_density(self))

    @property
    def density_as_wound(
        self,
    ) -> Annotated[
        Array,
        Quantity(
            "rho_w", "kg/m^3", "density as wound: mass of the web per increase of the roll volume"
        ),
    ]:
        """Density by a density analyser on the winder, at the nodes [kg/m^3]; nan as ``mass``."""
        return np.asarray(density_during_winding(self, self.radius))

    @property
    def wound_mass(
        self,
    ) -> Annotated[float, Quantity("m_w", "kg/m", "mass of the web with compressed layers")]:
        """Mass of ``wound_length`` of the web [kg/m]; nan as ``mass``."""
        return wound_mass(self)

    @property
    def mean_density(
        self,
    ) -> Annotated[float, Quantity("rho_m", "kg/m^3", "mean density of the wound layers")]:
        """Wound mass divided by the volume of the roll [kg/m^3]; nan as ``mass``."""
        return self.wound_mass / float(volume(self))

    def at_radius(self, radius: ArrayLike, *, running: bool = False) -> dict[str, Any]:
        """Return pressure and hoop stress at any radii.

        Parameters
        ----------
        radius : array_like
            [m], from the core to the surface.
        running : bool
            True for the finished roll while it still runs, before the changes after winding.

        Returns
        -------
        dict
            ``pressure`` and ``hoop_stress`` [Pa].

        Raises
        ------
        InvalidProblem
            For a radius outside the roll.
        """
        check_type("running", running, bool)
        return stresses_between(self, radius, self.as_wound if running else None)

    def at(self, radius: float) -> RollResult:
        """Return the stage of the build-up with a given surface radius.

        Parameters
        ----------
        radius : float
            Surface radius [m], at least ten layers on the core, at most that of the finished roll.

        Raises
        ------
        InvalidProblem
            For a radius outside the roll.
        """
        arrays = stage_arrays(self, radius)
        stage = RollResult(**arrays, residuals=Residuals())
        # a stage has fewer layers than the finished roll, so that their thickness matters more
        finished, at_stage = finite_layer_errors(self), finite_layer_errors(stage)
        errors = {
            name: self.errors[name] - error + at_stage[name]
            for name, error in finished.items()
            if name in self.errors
        }
        residuals, warnings = certificate(stage), roll_warnings(stage)
        return stage.replace(residuals=residuals, errors=errors, warnings=warnings).checked()

    def certified(self) -> Residuals:
        """Recompute the residuals from problem and arrays."""
        self.check_lane_count()
        return certificate(self)

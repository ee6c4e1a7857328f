r"""Slip between the layers of the roll below a nip: an index from the stresses of a bonded roll.

The nip model treats the roll as a bonded, homogenised body: friction limits the shear between web
and roll, but not between the layers below.  On the interface at depth z, between two layers, the
stresses sigma_r and tau under the solved tractions (:mod:`woundon.elasticity.interior_stress`) and
the pressure P0 that is wound into the roll could be carried by friction where

    |tau| <= mu (P0 + p),     p = -sigma_r,     mu the friction between the layers.

With entrained air, mu is that of the film between the layers under the pressure P0 + p
(:meth:`woundon.nip.result.NipResult.layer_friction`): no air escapes while they pass the nip.

P0(z) = T z/R close to the surface: every layer, wound on with a tension that exceeds its
centrifugal force by T h, presses those below it with T h/R.  It is limited by the plateau of the
stack, P of

    T^2/(2 E_t) = int_0^P P' dP'/E_r(P')

(:meth:`woundon.Stack.plateau_pressure`), with the air between the layers, and by the pressure of a
:class:`~woundon.WoundRoll` at that depth.

Two measures: the largest ratio, over the interfaces, of max_x |tau| and mu (P0 + max_x p); and the
number of layers in which |tau| exceeds mu (P0 + p) at some x.  Layers may slip at a ratio below 1,
where the pressure is low.  A ratio at each point would grow without bound outside the contact,
where both vanish at the surface.

The index uses the stresses of layers that do not slide.  It tells whether these stresses are
possible, not how far the layers slide, nor by how much the wound-on tension would change.
docs/theory/layer_slip.md
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, inf, isinf
from typing import Annotated, ClassVar

import numpy as np

from ..elasticity.interior_stress import Section
from ..errors import InvalidProblem
from ..problems.air import stack_with_film
from ..problems.radial_laws import SolidLaw
from ..problems.stack import Stack
from ..problems.wound_roll import WoundRoll
from ..quantities import length, pure
from ..results import ReadOnly
from ..validity import LENGTH
from .nip_fields import NipFields

__all__ = ["LayerSlip", "friction_limit", "interior_stress", "layer_slip", "wound_in_pressure"]

Array = np.ndarray

# All interfaces down to this layer are evaluated, then as many layers are skipped as this share of
# those above: the curves are smooth functions of ln z, and the index changes by less than 0.1 %.
FIRST_LAYERS, SKIPPED_SHARE = 12, 0.08
# Evaluated together; the search ends after a block without slip below SEARCH_DEPTH nip half widths.
# There the shear falls with the depth, and the pressure between the layers does not.
BLOCK, SEARCH_DEPTH = 24, 4.0
# Share of the radius down to which the layers of a half-plane are counted: it has no core.
HALF_PLANE = 0.5
# Share of the wrap on which its pressure and traction are reduced to zero.  A wrap ends abruptly at
# a load cell, but not in a roll, where that end would add shear to the outermost layers.
TAPERED_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class LayerSlip(ReadOnly):
    """Index of slip between the layers of the roll below a nip.

    Attributes
    ----------
    ratio : float
        Largest ratio of max_x abs(tau) and mu (P0 + max_x p) over the interfaces [1]; inf if air
        leaves no friction.  Above 1 the layers slip where the shear is largest, below 1 only where
        the pressure is low.
    layers : int
        Number of layers in which abs(tau) exceeds mu (P0 + p) somewhere; > 0 if the ratio is > 1.
    depth : float
        Depth of the deepest slipping layer [m], 0 if there is none.
    width : float
        Extent in x over which any layer slips [m].
    layer : (k,) int array
        Interfaces that were evaluated: the layers above them, counted from the surface.
    interface_depth : (k,) array
        Their depth z [m].
    largest_shear, largest_pressure : (k,) arrays
        max_x abs(tau) and max_x p of the nip [Pa].
    wound_in_pressure : (k,) array
        P0 [Pa].
    excess : (k,) array
        max_x (abs(tau) - mu (P0 + p)) [Pa], > 0 where layers slip.
    friction : (k,) array
        mu under P0 + max_x p, reduced by the air between the layers [1].
    """

    part_of_result: ClassVar[bool] = True

    ratio: Annotated[
        float, pure("S_tau", "largest interlayer shear / friction at largest pressure")
    ]
    layers: Annotated[int, pure("n_slip", "layers whose shear exceeds friction somewhere")]
    depth: Annotated[float, length("z_slip", "depth of the deepest slipping layer")]
    width: Annotated[float, length("w_slip", "extent along the nip over which layers would slip")]
    layer: Array = field(repr=False)
    interface_depth: Array = field(repr=False)
    largest_shear: Array = field(repr=False)
    largest_pressure: Array = field(repr=False)
    wound_in_pressure: Array = field(repr=False)
    excess: Array = field(repr=False)
    friction: Array = field(repr=False)

    @property
    def friction_limit(self) -> Array:
        """mu (P0 + max_x p) of the interfaces, (k,) [Pa]."""
        return self.friction * (self.wound_in_pressure + self.largest_pressure)

    @property
    def critical(self) -> int:
        """Index of the interface with the largest ratio."""
        return int(np.argmax(_ratios(self.largest_shear, self.friction_limit)))

    @property
    def warning(self) -> str:
        """Text of the warning if layers would slip; empty otherwise."""
        if self.layers == 0:
            return ""
        extent = f"down to {LENGTH.stored_text(self.depth, '.3g')} ({self.layers} layers)"
        if isinf(self.ratio):
            text = (
                "the air between the layers of the roll leaves no friction at some depth, and the "
                f"shear is more than friction can carry {extent}"
            )
        elif self.ratio > 1:
            text = (
                f"the shear between the layers of the roll is up to {self.ratio:.3g} times what "
                f"friction can carry, {extent}"
            )
        else:
            text = (
                "the shear between the layers of the roll is more than friction can carry, "
                f"{extent}, where the pressure is low; under the largest pressure of each layer "
                f"it is up to {self.ratio:.3g} times what friction can carry"
            )
        return f"{text}: the tension holds only if the layers below the web do not slide"


def layer_slip(result: NipFields) -> LayerSlip | None:
    """Return the index of slip between the layers of the roll.

    Parameters
    ----------
    result : NipResult

    Returns
    -------
    LayerSlip or None
        None for a rigid or viscoelastic roll, for other bodies without interior stresses, and for
        a roll thinner than two layers.

    Notes
    -----
    The number of layers is interpolated between the interfaces that are evaluated.

    Examples
    --------
    >>> import woundon as wo
    >>> slip = wo.solve(wo.NipProblem.example()).layer_slip
    >>> print(f"ratio {slip.ratio:.2f}, {slip.layers} layers")
    ratio 2.39, 69 layers
    """
    h = result.problem.web.thickness
    maxima, extents, layer = [], [], np.zeros(0, dtype=int)
    for block in _blocks(result):
        sections = interior_stress(result, block * h)
        if sections is None:
            return None
        for section, P0 in zip(sections, wound_in_pressure(result, block * h), strict=True):
            excess = np.abs(section.shear) - friction_limit(result, P0 - section.normal)
            maxima.append((np.abs(section.shear).max(), -section.normal.min(), P0, excess.max()))
            if excess.max() > 0:
                extents.append(_slipping_extent(section.x, excess))
        layer = np.append(layer, block)
        if layer[-1] * h > SEARCH_DEPTH * result.half_width and maxima[-1][-1] <= 0:
            break
    if not maxima:
        return None
    shear, pressure, wound_pressure, excess = np.array(maxima).T
    all_layers = np.arange(1, layer[-1] + 1)
    slipping = all_layers[np.interp(all_layers, layer, excess) > 0]
    width = max(end for _, end in extents) - min(start for start, _ in extents) if extents else 0.0
    friction = np.asarray(result.layer_friction(wound_pressure + pressure))
    return LayerSlip(
        ratio=float(_ratios(shear, friction * (wound_pressure + pressure)).max()),
        layers=int(slipping.size),
        depth=float(h * slipping.max(initial=0)),
        width=float(width),
        layer=layer,
        interface_depth=layer * h,
        largest_shear=shear,
        largest_pressure=pressure,
        wound_in_pressure=wound_pressure,
        excess=excess,
        friction=friction,
    )


def _ratios(shear: Array, limit: Array) -> Array:
    """Return the ratios of shear and friction limit; inf where there is no friction."""
    return np.divide(shear, limit, out=np.full(shear.shape, inf), where=limit > 0)


def friction_limit(result: NipFields, pressure: Array) -> Array:
    """Return mu P, the shear that friction between the layers carries under a pressure P [Pa].

    Parameters
    ----------
    result : NipResult
    pressure : array
        P = P0 + p [Pa]; < 0 where the stresses of the nip pull bonded layers apart.
    """
    limit: Array = result.layer_friction(np.maximum(pressure, 0.0)) * pressure
    return limit


def interior_stress(result: NipFields, depths: Array) -> tuple[Section, ...] | None:
    """Return the stresses that the nip adds in the roll.

    Parameters
    ----------
    result : NipResult
    depths : (m,) array
        z [m], > 0.

    Returns
    -------
    tuple of Section or None
        One for each depth; None if the body of the roll does not provide them.

    Notes
    -----
    The tractions of a wrap are reduced to zero over the last tenth of it.
    """
    nodes, a = slice(result.in_nip.start, None), result.half_width
    x, q = result.x[nodes], result.roll_traction[nodes]
    p = result.roll_pressure[nodes]
    if x[-1] > a:
        tapered = np.clip((x[-1] - x) / (TAPERED_SHARE * (x[-1] - a)), 0.0, 1.0)
        p, q = p * tapered, q * tapered
    return result.problem.roll.interior_stress(x, p, q, np.asarray(depths), a)


def wound_in_pressure(result: NipFields, depths: Array) -> Array:
    """Return P0 at depths z [m] below the surface of the roll, (m,) [Pa].

    P0 is the sum T z/R over the layers above, at most the plateau pressure of the stack.  The depth
    is that without air: each layer adds T h/R, whatever its distance from the next one.
    """
    problem, z = result.problem, np.asarray(depths, dtype=float)
    hoop_tension = float(result.tension[-1]) - problem.centrifugal_tension
    roll, T = problem.roll, max(hoop_tension, 0.0) / problem.web.thickness
    P0 = T * z / roll.radius
    if isinstance(roll, WoundRoll):
        P0 = np.minimum(P0, roll.wound_pressure(roll.radius - z))
    stack = roll.stack if isinstance(roll, WoundRoll) else problem.web.material
    if not isinstance(stack, Stack):
        return P0
    # other laws are measured with the air between the layers; the tension of a stack with a film
    # is per thickness of web and film
    film, air = result.air, problem.air
    if film is not None and air is not None and isinstance(stack.radial, SolidLaw):
        h = problem.web.thickness
        stack = stack_with_film(stack, film.film, h, air)
        T *= h / (h + film.film)
    try:
        return np.minimum(P0, stack.plateau_pressure(T))
    except InvalidProblem:  # the law ends below the plateau
        return np.minimum(P0, stack.radial.max_pressure)


def _blocks(result: NipFields) -> list[Array]:
    """Return the numbers of the interfaces to be evaluated, from the surface, in blocks.

    The spacing grows with the depth: max(1, SKIPPED_SHARE n) below interface n.
    """
    roll, h = result.problem.roll, result.problem.web.thickness
    deepest = HALF_PLANE * roll.radius if isinf(roll.thickness) else roll.thickness
    last = ceil(deepest / h) - 1
    layers = [*range(1, min(FIRST_LAYERS, last) + 1)]
    while layers and layers[-1] < last:
        layers.append(min(last, layers[-1] + max(1, round(SKIPPED_SHARE * layers[-1]))))
    return [np.array(layers[k : k + BLOCK]) for k in range(0, len(layers), BLOCK)]


def _slipping_extent(x: Array, excess: Array) -> tuple[float, float]:
    """Return the extent in x over which a layer slips: first and last zero of the excess [m].

    ``x`` are positions [m], and ``excess`` is abs(tau) - mu P there [Pa], (n,).  The excess is
    positive at some node.  Zeros are interpolated linearly; if the layer slips up to an end of x,
    beyond which no excess is known, that end is returned.
    """
    slipping = np.nonzero(excess > 0)[0]
    first, last = int(slipping[0]), int(slipping[-1])
    zeros = []
    for node, outer in ((first, first - 1), (last, last + 1)):
        if not 0 <= outer < x.size:
            zeros.append(float(x[node]))
            continue
        t = excess[node] / (excess[node] - excess[outer])
        zeros.append(float(x[node] + t * (x[outer] - x[node])))
    return zeros[0], zeros[1]

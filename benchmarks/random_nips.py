"""Random admissible problems, one a seed, over the range that the program is made for.

``random_nip``: log-uniform A_rr 2e6 to 2e8, A_tt 3e8 to 1e10, G 1e6 to 2e8 Pa; P 100 to 20 000 N/m;
mu+ and mu- 0.05 to 0.8, either the larger; web thickness 10 to 200 um; radii 0.06 to 1 m; covers of
5 to 40 mm; drums' E 5e5 to 3e9 Pa; web tension 50 to 1000 N/m.  Uniform: A_rt 0 to
0.6 min(A_rr, 40 MPa), F within +-0.95 mu- P, nu 0 to 0.495, the roll's core 0.1 to 0.9 of its
radius.  A third of the drums is rigid, a third half-planes, a third covers on a rigid core; half of
the rolls are half-planes.

All others start from these nips:

wrapped       1 rad to half a turn on the roll; half of them 0.2 to 3 rad on the drum, at 300 N/m or
              more
covers        wrapped, the drum with a cover of 5 to 40 mm, E 5e5 to 1e8 Pa, nu 0.3 to 0.499
rollers       roll and drum without a web: a third driven, a third with a creepage of up to that of
              full slip, a sixth each free and static
layered       drums of one to six layers of 1 um to 30 mm, E 5e5 to 2e11 Pa, on a rigid core or an
              open bore; rolls graded by a wound pressure of 10 kPa to 2 MPa, or paper on a shell
viscoelastic  one to eight Prony terms of 0.02 to 3 times E_inf and 1e-7 to 10 s, in a third of the
              cases a loss angle; 1 mm/s to 100 m/s; half-planes, covers of 0.5 to 40 mm, layers; a
              third each of plain nips, wrapped nips and rollers
air           1 cm/s to 100 m/s, roughness 0.05 um to a third of the thickness, a third of the webs
              permeable, 1e-10 to 1e-5 m/Pa/s; half of the drums wrapped
low_friction  friction 1e-6 to 1e-2 on one face or on both, half of the nips wrapped
hardening     rolls of a stack with any radial law, a few to fifty MPa at the wound pressure
two_nips      wrapped, a further nip 0.3 to 2.5 rad downstream: a drum of any kind, 1e-3 to 2 times
              the load, F within +-0.8 mu- P; every twentieth roll is a hardening one
three_nips    the same with one more nip
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import pi
from typing import Any

import numpy as np

import woundon as wo
from woundon.problems.bodies import half_width_guess

__all__ = [
    "FAMILIES", "flat_fields", "random_air", "random_covered", "random_hardening",
    "random_layered", "random_low_friction", "random_neighbours", "random_nip", "random_rollers",
    "random_viscoelastic", "random_wrapped_neighbours", "random_wrapped_nip",
]  # fmt: skip


class _Draw:
    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)

    def log(self, low: float, high: float) -> float:
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def even(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))


def random_nip(seed: int) -> wo.NipProblem:
    """Return the nip that belongs to a seed; always the same one."""
    draw = _Draw(seed)
    A_rr, A_tt, G = draw.log(2e6, 2e8), draw.log(3e8, 1e10), draw.log(1e6, 2e8)
    A_rt = draw.even(0.0, 0.6) * min(A_rr, 4e7)
    paper = wo.Orthotropic(radial=A_rr, tangential=A_tt, cross=A_rt, shear=G)
    P, mu_roll, mu_drum = draw.log(100.0, 20e3), draw.log(0.05, 0.8), draw.log(0.05, 0.8)
    F = draw.even(-0.95, 0.95) * mu_drum * P
    web = wo.Web(thickness=draw.log(10e-6, 200e-6), material=paper)
    R1, R2 = draw.log(0.06, 1.0), draw.log(0.06, 1.0)
    drum = _drum(draw, R2)
    core = draw.even(0.1, 0.9) * R1
    half_plane = draw.random.random() < 0.5
    roll: wo.HalfPlane | wo.Cylinder = wo.HalfPlane(radius=R1, material=paper)
    if not half_plane:
        roll = wo.Cylinder(radius=R1, core_radius=core, material=paper)
    return wo.NipProblem(
        web=web, roll=roll, drum=drum, roll_friction=mu_roll, drum_friction=mu_drum,
        nip_load=P, winding_force=F, web_tension=draw.log(50.0, 1000.0), roll_wrap=0.0,
    )  # fmt: skip


def _drum(draw: _Draw, radius: float) -> wo.Rigid | wo.HalfPlane | wo.Cylinder:
    """Return one of three kinds of drum; all draw the same numbers."""
    kind = draw.random.integers(3)
    thickness = draw.log(5e-3, 40e-3)
    cover = wo.Isotropic(youngs_modulus=draw.log(5e5, 3e9), poissons_ratio=draw.even(0.0, 0.495))
    if kind == 0:
        return wo.Rigid(radius=radius)
    if kind == 1:
        return wo.HalfPlane(radius=radius, material=cover)
    return wo.Cylinder(radius=radius, core_radius=radius - thickness, material=cover)


def random_neighbours(seed: int) -> list[wo.NipProblem]:
    """Return a seed's nip and three more, load and friction each 1 to 5 % from those before."""
    return _neighbours(seed, random_nip(seed))


def random_wrapped_neighbours(seed: int) -> list[wo.NipProblem]:
    """Return a seed's wrapped nip and three more, alike."""
    return _neighbours(seed, random_wrapped_nip(seed))


def _neighbours(seed: int, first: Any) -> list[Any]:
    draw, nips = _Draw(3_000_000 + seed), [first]
    load, friction = (1 + draw.even(0.01, 0.05) * draw.random.choice([-1, 1]) for _ in range(2))
    for k in (1, 2, 3):
        at = load**k
        nips.append(
            nips[0].replace(
                nip_load=at * nips[0].nip_load, winding_force=at * nips[0].winding_force,
                roll_friction=friction**k * nips[0].roll_friction,
            )
        )  # fmt: skip
    return nips


def random_wrapped_nip(seed: int) -> wo.NipProblem:
    """Return the nip of a seed with its wraps."""
    draw, nip = _Draw(4_000_000 + seed), random_nip(seed)
    roll_wrap, drum_wrap = draw.even(1.0, pi), draw.even(0.2, 3.0) * (seed % 2)
    if not drum_wrap:
        return nip.replace(roll_wrap=roll_wrap)
    taut = nip.replace(web_tension=max(nip.web_tension, 300.0))
    return taut.replace(roll_wrap=roll_wrap, drum_wrap=drum_wrap)


def random_rollers(seed: int) -> wo.RollerProblem:
    """Return the roll and the drum of a seed's nip as two rollers."""
    draw, nip = _Draw(5_000_000 + seed), random_nip(seed)
    friction, P = nip.roll_friction, nip.nip_load
    pull = draw.even(-0.95, 0.95) * friction * P
    creepage = draw.even(-1.5, 1.5) * friction * half_width_guess(P, *nip.bodies)
    creepage /= nip.contact_radius
    which = int(draw.random.integers(6))
    drives: list[dict[str, Any]] = [
        {"tangential_load": pull}, {"creepage": creepage}, {},
        {"motion": "static", "tangential_load": pull},
    ]  # fmt: skip
    drive = drives[(0, 0, 1, 1, 2, 3)[which]]
    return wo.RollerProblem(upper=nip.roll, lower=nip.drum, load=P, friction=friction, **drive)


def random_covered(seed: int) -> wo.NipProblem:
    """Return the wrapped nip of a seed with a soft cover on its drum."""
    draw, nip = _Draw(6_000_000 + seed), random_wrapped_nip(seed)
    R, thickness = nip.drum.radius, draw.log(5e-3, 40e-3)
    cover = wo.Isotropic(youngs_modulus=draw.log(5e5, 1e8), poissons_ratio=draw.even(0.3, 0.499))
    return nip.replace(drum=wo.Cylinder(radius=R, core_radius=R - thickness, material=cover))


def random_low_friction(seed: int) -> Any:
    """Return the nip of a seed, plain or wrapped, with little friction on one face or on both."""
    draw, nip = _Draw(7_000_000 + seed), random_nip(seed)
    mu, faces = draw.log(1e-6, 1e-2), ("roll", "drum", "both")[seed % 3]
    fields = {"winding_force": nip.winding_force}
    if faces != "drum":
        fields["roll_friction"] = mu
    if faces != "roll":
        fields["drum_friction"] = mu * draw.log(0.5, 2.0)
        fields["winding_force"] *= fields["drum_friction"] / nip.drum_friction
    nip = nip.replace(**fields)
    return nip.replace(roll_wrap=draw.even(1.0, pi)) if draw.random.random() < 0.5 else nip


def random_layered(seed: int) -> wo.NipProblem:
    """Return the nip of a seed with a layered drum and a graded or layered roll.

    Raises
    ------
    InvalidProblem
        If the problem is not admissible, as with layers thicker than the radius.
    """
    draw, plain = _Draw(1_000_000 + seed), random_nip(seed)
    layers = [
        wo.Layer(
            thickness=draw.log(1e-6, 30e-3),
            material=wo.Isotropic(
                youngs_modulus=draw.log(5e5, 2e11), poissons_ratio=draw.even(0.0, 0.495)
            ),
        )
        for _ in range(int(draw.random.integers(1, 7)))
    ]
    core = ("rigid", "free")[int(draw.random.integers(2))]
    drum = wo.Layered(radius=plain.drum.radius, layers=layers, core=core)
    return plain.replace(drum=drum, roll=_graded_roll(draw, plain))


def _graded_roll(draw: _Draw, plain: wo.NipProblem) -> wo.Body:
    R, paper = plain.roll.radius, plain.web.material
    core = draw.even(0.1, 0.9) * R
    if draw.random.random() < 0.5:
        shell = wo.Layer(thickness=draw.even(0.05, 0.3) * core, material="steel")
        layers = (wo.Layer(thickness=R - core, material=paper), shell)
        return wo.Layered(radius=R, layers=layers, core="free")
    law = wo.Pfeiffer(K1=draw.log(1e3, 1e6), K2=draw.log(5.0, 500.0))
    stack = wo.Stack(
        radial=law, tangential=paper.tangential, poissons_ratio=draw.even(0.0, 0.3),
        shear=paper.shear,
    )  # fmt: skip
    radii = np.sort(draw.random.uniform(core, R, 4))
    pressure = wo.Profile(radius=radii, value=[draw.log(10e3, 2e6) for _ in radii])
    return wo.WoundRoll(
        radius=R, core_radius=core, stack=stack, pressure=pressure, hardening="frozen"
    )


def random_viscoelastic(seed: int) -> Any:
    """Return the nip, wrapped nip or rollers of a seed with a viscoelastic drum.

    Raises
    ------
    InvalidProblem
        If the problem is not admissible.
    """
    draw, plain = _Draw(2_000_000 + seed), random_nip(seed)
    speed, drum = draw.log(1e-3, 100.0), _viscoelastic_drum(draw, plain.drum.radius)
    roll = plain.roll
    if draw.random.random() < 0.2:
        core = draw.even(0.1, 0.8) * roll.radius
        roll = wo.Cylinder(radius=roll.radius, core_radius=core, material=_rubber(draw, 1e7, 1e9))
    if seed % 3 == 2:
        friction = 0.0 if draw.random.random() < 0.3 else draw.even(0.05, 0.8)
        pull = draw.even(-0.8, 0.8) * friction * plain.nip_load
        return wo.RollerProblem(
            upper=roll, lower=drum, load=plain.nip_load, friction=friction, speed=speed,
            tangential_load=pull if friction else None,
        )  # fmt: skip
    nip = plain.replace(roll=roll, drum=drum, web_speed=speed)
    if seed % 3 == 0:
        return nip
    return nip.replace(roll_wrap=pi, drum_wrap=draw.even(0.0, 2.0) * (seed % 2))


def _rubber(draw: _Draw, low: float, high: float) -> wo.Material:
    E, nu = draw.log(low, high), draw.even(0.0, 0.499)
    if draw.random.random() < 1 / 3:
        return wo.LossAngle(
            youngs_modulus=E, poissons_ratio=nu, loss_angle=draw.log(1e-3, 1.2),
            frequency=draw.log(0.1, 1e5),
        )  # fmt: skip
    terms = range(int(draw.random.integers(1, 9)))
    prony = [(E * draw.log(0.02, 3.0), draw.log(1e-7, 10.0)) for _ in terms]
    return wo.Isotropic(youngs_modulus=E, poissons_ratio=nu, prony=prony)


def _viscoelastic_drum(draw: _Draw, radius: float) -> wo.Body:
    material, which = _rubber(draw, 1e6, 1e9), draw.random.random()
    if which < 0.25:
        return wo.HalfPlane(radius=radius, material=material)
    if which < 0.6:
        cover = draw.log(0.5e-3, 40e-3)
        return wo.Cylinder(radius=radius, core_radius=radius - cover, material=material)
    hard = wo.Isotropic(youngs_modulus=draw.log(1e7, 2e11), poissons_ratio=0.3)
    layers = [
        wo.Layer(thickness=draw.log(0.3e-3, 20e-3), material=m) for m in (material, hard, material)
    ]
    return wo.Layered(radius=radius, layers=layers[int(draw.random.integers(2)) :])


def random_air(seed: int) -> wo.NipProblem:
    """Return the nip of a seed with entrained air, a third of them on viscoelastic drums.

    Raises
    ------
    InvalidProblem
        If the problem is not admissible.
    """
    draw, plain = _Draw(3_000_000 + seed), random_nip(seed)
    drum = _viscoelastic_drum(draw, plain.drum.radius) if seed % 3 == 2 else plain.drum
    air = wo.Air(
        roughness=draw.log(0.05e-6, plain.web.thickness / 3),
        permeance=draw.log(1e-10, 1e-5) if draw.random.random() < 1 / 3 else 0.0,
    )
    fields = {name: getattr(plain, name) for name in wo.NipProblem.model_fields}
    wrap = draw.even(0.0, 2.0) * (seed % 2)
    speed = draw.log(1e-2, 100.0)
    fields |= {
        "drum": drum, "roll_wrap": pi, "drum_wrap": wrap, "web_speed": speed, "air": air
    }  # fmt: skip
    return wo.NipProblem(**fields)


def random_hardening(seed: int) -> Any:
    """Return the nip of a seed with a hardening roll, plain or wrapped.

    The web has the stiffness of the stack at the wound pressure.
    """
    rng = np.random.default_rng(seed)
    P0 = 10 ** rng.uniform(3.5, 5.7)
    stack = _stack(rng, P0)
    rr, tt, rt, shear = stack.tangent(P0)[:4]
    R = rng.uniform(0.1, 0.6)
    mu, load = rng.uniform(0.1, 0.5), 10 ** rng.uniform(1.5, 3.9)
    web = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    plain = wo.NipProblem(
        web=wo.Web(thickness=rng.uniform(20e-6, 150e-6), material=web),
        roll=wo.WoundRoll(
            radius=R, core_radius=R * rng.uniform(0.1, 0.7), stack=stack, pressure=P0
        ),
        drum=wo.Rigid(radius=rng.uniform(0.05, 0.6)), roll_friction=rng.uniform(0.1, 0.5),
        drum_friction=mu, nip_load=load, winding_force=rng.uniform(-0.6, 0.6) * mu * load,
        web_tension=10 ** rng.uniform(2, 3), roll_wrap=0.0,
    )  # fmt: skip
    return plain.replace(roll_wrap=rng.uniform(0.3, pi)) if rng.random() < 0.4 else plain


def _stack(rng: np.random.Generator, P0: float) -> wo.Stack:
    """Return a stack of any law whose modulus at P0 is a few to fifty MPa."""
    E = 10 ** rng.uniform(6.3, 7.7)
    share = rng.uniform(0.05, 1.0)  # K1/(K1 + P0)
    Q = max(P0, 1e3) / (1 - min(share, 0.95))
    kind = rng.choice(["pfeiffer", "pfeiffer", "power", "polynomial", "test"])
    radial: Any
    if kind == "pfeiffer":
        radial = wo.Pfeiffer(K1=Q * share, K2=E / Q)
    elif kind == "power":
        radial = wo.PowerLaw(E0=0.2 * E, k=0.8 * E / (Q / 1e5) ** 0.7, m=0.7)
    elif kind == "polynomial":
        radial = wo.Polynomial(coefficients=(0.2 * E, 0.8 * E / Q, -0.1 * E / Q / 1e7))
    else:
        P = np.geomspace(0.02 * Q, 40 * Q, 12)
        radial = wo.StackTest(pressure=P, strain=np.log1p(P / Q / share) / (E / Q))
    return wo.Stack(
        radial=radial, tangential=10 ** rng.uniform(9, 9.8), poissons_ratio=rng.uniform(0, 0.2),
        shear=E * 10 ** rng.uniform(-0.7, 0.3),
        shear_exponent=float(rng.choice([0.0, 0.0, 0.5, 1.0])),
    )  # fmt: skip


def random_two_nips(seed: int) -> wo.NipProblem:
    """Return the wrapped nip of a seed with a further one."""
    return _with_further_nips(seed, 1)


def random_three_nips(seed: int) -> wo.NipProblem:
    """Return the wrapped nip of a seed with two further ones."""
    return _with_further_nips(seed, 2)


def _with_further_nips(seed: int, count: int) -> wo.NipProblem:
    draw = _Draw(8_000_000 + seed)
    nip = random_hardening(seed) if seed % 20 == 19 else random_wrapped_nip(seed)
    further = []
    for _ in range(count):
        radius, friction = draw.log(0.06, 1.0), draw.log(0.05, 0.8)
        load = nip.nip_load * draw.log(1e-3, 2.0)
        force = draw.even(-0.8, 0.8) * friction * load
        further.append(
            wo.NextNip(
                angle=draw.even(0.3, 2.5), drum=_drum(draw, radius), nip_load=load,
                winding_force=force, drum_friction=friction,
            )
        )  # fmt: skip
    arcs = sum(one.angle for one in further)
    return nip.replace(next_nips=further, roll_wrap=min(arcs + draw.even(0.8, 2.0), 2 * pi))


FAMILIES: dict[str, Callable[[int], Any]] = {
    "plain": random_nip, "wrapped": random_wrapped_nip, "covers": random_covered,
    "rollers": random_rollers, "layered": random_layered, "viscoelastic": random_viscoelastic,
    "air": random_air, "low_friction": random_low_friction, "hardening": random_hardening,
    "two_nips": random_two_nips, "three_nips": random_three_nips,
}  # fmt: skip


def flat_fields(record: dict[str, object], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield (dotted name, value) of a problem's ``model_dump``."""
    for name, value in record.items():
        if isinstance(value, dict):
            yield from flat_fields(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value

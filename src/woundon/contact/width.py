"""The outermost loop: the half width at which the pressure carries the load."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, log
from typing import TypeVar

__all__ = ["WidthNotFound", "width_for_load"]

T = TypeVar("T")

PATIENCE = 10  # evaluations, after which a step stays between loads too small and too large
USUAL, LEAST = 0.7, 0.05  # powers: a tube that the load flattens carries hardly more as it widens


class WidthNotFound(ArithmeticError):
    """The secant iteration did not settle."""


def width_for_load(
    evaluate: Callable[[float], tuple[T, float]],
    load: float,
    guess: float,
    rtol: float,
    power: float = 2.0,
    widest: float = inf,
    beyond: Callable[[], str] = str,
) -> tuple[T, float]:
    """Find the half width a whose contact carries ``load``, by a secant on ln P against ln a.

    The load grows with the width like a power between 2 (half-planes) and 5 (a thin incompressible
    layer), so the iteration works on logarithms, where it is nearly linear.

    Parameters
    ----------
    evaluate : callable
        a [m] -> (state, load it carries [N/m]).
    load : float
        [N/m].
    guess : float
        First a [m].
    rtol : float
        Accepted relative difference of the loads.
    power : float
        First guess of d ln P/d ln a.
    widest : float
        Largest half width that makes sense [m].
    beyond : callable
        () -> what is wrong with a wider contact, and what to change.

    Returns
    -------
    state, power
        The state of the last evaluation, and the power that was found: a start for a finer grid.

    Raises
    ------
    WidthNotFound
        After 60 evaluations, or where the widest contact does not carry the load.
    """
    ln_a = log(guess)
    last: tuple[float, float] | None = None
    under, over = -inf, inf  # ln a of the last loads too small and too large
    for k in range(60):
        state, carried = evaluate(exp(ln_a))
        miss = log(carried / load) if carried > 0 else -2.0
        # a shorter step tells rounding, not the power
        if last is not None and abs(ln_a - last[0]) > 1e-9:
            least = USUAL if k < PATIENCE else LEAST
            power = min(max((miss - last[1]) / (ln_a - last[0]), least), 12.0)
        if abs(miss) <= rtol:
            return state, power
        if ln_a >= log(widest) and miss < 0:
            raise WidthNotFound(
                f"no contact carries {load:.4g} N/m: the widest, {widest:.3g} m to either side, "
                f"{max(carried, 0.0):.3g} N/m; {beyond()}"
            )
        last = (ln_a, miss)
        under, over = (ln_a, over) if miss < 0 else (under, ln_a)
        ln_a = min(ln_a - min(max(miss / power, -1.5), 1.5), log(widest))
        # a load that rises faster than any power would be missed to either side for ever
        if k >= PATIENCE and abs(over - under) < inf and not under < ln_a < over:
            ln_a = (under + over) / 2
    raise WidthNotFound(f"the half width did not settle: last {exp(ln_a):.6g} m, off by {miss:.2g}")

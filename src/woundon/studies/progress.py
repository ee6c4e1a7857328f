"""Report progress to a bar on the error channel, to a callable, or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Progress", "reported"]

Progress = Callable[[int, int], None]  # called with (done, expected)


@contextmanager
def reported(
    progress: bool | Progress, label: str, *, unit: str = "", done: int = 0
) -> Iterator[Progress]:
    """Provide a function that reports the numbers of finished and of all cases.

    Parameters
    ----------
    progress : bool or callable
        True shows a bar; a callable is called in its place.
    label : str
        What is being done, for the bar.
    unit : str, optional
        Of the rate that the bar shows: ".../s" or ".../min"; without it the bar shows a percentage.
    done : int
        What was done before, for the rate.

    Examples
    --------
    >>> with reported(lambda done, expected: print(f"{done} of {expected}"), "solving") as report:
    ...     report(1, 2)
    1 of 2
    """
    if progress is True:
        from .bars import bar

        with bar(label, unit, done) as report:
            yield report
    else:
        yield progress or (lambda done, expected: None)

"""Report progress to a bar on the error channel, to a callable, or not at all."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from ..arguments import check_arguments

__all__ = ["Progress", "progress_reporter"]

Progress = Callable[[int, int], None]  # called with (done, expected)


def progress_reporter(
    progress: bool | Progress, label: str, *, unit: str = "", done: int = 0
) -> AbstractContextManager[Progress]:
    """Provide a function that reports the numbers of finished and of all cases.

    Parameters
    ----------
    progress : bool or callable
        True shows a bar; a callable is called in its place.
    label : str
        Name of the work, for the bar.
    unit : str, optional
        Of the rate that the bar shows: ".../s" or ".../min"; without it the bar shows a percentage.
    done : int
        Number of cases finished before, which do not count for the rate.

    Examples
    --------
    >>> def show(done, expected):
    ...     print(f"{done} of {expected}")
    >>> with progress_reporter(show, "solving") as report:
    ...     report(1, 2)
    1 of 2
    """
    check_arguments(progress=progress)
    if progress is True:
        from .bars import bar

        return bar(label, unit, done)
    return nullcontext(progress or (lambda done, expected: None))

"""Where results are to be written: refused before anything is solved, not after."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import InvalidProblem

__all__ = ["check_writable"]


def check_writable(path: Path) -> None:
    """Refuse a file that cannot be written.

    Raises
    ------
    InvalidProblem
        If the path is a folder, or its folder is missing or read-only.
    """
    folder = path.parent
    if not folder.is_dir():
        raise InvalidProblem.at(str(path), f"the folder {str(folder)!r} does not exist")
    if path.is_dir():
        raise InvalidProblem.at(str(path), "is a folder; name a file")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise InvalidProblem.at(str(path), "cannot be written: no permission")

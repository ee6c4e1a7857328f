"""Some of LAPACK's routines as SciPy has them, without the rest of scipy.linalg.

That package imports some two hundred modules, numpy.f2py and numpy.testing among them, which takes
longer than a nip to solve.  The extension module with LAPACK in it needs none of them.
"""

from __future__ import annotations

import sys
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from types import ModuleType

import scipy  # finds the libraries that the extension is linked to

__all__ = ["dgbtrf", "dgbtrs", "dgesv", "dgetrf", "dgetrs", "dgtsv"]


def _extension() -> ModuleType:
    """Return the module that holds LAPACK; that of scipy.linalg where SciPy keeps it elsewhere."""
    folders = [str(Path(folder) / "linalg") for folder in scipy.__path__]
    spec = PathFinder.find_spec("scipy.linalg._flapack", folders)
    if "scipy.linalg" in sys.modules or spec is None or spec.loader is None:
        from scipy.linalg import lapack

        return lapack
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_LAPACK = _extension()
dgesv, dgetrf, dgetrs = _LAPACK.dgesv, _LAPACK.dgetrf, _LAPACK.dgetrs
dgbtrf, dgbtrs, dgtsv = _LAPACK.dgbtrf, _LAPACK.dgbtrs, _LAPACK.dgtsv  # bands

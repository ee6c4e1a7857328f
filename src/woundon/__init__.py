"""Winding mechanics: the winding nip, the tension it adds, the stresses that stay in the roll.

The public names are listed in ``__init__.pyi``; each is imported when it is first used.
"""

from typing import Any

import lazy_loader

__version__ = "0.4.0.dev0"

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Import a public name; an error for another one names those that are like it."""
    try:
        return _imported(name)
    except AttributeError:
        if name in __all__ or name.startswith("_"):
            raise
    from .errors import one_of

    word = name.lower()
    alike = [known for known in __all__ if word in known.lower() or known.lower() in word]
    hint = f"; did you mean {one_of(alike)}?" if alike else "; dir(woundon) lists the public names"
    raise AttributeError(f"woundon has no attribute {name!r}{hint}")

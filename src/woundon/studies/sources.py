"""Hash of the source code, which distinguishes programs with the same version number."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable

__all__ = ["source_digest"]

_CODE = (".py", ".pyc", ".pyd", ".so")


@cache
def source_digest(*packages: str) -> str:
    """Return the first 16 hexadecimal digits of a SHA-256 hash of the code of packages.

    Names and contents of all source files count, whether the package is a folder or an archive.
    The hash is computed once in a process.
    """
    digest = hashlib.sha256()
    for package in packages:
        for name, file in sorted(_code(files(package), package), key=lambda entry: entry[0]):
            content = file.read_bytes().replace(b"\r\n", b"\n")  # the same on all systems
            digest.update(f"{name} {len(content)} ".encode() + content)
    return digest.hexdigest()[:16]


def _code(folder: Traversable, prefix: str) -> Iterator[tuple[str, Traversable]]:
    """Yield the files of code below a folder, each with its name; caches are left out."""
    for part in folder.iterdir():
        name = f"{prefix}/{part.name}"
        if part.is_dir() and part.name != "__pycache__":
            yield from _code(part, name)
        elif part.name.endswith(_CODE):
            yield name, part

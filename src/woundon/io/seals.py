"""The seal of a result file: a SHA-256 of what it says, by which any change is found.

JSON is sealed by its content, so that it may be laid out anew or pass through a terminal; netCDF by
its bytes, so that a damaged file is refused before it is taken apart.  A seal keeps off accidents
and well-meant edits, nothing more: whoever forges a file can seal it too.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from ..errors import InvalidProblem

__all__ = ["BLANK", "NAME", "check_bytes", "check_record", "of_record", "sealed_bytes"]

NAME = "sha256"
BLANK = "0" * 64  # what the seal is computed with in its own place
# the name of an attribute, padded; text; 64 characters (the classic format of netCDF)
_MARK = b"\0\0\0\x06sha256\0\0" + b"\0\0\0\x02" + b"\0\0\0\x40"


def of_record(record: Mapping[str, Any]) -> str:
    """Return the seal of what a JSON file holds."""
    content = {name: part for name, part in record.items() if name != NAME}
    return _seal(json.dumps(content, sort_keys=True, allow_nan=False).encode("ascii"))


def check_record(record: Mapping[str, Any]) -> bool:
    """Tell whether a record is sealed.

    Raises
    ------
    InvalidProblem
        If the seal is not that of the content.
    """
    return NAME in record and _same(record[NAME], of_record(record))


def sealed_bytes(content: bytes) -> bytes:
    """Return a netCDF file with its seal in place of the blank one."""
    before, blank, after = _parts(content)
    if blank != BLANK.encode("ascii"):
        raise AssertionError("the file has no place for its seal")
    return before + _seal(content).encode("ascii") + after


def check_bytes(content: bytes) -> bool:
    """Tell whether a netCDF file is sealed.

    Raises
    ------
    InvalidProblem
        If the seal is not that of the content.
    """
    before, seal, after = _parts(content)
    blank = BLANK.encode("ascii")
    return bool(seal) and _same(seal.decode("latin-1"), _seal(before + blank + after))


def _parts(content: bytes) -> tuple[bytes, bytes, bytes]:
    """Return what is before, in and after the place of the seal."""
    head, mark, tail = content.partition(_MARK)
    return head + mark, tail[:64], tail[64:]


def _seal(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _same(told: Any, due: str) -> bool:
    if told != due:
        text = "its content has changed since it was saved; load a copy that is as it was saved, "
        raise InvalidProblem.at(NAME, f"{text}or solve the problem again")
    return True

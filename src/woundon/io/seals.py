"""SHA-256 of result files, which detects damage and edits.

The hash of a JSON file is that of its content, so that it may be reformatted; the hash of a netCDF
file is that of its bytes, so that a damaged file is rejected before it is parsed.  It is not a
signature: a forger can compute it too.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from ..errors import InvalidProblem

__all__ = ["BLANK", "NAME", "check_bytes", "check_record", "of_record", "sealed_bytes"]

NAME = "sha256"
BLANK = "0" * 64  # in place of the hash while it is computed
# the name of an attribute, padded; text; 64 characters (the classic format of netCDF)
_MARK = b"\0\0\0\x06sha256\0\0" + b"\0\0\0\x02" + b"\0\0\0\x40"


def of_record(record: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the content of a JSON file.

    >>> of_record({"a": 1})[:8] == of_record({"a": 1, "sha256": "..."})[:8]
    True
    """
    content = {name: part for name, part in record.items() if name != NAME}
    return _sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode("ascii"))


def check_record(record: Mapping[str, Any]) -> bool:
    """Return True if a record has a SHA-256.

    Raises
    ------
    InvalidProblem
        If it is not that of the content.
    """
    return NAME in record and _check_same(record[NAME], of_record(record))


def sealed_bytes(content: bytes) -> bytes:
    """Return a netCDF file with its SHA-256 in place of the placeholder."""
    head, blank, tail = _parts(content)
    if blank != BLANK.encode("ascii"):
        raise AssertionError("the file has no place for its SHA-256")
    return head + _sha256(content).encode("ascii") + tail


def check_bytes(content: bytes) -> bool:
    """Return True if a netCDF file contains a SHA-256 and this matches its content.

    Raises
    ------
    InvalidProblem
        If the SHA-256 does not match.
    """
    head, seal, tail = _parts(content)
    blank = BLANK.encode("ascii")
    return bool(seal) and _check_same(seal.decode("latin-1"), _sha256(head + blank + tail))


def _parts(content: bytes) -> tuple[bytes, bytes, bytes]:
    """Split the content of a file into the bytes before, of and after the SHA-256."""
    head, mark, tail = content.partition(_MARK)
    return head + mark, tail[:64], tail[64:]


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _check_same(actual: Any, expected: str) -> bool:
    """Reject a SHA-256 that differs from the expected one."""
    if actual != expected:
        text = "its content has changed since it was saved; load an unchanged copy, "
        raise InvalidProblem.at(NAME, f"{text}or solve the problem again")
    return True

"""What a file says of itself: kind, version, units. Needs no library."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ._errors import Failed, Refused

MAGIC = b"PAR1"
# The key `seatrial` and the beginning of its value, as the footer's encoding has them
KEY = b"\x18\x08seatrial\x18"
#: The tables that this version reads, and the version of their schema.
TABLES = {
    "compare": 1,
    "covariances": 1,
    "estimates": 1,
    "merit-rows": 1,
    "moments-table": 1,
    "resamples": 1,
    "scores": 1,
    "track": 1,
    "trajectories": 1,
}


def path_of(path: str | os.PathLike[str]) -> Path:
    """The path, of a table or a document by its ending."""
    path = Path(path)
    if path.suffix not in (".parquet", ".json"):
        raise Refused(f"{path}: ending: found {path.suffix or 'none'}, expected .parquet or .json; name a table or a document")
    return path


def envelope(path: Path) -> dict[str, Any]:
    """The envelope of a table, in its footer."""
    footer = _footer(path)
    at = footer.find(KEY)
    if at < 0:
        raise Refused(f"{path}: file: found no `seatrial` metadata, expected a table with schema and units; name one of seatrial")
    try:
        length, start = _number(footer, at + len(KEY))
        found = json.loads(footer[start : start + length])
    except (IndexError, ValueError, RecursionError) as error:
        raise Refused(f"{path}: metadata: found {error}, expected JSON; the file is damaged: write it again") from error
    if not isinstance(found, dict):
        raise Refused(f"{path}: metadata: found no object, expected one; the file is damaged: write it again")
    return found


def units_of(path: Path, found: dict[str, Any]) -> dict[str, str]:
    """The unit of each column of a table with this envelope."""
    try:
        return {column["name"]: column["unit"] for column in found["columns"]}
    except (KeyError, TypeError) as error:
        raise Refused(f"{path}: metadata: found no columns, expected names and units; write the file again") from error


def check_table(path: Path, found: dict[str, Any]) -> str:
    """The kind of a table with this envelope, if this version reads it."""
    schema = str(found.get("schema"))
    kind = schema.partition("/")[0]
    if kind not in TABLES:
        raise Refused(f"{path}: schema: found {schema}, expected one of {', '.join(TABLES)}; upgrade seatrial")
    check_version(path, schema, f"{kind}/{TABLES[kind]}")
    return kind


def check_version(path: Path, found: str, expected: str) -> None:
    """Refuses another version of the same kind."""
    if found != expected:
        remedy = "upgrade seatrial or write the file again with this version"
        raise Refused(f"{path}: schema: found {found}, expected {expected}; {remedy}")


def unreadable(path: Path, error: OSError) -> Failed:
    """The exception of a file that cannot be read."""
    return Failed(f"{path}: read: found {error.strerror}, expected a readable file; check the path or write the file first")


def _footer(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            head = file.read(len(MAGIC))
            end = file.seek(0, os.SEEK_END)
            file.seek(max(0, end - 8))
            tail = file.read(8)
            length = int.from_bytes(tail[:4], "little")
            if head != MAGIC or tail[4:] != MAGIC or length > end - 12:
                raise Refused(f"{path}: file: found no Parquet header or footer, expected a whole table; write it again")
            file.seek(end - 8 - length)
            return file.read(length)
    except OSError as error:
        raise unreadable(path, error) from error
    except ValueError as error:
        raise Refused(f"{str(path)!r}: path: found {error}, expected a path of the system; correct it") from error


def _number(data: bytes, at: int) -> tuple[int, int]:
    """A number of seven bits a byte, and the place behind it."""
    number = 0
    for shift in range(0, 35, 7):
        byte = data[at]
        at += 1
        number |= (byte & 0x7F) << shift
        if byte < 0x80:
            return number, at
    raise ValueError("a length without end")

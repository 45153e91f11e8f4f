"""Reads XML files of routes."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path


class Unreadable(Exception):
    """A file that cannot be checked at all; the message is one line without the file's name."""


def read_root(path: Path) -> ET.Element:
    """The root of an XML file. Refuses declarations of entities, which no route needs."""
    try:
        text = path.read_bytes()
    except OSError as error:
        raise Unreadable(f"cannot be read: {error.strerror}") from error
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise Unreadable("found a document type, expected none")
    try:
        return ET.fromstring(text)
    except (ET.ParseError, LookupError, ValueError) as error:
        raise Unreadable(f"not XML: {error}") from error


def number(text: str | None) -> float | None:
    """A finite decimal number as XML Schema writes it, if it is one."""
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in (text or "") else None

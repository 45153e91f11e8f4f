"""Reads documents strictly into the classes of `seatrial.documents`."""

from __future__ import annotations

import json
import keyword
import types
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from . import documents
from ._envelope import check_version, unreadable
from ._errors import Refused

# Keys of every document; the others may be absent
REQUIRED = ("schema", "producer", "seal", "inputs", "settings", "units", "data")
OPTIONAL = ("origins", "shard", "members")


@dataclass(frozen=True)
class Document:
    """A document: its contents, and where they come from."""

    #: Kind and version, like `design/1`.
    schema: str
    #: The program that wrote it, and its version.
    producer: str
    #: Digests of the input files, by role.
    inputs: dict[str, str]
    #: Settings that determine the contents.
    settings: dict[str, Any]
    #: Unit of each number, by the name of its field.
    units: dict[str, str]
    #: The contents: a class of `seatrial.documents`.
    data: Any


class _Wrong(Exception):
    """Something in a document is not what its schema says."""

    def __init__(self, place: str, found: str, expected: str) -> None:
        super().__init__(place)
        self.place, self.found, self.expected = place, found, expected


def read_document(path: Path) -> Document:
    """Reads the document at `path`."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise unreadable(path, error) from error
    except UnicodeDecodeError as error:
        raise Refused(f"{path}: text: found bytes that are not UTF-8, expected JSON; write the file again") from error
    except ValueError as error:
        raise Refused(f"{str(path)!r}: path: found {error}, expected a path of the system; correct it") from error
    try:
        found = json.loads(text, object_pairs_hook=_once, parse_constant=_constant)
    except (ValueError, RecursionError) as error:
        raise Refused(f"{path}: text: found {error}, expected JSON; the file is damaged: write it again") from error
    cls = _class_of(path, found)
    try:
        _keys("", found, set(REQUIRED), {*REQUIRED, *OPTIONAL})
        data = _decoder(cls)("data", found["data"])
    except _Wrong as wrong:
        found_expected = f"found {wrong.found}, expected {wrong.expected}"
        raise Refused(f"{path}: {wrong.place}: {found_expected}; write the file again with this version") from wrong
    except RecursionError as error:
        raise Refused(f"{path}: data: found {error}, expected a document of seatrial; write the file again") from error
    own = {name: found[name] for name in ("schema", "producer", "inputs", "settings", "units")}
    return Document(**own, data=data)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key twice in one object")
    return found


def _constant(name: str) -> Any:
    raise ValueError(f"{name}, which is no number")


def _class_of(path: Path, found: Any) -> type:
    """The class of the contents, by the schema that the document names."""
    schema = str(found.get("schema")) if isinstance(found, dict) else "no object"
    if schema in documents.KINDS:
        cls: type = getattr(documents, documents.KINDS[schema])
        return cls
    known = {name.partition("/")[0]: name for name in documents.KINDS}
    kind = schema.partition("/")[0]
    if kind in known:
        check_version(path, schema, known[kind])
    raise Refused(f"{path}: schema: found {schema}, expected one of {', '.join(known)}; name a document of seatrial")


def _keys(place: str, value: Any, required: set[str], known: set[str]) -> None:
    """Refuses a value that is no object of these keys."""
    if not isinstance(value, dict):
        raise _Wrong(place or "document", _named(value), "an object")
    unknown = [key for key in value if key not in known]
    if unknown:
        raise _Wrong(_below(place, unknown[0]), "an unknown key", f"one of {', '.join(sorted(known))}")
    absent = sorted(required - value.keys())
    if absent:
        raise _Wrong(_below(place, absent[0]), "no such key", "a value")


def _below(place: str, key: str) -> str:
    return f"{place}.{key}" if place else key


def _named(value: Any) -> str:
    """What a value is, in short."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else f"{text[:37]}..."


Decoder = Callable[[str, Any], Any]


@lru_cache(maxsize=None)
def _decoder(kind: Any) -> Decoder:
    """What turns a value of JSON into one of the type `kind`, or says what is wrong with it."""
    if is_dataclass(kind):
        return _object(kind)
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return _choice(arguments)
    if origin in (types.UnionType, Union):
        return _optional([own for own in arguments if own is not type(None)][0])
    if origin is list:
        return _list(_decoder(arguments[0]))
    if origin is tuple:
        return _tuple([_decoder(own) for own in arguments])
    if origin is dict:
        return _mapping(_decoder(arguments[1]))
    if kind is Any:
        return lambda _, value: value
    return _plain(kind)


def _object(kind: Any) -> Decoder:
    hints = get_type_hints(kind, vars(documents))
    # Loaded at the first value, since some types contain themselves
    parts: dict[str, tuple[str, Decoder]] = {}
    keys = {_key(own.name): own for own in fields(kind)}
    required = {key for key, own in keys.items() if own.default is MISSING and own.default_factory is MISSING}

    def decode(place: str, value: Any) -> Any:
        if not parts:
            parts.update({key: (own.name, _decoder(hints[own.name])) for key, own in keys.items()})
        _keys(place, value, required, set(keys))
        return kind(**{parts[key][0]: parts[key][1](f"{place}.{key}", own) for key, own in value.items()})

    return decode


def _key(attribute: str) -> str:
    """The key of an attribute: keywords of Python have a `_` behind them."""
    bare = attribute.removesuffix("_")
    return bare if keyword.iskeyword(bare) else attribute


def _choice(values: tuple[Any, ...]) -> Decoder:
    def decode(place: str, value: Any) -> Any:
        if value not in values:
            raise _Wrong(place, _named(value), f"one of {', '.join(map(str, values))}")
        return value

    return decode


def _optional(kind: Any) -> Decoder:
    inner = _decoder(kind)
    return lambda place, value: None if value is None else inner(place, value)


def _list(inner: Decoder) -> Decoder:
    def decode(place: str, value: Any) -> Any:
        if not isinstance(value, list):
            raise _Wrong(place, _named(value), "a list")
        return [inner(f"{place}[{i}]", own) for i, own in enumerate(value)]

    return decode


def _tuple(inner: list[Decoder]) -> Decoder:
    def decode(place: str, value: Any) -> Any:
        if not isinstance(value, list) or len(value) != len(inner):
            raise _Wrong(place, _named(value), f"a list of {len(inner)}")
        return tuple(own(f"{place}[{i}]", item) for i, (own, item) in enumerate(zip(inner, value)))

    return decode


def _mapping(inner: Decoder) -> Decoder:
    def decode(place: str, value: Any) -> Any:
        if not isinstance(value, dict):
            raise _Wrong(place, _named(value), "an object")
        return {key: inner(f"{place}.{key}", own) for key, own in value.items()}

    return decode


def _plain(kind: type) -> Decoder:
    names = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}

    def decode(place: str, value: Any) -> Any:
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            try:
                return float(value)
            except OverflowError as error:
                raise _Wrong(place, _named(value), "a number below 1e308") from error
        if type(value) is not kind:
            raise _Wrong(place, _named(value), names[kind])
        return value

    return decode

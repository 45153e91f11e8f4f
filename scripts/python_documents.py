"""Writes python/src/seatrial/documents.py: the documents of `schemas/` as dataclasses. Needs nothing but Python 3.10.

    python3 scripts/python_documents.py            write it
    python3 scripts/python_documents.py --check    exit code 1 if it is not what the schemas say

A definition of the same name is the same in all schemas; if it is not, this ends with exit code 1 and names it.
"""

from __future__ import annotations

import json
import keyword
import sys
import textwrap
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TO = ROOT / "python" / "src" / "seatrial" / "documents.py"
WIDTH = 120
NUMBERS = {"number": "float", "integer": "int", "string": "str", "boolean": "bool"}
EMPTY = {"number": "0.0", "integer": "0", "string": '""', "boolean": "False"}
HEAD = '''"""The documents of a study as dataclasses: what `seatrial.read` gives for JSON files.

Written by scripts/python_documents.py from schemas/; do not edit. A name that is a keyword of Python ends with `_` here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

'''

Schema = dict[str, Any]


def definitions() -> tuple[dict[str, Schema], dict[str, str]]:
    """All definitions by name, and for each kind of document, like `design/1`, the name of its contents."""
    found: dict[str, Schema] = {}
    kinds: dict[str, str] = {}
    for path in sorted((ROOT / "schemas").glob("*.schema.json")):
        if path.name.endswith("-toml.schema.json"):
            continue
        schema = json.loads(path.read_text(encoding="utf-8"))
        kinds[schema["properties"]["schema"]["const"]] = name_of(schema["properties"]["data"])
        for name, definition in schema["$defs"].items():
            if found.setdefault(name, definition) != definition:
                sys.exit(f"{path}: {name}: found two definitions of this name, expected one; rename one of the types")
    return found, kinds


def name_of(schema: Schema) -> str:
    """The name that a schema refers to."""
    return schema["$ref"].removeprefix("#/$defs/")


def of_one(kind: str, schema: Schema) -> str:
    """The Python type of values of one kind."""
    if kind == "array":
        item = of(schema["items"])
        length = schema.get("minItems")
        fixed = length is not None and length == schema.get("maxItems")
        return f"tuple[{', '.join([item] * length)}]" if fixed else f"list[{item}]"
    if kind == "object":
        return f"dict[str, {of(schema['additionalProperties'])}]"
    if "enum" in schema:
        return literal(schema["enum"])
    return NUMBERS[kind]


def of(schema: Schema | bool) -> str:
    """The Python type of the values that `schema` allows."""
    if schema is True:
        return "Any"
    assert isinstance(schema, dict)
    if "$ref" in schema:
        return name_of(schema)
    if "anyOf" in schema:
        return " | ".join("None" if one.get("type") == "null" else of(one) for one in schema["anyOf"])
    if "oneOf" in schema:
        return literal([one["const"] for one in schema["oneOf"]])
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    return " | ".join("None" if kind == "null" else of_one(kind, schema) for kind in kinds)


def literal(values: list[str]) -> str:
    """The type of one of some texts."""
    return f"Literal[{', '.join(json.dumps(value, ensure_ascii=False) for value in values)}]"


def default(schema: Schema) -> str:
    """What stands for a key that may be absent and is."""
    kind = schema.get("type")
    if isinstance(schema.get("default"), str):
        return json.dumps(schema["default"])
    if "anyOf" in schema or isinstance(kind, list):
        return "None"
    if kind in ("array", "object"):
        return f"field(default_factory={'list' if kind == 'array' else 'dict'})"
    assert isinstance(kind, str)
    return EMPTY[kind]


def comment(text: str, indent: str) -> list[str]:
    """The lines of a comment."""
    lines = textwrap.wrap(" ".join(text.split()), WIDTH - len(indent) - 3, break_long_words=False)
    return [f"{indent}#: {line}" for line in lines]


def described(text: str) -> str:
    """The docstring of a class."""
    text = " ".join(text.split()).replace("\\", "\\\\")
    if len(text) <= WIDTH - 10:
        return f'    """{text}"""'
    lines = textwrap.wrap(text, WIDTH - 8, break_long_words=False)
    return "\n".join([f'    """{lines[0]}', *(f"    {line}" for line in lines[1:]), '    """'])


def python_name(key: str) -> str:
    """The attribute of a key."""
    return f"{key}_" if keyword.iskeyword(key) else key


def dataclass_of(name: str, schema: Schema) -> str:
    """The class of a definition with keys."""
    lines = ["@dataclass(frozen=True, kw_only=True)", f"class {name}:", described(schema["description"]), ""]
    for key, value in schema["properties"].items():
        lines += comment(value.get("description", ""), "    ")
        absent = "" if key in schema.get("required", []) else f" = {default(value)}"
        lines.append(f"    {python_name(key)}: {of(value)}{absent}")
    return "\n".join(lines)


def alias_of(name: str, schema: Schema) -> str:
    """The name of a definition without keys, such as a choice of texts."""
    return "\n".join([*comment(schema["description"], ""), f"{name} = {of(schema)}"])


def text() -> str:
    """The whole file."""
    found, kinds = definitions()
    aliases = [alias_of(name, schema) for name, schema in sorted(found.items()) if "properties" not in schema]
    classes = [dataclass_of(name, schema) for name, schema in sorted(found.items()) if "properties" in schema]
    known = "".join(f'    "{kind}": "{name}",\n' for kind, name in sorted(kinds.items()))
    table = f"#: The class of the contents of each kind of document.\nKINDS = {{\n{known}}}"
    return HEAD + "\n".join(aliases) + "\n\n\n" + "\n\n\n".join([*classes, table]) + "\n"


def main() -> None:
    """Writes or compares the file."""
    new = text()
    if sys.argv[1:] == ["--check"]:
        old = TO.read_text(encoding="utf-8") if TO.exists() else ""
        if old != new:
            sys.exit(f"{TO}: found other classes than schemas/ say; run python3 scripts/python_documents.py")
    elif sys.argv[1:]:
        sys.exit(f"found {' '.join(sys.argv[1:])}, expected --check or nothing")
    else:
        TO.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()

"""Pages of the book's reference, in Markdown: programs from their `--help`, files from their JSON Schemas.

Used by book.py; writes nothing itself.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# A line of a help's list of commands: its name, at least two blanks, the beginning of what it does
COMMAND = re.compile(r"^  ([a-z][a-z-]*)  +\S")
# The beginning of a link to a page of docs/
PAGE = re.compile(r"\]\((?=[a-z-]+\.md)")
PROGRAMS = """Everything is one program, `seatrial`. Its stages are also programs of their own, such as `design` for `seatrial design`, in
the archives of a release and in `target/release` after `make build`. In most shells `export` is a command of the shell
itself: call that one `seatrial export`.
"""
WRITTEN = "Files that you write, in TOML. `seatrial new` writes commented ones; an unknown key is refused, and the nearest one named.\n"
MADE = "Files that stages write, in JSON. [Files](../files.md) says which stage writes which, and how files of one study belong together.\n"


@dataclass
class Page:
    """A page of the reference: where it stands, its title, its text, and the pages below it."""

    path: str
    title: str
    text: str
    below: list["Page"] = field(default_factory=list)


def asked(program: Path, commands: list[str]) -> str:
    """What `program commands --help` prints."""
    line = [str(program), *commands, "--help"]
    narrow = {**os.environ, "COLUMNS": "80"}
    return subprocess.run(line, check=True, capture_output=True, encoding="utf-8", env=narrow).stdout.rstrip()


def subcommands(text: str) -> list[str]:
    """The commands that a help lists, but `help`."""
    listed = text.partition("\nCommands:\n")[2].partition("\n\n")[0]
    found = [match[1] for match in map(COMMAND.match, listed.splitlines()) if match]
    return [name for name in found if name != "help"]


def summary(text: str) -> str:
    """The first sentence or paragraph of a help."""
    return " ".join(text.partition("\n\n")[0].split())


def sections(program: Path, commands: list[str], text: str) -> list[str]:
    """The help of a command and of all below it, each under a heading."""
    name = " ".join(["seatrial", *commands])
    level = "#" * min(len(commands), 3)
    parts = [f"{level} {name}\n\n```text\n{text}\n```\n"]
    for own in subcommands(text):
        parts += sections(program, [*commands, own], asked(program, [*commands, own]))
    return parts


def programs(program: Path) -> Page:
    """The page of all programs, with a page for each stage below it."""
    text = asked(program, [])
    pages, rows = [], []
    for name in subcommands(text):
        own = asked(program, [name])
        pages.append(Page(f"reference/{name}.md", f"seatrial {name}", "\n".join(sections(program, [name], own))))
        rows.append(f"| [`{name}`]({name}.md) | {cell(summary(own))} |")
    if not pages:
        raise ValueError(f"{program} --help: commands: found none, expected some; look at COMMAND in book_reference.py")
    table = "\n".join(["| program | what it does |", "|---|---|", *rows])
    return Page("reference/programs.md", "Programs", f"# Programs\n\n{PROGRAMS}\n{table}\n\n```text\n{text}\n```\n", pages)


def cell(text: str) -> str:
    """`text` as it may stand in a table: one line, no bars, no tags, links from the folder of the reference."""
    one = " ".join(text.split()).replace("\\|", "|").replace("|", "\\|")
    parts = PAGE.sub("](../", one).split("`")
    return "`".join(part if inside % 2 else part.replace("<", "&lt;") for inside, part in enumerate(parts))


def takes(schema: Any) -> str:
    """What a schema allows, in a few words."""
    if not isinstance(schema, dict) or not schema:
        return "anything"
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in schema:
        return f"`{json.dumps(schema['const'], ensure_ascii=False)}`"
    if "enum" in schema:
        return " or ".join(f"`{json.dumps(each, ensure_ascii=False)}`" for each in schema["enum"])
    for key in ("oneOf", "anyOf"):
        if key in schema:
            return " or ".join(dict.fromkeys(map(takes, schema[key])))
    if "allOf" in schema:
        return " and ".join(map(takes, schema["allOf"]))
    kind = schema.get("type")
    if isinstance(kind, list):
        return " or ".join(takes({**schema, "type": each}) for each in kind)
    if kind == "array":
        if "prefixItems" in schema:
            return "a list of " + ", ".join(map(takes, schema["prefixItems"]))
        return f"a list, each {takes(schema.get('items'))}"
    if kind == "object":
        inner = schema.get("additionalProperties")
        return f"a table, each {takes(inner)}" if isinstance(inner, dict) else "a table"
    words = {"string": "text", "number": "a number", "integer": "a whole number", "boolean": "true or false", "null": "nothing"}
    return words.get(kind, "anything")


def keys(schema: dict) -> list[str]:
    """The table of an object's keys, or what else it allows; of a choice, one after the other."""
    said = [cell(schema["description"]), ""] if "description" in schema else []
    for choice in schema.get("oneOf", schema.get("anyOf", [])):
        said += keys(choice) if "properties" in choice else [f"- {takes(choice)}. {cell(choice.get('description', ''))}".rstrip(), ""]
    if "properties" in schema:
        said += ["| key | takes | needed | meaning |", "|---|---|---|---|"]
        needed = schema.get("required", [])
        for name, own in schema["properties"].items():
            meaning = cell(own.get("description", "")) if isinstance(own, dict) else ""
            said.append(f"| `{name}` | {cell(takes(own))} | {'yes' if name in needed else ''} | {meaning} |")
        said.append("")
    elif not schema.get("oneOf", schema.get("anyOf")):
        said += [f"Takes {takes(schema)}.", ""]
    return said


def file(path: Path, name: str) -> Page:
    """The page of the file `name`, from its schema."""
    schema = json.loads(path.read_text(encoding="utf-8"))
    lines = [f"# {name}", "", f"Its JSON Schema is `schemas/{path.name}`.", "", *keys(schema)]
    for own, part in schema.get("$defs", {}).items():
        lines += [f"## {own}", "", *keys(part)]
    return Page(f"reference/{name.replace('.', '-')}.md", name, "\n".join(lines))


def files(folder: Path) -> tuple[Page, Page]:
    """The pages of hand-written files and of documents, with a page for each file below them."""
    written, made = [], []
    for path in sorted(folder.glob("*.schema.json")):
        name = path.name.removesuffix(".schema.json")
        if name.endswith("-toml"):
            written.append(file(path, f"{name.removesuffix('-toml')}.toml"))
        else:
            made.append(file(path, f"{name}.json"))
    listed = lambda pages: "\n".join(f"- [{page.title}]({Path(page.path).name})" for page in pages)  # noqa: E731
    return (
        Page("reference/hand-written.md", "Hand-written files", f"# Hand-written files\n\n{WRITTEN}\n{listed(written)}\n", written),
        Page("reference/documents.md", "Documents", f"# Documents\n\n{MADE}\n{listed(made)}\n", made),
    )

"""Makes what a release hands out: archives of the program, and the notes of a version.

    python scripts/release.py check --tag v0.3.0
    python scripts/release.py archive --bin target/release --target x86_64-unknown-linux-gnu --out out/release
    python scripts/release.py sum out/release/seatrial-0.3.0-py3-none-win_amd64.whl
    python scripts/release.py notes --version 0.3.0

`check` compares the tag with Cargo.toml, CITATION.cff and CHANGELOG.md. `archive` packs the program with README, manual pages,
completions for shells, licenses, those of all dependencies and a list of these in CycloneDX (sbom.json), as .tar.xz or, for
Windows, .zip, and writes the SHA-256 sum beside it: the same bytes for the same program. That of another system writes no pages
here: `--by` names one that does. `sum` writes that of other files, such as wheels. Needs nothing but Python and cargo.
Exits with 3 where a file is not as expected.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import lzma
import re
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
ROOTS = ("seatrial-cli",)
TEXTS = ("README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE")
LICENSE = re.compile(r"^(licen[cs]e|copying|unlicense|notice|copyright)", re.IGNORECASE)
# Archives of the same programs have the same bytes: all files are of 1980, the first year of a zip.
YEAR = (1980, 1, 1, 0, 0, 0)
SECONDS = 315532800


class Refused(Exception):
    """What is wrong, in one line."""


def version() -> str:
    """The version of the workspace."""
    return tomllib.loads((TOP / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]


def notes(wanted: str) -> str:
    """The section of CHANGELOG.md about the version `wanted`."""
    text = (TOP / "CHANGELOG.md").read_text(encoding="utf-8")
    found = re.search(rf"^## {re.escape(wanted)}(, \d{{4}}-\d\d-\d\d)?\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    if not found:
        raise Refused(f"CHANGELOG.md: sections: found none of {wanted}, expected `## {wanted}, <date>`; name the version there")
    return found[2].strip() + "\n"


def check(tag: str) -> None:
    """Refuses a tag that is not of the version in Cargo.toml and CITATION.cff, or that CHANGELOG.md has no section of."""
    cited = re.search(r"^version: (.*)$", (TOP / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    for file, found in [("Cargo.toml", version()), ("CITATION.cff", cited[1] if cited else "none")]:
        if tag != f"v{found}":
            raise Refused(f"{file}: version: found {found}, expected that of the tag {tag}; change one of them")
    notes(version())


def program(folder: Path, target: str) -> Path:
    """The program `seatrial` in `folder`, which has all stages; those of single stages are for the repository."""
    path = folder / ("seatrial.exe" if "windows" in target else "seatrial")
    if not path.is_file():
        raise Refused(f"{path}: found no such program, expected one; cargo build --release -p seatrial-cli makes it")
    return path


def dependencies(target: str) -> list[dict]:
    """Packages that are compiled into the programs for `target`, without the workspace's own."""
    line = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    data = json.loads(subprocess.run(line, cwd=TOP, check=True, capture_output=True).stdout)
    packages = {each["id"]: each for each in data["packages"]}
    nodes = {each["id"]: each["deps"] for each in data["resolve"]["nodes"]}
    waiting = [key for key, each in packages.items() if each["name"] in ROOTS and not each["source"]]
    seen = set(waiting)
    while waiting:
        for dependency in nodes[waiting.pop()]:
            if dependency["pkg"] not in seen and any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                seen.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    found = [packages[key] for key in seen if packages[key]["source"]]
    return sorted(found, key=lambda each: (each["name"], each["version"]))


def license_texts(packages: list[dict]) -> str:
    """The licenses of `packages`: each text once, under the packages that come with it."""
    owners: dict[str, list[str]] = {}
    for each in packages:
        folder = Path(each["manifest_path"]).parent
        paths = sorted(path for path in folder.iterdir() if path.is_file() and LICENSE.match(path.name))
        texts = [path.read_text(encoding="utf-8", errors="replace").strip() for path in paths]
        for text in texts or ["(The package has no text of its license.)"]:
            owners.setdefault(text, []).append(f"{each['name']} {each['version']} ({each['license']})")
    parts = ["The programs contain these packages, under the licenses that follow.\n"]
    for text, names in owners.items():
        parts.append("\n".join(["=" * 78, *names, "-" * 78, text, ""]))
    return "\n".join(parts)


def sbom(packages: list[dict], target: str) -> str:
    """The packages in the programs for `target`, in CycloneDX 1.5."""
    def part(each: dict) -> dict:
        name, number = each["name"], each["version"]
        purl = f"pkg:cargo/{name}@{number}"
        licenses = [{"expression": each["license"].replace("/", " OR ")}] if each["license"] else []
        return {"type": "library", "bom-ref": purl, "name": name, "version": number, "purl": purl, "licenses": licenses}

    whole = {"type": "application", "bom-ref": "seatrial", "name": "seatrial", "version": version()}
    parts = [part(each) for each in packages]
    metadata = {"component": whole, "properties": [{"name": "target", "value": target}]}
    bom = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": metadata, "components": parts}
    return json.dumps(bom, indent=1, ensure_ascii=False) + "\n"


def pages(program: Path) -> dict[str, bytes]:
    """The manual pages and the completions that `program` writes."""
    def written(*words: str) -> bytes:
        return subprocess.run([str(program), "completions", *words], check=True, capture_output=True).stdout

    with tempfile.TemporaryDirectory() as folder:
        written("man", folder)
        found = {f"man/man1/{path.name}": path.read_bytes() for path in sorted(Path(folder).iterdir())}
    return found | {f"completions/seatrial.{shell}": written(shell) for shell in ("bash", "elvish", "fish", "powershell", "zsh")}


def tar(name: str, files: dict[str, tuple[bytes, int]]) -> bytes:
    """`files`, with their modes, in a folder `name` of a .tar.xz."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w") as archive:
        for path, (content, mode) in files.items():
            info = tarfile.TarInfo(f"{name}/{path}")
            info.size, info.mode, info.mtime = len(content), mode, SECONDS
            archive.addfile(info, io.BytesIO(content))
    return lzma.compress(plain.getvalue(), preset=9)


def zipped(name: str, files: dict[str, tuple[bytes, int]]) -> bytes:
    """`files` in a folder `name` of a .zip."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, (content, mode) in files.items():
            info = zipfile.ZipInfo(f"{name}/{path}", YEAR)
            info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, mode << 16
            archive.writestr(info, content)
    return whole.getvalue()


def archive(folder: Path, target: str, out: Path, by: Path | None) -> Path:
    """Packs the program in `folder` for `target` into `out`, with the pages that the program `by` writes, and the sum beside."""
    packed = program(folder, target)
    files = {f"bin/{packed.name}": (packed.read_bytes(), 0o755)}
    files |= {name: ((TOP / name).read_bytes(), 0o644) for name in TEXTS}
    files |= {name: (content, 0o644) for name, content in pages((by or packed).absolute()).items()}
    packages = dependencies(target)
    files["LICENSES-OF-DEPENDENCIES.txt"] = (license_texts(packages).encode(), 0o644)
    files["sbom.json"] = (sbom(packages, target).encode(), 0o644)
    name = f"seatrial-{version()}-{target}"
    ending, pack = (".zip", zipped) if "windows" in target else (".tar.xz", tar)
    content = pack(name, files)
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{name}{ending}"
    path.write_bytes(content)
    summed(path)
    return path


def summed(path: Path) -> Path:
    """Writes the SHA-256 sum of the file at `path` beside it."""
    if not path.is_file():
        raise Refused(f"{path}: found no such file, expected one to sum; build it first")
    sum_of = path.with_name(f"{path.name}.sha256")
    sum_of.write_bytes(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n".encode())
    return sum_of


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("check").add_argument("--tag", required=True)
    commands.add_parser("notes").add_argument("--version", default=version())
    commands.add_parser("sum").add_argument("files", type=Path, nargs="+")
    packing = commands.add_parser("archive")
    packing.add_argument("--bin", type=Path, required=True)
    packing.add_argument("--target", required=True)
    packing.add_argument("--out", type=Path, required=True)
    packing.add_argument("--by", type=Path)
    return parser.parse_args()


def main() -> int:
    given = arguments()
    try:
        if given.command == "check":
            check(given.tag)
        elif given.command == "notes":
            print(notes(given.version), end="")
        elif given.command == "sum":
            for path in given.files:
                print(summed(path))
        else:
            print(archive(given.bin, given.target, given.out, given.by))
    except Refused as refused:
        print(f"error: {refused}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())

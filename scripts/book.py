"""Makes the book: the pages of docs/, with a reference of all programs and files, by mdBook.

    python scripts/book.py --bin target/release --figures out/book-check/out/tutorial/results/figures --out out/book

docs/SUMMARY.md lists the pages. Those outside of docs/ are copied beside the others, and all links between pages
follow. The chapters without a page there, `[Programs]()`, are the reference. A comment `<!-- figure: a.svg: words -->`
becomes that figure of the tutorial's study. At the end every link between the pages in HTML is followed. Needs Python
and mdbook; exits with 3 where a page, a figure or a link is missing.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

sys.dont_write_bytecode = True

import book_reference  # noqa: E402  (no cache before)
from book_reference import Page  # noqa: E402

TOP = Path(__file__).resolve().parent.parent
DOCS = TOP / "docs"
LINK = re.compile(r"\]\(([^()\s]+)\)")
ENTRY = re.compile(r"^(\s*(?:- )?)\[(.+)\]\((.*)\)$")
FIGURE = re.compile(r"^<!-- figure: (\S+): (.*) -->$", re.MULTILINE)


class Refused(Exception):
    """What is wrong, in one line."""


def chapters() -> dict[Path, str]:
    """Every page that SUMMARY.md lists, by its path, with its place in the book."""
    found = {}
    for line in (DOCS / "SUMMARY.md").read_text(encoding="utf-8").splitlines():
        entry = ENTRY.match(line)
        if entry and entry[3]:
            page = (DOCS / entry[3]).resolve()
            if not page.is_file():
                raise Refused(f"docs/SUMMARY.md: {entry[3]}: found no such page, expected one; write it or leave it out")
            title = re.sub(r"[^a-z0-9]+", "-", entry[2].lower()).strip("-")
            found[page] = page.name if page.parent == DOCS else f"{title}.md"
    missing = sorted(page.name for page in DOCS.glob("*.md") if page.name != "SUMMARY.md" and page not in found)
    if missing:
        raise Refused(f"docs/SUMMARY.md: pages: found no {missing[0]}, expected all of docs/; add it there")
    return found


def followed(text: str, page: Path, places: dict[Path, str], source: Path) -> str:
    """The text of `page` with its links as they are in the book; what is no page is copied along."""

    def link(match: re.Match) -> str:
        path, mark, part = match[1].partition("#")
        target = (page.parent / path).resolve()
        if not path or "://" in path or not target.is_relative_to(TOP):
            return match[0]
        if target in places:
            return f"]({places[target]}{mark}{part})"
        if not target.is_file():
            raise Refused(f"{page.relative_to(TOP)}: link {match[1]}: found no such file, expected one; mend the link")
        copy = target.relative_to(DOCS if target.parent == DOCS else TOP)
        (source / copy).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(target, source / copy)
        return f"]({copy.as_posix()}{mark}{part})"

    parts = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)


def drawn(text: str, page: Path, figures: Path, source: Path) -> str:
    """The text with figures in place of their comments."""

    def figure(match: re.Match) -> str:
        path = figures / match[1]
        if not path.is_file():
            raise Refused(f"{page.relative_to(TOP)}: figure {match[1]}: found no {path}, expected it; run scripts/book-check.sh")
        (source / "figures").mkdir(exist_ok=True)
        shutil.copyfile(path, source / "figures" / path.name)
        return f'<img src="figures/{path.name}" alt="{match[2]}" style="width: 36em; background: white">\n\n*{match[2]}*'

    return FIGURE.sub(figure, text)


def written(reference: Page, source: Path, depth: int) -> list[str]:
    """Writes the pages of the reference, and gives their lines of SUMMARY.md."""
    path = source / reference.path
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(reference.text, encoding="utf-8")
    lines = [f"{'  ' * depth}- [{reference.title}]({reference.path})"]
    for below in reference.below:
        lines += written(below, source, depth + 1)
    return lines


def contents(places: dict[Path, str], reference: dict[str, Page], source: Path) -> str:
    """SUMMARY.md of the book."""
    lines = []
    for line in (DOCS / "SUMMARY.md").read_text(encoding="utf-8").splitlines():
        entry = ENTRY.match(line)
        if entry and not entry[3]:
            if entry[2] not in reference:
                raise Refused(f"docs/SUMMARY.md: [{entry[2]}](): found no such reference, expected one of {', '.join(reference)}")
            lines += written(reference[entry[2]], source, 0)
        elif entry:
            lines.append(f"{entry[1]}[{entry[2]}]({places[(DOCS / entry[3]).resolve()]})")
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


class Links(HTMLParser):
    """The ids of a page, and what it links to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.targets: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.ids.add(value)
            elif name in ("href", "src") and value and tag in ("a", "img"):
                self.targets.append(value)


def broken(folder: Path) -> list[str]:
    """Links between the pages in `folder` that lead nowhere."""
    pages = {path: Links(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    found = []
    for path, links in pages.items():
        # Pages that mdBook writes for itself: the whole book for printing, the page for addresses that do not exist
        if path.name in ("print.html", "404.html", "toc.html"):
            continue
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            other = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            other = other / "index.html" if other.is_dir() else other
            known = pages.get(other)
            if not other.is_file() or (parts.fragment and known and unquote(parts.fragment) not in known.ids):
                found.append(f"{path.relative_to(folder)}: {target}")
    return found


def make(bin: Path, figures: Path, out: Path) -> str:
    """Makes the book in `out`, and says what came of it."""
    source, html = out / "src", out / "html"
    for folder in (source, html):
        shutil.rmtree(folder, ignore_errors=True)
    source.mkdir(parents=True)
    places = chapters()
    for page, place in places.items():
        text = followed(page.read_text(encoding="utf-8"), page, places, source)
        (source / place).write_text(drawn(text, page, figures, source), encoding="utf-8")
    hand_written, documents = book_reference.files(TOP / "schemas")
    pages = [book_reference.programs(bin / "seatrial"), hand_written, documents]
    (source / "SUMMARY.md").write_text(contents(places, {page.title: page for page in pages}, source), encoding="utf-8")
    settings = (DOCS / "book.toml").read_text(encoding="utf-8").replace('src = "."', 'src = "src"')
    (out / "book.toml").write_text(settings, encoding="utf-8")
    subprocess.run(["mdbook", "build", str(out), "--dest-dir", str(html.resolve())], check=True)
    lost = broken(html)
    if lost:
        raise Refused(f"{html}: links: found {len(lost)} that lead nowhere, such as {lost[0]}, expected none; mend the page")
    return f"{html}/index.html: {len(list(html.rglob('*.html')))} pages, links hold"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=Path, required=True)
    parser.add_argument("--figures", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    try:
        print(make(given.bin, given.figures, given.out))
    except Refused as refused:
        print(f"error: {refused}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())

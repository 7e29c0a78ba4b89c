"""Check the built site: ``python docs/check_site.py docs/_build/html``.

Every link to a page, a file or an anchor of the site must lead somewhere, and no page may load
anything from another server. Exit code 1 where that does not hold.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes whose address is loaded with the page, by element.
LOADED = {
    "audio": ("src",),
    "embed": ("src",),
    "iframe": ("src",),
    "img": ("src", "srcset"),
    "link": ("href",),
    "object": ("data",),
    "script": ("src",),
    "source": ("src", "srcset"),
    "video": ("src", "poster"),
}
# Links of the head that name a place and load nothing.
NAMED = {"canonical", "author", "license", "next", "prev", "index", "search"}
IN_STYLES = re.compile(r"""(?:url\(|@import\s+)\s*['"]?(https?:)?//""")


@dataclass
class Page(HTMLParser):
    """Anchors of a page, the links on it, and what it loads."""

    path: Path
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what an element is called and where it leads."""
        values = {name: value or "" for name, value in attrs}
        self.anchors |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if tag == "link" and NAMED & set(values.get("rel", "").split()):
            return
        for name in LOADED.get(tag, ()):
            if name in values:
                self.loaded += [part.split()[0] for part in values[name].split(",") if part.strip()]


def is_elsewhere(address: str) -> bool:
    """Whether an address names a server or a scheme."""
    parts = urlsplit(address)
    return bool(parts.scheme or parts.netloc)


def problems(site: Path) -> tuple[list[str], int]:
    """Everything that is wrong with a site, and the number of links looked at."""
    # What lies in _static are templates of the theme.
    paths = [path for path in sorted(site.rglob("*.html")) if "_static" not in path.parts]
    pages = {path: Page(path) for path in paths}
    faults, count = [], 0
    if not pages:
        faults.append(f"{site} has no pages")
    for path, page in pages.items():
        at = path.relative_to(site)
        for address in page.loaded:
            if is_elsewhere(address) and not address.startswith("data:"):
                faults.append(f"{at} loads {address}")
        for address in [*page.links, *page.loaded]:
            if is_elsewhere(address):
                continue
            count += 1
            name, _, anchor = unquote(address).partition("#")
            name = name.partition("?")[0]
            target = (path.parent / name).resolve() if name else path
            if not target.exists():
                faults.append(f"{at}: {address} leads nowhere")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                faults.append(f"{at}: {address} has no such anchor")
    for path in site.rglob("*.css"):
        if IN_STYLES.search(path.read_text(encoding="utf-8")):
            faults.append(f"{path.relative_to(site)} loads from another server")
    return faults, count


def main(arguments: list[str]) -> int:
    """Print what is wrong; return the exit code."""
    site = Path(arguments[0]).resolve()
    faults, count = problems(site)
    for problem in faults:
        print(problem, file=sys.stderr)
    if not faults:
        size_mb = sum(path.stat().st_size for path in site.rglob("*") if path.is_file()) / 1e6
        print(f"{count} links and anchors of the site are whole; {size_mb:.1f} MB")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

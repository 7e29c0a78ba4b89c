"""Make the Markdown pages, which are written for GitHub, at home in the site.

* Comments for the tests are left out.
* Blocks that show commands behind ``$`` get the colours of a console.
* ``CONTRIBUTING.md``, ``CHANGELOG.md`` and ``SECURITY.md`` beside ``docs/`` become pages, and
  links lead to them.
"""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
# Pages whose text is a file beside docs/.
BESIDE = {
    "development/contributing": "CONTRIBUTING.md",
    "development/changelog": "CHANGELOG.md",
    "development/security": "SECURITY.md",
}
COMMENT = re.compile(r"^<!-- .*? -->\n", re.M)
FENCED = re.compile(r"(^```.*?^```$)", re.M | re.S)
# Languages of blocks: sessions have colours of their own, tables need none.
SESSION = re.compile(r"^```(?:text)?\n(?=\$ )")
TABLE = re.compile(r"^```csv\n")


def adapt(app: Sphinx, docname: str, source: list[str]) -> None:
    """Change the text of a page before it is parsed."""
    if not str(app.env.doc2path(docname)).endswith(".md"):
        return
    text = source[0]
    if docname in BESIDE:
        path = ROOT / BESIDE[docname]
        app.env.note_dependency(str(path))
        text = path.read_text(encoding="utf-8").replace("](docs/", "](/")
    parts = FENCED.split(text)
    parts[::2] = [adapted_text(part) for part in parts[::2]]
    parts[1::2] = [adapted_block(part) for part in parts[1::2]]
    source[0] = "".join(parts)


def adapted_text(text: str) -> str:
    """Text between blocks, without comments and with the links of the site."""
    for page, name in BESIDE.items():
        text = re.sub(rf"\]\((?:\.\./)*{re.escape(name)}", f"](/{page}.md", text)
    return COMMENT.sub("", text)


def adapted_block(block: str) -> str:
    """Block with a language that the site knows."""
    return TABLE.sub("```text\n", SESSION.sub("```console\n", block))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("source-read", adapt)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""What the docstrings of the project need on their way into the site."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx


def keep_first_line(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    """Keep what Napoleon would take for a type: words before a colon in the first line."""
    if what in ("property", "attribute") and lines:
        lines[0] = re.sub(r"(?<!:):(?= )", " –", lines[0], count=1)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, before Napoleon."""
    app.connect("autodoc-process-docstring", keep_first_line, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

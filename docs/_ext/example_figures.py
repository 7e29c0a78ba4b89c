"""Figures of the examples for the gallery.

An example draws into the file that is its first argument. For the gallery it is given one, which
is moved to where the gallery keeps its pictures.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

FOLDER = Path(tempfile.mkdtemp(prefix="example-figures-"))


def figure_file(gallery_conf: dict[str, Any], script_vars: dict[str, Any]) -> list[str]:
    """Arguments of an example: the file for its figure."""
    return [str(FOLDER / f"{Path(script_vars['src_file']).stem}.png")]


def scrape_figure(
    block: tuple[Any, ...], block_vars: dict[str, Any], gallery_conf: dict[str, Any]
) -> str:
    """Move the figure that a block of an example has drawn; return how to show it."""
    drawn = FOLDER / f"{Path(block_vars['src_file']).stem}.png"
    if not drawn.exists():
        return ""
    shown = next(block_vars["image_path_iterator"])
    shutil.move(drawn, shown)
    return figure_rst([shown], gallery_conf["src_dir"])

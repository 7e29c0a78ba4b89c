"""Rows of the tables that the package brings as data."""

from __future__ import annotations

import csv
from importlib import resources


def data_rows(name: str) -> list[dict[str, str]]:
    """Return the rows of ``data/NAME.csv`` by its heads; lines from ``#`` on are comments."""
    text = (resources.files("sizing") / "data" / f"{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))

"""Rows of the tables that the packages bring as data."""

from __future__ import annotations


def data_rows(name: str, package: str) -> list[dict[str, str]]:
    """Return the rows of ``data/NAME.csv`` of a package by its heads.

    Lines from ``#`` on are comments.
    """
    import csv  # which a page of help does not need
    from importlib import resources

    text = (resources.files(package) / "data" / f"{name}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))

"""Versions of the software and of its files' format, and deprecated names.

The format version changes when a file of an earlier version would be read wrongly or refused. It
is the same for aircraft and mission files and for results, and stands in each of them as
``format_version``; a file without one is of format 1.
"""

from __future__ import annotations

from typing import Any

from solar._version import __version__

FORMAT_KEY, FORMAT_VERSION = "format_version", 1


def format_trouble(version: object) -> str | None:
    """Return the reason why a file's format version cannot be read, else None."""
    if type(version) is not int or version < 1:
        allowed = "1" if FORMAT_VERSION == 1 else f"a whole number from 1 to {FORMAT_VERSION}"
        return f"must be {allowed} (got {ascii(version)[:60]})"
    if version > FORMAT_VERSION:
        return (
            f"must be at most {FORMAT_VERSION} (got {ascii(version)[:60]}): the file is of a newer "
            f"version of solar-uav than this one, {__version__}; install a newer one"
        )
    return None


class DeprecatedKeyWarning(FutureWarning):
    """File with a key whose name a later version refuses."""


def deprecation(new: str) -> str:
    """Return the words behind a deprecated name: the new name, and when the old one ends."""
    next_major = int(__version__.partition(".")[0]) + 1
    return f"is called '{new}' now; version {next_major}.0 refuses the old name"


def software_record() -> dict[str, Any]:
    """Return the versions of software and format, for results."""
    return {"version": __version__, FORMAT_KEY: FORMAT_VERSION}

"""Attacks by faults: signals, full disks, folders that vanish, damaged files, dead workers."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.reliability.record import Row

__all__ = ["attacks"]


def attacks(count: int | None, seed: int, only: str) -> Iterator[Row]:
    """Run the cases kind by kind.

    Parameters
    ----------
    count : int or None
        Cases of each kind; None for as many as the page is made of.
    seed : int
        Of the cases that are drawn.
    only : str
        Text that the name of a kind must hold.

    Yields
    ------
    Row
    """
    yield from ()

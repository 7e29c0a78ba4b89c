"""Attacks by wrong inputs: files, options and requests that are changed at random.

Valid inputs are taken apart and changed, as data, as text and as bytes, and given to the command in
this process. A case holds if the command ends with exit code 0, 1 or 2 within 10 s of processor
time and a gigabyte of memory, says why where it refuses, prints no traceback, no warning of a
library and no control character, and where it accepts, prints no NaN and no infinity as a result
and writes whole files. ``python -m benchmarks.reliability.inputs KIND NUMBER`` repeats one case.
"""

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
    from benchmarks.reliability.inputs.campaign import KINDS, campaign

    for found in campaign([name for name in KINDS if only in name], count, seed):
        failed = f", {found.failed} failed" if found.failed else ""
        yield Row(
            found.kind.reader,
            found.kind.attack,
            found.cases,
            found.cases - len(found.broken),
            found.broken[:10],
            f"{found.accepted} accepted, {found.refused} refused{failed}; longest "
            f"{found.longest_s:.1f} s, {found.peak_mb} MB",
        )

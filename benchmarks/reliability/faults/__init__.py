"""Attacks by faults: signals, full disks, folders that vanish, damaged files, dead workers.

Linux alone: processes are found in ``/proc``, small disks are mounted where the user may do so.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator

import click

from benchmarks.reliability.faults import chunks, places, stops, workers
from benchmarks.reliability.faults.processes import own_folder
from benchmarks.reliability.record import Row, of_cases

__all__ = ["attacks"]

_KINDS = (stops, places, chunks, workers)


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
    for module in _KINDS:
        for fault in module.faults():
            name = f"{fault.subject}: {fault.attack}"
            if only not in name:
                continue
            found = []
            numbers = range(count or fault.cases)
            # Hundreds of cases take an hour: what breaks is told at once, besides in the record.
            with click.progressbar(numbers, label=name, file=sys.stderr) as bar:
                for number in bar:
                    rng = random.Random(f"{seed}/{name}/{number}")
                    with own_folder() as folder:
                        wrong = fault.case(rng, folder)
                    found.append(None if wrong is None else f"{name}, case {number}: {wrong}")
                    if found[-1] is not None:
                        click.echo(found[-1], err=True)
            yield of_cases(fault.subject, fault.attack, found)

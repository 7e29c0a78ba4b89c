"""What a case is: files in a folder of its own, a command line, and what may come out."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

__all__ = ["Case", "Maker", "rng_of"]


@dataclass(frozen=True)
class Case:
    """A call of ``solar-uav`` in a folder of its own.

    Attributes
    ----------
    arguments : tuple of str
        What follows ``solar-uav``.
    files : mapping
        Content of the files of the folder, by their path in it.
    links : mapping
        Symbolic links of the folder: target by path.
    environment : mapping
        Variables that are set, by name.
    json : bool
        Whether what is printed must be strict JSON where the command succeeds.
    outputs : tuple of str
        Files that must be there, whole, where the command succeeds, and not where it does not.
    """

    arguments: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)
    environment: Mapping[str, str] = field(default_factory=dict)
    json: bool = False
    outputs: tuple[str, ...] = ()


Maker: TypeAlias = Callable[[random.Random], Case]


def rng_of(seed: int, kind: str, number: int) -> random.Random:
    """Source of chance of one case, so that each can be repeated by itself.

    Parameters
    ----------
    seed : int
        Of the campaign.
    kind : str
        Name of the kind of input.
    number : int
        Of the case, from 0.

    Returns
    -------
    random.Random
    """
    return random.Random(f"{seed}/{kind}/{number}")

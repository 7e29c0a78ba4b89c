"""Axes of a trade study: varied keys of the files, their values, and the study's points."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.files.errors import did_you_mean
from sizing.catalogues.choice import Kind, documents
from sizing.library import NAMED_KEYS
from sizing.parameters import MISSION_PREFIX, catalogue, design_keys
from solar.schema import refusal, significant, spell

SampleName = Literal["grid", "lhs", "sobol", "one-at-a-time"]
SAMPLE_NAMES: tuple[SampleName, ...] = ("grid", "lhs", "sobol", "one-at-a-time")

MAXIMUM_POINTS = 1_000_000
_MAXIMUM_VALUES = 10_000

# Design variables: their short names, and the keys of the aircraft file.
DESIGN_KEYS = design_keys()
DESIGN_VARIABLES = {key: name for name, key in DESIGN_KEYS.items()}

_NAMED_LABELS: dict[Kind, str] = {
    "cells": "solar cell",
    "batteries": "battery",
    "motors": "motor",
    "propellers": "propeller",
    "mppts": "MPPT",
}

# Units of keys outside the parameters' catalogue, by their endings; longer ones first.
_UNITS = {
    "_wh_per_kg": "Wh/kg",
    "_kg_per_m2": "kg/m²",
    "_kg_per_m3": "kg/m³",
    "_kg_per_w": "kg/W",
    "_m_per_s": "m/s",
    "_per_k": "1/K",
    "_per_h": "1/h",
    "_m2": "m²",
    "_kg": "kg",
    "_wh": "Wh",
    "_deg": "deg",
    "_m": "m",
    "_w": "W",
    "_h": "h",
    "_c": "°C",
    "_k": "K",
    "_v": "V",
    "_a": "A",
}


@dataclass(frozen=True)
class Axis:
    """Varied key.

    ``key``: key of the aircraft file, or of the mission file behind ``mission.``. ``values``: its
    values, or the two ends of a range without a step, ``is_range``. ``names``: entries of a
    catalogue, whose indices are the values; empty for numbers.
    """

    key: str
    values: tuple[float, ...]
    is_range: bool = False
    names: tuple[str, ...] = ()

    @property
    def design_variable(self) -> str | None:
        """Short name of the varied design variable, None for other keys."""
        return DESIGN_VARIABLES.get(self.key)


def unit_of(key: str) -> str:
    """Return the CF unit of a key, by the catalogue, else by its ending, 1 without."""
    known = catalogue().get(key)
    if known is not None:
        return cf_unit(known.unit)
    return next((cf_unit(unit) for ending, unit in _UNITS.items() if key.endswith(ending)), "1")


def axis_label(key: str) -> str:
    """Return a key in words: the catalogue's label, else its name without the unit."""
    if key in NAMED_KEYS:
        return _NAMED_LABELS[NAMED_KEYS[key]]
    known = catalogue().get(key)
    return without_unit(_short(key)).replace("_", " ") if known is None else known.label


def cf_unit(unit: str) -> str:
    """Return a unit in CF spelling: ``W h kg-1`` for ``Wh/kg``."""
    plain = unit.translate({ord("²"): "2", ord("³"): "3", ord("°"): "deg"})
    above, _, below = re.sub(r"Wh\b", "W h", plain).partition("/")
    divided = re.sub(r"([A-Za-z]+)(\d*)", lambda m: f"{m[1]}-{m[2] or 1}", below)
    above = {"deg": "degree", "1": "" if divided else "1"}.get(above, above)
    return f"{above} {divided}".strip()


def unit_label(unit: str) -> str:
    """Return a CF unit as readers write it: ``Wh/kg`` for ``W h kg-1``."""
    return _LABELS.get(unit, unit)


_LABELS = {cf_unit(label): label for label in _UNITS.values()} | {"degrees_north": "deg N"}


def without_unit(name: str) -> str:
    """Return a name without the unit that it ends in."""
    return next((name.removesuffix(end) for end in _UNITS if name.endswith(end)), name)


def axis_names(axes: Sequence[Axis]) -> list[str]:
    """Return the names of axes in results: the end of the key, as far as needed to be unique."""
    short = [axis.design_variable or _short(axis.key) for axis in axes]
    whole = [axis.key.replace(".", "_") for axis in axes]
    return [
        name if short.count(name) == 1 else full for name, full in zip(short, whole, strict=True)
    ]


def _short(key: str) -> str:
    """Return the last part of a key, behind the part before it if a single word."""
    *before, last = key.removeprefix(MISSION_PREFIX).split(".")
    return last if "_" in without_unit(last) or not before else f"{before[-1]}_{last}"


def axes_of(vary: Mapping[str, ArrayLike]) -> list[Axis]:
    """Make axes from values by key, see :func:`studies.sweeps.study.sweep`."""
    axes = []
    for key, values in vary.items():
        if key.removeprefix("aircraft.") in NAMED_KEYS:
            axes.append(_named_axis(key, [str(name) for name in np.atleast_1d(np.asarray(values))]))
            continue
        numbers = np.atleast_1d(np.asarray(values))
        if numbers.dtype.kind not in "iuf" or numbers.ndim != 1 or not np.isfinite(numbers).all():
            raise ValueError(f"{key} needs a list of finite numbers")
        axes.append(_axis(key, tuple(float(number) for number in numbers)))
    return axes


def _axis(
    key: str, values: tuple[float, ...], *, is_range: bool = False, names: tuple[str, ...] = ()
) -> Axis:
    full = DESIGN_KEYS.get(key, key.removeprefix("aircraft."))
    if not values:
        raise ValueError(f"{key} needs values")
    if len(set(names or values)) < len(values):
        raise ValueError(f"{key} has a value twice")
    return Axis(full, values, is_range, names)


def _named_axis(key: str, entries: Sequence[str]) -> Axis:
    """Make an axis over entries of a catalogue."""
    names = tuple(name.strip() for name in entries)
    allowed = list(documents(NAMED_KEYS[key.removeprefix("aircraft.")]))
    for name in names:
        if name not in allowed:
            meant = did_you_mean(name, allowed, 3, 0.5)
            raise ValueError(f"{key}: no entry of the catalogue is called {name[:40]!r}{meant}")
    return _axis(key, tuple(map(float, range(len(names)))), names=names)


def shown_value(axis: Axis, value: float) -> Any:
    """Return a value as results show it: a number, or a name; empty for -1, the file's name."""
    if not axis.names:
        return value
    return axis.names[int(value)] if value >= 0.0 else ""


def parse_axis(text: str) -> Axis:
    """Read ``KEY=first:last:step``, ``KEY=first:last`` or ``KEY=v1,v2,...``.

    Keys that name an entry of a catalogue take names: ``modules.cell=sunpower-c60,sunpower-e60``.

    Steps begin at ``first`` and do not lead beyond ``last``.
    """
    key, equals, values = text.partition("=")
    key = key.strip().removeprefix("aircraft.")
    if not (key and equals and values.strip()):
        raise ValueError("write KEY=first:last:step or KEY=v1,v2, e.g. battery_mass_kg=1:5:0.5")
    if key in NAMED_KEYS:
        return _named_axis(key, values.split(","))
    if ":" in values:
        numbers = [_read_number(part) for part in values.split(":")]
        return _axis(key, _stepped(key, numbers), is_range=len(numbers) == 2)
    return _axis(key, tuple(_read_number(part) for part in values.split(",")))


def _read_number(text: str) -> float:
    # Python's notations, such as 1_000 or inf, are refused.
    if not re.fullmatch(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", text):
        raise ValueError(f"{text.strip()!r} is not a number")
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text.strip()!r} is too large")
    return number


def _stepped(key: str, numbers: Sequence[float]) -> tuple[float, ...]:
    if len(numbers) not in (2, 3):
        raise ValueError(f"{key} needs first:last:step, or first:last where samples are drawn")
    first, last = numbers[:2]
    if len(numbers) == 2:
        if not first < last:
            got = f"{spell(first)}:{spell(last)}"
            raise ValueError(refusal(f"{key} must rise from first to last", got))
        return first, last
    step = numbers[2]
    if not (first <= last and step > 0.0):
        raise ValueError(f"{key} must rise from first to last by a positive step")
    count = (last - first) / step + 1e-9
    if count >= _MAXIMUM_VALUES:
        raise ValueError(f"{key} has more than {_MAXIMUM_VALUES} values")
    # Rounded, so that 0.1 steps are 0.3 and not 0.30000000000000004.
    return tuple(significant(first + i * step, 12) for i in range(int(count) + 1))


def points(
    axes: Sequence[Axis],
    sample: SampleName,
    *,
    base: Sequence[float] | None = None,
    samples: int = 0,
    seed: int = 0,
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return a study's points, shape ``(point, axis)``, and the axis each varies (-1 for all).

    ``sample``: all combinations of values; a Latin hypercube or a scrambled Sobol sequence between
    least and largest values; or the base, then every value of each axis with the others at the
    base. ``samples``, ``seed``: number of drawn points, and seed of the generator.

    McKay, M. D., Beckman, R. J. and Conover, W. J. (1979), Technometrics 21, 239-245 (Latin
    hypercube); Owen, A. B. (1998), Journal of Complexity 14, 466-489 (scrambled Sobol sequence).
    """
    if sample == "grid":
        for axis in axes:
            if axis.is_range:
                raise ValueError(f"{axis.key} needs a step: first:last:step")
        count = math.prod(len(axis.values) for axis in axes)
        if count > MAXIMUM_POINTS:
            raise ValueError(f"the grid has {count} points, at most {MAXIMUM_POINTS} are allowed")
        grid = np.array(list(itertools.product(*(axis.values for axis in axes))), float)
        return grid, np.full(count, -1)
    if sample == "one-at-a-time":
        assert base is not None
        pairs = [(index, value) for index, axis in enumerate(axes) for value in axis.values]
        rows = [[*base[:index], value, *base[index + 1 :]] for index, value in pairs]
        return np.array([base, *rows], float), np.array([-1, *(index for index, _ in pairs)])
    if not 1 <= samples <= MAXIMUM_POINTS:
        raise ValueError(f"the number of samples must be from 1 to {MAXIMUM_POINTS}")
    from scipy.stats import qmc

    for axis in axes:
        if axis.names:
            raise ValueError(f"{axis.key} has names, of which none can be drawn between two others")
        if len(axis.values) < 2:
            raise ValueError(f"{axis.key} needs a range to draw samples from, first:last")
    low, high = (np.array([end(axis.values) for axis in axes]) for end in (min, max))
    generator = np.random.default_rng(seed)
    if sample == "lhs":
        unit = qmc.LatinHypercube(len(axes), rng=generator).random(samples)
    else:
        # A power of two keeps the sequence balanced; a part of it is still even.
        exponent = max(math.ceil(math.log2(samples)), 0)
        unit = qmc.Sobol(len(axes), rng=generator).random_base2(exponent)[:samples]
    return low + unit * (high - low), np.full(samples, -1)

"""Values of options: numbers of a range, grids, names, what a function of a study reads."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any

import click

from studies.cli.telling import tell_error
from studies.output.formats import format_of, missing_writer, wrong_ending

PAGE, PRINTED = ".html", ".pdf"  # endings of a report
_MAXIMUM_GRID = 2000  # numbers of first:last:step
_DECIMAL = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_LATITUDE = re.compile(rf"({_DECIMAL}) *°? *([ns])|([+-]?{_DECIMAL}) *°", re.IGNORECASE)


class OutputFile(click.Path):
    """File that a command writes; it is checked before any work is done for it.

    ``formats``: those that its name may ask for, ``without_ending`` one without an ending.
    """

    def __init__(self, *formats: str, without_ending: str = "") -> None:
        super().__init__()
        self.formats, self._without_ending = formats, without_ending

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse the name of a file in a format that cannot be written."""
        if value and self.formats and param is not None:
            kind = format_of(value, self.formats, self._without_ending)
            missing = missing_writer(kind)
            if kind is None:
                missing = wrong_ending(value, self.formats)
            if missing is not None:
                raise click.BadParameter(missing, param_hint=param.opts[0])
        return super().convert(value, param, ctx)


class OutputFolder(click.Path):
    """Folder that a command writes; it is checked before any work is done for it."""


class Parsed(click.ParamType):  # type: ignore[type-arg]  # click before 8.4 takes none
    """Values that a function reads, which takes text, and raises ValueError.

    ``reader``: the function, or ``package.module:function``, which is imported when there is a
    value. ``stepped``: reads the ends of ``first:last:step``, where a value may have that; a note
    on standard error says where the steps end, if not at ``last``.
    """

    def __init__(
        self,
        name: str,
        reader: str | Callable[[str], Any],
        *,
        stepped: Callable[[str], float] | None = None,
    ) -> None:
        self.name, self._reader, self._stepped = name, reader, stepped

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read a value."""
        try:
            reader = self._reader
            converted = (resolve_name(reader) if isinstance(reader, str) else reader)(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)
        if self._stepped and str(value).count(":") == 2:
            reached = getattr(converted, "values", converted)[-1]
            last = self._stepped(str(value).split(":")[1])
            if abs(reached - last) > 1e-9 * max(abs(reached), abs(last)):
                written = f"{param.opts[0] if param else ''} {value}".strip()
                text = f"{written} stops at {reached:g}, the last step before {last:g}"
                tell_error(f"solar-uav: {text}")
        return converted


def latitude_deg(text: str) -> float:
    """Return the latitude [deg] of a text as :func:`degrees` reads it; from -90 to 90."""
    number = degrees(text)
    if not -90.0 <= number <= 90.0:
        raise ValueError(f"must be from -90 to 90 (got {text})")
    return number


def degrees(text: str) -> float:
    """Return degrees, north positive, of ``-33.9``, ``-33.9°`` or ``33.9S``.

    Another text is a ValueError.
    """
    match = _LATITUDE.fullmatch(text.strip())
    try:
        if "_" in text:  # Python's own notation, nobody's latitude
            raise ValueError
        number = float((match[1] or match[3]) if match else text)
    except ValueError:
        raise ValueError(
            f"{text!r} is not a number of degrees; north is positive, or written 47.6N, 33.9S"
        ) from None
    return -number if match and match[2] in ("s", "S") else number


def grid(
    lowest: float, highest: float, *, whole: bool = False, read: Callable[[str], float] = float
) -> Parsed:
    """Return the type of numbers ``first:last:step``, or one; they do not go beyond last.

    ``whole``: whether they are whole numbers. ``read``: reads the ends.
    """

    def numbers(text: str) -> list[float]:
        try:
            ends: list[str] = text.split(":")
            start, end, by = [*ends, *ends, "1"] if len(ends) == 1 else ends
            first, last, step = read(start), read(end), float(by)
        except ValueError:
            example = "first:last:step, for example -70:70:2"
            raise ValueError(f"{text!r} is no number and not {example}") from None
        # NaN is no number that rises, and a step without end none that could be added.
        if not (lowest <= first <= last <= highest and 0.0 < step < math.inf):
            within = f"{lowest:g} to {highest:g}"
            raise ValueError(f"must rise within {within} by a positive step (got {text})")
        if whole and not (first.is_integer() and step.is_integer()):
            raise ValueError(f"takes whole numbers (got {text})")
        steps = (last - first) / step + 1e-9
        if steps >= _MAXIMUM_GRID:
            raise ValueError(f"has more than the {_MAXIMUM_GRID} numbers that are allowed")
        return [first + i * step for i in range(int(steps) + 1)]

    return Parsed("first:last:step", numbers, stepped=read)


class RealRange(click.FloatRange):
    """Numbers of a range; unlike click's own it refuses NaN, which passes every comparison.

    ``unit``: in words, as help has it in place of a value. ``above``, ``below``: whether numbers
    must lie above the lowest, and below the highest.
    """

    def __init__(
        self, lowest: float, highest: float, *, unit: str, above: bool = False, below: bool = False
    ) -> None:
        super().__init__(lowest, highest, min_open=above, max_open=below)
        self.name = unit

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the number, and check its range."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if math.isnan(number):
            text = f"must be a number of {self.name}, written without a unit (got {value})"
            self.fail(text, param, ctx)
        super().convert(number, param, ctx)
        return number


def names_of(allowed: tuple[str, ...]) -> Parsed:
    """Return the type of names separated by commas, in their usual order, without repetition."""

    def read(text: str) -> tuple[str, ...]:
        by_lower, names = {name.lower(): name for name in allowed}, []
        for part in map(str.strip, text.split(",")):
            if part.lower() not in by_lower:
                raise ValueError(f"{part!r} is not one of {', '.join(allowed)}")
            names.append(by_lower[part.lower()])
        return tuple(name for name in allowed if name in names)

    return Parsed("a,b", read)

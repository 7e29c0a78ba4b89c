"""Columns of a log: what each holds, by a file, by options, or guessed from the names.

A :class:`Recipe` says how a quantity of the log format is made of a log's columns; guesses go
into the notes.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, PlainValidator

from missions.files.errors import printable, shortened, shown
from missions.files.validation import unknown_key, validate
from missions.files.yaml import read_yaml
from missions.logs.clock import Span, parse_instant, parse_span, parse_zone
from missions.logs.units import (
    ATTITUDE,
    EPOCH,
    MPPT,
    QUANTITIES,
    TIME,
    split_unit,
)
from missions.units import SCALES, SPELLED, known_unit, spellings
from solar.schema import Real, Record, Text
from solar.types import FloatArray

# Place of an MPPT's modules on the wing, in the name of its column.
_PLACE = re.compile(r"[ _.-]?(?:left|right|cent(?:re|er)|front|rear|inner|outer)", re.IGNORECASE)
# Factors of the power, never a column of the result.
_PARTS = ("solar_voltage_v", "solar_current_a")
# Words in brackets behind a time that are no unit.
_ZONES = ("UTC", "Z", "GMT", "ISO", "LOCAL", "UNIX")


class Source(Record):
    """Origin of a quantity: a column, a sum of products of columns, or a constant ``value``."""

    name: Text | None = None
    unit: Text | None = None
    factor: Real = 1.0
    value: Real | None = None
    format: Text | None = None


class ColumnMap(Record):
    """Layout of a log from a YAML file or options; what neither says is guessed."""

    separator: Literal[",", ";", "\t", "|", "tab", "comma", "semicolon"] | None = None
    decimal: Literal[".", ","] | None = None
    timezone: Annotated[datetime.tzinfo, PlainValidator(parse_zone)] | None = None
    start: Annotated[float, PlainValidator(parse_instant)] | None = None
    columns: Mapping[str, Text | Source] = Field(default_factory=dict)
    ignore: tuple[Text, ...] = ()
    exclude: tuple[Annotated[Span, PlainValidator(parse_span)], ...] = ()

    def with_options(
        self,
        columns: Mapping[str, str],
        timezone: datetime.tzinfo | None = None,
        start: float | None = None,
        ignore: Sequence[str] = (),
        exclude: Sequence[Span] = (),
    ) -> ColumnMap:
        """Return the map with options of the command line, which precede the file.

        Parameters
        ----------
        columns, timezone, start, ignore, exclude
            As the keys of a map: the first three replace its values, the others add to them.

        Returns
        -------
        ColumnMap
        """
        changes: dict[str, Any] = {"columns": {**self.columns, **columns}}
        changes |= {n: v for n, v in (("timezone", timezone), ("start", start)) if v is not None}
        changes |= {"ignore": (*self.ignore, *ignore), "exclude": (*self.exclude, *exclude)}
        return self.model_copy(update=changes)


def read_column_map(path: str) -> ColumnMap:
    """Read a ``--columns`` file.

    Raises
    ------
    InputError
        With the line of every mistake.
    """
    return validate(read_yaml(path), ColumnMap)


def parse_column(text: str) -> tuple[str, str]:
    """Read ``QUANTITY=COLUMN`` of the command line."""
    quantity, sign, column = text.partition("=")
    quantity, column = quantity.strip(), column.strip()
    if not sign or not column:
        raise ValueError(f"must be QUANTITY=COLUMN, such as 'solar_power_w=P [kW]' (got {text!r})")
    if quantity not in QUANTITIES:
        known = unknown_key(quantity, list(QUANTITIES), "no such quantity")
        raise ValueError(f"{shortened(printable(quantity))}: {known}")
    return quantity, column


def column_name(text: str) -> str:
    """Return the name of a column, refused if blank."""
    if not text.strip():
        raise ValueError(f"must be the name of a column or quantity (got {shown(text)})")
    return text


class Factor(NamedTuple):
    """Column of the log with its unit, None where unknown."""

    column: str
    unit: str | None


@dataclass(frozen=True)
class Recipe:
    """Sum over ``terms`` of products of columns; ``guessed`` if no file or option named it."""

    quantity: str
    terms: tuple[tuple[Factor, ...], ...] = ()
    factor: float = 1.0
    value: float | None = None
    form: str | None = None
    guessed: bool = False

    @property
    def columns(self) -> list[str]:
        """Columns of the log that are read."""
        return [factor.column for term in self.terms for factor in term]

    @property
    def plain(self) -> bool:
        """True for a column that has the name and unit of the log format."""
        return self.columns == [self.quantity] and self.factor == 1.0 and self.unit is None

    @property
    def unit(self) -> str | None:
        """Unit of the only column; None for several columns or an unknown unit."""
        return self.terms[0][0].unit if self.single else None

    @property
    def single(self) -> bool:
        """True for a quantity that is read from one column."""
        return len(self.terms) == 1 and len(self.terms[0]) == 1

    def text(self) -> str:
        """Return the recipe as a line of text, units in brackets where known."""

        def with_unit(factor: Factor) -> str:
            if factor.unit is None or split_unit(factor.column)[1] is not None:
                return factor.column
            return f"{factor.column} [{SPELLED[factor.unit]}]"

        text = " + ".join(" * ".join(map(with_unit, term)) for term in self.terms)
        return f"{self.quantity} = {printable(text)}"

    def values(
        self, column: Callable[[str], FloatArray], unit: str | None = None
    ) -> dict[str, FloatArray]:
        """Return the quantity in the unit of the log format, and the power of several MPPTs.

        ``unit``: unit of the only column, where its name has none.
        """
        parts = []
        for term in self.terms:
            product: Any = self.factor
            for factor in term:
                scale = SCALES[factor.unit or unit]
                product = product * (scale.factor * column(factor.column) + scale.offset)
            parts.append((" * ".join(factor.column for factor in term), np.asarray(product, float)))
        every = {self.quantity: np.asarray(sum(values for _, values in parts), float)}
        if self.quantity == "solar_power_w" and len(parts) > 1:
            every |= {MPPT + name: values for name, values in parts}
        return every


class Recipes(NamedTuple):
    """Recipes by quantity, names of unused columns, and messages of what is wrong."""

    by_quantity: dict[str, Recipe]
    unused: list[str]
    problems: list[str]


def recipes_for(
    header: Sequence[str], layout: ColumnMap | None = None, *, guess: bool = True
) -> Recipes:
    """Find a recipe for each quantity of the log format, by layout, else by name."""
    recipes: dict[str, Recipe] = {}
    problems: list[str] = []
    layout = layout or ColumnMap()
    header = [name for name in header if name not in layout.ignore]
    for quantity, source in layout.columns.items():
        try:
            recipes[quantity] = _recipe_of_source(quantity, source, header)
        except ValueError as error:
            problems.append(str(error))
    taken = {column for recipe in recipes.values() for column in recipe.columns}
    for quantity in [name for name in QUANTITIES if guess and name not in recipes]:
        # The exact name comes first, then the likeliest of the other ones.
        names = [quantity, *((TIME, EPOCH) if quantity == "time" else ())]
        free = [name for name in header if name not in taken]
        exact = next((Factor(name, None) for name in names if name in free), None)
        alike = [_match_alias(quantity, name) for name in free if name not in QUANTITIES]
        known = [match for match in alike if match is not None]
        if exact is not None or known:
            column = exact or min(known, key=lambda match: match[0])[1]
            recipes[quantity] = Recipe(quantity, ((column,),), guessed=exact is None)
            if quantity not in _PARTS:  # one voltage may serve the power and itself
                taken.add(column.column)
    if guess and "solar_power_w" not in recipes:
        # The sum of the power of several MPPTs whose columns differ by number or place.
        groups: dict[str, list[Factor]] = {}
        for name in header:
            base = split_unit(name)[0]
            numbers, places = re.findall(r"\d+", base), _PLACE.findall(base)
            stem = _PLACE.sub("", re.sub(r"[ _.]?\d+", "", name, count=1))
            match = _match_alias("solar_power_w", stem)
            if name not in taken and match is not None and (len(numbers) == 1 or places):
                groups.setdefault(stem, []).append(match[1]._replace(column=name))
        factors = max(groups.values(), key=len, default=[])
        if len(factors) > 1:
            terms = tuple((column,) for column in factors)
            recipes["solar_power_w"] = Recipe("solar_power_w", terms, guessed=True)
    # Power from voltage and current, if it has no column.
    volts, amps = (recipes.pop(part, None) for part in _PARTS)
    if amps is not None and volts is None:
        volts = recipes.get("mppt_voltage_v")
    pair = [recipe.terms[0][0] for recipe in (volts, amps) if recipe is not None and recipe.single]
    if "solar_power_w" not in recipes and len(pair) == 2:
        recipes["solar_power_w"] = Recipe("solar_power_w", (tuple(pair),), guessed=True)
    for quantity in layout.ignore:
        recipes.pop(quantity, None)
    # Drop guessed angles unless there are all three: a course alone is no attitude.
    angles = [name for name in ATTITUDE if name in recipes]
    unwanted = any(name in layout.ignore for name in ATTITUDE)
    if len(angles) < len(ATTITUDE) and (unwanted or all(recipes[n].guessed for n in angles)):
        for name in angles:
            del recipes[name]
    used = {column for recipe in recipes.values() for column in recipe.columns}
    return Recipes(recipes, [name for name in header if name not in used], problems)


def _recipe_of_source(quantity: str, named_source: str | Source, header: Sequence[str]) -> Recipe:
    """Make the recipe of a quantity that the layout names."""
    key = f"columns.{shortened(printable(quantity))}"
    if quantity not in QUANTITIES:
        raise ValueError(f"{key}: {unknown_key(quantity, list(QUANTITIES), 'unknown quantity')}")
    source = Source(name=named_source) if isinstance(named_source, str) else named_source
    if source.value is not None:
        if source.name is not None:
            raise ValueError(f"{key}: give a name or a value, not both")
        return Recipe(quantity, value=source.factor * source.value)
    if source.name is None:
        raise ValueError(f"{key}: needs the name of a column, or a value")
    texts = [source.name] if source.name in header else source.name.split(" + ")
    terms = tuple(_read_product(key, quantity, text, header) for text in texts)
    if source.unit is not None:
        if len(terms) != 1 or len(terms[0]) != 1:
            raise ValueError(f"{key}: in a sum or product the unit stands behind each column")
        dimension = QUANTITIES[quantity].dimension
        terms = ((Factor(terms[0][0].column, _allowed_unit(key, source.unit, dimension)),),)
    return Recipe(quantity, terms, factor=source.factor, form=source.format)


def _read_product(key: str, quantity: str, text: str, header: Sequence[str]) -> tuple[Factor, ...]:
    """Read a product of columns, each with or without a unit behind it."""
    parts = [text.strip()] if text.strip() in header else text.strip().split(" * ")
    if len(parts) > 2:
        raise ValueError(f"{key}: a product is that of a voltage and a current (got {shown(text)})")
    alone: tuple[str, ...] = (QUANTITIES[quantity].dimension,)
    dimensions = alone if len(parts) == 1 else ("voltage", "current")
    factors = []
    for part in map(str.strip, parts):
        name, unit = (part, None) if part in header else split_unit(part)
        if name not in header:
            raise ValueError(f"{key}: {unknown_key(part, header, 'no such column')}")
        if unit is not None:
            unit = _allowed_unit(key, unit, *dimensions)
        elif name != quantity:  # the unit that ends the column's name
            base, bracketed = split_unit(name)
            words = _words_of_name(base)
            tails = (
                sign.join(words[-n:]) for n in (3, 2, 1) for sign in ("_", "") if len(words) > n
            )
            units = (known_unit(end or "", *dimensions) for end in (bracketed, *tails))
            unit = next((known for known in units if known is not None), None)
        factors.append(Factor(name, unit))
    return tuple(factors)


def _allowed_unit(key: str, text: str, *dimensions: str) -> str:
    """Return the spelling of a unit in ``UNITS``, refused if of other dimensions."""
    if (unit := known_unit(text, *dimensions)) is not None:
        return unit
    raise ValueError(f"{key}: unknown unit {shown(text)}; allowed: {spellings(*dimensions)}")


def _words_of_name(name: str) -> list[str]:
    """Split a name, also in camel case, into words in lower case."""
    apart = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return re.findall(r"[a-z0-9%°µ]+", apart.lower())


def _match_alias(quantity: str, name: str) -> tuple[int, Factor] | None:
    """Return the rank of a name among a quantity's aliases, and the column with its unit."""
    dimension, aliases = QUANTITIES[quantity].dimension, QUANTITIES[quantity].aliases.split()
    base, bracketed = split_unit(name)
    unit = None if bracketed is None else known_unit(bracketed, dimension)
    zone = quantity == "time" and bracketed is not None and bracketed.upper() in _ZONES
    if bracketed and unit is None and not zone:
        return None  # a unit of something else
    words = _words_of_name(base)
    for count in range(min(4, len(words))):
        tail = words[len(words) - count :]
        stem = "".join(words[: len(words) - count])
        if stem in aliases:
            # A unit in camel case, mA, is two words.
            spellings = [known_unit(sign.join(tail), dimension) for sign in ("_", "")]
            named = next((unit for unit in spellings if unit is not None), None)
            if count == 0 or named is not None:
                return aliases.index(stem), Factor(name, unit or named)
    return None

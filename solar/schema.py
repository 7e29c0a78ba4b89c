"""Field types shared by every description of an aircraft or a mission."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from itertools import pairwise
from keyword import iskeyword
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self, TypeGuard

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    Strict,
    model_validator,
)
from pydantic_core import PydanticCustomError

from solar.versions import FORMAT_VERSION, format_trouble

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

_HASH = "_hash"
_UNCHECKED = "_changed_copy"


# ---- Words of refusals


def spell(value: float, digits: int = 6) -> str:
    """Spell a number in a text, to a number of significant digits."""
    return f"{value:.{digits}g}"


def spell_ends(values: Iterable[float], digits: int = 6) -> str:
    """Spell the least and the largest of some numbers, once if they are equal."""
    every = list(values)
    return " to ".join(dict.fromkeys(spell(end, digits) for end in (min(every), max(every))))


def significant(value: float, digits: int = 6) -> float:
    """Round a number to a number of significant digits."""
    return float(spell(value, digits))


def refusal(message: str, got: object) -> str:
    """Return what is allowed, with the value in its place: texts as they are to be shown."""
    return f"{message} (got {spell(got) if isinstance(got, float) else got})"


class Allowed(NamedTuple):
    """Allowed numbers, both for checks and in words; an end may be excluded."""

    low: float = -math.inf
    high: float = math.inf
    above: bool = False
    below: bool = False

    def __str__(self) -> str:
        """Return the numbers in words: ``from 0 to 1``, ``above 0 and at most 10``."""
        low, high = spell(self.low), spell(self.high)
        if not (self.above or self.below) and math.isfinite(self.low) and math.isfinite(self.high):
            return f"from {low} to {high}"
        lower = f"{'above' if self.above else 'at least'} {low}"
        upper = f"{'below' if self.below else 'at most'} {high}"
        ends = ((lower, self.low), (upper, self.high))
        return " and ".join(words for words, end in ends if math.isfinite(end))

    def holds(self, values: Any) -> Any:
        """Return true where numbers are allowed, of a number or an array; false for NaN."""
        lower = values > self.low if self.above else values >= self.low
        return lower & (values < self.high if self.below else values <= self.high)

    def trouble(self, name: str, values: Any) -> str:
        """Return the refusal of the first number, of one or an array, that is not allowed."""
        if isinstance(values, int | float):
            odd = [] if self.holds(values) else [values]
        else:
            odd = values[~self.holds(values)].ravel()[:1].tolist()
        return refusal(f"{name} must be {self}".lstrip(), odd[0]) if odd else ""

    def check(self, name: str, values: Any) -> None:
        """Refuse numbers that are not allowed."""
        if trouble := self.trouble(name, values):
            raise ValueError(trouble)


# ---- Records


class _Described(ModelMetaclass):
    """Metaclass that shows a record's fields in ``help`` and ``dir``, not its validation."""

    def __dir__(self) -> list[str]:
        records = (c for c in self.__mro__ if c is not object and c is not BaseModel)
        names = {name for record in records for name in vars(record)} - {"model_config"}
        return sorted(name for name in names if not name.startswith("_"))

    @property
    def __signature__(self) -> inspect.Signature:
        parameter = inspect.Parameter
        parameters = [
            parameter(
                name if iskeyword(field.alias or name) else field.alias or name,
                parameter.KEYWORD_ONLY,
                default=parameter.empty
                if field.is_required()
                else field.get_default(call_default_factory=True),
            )
            for name, field in self.model_fields.items()  # type: ignore[attr-defined]  # of records
        ]
        return inspect.Signature(parameters)

    @__signature__.setter
    def __signature__(self, value: object) -> None:
        """Drop pydantic's signature, which spells every check."""


class Record(BaseModel, metaclass=_Described):
    """Immutable description that refuses unknown keys and non-finite numbers.

    Equality and hash depend on the declared fields, and on files that they name
    (:meth:`contents_read`), not on cached properties, which a changed copy computes anew. Records
    may therefore be keys of caches.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True, defer_build=True
    )
    # Relations of keys, checked where both are given: a number is above that of another key, or not
    # below it; a key stands in place of another, or either of both must be given; a column goes
    # with one that increases strictly.
    _above: ClassVar[Mapping[str, str]] = {}
    _not_below: ClassVar[Mapping[str, str]] = {}
    _in_place_of: ClassVar[Mapping[str, str]] = {}
    _either: ClassVar[Mapping[str, str]] = {}
    _column_over: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="after")
    def _check_relations(self) -> Self:
        for key, value, other, least in self._pairs(self._above):
            if not value > least:
                raise wrong_value(key, f"must be above {other} {spell(least)}", got=value)
        for key, value, other, least in self._pairs(self._not_below):
            if not value >= least:
                raise wrong_value(key, f"must be at least {other} {spell(least)}", got=value)
        for key, value, other, _ in self._pairs({**self._in_place_of, **self._either}):
            got = value if isinstance(value, float) else None
            raise wrong_value(key, f"give this or {other}, not both", got=got)
        for key, other in self._either.items():
            if getattr(self, key) is None and getattr(self, other) is None:
                raise wrong_value(other, f"required key is missing (or {key})")
        for key, column, other, across in self._pairs(self._column_over):
            if len(across) != len(column):
                raise ValueError(f"{other} and {key} must have the same length")
            if any(after <= before for before, after in pairwise(across)):
                raise ValueError(f"{other} must increase strictly")
        return self

    def _pairs(self, relation: Mapping[str, str]) -> Iterator[tuple[str, Any, str, Any]]:
        """Yield key and value, and other key and value, of a relation where both are given."""
        for key, other in relation.items():
            value, second = getattr(self, key), getattr(self, other)
            if value is not None and second is not None:
                yield key, value, other, second

    def __eq__(self, other: object) -> bool:
        """Return true for the same class, declared fields and file contents."""
        if type(other) is not type(self):
            return NotImplemented
        if self is other:
            return True
        return _declared(self) == _declared(other) and self.contents_read() == other.contents_read()

    def __hash__(self) -> int:
        """Hash of the class and the declared fields, computed once in every process."""
        known = vars(self)
        if _HASH not in known:
            known[_HASH] = hash((type(self), *_declared(self).values()))
        return int(known[_HASH])

    def __getstate__(self) -> dict[Any, Any]:
        """Return what is pickled: no hash, which is another one in another process."""
        state = super().__getstate__()
        return state | {"__dict__": {k: v for k, v in state["__dict__"].items() if k != _HASH}}

    def contents_read(self) -> str | None:
        """Return the contents of a file that a field names, as read; None by default."""
        return None

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a changed copy as pydantic does, of declared fields, marked as not validated."""
        copied = super().model_copy(update=update, deep=deep)
        values = _declared(copied) | dict(update or {})  # with keys that are none, to refuse them
        mark = {_UNCHECKED: True} if update or self.is_unchecked() else {}
        object.__setattr__(copied, "__dict__", values | mark)
        return copied

    def is_unchecked(self) -> bool:
        """Return true for a changed copy, which has not been validated."""
        return _UNCHECKED in vars(self)


class CompletedRecord(Record):
    """Record that takes values from others where it is not given them.

    What is taken does not count as given, so that a changed copy takes it anew.
    """

    @classmethod
    def completed(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return data with what they lack; wrong data are left to the validation."""
        return data

    @model_validator(mode="wrap")
    @classmethod
    def _complete(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if not isinstance(data, Mapping):
            return handler(data)
        values = cls.completed(data)
        record = handler(values)
        record.__pydantic_fields_set__.difference_update(values.keys() - data.keys())
        return record


class FileRecord(Record):
    """Record in a file of its own, with the version of the file's format."""

    format_version: Annotated[int, Strict(), Field(ge=1, le=FORMAT_VERSION)] = FORMAT_VERSION

    def facts(self) -> dict[str, Any]:
        """Return what ``repr`` and notebooks show, units in the names."""
        return {}

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {value}" for name, value in self.facts().items())
        return f"<{type(self).__name__} {facts}>"

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        rows = (
            f"<tr><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>"
            for name, value in self.facts().items()
        )
        return f"<table>{''.join(rows)}</table>"

    @model_validator(mode="before")
    @classmethod
    def _check_format(cls, data: Any) -> Any:
        """Refuse a newer format before its unknown keys."""
        if isinstance(data, Mapping) and "format_version" in data:
            trouble = format_trouble(data["format_version"])
            if trouble is not None:
                raise wrong_value("format_version", trouble)
        return data


def is_positive(value: Any) -> TypeGuard[float]:
    """Return true for raw data that are a number above 0, at most 1e12."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0.0 < value <= 1e12


def wrong_value(
    key: str, message: str, *, got: object = None, **context: Any
) -> PydanticCustomError:
    """Return a validator's error at a key below its record; braces in the message are text.

    ``got``: the value in words of :func:`refusal`, none by default. ``context``: for instance
    ``problems`` in a file that the key names.
    """
    why = message if got is None else refusal(message, got)
    return PydanticCustomError("wrong_value", "{why}", {"key": key, "why": why, **context})


def kind_by_default(key: str, kind: str) -> BeforeValidator:
    """Set the kind of records that do not name it."""

    def named(value: Any) -> Any:
        return {key: kind, **value} if isinstance(value, dict) and key not in value else value

    return BeforeValidator(named)


def _declared(record: BaseModel) -> dict[str, Any]:
    state = vars(record)
    return {name: state[name] for name in type(record).model_fields}


def _at_least(limit: float) -> AfterValidator:
    """Refuse positive numbers too small for anything that flies."""

    def check(value: float) -> float:
        Allowed(limit).check("", value)
        return value

    return AfterValidator(check)


# Bounds far outside all that flies keep the arithmetic free of overflow.
# Strict: neither `true` nor a quoted number passes for a number; an integer passes for a real.
Real = Annotated[float, Strict(), Field(allow_inf_nan=False)]
PositiveReal = Annotated[
    float, Strict(), Field(gt=0, le=1e12, allow_inf_nan=False), _at_least(1e-9)
]
# Without power no section lifts more than 4 pi: Smith, A. M. O. (1975), High-lift aerodynamics,
# Journal of Aircraft 12(6), 501-530.
LiftCoefficient = Annotated[PositiveReal, Field(le=12.57)]
NonNegativeReal = Annotated[float, Strict(), Field(ge=0, le=1e12, allow_inf_nan=False)]
Fraction = Annotated[float, Strict(), Field(gt=0, le=1, allow_inf_nan=False), _at_least(1e-3)]
UnitInterval = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]

Integer = Annotated[int, Strict()]
PositiveInteger = Annotated[int, Strict(), Field(gt=0)]
NonNegativeInteger = Annotated[int, Strict(), Field(ge=0)]
# More cells or strings than any aircraft has: Helios, 75 m span, had 62 120 solar cells.
MOST_CELLS = 100_000
CellCount = Annotated[int, Strict(), Field(gt=0, le=MOST_CELLS)]

Flag = Annotated[bool, Strict()]


def _printable(text: str) -> str:
    """Refuse control characters, which terminals obey and files of figures cannot hold."""
    if not text.isprintable():
        raise ValueError(refusal("must not hold control characters", ascii(text)[:60]))
    return text


Text = Annotated[str, Strict(), Field(min_length=1, pattern=r"\S"), AfterValidator(_printable)]
# Short enough for titles of figures and first lines of tables.
Name = Annotated[Text, Field(max_length=120)]

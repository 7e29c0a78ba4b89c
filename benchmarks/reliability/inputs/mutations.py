"""Changes of valid inputs: of plain data, of lines of text, and of bytes."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Sequence
from typing import Any

__all__ = ["HOSTILE", "NUMBERS", "bytes_changed", "data_changed", "number_text", "text_changed"]

NUMBERS = (
    *("0", "-0", "1", "-1", "0.0", "1.0", "0.5", "2", "7", "89", "90", "91", "100", "180", "365"),
    *("366", "1e-9", "1e-30", "1e-300", "5e-324", "1e9", "1e12", "1e30", "1e300", "1.8e308"),
    *("1e999", "-1e999", "-1e9", ".nan", ".inf", "-.inf", "nan", "inf", "NaN", "Infinity"),
    *("-272", "-273.15", "1,5", "1_000", "0x10", "0o17", "1e", "--1", "+1", "1 000", "9" * 400),
    *("1" + "0" * 20, "9223372036854775808", "0.1000000000000000055511151231257827", "\u0661"),
)
HOSTILE = (
    *("", " ", "\x1b[31mred\x1b[0m", "\x1b]0;title\x07", "\x9b31m", "=cmd|'/c calc'!A1", "+1+1"),
    *("-1+1", "@SUM(1)", "$x$", "\\alpha", "$\\frac{", "a\nb", "a\rb", "a\tb", "\0", "\u202egnp"),
    *("\ufeff", "\ud7ff", "\U0001f680" * 3, "n" * 5000, "../../../etc/passwd", "/etc/passwd"),
    *("/dev/zero", "/dev/null", ".", "..", "~", "CON", "a/b", "a\\b", "%s%n", "{0}", "<b>&amp;"),
    *("<script>alert(1)</script>", "!!python/object/apply:os.system [id]", "&a [*a]", "<<: *a"),
    *("null", "~", "true", "no", "2015-07-01", "12:30", "[", "{", "}", ":", "- ", "#", "'", '"'),
    *(
        "\u00e9",
        "caf\u00e9",
        "\u65e5\u672c",
        "\u0627\u0644",
        "a" * 300 + ".csv",
        "x.csv",
        "-",
        "--",
        "--json",
    ),
)


def number_text(rng: random.Random) -> str:
    """Number, or what looks like one."""
    way = rng.random()
    if way < 0.5:
        return rng.choice(NUMBERS)
    if way < 0.8:
        return f"{rng.choice((1, 1, -1)) * 10.0 ** rng.uniform(-12, 12):.{rng.randint(1, 6)}g}"
    return str(rng.randint(-400, 4000))


# ---- plain data


def data_changed(data: Any, rng: random.Random, *, donors: Sequence[Any] = ()) -> Any:
    """Copy of plain data with some of its values replaced, moved, removed or added.

    Parameters
    ----------
    data : dict
        Content of a valid file.
    rng : random.Random
        Source of chance.
    donors : sequence of dict
        Contents of other files, of which parts are taken.

    Returns
    -------
    dict
    """
    changed = copy.deepcopy(data)
    for _ in range(rng.choice((1, 1, 1, 1, 2, 2, 4))):
        places = list(_places(changed))
        if not places:
            break
        holder, key = rng.choice(places)
        _change_one(holder, key, places, rng, donors)
    return changed


def _places(data: Any) -> list[tuple[Any, Any]]:
    found: list[tuple[Any, Any]] = []
    pairs = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in pairs:
        found.append((data, key))
        if isinstance(value, dict | list):
            found += _places(value)
    return found


def _change_one(
    holder: Any, key: Any, places: Sequence[Any], rng: random.Random, donors: Sequence[Any]
) -> None:
    value, way = holder[key], rng.random()
    if isinstance(value, int | float) and not isinstance(value, bool) and way < 0.7:
        holder[key] = _other_number(value, rng)
    elif way < 0.15:
        del holder[key]
    elif way < 0.3:
        holder[key] = _any_value(rng)
    elif way < 0.4 and isinstance(holder, dict):
        holder[rng.choice(HOSTILE) if rng.random() < 0.3 else f"{key}s"] = holder.pop(key)
    elif way < 0.5 and isinstance(value, list):
        holder[key] = rng.choice(([], value * 2, value[:1], value[::-1], [value], value * 40))
    elif way < 0.75:
        other_holder, other_key = rng.choice(places)
        holder[key] = copy.deepcopy(other_holder[other_key])
    elif donors:
        name = key
        for donor in rng.sample(donors, len(donors)):
            matches = [h[k] for h, k in _places(donor) if k == name]
            if matches:
                holder[key] = copy.deepcopy(rng.choice(matches))
                return
        holder[key] = _any_value(rng)


def _other_number(value: float, rng: random.Random) -> Any:
    if abs(value) > 1e300:  # an earlier change's, which may have hundreds of digits
        return -value
    way = rng.random()
    if way < 0.5:
        return value * rng.uniform(0.5, 2.0)
    if way < 0.65:
        return value * 10.0 ** rng.randint(-12, 12)
    if way < 0.7:
        return -value
    if way < 0.8:
        return int(value) if value == value and abs(value) < 1e300 else 0
    return rng.choice(
        (0, 0.0, -0.0, 1, 1.0, 1e-300, 5e-324, 1e300, float("inf"), float("nan"), 10**30, True)
    )


def _any_value(rng: random.Random) -> Any:
    return rng.choice(
        (
            *(None, True, False, 0, 1, -1, 1.5, float("nan"), float("inf"), 1e300, 10**400, "", []),
            *({}, [1, 2], [[]], {"a": 1}, [None], "text", {"minimum": 1, "maximum": 0}, "1.5"),
            *({"kind": "none"}, {"kind": "table"}, rng.choice(HOSTILE), rng.choice(HOSTILE)),
        )
    )


# ---- text


def text_changed(text: str, rng: random.Random, *, separator: str = ",") -> str:
    """Copy of a text with some of its lines, fields or characters changed.

    Parameters
    ----------
    text : str
        Content of a valid file.
    rng : random.Random
        Source of chance.
    separator : str
        What stands between the fields of a line.

    Returns
    -------
    str
    """
    lines = text.split("\n")
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        change = rng.choice(_LINE_CHANGES)
        # The head of a file is where its meaning lies: it is hit as often as all the rest.
        last = min(len(lines), 12) if rng.random() < 0.5 else len(lines)
        change(lines, rng.randrange(max(last, 1)), rng, separator)
        lines = lines or [""]
    return "\n".join(lines)


def _field(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    fields = lines[at].split(separator)
    place = rng.randrange(len(fields))
    fields[place] = number_text(rng) if rng.random() < 0.7 else rng.choice(HOSTILE)
    lines[at] = separator.join(fields)


def _column(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    """Change a field in every line from here on."""
    place, value = rng.randrange(len(lines[at].split(separator))), number_text(rng)
    factor = rng.choice((None, -1.0, 1e3, 1e-3, 1e9, 0.0))
    for i in range(at, len(lines)):
        fields = lines[i].split(separator)
        if place >= len(fields):
            continue
        try:
            fields[place] = value if factor is None else f"{float(fields[place]) * factor:g}"
        except ValueError:
            continue
        lines[i] = separator.join(fields)


def _remove_line(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    del lines[at : at + rng.choice((1, 1, 2, 10, 1000))]


def _repeat_line(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    lines[at:at] = [lines[at]] * rng.choice((1, 1, 2, 30))


def _swap_lines(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    other = rng.randrange(len(lines))
    lines[at], lines[other] = lines[other], lines[at]


def _character(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    line = lines[at]
    place = rng.randrange(len(line) + 1)
    inserted = rng.choice(HOSTILE) if rng.random() < 0.4 else chr(rng.randrange(1, 0x2FF))
    lines[at] = line[:place] + inserted + line[place + rng.choice((0, 1, 1, 5)) :]


def _truncate(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
    if rng.random() < 0.5:
        del lines[at + 1 :]


def _fields(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    fields = lines[at].split(separator)
    if rng.random() < 0.5:
        fields *= rng.choice((2, 2, 3, 100))
    else:
        del fields[rng.randrange(len(fields))]
    lines[at] = separator.join(fields)


def _long(lines: list[str], at: int, rng: random.Random, separator: str) -> None:
    lines[at] += rng.choice(("x", "9", "[", "{a: ", "- ", '"', separator, " ", "&a ", "\t")) * (
        rng.choice((50, 1000, 50_000))
    )


_LINE_CHANGES: tuple[Callable[[list[str], int, random.Random, str], None], ...] = (
    *(_field, _field, _field, _field, _column, _column, _remove_line, _repeat_line, _swap_lines),
    *(_character, _character, _truncate, _fields, _long),
)


# ---- bytes


def bytes_changed(content: bytes, rng: random.Random) -> bytes:
    """Copy of a content with some of its bytes changed, as a bad disk or transfer does.

    Parameters
    ----------
    content : bytes
        Content of a valid file.
    rng : random.Random
        Source of chance.

    Returns
    -------
    bytes
    """
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4, 20))):
        way, place = rng.random(), rng.randrange(len(data) + 1)
        if way < 0.35 and place < len(data):
            data[place] ^= 1 << rng.randrange(8)
        elif way < 0.6 and place < len(data):
            data[place] = rng.choice((0, 1, 10, 13, 27, 34, 127, 128, 255, rng.randrange(256)))
        elif way < 0.7:
            del data[place : place + rng.choice((1, 2, 16, 256, 10**6))]
        elif way < 0.8:
            data[place:place] = data[place : place + rng.choice((1, 16, 256))]
        elif way < 0.9:
            data[place:place] = rng.randbytes(rng.choice((1, 4, 64)))
        else:
            data[place : place + 4] = rng.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\x7f\0\0\0"))
    if rng.random() < 0.05:
        return rng.choice((b"", b"\xff\xfe" + bytes(data), b"\x1f\x8b" + bytes(data), b"\0" * 512))
    return bytes(data)

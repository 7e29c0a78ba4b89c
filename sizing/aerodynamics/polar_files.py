"""Files of polars by XFOIL (PACC), XFLR5 and airfoil web sites: headers with units, and rows.

A file may hold several polars, and the text of a folder several files
(:data:`missions.files.texts.FILE_MARK`). XFOIL and XFLR5 omit points that do not converge; rows
with NaN or asterisks, which some programs write instead, are skipped. Single rows with impossible
drag or lift are left out, with a note.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from missions.files.errors import InputError, Problem, left_out_note, printable, shortened, shown
from missions.files.texts import FILE_MARK
from solar.schema import Allowed, refusal, spell
from solar.types import FloatArray

# Metres per second of the units in XFLR5.
_SPEED_UNITS = {"m/s": 1.0, "km/h": 1.0 / 3.6, "ft/s": 0.3048, "ft/min": 0.3048 / 60.0}
_SPEED_UNITS |= dict.fromkeys(("mph", "mi/h"), 0.44704)
_SPEED_UNITS |= dict.fromkeys(("kt", "kts", "knot", "knots"), 0.514444)
# Lift without power is at most 4 pi, see LiftCoefficient; drag of a plate across the flow is 2.
LIFT = Allowed(-12.57, 12.57)
# Largest share of rows with impossible lift or drag that is left out of a table or a polar.
SHARE_LEFT_OUT = 1 / 12
_REYNOLDS = Allowed(1e3, 1e8)  # beyond any aircraft
# Limit of incompressible flow, which the models of wing and aircraft assume: Anderson, Fundamentals
# of Aerodynamics, section 1.10.
_MACH = Allowed(0.0, 0.3)
_ALPHA_DEG, _DRAG = Allowed(-90.0, 90.0), Allowed(0.0, 10.0, above=True, below=True)
_MOST_ROWS = 50_000  # beyond any set of polars

_NO_POLAR = "holds no polar: neither 'Calculated polar for:' nor 'Wing name' or 'Plane name'"
# First lines of a polar, the last one in the CSV of airfoiltools.com.
_STARTS: dict[Literal["section", "wing"], re.Pattern[str]] = {
    "section": re.compile(
        r"^\s*(?:Calculated polar for\s*:\s*,?(.*)$|Xfoil polar\.)", re.IGNORECASE
    ),
    "wing": re.compile(r"^\s*(?:Wing|Plane) name\s*:\s*,?(.*)$", re.IGNORECASE),
}
# Lines of that site's header that are used.
_ENTRIES = {"reynolds number": "reynolds", "mach": "mach", "ncrit": "ncrit"}
_ENTRY = re.compile(
    r"^\s*(Airfoil|Reynolds number|Mach|Ncrit)\s*,\s*([^,]*\S)[\s,]*$", re.IGNORECASE
)
_WING_POLAR = re.compile(r"^\s*(?:Wing polar|Plane polar|Polar) name\s*:\s*,?(.*)$", re.IGNORECASE)
_TYPE = re.compile(r"^\s*(\d)\s+(\d)\s+Reynolds number", re.IGNORECASE)
_FIXED_ALPHA = re.compile(r"^\s*Alpha\s*=", re.IGNORECASE)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"
_SETTINGS = re.compile(
    rf"Mach\s*=\s*({_NUMBER}).*?Re\s*=\s*({_NUMBER})(?:\s*e\s*(\d+))?(?:.*?Ncrit\s*=\s*({_NUMBER}))?",
    re.IGNORECASE,
)
_TRIP = re.compile(rf"xtrf\s*=\s*({_NUMBER})\s*\(top\)\s*({_NUMBER})\s*\(bottom\)", re.IGNORECASE)
_SPEED = re.compile(rf"^\s*Freestream speed\s*:\s*,?\s*({_NUMBER})\s*,?\s*(.*?)\s*$", re.IGNORECASE)
_PROGRAM = re.compile(r"^\s*(XFOIL|xflr5|QBlade|flow5)\b.*$", re.IGNORECASE)
_RULE = re.compile(r"^[\s\-_=,;]+$")
# Fields of Fortran have a fixed width: a sign may follow a digit without a space.
_FIELD = re.compile(rf"{_NUMBER}|[-+]?nan|[-+]?inf(?:inity)?|\*+", re.IGNORECASE)

# Column names by quantity, of earlier versions of XFLR5 too.
_COLUMNS = {
    "alpha": ("alpha",),
    "lift": ("cl",),
    "drag": ("cd", "tcd"),
    "moment": ("cm", "gcm"),
    "viscous": ("cdv", "pcd"),
    "induced": ("cdi", "icd"),
    "speed": ("qinf",),
}


class PolarRow(NamedTuple):
    """Row of a polar: angle [deg], coefficients [-], and speed [m/s] if the file has it."""

    line: int
    alpha_deg: float
    lift: float
    drag: float
    moment: float
    induced: float = math.nan
    speed_m_per_s: float = math.nan


@dataclass
class FilePolar:
    """Polar of an airfoil ("section"), or of a whole wing or plane ("wing"), with its header.

    ``source``, ``line``: file and line of the header. ``name``, ``polar_name``: names of the
    airfoil or wing, and of a wing's polar. ``program``: name and version. ``reynolds_type``: 1 for
    a fixed Reynolds number, 2 for a fixed ``Re C_L^1/2``, as in level flight. ``reynolds``:
    Reynolds number [-], at ``C_L = 1`` for type 2; NaN for a wing. ``ncrit``, ``trip``: critical
    amplification, forced transition above and below (x/c). ``speed_m_per_s``: free stream of a wing
    at fixed speed [m/s], or NaN. ``rows``: in the order of the file.
    """

    source: str
    line: int
    kind: Literal["section", "wing"]
    name: str
    program: str
    polar_name: str = ""
    reynolds_type: int = 1
    reynolds: float = math.nan
    mach: float = 0.0
    ncrit: float | None = None
    trip: tuple[float, float] | None = None
    speed_m_per_s: float = math.nan
    rows: list[PolarRow] = field(default_factory=list)
    # Impossible rows, and the number of surplus columns.
    left_out: list[Problem] = field(default_factory=list)
    surplus: int = 0
    # Format of the rows.
    columns: list[str] = field(default_factory=list)
    by_commas: bool = False
    speed_unit: float = 1.0

    def problem(self, line: int | None, message: str) -> Problem:
        """Return a problem at a line of the file."""
        return Problem(self.source, line, None, "", message)

    def values(self, *names: str) -> FloatArray:
        """Return quantities of all rows, of shape (name, row)."""
        return np.array([[getattr(row, name) for row in self.rows] for name in names])


def read_polars(text: str, source: str) -> list[FilePolar]:
    """Read all polars of a file's or folder's text, each with rows; none of a polar table.

    ``source`` is the file or folder, for messages. Raises InputError with every wrong line.
    """
    known, head = (*_STARTS.values(), _PROGRAM), text.splitlines()[:40]
    if not text.startswith(FILE_MARK) and not any(form.match(x) for x in head for form in known):
        return []
    polars: list[FilePolar] = []
    problems: list[Problem] = []
    program, count = "", 0
    empty: dict[str, int] = {}  # files without a polar, with their first line of text
    for file, number, line in _lines(text, source):
        if _PROGRAM.match(line):
            program = " ".join(line.split())
        starts = ((kind, form.match(line)) for kind, form in _STARTS.items())
        kind, start = next((pair for pair in starts if pair[1]), ("section", None))
        if start:
            name = printable(" ".join((start[1] or "").split()).strip(","))[:80] or "unnamed"
            polars.append(FilePolar(file, number, kind, name, program))
            empty.pop(file, None)
        elif polars and polars[-1].source == file:
            try:
                count += _read_line(polars[-1], number, line)
            except ValueError as error:
                problems.append(polars[-1].problem(number, str(error)))
        elif line.strip():
            empty.setdefault(file, number)
        if count > _MOST_ROWS:
            raise InputError([Problem(file, number, None, "", f"more than {_MOST_ROWS} rows")])
    if not polars:
        raise InputError([Problem(source, None, None, "", _NO_POLAR)])
    problems += [Problem(file, number, None, "", _NO_POLAR) for file, number in empty.items()]
    for polar in polars:
        if not polar.columns:
            message = "no line of column names (alpha, CL, CD ...) follows"
            problems.append(polar.problem(polar.line, message))
        elif polar.kind == "section" and math.isnan(polar.reynolds):
            message = "the header has no line 'Mach = ... Re = ...'"
            problems.append(polar.problem(polar.line, message))
        elif len(polar.left_out) > SHARE_LEFT_OUT * len(polar.rows):
            problems += polar.left_out
        elif not polar.rows:
            problems.append(polar.problem(polar.line, "no point of this polar converged"))
        seen: dict[float, PolarRow] = {}
        for row in polar.rows:
            first = seen.setdefault(row.alpha_deg, row)
            if (first.lift, first.drag) != (row.lift, row.drag):
                message = f"alpha {spell(row.alpha_deg)} as in line {first.line}, with other values"
                problems.append(polar.problem(row.line, message))
        polar.rows[:] = seen.values()  # equal rows once
    if problems:
        raise InputError(problems)
    return polars


def _lines(text: str, source: str) -> Iterator[tuple[str, int, str]]:
    """Yield file, line number and text of every line."""
    file, number = source, 0
    for line in text.split("\n"):
        if line.startswith(FILE_MARK):
            name = printable(line.removeprefix(FILE_MARK).strip())[:200]
            file, number = f"{source}{name}" if source.endswith("/") else f"{source} ({name})", 0
            continue
        number += 1
        yield file, number, line.rstrip("\r")


def _read_line(polar: FilePolar, number: int, line: str) -> bool:
    """Read a line below the first one of a polar, and return whether it is a row."""
    if not line.strip() or _RULE.match(line):
        return False
    if not polar.columns or line.lower().lstrip().startswith("alpha"):
        _read_header(polar, line)
        return False
    if _PROGRAM.match(line):  # header of the next polar in the file
        return False
    row = _polar_row(polar, number, line)
    if row is not None:
        polar.rows.append(row)
    return True


def _read_header(polar: FilePolar, line: str) -> None:
    """Read a line of the header; unknown lines are skipped."""
    air = polar.mach, polar.reynolds
    if match := _TYPE.match(line):
        polar.reynolds_type = int(match[1])
        if polar.reynolds_type not in (1, 2):
            raise ValueError(
                f"Reynolds number of type {match[1]}; polars of type 1 (fixed) and 2 (~ 1/sqrt(CL))"
                " are read"
            )
    elif match := _SETTINGS.search(line):
        exponent = 10.0 ** min(int(match[3] or 0), 99)
        polar.ncrit = None if match[4] is None else _float(match[4])
        polar.mach, polar.reynolds = _float(match[1]), _float(match[2]) * exponent
    elif match := _ENTRY.match(line):
        key, value = match[1].lower(), match[2]
        if key == "airfoil":
            polar.name = printable(value)[:80]
        elif re.fullmatch(_NUMBER, value):
            setattr(polar, _ENTRIES[key], _float(value))
        else:
            raise ValueError(refusal(f"{key} must be a number", shown(value)))
    elif match := _TRIP.search(line):
        polar.trip = (_float(match[1]), _float(match[2]))
    elif match := _WING_POLAR.match(line):
        polar.polar_name = printable(" ".join(match[1].split()))[:80]
    elif match := _SPEED.match(line):
        name = match[2].strip(" ,;").lower()
        if name not in _SPEED_UNITS:
            allowed = f"the unit of the speed must be one of {', '.join(_SPEED_UNITS)}"
            raise ValueError(refusal(allowed, shortened(printable(name)) or "none"))
        polar.speed_unit = _SPEED_UNITS[name]
        polar.speed_m_per_s = _float(match[1]) * polar.speed_unit
    elif _FIXED_ALPHA.match(line) or (polar.kind == "section" and re.match(r"^\s*Re\s*,", line)):
        raise ValueError("a polar at a fixed angle of attack (type 4); types 1 and 2 are read")
    elif line.lower().lstrip().startswith("alpha"):
        _take_columns(polar, line)
    if (polar.mach, polar.reynolds) == air:
        return
    _MACH.check("Mach", polar.mach)
    if polar.reynolds == 0.0:
        raise ValueError(refusal(f"Re must be {_REYNOLDS}", "0, an inviscid polar"))
    if not math.isnan(polar.reynolds):
        _REYNOLDS.check("Re", polar.reynolds)


def _take_columns(polar: FilePolar, line: str) -> None:
    polar.by_commas = "," in line
    plain = re.sub(r"(?i)\b(top|bot)[ _](xtr|itr)\b", r"\1\2", line)
    names = plain.split(",") if polar.by_commas else plain.split()
    # In polars of wings Cl, Cm and Cn are moments, and only CL is lift.
    keys: list[str] = []
    for raw in (name.strip() for name in names):
        known = next((key for key, spelt in _COLUMNS.items() if raw.lower() in spelt), "")
        keys.append("" if known in keys or (raw == "Cl" and polar.kind == "wing") else known)
    needed = ["alpha", "lift", "drag"] + (["viscous", "induced"] if polar.kind == "wing" else [])
    missing = [next(iter(_COLUMNS[key])).upper() for key in needed if key not in keys]
    if missing:
        raise ValueError(f"the columns lack {', '.join(missing)}")
    if polar.kind == "section" and "induced" in keys:
        raise ValueError("columns of a wing below the header of an airfoil")
    polar.columns = keys


def _polar_row(polar: FilePolar, number: int, line: str) -> PolarRow | None:
    """Return a row; None for a point that did not converge, or is impossible."""
    if polar.by_commas:
        texts = [part.strip() for part in line.rstrip(", \t").split(",")]
        odd = [text for text in texts if not _FIELD.fullmatch(text)]
    else:
        texts = _FIELD.findall(line)
        odd = _FIELD.sub(" ", line).split()
    surplus = len(texts) - len(polar.columns)
    # XFLR5 6.61 writes twelve numbers under ten names; the surplus is at the right.
    if "xflr5" in polar.program.lower() and polar.kind == "section" and surplus > 0:
        polar.surplus, texts = surplus, texts[:-surplus]
    if odd or len(texts) != len(polar.columns):
        got = shown(" ".join(line.split()))
        raise ValueError(refusal(f"{len(polar.columns)} numbers are needed", got))
    values = {key: _float(text) for key, text in zip(polar.columns, texts, strict=True) if key}
    used = [values[key] for key in ("alpha", "lift", "drag")]
    drag = values["drag"] if polar.kind == "section" else values["viscous"]
    if not all(math.isfinite(value) for value in (*used, drag)):
        return None
    _ALPHA_DEG.check("alpha", values["alpha"])
    name = "CD" if polar.kind == "section" else "CDv"
    if wrong := LIFT.trouble("CL", values["lift"]) or _DRAG.trouble(name, drag):
        polar.left_out.append(polar.problem(number, wrong))
        return None
    moment, induced = (values.get(key, math.nan) for key in ("moment", "induced"))
    speed = values.get("speed", math.nan) * polar.speed_unit
    alpha_deg = round(values["alpha"], 4)
    return PolarRow(number, alpha_deg, values["lift"], drag, moment, induced, speed)


def _float(text: str) -> float:
    """Return a number of a Fortran program; NaN for asterisks, which mark an overflow."""
    return math.nan if text.startswith("*") else float(text.lower().replace("d", "e"))


def reading_notes(polars: Sequence[FilePolar]) -> tuple[str, ...]:
    """Return notes on rows left out of polars, and on surplus columns."""
    notes = []
    if polar := next((polar for polar in polars if polar.surplus), None):
        names = len(polar.columns)
        notes.append(
            f"XFLR5 writes {names + polar.surplus} numbers under {names} names: columns are taken "
            "by their place from the left"
        )
    return (*notes, *left_out_note([row for polar in polars for row in polar.left_out]))

"""Propeller of an aircraft's file, and files of its table: APC, UIUC database, and CSV."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, PrivateAttr, Strict, model_validator

from missions.files.errors import InputError, Problem, file_error, left_out_note, printable, shown
from missions.files.tables import number_of, number_rows, text_table
from missions.files.texts import read_text, texts_as_read
from missions.files.validation import wrong_file
from sizing.catalogues.choice import CatalogueRecord, Kind
from sizing.propulsion.propeller import BladeElementPropeller, Propeller, PropellerTable, SpeedCurve
from solar.schema import (
    Allowed,
    Flag,
    NonNegativeReal,
    PositiveReal,
    Text,
    refusal,
    spell,
    wrong_value,
)

_INCH_M = 0.0254
_MPH_M_PER_S = 0.44704
# Sizes in names are in inches, a few in millimetres; no model propeller has 40 inches.
_LARGEST_INCHES = 40.0
_ADVANCE, _COEFFICIENT = Allowed(0.0, 5.0), Allowed(-2.0, 2.0)  # beyond any propeller
_RPM = Allowed(0.0, 1e5, above=True)
_ALLOWED = {
    "j": _ADVANCE,
    "ct": _COEFFICIENT,
    "cp": _COEFFICIENT,
    "rpm": _RPM,
    "eta": Allowed(above=True, below=True),
}
# Relative difference of the speeds of two wind tunnel runs at one nominal speed.
_SAME_SPEED = 0.01
# Relative error of the efficiency by rounding of the coefficients.
_ROUNDING = 0.02

_BLOCK = re.compile(r"^\s*PROP RPM\s*=\s*(\S+)", re.IGNORECASE)
_SIZE = re.compile(r"(?:^|[\s_])(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)")
_RUN = re.compile(r"_(\d{3,6})\.txt$", re.IGNORECASE)
_MANY_SPEEDS = "two speeds or more are needed (any_speed=True uses one curve at every speed)"


@dataclass
class _Point:
    file: str
    line: int
    speed_rpm: float
    advance: float
    thrust: float
    power: float


@dataclass
class _Read:
    """Points, problems and diameter read from the files."""

    points: list[_Point] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    diameter_m: float | None = None
    static: list[_Point] = field(default_factory=list)
    left_out: list[Problem] = field(default_factory=list)

    def refuse(self, file: str, line: int | None, message: str) -> None:
        self.problems.append(Problem(file, line, None, "", message))

    def check(self) -> None:
        """Raise the problems, if any."""
        if self.problems:
            raise InputError(self.problems[:20])


def read_propeller(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    diameter_m: float | None = None,
    *,
    any_speed: bool = False,
) -> PropellerTable:
    """Read the table of a propeller from one file or several.

    * APC's performance files (``PER3_*.dat``): blocks ``PROP RPM =`` with columns V (mph), J, Ct,
      Cp. The diameter is that of the first line, in inches.
    * Tables of the UIUC propeller database: columns ``J CT CP eta``, a file for each run, whose
      name ends with the speed in rpm and has the size in inches (``apce_9x6_rd0988_4003.txt``).
      Static runs (``RPM CT CP``) give the value at ``J = 0`` of the speeds that they cover.
    * CSV with columns ``J``, ``CT``, ``CP`` and ``rpm``, in any order and case; lines that begin
      with ``#`` are comments, of which ``# diameter_m: 0.66`` gives the diameter.

    Parameters
    ----------
    files : path or sequence of paths
        All of one propeller.
    diameter_m : float, optional
        Diameter [m], in place of the one in the files or their names.
    any_speed : bool
        Use the slowest and fastest curve beyond their speeds as well, or a table that names no
        speed at all. Without it such a table is refused.

    Returns
    -------
    PropellerTable

    Raises
    ------
    InputError
        With file and line of every mistake.
    """
    paths = [files] if isinstance(files, str | os.PathLike) else list(files)
    if not paths:
        raise file_error("files", "must name at least one file (got none)")
    read = _Read(diameter_m=diameter_m)
    for path in paths:
        name = os.fspath(path)
        _read_file(read, read_text(name), printable(name))
    names = ", ".join(printable(os.fspath(path)) for path in paths)
    for point in read.points:
        advance, thrust, power = point.advance, point.thrust, point.power
        trouble = _ADVANCE.trouble("J", advance) or _COEFFICIENT.trouble("CT", thrust)
        trouble = trouble or _COEFFICIENT.trouble("CP", power)
        if not trouble and thrust > 0.0 and advance * thrust > (1.0 + _ROUNDING) * power:
            trouble = f"CT {spell(thrust)} and CP {spell(power)} at J {spell(advance)}"
            trouble += " are an efficiency J CT / CP above 1"
        if trouble:
            read.refuse(point.file, point.line, trouble)
    read.check()
    if not read.points:
        raise file_error(names, "holds no row of J, CT and CP")
    if read.diameter_m is None:
        raise file_error(names, "does not tell the diameter: give diameter_m")
    if trouble := Allowed(0.0, 100.0, above=True).trouble("", read.diameter_m):
        raise file_error("diameter_m", trouble)
    if len({math.isnan(point.speed_rpm) for point in read.points}) > 1:
        raise file_error(names, "names a speed of rotation for some rows alone")
    speeds = _by_speed(read.points)
    if len(speeds) < 2 and not any_speed:
        rpm = speeds[0][0].speed_rpm
        have = "names no speed of rotation" if math.isnan(rpm) else f"has {spell(rpm)} rpm alone"
        raise file_error(names, f"{have}: {_MANY_SPEEDS}")
    for first, *others in speeds:
        if all(point.advance == first.advance for point in others):
            message = "the only advance ratio at this speed; two are needed"
            read.refuse(first.file, first.line, message)
    read.check()
    curves = tuple(_curve(points, read.static) for points in speeds)
    return PropellerTable(read.diameter_m, curves, names, any_speed, left_out_note(read.left_out))


def _read_file(read: _Read, text: str, file: str) -> None:
    """Add the points of a file in any of the formats."""
    lines, table = text.splitlines(), text_table(text)
    names = table.names
    if any(_BLOCK.match(line) for line in lines):
        _read_apc(read, lines, file)
        return
    if not {"ct", "cp"} < set(names) & _ALLOWED.keys():
        message = "is no table of a propeller: neither 'PROP RPM =' nor columns J, CT and CP"
        read.refuse(file, None, message)
        return
    if not set(names) <= _ALLOWED.keys() or len(set(names)) < len(names):
        message = "columns must be J, CT, CP and rpm, each once"
        read.refuse(file, table.line, refusal(message, shown(", ".join(names))))
        return
    speed = math.nan
    if table.separator is None and "j" in names:
        name = file.replace("\\", "/").rpartition("/")[2]
        _take_diameter(read, name)
        speed = float(run[1]) if (run := _RUN.search(name)) else math.nan
    elif read.diameter_m is None and "diameter_m" in table.header:
        read.diameter_m = number_of(table.header["diameter_m"])
    rows, places, problems = number_rows(table, _ALLOWED, file)
    read.problems += problems
    static = table.separator is None and "j" not in names
    for line, row in zip(places, rows.tolist(), strict=True):
        by = {"rpm": speed, "j": 0.0} | dict(zip(names, row, strict=True))
        point = _Point(file, line, *(by[key] for key in ("rpm", "j", "ct", "cp")))
        (read.static if static else read.points).append(point)


def _take_diameter(read: _Read, text: str) -> None:
    """Take the diameter from a name such as 11x5.5E, unless it is given."""
    size = _SIZE.search(text)
    if read.diameter_m is None and size and float(size[1]) <= _LARGEST_INCHES:
        read.diameter_m = float(size[1]) * _INCH_M


def _read_apc(read: _Read, lines: Sequence[str], file: str) -> None:
    _take_diameter(read, next(line for line in lines if line.strip()))
    speed = math.nan
    order: list[str] = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        if block := _BLOCK.match(line):
            speed = number_of(block[1])
            order = []
            if not _RPM.holds(speed):
                message = refusal(f"PROP RPM must be {_RPM}", shown(block[1]))
                read.refuse(file, number, message)
        elif words[:2] == ["V", "J"]:
            order = [word.lower() for word in words]
        elif 2 < len(words) < len(order) and "(" not in line:
            message = refusal(f"{len(order)} numbers are needed", len(words))
            read.refuse(file, number, message)
        elif order and words and "(" not in line:
            _apc_row(read, speed, dict(zip(order, words, strict=False)), (file, number))


def _apc_row(read: _Read, speed: float, row: dict[str, str], place: tuple[str, int]) -> None:
    """Add a row; the finer rounded of J and V counts, and they must agree."""
    values = {key: number_of(row.get(key, "")) for key in ("v", "j", "ct", "cp")}
    wrong = [key for key, value in values.items() if math.isnan(value)]
    if wrong:
        # Where its computation does not converge APC prints NaN, since 2022 nothing.
        if any("nan" in row.get(key, "").lower() for key in wrong) or (
            list(row) == ["v", "j"] and wrong == ["ct", "cp"]
        ):
            read.left_out.append(Problem(*place, None, "", "no CT and CP"))
        else:
            text = f"{wrong[0].upper()} must be a number"
            read.refuse(*place, refusal(text, shown(row.get(wrong[0], ""))))
        return
    advance = values["j"]
    if read.diameter_m is not None and speed > 0.0:
        per_speed = 60.0 * _MPH_M_PER_S / (speed * read.diameter_m)
        by_speed = values["v"] * per_speed
        step_j, step_v = _last_digit(row["j"]), _last_digit(row["v"]) * per_speed
        if abs(by_speed - advance) > step_j + step_v + 0.02 * advance:
            at = f"{row['v']} mph, {spell(speed)} rpm and a diameter of {spell(read.diameter_m)} m"
            message = f"J {row['j']} is not V/(nD) of {at}, which is {round(by_speed, 3)}"
            read.refuse(*place, message)
        advance = by_speed if step_v < step_j else advance
    read.points.append(_Point(*place, speed, advance, values["ct"], values["cp"]))


def _last_digit(text: str) -> float:
    """Return the last digit's place value of a printed number."""
    return 10.0 ** -len(text.partition(".")[2])


def _by_speed(points: Sequence[_Point]) -> list[list[_Point]]:
    """Return the points of each speed of rotation, with runs of nearly the same speed together."""
    groups: list[list[_Point]] = []
    for point in sorted(points, key=lambda point: (point.speed_rpm, point.advance)):
        if not groups or point.speed_rpm > groups[-1][0].speed_rpm * (1.0 + _SAME_SPEED):
            groups.append([])
        groups[-1].append(point)
    return groups


def _curve(points: Sequence[_Point], static: Sequence[_Point]) -> SpeedCurve:
    """Return the curve of one speed, averaged over equal J, with J = 0 of the static runs."""
    speed = float(np.mean([point.speed_rpm for point in points]))
    advance, place = np.unique([point.advance for point in points], return_inverse=True)
    columns = [
        np.bincount(place, [getattr(point, name) for point in points]) / np.bincount(place)
        for name in ("thrust", "power")
    ]
    still = sorted(static, key=lambda point: point.speed_rpm)
    if still and advance[0] > 0.0 and still[0].speed_rpm <= speed <= still[-1].speed_rpm:
        rpm, *at_rest = zip(*((s.speed_rpm, s.thrust, s.power) for s in still), strict=True)
        advance = np.append(0.0, advance)
        columns = [
            np.append(np.interp(speed, rpm, first), column)
            for first, column in zip(at_rest, columns, strict=True)
        ]
    return SpeedCurve(speed, advance, columns[0], columns[1])


class PropellerChoice(CatalogueRecord):
    """Propeller by its diameter and pitch, or by the files of its table.

    ``product`` names a catalogue entry, which gives the keys that the file omits. ``table`` and
    ``any_speed``: see :func:`sizing.read_propeller`; with a table, ``diameter_m`` is needed only
    where its files omit it.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"product": "propellers"}

    product: Text | None = None
    diameter_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    pitch_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    blades: Annotated[int, Strict(), Field(ge=2, le=12)] = 2
    chords: Literal["thin_electric", "slow_flyer"] = "thin_electric"
    table: Text | tuple[Text, ...] | None = None
    any_speed: Flag = False
    mass_kg: NonNegativeReal | None = None
    # Texts of the tables by path, read when the record was made.
    _texts: dict[str, str] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _check_choice(self) -> PropellerChoice:
        if self.table is None:
            for key in ("diameter_m", "pitch_m"):
                if getattr(self, key) is None:
                    text = "required key is missing (or product, or table with its files)"
                    raise wrong_value(key, text)
            return self
        odd = self.model_fields_set & {"pitch_m", "blades", "chords"}
        if odd:
            text = "is of no use with a table, which has the coefficients"
            raise wrong_value(min(odd), text)
        try:
            _ = self.propeller
        except InputError as error:
            raise wrong_file("table", error) from error
        return self

    @property
    def paths(self) -> tuple[str, ...]:
        """Files of the table; empty without a table."""
        return (self.table,) if isinstance(self.table, str) else self.table or ()

    def texts_read(self) -> dict[str, str]:
        """Return the text of every file of the table by its path, read once."""
        if self._texts is None or tuple(self._texts) != self.paths:
            self._texts = {path: read_text(path) for path in self.paths}
        return self._texts

    def contents_read(self) -> str | None:
        """Return the joined texts of the table, which count for equality."""
        return "".join(self.texts_read().values()) or None

    @cached_property
    def propeller(self) -> Propeller:
        """Propeller by its table or by blade elements."""
        if self.table is None:
            assert self.diameter_m is not None
            assert self.pitch_m is not None
            return BladeElementPropeller(self.diameter_m, self.pitch_m, self.blades, self.chords)
        with texts_as_read(self.texts_read()):
            return read_propeller(self.paths, self.diameter_m, any_speed=self.any_speed)

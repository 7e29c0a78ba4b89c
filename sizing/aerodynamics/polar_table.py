"""Tables of airfoil polars over angle of attack and Reynolds number, also those that ship.

A polar is a CSV table of computed or measured data, a file by XFOIL or XFLR5, or a folder of such
files, whose polars are merged into one table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np

from missions.files.errors import InputError, Problem, file_error, left_out_note
from missions.files.tables import number_rows, text_table
from sizing.aerodynamics.polar_files import (
    LIFT,
    SHARE_LEFT_OUT,
    FilePolar,
    read_polars,
    reading_notes,
)
from solar.schema import Allowed, significant, spell
from solar.types import FloatArray

# Suffixes of files with polars; the path of a folder ends with a slash.
POLAR_SUFFIXES = (".csv", ".txt", ".pol", ".plr", ".dat")

_ALLOWED = {
    "alpha_deg": Allowed(-180.0, 180.0),
    "reynolds": Allowed(0.0, 1e10, above=True),
    "cl": LIFT,
    "cd": Allowed(0.0, 10.0, above=True),
    "cm": Allowed(above=True, below=True),
    "confidence": Allowed(0.0, 1.0),
}
_LEFT_OUT = ("cl", "cd")  # of rows with impossible values
COLUMNS = tuple(_ALLOWED)


def is_table_path(airfoil: str) -> bool:
    """Return whether an airfoil is the path of a table rather than the name of a shipped one."""
    return airfoil.lower().endswith((*POLAR_SUFFIXES, "/"))


OF_A_SECTION = "holds polars of a section: wing_chord_m and wing_aspect_ratio go with a wing's"


@dataclass(frozen=True)
class WingReference:
    """Wing of polars: mean chord [m], aspect ratio [-], and viscosity of the air [m2/s]."""

    chord_m: float
    aspect_ratio: float
    kinematic_viscosity_m2_per_s: float


@dataclass(frozen=True)
class PolarTable:
    """Rows and header of a polar file; keys of :attr:`header` are in lower case."""

    source: str
    header: dict[str, str]
    columns: dict[str, FloatArray]
    span_efficiency: float | None = None  # of a wing's induced drag
    notes: tuple[str, ...] = ()  # rows left out, and remarks on the format

    @property
    def name(self) -> str:
        """Name of the airfoil in the header."""
        return self.header["airfoil"]


def shipped_airfoils() -> tuple[str, ...]:
    """Return the names of the polars that ship with the package."""
    folder = resources.files("sizing").joinpath("data", "polars")
    names = (item.name for item in folder.iterdir())
    return tuple(sorted(name.removesuffix(".csv") for name in names if name.endswith(".csv")))


def shipped_table(name: str) -> PolarTable:
    """Read a table that ships with the package; an unknown name raises ValueError."""
    if name not in shipped_airfoils():
        known = ", ".join(shipped_airfoils())
        raise ValueError(
            f"unknown airfoil {name!r}; shipped are {known}, and a path ending in "
            f"{', '.join(POLAR_SUFFIXES)} or / is read"
        )
    file = resources.files("sizing").joinpath("data", "polars", f"{name}.csv")
    return parse_polar_table(file.read_text(encoding="utf-8"), f"{name}.csv")


def parse_polar_table(text: str, source: str) -> PolarTable:
    """Read the text of a polar table.

    The header is comment lines ``# key: value``, of which ``airfoil`` and ``source`` are required;
    then come the line of column names and the rows, in any order. ``source`` is the file name, for
    messages. Raises InputError with every wrong line.
    """
    table = text_table(text)
    problems = [
        Problem(source, None, None, "", f"the header has no line '# {key}: ...'")
        for key in ("airfoil", "source")
        if not table.header.get(key)
    ]
    if table.names != list(COLUMNS):
        message = f"column names must be {','.join(COLUMNS)}"
        raise InputError([*problems, Problem(source, table.line, None, "", message)])
    rows, lines, wrong = number_rows(table, _ALLOWED, source)
    left_out = [problem for problem in wrong if problem.key in _LEFT_OUT]
    problems += [problem for problem in wrong if problem.key not in _LEFT_OUT]
    seen: dict[tuple[float, ...], int] = {}
    for line, place in zip(lines, map(tuple, rows[:, :2].tolist()), strict=True):
        if (earlier := seen.setdefault(place, line)) != line:
            message = f"same alpha_deg and reynolds as in line {earlier}"
            problems.append(Problem(source, line, None, "", message))
    if len(left_out) > SHARE_LEFT_OUT * len(rows):
        problems += left_out
    if problems:
        raise InputError(problems)
    if not len(rows):
        raise file_error(source, "the table has no rows")
    columns = dict(zip(COLUMNS, rows.T, strict=True))
    return PolarTable(source, table.header, columns, notes=left_out_note(left_out))


# ---- Polars by XFOIL and XFLR5

# Share of the greatest lift that polars of fixed lift cover at their lowest resampled Reynolds
# number; a branch of attached flow has to begin below half the greatest lift.
_LOW_LIFT_SHARE = 0.35
_LEAST_RATIO = 1.5  # of the largest to the smallest Reynolds number of a table
# Lift coefficients of the span efficiency, over the greatest.
_CRUISE = (0.3, 0.9)
_SAME_SPEED = 2e-3  # relative, rounding of a column of speeds


def parse_polar(text: str, source: str, wing: WingReference | None = None) -> PolarTable:
    """Read a polar of a file's or folder's text: a table, or polars by XFOIL and XFLR5.

    ``source`` is the file or folder, for messages. With ``wing`` the polars are those of a whole
    wing, and the table has the viscous drag. Raises InputError with every wrong line, and for
    polars of different airfoils, settings or kinds.

    Polars of fixed lift (type 2) have another Reynolds number in each row. At equal angle of
    attack, lift, logarithm of drag and moment are interpolated linearly in the logarithm of the
    Reynolds number, to as many fixed Reynolds numbers as there are polars.
    """
    polars = read_polars(text, source)
    of_wing = next((polar for polar in polars if polar.kind == "wing"), None)
    if of_wing is None and wing is not None:
        raise file_error(source, OF_A_SECTION)
    if not polars:
        return parse_polar_table(text, source)
    if of_wing is not None and any(polar.kind != "wing" for polar in polars):
        message = "polars of an airfoil and of a wing mixed"
        raise InputError([of_wing.problem(of_wing.line, message)])
    if of_wing is not None and wing is None:
        message = (
            f"is the polar of a whole wing ({of_wing.name}), induced drag included, not of its "
            "section: give wing_chord_m and wing_aspect_ratio, or polars of the section"
        )
        raise InputError([of_wing.problem(of_wing.line, message)])
    _check_settings(polars)
    tables = [_table(polar, wing) for polar in polars]
    fixed = [_is_fixed(polar) for polar in polars]
    if any(fixed) and not all(fixed):
        odd = polars[fixed.index(not fixed[0])]
        raise InputError([odd.problem(odd.line, "polars of fixed speed and of fixed lift mixed")])
    seen: dict[float, FilePolar] = {}
    problems = []
    for polar, rows in zip(polars, tables, strict=True):
        first = seen.setdefault(float(rows[0, 1]), polar)
        if fixed[0] and first is not polar:
            message = f"Reynolds number {spell(rows[0, 1])} as in {_place(first)}"
            problems.append(polar.problem(polar.line, message))
    if problems:
        raise InputError(problems)
    rows = np.concatenate(tables) if fixed[0] else _resampled(tables, source)
    columns = dict(zip(COLUMNS, (*rows.T, np.ones(len(rows))), strict=True))
    header = {"airfoil": polars[0].name, "source": polars[0].program or "XFLR5"}
    efficiency = None if wing is None else _span_efficiency(polars, wing, source)
    return PolarTable(source, header, columns, efficiency, reading_notes(polars))


def _check_settings(polars: Sequence[FilePolar]) -> None:
    """Refuse polars of different airfoils, Mach numbers or transitions."""
    first = polars[0]
    problems: list[Problem] = []
    for polar in polars[1:]:
        for setting, expected, actual in (
            ("Mach", first.mach, polar.mach),
            ("Ncrit", first.ncrit, polar.ncrit),
            ("xtrf", first.trip, polar.trip),
        ):
            if expected != actual:
                message = f"{setting} {_spelled(actual)}, but {_spelled(expected)}"
                problems.append(polar.problem(polar.line, f"{message} in {_place(first)}"))
        if polar.name.lower().split() != first.name.lower().split():
            message = f"polar of {polar.name}, but {_place(first)} is of {first.name}"
            problems.append(polar.problem(polar.line, message))
    if problems:
        raise InputError(problems)


def _spelled(value: float | tuple[float, float] | None) -> str:
    if value is None:
        return "none"
    return " and ".join(map(spell, value if isinstance(value, tuple) else (value,)))


def _place(polar: FilePolar) -> str:
    return f"{polar.source.rsplit('/', 1)[-1]}:{polar.line}"


def _is_fixed(polar: FilePolar) -> bool:
    """Return whether all rows have the same Reynolds number."""
    if polar.kind == "section":
        return polar.reynolds_type == 1
    (speeds,) = polar.values("speed_m_per_s")
    speeds = speeds[np.isfinite(speeds)]
    return not len(speeds) or bool(np.ptp(speeds) <= _SAME_SPEED * speeds.max())


def _table(polar: FilePolar, wing: WingReference | None) -> FloatArray:
    """Return the rows of a polar: angle, Reynolds number, lift, drag, moment.

    Of fixed lift the Reynolds number is NaN at lift below zero.
    """
    alpha_deg, lift, drag, moment, speed = polar.values(
        "alpha_deg", "lift", "drag", "moment", "speed_m_per_s"
    )
    if wing is not None:
        speed = np.where(np.isfinite(speed) & (speed > 0.0), speed, polar.speed_m_per_s)
        if not np.all(speed > 0.0):
            message = "neither the header nor a column QInf has the speed"
            raise InputError([polar.problem(polar.line, message)])
        reynolds = speed * (wing.chord_m / wing.kinematic_viscosity_m2_per_s)
        if _is_fixed(polar):  # speeds have few digits: all rows get their mean
            reynolds = np.full(len(reynolds), significant(float(np.mean(reynolds)), 4))
    elif polar.reynolds_type == 1:
        reynolds = np.full(len(lift), polar.reynolds)
    else:
        reynolds = polar.reynolds / np.sqrt(np.where(lift > 0.0, lift, np.nan))
    return np.column_stack((alpha_deg, reynolds, lift, drag, moment))


def _resampled(read: Sequence[FloatArray], source: str) -> FloatArray:
    """Return the rows at fixed Reynolds numbers, from polars of fixed lift."""
    highest = max(float(rows[:, 2].max()) for rows in read)
    # Rows with positive lift, by polar.
    points = [rows[(rows[:, 2] > 0.0) & np.isfinite(rows[:, 1])] for rows in read]
    # Re C_L^1/2 of every polar, constant up to rounding.
    constants = sorted(
        float(np.median(rows[:, 1] * np.sqrt(rows[:, 2]))) for rows in points if len(rows)
    )
    low, high = 0.0, 0.0
    if len(constants) >= 2 and highest > 0.0:
        low = constants[0] / math.sqrt(_LOW_LIFT_SHARE * highest)
        high = constants[-1] / math.sqrt(highest)
    if not high >= _LEAST_RATIO * low > 0.0:
        ratio = spell(_LEAST_RATIO / math.sqrt(_LOW_LIFT_SHARE), 2)
        message = (
            "polars of fixed lift (type 2) make a table only if the greatest Re C_L^1/2 is at "
            f"least {ratio} times the smallest; export more of them, or polars of type 1"
        )
        raise file_error(source, message)
    every = np.concatenate(points)
    targets = np.geomspace(low, high, max(len(constants), 2))
    tables = []
    for alpha in np.unique(every[:, 0]):
        at = every[every[:, 0] == alpha]
        at = at[np.argsort(at[:, 1], kind="stable")]
        log_re = np.log(at[:, 1])
        if len(at) < 2 or np.any(np.diff(log_re) <= 0.0):
            continue
        log_targets = np.log(targets)
        inside = (log_targets >= log_re[0] - 1e-9) & (log_targets <= log_re[-1] + 1e-9)
        columns = (at[:, 2], np.log(at[:, 3]), at[:, 4])
        cl, cd, cm = (np.interp(log_targets[inside], log_re, column) for column in columns)
        reynolds = [significant(float(target)) for target in targets[inside]]
        tables.append(np.stack([np.full(len(cl), alpha), reynolds, cl, np.exp(cd), cm], axis=1))
    if not sum(map(len, tables)):
        raise file_error(source, "no angle of attack is in two polars of fixed lift")
    return np.concatenate(tables)


def _span_efficiency(polars: Sequence[FilePolar], wing: WingReference, source: str) -> float:
    """Return the median span efficiency over cruise, ``e = C_L^2 / (pi AR C_Di)`` [-].

    Anderson, Fundamentals of Aerodynamics, eq. 5.62.
    """
    efficiencies = np.empty(0)
    for polar in polars:
        lift, induced = polar.values("lift", "induced")
        low, high = (share * lift.max() for share in _CRUISE)
        used = (low <= lift) & (lift <= high) & (induced > 0.0)
        ideal = math.pi * wing.aspect_ratio * induced[used]
        efficiencies = np.append(efficiencies, lift[used] ** 2 / ideal)
    if not len(efficiencies):
        raise file_error(source, "the polars have no induced drag (CDi) at lift")
    efficiency = float(np.median(efficiencies))
    if not 0.3 <= efficiency <= 1.0 + 1e-2:
        message = (
            f"induced drag and wing_aspect_ratio {spell(wing.aspect_ratio)} give a span efficiency "
            f"of {spell(efficiency, 3)}; it must be from 0.3 to 1: is that the aspect ratio of "
            "this wing?"
        )
        raise file_error(source, message)
    return min(efficiency, 1.0)

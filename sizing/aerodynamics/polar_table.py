"""Tables of airfoil polars: reading, checks, and the tables that ship with the package.

A polar is a CSV table of computed or measured data, a file by XFOIL or XFLR5, or a folder of such
files.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources

from missions.files.errors import InputError, Problem, file_error, left_out_note
from missions.files.tables import number_rows, text_table
from missions.files.texts import read_folder, read_text
from solar.schema import Allowed
from solar.types import FloatArray

# Suffixes of files with polars; the path of a folder ends with a slash.
POLAR_SUFFIXES = (".csv", ".txt", ".pol", ".plr", ".dat")

# Lift without power is at most 4 pi, see LiftCoefficient; drag of a plate across the flow is 2.
LIFT = Allowed(-12.57, 12.57)
_ALLOWED = {
    "alpha_deg": Allowed(-180.0, 180.0),
    "reynolds": Allowed(0.0, 1e10, above=True),
    "cl": LIFT,
    "cd": Allowed(0.0, 10.0, above=True),
    "cm": Allowed(above=True, below=True),
    "confidence": Allowed(0.0, 1.0),
}
# Largest share of rows with impossible lift or drag that is left out of a table or a polar.
_LEFT_OUT = ("cl", "cd")
SHARE_LEFT_OUT = 1 / 12
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


def read_polar_text(path: str) -> str:
    """Read the text of a file, or of all files of a folder, whose path ends with a slash."""
    return read_folder(path, POLAR_SUFFIXES) if path.endswith("/") else read_text(path)


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

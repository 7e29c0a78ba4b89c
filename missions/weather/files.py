"""Weather records from files."""

from __future__ import annotations

import os
from contextlib import ExitStack
from importlib import resources
from pathlib import Path

from missions.files.errors import printable
from missions.weather.checks import checked_record
from missions.weather.layouts import read_layout
from missions.weather.record import Weather

_ENDING = ".csv.gz"


def load_weather(path: str | os.PathLike[str]) -> Weather:
    """Load a weather record: light, temperature and wind at a site over time.

    Parameters
    ----------
    path : str or path
        Name of the shipped record, ``colorado-2023``, or a file: EPW, TMY2, TMY3, PVGIS (typical
        year or hourly, CSV or JSON), NSRDB PSM, BSRN, or a plain CSV table. Which of them it is
        is seen from the contents.

    Returns
    -------
    Weather
        Equal intervals without gaps; what was repaired is told in ``repairs``.

    Raises
    ------
    InputError
        With file, line and reason, if the file cannot be read or its values cannot be true.
    """
    name = os.fspath(path)
    source = printable(name)
    with ExitStack() as stack:
        place = Path(name)
        if name in shipped_records() and not place.exists():
            shipped = resources.files("missions").joinpath("library", f"{name}{_ENDING}")
            place, source = stack.enter_context(resources.as_file(shipped)), f"{name} (shipped)"
        return checked_record(read_layout(place, source), source)


def shipped_records() -> list[str]:
    """Names of the weather records that are shipped, sorted."""
    folder = resources.files("missions").joinpath("library")
    names = (file.name for file in folder.iterdir())
    return sorted(name.removesuffix(_ENDING) for name in names if name.endswith(_ENDING))

"""Weather records from files."""

from __future__ import annotations

import os
from pathlib import Path

from missions.files.errors import printable
from missions.weather.checks import checked_record
from missions.weather.layouts import read_layout
from missions.weather.record import Weather


def load_weather(path: str | os.PathLike[str]) -> Weather:
    """Load a weather record: light, temperature and wind at a site over time.

    Parameters
    ----------
    path : str or path
        EPW, TMY2, TMY3, PVGIS (typical year or hourly, CSV or JSON), NSRDB PSM, BSRN, or a plain
        CSV table; which of them is seen from the contents.

    Returns
    -------
    Weather
        Equal intervals without gaps; what was repaired is told in ``repairs``.

    Raises
    ------
    InputError
        With file, line and reason, if the file cannot be read or its values cannot be true.
    """
    source = printable(os.fspath(path))
    return checked_record(read_layout(Path(path), source), source)

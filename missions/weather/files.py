"""Weather records from files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path

from missions.files.errors import file_error, in_file, printable
from missions.files.shipped import shipped_file, shipped_names
from missions.mission import Mission
from missions.weather.record import Weather


def load_weather(path: str | os.PathLike[str], mission: Mission | None = None) -> Weather:
    """Load a weather record: light, temperature and wind at a site over time.

    Parameters
    ----------
    path : str or path
        Name of the shipped record, ``colorado-2023``, or a file: EPW, TMY2, TMY3, PVGIS (typical
        year or hourly, CSV or JSON), SAM, NSRDB PSM, BSRN, NASA POWER (CSV), ERA5 (CSV time
        series), NetCDF of ERA5, NASA POWER and others, or a plain CSV table. Which of them it is
        is seen from the contents.
    mission : Mission, optional
        Whose latitude, longitude and altitude choose the point of gridded data.

    Returns
    -------
    Weather
        Equal intervals without gaps; ``repairs`` lists repairs.

    Raises
    ------
    InputError
        With file, line and reason, if the file cannot be read or its values cannot be true.
    """
    # They read with pandas, which takes longer than a command without a record.
    from missions.weather import checks, layouts

    with weather_file(path) as (place, source), in_file(source):
        return checks.checked_record(layouts.read_layout(place, mission), source)


@contextmanager
def weather_file(path: str | os.PathLike[str]) -> Iterator[tuple[Path, str]]:
    """Yield a weather record's file while it is read, and its name for messages."""
    name = os.fspath(path)
    source = printable(name) or repr(name)
    if name in shipped_names("record") and not Path(name).exists():
        with resources.as_file(shipped_file("record", name)) as place:
            yield place, f"{name} (shipped)"
        return
    if not os.path.lexists(name):
        known = ", ".join(shipped_names("record"))
        raise file_error(source, f"there is no such file, and none is shipped but {known}")
    yield Path(name), source

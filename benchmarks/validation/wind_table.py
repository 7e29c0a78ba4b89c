"""Make the shipped table of winds from the one of AeroSandbox: ``python -m`` this module.

``missions/winds/data/zonal-p95.csv.gz`` is written from the installed package; its head says what
it is made of and what was changed.
"""

from __future__ import annotations

import gzip
from importlib import resources
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missions.air import MAXIMUM_ALTITUDE_M
from missions.winds.table import COLUMNS

_HEAD = """\
# description: 95th percentile of the wind speed over latitude, altitude and month
# source: aerosandbox {version}, library/datasets/winds_and_tropopause_global (MIT License,
# Copyright (c) 2019-2023 Peter Sharpe); its 18 altitudes are those of the pressure levels of ERA5
# from 1 to 300 hPa. Years and sampling of longitudes are not stated there.
# attribution: contains modified Copernicus Climate Change Service information. Neither the European
# Commission nor ECMWF is responsible for any use that may be made of the Copernicus information or
# data it contains.
# changes: every second latitude from 88 S to 88 N, altitudes up to 33 km, rounded to 0.01 m/s
"""
_LATITUDES = np.arange(-88, 89, 2)
_OUT = Path(__file__).parents[2] / "missions" / "winds" / "data" / "zonal-p95.csv.gz"


def table_text() -> str:
    """Head and rows of the table."""
    folder = resources.files("aerosandbox").joinpath(
        "library", "datasets", "winds_and_tropopause_global"
    )

    def array(name: str) -> NDArray[np.float64]:
        with resources.as_file(folder.joinpath(f"{name}.npy")) as path:
            return np.asarray(np.load(path), float)

    # As aerosandbox.library.winds reads them: the axes descend, the winds are flipped already.
    altitudes, latitudes = np.flip(array("altitudes")), np.flip(array("latitudes"))
    winds = array("winds_95_vs_altitude_latitude_day")
    kept = altitudes[: int(np.searchsorted(altitudes, MAXIMUM_ALTITUDE_M)) + 1]
    rows = [
        f"{latitude},{altitude:.0f},{month + 1},95,{winds[i, j, month]:.2f}"
        for latitude in _LATITUDES
        for j in [int(np.flatnonzero(latitudes == latitude)[0])]
        for i, altitude in enumerate(kept)
        for month in range(12)
    ]
    head = _HEAD.format(version=version("aerosandbox"))
    return head + ",".join(COLUMNS) + "\n" + "\n".join(rows) + "\n"


if __name__ == "__main__":
    _OUT.parent.mkdir(exist_ok=True)
    # No name and no time in the file: the same table gives the same bytes.
    _OUT.write_bytes(gzip.compress(table_text().encode(), 9, mtime=0))
    print(f"{_OUT}: {_OUT.stat().st_size / 1000:.0f} kB")

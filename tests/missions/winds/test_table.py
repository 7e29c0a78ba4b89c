"""Tables of winds: what they hold, reading between their points, and what is refused.

``era_interim_p95.csv`` has 95th percentiles of the wind over all longitudes and the years 2005 to
2015 of ECMWF's ERA-Interim, an earlier reanalysis than ERA5: Burton, M. and Hoburg, W. (2018),
Solar and gas powered long-endurance unmanned aircraft sizing via geometric programming, Journal of
Aircraft 55(1); the numbers are those of the authors' data (gassolar of convexengineering on
GitHub, ``environment/windsNS`` and ``windsS``), rounded.
"""

from pathlib import Path

import numpy as np
import pytest

from missions.air import standard_air
from missions.files.errors import InputError
from missions.winds.table import COLUMNS, shipped_winds, wind_table_from_text

HEAD = ",".join(COLUMNS)
# Rows that are no grid; as one they would take 715 GiB.
SCATTERED = "\n".join(
    [HEAD, *(f"{40 + 0.005 * i},{1000 + i},{i % 12 + 1},{50 + 0.02 * i},5" for i in range(2000))]
)
SMALL = "\n".join(
    [
        "# made up",
        HEAD,
        *(
            f"{latitude},{altitude},{month},{percentile},{latitude / 10 + altitude / 1000 + p}"
            for latitude in (40, 50)
            for altitude in (10000, 20000)
            for month in (1, 7)
            for percentile, p in ((50, 0), (90, 8))
        ),
    ]
)


def era_interim():
    return np.loadtxt(Path(__file__).with_name("era_interim_p95.csv"), delimiter=",", skiprows=1)


def shipped_at_pressure(hpa, latitude, month):
    """Shipped wind at a pressure of the standard atmosphere, as the other table has it."""
    heights = np.arange(0.0, 32000.0, 10.0)
    altitude = np.interp(-hpa, -standard_air(heights).pressure_pa / 100.0, heights)
    return shipped_winds().at(latitude, altitude, month, 95.0)


def test_shipped_winds_are_near_those_of_another_reanalysis():
    month, hpa, latitude, theirs = era_interim().T
    ratio = shipped_at_pressure(hpa, latitude, month) / theirs
    # Other years and another reanalysis. Poleward of the subtropics a fifth of the wind is a few
    # percentiles: ERA-Interim's 90th and 99th lie 7 to 15 % below and 12 to 40 % above its 95th.
    # Less agrees at the jet, where the easterlies of the tropics come and go every two years, and
    # near the poles: there only the order of magnitude and the safe side are held.
    calm = (hpa <= 100.0) & (np.abs(latitude) >= 45.0) & (np.abs(latitude) <= 70.0)
    assert calm.sum() >= 10
    assert ratio[calm] == pytest.approx(1.0, abs=0.2)
    assert np.all((ratio > 0.85) & (ratio < 1.7))
    # It errs on the side of more wind.
    assert 1.0 < np.median(ratio) < 1.25
    # Seasons and latitudes are not mixed up: over a factor of ten of speed they rise together.
    assert np.corrcoef(np.log(ratio * theirs), np.log(theirs))[0, 1] > 0.9


def test_shipped_points():
    """Numbers of the original at its own points: aerosandbox 4.2.10, printed by NumPy."""
    winds = shipped_winds()
    for latitude, altitude, month, speed in (
        (30.0, 11015.0, 1, 87.0),
        (48.0, 20340.0, 8, 10.8),
        (-60.0, 26127.0, 8, 103.1),
        (0.0, 18264.0, 6, 26.8),
    ):
        assert winds.at(latitude, altitude, month, 95.0) == pytest.approx(speed, abs=0.051)
    assert winds.months == tuple(range(1, 13))
    assert (winds.latitude_deg[0], winds.latitude_deg[-1]) == (-88.0, 88.0)
    assert np.all(winds.wind_m_per_s > 0.0)
    # Winter is windier in the stratosphere of both hemispheres.
    for latitude, winter, summer in ((60.0, 1, 7), (-60.0, 7, 1)):
        windy, calm = (winds.at(latitude, 20000.0, month, 95.0) for month in (winter, summer))
        assert windy > 3.0 * calm


def test_between_points_it_is_linear():
    winds = wind_table_from_text(SMALL, "small.csv")
    assert winds.at(44.0, 12000.0, 7, 60.0) == pytest.approx(4.4 + 12.0 + 2.0)
    assert winds.at([40.0, 50.0], [[10000.0], [20000.0]], 1, 50.0).shape == (2, 2)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ((39.9, 15000.0, 1, 60.0), r"latitude_deg 40 to 50 \(got 39.9\)"),
        ((45.0, 9999.0, 1, 60.0), r"altitude_m 10000 to 20000 \(got 9999\)"),
        ((45.0, 15000.0, 2, 60.0), "lacks the month Feb"),
        ((45.0, 15000.0, 1, 91.0), r"percentile 50 to 90 \(got 91\)"),
    ],
)
def test_nothing_is_read_beyond_the_ends(place, message):
    with pytest.raises(ValueError, match=message):
        wind_table_from_text(SMALL, "small.csv").at(*place)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "small.csv: has no line of the columns latitude_deg"),
        ("latitude,wind\n1,2", "small.csv: has no line of the columns"),
        (HEAD, "small.csv: has no row"),
        (f"{HEAD}\n40,1e4,1,50,x", "small.csv:2: wind_m_per_s: must be a number from 0 to 400"),
        (f"{HEAD}\n40,1e4,1,50,1\n\n40,1e4,1.5,90,2", "small.csv:4: month: must be a whole number"),
        (f"{HEAD}\n95,1e4,1,50,1", "small.csv:2: latitude_deg: must be a number from -90 to 90"),
        (f"{HEAD}\n40,1e4,1,50,-1", "small.csv:2: wind_m_per_s"),
        (f"{HEAD}\n40,1e4,1,50", "small.csv:2: has 4 values, but the table names 5"),
        (f"{HEAD}\n40,1e4,1,50,1\n50,1e4,2,50,1", "small.csv: lacks some of the 2 x 1 x 2 x 1"),
        (f"{HEAD}\n40,1e4,1,50,1\n40,1e4,1,50,1", "small.csv: has twice some of the 1 x 1"),
        (SCATTERED, "small.csv: lacks some of the 2000 x 2000 x 12 x 2000"),
        (f"{HEAD}\n40,1e4,1,50,2\n40,1e4,1,90,1", "a higher percentile must not be lower"),
    ],
)
def test_wrong_tables_are_refused_with_the_place(text, message):
    with pytest.raises(InputError) as refused:
        wind_table_from_text(text, "small.csv")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)

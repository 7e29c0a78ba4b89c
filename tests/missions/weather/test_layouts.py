import gzip
import re
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from weather_files import (
    SITE,
    clear_light,
    clear_record,
    minutes_behind_the_sun,
    write_bsrn,
    write_epw,
    write_plain,
    write_psm,
    write_pvgis_hourly,
    write_pvgis_tmy,
    write_pvgis_tmy_epw,
    write_pvgis_tmy_json,
    write_sam,
)

from missions.files.errors import InputError
from missions.files.shipped import shipped_names
from missions.weather.files import load_weather
from missions.weather.record import Site

pvlib = pytest.importorskip("pvlib")
PVLIB_DATA = Path(pvlib.__file__).parent / "data"
# Of a record's sum over days: digits lost in the files' decimals.
ROUNDED = 2e-3


def same_light(found, record, tolerance=ROUNDED):
    for name in ("ghi", "dni", "dhi"):
        whole = np.sum(getattr(record, name)) * record.interval_s
        assert getattr(found, name).sum() * found.interval_s == pytest.approx(whole, rel=tolerance)


SAM_COLUMNS = [
    "Year,Month,Day,Hour,GHI,DNI,DHI,Tdry,Wspd",
    "Year,Month,Day,Hour,Minute,GHI,DNI,DHI,Temperature,Wind Speed",
    "yr,mo,day,hr,global,beam,diffuse,dry bulb,wspd",
]
ZONES = [(5.5, 77.2), (5.75, 85.3), (-3.5, -52.7), (12.75, -176.5)]
PLACES = [Site("There", 28.6, east_deg, 200.0, offset_h) for offset_h, east_deg in ZONES]
MINUTES = {"first": "2016-06-01", "interval_s": 60.0, "site": replace(SITE, utc_offset_h=0.0)}


@pytest.mark.parametrize(
    ("write", "options", "record", "layout", "name"),
    [
        (write_epw, {}, {}, "EPW", "Zürich"),  # in Latin-1
        *((write_sam, {"columns": columns}, {}, "SAM", "Here") for columns in SAM_COLUMNS),
        (write_bsrn, {}, MINUTES, "BSRN", "Somewhere"),
        *((write_epw, {}, {"site": site}, "EPW", "Zürich") for site in PLACES),
        *((write_psm, {}, {"site": s, "interval_s": 1800.0}, "NSRDB PSM", "") for s in PLACES),
    ],
)
def test_layouts_are_read_with_the_start_of_their_intervals(
    tmp_path, write, options, record, layout, name
):
    made = clear_record(2, **record)
    found = load_weather(write(tmp_path / "a.txt", made, **options))
    assert (found.layout, found.site.name) == (layout, name)
    assert astuple(found.site)[1:] == pytest.approx(astuple(made.site)[1:])
    assert found.start_s == pytest.approx(made.start_s)
    same_light(found, made)
    assert abs(minutes_behind_the_sun(found)) < 1.0
    if write is not write_bsrn:  # of which they are not read
        assert found.temperature_c == pytest.approx(15.0)
        assert found.wind_m_per_s == pytest.approx(3.0)


def test_months_of_several_years_become_one_typical_year(tmp_path):
    record = clear_record(59 + 3, first="2001-01-01")
    found = load_weather(write_epw(tmp_path / "a.epw", record, years={1: 1996, 2: 1988, 3: 1979}))
    assert found.typical
    assert found.start_s == pytest.approx(record.start_s)


def test_pvgis_typical_year_has_instants_that_are_the_middles_of_their_hours(tmp_path):
    site = Site("", 45.0, 8.0, 250.0, 0.0)
    record = clear_record(365, first="2001-01-01", site=site)
    years = dict(zip(range(1, 13), range(2018, 2006, -1), strict=True))
    path = write_pvgis_tmy(tmp_path / "a.csv", record, years=years)
    found = load_weather(path)
    assert (found.layout, found.typical, found.site) == ("PVGIS typical year", True, site)
    assert found.start_s[0] - record.start_s[0] == pytest.approx(3600.0 * (0.1761 - 0.5))
    lines = [line for line in path.read_text().splitlines() if "Offset" not in line]
    path.write_text("\n".join(lines))
    assert load_weather(path).repairs[0].startswith("light taken at the full hours")


def test_pvgis_typical_year_has_the_same_times_in_every_format(tmp_path):
    record = clear_record(365, first="2001-01-01", site=Site("", 45.0, 8.0, 250.0, 0.0))
    table = load_weather(write_pvgis_tmy(tmp_path / "a.csv", record))
    for path in (
        write_pvgis_tmy_json(tmp_path / "a.json", record),
        write_pvgis_tmy_epw(tmp_path / "a.epw", record),
    ):
        found = load_weather(path)
        assert found.start_s == pytest.approx(table.start_s, abs=1e-6), path
        same_light(found, table)


@pytest.mark.parametrize("zone_h", [1.0, 0.0, -7.0])
def test_hours_of_pvgis_before_5_3_are_universal_whatever_the_zone(tmp_path, zone_h):
    record = clear_record(3, site=Site("", 45.0, 8.0, 250.0, 0.0))
    light = clear_light(record.start_s - 30.0, 60.0, record.site)  # at the full hours
    instants = replace(record, **dict(zip(("ghi", "dni", "dhi"), light, strict=True)))
    path = write_pvgis_tmy_epw(tmp_path / "a.epw", instants, zone_h=zone_h, offset_h=None)
    found = load_weather(path)
    assert found.repairs == ("hours taken as UTC, as PVGIS before 5.3 wrote them",)
    assert found.start_s == pytest.approx(record.start_s - 1800.0)
    assert abs(minutes_behind_the_sun(found)) < 2.0  # an instant is not its hour's mean


@pytest.mark.parametrize("minutes", [30, 15, 10])
def test_several_records_an_hour(tmp_path, minutes):
    record = clear_record(2, interval_s=60.0 * minutes)
    found = load_weather(write_epw(tmp_path / "a.epw", record))
    assert found.start_s == pytest.approx(record.start_s)
    same_light(found, record)
    lines = (tmp_path / "a.epw").read_text("latin-1").splitlines()
    rows = [line.split(",") for line in lines[8:]]
    begins = [",".join([*row[:4], str(int(row[4]) - minutes), *row[5:]]) for row in rows]
    (tmp_path / "b.epw").write_text("\n".join([*lines[:8], *begins]), "latin-1")
    assert load_weather(tmp_path / "b.epw").start_s == pytest.approx(record.start_s)


def test_one_or_two_of_the_three_kinds_of_light_suffice(tmp_path):
    record = clear_record(3)
    whole = load_weather(write_epw(tmp_path / "a.epw", record))
    lines = (tmp_path / "a.epw").read_text("latin-1").splitlines()
    for missing, note in (
        ([13], "ghi missing in 72 rows: from the other two"),
        ([14], "dni missing in 72 rows: from the other two"),
        ([15], "dhi missing in 72 rows: from the other two"),
        ([14, 15], "direct and diffuse light by the decomposition of Erbs et al. (1982)"),
    ):
        rows = [
            ",".join("9999" if at in missing else value for at, value in enumerate(row.split(",")))
            for row in lines[8:]
        ]
        (tmp_path / "b.epw").write_text("\n".join([*lines[:8], *rows]), "latin-1")
        found = load_weather(tmp_path / "b.epw")
        assert note in found.repairs
        # Through the sun's height in the middle of an hour, which at sunrise is not its mean.
        high = whole.ghi > 100.0
        assert found.ghi[high] == pytest.approx(whole.ghi[high], rel=0.02)
        assert abs(minutes_behind_the_sun(found)) < 2.0


def test_pvgis_hourly_takes_the_beam_back_to_its_normal(tmp_path):
    site = Site("", 45.0, 8.0, 250.0, 0.0)
    record = clear_record(3, site=site)
    found = load_weather(write_pvgis_hourly(tmp_path / "a.csv", record))
    assert found.layout == "PVGIS hourly"
    # Instants at the half hour.
    assert found.start_s == pytest.approx(record.start_s)
    same_light(found, record, 0.03)  # hourly means divided by the sun's height at the half hour


@pytest.mark.parametrize(
    ("name", "layout", "place", "kwh"),
    [
        ("723170TYA.CSV", "TMY3", (36.1, -79.95, 273.0, -5.0), 1566),
        ("12839.tm2", "TMY2", (25.8, -80.2667, 2.0, -5.0), 1793),
    ],
)
def test_typical_years_that_pvlib_brings(name, layout, place, kwh):
    found = load_weather(PVLIB_DATA / name)
    site = found.site
    assert found.layout == layout
    assert (site.latitude_deg, site.longitude_deg, site.altitude_m, site.utc_offset_h) == (
        pytest.approx(place, abs=1e-4)
    )
    assert len(found) == 8760
    assert found.ghi.sum() / 1000 == pytest.approx(kwh, abs=1)
    # Before and after true noon there is as much light, to some per cent of the year's weather: a
    # row's hour is that of the sun. A shift of an hour would be 26 % or more.
    from missions.weather.light import light_at_altitude

    light = light_at_altitude(found, site.altitude_m)
    morning = light.time_solar_h < 12.0
    sums = [np.sum((light.recorded.dni * light.cos_zenith)[part]) for part in (morning, ~morning)]
    assert sums[0] == pytest.approx(sums[1], rel=0.1)


def test_plain_table_and_the_shipped_year(tmp_path):
    record = clear_record(2)
    found = load_weather(write_plain(tmp_path / "a.csv", record))
    assert (found.layout, found.site) == ("CSV", Site("Somewhere", 46.8, 6.9, 491.0, 0.0))
    same_light(found, record, 1e-5)
    paged = replace(record, site=replace(SITE, name="Some\fwhere"))  # lines end by line feeds alone
    same_light(load_weather(write_plain(tmp_path / "b.csv", paged)), record, 1e-5)
    assert SITE.label.startswith("Somewhere (46.80° N, 6.90° E, 491 m)")
    assert shipped_names("record") == ["colorado-2023"]
    year = load_weather("colorado-2023")
    assert (len(year), year.interval_s, year.typical) == (17520, 1800.0, False)
    assert year.site.latitude_deg == 40.53


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"\0\1\2\0", "is no text file"),
        (b"hello\nworld\n", "is no weather file that is known"),
        (b"time_utc ghi\n2023-06-21T00:00Z 0\n", "is no weather file that is known"),
        (b"LOCATION,X,-,CHE,IWEC,1,95.0,6.9,1.0,491.0\n", "is no readable EPW file|latitude"),
        (b'{"inputs": {"meteo_data": 1', "is no readable PVGIS typical year file"),
        (b"*U0001\n 21  6 2016  1\n", "is no readable BSRN file"),
        (b"PK\x03\x04" + bytes(100), "is packed with zip: unpack it; allowed: gzip, or none"),
    ],
)
def test_what_is_no_weather_file_is_told_by_name(tmp_path, content, message):
    path = tmp_path / "bad.dat"
    with pytest.raises(InputError, match="there is no such file"):
        load_weather(path)
    with pytest.raises(InputError, match="is a folder"):
        load_weather(tmp_path)
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        load_weather(path)
    assert "bad.dat" in str(caught.value)


@pytest.mark.parametrize(
    ("write", "old", "new", "message"),
    [
        (write_sam, "Day,Hour", "Day,Time", r"a.csv: has no column hour"),
        (write_sam, "46.8", "146.8", r"a.csv:1: lat\w*: must be from -90 to 90"),
        (write_pvgis_hourly, "Slope: 0", "Slope: 30", "30 deg slope: ask PVGIS for a slope of 0"),
        (write_psm, "20,4,15", "20,4,15" + 20_000 * ",", r"line \d+ has more than 20000 char"),
        (write_plain, "T04", "T04" + 20_000 * ",", r"line \d+ has more than 20000 characters"),
        (write_plain, "(Z,.*)", r"\1" + 1000 * ",", r"a.csv:\d+: has 100\d values, but the tab"),
        (write_plain, ".*Z,", "yesterday,", r"a.csv:6: time_utc: must be ISO 8601 .*'yesterday'"),
        (write_plain, "46.8", "146.8", r"2: latitude_deg: must be a .* -90 to 90 \(got '146.8'\)"),
        (write_plain, "6.9", "x", r"3: longitude_deg: must be a .* -180 to 180 \(got 'x'\)"),
        (write_plain, "# altitude_m.*\n", "", r"lacks the line '# altitude_m: ...'"),
        *(
            (write_psm, r"2001,6,20,4", f"2001,{month},20,4", "is no readable NSRDB PSM")
            for month in ("1e30", "60.5", "nan")
        ),
    ],
)
def test_mistakes_in_files_are_told_without_a_warning(tmp_path, write, old, new, message, recwarn):
    path = write(tmp_path / "a.csv", clear_record(3, interval_s=1800.0))
    path.write_text(re.sub(old, new, path.read_text()))
    with pytest.raises(InputError, match=message):
        load_weather(path)
    assert not recwarn.list


CHANGES = {
    "packed": gzip.compress,
    "byte-order mark": lambda content: b"\xef\xbb\xbf" + content,
    "CRLF": lambda content: re.sub(rb"\r?\n", b"\r\n", content),
    "CR": lambda content: re.sub(rb"\r?\n", b"\r", content),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_files_may_be_packed_marked_and_end_their_lines_as_on_any_machine(tmp_path, change):
    record = clear_record(2, site=Site("Somewhere", 46.8, 6.9, 491.0, 0.0))
    minutes = clear_record(1, first="2016-06-01", interval_s=60.0, site=record.site)
    year = (PVLIB_DATA / "12839.tm2").read_bytes()
    plain = tmp_path / "a.txt"
    plain.write_bytes(b"".join(year.splitlines(keepends=True)[: 1 + 24 * 40]))
    files = [
        plain,
        write_plain(tmp_path / "a.csv", record),
        write_epw(tmp_path / "a.epw", record),
        write_psm(tmp_path / "b.csv", record),
        write_bsrn(tmp_path / "a.dat", minutes),
    ]
    for path in files:
        light = load_weather(path)
        path.write_bytes(change(path.read_bytes()))  # whatever its ending
        again = load_weather(path)
        assert (again.layout, again.site) == (light.layout, light.site)
        assert np.array_equal(again.ghi, light.ghi)


def test_names_and_reasons_are_printable(tmp_path):
    path = write_epw(tmp_path / "a.epw", clear_record(2), name="\x1b[31mRed")
    assert load_weather(path).site.name == "\\x1b[31Mred"
    path.write_bytes(path.read_bytes().replace(b"2001,6,20,3,", b"2001,6,\x1b,3,"))
    with pytest.raises(InputError) as refused:
        load_weather(path)
    assert str(refused.value).isprintable()


def test_a_file_of_the_largest_size_is_read_and_one_byte_more_is_not(tmp_path, monkeypatch):
    path = write_plain(tmp_path / "a.csv", clear_record(2))
    monkeypatch.setattr("missions.weather.raw.MAXIMUM_BYTES", path.stat().st_size)
    assert len(load_weather(path).ghi) == 48
    monkeypatch.setattr("missions.weather.raw.MAXIMUM_BYTES", path.stat().st_size - 1)
    with pytest.raises(InputError, match="is larger than"):
        load_weather(path)
    path.write_bytes(gzip.compress(path.read_bytes()))
    with pytest.raises(InputError, match=r"a.csv: is larger than \d+ MB when it is unpacked"):
        load_weather(path)

from dataclasses import replace

import numpy as np
import pytest
from weather_files import SITE, clear_record, write_plain

from missions.files.errors import InputError
from missions.weather.checks import _diffuse_fraction
from missions.weather.files import load_weather
from missions.weather.record import day_of_year
from solar.sun import cos_zenith, declination, hour_angle, solar_time_h


def load(tmp_path, record, **changes):
    return load_weather(write_plain(tmp_path / "a.csv", record, **changes))


def with_fields(row, **fields):
    names = ["time", "ghi", "dni", "dhi"]
    values = dict(zip(names, row.split(","), strict=True)) | fields
    return ",".join(str(values[name]) for name in names)


def replaced(number, **fields):
    """Make a change of the fields of one row."""
    return lambda rows: [*rows[:number], with_fields(rows[number], **fields), *rows[number + 1 :]]


@pytest.mark.parametrize(
    ("days", "change", "message"),
    [
        # Five lines of head, so that row 9 stands on line 14.
        (2, lambda r: [*r[:7], r[8], r[7], *r[9:]], r"a.csv:14: .* goes back in time"),
        (2, lambda r: [*r[:9], r[8], *r[9:]], "is the same as before"),
        (70, lambda r: [*r[:60], *r[210:]], r"gap of 6.\d days from 2001-06-2.* at most 5 days"),
        # Two rows at noon, six days and six hours, two rows at noon again.
        (70, lambda r: [*r[:34], *r[36:231], *r[381:418], *r[420:]], r"6.\d days from 2001-06-29"),
        (10, lambda r: [with_fields(row, ghi=5000) for row in r], r"time zone or the unit wrong"),
        (2, replaced(9, ghi="24:00"), r"a.csv:15: ghi: must be a number \(got '24:00'\)$"),
        (2, replaced(9, dhi="0.1-4"), r"a.csv:15: dhi: must be a number \(got '0.1-4'\)$"),
        (2, replaced(9, time="1677-06-20T09:00Z"), r"a.csv:15: time\S*: .*got '?1677"),
        (3, lambda r: [*r, "2061-05-01T00:00:00Z,0,0,0"], "a gap of"),
        (3, lambda r: [*r, "2061-09-01T00:00:00Z,0,0,0"], "more than 60 years"),
    ],
)
def test_rows_that_cannot_be_are_refused(tmp_path, days, change, message):
    with pytest.raises(InputError, match=message):
        load(tmp_path, clear_record(days), changed=change)


def test_short_gaps_follow_the_clear_sky(tmp_path):
    record = clear_record(3, share=0.6)
    weather = load(tmp_path, record, changed=lambda rows: [*rows[:34], *rows[36:]])
    assert "2 of 72 rows are missing" in weather.repairs
    assert "2 rows filled between their neighbours" in weather.repairs
    # A gap at noon under an evenly dimmed sky is filled exactly, but that the clear sky in the
    # middle of an hour is not its mean.
    assert weather.dni == pytest.approx(record.dni, rel=1e-3, abs=0.01)
    assert weather.dhi == pytest.approx(record.dhi, rel=1e-3, abs=0.01)


def test_of_rows_in_one_place_the_last_counts(tmp_path):
    record = clear_record(3, share=0.6)

    def doubled(rows):
        again = with_fields(rows[34], time=rows[34].replace(":00Z", ":30Z").split(",")[0], ghi=7)
        return [*rows[:35], again, *rows[35:40], *rows[42:]]

    weather = load(tmp_path, record, changed=doubled)
    assert weather.ghi[34] == 7.0
    assert weather.ghi[33] == pytest.approx(record.ghi[33], abs=1e-3)
    assert "2 of 72 rows are missing" in weather.repairs


def test_long_gaps_take_the_nearest_day(tmp_path):
    record = clear_record(70, share=0.6)
    weather = load(tmp_path, record, changed=lambda rows: [*rows[:100], *rows[116:]])
    # No light is missing at night.
    daylight_rows = np.count_nonzero(record.ghi[100:116])
    assert f"{daylight_rows} rows of long gaps filled from the nearest days" in weather.repairs
    assert not any("between their neighbours" in text for text in weather.repairs)
    assert weather.ghi.sum() == pytest.approx(record.ghi.sum(), rel=0.01)  # the days are alike


def test_nights_without_rows_are_no_gaps(tmp_path):
    record = clear_record(5)

    def daylight_rows(rows):
        return [row for row, light in zip(rows, record.ghi, strict=True) if light > 0.0]

    weather = load(tmp_path, record, changed=daylight_rows)
    assert weather.ghi.sum() == pytest.approx(record.ghi.sum(), rel=1e-4)
    assert not any("filled" in text for text in weather.repairs)


def test_noise_of_the_night_is_taken_out_and_counted(tmp_path):
    record = clear_record(3)

    def noisy(rows):
        return [
            with_fields(row, ghi=-4.0) if light == 0.0 else row
            for row, light in zip(rows, record.ghi, strict=True)
        ]

    weather = load(tmp_path, record, changed=noisy)
    dark = int(np.count_nonzero(record.ghi == 0.0))
    assert f"noise at night or below zero in {dark} rows set to zero" in weather.repairs
    assert weather.ghi.min() == 0.0


def test_few_impossible_values_are_replaced(tmp_path):
    record = clear_record(10)
    weather = load(tmp_path, record, changed=replaced(35, dni=1e6))
    assert "1 rows with impossible light taken out" in weather.repairs
    # Closure: the beam is what global and diffuse light leave, at the sun's height of half past.
    assert weather.dni == pytest.approx(record.dni, rel=0.01, abs=1.0)


def test_a_wrong_zone_and_a_record_without_sun_do_not_pass_in_silence(tmp_path):
    record = clear_record(4)
    shifted = replace(record, start_s=record.start_s + 8 * 3600.0)
    with pytest.raises(InputError, match="time zone"):
        load(tmp_path, shifted)
    with pytest.raises(InputError, match="without sun"):
        load(tmp_path, clear_record(3, share=0.0))


def test_day_of_year_counts_dates_alike_in_leap_years():
    dates = ["2001-03-01T00:00", "2004-03-01T00:00", "2004-02-29T12:00", "2004-12-31T18:00"]
    seconds = np.array(dates, "datetime64[s]").astype(float)
    assert day_of_year(seconds) == pytest.approx([60.0, 60.0, 59.5, 365.75])


def loaded_beside(tmp_path, temperature, wind):
    """Load a record with temperature and wind beside the light."""
    head = ["# latitude_deg: 46.8", "# longitude_deg: 6.9", "# altitude_m: 491"]
    head.append("time_utc,ghi,dni,dhi,temperature_c,wind_m_per_s")

    def beside(rows):
        return [f"{row},{t},{w}" for row, t, w in zip(rows, temperature, wind, strict=True)]

    return load(tmp_path, clear_record(3), header=head, changed=beside)


@pytest.mark.parametrize(
    ("temperature", "wind", "expected"),
    [
        (-272.0, 3.0, r"a.csv:5: temp_air: 72 of 72 rows have a temperature not from -90 to 70"),
        (288.0, 3.0, "is the unit wrong"),
        (15.0, 500.0, r"a.csv:5: wind_speed: 72 of 72 rows have a wind speed not from 0 to 120"),
        (15.0, -1.0, "wind speed not from"),
        # Pandas before version 3 takes it for text.
        pytest.param("9" * 400, 3.0, "temperature not from|must be a number", id="400 digits"),
    ],
)
def test_air_that_cannot_be_is_refused(tmp_path, temperature, wind, expected):
    with pytest.raises(InputError, match=expected):
        loaded_beside(tmp_path, [temperature] * 72, [wind] * 72)


def test_what_is_left_out_of_the_air_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("missions.weather.checks.MAXIMUM_IMPOSSIBLE", 0.02)
    weather = loaded_beside(tmp_path, [-9999, *([15.0] * 71)], [500.0, *([3.0] * 71)])
    assert weather.repairs == (
        "temperature missing in 1 of 72 rows: filled between their neighbours",
        "1 rows with a wind speed not from 0 to 120 m/s taken out",
    )
    assert (weather.temperature_c.max(), weather.wind_m_per_s.max()) == (15.0, 3.0)
    # What is at the ends of what can be is kept.
    weather = loaded_beside(tmp_path, [-90.0, 70.0, *([20.0] * 70)], [3.0] * 72)
    assert weather.temperature_c[:2].tolist() == [-90.0, 70.0]
    weather = loaded_beside(tmp_path, [99.9] * 72, [999] * 19 + [99.9] + [3.0] * 52)
    assert weather.repairs == (
        "temperature missing in 72 of 72 rows: that of the mission's air",
        "wind speed missing in 20 of 72 rows: not used",
    )
    assert weather.wind_m_per_s is weather.temperature_c is None


def test_two_months_of_two_years_are_a_typical_year_and_one_month_is_none(tmp_path):
    record = clear_record(59, first="2001-01-01", site=replace(SITE, utc_offset_h=0.0))

    def february_of(year):
        return lambda rows: [row.replace("2001-02", f"{year}-02") for row in rows]

    weather = load(tmp_path, record, changed=february_of(1993))
    assert weather.typical
    # A year without 29 February: the rows follow each other as those of 2001 do.
    assert np.diff(weather.start_s) == pytest.approx(3600.0)
    with pytest.raises(InputError, match="goes back in time"):
        load(
            tmp_path,
            clear_record(8, first="2001-01-10"),
            changed=lambda rows: [*rows[:96], *(row.replace("2001", "1993") for row in rows[96:])],
        )


def test_a_beam_is_told_of_the_sun_from_one_degree_on(tmp_path):
    record = clear_record(2, interval_s=60.0)
    weather = load(
        tmp_path, record, changed=lambda rows: [with_fields(row, dni="") for row in rows]
    )
    day = day_of_year(weather.start_s + 30.0)
    hour = solar_time_h((day % 1.0) * 24.0, day, SITE.longitude_deg)
    height = np.degrees(
        np.arcsin(cos_zenith(SITE.latitude_deg, declination(day), hour_angle(hour)))
    )
    low, higher = (height > 0.2) & (height < 0.95), (height > 1.1) & (height < 3.0)
    assert min(np.count_nonzero(low), np.count_nonzero(higher)) > 10
    # Below, what the light lacks of the diffuse is divided by next to nothing.
    assert not weather.dni[low].any()
    # Light is written to 0.001 W/m2, over a sine of 0.02.
    assert weather.dni[higher] == pytest.approx(record.dni[higher], rel=0.02, abs=0.1)


# Erbs et al. (1982), equation 1, worked by hand.
@pytest.mark.parametrize(
    ("clearness", "share"),
    [(0.2, 0.982), (0.3, 0.9485956), (0.5, 0.65915), (0.79, 0.16463391), (0.9, 0.165)],
)
def test_share_of_diffuse_light(clearness, share):
    fraction = _diffuse_fraction(np.array([1000.0 * clearness, 3.0]), np.array([1000.0, 0.0]))
    # Light without a sun is diffuse.
    assert fraction == pytest.approx([share, 1.0], abs=1e-8)

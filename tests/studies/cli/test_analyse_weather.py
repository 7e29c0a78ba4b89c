import csv
import io

import pytest
from weather_files import clear_record, write_epw, write_plain

from missions.weather.files import load_weather

AS2 = "atlantiksolar-as2"


@pytest.mark.long
def test_a_record_is_flown_through_and_told(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(6, first="2001-07-14"))
    table, figure = tmp_path / "days.csv", tmp_path / "days.png"
    done = run("analyse", AS2, "--weather", path, "--csv", table, "--plot", figure)
    assert done.code == 0
    assert "6 of 6 days close" in done.out
    assert "(default mission)" in done.out
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert rows[0]["date"] == "07-14"
    assert all(row["closes"] == "True" for row in rows)
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_json_has_the_record_beside_the_clear_day(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(6, first="2001-07-14"))
    record = run("analyse", AS2, "--weather", path, "--json").json()
    weather = record["weather"]
    assert {"site", "days", "days_that_close", "clear_sky_days_that_close"} <= set(weather)
    assert {"longest_run_days", "endurance_h"} <= set(weather)
    assert set(weather["endurance_h"]) == {"p10", "p50", "p90"}
    assert record["latitude_deg"] == 46.8
    assert record["status"] == "perpetual"


def test_mistakes_end_with_two_and_one_line(run, tmp_path):
    missing = run("analyse", AS2, "--weather", tmp_path / "none.epw")
    assert missing.code == 2
    assert "none.epw: there is no such file" in missing.err
    far = run("analyse", AS2, "-m", "rafz-july", "--weather", "colorado-2023")
    assert far.code == 2
    assert "km from the mission rafz-july; allowed: up to 1000 km" in far.err
    moved = run("analyse", AS2, "--latitude", "10", "--weather", "colorado-2023")
    assert moved.code == 2
    assert "a weather record has its own place" in moved.err
    assert "Traceback" not in missing.err + far.err + moved.err


def test_options_without_effect_are_refused(run, tmp_path):
    for option, value in (("--date", "06-21"), ("--day-of-year", "172")):
        told = run("analyse", AS2, option, value, "--weather", "colorado-2023")
        assert told.code == 2
        assert f"a weather record has its own days: give {option} or --weather" in told.err
    told = run("analyse", AS2, "--table-years", "years.csv")
    assert (told.code, "--table-years needs --weather" in told.err) == (2, True)
    record = clear_record(59, first="2001-01-01", interval_s=3600.0)
    typical = write_epw(tmp_path / "typical.epw", record, years={1: 1996, 2: 1988})
    told = run("analyse", AS2, "--weather", typical, "--table-years", "years.csv")
    assert (told.code, "this is a typical year" in told.err) == (2, True)


def test_years_are_written_a_row_each(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(6, first="2001-07-14"))
    table = tmp_path / "years.csv"
    assert run("analyse", AS2, "--weather", path, "--table-years", table).code == 0
    (row,) = csv.DictReader(io.StringIO(table.read_text()))
    assert (row["year"], row["days"], row["days_that_close"], row["whole"]) == (
        *("2001", "6", "6"),
        "False",
    )


def test_shipped_records_are_listed_and_shown(run, tmp_path):
    assert "colorado-2023" in run("list").out
    assert set(run("list", "--json").json()["weather"]) == {"colorado-2023"}
    text = run("show", "colorado-2023").out
    copy = tmp_path / "mine.csv"
    copy.write_text(text)
    assert len(load_weather(copy)) == 17520
    missing = run("analyse", AS2, "--weather", "colorado")
    assert missing.code == 2
    assert "there is no such file, and none is shipped but colorado-2023" in missing.err
    nameless = run("analyse", AS2, "--weather", "")
    assert nameless.code == 2
    assert nameless.err.startswith("'': there is no such file")


def test_what_plays_no_part_in_a_record_is_said(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(3, first="2001-07-14"))
    out = run("analyse", AS2, "-m", "rafz-28h", "--weather", path).out
    assert "the mission's launch plays no part" in out


def test_climbs_in_a_record_are_refused_in_one_line(run, tmp_path):
    path = str(write_plain(tmp_path / "clear.csv", clear_record(3, first="2001-07-14")))
    done = run("analyse", AS2, "--set", "mission.climb={ceiling_m: 3000}", "--weather", path)
    assert done.code == 2
    assert "keep their altitude: leave out climb" in done.err
    assert len(done.err.strip().splitlines()) == 1

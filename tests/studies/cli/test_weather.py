import csv
import io
import json

import pytest
from weather_files import clear_record, write_plain

from missions.weather.files import load_weather

AS2 = "atlantiksolar-as2"


@pytest.mark.long
def test_a_record_is_flown_through_and_told(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(6, first="2001-07-14"))
    table, figure = tmp_path / "days.csv", tmp_path / "days.png"
    done = run("analyse", AS2, "--weather", path, "--csv", table, "--plot", figure).good()
    assert "6 of 6 days close" in done.out
    assert "(default mission)" in done.out
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert rows[0]["date"] == "07-14"
    assert all(row["closes"] == "True" for row in rows)
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_json_has_the_record_beside_the_clear_day(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(6, first="2001-07-14"))
    record = run("analyse", AS2, "--weather", path, "--json").json()
    assert set(record["weather"]["endurance_h"]) == {"p10", "p50", "p90"}
    assert record["latitude_deg"] == 46.8
    assert record["status"] == "perpetual"


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


def test_what_plays_no_part_in_a_record_is_said(run, tmp_path):
    path = write_plain(tmp_path / "clear.csv", clear_record(3, first="2001-07-14"))
    out = run("analyse", AS2, "-m", "rafz-28h", "--weather", path).out
    assert "the mission's launch plays no part" in out


# ---- sizing for a record


DESIGN = "atlantiksolar-design"
PLACE = ("--set", "mission.latitude_deg=46.8", "--set", "mission.altitude_m=491")
JULY = ("-m", "rafz-july", *PLACE, "--set", "mission.dates={from: 07-15, to: 07-17}")


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    made = clear_record(7, first="2001-07-13", share=0.8)
    return str(write_plain(tmp_path_factory.mktemp("weather") / "hazy.csv", made))


@pytest.mark.slow
def test_a_season_is_sized_for_told_and_written(run, record, tmp_path):
    folder = tmp_path / "sized"
    call = ("size", DESIGN, *JULY, "--weather", record)
    done = run(*call, "--survive", "1", "--out", str(folder))
    assert done.code == 0
    assert "in the weather of Somewhere" in " ".join(done.out.split())
    assert "15 Jul to 17 Jul: 3 of 3, 100.0 % (required 100 %)" in " ".join(done.out.split())
    written = json.loads((folder / "results.json").read_text())
    assert written["weather"]["days_that_close"] == 3
    assert len(json.loads((folder / "run.json").read_text())["inputs"]["weather"]["sha256"]) == 64
    # The folder stands for the design at the record's site.
    again = run("analyse", str(folder), "--weather", record, "--json").json()
    assert again["weather"]["days_that_close"] >= 3
    assert again["total_mass_kg"] == pytest.approx(written["total_mass_kg"], rel=1e-6)

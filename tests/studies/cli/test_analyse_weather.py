import csv
import io

from weather_files import clear_record, write_plain

AS2 = "atlantiksolar-as2"


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

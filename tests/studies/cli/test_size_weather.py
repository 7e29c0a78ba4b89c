import json

import pytest
from weather_files import clear_record, write_plain

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

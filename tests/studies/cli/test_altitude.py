"""Ceiling and climbs on the command line: results, files, messages and exit codes."""

import pandas as pd
import pytest

pytestmark = pytest.mark.slow

AS2 = "atlantiksolar-as2"


def test_ceiling_writes_table_and_figure(run, tmp_path):
    outcome = run("ceiling", AS2, "--step", "4000", "--csv", "a.csv", "--plot", "a.png").good()
    assert "perpetual flight up to" in outcome.out
    table = pd.read_csv(tmp_path / "a.csv")
    assert list(table["altitude_m"]) == [536.0, 4000.0, 8000.0, 12000.0, 16000.0, 20000.0]
    assert (table["propulsion_power_w"].diff().dropna() > 0.0).all()
    record = run("ceiling", AS2, "--step", "4000", "--json").json()
    assert f"perpetual flight up to {record['highest_perpetual_altitude_m']:.0f} m" in outcome.out
    assert [one["altitude_m"] for one in record["altitudes"]] == list(table["altitude_m"])
    assert (record["required_excess_time_h"], record["at_search_limit"]) == (0.0, False)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_no_ceiling_is_exit_code_one(run, tmp_path):
    arguments = ["--set", "power.avionics_w=60", "--step", "5000", "--plot", "none.svg"]
    outcome = run("ceiling", "sky-sailor", *arguments)
    assert outcome.code == 1
    assert "no perpetual flight from 0 to 20000 m" in " ".join(outcome.out.split())
    assert (tmp_path / "none.svg").exists()


def test_a_search_that_starts_above_the_ceiling_goes_down_to_it(run):
    standard = ("ceiling", AS2, "--set", "mission.air={}")
    from_above = run(*standard, "--set", "mission.altitude_m=12000")
    printed = " ".join(from_above.out.split())
    assert from_above.code == 0
    # From either side to 0.1 m.
    up_to = run(*standard, "--json").json()["highest_perpetual_altitude_m"]
    assert f"up to {up_to:.0f} m, below the mission's 12000 m" in printed
    # Rows end where the day has no power at all; the headline has it as well.
    hopeless = run(*standard, "--set", "mission.clearness=0.05", "--set", "mission.altitude_m=9000")
    assert hopeless.code == 1
    assert " ".join(hopeless.out.split()).count("-24.00") == 2

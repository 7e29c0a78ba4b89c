"""Tests of ``solar-uav efficiencies`` and ``loiter-correction``: numbers, files and mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_line import Run, files

from missions.library import load_mission
from missions.loiter_power import Daylight, FlownModules, mean_power_on_path
from sizing.library import load_aircraft

AS2 = "atlantiksolar-as2"


def test_efficiencies_belong_to_the_power_on_the_path(run: Run, tmp_path: Path) -> None:
    outcome = run("efficiencies", AS2, "--csv", "e.csv", "--plot", "e.png")
    assert (outcome.code, outcome.err) == (0, "")
    assert files(tmp_path) == {"e.csv", "e.png"}
    assert (tmp_path / "e.png").read_bytes().startswith(b"\x89PNG")
    table = pd.read_csv(tmp_path / "e.csv")
    modules, mission = load_aircraft(AS2).modules, load_mission("rafz-loiter")
    assert modules.geometry is not None
    assert mission.flight_path is not None
    assert sorted(set(table["surface"])) == sorted(s.name for s in modules.geometry.surfaces)
    by_time = table.drop_duplicates("time")
    scenarios = mission.scenarios()
    power = mean_power_on_path(
        "FM",
        FlownModules(modules.geometry, modules, mission.flight_path, mission.wind),
        Daylight(
            float(scenarios.latitude_deg[0]),
            float(scenarios.noon_day[0]),
            by_time["time"].to_numpy(),
            mission.altitude_m,
            mission.clearness,
        ),
        ambient_temperature_c=float(mission.air_state().temperature_c),
        module_temperature_c=mission.module_temperature_c(),
    )
    # The same model averaged by other code; the file has all digits.
    np.testing.assert_allclose(by_time["specific_power"], power, rtol=1e-9)
    shares = [name for name in table if name.endswith("_efficiency")]
    assert len(shares) == 5
    # Modules colder than 25 C are a little better than rated.
    assert table[shares].to_numpy().min() >= 0.0
    assert table[shares].to_numpy().max() < 1.05


def test_efficiencies_need_module_surfaces(run: Run, tmp_path: Path) -> None:
    outcome = run("efficiencies", "sky-sailor", "--csv", "e.csv")
    assert (outcome.code, outcome.out) == (2, "")
    assert "needs the module surfaces" in outcome.err
    assert files(tmp_path) == set()


@pytest.mark.parametrize("command", [("efficiencies", AS2), ("loiter-correction", AS2)])
def test_path_is_needed(run: Run, tmp_path: Path, command: tuple[str, ...]) -> None:
    (tmp_path / "bare.yaml").write_text("name: bare\nlatitude_deg: 45.0\ndates: {on: 06-21}\n")
    outcome = run(*command, "-m", "bare.yaml")
    assert (outcome.code, outcome.out) == (2, "")
    assert "needs a flight path" in outcome.err


@pytest.mark.long
def test_loiter_correction_covers_both_models_and_says_how_wind_spreads(
    run: Run, tmp_path: Path
) -> None:
    outcome = run("loiter-correction", "--json", "--markdown", "t.md")
    assert (outcome.code, outcome.err) == (0, "")
    rows = outcome.json()["errors"]
    assert {row["model"] for row in rows} == {"CDM", "CAM"}
    for row in rows:
        # On a circle without wind no direction is another; with wind they differ.
        assert (row["half_range"] < 1e-9) == (row["wind_m_per_s"] == 0.0)
    winds = {row["wind_m_per_s"] for row in rows}
    text = (tmp_path / "t.md").read_text(encoding="utf-8")
    assert text.count("\n|") + 1 == len(rows) / len(winds) + 2


def test_season_as_table_and_as_file(run: Run, tmp_path: Path) -> None:
    outcome = run("published", "--season", "--csv", "s.csv", "--markdown", "s.md")
    assert (outcome.code, outcome.err) == (0, "")
    assert files(tmp_path) == {"s.csv", "s.md"}
    table = pd.read_csv(tmp_path / "s.csv")
    assert table["perpetual_days"].max() <= 365
    assert (tmp_path / "s.md").read_text(encoding="utf-8").count("\n") == len(table) + 2


def test_explanation_and_season_are_two_tables(run: Run, tmp_path: Path) -> None:
    outcome = run("published", "--season", "--explain")
    assert (outcome.code, outcome.out) == (2, "")
    assert "give --explain or --season, not both" in outcome.err
    outcome = run("published", "--season", "--csv", "a", "--markdown", "a")
    assert outcome.code == 2
    assert "name the same file" in outcome.err
    assert files(tmp_path) == set()

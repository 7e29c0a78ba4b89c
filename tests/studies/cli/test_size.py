"""Tests of ``solar-uav size``: results, files and exit codes."""

import re

import pandas as pd
import pytest
from command_line import files

pytestmark = pytest.mark.slow

DESIGN = "atlantiksolar-design"
LONGEST = ("--objective", "max_excess_time")
SIZE_KEYS = {
    *("wingspan_m", "battery_mass_kg", "module_area_m2", "aspect_ratio", "total_mass_kg"),
    *("masses_kg", "power_out_w", "objective", "worst_scenario", "active_constraints"),
    *("status", "simulated", "solver"),
}
SIZED_FILES = {
    *("aircraft.yaml", "mission.yaml", "run.json", "results.json", "scenarios.csv"),
    *("masses.csv", "cycle.png", "masses.png", "flight-envelope.png"),
}


def test_sizing_as_json(run):
    record = run("size", DESIGN, "-m", "rafz-july", *LONGEST, "--json").good().json()
    assert record.keys() >= SIZE_KEYS
    assert record["status"] == "optimal"
    assert sum(record["masses_kg"].values()) == pytest.approx(record["total_mass_kg"], rel=1e-6)
    assert record["solver"].keys() >= {"iterations", "time_s"}
    assert record["active_constraints"]
    # The simulator has the last word on what the program found.
    assert record["objective"]["value"] == record["simulated"]["excess_time_h"]


def test_the_least_mass_with_the_required_excess_time_is_what_is_sized_for(run):
    asked = ("size", DESIGN, "-m", "rafz-july", "--json")
    record = run(*asked, "--set", "mission.required_excess_time_h=2").json()
    assert record["objective"]["name"] == "min_mass"
    assert record["objective"]["required_excess_time_h"] == 2.0
    assert record["simulated"]["excess_time_h"] == pytest.approx(2.0, abs=0.1)
    assert not [name for name in record["active_constraints"] if " at its " in name]
    by_option = run(*asked, "--required-excess-time", "2").json()
    assert by_option["total_mass_kg"] == record["total_mass_kg"]


def test_files_of_a_sizing(run, tmp_path):
    folder = tmp_path / "new" / "design"
    outcome = run("size", DESIGN, "-m", "rafz-july", "--json", "--out", str(folder)).good()
    assert files(folder) == SIZED_FILES
    assert files(folder.parent) == {"design"}
    record = outcome.json()
    masses = pd.read_csv(folder / "masses.csv")
    assert list(masses) == ["item", "mass_kg"]
    assert masses["mass_kg"].sum() == pytest.approx(record["total_mass_kg"], rel=1e-6)
    scenarios = pd.read_csv(folder / "scenarios.csv")
    assert {"latitude_deg", "day_of_year", "excess_time_h"} <= set(scenarios)
    excess_h = record["simulated"]["excess_time_h"]
    assert scenarios["excess_time_h"].min() == pytest.approx(excess_h, rel=1e-9)
    for figure in ("cycle.png", "masses.png"):
        assert (folder / figure).read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    # An optimum sized again stays to three digits.
    again = run("size", str(folder / "aircraft.yaml"), "-m", "rafz-july", "--json").json()
    assert again["wingspan_m"] == pytest.approx(record["wingspan_m"], rel=1e-3)


def test_excess_time_without_end_is_null_and_told_in_words(run, tmp_path):
    # At the pole in June the sun stays at 23 degrees: the battery is never needed.
    place = ("--set", "mission.latitude_deg=90", "--set", "mission.dates={on: 06-21}")
    asked = ("size", DESIGN, "-m", "rafz-july", *LONGEST, *place)
    asked += ("--sensitivities", "--cross-check")
    record = run(*asked, "--json", "--out", "pole").good().json()
    assert record["status"] == "optimal"
    assert record["objective"]["value"] is None
    assert record["sensitivities"] == []
    assert record["cross_check"]["cross_checked"]
    assert record["cross_check"]["advantage"] == 0.0
    assert files(tmp_path / "pole") == SIZED_FILES
    text = run(*asked, "-v").good()
    assert "unlimited excess time" in text.out
    assert re.search(r"\b(inf|nan)\b", text.out) is None


@pytest.mark.parametrize(
    ("override", "requirement"),
    [
        ("mission.payload.mass_kg=1e6", "mass_budget"),
        ("modules.efficiency_stc=0.01", "energy_balance"),
        ("design_space.maximum_wing_loading_kg_per_m2=0.001", "wing_loading_kg_per_m2_maximum"),
    ],
)
def test_infeasible_sizing_says_why_and_writes_nothing(run, tmp_path, override, requirement):
    options = ("--out", "design", "--set", override, "--json")
    outcome = run("size", DESIGN, "-m", "rafz-july", *options)
    assert (outcome.code, outcome.err) == (1, "")
    assert files(tmp_path) == set()
    record = outcome.json()
    assert record.keys() >= SIZE_KEYS
    assert record["status"] == "infeasible"
    assert record["wingspan_m"] is None
    assert requirement in [v["requirement"] for v in record["violated_requirements"]]


def test_a_result_is_printed_and_written_where_figures_and_report_fail(run, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise OSError("cannot be drawn")

    usual = run("size", DESIGN, "-m", "rafz-july")
    monkeypatch.setattr("studies.output.sizing_files.plot_masses", fail)
    monkeypatch.setattr("studies.report.document.render", fail)
    figures = run("size", DESIGN, "-m", "rafz-july", "--out", "d")
    report = run("size", DESIGN, "-m", "rafz-july", "--report", "r.html")
    for outcome in (figures, report):
        assert (outcome.code, outcome.err) == (1, "solar-uav: cannot be drawn\n")
        assert outcome.out.splitlines()[0] == usual.out.splitlines()[0]
        assert "written to" not in outcome.out
    kept = {"aircraft.yaml", "mission.yaml", "run.json", "results.json"}
    assert files(tmp_path / "d") == kept | {"scenarios.csv", "masses.csv"}
    assert not (tmp_path / "r.html").exists()


def test_a_result_is_written_before_the_other_models_are_asked(run, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise OSError("no memory")

    monkeypatch.setattr("studies.models.solar_models.perpetual_by_model", fail)
    outcome = run("size", DESIGN, "-m", "rafz-july", "--out", "d")
    assert (outcome.code, outcome.err) == (1, "solar-uav: no memory\n")
    assert (tmp_path / "d" / "results.json").exists()

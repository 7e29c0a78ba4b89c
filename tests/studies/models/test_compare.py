"""Comparison of models: numbers of single analyses, files, messages and exit codes."""

import json
from itertools import product

import pytest

from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.performance import performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from sizing.results.analysis import analyse
from studies.maps.season import Season
from studies.models import comparison as study
from studies.models import solar_models
from studies.models.plots import plot_comparison, spans

pytestmark = pytest.mark.slow

AS2, DESIGN, SUMMER = "atlantiksolar-as2", "atlantiksolar-design", "central-europe-summer"
VM = SolarModel("VM")
AIRCRAFT, MISSION = load_aircraft(DESIGN), load_mission(SUMMER)


@pytest.fixture(scope="module")
def designs():
    models = [SolarModel("CDM"), SolarModel("CAM", "report"), SolarModel("FM", "report")]
    return study.compare(AIRCRAFT, MISSION, models=models, required_excess_time_h=3.0)


def test_predictions_are_those_of_single_analyses(designs):
    for case in designs.cases:
        single = performance(AIRCRAFT, MISSION, case.solar)
        worst = single.worst_scenario()
        p = case.prediction
        assert p.scenario == single.day.scenarios.label(worst)
        assert p.excess_time_h == pytest.approx(single.cycle.excess_time_h[worst], rel=1e-9)
        assert p.solar_energy_wh == pytest.approx(
            single.cycle.energy_budget.solar_wh[worst], rel=1e-9
        )
        assert p.mean_solar_energy_wh == pytest.approx(
            single.cycle.energy_budget.solar_wh.mean(), rel=1e-9
        )
        assert p.excess_time_low_h < p.excess_time_h < p.excess_time_high_h


def test_designs_are_those_of_single_sizings_judged_by_the_reference(designs):
    reference = SolarModel("FM", "report")
    assert designs.reference.solar == reference
    for case in designs.cases:
        built = case.built
        alone = size_aircraft(
            AIRCRAFT, MISSION, Objective.min_wingspan, case.solar, required_excess_time_h=3.0
        )
        # The sun differs in its last digits; the solver's tolerance is 1e-8.
        assert built.sizing.design.variables.wingspan_m == pytest.approx(
            alone.design.variables.wingspan_m, rel=1e-5
        )
        judged = performance_of_designs(AIRCRAFT, MISSION, built.sizing.design.variables, reference)
        worst = judged.worst_scenario()
        assert built.judged.excess_time_h == pytest.approx(
            judged.cycle.excess_time_h[worst], rel=1e-6
        )
        expected = judged.endurance_h[worst]
        # The longest flight is found to within seconds, of some hours.
        assert built.judged.endurance_h == pytest.approx(expected, rel=1e-3)


def test_headline_where_the_reference_is_the_only_case():
    only = [SolarModel("FM", "report")]
    built = study.compare(AIRCRAFT, MISSION, models=only, required_excess_time_h=3.0)
    assert built.headline().startswith(f"Sized with corrected FM, {DESIGN} has a span of 4.")
    assert "judged" not in built.headline()
    as_given = study.compare(AIRCRAFT, MISSION, models=only, design=False)
    assert as_given.headline().startswith(
        f"According to corrected FM {DESIGN} flies perpetually in every"
    )


def test_headline_where_nothing_is_feasible():
    aircraft = load_aircraft(DESIGN, ["design_space.wingspan_m.maximum=4.1"])
    both = study.compare(aircraft, MISSION, models=[SolarModel("CDM")], required_excess_time_h=3.0)
    built = both.cases[0].built
    assert both.headline() == (
        f"Sized with uncorrected CDM, {DESIGN} has a span of "
        f"{built.sizing.objective_value:.2f} m; evaluated by corrected FM it "
        f"{built.judged.outcome(3.0)} (sized with corrected FM: no design)."
    )
    none = study.compare(aircraft, MISSION, models=[SolarModel("CDM")], required_excess_time_h=9.0)
    assert none.headline() == (
        f"Sized with uncorrected CDM, no design of {DESIGN} meets the requirements (sized with "
        "corrected FM: no design)."
    )
    assert none.to_dict()["cases"][0]["design"]["judged"] is None
    assert "no design" in str([t.get_text() for t in plot_comparison(none).axes[3].texts])


def test_figure_names_its_axes_and_marks_who_comes_down(designs):
    figure = plot_comparison(designs)
    labels = [axes.get_xlabel().split()[0] for axes in figure.axes]
    assert labels == ["solar", "excess", "perpetual", "design:"]
    assert all("[" in axes.get_xlabel() or "days" in axes.get_xlabel() for axes in figure.axes)
    crosses = [line for line in figure.axes[3].lines if line.get_marker() == "x"]
    down = [c for c in designs.cases if c.built and c.built.judged and not c.built.judged.perpetual]
    assert len(crosses) == len(down) == 1


def test_season_over_the_years_end_is_drawn_in_two_parts():
    assert spans(Season(126, 126, 300, 60)) == [(1, 60), (300, 365)]
    assert spans(Season(3, 0, None, None)) == []


def test_rows_of_a_report_belong_to_the_scenario_they_name(designs):
    worst, every = designs.scenario_tables()
    for case, row in zip(designs.cases, worst.rows, strict=True):
        model, correction, scenario, solar_wh, excess_h, *_ = row
        analysis = analyse(designs.aircraft, designs.mission, model=model, correction=correction)
        frame = analysis.to_frame().iloc[analysis.worst]
        assert scenario == analysis.performance.day.scenarios.label(analysis.worst)
        assert solar_wh == pytest.approx(frame["solar_energy_wh"])
        assert excess_h == pytest.approx(frame["excess_time_h"], abs=1e-6)
        assert case.prediction.scenario == scenario
    assert all(
        row[2] == c.prediction.mean_solar_energy_wh
        for row, c in zip(every.rows, designs.cases, strict=True)
    )


def test_models_that_deny_perpetual_flight_are_counted(designs):
    by_model = solar_models.perpetual_by_model(designs.aircraft, designs.mission)
    assert all(by_model[c.solar] == c.prediction.perpetual for c in designs.cases)
    assert solar_models.perpetual_line([True, False, False], designs.mission).startswith(
        "2 of 3 pairs"
    )
    assert solar_models.perpetual_line([True, True], designs.mission).startswith("All 2 pairs")


def test_result_prints_itself_and_gives_its_numbers(designs):
    shown, told = (" ".join(str(text).split()) for text in (designs, designs.headline()))
    assert shown.startswith(f"{DESIGN} on {SUMMER}: 3 models, reference: corrected FM ")
    assert told in shown
    assert repr(designs) == f"<Comparison: {designs.headline()}>"
    lines, every = (designs.at_level(n).to_text().splitlines() for n in (1, 2))
    assert max(map(len, every)) <= 80
    assert len(lines) <= 25 < len(every)
    frame = designs.to_frame()
    assert frame["model"].tolist() == ["CDM", "CAM", "FM"]
    assert frame["design_judged_excess_time_h"].tolist() == [
        case.built.judged.excess_time_h for case in designs.cases
    ]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"models": ["XM"]}, "unknown model 'XM'; allowed: CDM, CAM, VM, FM$"),
        ({"corrections": ["all"]}, "unknown correction 'all'; allowed: none, report, loiter$"),
        ({"objective": "fun"}, "unknown objective 'fun'; allowed: max_excess_time, "),
        ({"objective": "longest_season"}, "unknown objective 'longest_season'; allowed: "),
        ({"models": []}, "no model to compare"),
        *[
            (one | {"aircraft": load_aircraft("sky-sailor")}, r"needs modules\.geometry of the air")
            for one in ({"models": ["FM"]}, {"corrections": ["loiter"]}, {"models": [VM]})
        ],
    ],
)
def test_wrong_names_are_refused_at_the_call(options, said):
    with pytest.raises(ValueError, match=said):
        study.compare(options.pop("aircraft", AIRCRAFT), MISSION, **options)


def test_whole_comparison_as_json(run):
    record = run("compare", AS2, "--json").json()
    assert record["reference"] == {"model": "FM", "correction": "report"}
    cases = {(c["model"], c["correction"]): c for c in record["cases"]}
    assert len(cases) == 11
    assert cases["FM", "report"]["solar_energy_above_reference"] == 0.0
    # The loiter correction makes every model's daily energy that of the corrected Full Model.
    for model in ("CDM", "CAM", "VM"):
        assert abs(cases[model, "loiter"]["solar_energy_above_reference"]) <= 1e-9
    assert cases["CDM", "none"]["season"]["days"] > cases["FM", "report"]["season"]["days"]
    assert all(c["design"] is None for c in record["cases"])
    assert record["summary"].startswith(f"According to uncorrected CDM {AS2} flies perpetually, ")


def test_aircraft_without_surfaces_is_compared_without_them(run):
    record = run("compare", "sky-sailor", "--no-design", "--json").json()
    cases = [(c["model"], c["correction"]) for c in record["cases"]]
    assert cases == list(product(("CDM", "CAM"), ("none", "report")))
    assert record["reference"] == {"model": "CAM", "correction": "report"}
    assert "modules.geometry of sky-sailor" in record["notes"][0]


def test_no_design_at_all_ends_with_1(run):
    result = run(
        "compare",
        DESIGN,
        *("-m", SUMMER, "--models", "CDM", "--corrections", "none", "--json"),
        *("--set", "design_space.wingspan_m.maximum=2.5"),
    )
    assert result.code == 1
    record = result.json()
    assert record["cases"][0]["design"]["status"] == "infeasible"
    assert record["cases"][0]["design"]["violated_requirements"]


@pytest.mark.parametrize(
    ("objective", "name", "unit"),
    [("max_payload_mass", "payload_mass_kg", "kg"), ("max_payload_power", "payload_power_w", "W")],
)
def test_payload_is_compared_in_table_headline_and_figure(run, tmp_path, objective, name, unit):
    options = ["--models", "CAM", "--corrections", "none", "--objective", objective]
    options += ["-m", "rafz-july", "--required-excess-time", "1", "--out", "c", "-v"]
    outcome = run("compare", DESIGN, *options).good()
    record = json.loads((tmp_path / "c" / "results.json").read_text())
    built = record["cases"][0]["design"][name]
    assert built > 0.0
    assert f"[{unit}]" in outcome.out
    assert f"a payload of {built:.{1 if unit == 'W' else 2}f} {unit}" in record["summary"]

"""Reports: every section is there, the page needs nothing else, names are text, numbers agree."""

import dataclasses
import html
import importlib.util
import itertools
import json
import re
from collections import Counter
from contextlib import nullcontext
from functools import cache
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from builders import AS2, DESIGN, aircraft, mission, shipped_mission
from hypothesis import given
from hypothesis import strategies as st
from synthetic_logs import Settings, synthetic_log

from missions.mission import Mission
from missions.weather.files import load_weather
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.results.analysis import analyse
from sizing.results.sizing import size
from studies import make_report
from studies.output.run_folder import RunInputs
from studies.report.blocks import Bars
from studies.report.document import key_facts, verdict
from studies.report.pdf import to_pdf, with_plain_colours
from studies.report.sections import (
    aircraft_blocks,
    budget_blocks,
    loss_chain,
    margin_table,
    margins_blocks,
    sizing_blocks,
)
from studies.report.subject import Subject

pytestmark = pytest.mark.slow

VOID = {"meta", "link", "br", "img", "hr", "input"}


class Page(HTMLParser):
    """A page as a reader of it finds it; open and closed elements must match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self._open: list[str] = []
        self.feed(text)
        assert not self._open, self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open, tag
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open:
            self.texts.setdefault(self._open[-1], []).append(data)

    def of(self, tag: str) -> list[dict[str, str | None]]:
        """Attributes of the elements of a tag."""
        return [attributes for name, attributes in self.elements if name == tag]

    def headings(self) -> list[int]:
        return [int(name[1]) for name, _ in self.elements if re.fullmatch("h[1-6]", name)]

    def results(self) -> Any:
        return json.loads(self.texts["script"][0])


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """Season maps of a few cells, few draws: nobody looks at those of tests."""
    with pytest.MonkeyPatch.context() as context:
        context.setattr("studies.report.sections.CELLS", (5, 6))
        context.setattr("studies.report.subject.SAMPLES", 128)
        yield


@cache
def page_of_as2() -> str:
    return make_report(AS2, shipped_mission())


@pytest.fixture(scope="module")
def as2():
    return Page(page_of_as2())


def subject_of(craft: Aircraft, there: Mission) -> Subject:
    return Subject(craft, there, SolarModel(), RunInputs({}, {}, SolarModel(), {}))


def test_sections_stand_in_the_order_of_a_review(as2):
    keys = [section["id"] for section in as2.of("section")]
    assert keys == [
        "verdict", "aircraft", "budgets", "day", "season", "margins", "belief", "models",
        "glossary", "provenance", "inputs",
    ]  # fmt: skip
    links = [link["href"] for link in as2.of("a")]
    assert [f"#{key}" for key in keys] == links[1:]  # the first one skips the contents


def test_page_needs_no_other_file_and_no_network(as2):
    for _, attributes in as2.elements:
        for name in ("src", "href", "srcset", "data", "action", "xlink:href"):
            value = attributes.get(name) or "#"
            assert value.startswith(("#", "data:")), value
    style = as2.texts["style"][0]
    assert "@import" not in style
    assert "url(" not in style


def test_ids_are_unique_and_what_refers_to_them_finds_them(as2):
    ids = [a["id"] for _, a in as2.elements if "id" in a]
    assert [one for one, count in Counter(ids).items() if count > 1] == []
    referred = re.findall(r"url\(#([^)]+)\)", page_of_as2())
    for _, attributes in as2.elements:
        referred += (attributes.get("aria-labelledby") or "").split()
        if (attributes.get("href") or "").startswith("#"):
            referred.append(str(attributes["href"])[1:])
    assert set(referred) <= set(ids)


def test_screen_readers_are_told_of_drawings_and_tables(as2):
    drawings = as2.of("svg")
    assert len(drawings) == 4  # views, day, season, models
    for drawing in drawings:
        assert drawing["role"] == "img"
        assert len((drawing["aria-labelledby"] or "").split()) == 2
    assert all(head.get("scope") in ("row", "col") or head.get("aria-hidden")
               for head in as2.of("th"))  # fmt: skip
    assert as2.of("html") == [{"lang": "en"}]
    levels = as2.headings()
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(b - a <= 1 for a, b in itertools.pairwise(levels))


def test_results_are_those_of_the_analysis(as2):
    record = analyse(AS2, shipped_mission()).to_dict() | {"mission_is_default": False}
    assert as2.results()["analysis"] == json.loads(json.dumps(record))


def test_same_inputs_give_the_same_page():
    def undated(page: str) -> str:
        return re.sub(r"\d{4}-\d\d-\d\d(.\d\d:\d\d:\d\d)?", "", page)

    assert undated(make_report(AS2, shipped_mission())) == undated(page_of_as2())


def test_names_are_text():
    evil = "<script>alert('a')</script>&amp;\"$x$"
    bird = AS2.model_copy(update={"name": evil, "description": evil})
    there = mission(name=evil, description=evil)
    page = Page(make_report(bird, there))
    assert len(page.of("script")) == 1
    assert page.results()["analysis"]["aircraft"] == evil
    assert evil in page.texts["h1"]


def test_polar_night_is_reported():
    page = make_report(AS2, mission(latitude_deg=80.0, dates={"on": "12-21"}))
    assert "does not fly perpetually" in page
    assert "not enough alone" in page


def test_climbing_missions_are_reported_with_their_climbs():
    text = make_report(AS2, mission(climb={"ceiling_m": 800.0}))
    page = Page(text)
    keys = {section["id"] for section in page.of("section")}
    assert {"day", "season", "models", "margins"} <= keys
    assert "with climbs from 536 to 800 m." in text
    assert page.results()["comparison"]["climb"]["ceiling_m"] == 800.0


def test_models_are_left_out_in_words_where_the_wind_is_too_strong_for_the_path():
    path = {"kind": "circle", "radius_m": 100.0, "airspeed_m_per_s": 8.6}
    windy = shipped_mission("rafz-july", wind_m_per_s=9.0, flight_path=path)
    text = make_report(AS2, windy)
    page = Page(text)
    assert {"season", "models"} <= {section["id"] for section in page.of("section")}
    assert "are not compared: the wind of 9 m/s is not below the airspeed of 8.6 m/s" in text
    assert "comparison" not in page.results()


def test_uncertain_inputs_are_reported_where_a_file_has_them():
    assert DESIGN.uncertainty is not None
    page = Page(make_report(DESIGN, mission()))
    assert "uncertainty" in {section["id"] for section in page.of("section")}
    assert "uncertainty" in page.results()


def test_command_writes_the_page_of_the_folder_of_a_sizing(run, tmp_path):
    sized = run(
        *("size", "sky-sailor", "-m", "rafz-july", "--out", "sized"), *("--sensitivities", "--json")
    )
    assert sized.code == 0, sized.err
    told = run("report", "sized", "--out", "report.html")
    assert (told.code, told.out) == (0, "written to report.html\n"), told.err
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    results = page.results()
    assert results["sizing"] == sized.json()
    analysed = run("analyse", "sized", "--json")
    assert results["analysis"] == analysed.json()
    # Another mission is not what was sized.
    told = run("report", "sized", "-m", "rafz-28h", "--out", "r.html")
    assert told.code == 0
    assert 'id="sizing"' not in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_size_and_verify_write_reports(run, tmp_path, monkeypatch):
    sized = run("size", "sky-sailor", "-m", "rafz-july", "--report", "sized.html")
    assert sized.code == 0, sized.err
    assert "written to sized.html" in sized.out
    page = Page((tmp_path / "sized.html").read_text(encoding="utf-8"))
    assert page.results()["sizing"]["status"] == "optimal"
    assert page.results()["analysis"]["aircraft"] == "sky-sailor-sized"
    settings = Settings(rate_hz=0.01)
    log = synthetic_log(AS2, shipped_mission("rafz-28h"), settings)
    (tmp_path / "log.csv").write_text(log.to_csv(index=False))
    finished = []
    monkeypatch.setattr(
        "studies.cli.outputs.progress_of",
        lambda *_, **__: nullcontext(lambda *numbers: finished.append(numbers)),
    )
    told = run("verify", "atlantiksolar-as2", "log.csv", "--report", "log.html", "--json")
    assert finished == [(number, 6) for number in range(7)]
    assert told.code == 0, told.err
    page = Page((tmp_path / "log.html").read_text(encoding="utf-8"))
    del (record := told.json())["mission_is_default"]
    assert page.results()["verification"] == record
    keys = {section["id"] for section in page.of("section")}
    assert "verification" in keys
    assert "season" not in keys
    # The log is the Full Model's own, with noise.
    assert "FM comes closest" in (tmp_path / "log.html").read_text(encoding="utf-8")


def test_weather_is_a_section():
    colorado = mission(latitude_deg=40.53, longitude_deg=-108.54, altitude_m=2300.0)
    page = Page(make_report(AS2, colorado, weather=load_weather("colorado-2023")))
    assert "weather" in {section["id"] for section in page.of("section")}
    assert page.results()["weather"]["days"] == 365


def test_load_and_energy_add_up():
    subject = subject_of(DESIGN, mission(payload={"mass_kg": 0.5, "power_w": 4.0}))
    _, power, energy, *_ = budget_blocks(subject)
    assert isinstance(power, Bars)
    assert isinstance(energy, Bars)
    assert power.sum == pytest.approx(subject.record["power_out_w"])
    # Losses below half a watt hour are left out.
    steps = dict(energy.rows)
    assert steps["electric energy of the modules"] == pytest.approx(
        subject.record["solar_energy_wh"]
    )
    assert steps["load"] == pytest.approx(subject.record["load_energy_wh"])
    level = 0.0
    for label, amount in energy.rows:
        if label in energy.sums and level:
            assert level == pytest.approx(amount, abs=2.5)
        level = amount if label in energy.sums else level + amount
    light, converted, *_ = (amount for _, amount in energy.rows)
    efficiency = subject.aircraft.modules.efficiency_stc
    assert light + converted == pytest.approx(efficiency * light)


def test_losses_of_light_are_those_of_the_module_constants():
    """A loss is the factor of its own constant: the models multiply them."""
    subject = subject_of(AS2, shipped_mission())
    steps = loss_chain(subject.analysis)
    sums = [energy_wh for _, energy_wh in steps]
    losses = dict(steps)
    electric = losses["electric energy of the modules"]
    before = electric - losses["MPPT"]
    assert electric / before == pytest.approx(subject.aircraft.modules.mppt_efficiency)
    assert sums[0] == max(sums)


def test_project_and_author_stand_on_the_head():
    page = make_report(AS2, shipped_mission(), project="Dawn <1>", author="A. Name")
    assert "<dt>Project</dt><dd>Dawn &lt;1&gt;</dd>" in page
    assert "<dt>Author</dt><dd>A. Name</dd>" in page
    assert "<dt>Project</dt>" not in page_of_as2()


def test_an_aircraft_known_by_its_power_alone_has_no_airspeed():
    blocks = str([*aircraft_blocks(subject_of(aircraft("sky-sailor-2008"), mission()))])
    assert "battery energy" in blocks
    assert "airspeed" not in blocks
    assert "Reynolds" not in blocks


@pytest.mark.parametrize("avionics_w", [6.0, 25.0])
def test_margins_are_where_the_requirement_ends(avionics_w):
    craft = aircraft("atlantiksolar-as2", f"power.avionics_w={avionics_w}")
    there = mission(required_excess_time_h=1.0)
    table = margin_table(subject_of(craft, there))
    rows = {row[0]: row for row in table.rows}
    limit_w = rows["avionics power"][3]
    for factor, holds in ((0.999, True), (1.001, False)):
        other = aircraft("atlantiksolar-as2", f"power.avionics_w={factor * limit_w}")
        assert (analyse(other, there).excess_time_h >= 1.0) is holds
    limit = rows["specific energy of the battery"][3]
    for factor, holds in ((0.999, False), (1.001, True)):
        key = f"battery.specific_energy_wh_per_kg={factor * limit}"
        other = aircraft("atlantiksolar-as2", f"power.avionics_w={avionics_w}", key)
        assert (analyse(other, there).excess_time_h >= 1.0) is holds


def test_a_sizing_ends_with_the_same_by_each_class_of_building():
    study = size(aircraft("atlantiksolar-design"), mission(), with_builds=True)
    subject = subject_of(study.aircraft, study.mission)
    *_, table = sizing_blocks(dataclasses.replace(subject, sizing=study.to_dict()))
    assert [row[0] for row in table.rows] == ["record (this file)", "careful", "ordinary"]


def test_a_design_on_the_edge_has_no_margins():
    study = size(aircraft("atlantiksolar-design"), mission())
    on_edge = subject_of(study.sized_aircraft(), study.sized_mission())
    assert margin_table(on_edge) is None
    assert "has just what is required" in str([*margins_blocks(on_edge)])


def test_the_verdicts_page_has_the_probability():
    subject = subject_of(aircraft("atlantiksolar-design"), mission(required_excess_time_h=6.0))
    (fact,) = (one for one in key_facts(subject) if one.label == "probability")
    share = 100.0 * np.mean(np.asarray(subject.uncertainty.flights.excess_time_h) >= 6.0)
    assert float(fact.value.removesuffix(" %")) == pytest.approx(share, abs=0.05)


@pytest.mark.parametrize(
    ("changes", "state", "told"),
    [
        ({}, "good", "flies perpetually: at 47.6° N, 15 Jul, 6."),
        ({"required_excess_time_h": 5.0}, "good", "more than required"),
        ({"required_excess_time_h": 9.0}, "bad", "less than the required 9 h"),
        ({"dates": {"on": "12-21"}}, "bad", "does not fly perpetually"),
        ({"latitude_deg": 80.0, "dates": {"on": "06-21"}}, "good", "flies perpetually"),
    ],
)
def test_verdict_says_what_the_analysis_found(changes, state, told):
    found = verdict(subject_of(AS2, mission(**changes)))
    assert found.state == state
    assert told in found.sentence


def test_verdict_on_the_edge_of_the_model_error():
    bird = aircraft("atlantiksolar-as2", "modules.area_m2=0.6")
    found = verdict(subject_of(bird, mission()))
    assert found.state == "edge"


@pytest.mark.skipif(importlib.util.find_spec("weasyprint") is None, reason="needs WeasyPrint")
@pytest.mark.extra
def test_page_is_printed():
    printed = to_pdf(page_of_as2())
    assert printed.startswith(b"%PDF-")


@given(
    st.lists(
        st.sampled_from(["@media screen", "--ink: red;", "var(--ink)", ' style="', "<style>", ">"])
        | st.text(max_size=5)
    ).map("".join)
)
def test_names_do_not_change_the_colours_of_print_nor_they_the_names(name: str) -> None:
    drawn = '<svg class="figure"><path style="fill: {}"/></svg>'
    head = f"<title>{html.escape(name)}</title>"
    printed = with_plain_colours(head + drawn.format("var(--ink)"))
    assert printed.startswith(head)
    assert printed.endswith('<path style="fill: #1c1e21"/></svg>')
    assert "var(" not in printed.removeprefix(head)


def test_without_weasyprint_a_pdf_is_refused(run, monkeypatch):
    monkeypatch.setattr("studies.report.pdf.has_weasyprint", lambda: False)
    outcome = run("report", "atlantiksolar-as2", "--out", "report.html", "--pdf")
    assert outcome.code == 2
    assert "pip install weasyprint (the extra 'report')" in outcome.err

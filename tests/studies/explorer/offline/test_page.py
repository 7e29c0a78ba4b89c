"""The offline page in a browser, from ``file://``: its numbers are those of the analysis."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from browser_pages import PHONE, accessibility_problems, too_wide
from explorer_pages import DAY, LATITUDE, at_rest, go_to, number, shown, slider

from sizing.results.analysis import Analysis
from studies.explorer.offline.page import offline_page
from studies.explorer.session import Session

pytestmark = [pytest.mark.browser, pytest.mark.slow]

MEGABYTE = 1e6


def session_of(name: str) -> Session:
    from studies.cli.files import load
    from studies.cli.options import CaseOptions

    case = load(CaseOptions(name, "rafz-july"))
    return Session(case.aircraft_file.document, case.mission_file.document, case.solar)


@pytest.fixture(scope="module")
def session() -> Session:
    return session_of("atlantiksolar-design")


@pytest.fixture(scope="module")
def offline(session: Session, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("offline") / "page.html"
    path.write_text(offline_page(session), encoding="utf-8")
    return path


def test_one_file_of_moderate_size(offline: Path) -> None:
    assert offline.stat().st_size < 2 * MEGABYTE


def test_start_is_that_of_the_analysis(open_page: Any, offline: Path, session: Session) -> None:
    page = at_rest(open_page(offline, waiting=True))
    numbers = session.day(session.settings())["numbers"]
    assert page.locator("#verdict-title").inner_text() == "Perpetual flight"
    # Light between two latitudes and two dates of the table; see the next test.
    assert number(page, "excess time") == pytest.approx(numbers["excess_time_h"], abs=0.02)
    assert shown(page, "total mass") == f"{numbers['total_mass_kg']:.2f} kg"
    assert shown(page, "battery") == f"{numbers['battery_energy_wh']:.0f} Wh"
    budget = page.locator("#masses li b").all_inner_texts()
    masses = session.day(session.settings())["masses_kg"]
    # Half a hundredth of a kilogram of rounding, and as much between the nodes of the table.
    assert [float(text.split()[0]) for text in budget] == pytest.approx(
        list(masses.values()), abs=0.01
    )
    assert too_wide(page) == []
    assert accessibility_problems(page) == []


# Between the nodes of all tables; summer, autumn, the southern hemisphere, a day without a night.
POINTS = [
    {LATITUDE: 33.3, DAY: 285, "airframe.wingspan_m": 7.7, "battery.mass_kg": 4.1},
    {LATITUDE: 58.7, DAY: 178, "modules.area_m2": 1.12, "battery.mass_kg": 1.7},
    {LATITUDE: -21.9, DAY: 61, "mission.payload.mass_kg": 0.33, "mission.payload.power_w": 7.1},
    {LATITUDE: 47.3, DAY: 331, "battery.specific_energy_wh_per_kg": 333, "battery.mass_kg": 3.3},
    {LATITUDE: 81.3, DAY: 165, "airframe.wingspan_m": 4.4, "modules.area_m2": 0.8},
    {LATITUDE: -66.1, DAY: 20, "airframe.wingspan_m": 6.3},
]


def test_numbers_between_the_nodes(open_page: Any, offline: Path, session: Session) -> None:
    page = at_rest(open_page(offline, waiting=True))
    for point in POINTS:
        go_to(page, **point)
        found: Analysis = session.analysis(session.settings(point))
        cycle, hours = found.performance.cycle, partial(number, page)
        if found.to_dict()["status"] == "always_lit":
            assert shown(page, "excess time") == "unlimited"
        else:
            # The error that the page itself states for nine points of ten is 0.04 h.
            assert hours("excess time") == pytest.approx(found.excess_time_h, abs=0.06), point
        charge = number(page, "min. charge") / 100
        assert charge == pytest.approx(cycle.minimum_state_of_charge[0], abs=0.01), point
        assert hours("charge margin") == pytest.approx(cycle.charge_margin_h[0], abs=0.1), point
        endurance = found.endurances[0]
        if endurance is not None:
            # Launches five minutes apart.
            assert number(page, "endurance") == pytest.approx(
                float(endurance.endurance_h), abs=0.2
            ), point


@pytest.mark.parametrize("name", ["atlantiksolar-design", "atlantiksolar-as2"])
def test_the_page_states_its_own_error(
    open_page: Any, offline: Path, tmp_path: Path, name: str
) -> None:
    path = offline
    if name != "atlantiksolar-design":
        path = tmp_path / "page.html"
        path.write_text(offline_page(session_of(name)), encoding="utf-8")
    page = open_page(path, waiting=True)
    page.wait_for_function("document.documentElement.dataset.errors")
    found = json.loads(page.evaluate("document.documentElement.dataset.errors"))
    assert found["points"] == 120
    assert found["excess_time_90_h"] < 0.05
    assert found["other_status"] <= 2
    text = page.locator("#offline-errors").inner_text()
    assert f"within {found['excess_time_90_h']:.2f} h of the analysis at nine of ten" in text


def test_settings_that_no_aircraft_has(open_page: Any, offline: Path) -> None:
    page = at_rest(open_page(offline, waiting=True))
    go_to(page, **{"airframe.wingspan_m": 2.0})
    assert page.locator("#verdict-title").inner_text() == "Not possible"
    assert "must not exceed the wing area of 0.216 m²" in page.locator("#verdict-text").inner_text()
    go_to(page, **{"airframe.wingspan_m": 5.5})
    assert page.locator("#verdict-title").inner_text() != "Not possible"


def test_slider_by_keyboard_changes_numbers_and_address(open_page: Any, offline: Path) -> None:
    page = at_rest(open_page(offline, waiting=True))
    before = number(page, "total mass")
    mass = slider(page, "battery.mass_kg")
    mass.focus()
    for _ in range(5):
        mass.press("PageUp")
    at_rest(page)
    assert number(page, "total mass") > before
    page.wait_for_function("location.hash.includes('battery.mass_kg')")
    page.reload()
    at_rest(page)
    assert number(page, "total mass") > before


@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone(open_page: Any, offline: Path, dark: bool) -> None:
    page = at_rest(open_page(offline, size=PHONE, dark=dark, waiting=True))
    assert too_wide(page) == []
    assert accessibility_problems(page) == []

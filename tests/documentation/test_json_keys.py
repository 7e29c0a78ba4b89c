"""Tables of JSON keys in the documentation name what the commands print, and all of it."""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

DOCS = Path(__file__).resolve().parents[2] / "docs"
AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"
SUMMER = ("--mission", "central-europe-summer")
STRINGS = (
    "{cells_in_series: 22, coldest_c: -20, hottest_c: 70, "
    "mppt: {minimum_voltage_v: 5, maximum_voltage_v: 40, maximum_current_a: 7}}"
)
CELLS = (
    *("--set", "modules.cell=sunpower-c60"),
    *("--set", "modules.layout={cell_span_m: 0.125, cell_chord_m: 0.125}"),
    *("--set", "modules.layout.bays=[{cells: [22, 22]}]"),
    *("--set", f"modules.layout.strings={STRINGS}"),
    *("--set", "battery.pack={cells_in_series: 6, cell_mass_kg: 0.0486}"),
)
CLIMB = ("--set", "mission.climb={ceiling_m: 1500}")
HIGH = ("--set", "mission.altitude_m=12000", "--set", "mission.wind={percentile: 95}")
WINDY = (
    *("--set", "mission.altitude_m=20000", "--set", "mission.wind={percentile: 95}"),
    *("--set", "mission.flight_path.airspeed_m_per_s=25"),
    *("--set", "mission.flight_path.radius_m=600", "--model", "VM"),
)

OPTIONS = {"SUMMER": SUMMER, "CELLS": CELLS, "CLIMB": CLIMB, "HIGH": HIGH, "WINDY": WINDY}

# Calls that together show every key of a command, and keys that only other calls show. Words in
# capitals are the options above.
CASES = {
    "analyse": (
        "cli.md",
        [
            f"{AS2} --mission rafz-28h",
            f"{AS2} CLIMB",
            f"{AS2} --set battery.ageing.cycles=180 --set modules.cell=sunpower-c60",
            f"{AS2} CELLS",
        ],
        # Of aircraft with a rib wing, whose keys of "structure" stand with those of "size"; of held
        # winds, whose keys stand on their page; of tables that other programs wrote; of parts that
        # cannot do the load.
        {
            *("balance", "drag_coefficients", "part_masses", "held_up_to_m"),
            *("reading_notes", "beyond_parts"),
        },
    ),
    "size": (
        "cli.md",
        [
            f"{DESIGN} SUMMER --sensitivities --cross-check",
            "sky-sailor SUMMER --required-excess-time 12",
            "twin-boom-design --mission rafz-july",
            f"{DESIGN} SUMMER --set mission.uncertainty_margins.battery_capacity=0.9 "
            "--set battery.ageing.cycles=180 --set modules.cell=sunpower-c60",
            f"{DESIGN} --mission rafz-july --reliability 0.4",
            f"{DESIGN} --mission rafz-july CLIMB",
            f"{DESIGN} --mission rafz-july --whole-cells CELLS",
        ],
        {"range", "weather", "part_masses", "reading_notes"},
    ),
    "size --weather": (
        "season.md",
        [
            f"{DESIGN} SUMMER --set mission.latitude_deg=40.5 --set mission.altitude_m=2300 "
            "--set mission.dates.to=05-03 --weather colorado-2023 --survive 1"
        ],
        set(),
    ),
    "ceiling": ("cli.md", [f"{AS2} --step 4000", f"{AS2} CLIMB --step 4000 --highest 5000"], set()),
    "sweep": (
        "cli.md",
        [
            f"{DESIGN} --vary wingspan_m=4,5",
            f"{DESIGN} --vary wingspan_m=4,5 --pareto wingspan_m excess_time",
        ],
        set(),
    ),
    "map": (
        "cli.md",
        [
            f"{AS2} --latitudes 40:50:10 --days 100:200:100 --endurance",
            f"{DESIGN} --latitudes 40:50:10 --days 100:200:100 --resize min_mass",
            f"{AS2} WINDY --latitudes 20:60:40 --days 1:181:180",
        ],
        set(),
    ),
    "station": (
        "winds.md",
        [
            f"{DESIGN} HIGH --latitudes 40:50:10",
            f"{DESIGN} HIGH --altitudes 10000:12000:2000",
            f"{DESIGN} HIGH --latitudes 40:50:10 --altitudes 10000:12000:2000",
        ],
        set(),
    ),
    "uncertainty": (
        "uncertainty.md",
        [f"{DESIGN} {flown} --samples 64" for flown in ("SUMMER", "CLIMB")],
        set(),
    ),
    "analyse --weather": ("weather.md", [f"{AS2} --weather colorado-2023"], set()),
    "compare": (
        "compare.md",
        [
            f"{DESIGN} --models CDM,CAM --corrections none {more}"
            for more in ("--required-excess-time 3", "CLIMB")
        ],
        set(),
    ),
}
COMMON = {"aircraft", "mission", "mission_is_default"}
# Whose keys are quantities, items or places, described as a whole.
OPEN = {
    *("sobol", "spar_caps", "spar_web", "balance", "drag_coefficients", "others", "masses_kg"),
    *("power_budget", "quantities", "points", "status", "latitudes", "extrapolations"),
}


def keys(record, inside=""):
    """Names of all keys, at any depth."""
    if isinstance(record, list):
        for entry in record:
            yield from keys(entry, inside)
    elif isinstance(record, dict) and inside not in OPEN:
        for key, value in record.items():
            yield key
            yield from keys(value, key)


def section(page, command):
    """Part of a page on a command: under its heading, or all of a page of its own."""
    text = (DOCS / page).read_text(encoding="utf-8")
    if page != "cli.md":
        return text
    found = re.search(rf"^## `{command}`$.*?(?=^## |\Z)", text, re.M | re.S)
    return found[0]


def names(text):
    """Keys in code."""
    return {span.rstrip("[]") for span in re.findall(r"`(\w+(?:\[\])?)`", text)}


def first_columns(text):
    """First cells of the tables of keys."""
    tables = re.findall(r"^\| key.*\n\|[-:|\s]+\n((?:\|.*\n)+)", text, re.M)
    return "\n".join(row.split("|")[1] for table in tables for row in table.splitlines())


def test_keys_of_what_lies_outside_a_range_are_those_of_its_page(run):
    record = run("analyse", AS2, "--set", "mission.wind_m_per_s=50", "--json").json()
    (one,) = record["extrapolations"]
    page = (DOCS / "validity.md").read_text(encoding="utf-8")
    assert set(one) == names(first_columns(page))


@pytest.mark.parametrize("command", CASES)
def test_keys_of_the_json_are_those_of_the_page(command, run):
    page, calls, elsewhere = CASES[command]
    printed = set()
    verb, _, option = command.partition(" --")
    for call in calls:
        words = (word for one in call.split() for word in OPTIONS.get(one, (one,)))
        record = run(verb, *words, "--json").json()
        # An option that adds a record has a page of its own for it.
        printed |= set(keys(record[option] if option else record)) - COMMON
    text = section(page, command)
    assert printed <= names(text), f"not documented: {sorted(printed - names(text))}"
    documented = names(first_columns(text))
    unknown = documented - printed - elsewhere
    assert not unknown, f"documented, but not printed: {sorted(unknown)}"
